"""Measured configurations of IRMA4U with ranges of lengths: covers, tubes, and what a pose in them is.

Data: `examples/irma4u/measured.csv`, with its source. The oracle are exact lengths drawn from the ranges: of
each, every pose must lie in an entry or a region of the answer for the ranges.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from cdpr_interval.mechanics.stability import Stability
from examples.irma4u.covers import AGREES, Measured, measured, row
from solvers import Outcome, forward_kinematics
from solvers.answers.data import CableState, Solution, StopReason
from solvers.answers.result import Result

ROBOT = "irma4u"
ALL = (0, 1, 2, 3)


def choices(one: Measured, tolerance: str, count: int, seed: int) -> Iterator[list[Fraction]]:
    """Yield exact lengths in the ranges: random ones, every other with each length at an end."""
    rng = np.random.default_rng(seed)
    for k in range(count):
        shares = rng.choice([-1, 1], 4) if k % 2 else rng.integers(-1000, 1001, 4) / 1000
        yield [
            Fraction(x) + Fraction(str(s)) * Fraction(tolerance)
            for x, s in zip(one.lengths, shares.tolist(), strict=True)
        ]


def is_held(pose: Solution, cover: Result) -> bool:
    """Return whether a pose with exact lengths lies in an entry or a region."""
    place, turn = pose.position.mean(axis=1), pose.rotation.mean(axis=2)
    for found in (*cover.solutions, *cover.undecided):
        inside = (found.position[:, 0] <= place + 1e-9) & (place - 1e-9 <= found.position[:, 1])
        turned = (found.rotation[..., 0] <= turn + 1e-9) & (turn - 1e-9 <= found.rotation[..., 1])
        if inside.all() and turned.all():
            return True
    return False


def is_cover(result: Result) -> bool:
    """Return whether nothing was left to look at."""
    return result.stop_reason is StopReason.EXHAUSTED and not result.pending


def ranges(one: Measured, tolerance: str) -> list[tuple[Fraction, Fraction]]:
    return one.ranges(Fraction(tolerance))


def test_every_pose_of_four_taut_cables_lies_in_a_small_region() -> None:
    one = measured()[7]
    cover = forward_kinematics(ROBOT, ranges(one, "0.002"), taut=ALL)
    assert is_cover(cover) and cover.undecided and not cover.verify(ROBOT)
    for region in cover.undecided:
        assert np.ptp(region.position, axis=1).max() < 0.06 and np.ptp(region.rotation, axis=2).max() < 0.2
    held = [
        is_held(pose, cover)
        for lengths in choices(one, "0.002", 3, 5)
        for pose in forward_kinematics(ROBOT, lengths, taut=ALL).solutions
    ]
    assert len(held) >= 3 and all(held)


def test_a_tube_in_many_parts_holds_one_pose_of_every_choice() -> None:
    """Four taut cables and a tenth of a millimetre: tensions change by 5 N, and one proof is not enough."""
    one = measured()[4]
    result = forward_kinematics(ROBOT, ranges(one, "0.0001"), taut=ALL)
    assert is_cover(result) and not result.verify(ROBOT)
    low = [tube for tube in result.solutions if tube.stability is Stability.STABLE]
    assert len(low) == 1 and np.ptp(low[0].tensions, axis=1).min() > 4.0 and low[0].tensions.min() > 1.0
    for lengths in choices(one, "0.0001", 4, 4):
        poses = forward_kinematics(ROBOT, lengths, taut=ALL).solutions
        assert all(is_held(pose, result) for pose in poses)
        for tube in result.solutions:
            assert tube.is_decided
            assert sum(is_held(pose, replace(result, solutions=(tube,), undecided=())) for pose in poses) == 1


def test_a_pose_that_some_choices_do_not_have_is_not_proved_to_exist() -> None:
    """A fourth cable that is long enough for some lengths only: its entry is open."""
    result = forward_kinematics(ROBOT, ranges(measured()[1], "0.002"), taut=(1, 2, 3))
    (entry,) = result.solutions
    assert CableState.UNDECIDED in entry.cable_states and not entry.is_proved and entry.note
    assert not result.verify(ROBOT)


def test_two_opposite_cables_with_ranges_have_their_pose_and_no_more() -> None:
    """Positions were once bisected without end in cells whose rotations were points."""
    result = forward_kinematics(ROBOT, ranges(measured()[4], "0.00001"), taut=(0, 2))
    assert result.outcome is Outcome.COMPLETE and len(result.solutions) == 1
    assert result.statistics.cells < 80_000


def test_a_tenth_of_a_millimetre_is_one_tube() -> None:
    """Exactly one pose for every choice, among all fifteen taut sets."""
    one = measured()[1]
    result = forward_kinematics(ROBOT, ranges(one, "0.0001"))
    assert result.outcome is Outcome.COMPLETE
    (tube,) = result.solutions
    assert tube.taut == (1, 2, 3) and np.ptp(tube.position, axis=1).max() < 1e-3
    for lengths in choices(one, "0.0001", 3, 1):
        (pose,) = forward_kinematics(ROBOT, lengths, taut=tube.taut).solutions
        assert is_held(pose, result)


@pytest.mark.slow
@pytest.mark.parametrize("k", range(8))
def test_the_cover_of_a_configuration_holds_a_pose_with_the_measured_tilt(k: int) -> None:
    """Within 2 mm of the measured lengths, and every pose of any lengths drawn lies in the cover."""
    one = measured()[k]
    found = row(one, Fraction("0.002"))
    assert found.is_cover and len(found.result.subsets) == 15 and not found.result.verify(ROBOT)
    assert found.is_proved(Fraction("0.002"))
    assert found.witness is not None and max(found.witness.roll, found.witness.pitch) < AGREES
    assert "c1 c2 c3 c4" in found.taut_sets
    for place in found.around:
        assert np.ptp(place.position, axis=1).max() < 0.06 and np.ptp(place.rotation, axis=2).max() < 0.25
    for region in found.result.undecided:
        assert np.ptp(region.position, axis=1).max() < 0.1 and np.ptp(region.rotation, axis=2).max() < 0.5
    held = [
        is_held(pose, found.result)
        for lengths in choices(one, "0.002", 8, k)
        for pose in forward_kinematics(ROBOT, lengths).solutions
    ]
    assert len(held) >= 8 and all(held)


@pytest.mark.slow
@pytest.mark.parametrize("k", [0, 3])
def test_tubes_hold_the_poses_of_least_middle_and_largest_lengths(k: int) -> None:
    """All 3^n choices of the taut cables' lengths: one pose each, in the one tube of all."""
    one = measured()[k]
    result = forward_kinematics(ROBOT, ranges(one, "0.0001"))
    assert result.outcome is Outcome.COMPLETE
    (tube,) = result.solutions
    for shares in product((-1, 0, 1), repeat=len(tube.taut)):
        lengths = [Fraction(x) for x in one.lengths]
        for i, share in zip(tube.taut, shares, strict=True):
            lengths[i] += share * Fraction("0.0001")
        (pose,) = forward_kinematics(ROBOT, lengths, taut=tube.taut).solutions
        assert is_held(pose, result)
