"""What a platform under a load needs in every run, whatever the lengths: computed once and kept.

The caches are bounded, and safe to use from several threads (``functools.lru_cache``). A robot is
recognised as the same object, not by its contents: hashing all its rationals would cost more than it saves.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.mechanics.six_dof.arrays import Range, split
from cdpr_interval.mechanics.six_dof.families import Classification, classify
from cdpr_interval.mechanics.six_dof.fields import Cables
from cdpr_interval.robots.cable_robot import Robot, Vector
from solvers.questions.problem import Problem

Floats = NDArray[np.float64]

ROBOTS = 8
"""Most robots under a load that are kept."""
SUBSETS = 4096
"""Most taut subsets whose kind is kept."""


class Same:
    """A robot as the key of a cache: equal only to itself. Holds it, so that its identity stays its own."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot

    def __hash__(self) -> int:
        return id(self.robot)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and self.robot is other.robot


@dataclass(frozen=True, eq=False)
class Prepared:
    """A robot under a load. Compared and hashed by identity: caches of what follows from it use it as key."""

    problem: Problem
    """The robot and its load; no lengths."""

    @cached_property
    def cables(self) -> Cables:
        """The arrays of the compiled reports."""
        problem = self.problem
        with balls.precision():
            g = balls.fractions(problem.robot.gravity)
            up = balls.bounds_array(g * (-1 / balls.norm(g)))
        return Cables(
            exits=np.array([column(c.frame_anchor) for c in problem.robot.cables]),
            arms=np.array([column(b) for b in problem.anchors_from_centre]),
            centre=column(problem.robot.platform.centre_of_mass),
            up=up.reshape(1, 3, 2),
            load=column(problem.load),
        )


def column(v: Vector) -> Floats:
    """Return the bounds (3, 1, 2) of an exact vector."""
    return np.array([enclose(x) for x in v]).reshape(3, 1, 2)


def prepared(problem: Problem) -> Prepared:
    """Return what is known of the robot and the load of a problem."""
    return _prepared(Same(problem.robot), problem.external_force)


@lru_cache(maxsize=ROBOTS)
def _prepared(robot: Same, force: Vector) -> Prepared:
    return Prepared(Problem(robot.robot, (), force))


@lru_cache(maxsize=SUBSETS)
def kind_of(robot: Prepared, taut: tuple[int, ...]) -> Classification:
    """Return the kind of a taut subset."""
    return classify(robot.problem, taut)


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
