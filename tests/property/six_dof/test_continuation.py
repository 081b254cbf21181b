"""Poses that are followed from the last lengths to new ones: by exact answers there, and by small steps."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.robots.cable_robot import Robot
from solvers import forward_kinematics
from solvers.answers.data import CableState, Solution
from solvers.six_dof import continuation
from solvers.six_dof.tracked_pose import TrackedPose
from solvers.six_dof.tracker import Tracker
from solvers.six_dof.way import Known, Way
from tests.support.kernel_callers import Callers
from tests.support.planted.platform import plant
from tests.support.tracked_region import start_at

called = Callers(continuation)
UC3, UC4 = [7.5, 8.0, 7.0], [7.5, 8.0, 7.0, 9.0]
NO_REGION = 1e-9
"""A radius in m that no pose stays within: all are followed."""


def stable(robot: Robot, lengths: Any) -> Solution:
    (found,) = [s for s in forward_kinematics(robot, lengths).solutions if s.stability == "stable"]
    return found


def same(pose: TrackedPose, s: Solution) -> bool:
    """Return whether an exact pose lies in a tracked one's bounds, as far as these are known."""
    return all(
        bool(((x[..., 0] <= y[..., 1] + 1e-12) & (y[..., 0] - 1e-12 <= x[..., 1])).all())
        for x, y in (
            (pose.position, s.position),
            (pose.rotation, s.rotation),
            (pose.tensions, s.tensions),
            (pose.distances, s.distances),
        )
    )


def planar_walk(seed: int, count: int, step: float) -> list[list[float]]:
    """Return lengths of UC4 around a place where its fourth cable becomes slack."""
    rng, lengths, walk = random.Random(seed), [*UC4[:3], 9.19], []
    for _ in range(count):
        cable = rng.randrange(4)
        lengths[cable] += rng.choice((-1.0, 1.0)) * step
        walk.append(list(lengths))
    return walk


@pytest.mark.parametrize("seed", range(2))
def test_the_stable_pose_is_followed_through_cables_that_switch(seed: int) -> None:
    robot = load_robot("uc4")
    tracker = Tracker(robot, stable(robot, [*UC4[:3], 9.19]))
    switched = 0
    for lengths in planar_walk(seed, 25, 0.02):
        pose = tracker.update(lengths)
        assert pose.tracked, pose.reason
        wanted = stable(robot, lengths)
        assert same(pose, wanted) and pose.taut == wanted.taut and pose.states == wanted.cable_states
        assert np.ptp(pose.position, axis=1).max() < 1e-6
        switched += len(pose.switching)
    assert switched >= 1


@pytest.mark.parametrize("number", range(14))
def test_large_steps_lead_where_small_ones_do(number: int) -> None:
    """Each small one is proved by a region."""
    robot = load_robot("uc3")
    start = forward_kinematics(robot, UC3).solutions[number]
    rng, followed = random.Random(number), 0
    for _ in range(3):
        by = np.array([rng.uniform(-0.05, 0.05) for _ in UC3])
        small = Tracker(robot, start, follow=False)
        pose = Tracker(robot, start).update(list(UC3 + by))
        for k in range(1, 201):
            last = small.update(list(UC3 + by * (k / 200)))
            if not last.tracked:
                break
        if pose.tracked and last.tracked:
            followed += pose.pieces > 0
            assert pose.taut == last.taut
            assert (pose.position[:, 0] <= last.position[:, 1]).all()
            assert (last.position[:, 0] <= pose.position[:, 1]).all()
            assert (pose.rotation[..., 0] <= last.rotation[..., 1]).all()
            assert (last.rotation[..., 0] <= pose.rotation[..., 1]).all()
        # A cable that may switch in all poses near: then neither goes on.
        assert pose.tracked or not last.tracked
    assert followed >= 1


@pytest.mark.parametrize(("l4", "half"), [(9.0, 0.005), (9.19, 0.005), (9.214, 0.003), (9.23, 0.003)])
def test_ranges_hold_the_pose_of_every_choice(l4: float, half: float) -> None:
    robot = load_robot("uc4")
    begin = [*UC4[:3], 9.1]
    start = stable(robot, begin)
    middle = [7.51, 7.995, 7.005, l4]
    tracker = Tracker(robot, start, radius=NO_REGION)
    pose = tracker.update([(x - half, x + half) for x in middle])
    assert pose.tracked, pose.reason
    rng, states = random.Random(1), set()
    for k in range(12):
        signs = [rng.choice((-1, 1)) if k < 6 else rng.uniform(-1, 1) for _ in middle]
        choice = [x + s * half for x, s in zip(middle, signs, strict=True)]
        wanted = stable(robot, choice)
        assert same(pose, wanted)
        states.add(wanted.cable_states[3])
        for own, state in zip(pose.states, wanted.cable_states, strict=True):
            assert own in (state, CableState.SWITCHING)
        one = Tracker(robot, start).update(choice)
        assert one.tracked and same(one, wanted)
    if len(states) > 1:
        assert pose.states[3] == "switching" and pose.tensions[3, 0] == 0.0 and 3 not in pose.taut
        assert pose.stability == "stable"
    # It goes on from there, whatever the choice was.
    again = tracker.update([*UC4[:3], 9.1])
    assert again.tracked and same(again, start)


