"""Tension limits asked of every class of robot: what is left is what a filter of all poses leaves."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.robots.cable_robot import Elasticity, Robot
from cdpr_interval.robots.formats.reader import parse_robot
from solvers import Result, forward_kinematics
from solvers.answers.data import Outcome, Solution
from tests.oracle.compare import compare
from tests.oracle.problems import problem
from tests.oracle.subsets import find_poses
from tests.support.planted.platform import plant
from tests.support.planted.verdict import Verdict, judge

QUESTIONS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "point mass": ("merlet_4_1", "3.1,3.2,3.3,3.4", {}),
    "elastic point mass": ("merlet_4_1_k100", "2.9,2.9,4.1,4.1", {}),
    "point mass with ranges": ("merlet_4_1", "3.1,3.2,3.3,3.4+-0.01", {}),
    "mass on pulleys": (
        "paty_cdpr4",
        "9.654513618793564,9.098017637344164,9.913734577595523,10.927627223606171",
        {},
    ),
    "platform": ("uc3", "7.5,8,7", {}),
    "platform with ranges": ("uc3", "7.5+-0.005,8,7", {}),
    "platform on pulleys": ("grab33", "1.54832,1.64748,1.53246", {"taut": "c1,c2,c3"}),
}
SLOW = ("platform on pulleys",)
NAMES = [pytest.param(name, marks=pytest.mark.slow if name in SLOW else ()) for name in QUESTIONS]


def key(pose: Solution) -> tuple[Any, ...]:
    """Return what an entry is told by: everything but whether the limits are kept."""
    bounds = (pose.position, pose.rotation, pose.tensions)
    return (pose.taut, pose.cable_states, *(b.tobytes() for b in bounds))


def carrying(pose: Solution) -> np.ndarray:
    """Return bounds (K, 2) of the tensions of the cables that are not slack."""
    return np.array([pose.tensions[i] for i, state in enumerate(pose.cable_states) if state != "slack"])


def exactly(bounds: list[float]) -> tuple[Fraction, Fraction]:
    """Return bounds as fractions."""
    lo, hi = bounds
    return Fraction(lo), Fraction(hi)


def filtered(result: Result, lo: Fraction, hi: Fraction) -> tuple[list[Any], list[Any]]:
    """Return the entries that are surely within, and those that may be; written anew, exactly.

    A switching cable is slack for some choices, whatever its tension is for others.
    """
    surely, maybe = [], []
    for pose in result.solutions:
        ends = [exactly(row) for row in carrying(pose).tolist()]
        if all(lo <= a and b <= hi for a, b in ends):
            surely.append(key(pose))
        elif all(b >= lo and a <= hi for a, b in map(exactly, pose.tensions[list(pose.taut)].tolist())):
            maybe.append(key(pose))
    return surely, maybe


def limits_near(result: Result) -> list[tuple[Fraction, Fraction]]:
    """Return limits around the ends of every tension, on them and between them."""
    ends = sorted({float(x) for pose in result.solutions for x in carrying(pose).ravel()})
    above = 2 * Fraction(ends[-1])
    found = [(Fraction(0), above)]
    for a, b in pairwise(ends):
        middle = (Fraction(a) + Fraction(b)) / 2
        found += [(Fraction(0), middle), (middle, above), (Fraction(0), Fraction(b)), (Fraction(a), above)]
        found += [(Fraction(a), Fraction(b))]
    return [(lo, hi) for lo, hi in found if lo < hi]


@pytest.mark.parametrize("name", NAMES)
def test_what_is_left_is_what_a_filter_leaves(name: str) -> None:
    """The filter is applied to the answer without limits; a dozen limits are asked of the solver itself."""
    robot, lengths, options = QUESTIONS[name]
    everything = forward_kinematics(robot, lengths, **options)
    assert everything.outcome is Outcome.COMPLETE
    cases = limits_near(everything)
    for lo, hi in cases[:: max(1, len(cases) // 12)]:
        result = forward_kinematics(robot, lengths, tension=(lo, hi), **options)
        surely, maybe = filtered(everything, lo, hi)
        assert [key(p) for p in result.solutions if p.tension_respected] == surely
        assert [key(p) for p in result.solutions if p.tension_respected is None] == maybe
        assert result.outcome is (Outcome.INCOMPLETE if maybe else Outcome.COMPLETE)
        assert result.verify(robot) == []
        assert Result.from_json(result.to_json()).to_json() == result.to_json()
        if not result.solutions:
            assert result.message.startswith("no static pose within the tension limits; ")


@pytest.mark.parametrize("kind", ["two-cables", "two-parallel-equal", "a-hook-2", "b-rod-2", "d-one-point-2"])
@pytest.mark.parametrize("seed", range(2))
def test_a_planted_pose_on_a_limit_is_never_left_out(kind: str, seed: int) -> None:
    """Families and single poses: the planted tensions are exact, and a limit just there allows them."""
    planted = plant(kind, seed)
    most = max(planted.tensions)
    least = min(planted.tensions[i] for i in planted.taut)

    def asked(lo: Fraction, hi: Fraction) -> tuple[Verdict, Result]:
        result = forward_kinematics(
            planted.robot,
            planted.lengths,
            taut=planted.taut,
            external_force=planted.external_force,
            tension=(lo, hi),
        )
        return judge(planted, result), result

    tiny = most / 10**6
    assert asked(least - tiny, most + tiny)[0] is Verdict.FOUND
    for lo, hi in ((Fraction(0), most), (least, most + tiny)):
        verdict, _ = asked(lo, hi)
        assert verdict in (Verdict.FOUND, Verdict.UNDECIDED)
    for lo, hi in ((Fraction(0), most - tiny), (least + tiny, most + tiny)):
        verdict, result = asked(lo, hi)
        assert verdict is Verdict.LOST, "the pose is outside, and proved to be"
        assert result.outcome is Outcome.COMPLETE


def test_the_weight_on_one_cable_is_a_limit_that_no_bounds_can_tell() -> None:
    """UC2 weighs 1 N: on one cable its tension is exactly 1 N, in bounds that hold both sides."""
    result = forward_kinematics("uc2", ["7.5", "30"], tension="0.5..1")
    assert result.outcome is Outcome.INCOMPLETE
    assert {pose.tension_respected for pose in result.solutions if pose.taut == (0,)} == {None}
    assert "within the tension limits is open" in result.message or "are within" in result.message
    apart = forward_kinematics("uc2", ["7.5", "30"], tension="0.5..0.999")
    assert all(pose.taut != (0,) for pose in apart.solutions)


def stretching(name: str, axial_stiffness: int) -> Robot:
    """Return a robot that ships on elastic cables."""
    robot = load_robot(name)
    spring = Elasticity(axial_stiffness=axial_stiffness)
    return robot.replace(cables=[cable.replace(elasticity=spring) for cable in robot.cables])


@pytest.mark.slow
def test_an_elastic_platform_is_complete_within_the_limits() -> None:
    """UC2, 1 N on 100 N of stiffness, against the answer without limits."""
    robot, lengths = stretching("uc2", 100), "7.5,8"
    everything = forward_kinematics(robot, lengths)
    assert everything.outcome is Outcome.COMPLETE
    ends = sorted(float(pose.tensions[:, 1].max()) for pose in everything.solutions)
    for limits in ("0..5", (0, ends[2] + 1e-6), (0, ends[2] - 1e-6), (ends[0] + 1e-6, 2)):
        result = forward_kinematics(robot, lengths, tension=limits)
        lo, hi = result.question.tension or (0.0, 0.0)
        wanted = [
            pose.nominal.position
            for pose in everything.solutions
            if (carrying(pose) >= lo).all() and (carrying(pose) <= hi).all()
        ]
        assert result.outcome is Outcome.COMPLETE and not result.undecided
        assert len(result.solutions) == len(wanted)
        for pose, place in zip(result.solutions, wanted, strict=True):
            assert np.abs(np.subtract(pose.nominal.position, place)).max() < 1e-8
        assert result.verify(robot) == []
    none = forward_kinematics(robot, lengths, tension=(0, "0.1"))
    assert none.outcome is Outcome.COMPLETE and not none.solutions
    assert none.message.startswith("no static pose within the tension limits")


@pytest.mark.slow
def test_a_limit_on_an_elastic_tension_keeps_the_pose() -> None:
    """The search ends exactly at the pose: it is found there, on the very edge."""
    robot, lengths = stretching("uc2", 100), "7.5,8"
    everything = forward_kinematics(robot, lengths, tension="0..1.5")
    for pose in everything.solutions:
        lo, hi = (Fraction(x) for x in pose.tensions[int(pose.tensions[:, 1].argmax())].tolist())
        for most in (hi, (lo + hi) / 2):
            result = forward_kinematics(robot, lengths, tension=(0, most))
            gaps = [np.abs(np.subtract(p.nominal.position, pose.nominal.position)) for p in result.solutions]
            is_listed = any(gap.max() < 1e-8 for gap in gaps)
            # A region would do; a complete answer without it would not.
            assert is_listed or result.undecided
            assert most == hi or result.outcome is Outcome.INCOMPLETE


def test_high_limits_of_an_elastic_platform_leave_nothing_out() -> None:
    robot = stretching("uc2", 100)
    limited = forward_kinematics(robot, "7.5,8", tension="0N..1kN", taut="c1,c2")
    everything = forward_kinematics(robot, "7.5,8", taut="c1,c2")
    assert limited.outcome is everything.outcome is Outcome.COMPLETE
    assert len(limited.solutions) == len(everything.solutions) > 0


def test_few_elastic_poses_within_the_limits_are_all() -> None:
    result = forward_kinematics(stretching("uc2", 100), "7.5,8", tension=(0, "0.7"), taut="c1,c2")
    assert result.outcome is Outcome.COMPLETE and len(result.solutions) == 2


@pytest.mark.parametrize(
    ("kind", "seed"), [("general", 2), ("one_point", 1), ("point_mass", 1), ("elastic", 2), ("asked", 1)]
)
def test_the_oracle_agrees_about_poses_within_limits(kind: str, seed: int) -> None:
    """What the oracle finds and filters by its own tensions is what is listed, or said to be open."""
    case = problem(kind, seed)
    poses = find_poses(case, np.random.default_rng(0), 60)
    tensions = sorted(t for pose in poses for i in pose.taut if (t := float(pose.tensions[i])) > 1e-9)
    middle, above = tensions[len(tensions) // 2], 2.0 * tensions[-1]
    for lo, hi in ((0.0, above), (0.0, 1.001 * middle), (0.999 * middle, above), (0.0, middle)):
        result = forward_kinematics(
            parse_robot(case.robot_yaml().encode()),
            [(a, b) for a, b in case.lengths],
            taut=case.taut,
            ignore_slack=case.ignore_slack,
            external_force=case.force,
            tension=(lo, hi),
            cell_limit=300_000,
        )
        within = [pose for pose in poses if all(lo <= pose.tensions[i] <= hi for i in pose.taut)]
        found = compare(case, result.to_dict(), np.random.default_rng(seed), poses=within)
        assert not found.contradictions
        assert result.verify() == []
