"""Poses followed for every choice of all data: planted exact robots stay inside, switches included."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.robots.cable_robot import Robot
from solvers import Tracker, forward_kinematics
from solvers.six_dof.estimate import Body, estimate
from solvers.six_dof.place import guess_of, place_of
from tests.unit.motions.test_motion import with_ranges

SEED = 20261129


def choice(robot: Robot, rng: np.random.Generator, is_corner: bool) -> Robot:
    """Return an exact robot within the ranges of one."""

    def of(value: object) -> object:
        if isinstance(value, list):
            return ends(value) if len(value) == 2 else [of(x) for x in value]
        if isinstance(value, dict):
            return {key: of(x) for key, x in value.items()}
        return value

    def ends(pair: list[object]) -> float:
        lo, hi = (Fraction(str(x)) for x in pair)
        share = Fraction(int(rng.integers(2))) if is_corner else Fraction(float(rng.random()))
        # The nearest double may lie outside by rounding, as far as the assertions below allow.
        return float(lo + share * (hi - lo))

    found = of(robot.to_dict())
    assert isinstance(found, dict)
    return Robot.from_dict(found)


def beginning(exact: Robot, start: Robot, lengths: list[float]) -> Tracker:
    """Return a tracker of an exact robot, at its pose near the one stable pose of another robot."""
    (stable,) = [s for s in forward_kinematics(start, lengths).solutions if str(s.stability) == "stable"]
    guess = guess_of(place_of(Body(start), stable))
    load = np.array([float(x) for x in loaded(exact).load])
    found, _ = estimate(Body(exact), guess, np.array(lengths), load)
    return Tracker(exact, found)


CASES = {
    "small": ("uc4", "1e-4", [0.99, 1.01], [7.5, 8.0, 7.0, 9.0], 5e-4, 12),
    "points to a millimetre": ("uc4", "1e-3", None, [7.5, 8.0, 7.0, 9.0], 5e-4, 12),
    "with a switch": ("uc4", "1e-4", [0.9, 1.2], [7.5, 8.0, 7.0, 9.205], 1e-4, 24),
    "at a switch": ("uc4", "2e-4", None, [7.5, 8.0, 7.0, 9.21], 1e-4, 24),
}


@pytest.mark.parametrize("case", CASES)
def test_every_choice_stays_inside(case: str) -> None:
    name, width, mass, begin, half, steps = CASES[case]
    middle, vague = load_robot(name), with_ranges(name, width, mass)
    rng = np.random.default_rng(SEED)
    (stable,) = [s for s in forward_kinematics(middle, begin).solutions if str(s.stability) == "stable"]
    tracker = Tracker(vague, stable)
    exact = [choice(vague, rng, k % 2 == 0) for k in range(6)]
    others = [beginning(one, middle, begin) for one in exact]
    lengths, switched = np.array(begin), set()
    for k in range(steps):
        lengths = lengths.copy()
        if case.endswith("switch"):
            # To and fro across the switch, while another cable moves a little.
            lengths[3] += 4e-3 * (1.0 if k % 12 < 6 else -1.0)
            lengths[rng.integers(3)] += 1e-3 * rng.choice([-1.0, 1.0])
        else:
            lengths[rng.integers(len(lengths))] += 5e-3 * rng.choice([-1.0, 1.0])
        pose = tracker.update(np.stack([lengths - half, lengths + half], axis=1))
        assert pose.tracked, pose.reason
        switched |= set(pose.switching)
        for other in others:
            chosen = other.update((lengths + half * rng.choice([-1.0, 1.0], size=len(lengths))).tolist())
            assert chosen.tracked, chosen.reason
            for wide, narrow in (
                (pose.position, chosen.position),
                (pose.rotation, chosen.rotation),
                (pose.tensions, chosen.tensions),
                (pose.height, chosen.height),
            ):
                assert (wide[..., 0] <= narrow[..., 1] + 1e-12).all()
                assert (narrow[..., 0] <= wide[..., 1] + 1e-12).all()
            assert set(pose.taut) <= set(chosen.taut) or chosen.switching
    assert bool(switched) == case.endswith("switch")


def test_a_range_of_the_mass_alone_moves_no_pose() -> None:
    lengths = [7.5, 8.0, 7.0, 9.0]
    tracked = [Tracker(robot).update(lengths) for robot in (load_robot("uc4"), with_ranges("uc4", 0, [1, 2]))]
    exact, vague = tracked
    assert np.allclose(exact.position, vague.position, atol=1e-12)
    assert np.allclose(vague.tensions, exact.tensions * [1.0, 2.0], rtol=1e-9)


def test_a_way_may_end_where_a_cable_switches_and_go_on_both_ways() -> None:
    """For some choices the cable is taut there, for others slack; what goes on is the pose of each."""
    vague, at = with_ranges("uc4", "2e-4"), [7.5, 8.0, 7.0, 9.2177]
    for last, taut in ((9.19, (0, 1, 2, 3)), (9.25, (0, 1, 2))):
        tracker = Tracker(vague)
        assert tracker.update([7.5, 8.0, 7.0, 9.19]).taut == (0, 1, 2, 3)
        there = tracker.update(at)
        assert there.tracked and there.switching == (3,) and there.taut == (0, 1, 2)
        still = tracker.update(at)
        assert still.tracked and still.switching == (3,) and np.allclose(still.position, there.position)
        pose = tracker.update([7.5, 8.0, 7.0, last])
        assert pose.tracked and pose.taut == taut


def test_a_force_may_be_a_range() -> None:
    lengths = [7.5, 8.0, 7.0, 9.0]
    tracker, exact = Tracker("uc4"), Tracker("uc4")
    wide = tracker.update(lengths, ["-0.001..0.001", 0, 0])
    assert wide.tracked
    for force in (-0.001, 0.0, 0.001):
        pose = Tracker("uc4").update(lengths, [force, 0.0, 0.0])
        assert (wide.position[:, 0] <= pose.position[:, 0]).all()
        assert (pose.position[:, 1] <= wide.position[:, 1]).all()
    assert exact.update(lengths).tracked


def test_a_way_goes_on_in_another_chart() -> None:
    """Radii of ranges are far from 0: what is known of a pose is not much less where the chart changes."""
    document, turn = load_robot("uc4").to_dict(), 1.4
    for cable in document["cables"]:
        x, y, z = map(float, cable["platform_anchor_m"])
        x, z = np.cos(turn) * x + np.sin(turn) * z, np.cos(turn) * z - np.sin(turn) * x
        cable["platform_anchor_m"] = [{"value": round(v, 6), "tolerance": "5e-4"} for v in (x, y, z)]
    vague, lengths = Robot.from_dict(document), np.array([7.5, 8.0, 7.0, 9.0])
    found = forward_kinematics(vague.middle(), lengths.tolist(), taut=range(4)).solutions
    (stable,) = [s for s in found if str(s.stability) == "stable"]
    tracker, charts = Tracker(vague, stable), set()
    for _ in range(12):
        lengths += [-0.02, 0.02, 0.0, 0.0]
        pose = tracker.update(np.stack([lengths - 1e-4, lengths + 1e-4], axis=1))
        assert pose.tracked, pose.reason
        assert tracker._place is not None
        charts.add(tracker._place.chart)
    assert len(charts) == 2
