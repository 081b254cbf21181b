"""Attacks that once passed: a rule for a special case must ask for its premises, a loop for the time."""

from __future__ import annotations

import base64
import copy
import re
import subprocess
import sys
from dataclasses import replace
from typing import Any

import pytest
from flint import arb

import certificates
from certificates import clock
from certificates.apart import require_apart
from certificates.certificate import Certificate
from certificates.container import LIMIT, pack
from certificates.literals import exact
from certificates.point_mass import lowest_points
from certificates.problem import MOST_RANGES, read_problem, read_solutions
from certificates.root_claims import check_all_roots
from certificates.search import MOST_ROOTS
from certificates.tree import Cell, Node, decode
from certificates.turning import everywhere
from certificates.verdicts import Malformed, NotProved, Report, Verdict
from solvers.answers.data import CableState
from solvers.forward import answer_question, pose_problem
from solvers.proofs.check import difference
from solvers.proofs.document import certificate_document
from solvers.proofs.entries import subset_entries
from solvers.proofs.listed import document_candidates, hindrance
from solvers.questions.problem import Options
from tests.support import hanging_mass
from tests.support.forgeries import dropped
from tests.support.honest_certificates import CORNERS, TURNED, Document, honest, made
from tests.support.listed_bounds import at_middle, hexed, undecided, widen_all, with_hull
from tests.support.point_certificates import robot

LINE = robot([(0, 0, 0), (2, 0, 0), (4, 0, 0)], mass=1)
"""With lengths 2.5, 1.5, 2.5 the point hangs on all three cables, whose wrenches are dependent."""
COUNTS = re.compile(r"\d+ static|no static|no other")


def report(document: Document, **options: Any) -> Report:
    return certificates.check(pack(document), **options)


def roots_of(document: Document, k: int) -> list[Document]:
    """Return the roots that point to a solution."""
    searches = [search for entry in document["subsets"] for search in entry.get("searches", [])]
    return [root for search in searches for root in search["roots"] if root["pose"] == k]


def single(document: Document) -> int:
    """Return the first solution without a family."""
    return next(k for k, s in enumerate(document["solutions"]) if s["family"] is None)


def test_a_pose_is_not_dropped_as_the_end_of_a_family():
    document = made("swing, ranges").document
    assert report(document).complete and len(document["solutions"]) == 3
    less = copy.deepcopy(document)
    k = single(less)
    for root in roots_of(less, k):
        root["end"] = 0
    less = dropped(less, k)
    found = report(less)
    assert found.verdict is Verdict.MALFORMED and "end" in found.message
    assert report(dropped(document, k)).verdict is Verdict.NOT_PROVED


def test_files_of_before_have_a_null_there():
    document = copy.deepcopy(made("swing").document)
    for root in (r for k in range(4) for r in roots_of(document, k)):
        root["end"] = None
    assert report(document).complete


def test_dependent_says_nothing_of_the_one_subset_asked_for():
    asked = honest(LINE, ["2.5", "1.5", "2.5"], "c0,c1,c2", ignore_slack=True).document
    proof = {"poses": [None], "proof": {"kind": "dependent"}}
    assert asked["subsets"][0].get("point") != proof
    forged = {**asked, "solutions": [], "not_certified": [], "subsets": [{"taut": [0, 1, 2], "point": proof}]}
    assert report(forged).verdict is Verdict.NOT_PROVED
    every = honest(LINE, ["2.5", "1.5", "2.5"], ignore_slack=True).document
    assert every["subsets"][-1] == {"taut": [0, 1, 2], "point": proof}


def test_ranges_of_angles_are_looked_at_with_slackness_ignored():
    document = copy.deepcopy(made("swing, asked").document)
    assert report(document).complete
    for ranges in ([], [[hexed(0, 0), hexed(3, 3)]]):
        document["solutions"][0]["family"]["angle_ranges_rad"] = ranges
        assert report(document).verdict is Verdict.NOT_PROVED


def test_three_poses_of_three_subsets_in_one_entry_are_not_counted():
    document = made("point, each subset").document
    shared = dropped(dropped(with_hull(with_hull(document, 0, 1), 0, 2), 2, 0), 1, 0)
    found = report(undecided(shared, 0))
    assert found.verdict is Verdict.PROVED and not found.complete and not COUNTS.search(found.message)
    assert report(shared).verdict is Verdict.NOT_PROVED


def test_one_family_for_each_subset_is_not_counted():
    platform = robot([(0, 0, 0), (2, 0, 0), (4, 0, 0)], [(0, 0, 0.5)] * 3)
    document = honest(platform, ["2.5", "1.5", "2.5"]).document
    assert document["solutions"] and all(s["family"] for s in document["solutions"])
    entries = [entry["point"]["poses"] for entry in document["subsets"] if "point" in entry]
    for poses in entries:
        for i, k in enumerate(poses):
            if k is not None:
                document["solutions"].append(copy.deepcopy(document["solutions"][k]))
                poses[i] = len(document["solutions"]) - 1
    used = {k for poses in entries for k in poses if k is not None}
    for k in sorted({*range(len(document["solutions"]))} - used, reverse=True):
        document = dropped(document, k)
    found = report(document)
    assert found.verdict is Verdict.PROVED and len(document["solutions"]) > 2
    assert not found.complete and not COUNTS.search(found.message)


