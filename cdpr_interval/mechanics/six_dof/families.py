"""Taut subsets whose poses come in families, recognised exactly on the input's rationals.

(a) all taut exit arms on one line parallel to the load: the whole pose turns about that line;
(b) all taut platform points and the centre of mass on one line: the platform turns about it;
(c) all taut platform points at the centre of mass: the platform turns freely;
(d) all taut platform points in one other point: the platform hangs under it or balances over it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from itertools import combinations

from cdpr_interval.exact.vector import Vector, cross, is_zero, minus
from cdpr_interval.mechanics.loaded import LoadedRobot


class Kind(Enum):
    """How the poses of a taut subset are searched."""

    GENERAL = "general"
    PLANE = "plane"
    """Two cables: everything taut lies in the plane of the exit arms and the load."""
    ABOUT_VERTICAL = "a"
    ABOUT_ROD = "b"
    FREE_TURNING = "c"
    ONE_POINT = "d"
    DEPENDENT = "dependent"
    """The wrenches are linearly dependent in every pose: smaller subsets hold all its poses."""
    UNCERTAIN = "uncertain"
    """Of data with ranges: one of the families for some choices, and maybe none for others."""


@dataclass(frozen=True)
class Classification:
    """The kind of a subset, and which of the symmetries (a) and (b) it has."""

    kind: Kind
    vertical: bool = False
    rod: bool = False


def classify(loaded: LoadedRobot, taut: tuple[int, ...]) -> Classification:
    """Recognise the family of a taut subset from the exact input."""
    exits = [loaded.exits[i] for i in taut]
    arms = [loaded.arms[i] for i in taut]
    n = len(taut)
    if is_dependent(exits, arms):
        return Classification(Kind.DEPENDENT)
    if all(b == arms[0] for b in arms):
        return Classification(Kind.FREE_TURNING if is_zero(arms[0]) else Kind.ONE_POINT)
    vertical = all(is_zero(cross(minus(a, exits[0]), loaded.load)) for a in exits)
    rod = all(is_zero(cross(b, c)) for b, c in combinations(arms, 2))
    if (vertical and rod and n > 3) or ((vertical or rod) and n > 5):
        return Classification(Kind.DEPENDENT)
    if n == 2 or (vertical and rod):
        return Classification(Kind.PLANE, vertical, rod)
    if vertical:
        return Classification(Kind.ABOUT_VERTICAL, vertical=True)
    if rod:
        return Classification(Kind.ABOUT_ROD, rod=True)
    return Classification(Kind.GENERAL)


def is_dependent(exits: list[Vector], arms: list[Vector]) -> bool:
    """Return True where two cables coincide or more than three pull through one point."""
    if len(set(zip(exits, arms, strict=True))) < len(exits):
        return True
    return max(most_common(exits), most_common(arms)) > 3


def most_common(vectors: Iterable[Vector]) -> int:
    """Return how often the most frequent vector occurs."""
    return max(Counter(vectors).values())
