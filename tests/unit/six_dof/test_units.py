"""A platform's poses do not depend on the units of its lengths and forces."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval.exact.vector import Vector
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.reader import load_robot
from solvers import forward_kinematics
from solvers.answers.data import Outcome
from solvers.answers.result import Result
from solvers.questions.problem import Options, Problem
from solvers.six_dof.prepared import lengths_of
from solvers.six_dof.reduction import reduced_problems
from solvers.six_dof.units import METRES, Units, in_units, moved_outward, scaled

CASES = {"uc2": ("7.5", "8"), "uc3": ("7.5", "8", "7")}
MILLION, TINY = Fraction(10**6), Fraction(1, 10**30)


def in_other_units(robot: Robot, length: Fraction, mass: Fraction) -> Robot:
    """Return a robot with all its lengths and its mass multiplied."""

    def moved(v: Vector) -> Vector:
        return (length * v[0], length * v[1], length * v[2])

    platform = robot.platform
    return replace(
        robot,
        cables=tuple(
            replace(c, frame_anchor=moved(c.frame_anchor), platform_anchor=moved(c.platform_anchor))
            for c in robot.cables
        ),
        platform=replace(platform, mass=mass * platform.mass, centre_of_mass=moved(platform.centre_of_mass)),
    )


def poses(name: str, length: Fraction, mass: Fraction) -> Result:
    """Return the poses of a case in other units."""
    robot = in_other_units(load_robot(name), length, mass)
    lengths = [length * Fraction(x) for x in CASES[name]]
    return forward_kinematics(robot, lengths, taut=range(len(lengths)))


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize(
    ("length", "mass"),
    [
        (MILLION, Fraction(1)),
        (1 / MILLION, Fraction(1)),
        (Fraction(1000), Fraction(1)),
        (Fraction(1), TINY),
        (Fraction(1), 1 / TINY),
        (MILLION, TINY),
    ],
)
def test_all_poses_are_proved_in_any_units(name: str, length: Fraction, mass: Fraction) -> None:
    usual, found = poses(name, Fraction(1), Fraction(1)), poses(name, length, mass)
    assert found.outcome is usual.outcome is Outcome.COMPLETE
    assert len(found.solutions) == len(usual.solutions)
    for a, b in zip(found.solutions, usual.solutions, strict=True):
        assert a.stability is b.stability
        assert np.allclose(a.position / float(length), b.position, rtol=0.0, atol=1e-9)
        assert np.allclose(a.rotation, b.rotation, rtol=0.0, atol=1e-9)
        assert np.allclose(a.tensions / float(mass), b.tensions, rtol=0.0, atol=1e-7)


def test_a_robot_of_ordinary_size_keeps_its_units() -> None:
    for length, units in ((Fraction(1), METRES), (MILLION, Units(length=16 + 8)), (1 / MILLION, Units(-24))):
        robot = in_other_units(load_robot("uc3"), length, Fraction(1))
        ranges = tuple((length * Fraction(x), length * Fraction(x)) for x in CASES["uc3"])
        problem = Problem(robot, ranges)
        (reduced,) = reduced_problems(problem.loaded, lengths_of(problem), Options(), (0, 1, 2))
        assert abs(reduced.units.length - units.length) <= 8 and reduced.units.force == 0
        assert bool(reduced.units) is bool(units)
        assert 0.05 < reduced.model.size < 20.0


def test_what_cannot_be_scaled_exactly_is_not_scaled() -> None:
    """Bounds would be lost where a number underflows."""
    robot = load_robot("uc3")
    problem = Problem(robot, ((Fraction(7), Fraction(7)),) * 3)
    (reduced,) = reduced_problems(problem.loaded, lengths_of(problem), Options(), (0, 1, 2))
    moved = in_units(reduced.model, Units(8, -32))
    assert moved is not None
    assert moved.size * 256.0 == reduced.model.size
    assert np.array_equal(moved.lengths_sq * 65536.0, reduced.model.lengths_sq)
    assert np.array_equal(moved.load, 2.0**32 * reduced.model.load)
    back = in_units(moved, Units(-8, 32))
    assert back is not None
    assert all(np.array_equal(x, y) for x, y in zip(back, reduced.model, strict=True))
    assert scaled(np.array([1.0, 3e-320]), -8) is None
    assert scaled(np.array([1.0, 1e300]), 64) is None
    odd = reduced.model._replace(load=np.array([3e-320, 0.0, -1.0]))
    assert in_units(odd, Units(force=8)) is None


def test_bounds_that_underflow_stay_bounds() -> None:
    box = np.array([[3e-320, 5e-320], [-1.0, 1.0], [1e300, 2e300]])
    moved = moved_outward(box, np.array([-4, 3, 64]))
    assert Fraction(moved[0, 0]) <= Fraction(3e-320) / 16
    assert Fraction(moved[0, 1]) >= Fraction(5e-320) / 16
    assert moved[1].tolist() == [-8.0, 8.0]
    assert moved[2, 0] < np.inf and moved[2, 1] == np.inf
