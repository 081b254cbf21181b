"""Entries of point masses: written for what the solver finds, refused when anything is changed."""

import copy
import random
from dataclasses import replace

import pytest
from flint import fmpq

from cdpr_interval import load_robot
from certificates.literals import exact
from certificates.point_mass import check_point
from certificates.verdicts import Malformed, NotProved
from tests.support.point_certificates import case, robot

MERLET = "2.69,3.90,3.35,4.38"
SEED = 20261123
CORNERS = [(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0)]


@pytest.fixture(scope="module")
def merlet():
    return case(load_robot("merlet_4_1"), MERLET)


def refused(found, kind=NotProved):
    with pytest.raises(kind):
        found.check()


@pytest.mark.parametrize(
    ("name", "lengths", "options", "kind"),
    [
        ("merlet_4_1", MERLET, {}, "newton"),
        ("merlet_4_1", MERLET, {"force": ("10", "-20", "5")}, "newton"),
        ("merlet_4_1", "1,1,1,1", {}, "weights"),
        ("merlet_4_1_k100", "2.9,2.9,4.1,4.1", {}, "newton"),
        ("merlet_4_1_k1000", "2.9,2.9,4.1,4.1", {"taut": (0, 1, 2, 3)}, "newton"),
        ("merlet_4_1_k100", "2.9+-0.03,2.9,4.1,4.1", {}, "parts"),
        ("merlet_4_1", MERLET, {"taut": (0, 2, 3)}, "newton"),
        ("merlet_4_1", MERLET, {"taut": (0, 2)}, "newton"),
        ("merlet_4_1", MERLET, {"taut": (0, 1, 2)}, "newton"),
        ("merlet_4_1", "3,3,3,3", {}, "duality"),
    ],
)
def test_what_the_solver_finds_is_proved(name, lengths, options, kind):
    found = case(load_robot(name), lengths, **options)
    assert found.entry["proof"]["kind"] == kind
    assert found.check() == set(range(len(found.result.solutions)))


