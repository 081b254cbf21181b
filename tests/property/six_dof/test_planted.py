"""A fixed sample of platforms with planted static poses, one robot of every kind: none may be lost."""

from __future__ import annotations

import pytest

from solvers import forward_kinematics
from tests.support.planted.platform import KINDS, plant
from tests.support.planted.verdict import Verdict, complaints, judge

SEED = 20261122
CELL_LIMIT = 150_000
"""Keeps the sample within three minutes; a robot that needs more ends pending, which is no loss."""


@pytest.mark.parametrize("kind", KINDS)
def test_the_planted_pose_is_not_lost(kind: str) -> None:
    """The planted pose is found, or the result says truthfully that it is not finished."""
    planted = plant(kind, SEED)
    print(f"kind {kind}, seed {SEED}")
    result = forward_kinematics(
        planted.robot,
        planted.lengths,
        taut=planted.taut,
        external_force=planted.external_force,
        cell_limit=CELL_LIMIT,
    )
    assert complaints(planted, result) == []
    verdict = judge(planted, result)
    assert verdict is not Verdict.LOST
    assert verdict is not Verdict.PENDING or result.pending > 0


SMALL_KINDS = ("two-cables", "two-parallel-equal", "a-hook-2", "b-rod-2", "d-one-point-1", "d-one-point-2")
"""Kinds whose searches are one-dimensional: they must be found, whatever the machine."""


@pytest.mark.parametrize("kind", SMALL_KINDS)
@pytest.mark.parametrize("seed", range(4))
def test_small_searches_find_the_planted_pose(kind: str, seed: int) -> None:
    """No budget is needed here, so nothing but the pose itself will do."""
    planted = plant(kind, seed)
    result = forward_kinematics(
        planted.robot, planted.lengths, taut=planted.taut, external_force=planted.external_force
    )
    assert complaints(planted, result) == []
    assert judge(planted, result) is Verdict.FOUND
