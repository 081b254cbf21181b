"""`fk` against the independent oracle of ``tests/oracle``: a fixed sample, and that the oracle can fail.

``make fuzz`` asks new questions for as long as wanted.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from cdpr_interval.robots.formats.reader import parse_robot
from solvers import forward_kinematics
from tests.oracle.compare import Verdict, compare
from tests.oracle.model import Case
from tests.oracle.problems import KINDS, problem
from tests.oracle.subsets import StaticPose, find_poses

Document = dict[str, Any]
CELLS = 300_000
"""The sample is bounded by cells, not by time, so that it is the same on every machine."""
STARTS = 100
QUICK = [
    ("large", 1),
    ("near_fold", 2),
    ("point_mass", 1),
    ("elastic", 2),
    ("ranges", 1),
    ("general", 2),
    ("one_point", 1),
    ("asked", 1),
]
SLOW = [(kind, seed) for seed in (1, 2, 3) for kind in KINDS if (kind, seed) not in QUICK]


@cache
def answered(kind: str, seed: int) -> tuple[Case, Document]:
    case = problem(kind, seed)
    result = forward_kinematics(
        parse_robot(case.robot_yaml().encode()),
        [lo if lo == hi else (lo, hi) for lo, hi in case.lengths],
        taut=case.taut,
        ignore_slack=case.ignore_slack,
        external_force=case.force,
        cell_limit=CELLS,
    )
    return case, result.to_dict()


def verdict(case: Case, document: Document, seed: int = 0) -> Verdict:
    poses = found_poses(case) if case.exact and seed == 0 else None
    return compare(case, document, np.random.default_rng(seed), starts=STARTS, poses=poses)


@cache
def found_poses(case: Case) -> list[StaticPose]:
    """What the oracle finds does not depend on what is listed: once is enough."""
    return find_poses(case, np.random.default_rng(0), STARTS)


def agree(kind: str, seed: int) -> None:
    case, document = answered(kind, seed)
    found = verdict(case, document, seed).contradictions
    assert not found, "\n".join([f"{kind} {seed}", *found, case.robot_yaml(), case.command("FILE")])


@pytest.mark.parametrize(("kind", "seed"), QUICK)
def test_the_oracle_agrees(kind: str, seed: int) -> None:
    agree(kind, seed)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), SLOW)
def test_the_oracle_agrees_with_the_whole_sample(kind: str, seed: int) -> None:
    agree(kind, seed)


ISOLATED, FAMILY, RANGE, POINT = ("general", 2), ("one_point", 1), ("ranges", 1), ("point_mass", 1)


@pytest.mark.parametrize("which", [ISOLATED, FAMILY, RANGE, POINT], ids=lambda which: which[0])
def test_the_oracle_finds_what_is_listed(which: tuple[str, int]) -> None:
    """Otherwise it would agree with everything."""
    case, document = answered(*which)
    assert document["outcome"] == "complete"
    assert verdict(case, document).found >= len(document["solutions"]) > 0


@pytest.mark.parametrize("which", [ISOLATED, FAMILY, RANGE, POINT], ids=lambda which: which[0])
def test_a_missing_pose_is_noticed(which: tuple[str, int]) -> None:
    case, document = answered(*which)
    for k in range(len(document["solutions"])):
        less = {**document, "solutions": document["solutions"][:k] + document["solutions"][k + 1 :]}
        assert any("MISSING" in c for c in verdict(case, less).contradictions)


def test_a_pose_may_lie_in_an_undecided_region_or_be_pending() -> None:
    case, document = answered(*ISOLATED)
    first, *others = document["solutions"]
    region = {"taut": first["taut"], "position_m": first["position_m"], "rotation": first["rotation"]}
    less = {**document, "solutions": others, "outcome": "incomplete"}
    assert not verdict(case, {**less, "undecided": [region]}).contradictions
    assert not verdict(case, {**less, "pending": 1}).contradictions
    elsewhere = {**region, "position_m": [[x + 0.1 for x in pair] for pair in region["position_m"]]}
    assert verdict(case, {**less, "undecided": [elsewhere]}).contradictions


def moved(bounds: list[list[float]], by: float) -> list[list[float]]:
    return [[lo + by, hi + by] for lo, hi in bounds]


def another_taut_set(entry: Document) -> None:
    k = entry["cable_states"].index("taut")
    entry["cable_states"][k] = "slack"
    entry["tensions_N"][k] = [0.0, 0.0]


def swapped_stability(entry: Document) -> None:
    entry["stability"] = "unstable" if entry["stability"] == "stable" else "stable"


def another_place(entry: Document) -> None:
    entry["position_m"] = moved(entry["position_m"], 1e-6)


def another_rotation(entry: Document) -> None:
    entry["rotation"] = [moved(row, 1e-6) for row in entry["rotation"]]


def other_tensions(entry: Document) -> None:
    entry["tensions_N"] = moved(entry["tensions_N"], 1e-3)


def other_distances(entry: Document) -> None:
    entry["distances_m"] = moved(entry["distances_m"], 1e-6)


LIES: list[Callable[[Document], None]] = [
    another_taut_set,
    swapped_stability,
    another_place,
    another_rotation,
    other_tensions,
    other_distances,
]


@pytest.mark.parametrize("lie", LIES, ids=lambda lie: lie.__name__)
def test_a_lie_about_a_pose_is_noticed(lie: Callable[[Document], None]) -> None:
    case, document = answered(*ISOLATED)
    for k in range(len(document["solutions"])):
        false = copy.deepcopy(document)
        lie(false["solutions"][k])
        assert verdict(case, false).contradictions, k


@pytest.mark.parametrize("lie", [another_taut_set, swapped_stability, another_place, other_tensions])
def test_a_lie_about_a_family_is_noticed(lie: Callable[[Document], None]) -> None:
    case, document = answered(*FAMILY)
    false = copy.deepcopy(document)
    lie(false["solutions"][0])
    # Families are compared in floats, to 1e-7.
    if lie is another_place:
        false["solutions"][0]["position_m"] = moved(document["solutions"][0]["position_m"], 1e-3)
    assert verdict(case, false).contradictions


def test_a_phantom_is_noticed() -> None:
    case, document = answered(*ISOLATED)
    phantom = copy.deepcopy(document["solutions"][0])
    another_place(phantom)
    phantom["nominal"]["position_m"] = [x + 1e-6 for x in phantom["nominal"]["position_m"]]
    more = {**document, "solutions": [*document["solutions"], phantom]}
    assert any("PHANTOM" in c for c in verdict(case, more).contradictions)


@pytest.mark.parametrize("which", [ISOLATED, FAMILY], ids=lambda which: which[0])
def test_a_pose_listed_twice_is_noticed(which: tuple[str, int]) -> None:
    case, document = answered(*which)
    twice = {**document, "solutions": [*document["solutions"], document["solutions"][0]]}
    assert any("TWICE" in c for c in verdict(case, twice).contradictions)


@pytest.mark.parametrize("part", [0.5, 1.5])
def test_wrong_angles_of_a_family_are_noticed(part: float) -> None:
    """Ranges half as long leave poses out; longer ones hold poses at which a cable is too short."""
    case, document = answered("planar", 9)
    false = copy.deepcopy(document)
    ends = [s for s in false["solutions"] if s["family"] and full_turns(s["family"]) < 0.9]
    assert ends
    for solution in ends:
        ranges = solution["family"]["angle_ranges_rad"]
        solution["family"]["angle_ranges_rad"] = [
            [[part * x for x in end] for end in pair] for pair in ranges
        ]
    assert verdict(case, false).contradictions
    assert not verdict(case, document).contradictions


def full_turns(family: Document) -> float:
    return sum(end[1] - start[0] for start, end in family["angle_ranges_rad"]) / (2 * np.pi)


def test_a_tube_that_holds_one_choice_only_is_noticed() -> None:
    case, document = answered(*RANGE)
    false = copy.deepcopy(document)
    for bounds in false["solutions"][0]["position_m"]:
        bounds[:] = [0.5 * (bounds[0] + bounds[1])] * 2
    assert any("NO POSE" in c for c in verdict(case, false).contradictions)
