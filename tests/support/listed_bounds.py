"""The bounds of listed solutions, changed: moved, wider, around two, without width."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

from tests.support.honest_certificates import Document

BOUNDS = ("position_m", "rotation", "height_m", "tensions_N", "distances_m")


def hexed(lo: float, hi: float) -> list[str]:
    """Return bounds as they are written."""
    return [float(lo).hex(), float(hi).hex()]


def every_bound(value: Any, change: Callable[[float, float], tuple[float, float]], text: bool = True) -> Any:
    """Return nested lists of bounds, each changed."""
    if isinstance(value[0], str):
        found = change(*map(float.fromhex, value))
        return hexed(*found) if text else list(found)
    return [every_bound(v, change, text) for v in value]


def at_middle(bounds: list[str]) -> list[str]:
    """Return bounds without width."""
    lo, hi = map(float.fromhex, bounds)
    return hexed((lo + hi) / 2, (lo + hi) / 2)


def zero(bounds: list[str]) -> bool:
    """Return True for the bounds of an entry that is fixed."""
    return bounds == hexed(0, 0)


def apart(a: list[str], b: list[str]) -> bool:
    """Return True for bounds that have nothing in common."""
    (p, q), (r, s) = (map(float.fromhex, v) for v in (a, b))
    return q < r or s < p


def differ(a: list[list[str]], b: list[list[str]]) -> bool:
    """Return True for boxes that have nothing in common."""
    return any(apart(x, y) for x, y in zip(a, b, strict=True))


def all_moved(solution: Document, by: float) -> Document:
    """Return a solution beside another one."""
    found = copy.deepcopy(solution)
    for key in ("position_m", "height_m"):
        found[key] = every_bound(solution[key], lambda lo, hi: (lo + by, hi + by))
    return found


def widen_all(solution: Document, by: float | None = None) -> None:
    """Make a solution's bounds wider, None: as wide as can be."""
    for key in BOUNDS:
        most = 2.0 if key == "rotation" else 1e4
        if by is None:
            solution[key] = every_bound(solution[key], lambda lo, hi, m=most: (-m, m))
        else:
            solution[key] = every_bound(solution[key], lambda lo, hi, w=by: (lo - w, hi + w))
    solution["stability"] = "undecided"


def with_hull(document: Document, j: int, k: int) -> Document:
    """Return a document in which the bounds of solution j hold those of solution k too."""
    found = copy.deepcopy(document)
    one, other = found["solutions"][j], found["solutions"][k]
    for key in BOUNDS:
        one[key] = hull(one[key], other[key])
    return found


def hull(a: Any, b: Any) -> Any:
    """Return nested bounds around two."""
    if isinstance(a[0], str):
        (p, q), (r, s) = (map(float.fromhex, v) for v in (a, b))
        return hexed(min(p, r), max(q, s))
    return [hull(x, y) for x, y in zip(a, b, strict=True)]


def undecided(document: Document, k: int) -> Document:
    """Return a document that says as little as can be of a solution's cables."""
    found = copy.deepcopy(document)
    found["solutions"][k] |= {
        "states": ["undecided"] * len(found["solutions"][k]["states"]),
        "taut": [],
        "slack_respected": None,
        "stability": "undecided",
    }
    return found
