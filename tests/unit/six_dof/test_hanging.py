"""A cable at the centre of mass: no pose without tensions is listed, none is lost."""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np
import pytest
from flint import arb_mat

from cdpr_interval.exact import balls
from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.six_dof.frame import Pose
from cdpr_interval.robots.cable_robot import Cable, Platform, Robot
from solvers import forward_kinematics
from solvers.answers.data import CableState, Outcome
from solvers.questions.problem import Problem
from solvers.six_dof.hanging import hangs_by_centre, slack_rotation

ZERO = (Fraction(0),) * 3


def vector(text: str) -> Vector:
    x, y, z = (Fraction(v) for v in text.split())
    return (x, y, z)


def robot(*cables: tuple[str, str]) -> Robot:
    """Return a robot of 1 kg from exit and platform points."""
    made = tuple(Cable(f"c{k}", vector(a), vector(b)) for k, (a, b) in enumerate(cables))
    return Robot("hanging", Platform(Fraction(1), ZERO), made)


CENTRAL = ("0 0 4", "0 0 0")
SECOND = ("2 0.5 4", "0.5 0.2 0.1")
THIRD = ("1 3 4.2", "-0.4 0.3 0.15")


@pytest.mark.parametrize(
    ("cables", "lengths", "families", "poses"),
    [
        ((CENTRAL, SECOND), ("3", "3.7"), 1, 1),
        ((SECOND, CENTRAL), ("3.7", "3"), 1, 1),
        ((CENTRAL, SECOND), ("3", "3"), 0, 2),
        ((CENTRAL, SECOND), ("3", "9"), 1, 0),
        ((CENTRAL, SECOND, THIRD), ("3", "3.7", "4.4"), 1, 4),
        ((CENTRAL, SECOND, THIRD), ("3", "3.7", "4"), 1, 4),
    ],
)
def test_no_pose_without_tensions_is_listed(
    cables: tuple[tuple[str, str], ...], lengths: tuple[str, ...], families: int, poses: int
) -> None:
    result = forward_kinematics(robot(*cables), lengths)
    assert result.outcome is Outcome.COMPLETE
    free = [s for s in result.solutions if s.family is not None and s.family.kind == "all-rotations"]
    assert len(free) == families and len(result.solutions) == families + poses
    for s in result.solutions:
        assert all(s.tensions[i, 0] > 0.0 for i in s.taut)
        assert (len(s.taut) == 1) == (s in free)
        for i, state in enumerate(s.cable_states):
            longest = float(Fraction(lengths[i]))
            assert state is CableState.TAUT or s.distances[i, 1] < longest


def test_asked_for_alone_a_subset_has_no_poses_of_the_smaller_one() -> None:
    result = forward_kinematics(robot(CENTRAL, SECOND), ["3", "3.7"], taut=[0, 1])
    assert result.outcome is Outcome.COMPLETE
    assert [s.taut for s in result.solutions] == [(0, 1)]
    assert result.solutions[0].tensions[:, 0].min() > 1.0


def test_cables_that_leave_no_rotation_slack_exclude_the_family() -> None:
    """Each alone could be slack; the arms are opposite, and both cables pull upward."""
    pair = (CENTRAL, ("0.01 0 5", "0 0 1"), ("0 0.01 5", "0 0 -1"))
    problem = Problem(robot(*pair), tuple((Fraction(x), Fraction(x)) for x in ("3", "3.5", "3.5")))
    centre = balls.vector([balls.from_fraction(Fraction(x)) for x in (0, 0, 1)])
    assert slack_rotation(problem, centre, [1, 2]) is False
    assert isinstance(slack_rotation(problem, centre, [1]), arb_mat)
    # Just tight at best: neither.
    edge = Problem(robot(CENTRAL, ("0 0 5", "0 0 1")), ((Fraction(3), Fraction(3)),) * 2)
    assert slack_rotation(edge, centre, [1]) is True


def test_a_rotation_is_found_wherever_one_was_planted() -> None:
    rng = random.Random(3)
    with balls.precision():
        for _ in range(20):
            cables = [CENTRAL]
            for _ in range(3):
                a, b = ([f"{rng.uniform(-s, s):.3f}" for _ in range(3)] for s in (5.0, 0.8))
                cables.append((" ".join(a), " ".join(b)))
            made = robot(*cables)
            centre = balls.vector([balls.from_fraction(Fraction(x)) for x in (0, 0, 1)])
            turned = np.linalg.qr(np.array([[rng.gauss(0.0, 1.0) for _ in range(3)] for _ in range(3)]))[0]
            turned *= np.linalg.det(turned)
            lengths = [Fraction(3)]
            for c in made.cables[1:]:
                spoke = np.array(c.frame_anchor, dtype=float) - [0.0, 0.0, 1.0]
                spoke -= turned @ np.array(c.platform_anchor, dtype=float)
                lengths.append(Fraction(float(np.linalg.norm(spoke)) + 0.05))
            problem = Problem(made, tuple((x, x) for x in lengths))
            assert isinstance(slack_rotation(problem, centre, [1, 2, 3]), arb_mat)


def test_tensions_vanish_where_moments_are_independent() -> None:
    made = robot(CENTRAL, SECOND, THIRD)
    problem = Problem(made, ((Fraction(3), Fraction(3)),) * 3)
    pose = Pose(balls.identity(), balls.vector([balls.from_fraction(Fraction(x)) for x in (0, 0, 1)]), ())
    assert hangs_by_centre(problem, (0, 1), pose)
    assert hangs_by_centre(problem, (0, 1, 2), pose)
    assert not hangs_by_centre(problem, (1, 2), pose)
    assert not hangs_by_centre(problem, (0,), pose)
    # A line of a cable through the centre of mass: it may pull.
    through = Problem(robot(CENTRAL, ("2 0 1", "1 0 0")), ((Fraction(3), Fraction(3)),) * 2)
    assert not hangs_by_centre(through, (0, 1), pose)
