"""What a platform under a load needs in every run, whatever the lengths: computed once and kept."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.exact.range import Range
from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.loaded import MOST_KEPT, LoadedRobot
from cdpr_interval.mechanics.six_dof.arrays import split
from cdpr_interval.mechanics.six_dof.families import Classification, classify
from cdpr_interval.mechanics.six_dof.fields import Cables
from solvers.questions.problem import Problem

Floats = NDArray[np.float64]

SUBSETS = 4096
"""Most taut subsets whose kind is kept."""


@lru_cache(maxsize=MOST_KEPT)
def cables_of(loaded: LoadedRobot) -> Cables:
    """Return the arrays of the compiled reports."""
    with balls.precision():
        g = balls.fractions(loaded.gravity)
        up = balls.bounds_array(g * (-1 / balls.norm(g)))
    return Cables(
        exits=np.array([column(a) for a in loaded.exits]),
        arms=np.array([column(b) for b in loaded.arms]),
        centre=column(loaded.centre),
        up=up.reshape(1, 3, 2),
        load=column(loaded.load),
    )


def column(v: Vector) -> Floats:
    """Return the bounds (3, 1, 2) of an exact vector."""
    return np.array([enclose(x) for x in v]).reshape(3, 1, 2)


@lru_cache(maxsize=SUBSETS)
def kind_of(loaded: LoadedRobot, taut: tuple[int, ...]) -> Classification:
    """Return the kind of a taut subset."""
    return classify(loaded, taut)


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
