"""Answers over ranges of lengths against those for choices in them: each has one pose in every tube."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.engine.budget import Budget
from solvers import forward_kinematics
from solvers.answers.data import Answer, Outcome, Solution
from solvers.forward import pose_problem
from solvers.questions.problem import Options
from solvers.six_dof.cells.halves import cut_lengths
from solvers.six_dof.cells.subset_search import SubsetSearch
from solvers.six_dof.cells.tube import GluedTube, Tube
from solvers.six_dof.parts import parts_of
from solvers.six_dof.prepared import lengths_of
from solvers.six_dof.reduction import reduced_problems
from tests.support.planted.platform import plant
from tests.support.planted.verdict import Verdict, complaints, judge

LENGTHS = {"uc2": ["7.5", "8"], "uc3": ["7.5", "8", "7"], "uc4": ["7.5", "8", "7", "9"]}
FIELDS = ("position", "rotation", "height", "tensions", "distances")
Range = tuple[Fraction, Fraction]


def ranges(name: str, by: str) -> list[Range]:
    """Return the lengths +- by."""
    return [(Fraction(x) - Fraction(by), Fraction(x) + Fraction(by)) for x in LENGTHS[name]]


def asked(name: str, lengths: Any) -> Answer:
    return forward_kinematics(load_robot(name), lengths, taut=range(len(lengths)))


def choices(rng: random.Random, around: list[Range], count: int) -> list[list[Fraction]]:
    """Return all corners of the ranges, and some lengths inside."""
    inside = [[lo + (hi - lo) * Fraction(rng.randint(0, 64), 64) for lo, hi in around] for _ in range(count)]
    return [list(corner) for corner in product(*around)] + inside


def is_in(pose: Solution, tube: Solution) -> bool:
    """Return True when an exact pose lies in a tube's bounds in every field."""
    return all(within(getattr(pose, name), getattr(tube, name)) for name in FIELDS)


def within(inner: Any, outer: Any) -> bool:
    """Return True when bounds lie in others; those of an exact pose are as narrow as doubles make them."""
    room = 1e-12 * (1.0 + np.abs(outer).max())
    return bool(
        np.all(outer[..., 0] - room <= inner[..., 0]) and np.all(inner[..., 1] <= outer[..., 1] + room)
    )


def check_choices(name: str, by: str, inside: int, count: int) -> list[list[Solution]]:
    """Assert that every choice has its poses in the tubes, one in each; return them, tube by tube."""
    around = ranges(name, by)
    whole = asked(name, around)
    assert whole.outcome is Outcome.COMPLETE and len(whole.solutions) == count
    seen: list[list[Solution]] = [[] for _ in whole.solutions]
    for lengths in choices(random.Random(f"{name} {by}"), around, inside):
        found = asked(name, lengths)
        assert found.outcome is Outcome.COMPLETE and len(found.solutions) == count
        for pose in found.solutions:
            (k,) = [k for k, tube in enumerate(whole.solutions) if is_in(pose, tube)]
            tube = whole.solutions[k]
            assert (pose.stability, pose.cable_states) == (tube.stability, tube.cable_states)
            seen[k].append(pose)
    assert len({len(poses) for poses in seen}) == 1
    if Fraction(by) <= Fraction("0.001"):
        check_widths(whole.solutions, seen)
    return seen


def check_widths(tubes: Any, seen: list[list[Solution]]) -> None:
    """Assert that tubes are little wider than what is seen in them; what hardly moves is off as much."""
    for tube, poses in zip(tubes, seen, strict=True):
        for field in ("position", "rotation"):
            wide = np.ptp(getattr(tube, field), axis=-1)
            middles = [getattr(pose, field).mean(axis=-1) for pose in poses]
            assert np.all(wide <= 1.15 * np.ptp(middles, axis=0) + 0.05 * wide.max())