def test_a_pose_ends_at_its_fold() -> None:
    robot = load_robot("uc2")
    for s in forward_kinematics(robot, [7.5, 7.374]).solutions[2:4]:
        tracker = Tracker(robot, s)
        assert tracker.update([7.5, 7.34]).tracked
        for second in (7.3295, 7.32, 7.0):
            pose = tracker.update([7.5, second])
            assert not pose.tracked and pose.reason and pose.estimate is not None
        assert tracker.update([7.5, 7.374]).tracked


def nonsmooth() -> Robot:
    """Return a robot of which two poses, with and without cable c3, meet and end."""
    cables = [
        {"name": f"c{i + 1}", "frame_anchor_m": a, "platform_anchor_m": b}
        for i, (a, b) in enumerate(
            [
                ([5.41, 9.7, 0.25], [1.25, -1.38, 0.09]),
                ([2.77, 5.16, 0.55], [-0.12, -1.31, 0.42]),
                ([1.61, 1.16, 0.23], [1.06, 0.28, -0.72]),
            ]
        )
    ]
    platform = {"mass_kg": 1, "centre_of_mass_m": [0, 0, 0]}
    document = {"format": "cdpr-robot/1", "name": "fold", "platform": platform, "cables": cables}
    return Robot.from_dict({**document, "gravity_m_s2": [0, 0, -9.81]})


def test_a_pose_ends_where_two_taut_sets_meet() -> None:
    robot = nonsmooth()
    ended = 0
    for s in forward_kinematics(robot, ["9.22", "7.4", "6.30"]).solutions:
        tracker = Tracker(robot, s)
        pose = tracker.update([9.22, 7.4, 6.28])
        ends = s.taut == (0, 1) or s.taut == (0, 1, 2)
        assert pose.tracked != ends
        ended += ends
        if ends:
            assert "cable c3" in pose.reason
            assert tracker.update([9.22, 7.4, 6.31]).tracked
        else:
            found = forward_kinematics(robot, [9.22, 7.4, 6.28], taut=s.taut).solutions
            assert sum(same(pose, one) for one in found) == 1
    assert ended == 2


@pytest.mark.parametrize("seed", range(6))
def test_six_taut_cables_are_followed(seed: int) -> None:
    planted = plant("general-6", seed)
    rotation, position = (np.array(x, dtype=np.float64) for x in (planted.rotation, planted.position))
    start = start_at(planted.robot, planted.taut, rotation, position, [float(t) for t in planted.tensions])
    rng = random.Random(seed)
    lengths = np.array([float(lo + hi) / 2 for lo, hi in planted.lengths])
    by = np.array([rng.uniform(-2e-4, 2e-4) for _ in lengths])
    force = planted.external_force
    tracker = Tracker(planted.robot, start, radius=NO_REGION)
    pose = tracker.update(list(lengths + by), force)
    small = Tracker(planted.robot, start)
    for k in range(1, 51):
        last = small.update(list(lengths + by * (k / 50)), force)
    assert pose.tracked and last.tracked and pose.taut == last.taut == planted.taut and pose.pieces > 0
    assert (pose.position[:, 0] <= last.position[:, 1]).all()
    assert (last.position[:, 0] <= pose.position[:, 1]).all()
    back = tracker.update(list(lengths), force)
    assert back.tracked
    assert (back.position[:, 0] <= position + 1e-9).all() and (position - 1e-9 <= back.position[:, 1]).all()


@pytest.mark.parametrize(("cable", "number"), [(1, 6), (2, 11)])
@pytest.mark.parametrize("radius", [None, NO_REGION])
def test_a_pose_is_followed_into_another_chart(cable: int, number: int, radius: float | None) -> None:
    robot = load_robot("uc3")
    lengths = list(UC3)
    tracker = Tracker(robot, forward_kinematics(robot, lengths).solutions[number], radius=radius)
    charts = set()
    for _ in range(18):
        lengths[cable] += 0.05
        pose = tracker.update(lengths)
        assert pose.tracked, pose.reason
        charts.add(tracker._place.chart)
    assert sum(same(pose, s) for s in forward_kinematics(robot, lengths).solutions) == 1
    assert len(charts) == 2


def test_another_pose_is_never_taken_for_the_last_one() -> None:
    """Whatever the floats are near to: what is proved of the last pose decides."""
    robot = load_robot("uc3")
    first, second = forward_kinematics(robot, UC3).solutions[:2]
    tracker, other = (Tracker(robot, s, radius=NO_REGION) for s in (first, second))
    assert tracker.update([7.501, 8.0, 7.0]).tracked and other.update([7.501, 8.0, 7.0]).tracked
    known, wrong = tracker._place.way.known, other._place.way.known
    honest = known.zero
    for zero in (wrong.zero, honest + np.eye(9)[3] * 1e-2, honest + np.eye(9)[7], honest * np.nan):
        known.zero = zero
        pose = tracker.update([7.502, 8.0, 7.0])
        assert not pose.tracked and "may be another one" in pose.reason
    known.zero = honest
    assert tracker.update([7.502, 8.0, 7.0]).tracked


