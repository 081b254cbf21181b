"""Planted static poses of platforms are never lost, and nothing that is listed is out of balance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

from solvers import forward_kinematics
from solvers.result import Result
from tests.planted.platform import KINDS, Planted, plant
from tests.planted.rational import apply, combine, cross, dot
from tests.planted.verdict import Verdict, complaints, imbalance, judge, planted_pose

SEEDS = dict.fromkeys(KINDS, 0)
"""One robot of each kind, chosen among the first ones of its kind for a small search."""
CELL_LIMIT = 3_000_000
OPEN = {"just-tight-3"}
"""Kinds whose pose cannot be decided: a cable is exactly tight without tension."""
MAY_BE_OPEN = {
    *(f"interval-lengths-{n}" for n in (3, 4, 5, 6)),
    *(f"c-at-centre-{n}" for n in (1, 2, 3)),
    "ab-torus-2",
    "ab-torus-3",
    "ab-hook-and-rod-2",
}
"""Kinds whose pose may stay undecided: wide lengths, or another cable that is slack in a part of the family."""


def solve(planted: Planted, taut: tuple[int, ...] | None) -> Result:
    return forward_kinematics(
        planted.robot,
        planted.lengths,
        taut=taut,
        external_force=planted.external_force,
        cell_limit=CELL_LIMIT,
    )


@cache
def solved(kind: str, seed: int) -> tuple[Planted, Result]:
    planted = plant(kind, seed)
    return planted, solve(planted, planted.taut)


@pytest.mark.parametrize("kind", KINDS)
def test_a_planted_pose_is_found(kind: str) -> None:
    planted, result = solved(kind, SEEDS[kind])
    verdict = judge(planted, result)
    wanted = {Verdict.UNDECIDED} if kind in OPEN else {Verdict.FOUND}
    if kind in MAY_BE_OPEN:
        wanted.add(Verdict.UNDECIDED)
    assert verdict in wanted, (kind, SEEDS[kind], result.message)
    assert complaints(planted, result) == []


@pytest.mark.parametrize("kind", ["two-cables", "two-parallel-equal", "a-hook-2", "d-one-point-2"])
@pytest.mark.parametrize("seed", range(10, 15))
def test_cheap_kinds_over_all_subsets(kind: str, seed: int) -> None:
    planted = plant(kind, seed)
    count = len(planted.lengths)
    if count > 2:
        planted = without_slack(planted)
    result = solve(planted, None)
    assert judge(planted, result) is Verdict.FOUND, (kind, seed, result.message)
    assert complaints(planted, result) == []


def without_slack(planted: Planted) -> Planted:
    """Return the robot with its taut cables only."""
    taut = planted.taut
    robot = replace(planted.robot, cables=tuple(planted.robot.cables[i] for i in taut))
    return replace(
        planted,
        robot=robot,
        lengths=tuple(planted.lengths[i] for i in taut),
        tensions=tuple(planted.tensions[i] for i in taut),
        taut=tuple(range(len(taut))),
    )


def wrench(planted: Planted) -> Iterator[Fraction]:
    """Return the squares of force and moment left over at the planted pose, lengths to 60 decimals."""
    com = planted.robot.platform.centre_of_mass
    force, moment = planted.load, combine()
    for i in planted.taut:
        cable = planted.robot.cables[i]
        arm = apply(planted.rotation, combine((1, cable.platform_anchor), (-1, com)))
        spoke = combine(
            (1, cable.frame_anchor),
            (-1, planted.position),
            (-1, apply(planted.rotation, cable.platform_anchor)),
        )
        density = planted.tensions[i] / (sum(planted.lengths[i]) / 2)
        force = combine((1, force), (density, spoke))
        moment = combine((1, moment), (density, cross(arm, spoke)))
        lo, hi = planted.lengths[i]
        assert lo * lo <= dot(spoke, spoke) + Fraction(1, 10**50)
        assert dot(spoke, spoke) <= hi * hi + Fraction(1, 10**50)
    yield dot(force, force)
    yield dot(moment, moment)


@pytest.mark.parametrize("kind", KINDS)
def test_the_planted_poses_are_equilibria(kind: str) -> None:
    for seed in range(5):
        planted = plant(kind, seed)
        assert all(x < Fraction(1, 10**60) for x in wrench(planted))
        assert all((planted.tensions[i] > 0) == (i in planted.taut) for i in range(len(planted.lengths)))
        assert plant(kind, seed) == planted


def test_a_moved_pose_counts_as_lost() -> None:
    planted, result = solved("two-cables", SEEDS["two-cables"])
    assert judge(planted, result) is Verdict.FOUND
    x, y, z = planted.position
    moved = replace(planted, position=(x + Fraction(1, 10**5), y, z))
    assert judge(moved, result) is Verdict.LOST
    assert judge(planted, replace(result, solutions=())) is Verdict.LOST


def test_a_family_is_turned_back_before_it_is_compared() -> None:
    planted, result = solved("a-hook-2", SEEDS["a-hook-2"])
    (solution,) = (s for s in result.solutions if judge(planted, replace(result, solutions=(s,))) != "LOST")
    assert solution.family is not None
    x, y, z = planted.position
    moved = replace(planted, position=(x + Fraction(1, 10**5), y, z))
    assert judge(moved, result) is Verdict.LOST
    narrow = replace(solution.family, angle_ranges=np.zeros((1, 2, 2)))
    assert judge(planted, replace(result, solutions=(replace(solution, family=narrow),))) is Verdict.LOST


def test_a_wrong_tension_is_out_of_balance() -> None:
    planted, result = solved("two-cables", SEEDS["two-cables"])
    solution = result.solutions[0]
    rotation, position = solution.rotation.mean(axis=-1), solution.position.mean(axis=-1)
    assert list(imbalance(planted, solution, rotation, position)) == []
    wrong = replace(solution, tensions=solution.tensions * 1.001)
    assert list(imbalance(planted, wrong, rotation, position))
    assert list(imbalance(planted, solution, rotation, position + 1e-3))
    assert planted_pose(planted)[0].shape == (3, 3)