def test_uc2_has_one_pose_in_each_tube_for_every_choice() -> None:
    check_choices("uc2", "0.001", 6, 8)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "by", "count"), [("uc2", "0.003", 8), ("uc3", "0.001", 14), ("uc4", "0.001", 3)]
)
def test_every_choice_has_one_pose_in_each_tube(name: str, by: str, count: int) -> None:
    check_choices(name, by, 24, count)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "count"), [("uc3", 14), ("uc4", 3)])
def test_cutting_lengths_goes_on_until_all_is_settled(name: str, count: int) -> None:
    """+- 5 mm are too wide for tubes in one piece near the folds."""
    check_choices(name, "0.005", 4, count)


def searched(name: str, by: str, cut: bool) -> SubsetSearch:
    """Return the search of all cables taut."""
    taut = tuple(range(len(LENGTHS[name])))
    problem = pose_problem(load_robot(name), ranges(name, by), taut, None, Options())
    reduced = reduced_problems(problem.loaded, lengths_of(problem), Options(), taut)[0]
    search = SubsetSearch(reduced.model, reduced.reduction, Budget())
    search.solve()
    if cut:
        cut_lengths(search)
    return search


def test_halves_of_lengths_settle_what_the_whole_range_leaves() -> None:
    before, after = (searched("uc4", "0.005", cut) for cut in (False, True))
    assert before.left and before.reason and not after.left and not after.reason
    assert len(after.roots) == len(before.roots) and all(isinstance(root, Tube) for root in after.roots)


def test_a_zero_without_a_tube_in_one_piece_has_a_glued_one() -> None:
    before, after = (searched("uc4", "0.01", cut) for cut in (False, True))
    (glued,) = [root for root in after.roots if isinstance(root, GluedTube)]
    assert len(after.roots) == len(before.roots) + 1 and after.left < before.left
    assert len(glued.parts) >= 2 and all(part.chart == glued.chart for part in glued.parts)


def test_a_search_over_ranges_has_no_parts() -> None:
    """Parts hand over boxes of roots, and a tube is alone within its reach, not within a box."""
    options, taut = Options(), (0, 1, 2)
    robot = load_robot("uc3")
    exact = pose_problem(robot, LENGTHS["uc3"], None, None, options)
    assert len(parts_of(exact, options, taut, 4)) == 4
    ranged = pose_problem(robot, ranges("uc3", "0.001"), None, None, options)
    assert parts_of(ranged, options, taut, 4) == []


KINDS = ("general-3", "general-4", "shared-points-3", "chart-face-3", "two-cables", "large-platform-4")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("share", [Fraction(1, 10**5), Fraction(1, 2000)])
def test_a_planted_pose_is_in_a_tube_or_region(kind: str, share: Fraction) -> None:
    """Its lengths are anywhere in the ranges, also at an end."""
    rng = random.Random(f"{kind} {share}")
    for seed in range(2):
        planted = plant(kind, seed)
        lengths = []
        for lo, hi in planted.lengths:
            side, width = rng.choice([Fraction(0), Fraction(1), Fraction(rng.randint(0, 99), 99)]), share * lo
            lengths.append((lo - side * width, hi + (1 - side) * width))
        result = forward_kinematics(
            planted.robot,
            lengths,
            taut=planted.taut,
            external_force=planted.external_force,
            cell_limit=300_000,
        )
        assert complaints(planted, result) == []
        verdict = judge(planted, result)
        assert verdict is not Verdict.LOST
        assert verdict is not Verdict.PENDING or result.pending > 0


def test_plain_angles_near_a_pitch_of_a_quarter_turn_are_those_of_a_rotation() -> None:
    """The middle of a tube's bounds is no rotation."""
    planted = plant("sigma-zero-on-face-3", 1053)
    share = Fraction(1, 10**5)
    lengths = [(lo, hi + share * hi) for lo, hi in planted.lengths]
    force = planted.external_force
    result = forward_kinematics(planted.robot, lengths, taut=planted.taut, external_force=force)
    assert max(pose.nominal.rpy[1] for pose in result.solutions) > 1.57
    assert complaints(planted, result) == [] and judge(planted, result) is Verdict.FOUND
