"""Decimal text of an enclosure that shows only what is proved."""

from __future__ import annotations

import math
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal

_EXACT = Context(prec=800)
"""Holds every digit of a double, so that quantizing rounds once."""


def proved_decimal(lo: float, hi: float, most: int) -> str:
    """Return a number both bounds round to, with as many decimals as possible.

    Parameters
    ----------
    lo, hi : float
        The enclosure.
    most : int
        Largest number of decimals.

    Returns
    -------
    str
        Every number of the enclosure rounds to this one at its last decimal. Where not even the
        whole number is common, the range ``lo..hi``, rounded outwards.
    """
    if math.isfinite(lo) and math.isfinite(hi):
        for decimals in range(most, -1, -1):
            unit = Decimal(1).scaleb(-decimals)
            low, high = (Decimal(bound).quantize(unit, context=_EXACT) for bound in (lo, hi))
            if low == high:
                # A zero loses its sign: it may come from a tiny negative bound.
                return f"{abs(low) if low == 0 else low:f}"
    return f"{_outward(lo, ROUND_FLOOR)}..{_outward(hi, ROUND_CEILING)}"


def proved_significant(lo: float, hi: float, digits: int) -> str:
    """Return `proved_decimal` with at most so many significant digits."""
    size = max(abs(lo), abs(hi))
    if not (math.isfinite(size) and size > 0.0):
        return proved_decimal(lo, hi, 0)
    return proved_decimal(lo, hi, max(0, digits - 1 - math.floor(math.log10(size))))


def _outward(bound: float, rounding: str) -> str:
    if not math.isfinite(bound):
        return str(bound)
    rounded = Context(prec=4, rounding=rounding).create_decimal(Decimal(bound)).normalize()
    return f"{rounded:f}" if 1e-6 <= abs(bound) < 1e7 else f"{rounded:g}"
