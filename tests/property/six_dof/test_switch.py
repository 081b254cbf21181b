"""One cable just taut or just slack: exactly one pose for every choice of lengths, or no claim."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.robots.formats.reader import parse_robot
from solvers import forward_kinematics
from solvers.answers.data import CableState, Outcome


def within(inner, outer):
    return bool(np.all(outer[..., 0] <= inner[..., 0]) and np.all(inner[..., 1] <= outer[..., 1]))


def just_tight():
    """Return UC3's poses on two cables with the third cable's distance there."""
    solved = forward_kinematics(load_robot("uc3"), ["7.5", "8", "20"])
    return [float(s.distances[2].mean()) for s in solved.solutions if s.taut == (0, 1)]


DISTANCES = just_tight()


@pytest.mark.parametrize("k", range(len(DISTANCES)))
def test_a_cable_that_just_becomes_taut_switches(k):
    length = repr(DISTANCES[k])
    solved = forward_kinematics(load_robot("uc3"), ["7.5", "8", length])
    (entry,) = [s for s in solved.solutions if not s.is_strict]
    assert entry.cable_states == (CableState.TAUT, CableState.TAUT, CableState.SWITCHING)
    assert entry.is_proved and solved.outcome is Outcome.COMPLETE
    assert all(subset.outcome is Outcome.COMPLETE for subset in solved.subsets)
    assert solved.verify(load_robot("uc3")) == []


@pytest.mark.parametrize("k", [0, 1, 6, 7])
def test_exactly_one_pose_for_every_length_of_a_range(k):
    middle, half = Fraction(DISTANCES[k]), Fraction(1, 100_000)
    robot = load_robot("uc3")
    solved = forward_kinematics(robot, ["7.5", "8", (middle - half, middle + half)])
    (entry,) = [s for s in solved.solutions if CableState.SWITCHING in s.cable_states]
    assert entry.is_proved
    carried = set()
    for step in range(-4, 5):
        exact = forward_kinematics(robot, ["7.5", "8", middle + half * step / 4])
        inside = [s for s in exact.solutions if within(s.position, widened(entry.position))]
        (one,) = [s for s in inside if within(s.rotation, widened(entry.rotation))]
        assert within(one.tensions, widened(entry.tensions))
        carried.add(2 in one.taut)
    assert carried == {True, False}


def widened(bounds):
    """Return bounds with room for the width of an exact pose's own: with a slack cable it is at an end."""
    return bounds + 1e-13 * np.array([-1.0, 1.0])


FOLD = parse_robot(
    b"format: cdpr-robot/1\nname: fold\nplatform: {mass_kg: 1}\ncables:\n"
    b"  - {name: c1, frame_anchor_m: [5.41, 9.7, 0.25], platform_anchor_m: [1.25, -1.38, 0.09]}\n"
    b"  - {name: c2, frame_anchor_m: [2.77, 5.16, 0.55], platform_anchor_m: [-0.12, -1.31, 0.42]}\n"
    b"  - {name: c3, frame_anchor_m: [1.61, 1.16, 0.23], platform_anchor_m: [1.06, 0.28, -0.72]}\n"
)
MIDDLE = Fraction("6.28929407838707190678")


def test_two_poses_on_one_side_and_none_on_the_other_are_not_claimed():
    """A fold that is not smooth: with a shorter third cable there is no pose there, with a longer one two."""
    counts = []
    for shift in (-1, 1):
        exact = forward_kinematics(FOLD, ["9.22", "7.4", MIDDLE + shift * Fraction(1, 10**5)])
        assert exact.outcome is Outcome.COMPLETE
        counts.append(sum(s.is_proved for s in exact.solutions if s.taut in ((0, 1), (0, 1, 2))))
    assert abs(counts[0] - counts[1]) == 2
    for half in (0, Fraction(1, 10**6)):
        solved = forward_kinematics(FOLD, ["9.22", "7.4", (MIDDLE - half, MIDDLE + half)])
        loose = [s for s in solved.solutions if not s.is_strict]
        assert loose and not any(s.is_proved for s in loose)
        assert solved.outcome is Outcome.INCOMPLETE
        strict = [s for s in solved.solutions if s.is_strict]
        assert solved.message.startswith(f"finished: {len(strict)} static poses proved")


TWO_NEAR = parse_robot(
    b"format: cdpr-robot/1\nname: two-near\nplatform: {mass_kg: 1}\ncables:\n"
    b"  - {name: c1, frame_anchor_m: [-1, 0, 1.5], platform_anchor_m: [-0.5, 0, -0.2]}\n"
    b"  - {name: c2, frame_anchor_m: [1, 0, 1.5], platform_anchor_m: [0.5, 0, -0.2]}\n"
    b"  - {name: c3, frame_anchor_m: [-1.28, -1.24, 1.91], platform_anchor_m: [-0.25, -0.3, 0.15]}\n"
    b"  - {name: c4, frame_anchor_m: [-0.39, -1.59, 1.8], platform_anchor_m: [-0.35, -0.37, -0.45]}\n"
)


def test_a_pose_beside_with_one_more_cable_taut_is_not_lost():
    """Two poses 11 um apart: the third cable switches at both, the fourth is taut at one of them."""
    lengths = ["1.772004514666935", "1.772004514666935", None, "2.559789147"]
    middle, half = Fraction("2.2454620905283615"), Fraction(4, 10**7)
    lengths[2] = (middle - half, middle + half)
    solved = forward_kinematics(TWO_NEAR, lengths)
    near = [s for s in solved.solutions if np.abs(np.array(s.nominal.position)).max() < 1e-3]
    assert [s.cable_states[3] for s in near] == [CableState.TAUT, CableState.SLACK]
    for step in (-1, 0, 1):
        exact = forward_kinematics(TWO_NEAR, [*lengths[:2], middle + half * step, lengths[3]])
        assert exact.outcome is Outcome.COMPLETE
        assert len(exact.solutions) == len(solved.solutions)
        for pose in exact.solutions:
            held = [
                s
                for s in solved.solutions
                if within(pose.position, s.position) and within(pose.rotation, s.rotation)
            ]
            assert len(held) == 1
