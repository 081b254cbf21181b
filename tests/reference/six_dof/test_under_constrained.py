"""Platforms whose poses are known otherwise: constructed examples, a benchmark and shipped robots."""

from __future__ import annotations

import json
from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.mechanics.orientation import rotation_from_quaternion
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Cable, Platform, Robot
from solvers import forward_kinematics, inverse_kinematics
from solvers.answers.data import CableState, Outcome, Solution
from solvers.answers.result import Result

DATA = Path(__file__).parents[1] / "data"
CASES = {case["name"]: case for case in json.loads((DATA / "uc.json").read_text())["cases"]}
COUNTS = {"UC2": 8, "UC3": 14, "UC4": 3}
SIX_LEGS = json.loads((DATA / "six_leg_40.json").read_text())
DIGITS = 1e-8
"""The references are printed to 1e-12; tensions to 1e-6 of the weight."""


def exact(vector) -> tuple[Fraction, Fraction, Fraction]:
    x, y, z = (Fraction(str(c)) for c in vector)
    return x, y, z


def robot_of(case: dict, name: str, gravity: str) -> Robot:
    anchors = zip(case["frame_anchors_m"], case["platform_anchors_m"], strict=True)
    cables = tuple(Cable(f"c{i + 1}", exact(a), exact(b)) for i, (a, b) in enumerate(anchors))
    return Robot(name, Platform(Fraction(1)), cables, exact((0, 0, gravity)))


@cache
def solved(name: str, threads: int = 1, every_subset: bool = False) -> Result:
    case = CASES[name]
    taut = None if every_subset else range(len(case["lengths_m"]))
    lengths = [str(x) for x in case["lengths_m"]]
    return forward_kinematics(robot_of(case, name, "-1"), lengths, taut=taut, threads=threads)


def width(bounds) -> float:
    return float(np.max(bounds[..., 1] - bounds[..., 0]))


def distance(bounds, values) -> float:
    """Return how far the farthest entry lies outside its range."""
    values = np.asarray(values)
    return float(np.max(np.maximum(bounds[..., 0] - values, values - bounds[..., 1]).clip(0.0)))


def is_at(solution: Solution, pose: dict) -> bool:
    return (
        distance(solution.position, pose["G_m"]) < DIGITS
        and distance(solution.rotation, rotation_from_quaternion(pose["quaternion"])) < DIGITS
    )


def check_sound(result: Result, robot: Robot) -> None:
    """Check a result without undecided parts against itself and the robot."""
    assert result.outcome is Outcome.COMPLETE and not result.undecided and not result.pending
    assert result.verify(robot) == []


@pytest.mark.parametrize("name", COUNTS)
def test_every_pose_with_all_cables_taut(name: str) -> None:
    case, result = CASES[name], solved(name)
    check_sound(result, robot_of(case, name, "-1"))
    assert len(result.solutions) == len(case["solutions"]) == COUNTS[name]
    for pose in case["solutions"]:
        (solution,) = (s for s in result.solutions if is_at(s, pose))
        assert width(solution.position) < DIGITS and width(solution.rotation) < DIGITS
        assert distance(solution.tensions, pose["tension_over_W"]) < 1e-6
        assert set(solution.cable_states) == {CableState.TAUT} and solution.slack_respected


@pytest.mark.parametrize("name", COUNTS)
def test_only_the_lowest_pose_is_stable(name: str) -> None:
    solutions = solved(name).solutions
    lowest = min(solutions, key=lambda s: s.height[0])
    assert all(lowest.height[1] < s.height[0] for s in solutions if s is not lowest)
    assert lowest.stability is Stability.STABLE
    assert all(s.stability is Stability.UNSTABLE for s in solutions if s is not lowest)


@pytest.mark.parametrize("name", COUNTS)
def test_all_subsets_hold_the_same_poses_with_all_cables_taut(name: str) -> None:
    case, result = CASES[name], solved(name, every_subset=True)
    check_sound(result, robot_of(case, name, "-1"))
    n = len(case["lengths_m"])
    assert len(result.subsets) == 2**n - 1
    alone, together = solved(name).solutions, [s for s in result.solutions if len(s.taut) == n]
    assert len(alone) == len(together)
    for a, b in zip(alone, together, strict=True):
        assert np.array_equal(a.position, b.position) and np.array_equal(a.rotation, b.rotation)