@pytest.mark.parametrize("name", ["merlet_4_1", "merlet_4_1_k1000"])
def test_each_subset_alone(name):
    subsets = [(0,), (3,), (0, 1), (2, 3), (0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]
    proved = set()
    for subset in subsets:
        found = case(load_robot(name), MERLET, subset=subset, ignore_slack=True)
        proved |= found.check()
        own = {k for k, s in enumerate(found.result.solutions) if s.taut == subset}
        assert found.check() == own
    assert proved


def test_random_point_masses_are_proved():
    print("seed", SEED)
    rng = random.Random(SEED)
    kinds = set()
    for trial in range(40):
        count = rng.choice([1, 2, 3, 4, 6])
        exits = [[rng.uniform(-3, 3), rng.uniform(-3, 3), rng.uniform(1, 3)] for _ in range(count)]
        stiffness = [None, None, 5000, ("axial", 20000)][trial % 4]
        lengths = [f"{rng.uniform(2, 6):.3f}" + ("+-0.0005" if trial % 5 == 0 else "") for _ in exits]
        found = case(robot(exits, stiffness=stiffness), lengths)
        if found.result.outcome == "complete":
            assert found.check() == set(range(len(found.result.solutions))), (exits, lengths)
            kinds.add(found.entry["proof"]["kind"])
    assert kinds >= {"newton", "weights"}


def test_tight_cables_without_unique_tensions():
    found = case(robot([(-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0)]), ["2"] * 4)
    assert found.entry["proof"]["kind"] == "duality"
    assert found.listed[0].states == ("undecided",) * 4
    assert found.check() == {0}
    shifted = [(lo + 1e-9, hi + 1e-9) for lo, hi in found.listed[0].position]
    refused(found.other(position=shifted))
    refused(found.other(states=("taut", *["undecided"] * 3), taut=(0,)))


def test_a_tension_that_is_unique_beside_others_that_are_not():
    # Three cables in the plane y = 0 share one part of the load, the fourth alone holds against y.
    exits = [(-3, 0, 4), (0, 0, 5), (3, 0, 4), (0, 4, 3)]
    found = case(robot(exits), ["5", "5", "5", "5"], force=("0", "-30", "0"))
    assert found.entry["proof"]["kind"] == "duality"
    found = found.other(
        taut=(3,),
        states=("undecided", "undecided", "undecided", "taut"),
        tensions=[*found.listed[0].tensions[:3], (37.5 - 1e-9, 37.5 + 1e-9)],
    )
    assert found.check() == {0}
    lo, hi = found.listed[0].tensions[3]
    refused(found.other(tensions=[*found.listed[0].tensions[:3], (lo + 1e-6, hi + 1e-6)]))
    proof = {**found.entry["proof"], "normals": [None] * 4}
    refused(replace(found, entry={**found.entry, "proof": proof}))


def test_a_cable_that_is_only_just_taut():
    found = case(robot([(-3, 0, 0), (3, 0, 0), (0, 5, 3)]), ["5", "5", "74"])
    assert found.check() == {0}
    just = case(robot([(-3, 0, 0), (3, 0, 0), (0, 3, 0)]), ["5", "5", "5"])
    assert just.listed[0].states == ("taut", "taut", "undecided")
    assert just.entry["proof"]["kind"] == "newton"
    assert just.check() == {0}
    refused(just.other(states=("taut", "taut", "slack")))
    refused(just.other(states=("taut", "taut", "taut"), taut=(0, 1, 2)))


def test_taut_sets_that_change_over_a_range():
    found = case(robot([(-3, 0, 0), (3, 0, 0), (0, 3, 0)]), ["5", "5", "5+-0.001"])
    assert found.listed[0].states[2] == "undecided"
    assert set(found.entry) == {"pending"}
    start = ["0", "0.0008", "-4", "12.2", "12.2", "0.007"]
    entry = {"poses": [0], "proof": {"kind": "newton", "start": start, "scale": "1"}}
    one = found.listed[0]
    wide = {
        "position": [(lo - 0.01, hi + 0.01) for lo, hi in one.position],
        "height": (one.height[0] - 0.01, one.height[1] + 0.01),
        "tensions": [(lo - 1, hi + 1) for lo, hi in one.tensions],
        "distances": [(lo - 0.01, hi + 0.01) for lo, hi in one.distances],
    }
    found = replace(found.other(**wide), entry=entry)
    assert found.check() == {0}
    refused(found.other(states=("taut", "taut", "slack")))
    refused(found.other(states=("taut", "taut", "taut"), taut=(0, 1, 2)))


def test_dependent_subsets_alone():
    exits = [(0, 0, 0), (0, 0, 1), (2, 0, 0)]
    found = case(robot(exits), ["2", "3", "2"], subset=(0, 1), ignore_slack=True)
    assert found.entry == {"poses": [None], "proof": {"kind": "dependent"}}
    assert found.check() == set()
    refused(replace(found, taut=(0, 2)))
    refused(found.asks(ignore_slack=False))
    refused(found.asks(stiffness=[(fmpq(1000), False)] * 3))
    refused(replace(found, listed=found.listed, entry={**found.entry, "poses": [0]}))


def test_changed_problems_are_refused(merlet):
    p = merlet.problem
    for fields in (
        {"mass": p.mass, "load": [x * fmpq(1000001, 1000000) for x in p.load]},
        {"load": [p.load[0] + 1, *p.load[1:]]},
        {"lengths": [(p.lengths[0][0] + fmpq(1, 10**9),) * 2, *p.lengths[1:]]},
        {"lengths": [(p.lengths[0][0], p.lengths[0][1] + fmpq(1, 10**9)), *p.lengths[1:]]},
        {"exits": [[p.exits[0][0] + fmpq(1, 10**9), *p.exits[0][1:]], *p.exits[1:]]},
        {"centre": [fmpq(1, 10**9), fmpq(0), fmpq(0)]},
        {"gravity": [fmpq(1), fmpq(0), fmpq(-9)]},
        {"stiffness": [(fmpq(100000), False)] * 4},
        {"stiffness": [(fmpq(100000), False), None, None, None]},
        {"ignore_tension_sign": True},
        {"taut": (0, 1)},
    ):
        changed = merlet.asks(**fields)
        refused(replace(changed, taut=fields.get("taut", merlet.taut)), (NotProved, Malformed))


def test_stiffness_matters():
    found = case(load_robot("merlet_4_1_k100"), "2.9,2.9,4.1,4.1")
    k, axial = found.problem.stiffness[0]
    refused(found.asks(stiffness=[(k * 2, axial), *found.problem.stiffness[1:]]))
    refused(found.asks(stiffness=[(k, not axial), *found.problem.stiffness[1:]]))


def test_a_pose_is_not_proved_absent(merlet):
    refused(replace(merlet, entry={**merlet.entry, "poses": [None]}))
    asked = case(load_robot("merlet_4_1"), MERLET, taut=(0, 2, 3))
    refused(replace(asked, entry={**asked.entry, "poses": [None]}))
    alone = case(load_robot("merlet_4_1"), MERLET, subset=(0, 2, 3), ignore_slack=True)
    refused(replace(alone, entry={**alone.entry, "poses": [None]}))


def test_a_cable_that_may_carry_nothing_excludes_no_pose():
    just = case(robot([(-3, 0, 0), (3, 0, 0), (0, 3, 0)]), ["5", "5", "5"], taut=(0, 1))
    assert just.check() == {0}
    refused(replace(just, entry={**just.entry, "poses": [None]}))


def test_the_pose_of_other_cables_than_asked(merlet):
    for taut in ((0, 2), (0, 1, 2, 3), (1,)):
        refused(replace(merlet.asks(taut=taut), taut=taut))
    alone = merlet.asks(ignore_slack=True)
    refused(alone)


def test_empty_needs_weights_that_prove_it():
    found = case(load_robot("merlet_4_1"), "1,1,1,1")
    weights = found.entry["proof"]["weights"]
    for wrong, kind in (
        (["1", "0", "0", "0"], NotProved),
        (["0"] * 4, Malformed),
        (["-1", "0", "0", "0"], Malformed),
        (weights[:3], Malformed),
        ([*weights[:3], 1.0], Malformed),
    ):
        refused(replace(found, entry={"poses": [None], "proof": {"kind": "weights", "weights": wrong}}), kind)
    refused(found.asks(lengths=[(lo, hi + 9) for lo, hi in found.problem.lengths]))
    nested = case(robot([(0, 0, 0), (0, 0, 0)]), ["1", "3"])
    proof = {"kind": "weights", "weights": ["1", "-0.5"]}
    refused(replace(nested, entry={"poses": [None], "proof": proof}), Malformed)
    refused(found.asks(stiffness=[(fmpq(1000), False)] * 4))


def test_duality_needs_a_strictly_inner_point_and_non_negative_multipliers():
    found = case(robot(CORNERS), ["4"] * 4)
    proof = found.entry["proof"]
    assert proof["kind"] == "duality"
    outside = {**proof, "inner": ["2", "2", "-1000"]}
    corner = {**proof, "inner": ["2", "2", "0"]}
    negative = {**proof, "densities": ["-" + t if t != "0" else t for t in proof["densities"]]}
    # With these the point, the bound of its distance and the pose stay the same.
    inner = [exact(x) for x in proof["inner"]]
    aside = {**proof, "inner": [str(inner[0] + 100), str(inner[1]), str(inner[2])]}
    half = sum((exact(t) for t in proof["densities"]), fmpq(0)) / 2
    mixed = {**proof, "densities": ["-1", str(half + 1), "-1", str(half + 1)]}
    even = {**proof, "densities": ["1", str(half - 1), "1", str(half - 1)]}
    assert replace(found, entry={"poses": [0], "proof": even}).check() == {0}
    for wrong in (outside, corner, negative, aside, mixed, {**proof, "densities": ["0"] * 4}):
        refused(replace(found, entry={"poses": [0], "proof": wrong}))
    refused(replace(found, entry={"poses": [0], "proof": {**proof, "normals": []}}), Malformed)
    refused(found.asks(stiffness=[(fmpq(10**9), False)] * 4))


def test_parts_must_cover_the_range():
    found = case(load_robot("merlet_4_1_k100"), "2.9+-0.03,2.9,4.1,4.1")
    proof = found.entry["proof"]
    assert proof["kind"] == "parts"
    for change in ({"at": "3"}, {"at": "2.8"}, {"cable": 4}, {"cable": -1}, {"parts": proof["parts"][:1]}):
        refused(replace(found, entry={**found.entry, "proof": {**proof, **change}}), Malformed)
    deep = {"kind": "weights", "weights": ["1"] * 4}
    for _ in range(60):
        deep = {"kind": "parts", "cable": 0, "at": "2.9", "parts": [deep, deep]}
    refused(replace(found, entry={**found.entry, "proof": deep}), (Malformed, NotProved))
    lo, hi = found.problem.lengths[0]
    wide = [(lo - fmpq(1, 10), hi + fmpq(1, 10)), *found.problem.lengths[1:]]
    refused(found.asks(lengths=wide))


@pytest.mark.parametrize(
    "text", ["", "1_0", " 1", "nan", "inf", "1e9999", "1/0", "0x1p3", "--1", "1/-2", None, 1.5, 3]
)
def test_numbers_that_are_none(text):
    with pytest.raises(Malformed):
        exact(text)


def test_numbers():
    assert exact("-9.81") == fmpq(-981, 100)
    assert exact("1.3e6") == 1300000
    assert exact("269/100") == fmpq(269, 100)
    assert exact("1e-05") == fmpq(1, 100000)


@pytest.mark.parametrize(
    "change",
    [
        lambda e: e.pop("proof"),
        lambda e: e.update(more=1),
        lambda e: e.update(poses=[]),
        lambda e: e.update(poses=[1]),
        lambda e: e.update(poses=[-1]),
        lambda e: e.update(poses=[True]),
        lambda e: e.update(poses=0),
        lambda e: e.update(proof=None),
        lambda e: e["proof"].update(kind="faith"),
        lambda e: e["proof"].update(start=e["proof"]["start"][:-1]),
        lambda e: e["proof"].update(start=[0.5] * 7),
        lambda e: e["proof"].update(more=1),
        lambda e: e["proof"].update(scale="0"),
        lambda e: e["proof"].update(scale="-1"),
    ],
)
def test_malformed_entries(merlet, change):
    entry = copy.deepcopy(merlet.entry)
    change(entry)
    refused(replace(merlet, entry=entry), Malformed)


def test_a_bad_start_proves_nothing_false(merlet):
    print("seed", SEED)
    rng = random.Random(SEED)
    wrong = merlet.other(position=[(lo + 1e-6, hi + 1e-6) for lo, hi in merlet.listed[0].position])
    for _ in range(30):
        start = [repr(rng.uniform(-300, 300)) for _ in range(7)]
        entry = {"poses": [0], "proof": {"kind": "newton", "start": start, "scale": "1"}}
        with pytest.raises(NotProved):
            check_point(wrong.problem, wrong.taut, entry, wrong.listed)
