"""What a platform under a load needs in every run, whatever the lengths: computed once and kept."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.exact.range import Range, RangeVector
from cdpr_interval.mechanics.loaded import MOST_KEPT, LoadedRobot
from cdpr_interval.mechanics.six_dof.arrays import split
from cdpr_interval.mechanics.six_dof.families import Classification, Kind, classify
from cdpr_interval.mechanics.six_dof.fields import Cables
from cdpr_interval.mechanics.six_dof.frame import upward
from solvers.questions.problem import Problem

Floats = NDArray[np.float64]

SUBSETS = 4096
"""Most taut subsets whose kind is kept."""


@lru_cache(maxsize=MOST_KEPT)
def cables_of(loaded: LoadedRobot) -> Cables:
    """Return the arrays of the compiled reports, of ranges for all choices; the load but for its factor."""
    with balls.precision():
        g = balls.ranges(loaded.gravity_ranges)
        up = balls.bounds_array(g * (-1 / balls.norm(g)))
    return Cables(
        exits=np.array([column(a) for a in loaded.exit_ranges]),
        arms=np.array([column(b) for b in loaded.arm_ranges]),
        centre=column(loaded.centre_ranges),
        up=up.reshape(1, 3, 2),
        load=column(loaded.load_direction_ranges),
    )


def column(v: RangeVector) -> Floats:
    """Return the bounds (3, 1, 2) of a vector."""
    return np.array([(enclose(x.lo)[0], enclose(x.hi)[1]) for x in v]).reshape(3, 1, 2)


@lru_cache(maxsize=SUBSETS)
def kind_of(loaded: LoadedRobot, taut: tuple[int, ...]) -> Classification:
    """Return the kind of a taut subset: ``UNCERTAIN`` where it is not proved to be one for all choices."""
    kind = classify(loaded.middle, taut)
    if loaded.is_exact or kind.kind is Kind.GENERAL or is_known(loaded, taut):
        return kind
    with balls.precision():
        return kind if is_plain(loaded, taut, kind) else Classification(Kind.UNCERTAIN)


def is_known(loaded: LoadedRobot, taut: tuple[int, ...]) -> bool:
    """Return whether all data that decide about the kind of a subset are exact."""
    points = (*(loaded.exit_ranges[i] for i in taut), *(loaded.arm_ranges[i] for i in taut))
    return all(x.lo == x.hi for v in (*points, loaded.load_direction_ranges) for x in v)


def is_plain(loaded: LoadedRobot, taut: tuple[int, ...], kind: Classification) -> bool:
    """Return True when a subset with ranges has the kind of its middle for all choices."""
    arms = [balls.ranges(loaded.arm_ranges[i]) for i in taut]
    if kind.kind is Kind.PLANE and not (kind.vertical or kind.rod):
        up = upward(loaded.load_direction_ranges)
        first, second = (balls.ranges(loaded.exit_ranges[i]) for i in taut)
        step = balls.norm(balls.cross(up, second - first))
        return bool(step > 0 and balls.norm(balls.cross(*arms)) > 0)
    anchors = {loaded.anchor_ranges[i] for i in taut}
    together = len(taut) == 1 or (len(anchors) == 1 and all(x.lo == x.hi for v in anchors for x in v))
    if kind.kind is Kind.ONE_POINT:
        return together and bool(balls.norm(arms[0]) > 0)
    return kind.kind is Kind.FREE_TURNING and not any(any(map(any, loaded.arm_ranges[i])) for i in taut)


class Lengths(NamedTuple):
    """All cables' lengths as the kernels see them, file order."""

    bounds: Floats
    """(N, 2) of l_i, m."""
    squares: Floats
    """(N,) l_i^2; the error bounds |exact - value|."""
    squares_err: Floats


def lengths_of(problem: Problem) -> Lengths:
    """Return the lengths of a problem in arrays."""
    bounds = np.array([[enclose(lo)[0], enclose(hi)[1]] for lo, hi in problem.lengths])
    squares, errors = split([Range(lo * lo, hi * hi) for lo, hi in problem.lengths])
    return Lengths(bounds, squares, errors)
