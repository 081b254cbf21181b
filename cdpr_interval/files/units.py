"""Units in keys: what a key of another unit is called in this one, and by how much its numbers change."""

from __future__ import annotations

import difflib
from collections.abc import Collection
from fractions import Fraction

MILLI, KILO = Fraction(1, 1000), Fraction(1000)
UNITS: dict[str, dict[str, Fraction]] = {
    "N_per_m": {
        "N_per_mm": KILO, "N_per_cm": Fraction(100), "kN_per_m": KILO, "kN_per_mm": KILO * KILO,
        "N_m": Fraction(1), "N_mm": KILO, "kN_m": KILO,
    },
    "m_s2": {"mm_s2": MILLI, "cm_s2": Fraction(1, 100)},
    "m_s": {"mm_s": MILLI, "cm_s": Fraction(1, 100)},
    "kg": {"g": MILLI, "t": KILO, "lb": Fraction("0.45359237"), "lbs": Fraction("0.45359237")},
    "N": {
        "kN": KILO, "daN": Fraction(10), "MN": KILO * KILO, "kgf": Fraction("9.80665"),
        "lbf": Fraction("4.4482216152605"),
    },
    "m": {
        "mm": MILLI, "cm": Fraction(1, 100), "dm": Fraction(1, 10), "um": MILLI * MILLI, "km": KILO,
        "in": Fraction("0.0254"), "inch": Fraction("0.0254"), "ft": Fraction("0.3048"),
    },
    "s": {"ms": MILLI, "us": MILLI * MILLI, "min": Fraction(60)},
}  # fmt: skip
"""Each unit of our keys, the longer ones first, with what others write: 1 of theirs is so many of ours."""
TURNS = {"deg": ("rad", "multiply by pi/180"), "rad": ("deg", "multiply by 180/pi")}
"""Angles: no decimal leads from one to the other."""


def renamed(key: str, known: Collection[str]) -> str | None:
    """Return what to do with a key that carries another unit than ours; None when it carries none.

    Parameters
    ----------
    key : str
        As it was typed: ``frame_anchor_mm``.
    known : collection of str
        Keys that are allowed in its place: ``frame_anchor_m``.

    Returns
    -------
    str or None
        ``write 'frame_anchor_m', and divide by 1000``.
    """
    for ours, others in UNITS.items():
        for theirs, factor in others.items():
            if (found := _with_unit(key, theirs, ours, known)) is not None:
                return f"write '{found}'" + (f", and {scaling(factor)}" if factor != 1 else "")
    for theirs, (ours, rule) in TURNS.items():
        if (found := _with_unit(key, theirs, ours, known)) is not None:
            return f"write '{found}', and {rule}"
    return None


def _with_unit(key: str, theirs: str, ours: str, known: Collection[str]) -> str | None:
    """Return the known key of our unit that a key of another unit means, mistyped or not."""
    word = key.lower() if theirs.islower() else key
    stem = word.removesuffix(f"_{theirs}")
    if stem == word or key in known or f"{word}_{ours}" in known:
        # ``lead_in`` lacks its unit.
        return None
    stems = {name.removesuffix(f"_{ours}"): name for name in known if name.endswith(f"_{ours}")}
    if near := difflib.get_close_matches(stem, stems, 1):
        return stems[near[0]]
    # What `suggestion` would offer without a word on the unit.
    return next(iter(difflib.get_close_matches(key, stems.values(), 1)), None)


def scaling(factor: Fraction) -> str:
    """Return how numbers are changed by a factor, in words."""
    if factor.numerator == 1:
        return f"divide by {factor.denominator}"
    return f"multiply by {factor.numerator if factor.denominator == 1 else float(factor)}"


def unit_of(key: str) -> str | None:
    """Return the unit that a key of ours ends in: ``m`` of ``frame_anchor_m``."""
    return next((unit for unit in UNITS if key.endswith(f"_{unit}")), None)
