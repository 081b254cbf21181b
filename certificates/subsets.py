"""The subsets of taut cables to be examined, and how the poses of each are searched."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from enum import Enum
from itertools import combinations
from typing import TYPE_CHECKING

from flint import fmpq

from certificates.arithmetic.vectors import cross, minus

if TYPE_CHECKING:
    from certificates.problem import Problem

Exact = list[fmpq]


class Kind(Enum):
    """What is known of a subset's poses from where its cables end."""

    GENERAL = "general"
    PLANE = "plane"
    """Two cables: they, their platform points and the centre of mass lie in one plane with the load."""
    VERTICAL = "vertical"
    """The exit points lie on one line along the load: the pose turns about it."""
    ROD = "rod"
    """The platform points and the centre of mass lie on one line: the platform turns about it."""
    BOTH = "both"
    FREE = "free"
    """All platform points are the centre of mass."""
    ONE_POINT = "one point"
    """All platform points are one other point."""
    DEPENDENT = "dependent"
    """The wrenches are linearly dependent in every pose: by Caratheodory smaller subsets hold all poses."""


def examined(problem: Problem) -> Iterator[tuple[int, ...]]:
    """Yield the subsets a certificate must have, in order."""
    if problem.taut is not None:
        return iter([problem.taut])
    cables = range(len(problem.names))
    most = 6
    if problem.is_point_mass:
        if not problem.ignore_slack:
            return iter([tuple(cables)])
        most = len(cables) if problem.is_elastic else 3
    return (taut for n in range(1, min(most, len(cables)) + 1) for taut in combinations(cables, n))


def classify(problem: Problem, taut: tuple[int, ...]) -> Kind:
    """Return the kind of a subset of a platform's cables."""
    if problem.is_routed:
        return Kind.GENERAL
    exits, points = [problem.exits[i] for i in taut], [problem.points[i] for i in taut]
    if is_dependent(exits, points):
        return Kind.DEPENDENT
    if all(b == points[0] for b in points):
        return Kind.ONE_POINT if any(points[0]) else Kind.FREE
    vertical = not any(any(cross(minus(a, exits[0]), problem.load)) for a in exits)
    rod = not any(any(cross(b, c)) for b, c in combinations(points, 2))
    # One symmetry: the moment about its line is 0 for all wrenches, their rank is 5 at most. Both, with
    # t >= 0: balance puts the two lines into one plane, as the mean of the platform points with weights t
    # lies on both (seen from the line along the load, sum t_i p_i has no horizontal part). Forces in a
    # plane have rank 3.
    if len(taut) > (3 if vertical and rod else 5 if vertical or rod else 6):
        return Kind.DEPENDENT
    if vertical or rod:
        return Kind.BOTH if vertical and rod else Kind.VERTICAL if vertical else Kind.ROD
    return Kind.PLANE if len(taut) == 2 else Kind.GENERAL


def is_dependent(exits: list[Exact], points: list[Exact]) -> bool:
    """Return True where two cables coincide, or more than three pull at one point or from one point."""
    ends = [[tuple(v) for v in exits], [tuple(v) for v in points]]
    most = max(max(Counter(vectors).values()) for vectors in ends)
    return most > 3 or len(set(zip(*ends, strict=True))) < len(exits)