def test_a_root_without_width_holds_nothing():
    document = made("three cables").document
    for entries in (range(6), [0], [5]):
        found = copy.deepcopy(document)
        root = roots_of(found, 0)[0]
        widen_all(found["solutions"][0])
        for k in entries:
            place = root["u" if k < 3 else "x"]
            place[k % 3] = at_middle(place[k % 3])
        assert report(found).verdict is Verdict.MALFORMED


@pytest.mark.parametrize("name", ["swing, each subset", "swing", "slings", "all rotations"])
def test_families_are_told_apart_from_each_other_and_from_single_poses(name):
    document = made(name).document
    problem = read_problem(document)
    listed = read_solutions(document, problem)
    require_apart(problem, listed)
    family = next(s for s in listed if s.family is not None)
    for other in (family, replace(family, family=None)):
        with pytest.raises(NotProved):
            require_apart(problem, [family, other])
        require_apart(problem, [family, replace(other, states=("undecided",) * len(other.states))])


def test_a_pose_beside_a_family_is_written_and_proved():
    # The second cable carries 9e-13 N: the pose is 1e-12 from one of the family, which it does not belong to.
    document = honest(TURNED, ["3", "6.103277807865"]).document
    found = report(document)
    assert found.verdict is Verdict.PROVED and found.message.startswith("3 static poses (2 with a family)")


def test_one_pose_of_two_subsets_is_listed_once():
    found = honest(robot(CORNERS), ["4"] * 4, ignore_slack=True).document
    twice = copy.deepcopy(made("point, each subset"))
    same = replace(twice.truth.solutions[1], taut=(0,), cable_states=twice.truth.solutions[0].cable_states)
    problem = pose_problem(hanging_mass.robot(), ["2", "3"], None, None, Options(ignore_slack=True))
    result = replace(twice.truth, solutions=(*twice.truth.solutions, same))
    reasons = [reason for _, reason in document_candidates(problem, result)]
    assert reasons == [None, None, None, "it may be the same as another solution"]
    assert report(found).verdict is Verdict.PROVED


def test_a_family_listed_at_another_angle_is_the_same():
    document = made("slings").document
    problem = read_problem(document)
    first = next(s for s in read_solutions(document, problem) if s.family is not None)
    # A half turn about z through the exit points, at x = y = 0.
    turned = replace(
        first,
        position=[(-hi, -lo) for lo, hi in first.position[:2]] + first.position[2:],
        rotation=[[(-hi, -lo) for lo, hi in row] for row in first.rotation[:2]] + first.rotation[2:],
    )
    with pytest.raises(NotProved, match="1 and 2"):
        require_apart(problem, [first, turned])


def test_what_a_file_is_about_is_printed_as_it_stands_there():
    document = copy.deepcopy(made("swing, asked").document)
    document["robot"] |= {"name": 'good"\u00e9, proved', "sha256": "ab"}
    lines = report(document).lines()
    assert lines[0].startswith("PROVED: 2 static poses")
    assert lines[1] == 'robot "good\\"\\u00e9, proved", sha256 "ab"'
    assert lines[2] == "lengths_m c0 3, c1 5"
    assert lines[3] == "external_force_N 0, 0, 0; subset c0, slackness ignored"
    assert report({**document, "solutions": []}).lines()[1] == lines[1]
    ranges = report(made("swing, ranges").document).lines()
    assert ranges[2] == "lengths_m c0 3, c1 6.1..6.1028" and ranges[3].endswith("; all subsets")


def test_a_sample_is_not_drawn_by_the_file():
    document = made("swing").document
    seeds = {report(document, sample=5).seed for _ in range(4)}
    assert len(seeds) > 1
    one, two = (report(document, sample=5, seed=7) for _ in range(2))
    assert one.seed == 7 and one.parts == two.parts and one.verdict is Verdict.SAMPLED


def test_every_loop_asks_for_the_time():
    certificate = Certificate(pack(made("swing").document))
    searches = certificate.searches(2)
    cell = Cell(0, ((-1.0, 1.0),) * 3)
    with clock.seconds(-1.0):
        for work in (
            lambda: check_all_roots(searches, certificate.solutions),
            lambda: searches.tally(),
            lambda: searches.check((0, next(decode(bytes([Node.NO_POSITION]), cell, 3.0, False)))),
            lambda: everywhere(lambda a, b: True, arb(0), arb(1)),
            lambda: list(lowest_points(certificate.problem, (0,), {"kind": "weights", "weights": ["1"]})),
        ):
            with pytest.raises(clock.OutOfTime):
                work()