def test_a_pose_under_another_force_is_not_followed() -> None:
    robot = load_robot("uc4")
    tracker = Tracker(robot, stable(robot, UC4), radius=NO_REGION)
    assert tracker.update([7.51, 8.0, 7.0, 9.0]).tracked
    pose = tracker.update([7.52, 8.0, 7.0, 9.0], (1.0, 0.0, 0.0))
    assert not pose.tracked and "the force is not that of the last pose" in pose.reason
    assert tracker.update([7.52, 8.0, 7.0, 9.0]).tracked


def test_pieces_hold_the_straight_ways_between_all_choices() -> None:
    rng = random.Random(7)
    for _ in range(300):
        before, after = (sorted(rng.uniform(0.1, 20.0) for _ in range(2)) for _ in range(2))
        if rng.random() < 0.4:
            after = [before[0] + 1e-3 * rng.random(), before[1] + 1e-3]
        if rng.random() < 0.3:
            before[1] = before[0]
        if rng.random() < 0.2:
            after = list(before)
        first, last = sorted(rng.choice((0.0, 1.0, rng.random())) for _ in range(2))
        lo, hi = called.piece_of_way(np.array([before]), np.array([after]), first, last, 0)
        a = [Fraction(x) for x in before]
        b = [Fraction(x) for x in after]
        for share in (Fraction(first), Fraction(last), Fraction(first + last) / 2):
            for x in a:
                for y in b:
                    assert lo <= x + share * (y - x) <= hi
        widest = max(before[1], after[1]) - min(before[0], after[0])
        assert hi - lo <= widest + 1e-12


def test_what_a_way_tells() -> None:
    robot = load_robot("uc4")
    tracker = Tracker(robot, stable(robot, [*UC4[:3], 9.2]))
    pose = tracker.update([*UC4[:3], 9.25])
    assert pose.region is None and pose.pieces > 1 and pose.switching == (3,)
    assert pose.states[3] == "slack" and pose.taut == (0, 1, 2) and pose.stability == "stable"
    back = tracker.update([*UC4[:3], 9.2])
    assert back.switching == (3,) and back.taut == (0, 1, 2, 3) and back.states[3] == "taut"
    tracker.update([*UC4[:3], 9.2])
    near = tracker.update([*UC4[:3], 9.2])
    assert near.region is not None and near.pieces == 0 and near.switching == ()


@pytest.mark.parametrize("l4", [9.3, 9.211, 9.19, 9.15])
def test_a_start_with_a_slack_cable_that_is_wound_in(l4: float) -> None:
    robot = load_robot("uc4")
    start = stable(robot, [*UC4[:3], 9.3])
    assert start.taut == (0, 1, 2)
    lengths = [7.5, 8.0, 7.0, l4]
    pose = Tracker(robot, start, radius=NO_REGION).update(lengths)
    assert pose.tracked and same(pose, stable(robot, lengths))


def test_a_lost_first_call_is_forgotten() -> None:
    robot = load_robot("uc4")
    tracker = Tracker(robot, stable(robot, UC4), radius=NO_REGION)
    assert not tracker.update([1.0, 1.0, 1.0, 1.0]).tracked
    assert not tracker.update([7.5, 8.0, 7.0, (8.0, 10.0)], (1.0, 0.0, 0.0)).tracked
    pose = tracker.update([7.51, 8.0, 7.0, 9.3])
    assert pose.tracked and pose.taut == (0, 1, 2)
    # What is proved by a region names the cables in the same order.
    back = Tracker(robot, stable(robot, [*UC4[:3], 9.3]))
    for l4 in (9.3, 9.1, 9.1, 9.1):
        pose = back.update([*UC4[:3], l4])
    assert pose.region is not None and pose.taut == (0, 1, 2, 3)


def test_taut_cables_are_in_file_order_after_a_switch() -> None:
    robot = load_robot("uc4")
    names = [robot.cables[i] for i in (3, 0, 1, 2)]
    turned = replace(robot, cables=tuple(names))
    tracker = Tracker(turned, stable(turned, [9.3, *UC4[:3]]))
    for l4 in (9.3, 9.1, 9.1, 9.1):
        pose = tracker.update([l4, *UC4[:3]])
        assert pose.tracked and list(pose.taut) == sorted(pose.taut)
    assert pose.region is not None and pose.taut == (0, 1, 2, 3)


def test_regions_are_measured_by_all_cables() -> None:
    """Of the taut cables alone the platform may be small."""
    robot = load_robot("cogiro")
    far = replace(robot.cables[7], platform_anchor=(Fraction(5), Fraction(0), Fraction(0)))
    wide = replace(robot, cables=(*robot.cables[:7], far))
    tracker = Tracker(wide)
    z = np.ones(14)
    way = Way(wide, Known((0, 1), z, np.ones((8, 2)), np.ones((3, 2)), z, z), tracker.size)
    assert tracker.size > Tracker(robot).size
    assert way.model(tuple(range(8)), 2, np.ones((3, 2))).size == tracker.size