@pytest.mark.parametrize("name", COUNTS)
def test_threads_do_not_change_a_bit(name: str) -> None:
    one, two = (solved(name, threads=n).to_dict()["solutions"] for n in (1, 2))
    assert one == two


def test_six_legs_with_forty_poses() -> None:
    robot = robot_of(SIX_LEGS, "six legs", "-9.81")
    result = forward_kinematics(
        robot, [str(x) for x in SIX_LEGS["lengths_m"]], taut=range(6), ignore_tension_sign=True
    )
    check_sound(result, robot)
    assert len(result.solutions) == SIX_LEGS["poses"]
    assert {s.stability for s in result.solutions} == {Stability.STABLE}
    middles = [s.rotation.mean(axis=-1) for s in result.solutions]
    gaps = [np.abs(a - b).max() for k, a in enumerate(middles) for b in middles[:k]]
    assert min(gaps) > 0.1


SETTLED = [
    ("cogiro", (2, 4), (2.8, 1.6, 0.8), (1, 0, -0.1, 0.2)),
    ("cogiro", (0, 3, 5), (-2.3, -0.5, 0.1), (1, -0.3, -0.1, 0)),
    ("cogiro", (1, 2, 6, 7), (0.2, -2.0, 0.8), (1, 0.2, 0, -0.2)),
    ("cogiro", (2, 3, 6, 7), (-1.2, 0.2, 1.9), (1, 0.1, 0, -0.5)),
    ("cogiro", (0, 1, 3, 4, 7), (-3.9, -2.1, 2.2), (1, -0.3, 0.2, 0.2)),
    ("cogiro", (1, 2, 3, 6, 7), (-3.6, 2.2, 0.7), (1, 0.3, 0.2, -0.1)),
    ("cogiro", (0, 1, 2, 4, 5, 7), (2.1, 2.3, 0.9), (1, 0.2, 0.3, -0.1)),
    ("cogiro", (2, 3, 4, 5, 6, 7), (2.8, 0.3, 3.0), (1, 0, -0.4, -0.2)),
    ("fast", (0, 1, 2, 3, 4, 5), (10, 20, -30), (1, 0, 0, 0)),
    ("fast", (0, 2, 4, 5), (10, 20, -30), (1, 0, 0, 0)),
    ("nist_robocrane", (0, 1, 2, 3, 4, 5), (0.1, -0.1, 0.3), (1, 0, 0, 0)),
    ("nist_robocrane", (0, 1, 2, 3, 4), (0.1, -0.1, 0.3), (1, 0, 0, 0)),
    ("nist_robocrane", (0, 2, 4), (0.1, -0.1, 0.3), (1, 0, 0, 0)),
]
"""Shipped robots: cables that carry the load near a pose, the others 5 % longer than they need to be."""


@pytest.mark.parametrize(("name", "taut", "position", "quaternion"), SETTLED)
def test_a_static_pose_of_a_shipped_robot_is_found(name: str, taut, position, quaternion) -> None:
    robot = load_robot(name)
    pose = inverse_kinematics(
        robot, position, quaternion=quaternion, taut=taut, settle=True, settle_within=6.0, slack_margin=0.05
    )
    assert pose.is_static and min(pose.tensions[i] for i in taut) > 0
    result = forward_kinematics(robot, pose.lengths, taut=taut)
    check_sound(result, robot)
    size = max(pose.lengths)
    (solution,) = (
        s
        for s in result.solutions
        if distance(s.position, pose.position) < 1e-9 * size and distance(s.rotation, pose.rotation) < 1e-9
    )
    assert solution.taut == taut and solution.slack_respected
    assert width(solution.position) < 1e-9 * size and width(solution.rotation) < DIGITS
    assert distance(solution.tensions, pose.tensions) < 1e-6 * max(pose.tensions)
