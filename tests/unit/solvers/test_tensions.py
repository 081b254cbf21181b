"""The static pose for given tensions: planted poses, ranges, and when there is none."""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.errors import InputError, NotSupportedError
from cdpr_interval.robots.cable_robot import Cable, Platform, Robot
from solvers import Result, pose_from_tensions

SEED = 20261123
ZERO = (Fraction(0), Fraction(0), Fraction(0))


def robot_of(exits, mass: float = 1) -> Robot:
    cables = tuple(Cable(f"c{k}", tuple(Fraction(x) for x in a), ZERO) for k, a in enumerate(exits))
    return Robot("made", Platform(Fraction(mass)), cables, (Fraction(0), Fraction(0), Fraction(-10)))


def test_planted_poses_are_found():
    """Three tensions that balance the load at a pose: it is the one that is found."""
    generator = random.Random(SEED)
    for _ in range(30):
        exits = [[generator.randint(-40, 40) / 8, generator.randint(-40, 40) / 8, 0.0] for _ in range(3)]
        inside = np.array([generator.uniform(0.2, 1) for _ in range(3)])
        pose = inside / inside.sum() @ np.array(exits) - [0, 0, generator.uniform(1, 5)]
        arms = np.array(exits) - pose
        rho = np.linalg.norm(arms, axis=1)
        try:
            tension = np.linalg.solve((arms / rho[:, None]).T, [0, 0, 10])
        except np.linalg.LinAlgError:
            continue
        if min(tension) < 1e-3 or abs(np.linalg.det(arms)) < 0.1:
            continue
        result = pose_from_tensions(robot_of(exits), tension.tolist())
        (solution,) = result.solutions
        assert result.outcome == "complete" and np.abs(solution.position.mean(axis=1) - pose).max() < 1e-7
        assert np.abs(result.lengths.mean(axis=1) - rho).max() < 1e-7 and not result.verify(robot_of(exits))


def test_ranges_enclose_the_pose_of_every_choice():
    robot = load_robot("merlet_4_1")
    wide = pose_from_tensions(robot, "441+-3,442+-3,202+-3,203+-3")
    (solution,) = wide.solutions
    generator = random.Random(SEED)
    for _ in range(20):
        chosen = [t + generator.choice((-3, 3, generator.uniform(-3, 3))) for t in (441, 442, 202, 203)]
        (other,) = pose_from_tensions(robot, chosen).solutions
        assert (solution.position[:, 0] <= other.position[:, 1]).all()
        assert (other.position[:, 0] <= solution.position[:, 1]).all()
    assert not wide.verify(robot)
    again = Result.from_json(wide.to_json())
    assert again.question == wide.question and again.question.tensions_given is not None


def test_elastic_cables_are_given_their_unstretched_lengths():
    robot = load_robot("merlet_4_1_k1000")
    result = pose_from_tensions(robot, "441.45,441.45,202.2383,202.2383")
    distances = result.solutions[0].distances.mean(axis=1)
    stretch = np.array([441.45, 441.45, 202.2383, 202.2383]) / 1e5
    assert np.abs(result.lengths.mean(axis=1) - distances + stretch).max() < 1e-9 and not result.verify(robot)


@pytest.mark.parametrize(
    ("tensions", "taut", "outcome", "message"),
    [
        ("100,100,100,100", None, "complete", "less than the load"),
        ("4000,100,100,100", None, "complete", "into the exit of c1"),
        ("800", "c1", "incomplete", "on a line along the load"),
        ("700", "c1", "complete", "less than the load"),
        ("392.4,392.4", "c1,c2", "incomplete", "no box"),
    ],
)
def test_where_there_is_no_pose_or_it_is_open(tensions: str, taut: str | None, outcome: str, message: str):
    result = pose_from_tensions(load_robot("merlet_4_1"), tensions, taut=taut)
    assert result.outcome == outcome and not result.solutions and message in result.message
    assert not result.verify(load_robot("merlet_4_1"))


def test_wrong_questions_are_refused():
    robot = load_robot("merlet_4_1")
    with pytest.raises(InputError, match="3 tensions for 4 cables"):
        pose_from_tensions(robot, "1,2,3")
    with pytest.raises(InputError, match="positive"):
        pose_from_tensions(robot, "0,2,3,4")
    with pytest.raises(NotSupportedError, match="platform"):
        pose_from_tensions(load_robot("uc2"), "1,2")