def test_the_numbers_of_roots_and_ranges_are_limited():
    document = copy.deepcopy(made("swing").document)
    roots = next(e for e in document["subsets"] if "searches" in e)["searches"][0]["roots"]
    roots += [roots[0]] * MOST_ROOTS
    assert f"more than {MOST_ROOTS} roots" in report(document).message
    document = copy.deepcopy(made("swing").document)
    family = next(s["family"] for s in document["solutions"] if s["family"])
    family["angle_ranges_rad"] *= MOST_RANGES + 1
    assert f"more than {MOST_RANGES} ranges" in report(document).message


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"claim": "x" * LIMIT}, "too large"),
        ({"not_certified": [[]] * (LIMIT // 40)}, "too many values"),
        ({"not_certified": [{}] * (LIMIT // 40)}, "too many values"),
    ],
)
def test_a_small_file_takes_no_more_memory_than_a_gigabyte(change, message, tmp_path):
    path = tmp_path / "bomb.cert"
    path.write_bytes(pack({**made("point").document, **change}))
    assert path.stat().st_size < 200_000
    code = (
        "import resource, sys, certificates\n"
        "resource.setrlimit(resource.RLIMIT_AS, (2**30, 2**30))\n"
        "print(certificates.check(sys.argv[1]).lines()[0])"
    )
    done = subprocess.run([sys.executable, "-c", code, path], capture_output=True, text=True, timeout=100)
    assert done.stdout.startswith("MALFORMED: ") and message in done.stdout, done


def test_a_large_tree_takes_no_more_memory_than_its_text():
    def halves(splits: int) -> bytes:
        return bytes([splits % 3]) + 2 * halves(splits - 1) if splits else bytes([Node.UNDECIDED])

    start = Cell(0, ((-1.0, 1.0),) * 3)
    leaves = decode(halves(16), start, 3.0, False)
    import tracemalloc

    tracemalloc.start()
    assert sum(1 for _ in leaves) == 2**16
    assert tracemalloc.get_traced_memory()[1] < 2**20
    tracemalloc.stop()


@pytest.mark.parametrize("name", ["a and of all others", "", "1a", "a,b", "\u00e4", "a\u00a0b", "a" * 101])
def test_the_name_of_a_cable_does_not_speak(name):
    document = copy.deepcopy(made("point").document)
    document["robot"]["cables"][0]["name"] = name
    assert report(document).verdict is Verdict.MALFORMED
    document["robot"]["cables"][0]["name"] = "Rope_1.a-b"
    assert report(document).complete


@pytest.mark.parametrize("text", ["1/" + "0" * 5000 + "7", "1/01", "1/" + "9" * 400])
def test_long_fractions_are_malformed(text):
    with pytest.raises(Malformed):
        exact(text)


def test_the_slackness_of_a_family_is_that_of_all_its_poses():
    document = copy.deepcopy(made("swing, asked").document)
    assert [s["slack_respected"] for s in document["solutions"]] == [False, False]
    document["solutions"][0]["slack_respected"] = True
    assert report(document).verdict is Verdict.NOT_PROVED


def test_a_family_without_a_sharp_rotation_has_no_angles():
    document = copy.deepcopy(made("swing").document)
    k = next(k for k, s in enumerate(document["solutions"]) if s["family"])
    wide = [[[(-1.0).hex(), (1.0).hex()]] * 3] * 3
    document["solutions"][k] |= {"rotation": wide, "stability": "undecided"}
    found = report(document)
    assert found.verdict is Verdict.NOT_PROVED and "no rotation from which angles count" in found.message


def test_what_is_switching_is_written_as_undecided_and_counts_as_open():
    options = Options()
    made_of = robot([(0, 0, 0), (4, 0, 0)])
    problem = pose_problem(made_of, ["2", "5"], None, None, options)
    result = answer_question(problem, options)
    states = (CableState.TAUT, CableState.SWITCHING)
    switching = replace(result, solutions=(replace(result.solutions[0], cable_states=states),))
    entries = subset_entries(problem, options, switching)
    document = certificate_document(problem, options, switching, entries)
    assert document["solutions"][0]["states"] == ["taut", "undecided"]
    found = report(document)
    assert found.verdict is Verdict.PROVED and not found.complete and not COUNTS.search(found.message)
    assert difference(made_of, switching, pack(document)) == ""


def test_a_pose_whose_existence_is_undecided_is_not_listed_as_a_pose():
    options = Options()
    result = answer_question(
        pose_problem(robot([(0, 0, 0), (4, 0, 0)]), ["2", "5"], None, None, options), options
    )
    solution = copy.copy(result.solutions[0])
    assert hindrance(solution) is None
    object.__setattr__(solution, "existence", "undecided")
    assert hindrance(solution) == "its existence is not proved"


def test_a_tree_is_no_other_text():
    document = copy.deepcopy(made("swing").document)
    search = next(e for e in document["subsets"] if "searches" in e)["searches"][0]
    for text in ("!", None, 5, base64.b64encode(b"").decode()):
        search["trees"][0] = text
        assert report(document).verdict is Verdict.MALFORMED
