"""Trackers of platforms on pulleys and elastic cables, held against Newton's method in floats."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from cdpr_interval.errors import CdprError, InputError, NotSupportedError
from cdpr_interval.mechanics.loaded import NO_FORCE
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Robot
from solvers import Tracker
from solvers.answers.data import CableState
from solvers.six_dof.over_pulleys import stability_at
from solvers.six_dof.real.tracking import Tracking
from solvers.winches.where import enclosed
from tests.support.planted.pulleys import Floats, Planted, plant
from tests.support.real_oracle import Body, Oracle, robot_of, start_of

NEAR = 1e-8
"""Errors of the poses in floats."""
CASES = [(0, 3, 0.0), (5, 4, 0.0), (1, 5, 0.0), (2, 5, 1e-3), (5, 6, 1e-3)]


def planted_start(seed: int, count: int, compliance: float) -> tuple[Planted, Robot, Floats, Body]:
    planted = plant(seed, count)
    robot = robot_of(planted, 1.0 / compliance if compliance else None)
    lengths = planted.lengths - compliance * planted.tensions
    return (
        planted,
        robot,
        lengths,
        Body(planted.position, planted.rotation, tuple(range(count)), planted.tensions),
    )


@pytest.mark.parametrize(("seed", "count", "compliance"), CASES)
def test_each_call_encloses_the_pose_of_its_lengths(seed: int, count: int, compliance: float) -> None:
    planted, robot, lengths, body = planted_start(seed, count, compliance)
    tracker, oracle = Tracker(robot, start_of(planted, robot, lengths)), Oracle(planted, compliance)
    rng = np.random.default_rng(seed)
    way = 0.08 * rng.uniform(-1.0, 1.0, count)
    way[rng.integers(count)] += 0.16
    for k in range(1, 21):
        now = lengths + way * k / 20
        pose = tracker.update(now)
        found = oracle.settled(body, now)
        assert pose.tracked, pose.reason
        assert found is not None
        body = found
        assert pose.region is None and pose.pieces >= 1
        assert pose.taut == body.taut and str(pose.stability) == "stable"
        assert all((state is CableState.TAUT) == (i in body.taut) for i, state in enumerate(pose.states))
        tensions = np.zeros(count)
        tensions[list(body.taut)] = body.tensions
        for bounds, value, off in (
            (pose.position, body.position, NEAR),
            (pose.rotation, body.rotation, NEAR),
            (pose.tensions, tensions, 1e-5),
            (pose.distances, oracle.paths(body)[0], NEAR),
        ):
            assert ((bounds[..., 0] - off <= value) & (value <= bounds[..., 1] + off)).all()
            assert (bounds[..., 1] - bounds[..., 0]).max() < 1e-6


def test_ranges_enclose_every_choice_and_what_is_lost_stays_where_it_was() -> None:
    planted, robot, lengths, body = planted_start(1, 5, 0.0)
    tracker, oracle = Tracker(robot, start_of(planted, robot, lengths)), Oracle(planted)
    assert tracker.update(lengths).tracked
    pose = tracker.update(np.stack([lengths - 1e-5, lengths + 1e-5], axis=1))
    assert pose.tracked and pose.taut == (0, 1, 2, 3, 4)
    rng = np.random.default_rng(1)
    for _ in range(20):
        found = oracle.settled(body, lengths + 1e-5 * rng.uniform(-1.0, 1.0, 5))
        assert found is not None
        assert ((pose.position[:, 0] <= found.position) & (found.position <= pose.position[:, 1])).all()
    lost = tracker.update(np.stack([lengths - 0.05, lengths + 0.05], axis=1))
    assert not lost.tracked and lost.reason and lost.estimate is None
    with pytest.raises(CdprError):
        _ = lost.position
    assert tracker.update(lengths).taut == (0, 1, 2, 3, 4)


def test_another_force_is_another_pose() -> None:
    planted, robot, lengths, body = planted_start(0, 3, 0.0)
    start = start_of(planted, robot, lengths)
    tracker = Tracker(robot, start)
    assert tracker.update(lengths).tracked
    lost = tracker.update(lengths, external_force=[1, 0, 0])
    assert not lost.tracked and "force" in lost.reason
    assert tracker.update(lengths).tracked
    # From a start of another load goes on what is next to it under this one.
    found = Tracker(robot, start).update(lengths, external_force=[1, 0, 0])
    pushed_body = Oracle(replace(planted, load=planted.load + np.array([1.0, 0.0, 0.0]))).settled(
        body, lengths
    )
    assert found.tracked and pushed_body is not None
    assert np.abs(np.subtract(found.point, pushed_body.position)).max() < NEAR
    assert np.abs(np.subtract(found.point, body.position)).max() > 1e-4


def test_measured_lengths_are_enclosed_piece_by_piece() -> None:
    """What `winch where` says of a pose for ranges that no one proof covers."""
    planted, robot, lengths, body = planted_start(1, 5, 0.0)
    start, half = start_of(planted, robot, lengths), 2e-4
    ranges = [(x - half, x + half) for x in lengths.tolist()]
    assert not Tracker(robot, start).update(np.array(ranges)).tracked
    found = enclosed(robot, start, ranges)
    assert found is not None and found.taut == (0, 1, 2, 3, 4)
    rng, oracle = np.random.default_rng(3), Oracle(planted)
    for _ in range(30):
        pose = oracle.settled(body, lengths + half * rng.choice([-1.0, 1.0], 5))
        assert pose is not None and pose.taut == found.taut
        for bounds, value in ((found.position, pose.position), (found.tensions, pose.tensions)):
            assert ((bounds[:, 0] <= value) & (value <= bounds[:, 1])).all()
    assert enclosed(robot, start, [(x - 0.05, x + 0.05) for x in lengths.tolist()]) is None


def test_wrong_starts_are_refused() -> None:
    planted, robot, lengths, _ = planted_start(0, 3, 0.0)
    start = start_of(planted, robot, lengths)
    with pytest.raises(InputError, match="start: must be a Solution"):
        Tracker(robot, "here")
    with pytest.raises(InputError, match="start: has 3 cables, the robot 4"):
        Tracker(planted_start(0, 4, 0.0)[1], start)
    with pytest.raises(NotSupportedError, match="follow"):
        Tracker(robot, start, follow=False)
    # Of another robot with as many cables: no pose is proved there.
    assert not Tracker(planted_start(1, 3, 0.0)[1], start).update(lengths).tracked


@pytest.mark.parametrize(("seed", "stiffness"), [(9, 15.0), (18, 30.0)])
def test_stability_is_that_of_the_robot_not_of_its_start(seed: int, stiffness: float) -> None:
    """The same pose is stable on stiff cables and unstable on soft ones."""
    planted = plant(seed, 6)
    start = start_of(planted, robot_of(planted, 1e6), planted.lengths - planted.tensions / 1e6)
    assert start.stability is Stability.STABLE
    pose = Tracker(robot_of(planted, stiffness), start).update(planted.lengths - planted.tensions / stiffness)
    assert pose.tracked and pose.stability is Stability.UNSTABLE


def test_a_first_call_under_a_wrong_force_is_forgotten() -> None:
    planted = plant(1, 5)
    tracker = Tracker(robot_of(planted), start_of(planted, robot_of(planted), planted.lengths))
    assert not tracker.update(planted.lengths, external_force=[2, 0, 0]).tracked
    assert tracker.update(planted.lengths).tracked


def test_an_interrupted_way_leaves_the_pose_where_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    planted = plant(1, 5)
    robot = robot_of(planted)
    judge = partial(stability_at, robot, NO_FORCE)
    tracking = Tracking(robot, NO_FORCE, start_of(planted, robot, planted.lengths), judge)
    follower = tracking._follower
    bounds = np.stack([planted.lengths, planted.lengths], axis=1)
    assert tracking.update(bounds).here is not None
    known, lengths = follower.known, follower.lengths
    legs: list[int] = []
    original = follower._leg

    def interrupted(*arguments: Any) -> Any:
        legs.append(0)
        if len(legs) == 4:
            raise KeyboardInterrupt
        return original(*arguments)

    monkeypatch.setattr(follower, "_leg", interrupted)
    with pytest.raises(KeyboardInterrupt):
        tracking.update(bounds - 0.02)
    assert len(legs) == 4 and follower.known is known and follower.lengths is lengths
