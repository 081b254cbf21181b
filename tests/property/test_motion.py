"""Motions: sampled exact poses lie in the tubes; switches and folds are where they are said to be."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction as F
from typing import Any

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.engine.budget import Budget
from cdpr_interval.robots.cable_robot import Robot
from solvers import Motion, forward_kinematics, motion
from solvers.answers.data import Solution
from solvers.motions.course import given_course
from solvers.motions.ending import ending
from solvers.motions.platform import PlatformMover
from solvers.motions.start import mover_at
from solvers.motions.stretch import Stretch
from solvers.motions.trail import lead
from solvers.six_dof.tracked_pose import TrackedPose
from solvers.six_dof.tracker import Tracker
from tests.property.six_dof.test_continuation import nonsmooth
from tests.support.motion_samples import chosen, fits, is_without_gaps, meet, segments_at, stable
from tests.support.planted.platform import plant
from tests.support.tracked_region import start_at

MERLET = [(0, ["2.6926", "3.9051", "3.3541", "4.5"]), (10, ["2.6926", "3.9051", "3.3541", "4.3"])]
"""III.B: the fourth cable, slack, is shortened slowly."""
UC4 = [(0, ["7.5", "8", "7", "9"]), (10, ["7.5", "8", "7", "9.3"]), (15, ["7.5", "7.8", "7.2", "9.1"])]
FOUR = [(0, ["3.06", "3.06", "3.06", "3.06"]), (1, ["3.06", "3.06", "3.06", "3.12"])]
CASES = {
    "merlet": ("merlet_4_1", MERLET, 0, None),
    "merlet 1 mm": ("merlet_4_1", MERLET, "0.001", 1),
    "uc4": ("uc4", UC4, 0, None),
    "uc4 1 mm": ("uc4", UC4, "0.001", 2),
    "uc4 wound in": ("uc4", [(-3, ["7.5", "8", "7", "9"]), (2, ["7.5", "8", "7", "4"])], 0, None),
    "four_winches": ("four_winches", FOUR, 0, "0.25"),
    "four_winches 1 mm": ("four_winches", FOUR, "0.001", None),
    "uc3": ("uc3", [(0, [7.5, 8, 7]), (1, [7.4, "8.3+-0.002", 7.3]), (4, ["8..8.01", 8, 7])], 0, None),
    "uc2": ("uc2", [(0, ["7.5", "8"]), (1e9, ["7.5", "6"])], "0.0001", 3e8),
}
COUNT = 14
"""Samples of each."""
SLOW = [pytest.param(name, marks=[pytest.mark.slow] if name.startswith("uc4") else []) for name in CASES]


@pytest.mark.parametrize("name", SLOW)
def test_the_exact_pose_lies_in_the_tube(name: str) -> None:
    source, rows, tolerance, step = CASES[name]
    robot = load_robot(source)
    course = given_course(rows, robot.cable_names)
    result = motion(robot, rows, tolerance=tolerance, step=step)
    assert result.outcome == "complete" and is_without_gaps(result.segments) and not result.others
    assert result.segments[0].t[0] == course.begin and result.segments[-1].t[1] == course.end
    rng = random.Random(name)
    band, span = course.widened(F(tolerance), "tolerance"), course.end - course.begin
    narrow = [one for one in result.segments if one.switching]
    for k in range(COUNT):
        time = course.begin + span * F(rng.random())
        if k < len(narrow):
            low, high = map(F, narrow[k].t)
            time = low + (high - low) * F(rng.random())
        (pose,) = stable(robot, chosen(band, rng).middles(time))
        found = segments_at(result.segments, float(time))
        assert found and all(fits(pose, one) for one in found), float(time)


def carries(robot: Robot, lengths: Any, cable: int) -> bool:
    (pose,) = stable(robot, lengths)
    return bool(pose.tensions[cable, 1] > 0.0)


@pytest.mark.parametrize(
    "name", [one for one in SLOW if one.values[0] in ("merlet", "uc4", "uc4 wound in", "four_winches")]
)
def test_cables_switch_when_it_is_said(name: str) -> None:
    """The time is found by bisection, without anything that motions use."""
    source, rows, _, step = CASES[name]
    robot = load_robot(source)
    course = given_course(rows, robot.cable_names)
    result = motion(robot, rows, step=step)
    assert result.events
    for event in result.events:
        cable = robot.cable_names.index(event.cable)
        low, high = F(event.t[0]), F(event.t[1])
        before, after = (carries(robot, course.middles(t), cable) for t in (low, high))
        assert (before, after) == ((True, False) if event.kind == "slack" else (False, True))
        assert high - low < (course.end - course.begin) / 1000
        apart = (high - low) / 4
        while high - low > apart:
            middle = (low + high) / 2
            now = carries(robot, course.middles(middle), cable)
            low, high = (middle, high) if now == before else (low, middle)
        # In between it switches once: nothing is said of where exactly.
        assert event.t[0] <= low <= high <= event.t[1]


def test_merlets_experiment() -> None:
    result = motion("merlet_4_1", MERLET)
    assert [[result.cables[i] for i in one.taut] for one in result.segments] == [
        ["c1", "c2", "c3"],
        ["c1", "c3"],
        ["c1", "c3", "c4"],
    ]
    assert [(str(event.kind), event.cable) for event in result.events] == [("slack", "c2"), ("taut", "c4")]


def led(robot: Robot, rows: Any, start: Solution) -> tuple[Any, Any]:
    """Return the event with which a pose ends, and the trail until then."""
    course = given_course(rows, robot.cable_names)
    among = forward_kinematics(robot, course.middles(course.begin)).solutions
    (start,) = [one for one in among if meet(one.position, start.position)]
    mover = mover_at(robot, start, among, course)
    trail = lead(mover, course, course.knots(), Budget())
    if not trail.reason:
        return None, trail
    return ending(robot, course, trail, mover.here, Budget(), 1), trail


@pytest.mark.parametrize(
    ("name", "first", "last", "numbers", "between"),
    [
        ("uc2", ["7.5", "7.374"], ["7.5", "7.3"], (2, 3), ("6.01", "6.03")),
        ("uc3", ["7.5", "8", "7"], ["7.5", "8", "5"], (2, 3), ("0.32", "0.3213")),
        ("uc3", ["7.5", "8", "7"], ["7.5", "8", "5"], (7, 10), ("2.109", "2.11")),
        pytest.param(
            "nonsmooth",
            ["9.22", "7.4", "6.30"],
            ["9.22", "7.4", "6.28"],
            (2, 3),
            ("5.35", "5.4"),
            marks=pytest.mark.slow,
        ),
    ],
)
def test_two_poses_meet_at_a_fold(
    name: str, first: list[str], last: list[str], numbers: tuple[int, int], between: tuple[str, str]
) -> None:
    """Both are followed to nearly the same time, and proved to end; the ones that remain are listed."""
    robot = nonsmooth() if name == "nonsmooth" else load_robot(name)
    rows = [(0, first), (10, last)]
    course = given_course(rows, robot.cable_names)
    solutions = forward_kinematics(robot, first).solutions
    events = [led(robot, rows, solutions[number])[0] for number in numbers]
    for event in events:
        assert event.kind == "fold" and F(between[0]) < event.begin < event.end < F(between[1])
        afterwards = forward_kinematics(robot, course.middles(event.end)).solutions
        assert len(event.poses) == len(afterwards) == len(solutions) - 2 or name == "uc3"
    assert abs(events[0].begin - events[1].begin) < F(1, 100)
    if name != "uc3":
        # The others go on.
        assert all(
            led(robot, rows, solutions[i])[0] is None for i in range(len(solutions)) if i not in numbers
        )


def test_a_pose_that_goes_on_is_not_said_to_end() -> None:
    """A trail that is cut off before its end, whatever for, is lost: the pose afterwards comes from it."""
    robot = load_robot("uc3")
    course = given_course([(0, [7.5, 8, 7]), (10, [7.5, 8, 6.5])], robot.cable_names)
    among = forward_kinematics(robot, [7.5, 8, 7]).solutions
    for start in among[:2]:
        mover = mover_at(robot, start, among, course)
        trail = lead(mover, course, [F(0), F(1)], Budget())
        trail.reason = "it was cut off"
        event = ending(robot, course, trail, mover.here, Budget(), 1)
        assert event.kind == "lost" and "may come from it" in event.reason


@pytest.mark.parametrize("tolerance", [0, "0.0002"])
def test_a_pose_in_which_a_platform_hangs_ends(tolerance: Any) -> None:
    """The pose with the second cable taut meets one without it, which is not stable: both are gone."""
    cables = [
        {"name": f"c{i + 1}", "frame_anchor_m": a, "platform_anchor_m": b}
        for i, (a, b) in enumerate(
            [
                (["-0.56", "1.69", 4], ["0.76", "-0.7", "-0.09"]),
                (["1.87", "-1.32", "3.16"], ["-0.34", "0.06", "-0.69"]),
                (["-0.2", "-1.93", "3.5"], ["-0.6", "0.67", "-0.02"]),
            ]
        )
    ]
    robot = Robot.from_dict(
        {"format": "cdpr-robot/1", "name": "three", "platform": {"mass_kg": 1}, "cables": cables}
    )
    rows = [(0, ["3.1287", "3.6742", "3.5181"]), (1, ["3.182", "3.65", "3.521"])]
    result = motion(robot, rows, tolerance=tolerance, start=(-0.38, -0.13, 0.58))
    (event,) = result.events
    assert event.kind == "fold" and len(event.poses) == 4
    course = given_course(rows, robot.cable_names)
    low, high = F(event.t[0]), F(event.t[1])

    def there(time: F) -> list[tuple[int, ...]]:
        poses = forward_kinematics(robot, course.middles(time)).solutions
        return [p.taut for p in poses if abs(p.nominal.position[2] - 0.576) < 0.02]

    for time in (low / 2, low * F(99, 100)):
        assert sorted(there(time)) == [(0, 1, 2), (0, 2)]
    assert there(high) == []
    if tolerance:
        # Until the first time every choice has the pose, the last ones too.
        rng, band = random.Random(0), course.widened(F(tolerance), "tolerance")
        for _ in range(6):
            poses = forward_kinematics(robot, chosen(band, rng).middles(low)).solutions
            assert any(fits(pose, result.segments[-1]) for pose in poses)


@pytest.mark.parametrize("rows", [UC4, [(0, [3, 3, 3, 3]), (5, [1, 1, 1, 1])]])
def test_where_there_is_no_pose_any_more(rows: Any) -> None:
    name = "uc2" if rows is UC4 else "merlet_4_1"
    rows = [(0, ["7.5", "8"]), (5, ["2", "2"])] if rows is UC4 else rows
    robot = load_robot(name)
    result = motion(robot, rows)
    assert result.outcome == "incomplete"
    event = result.events[-1]
    assert event.kind == "fold" and event.poses == () and result.segments[-1].t[1] == event.t[0]
    course = given_course(rows, robot.cable_names)
    assert len(stable(robot, course.middles(F(event.t[0]) - F(1, 100)))) == 1
    assert forward_kinematics(robot, course.middles(F(event.t[1]))).solutions == ()


def two_stable() -> Robot:
    """Return a robot that hangs in two ways for `HANGING`."""
    cables = [
        {"name": f"c{i + 1}", "frame_anchor_m": a, "platform_anchor_m": b}
        for i, (a, b) in enumerate(
            [
                ([0.51, -0.8, 3.51], [-0.18, -0.24, 0.14]),
                ([0.34, 1.62, 3.68], [0.69, 0.57, 0.79]),
                ([0.69, -1.35, 3.86], [0.74, 0.65, 0.11]),
            ]
        )
    ]
    document = {"format": "cdpr-robot/1", "name": "two", "platform": {"mass_kg": 1}, "cables": cables}
    return Robot.from_dict(document)


HANGING = ["3.43", "2.42", "3.66"]


@pytest.mark.slow
def test_every_stable_pose_of_the_start_is_followed() -> None:
    robot, rows = two_stable(), [(0, HANGING), (10, ["2.99", "2.84", "3.98"])]
    result = motion(robot, rows)
    assert len(result.others) == 1 and result.outcome == "incomplete"
    (other,) = result.others
    assert result.events == () and result.segments[-1].t[1] == 10.0
    assert other.events[-1].kind == "lost" and other.segments[-1].t[1] == other.events[-1].t[0] < 2.0
    assert Motion.from_json(result.to_json()).to_json() == result.to_json()
    for start, wanted in ((result.start, result.segments), (other.start, other.segments)):
        one = motion(robot, rows, start=start.position.mean(axis=1).tolist())
        assert one.others == () and [s.t for s in one.segments] == [s.t for s in wanted]
        assert meet(one.start.position, start.position)
        course = given_course(rows, robot.cable_names)
        for time in (F(1, 2), F(3, 2)):
            fitting = [pose for pose in stable(robot, course.middles(time)) if fits(pose, one.segments[0])]
            assert len(fitting) >= 1
    there = motion(robot, [(0, HANGING), (10, ["3.61", "2.77", "3.17"])])
    assert there.outcome == "complete" and len(there.others) == 1


@pytest.mark.parametrize("seed", range(3))
def test_back_again_the_same_way(seed: int) -> None:
    """A course that turns round ends where it began, through the same switches in the other order."""
    rng = random.Random(seed)
    ends = [round(x + rng.uniform(-0.1, 0.1), 4) for x in (7.5, 8, 7)] + [round(rng.uniform(9.1, 9.3), 4)]
    result = motion("uc4", [(0, [7.5, 8, 7, 9.0]), (1, ends), (2, [7.5, 8, 7, 9.0])])
    assert result.outcome == "complete"
    there = [(e.cable, str(e.kind)) for e in result.events if e.t[1] <= 1.0]
    back = [(e.cable, str(e.kind)) for e in result.events if e.t[0] >= 1.0]
    turned = {"slack": "taut", "taut": "slack"}
    assert back == [(cable, turned[kind]) for cable, kind in reversed(there)]
    assert meet(result.segments[-1].tube.position, result.start.position)


def lies_in(pose: TrackedPose, stretch: Stretch) -> bool:
    """Return whether a tracked pose and its tensions are where a stretch has them."""
    pairs = (
        (pose.position, stretch.position),
        (pose.rotation, stretch.rotation),
        (pose.tensions, stretch.tensions),
    )
    return all(meet(one, other, 1e-9) for one, other in pairs)


def same_in_small_steps(robot: Robot, start: Any, before: Any, after: Any, steps: int = 60) -> int:
    """Follow a pose in one go; return on how many stretches small steps, each alone in its region, agree."""
    mover = PlatformMover(robot, start, np.stack([before, before], axis=-1))
    moved = mover.go(np.stack([after, after], axis=-1))
    assert moved.reason == "" and moved.share == 1.0
    assert moved.stretches[0].first == 0.0 and moved.stretches[-1].last == 1.0
    tracker, seen = Tracker(robot, start), set()
    for k in range(steps + 1):
        pose = tracker.update(list(before + (after - before) * (k / steps)))
        assert pose.tracked, pose.reason
        for number, one in enumerate(moved.stretches):
            if one.first <= k / steps <= one.last:
                assert lies_in(pose, one) and set(one.taut) <= set(pose.taut)
                seen.add(number)
    assert lies_in(pose, mover.here)
    return len(seen)


@pytest.mark.parametrize("seed", range(6))
def test_six_taut_cables(seed: int) -> None:
    planted = plant("general-6", seed)
    rotation, position = (np.array(x, dtype=np.float64) for x in (planted.rotation, planted.position))
    start = start_at(planted.robot, planted.taut, rotation, position, [float(t) for t in planted.tensions])
    rng = random.Random(seed)
    lengths = np.array([float(lo + hi) / 2 for lo, hi in planted.lengths])
    by = np.array([rng.uniform(-2e-4, 2e-4) for _ in lengths])
    # A motion knows the weight only.
    mass = planted.robot.platform.mass
    x, y, z = (force / mass for force in planted.load)
    robot = replace(planted.robot, gravity=(x, y, z))
    assert same_in_small_steps(robot, start, lengths, lengths + by) >= 1


@pytest.mark.parametrize(("cable", "number"), [(1, 6), (2, 11)])
def test_a_pose_turns_into_another_chart(cable: int, number: int) -> None:
    robot = load_robot("uc3")
    lengths = np.array([7.5, 8.0, 7.0])
    start = forward_kinematics(robot, lengths.tolist()).solutions[number]
    there = lengths + 0.9 * np.eye(3)[cable]
    rows = [(0, lengths.tolist()), (1, there.tolist())]
    event, trail = led(robot, rows, start)
    assert event is None
    tracker = Tracker(robot, start)
    for k in range(91):
        pose = tracker.update((lengths + (there - lengths) * (k / 90)).tolist())
        inside = [span.tube for span in trail.spans if span.begin <= F(k, 90) <= span.end]
        assert pose.tracked and inside and all(lies_in(pose, tube) for tube in inside)


def test_a_switch_in_one_go() -> None:
    robot = load_robot("uc4")
    before, after = np.array([7.5, 8, 7, 9.0]), np.array([7.5, 8, 7, 9.3])
    (start,) = stable(robot, before.tolist())
    assert same_in_small_steps(robot, start, before, after, steps=600) >= 5
