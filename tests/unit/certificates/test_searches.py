"""Certificates of searches: honest ones are proved; whatever is taken away, moved or made up is refused."""

import base64
import copy
import random
import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flint import ctx

from cdpr_interval import load_robot
from cdpr_interval.engine.rows import UNBALANCED
from certificates import check, leaves, searches
from certificates.arithmetic.balls import BITS
from certificates.certificate import Certificate
from certificates.container import pack
from certificates.root_claims import check_all_roots
from certificates.tree import Node
from certificates.verdicts import NotProved, Verdict
from solvers import forward_kinematics
from solvers.answers.result import Result
from solvers.forward import answer_question, pose_problem
from solvers.proofs.document import certificate_document
from solvers.proofs.entries import subset_entries
from solvers.proofs.recorder import Recorder
from solvers.proofs.tree import Cell, Trees
from solvers.questions.problem import Options, Problem
from solvers.six_dof.record import Record
from tests.support import plain_certificate_reader as reader
from tests.support import point_certificates
from tests.support.honest_certificates import TURNED, made

LENGTHS = "7.5,8"
"""Of uc2: eight poses, all with both cables taut."""
SEED = 20261123


def solved(robot: str, lengths: str, taut: str | None = None) -> tuple[Problem, Options, Result]:
    """Return a question, its options with the searches kept, and the answer."""
    options = Options(record=Record())
    problem = pose_problem(load_robot(robot), lengths, taut, None, options)
    return problem, options, answer_question(problem, options)


def document_of(problem: Problem, options: Options, result: Result) -> dict[str, Any]:
    """Return the certificate of an answer."""
    return certificate_document(problem, options, result, subset_entries(problem, options, result))


@pytest.fixture(scope="module")
def uc2() -> dict[str, Any]:
    """The certificate of all subsets of uc2."""
    return document_of(*solved("uc2", LENGTHS))


def verdict(folder: Path, document: dict[str, Any]) -> Verdict:
    """Return what the checker says of a document whose digest is right."""
    path = folder / "made.cert"
    path.write_bytes(pack(document))
    report = check(path)
    assert report.complete <= (report.verdict is Verdict.PROVED)
    return report.verdict


def refused(folder: Path, document: dict[str, Any]) -> bool:
    """Return True when a document is not proved, not even in part."""
    return verdict(folder, document) in (Verdict.NOT_PROVED, Verdict.MALFORMED)


def test_an_honest_certificate_is_proved_and_a_plain_reader_counts_its_leaves(
    uc2: dict[str, Any], tmp_path: Path
):
    path = tmp_path / "uc2.cert"
    path.write_bytes(pack(uc2))
    report = check(path)
    assert report.verdict is Verdict.PROVED and report.complete and report.solutions == 8
    plain = reader.trees(reader.read(path))
    assert sum(len(reader.leaves(tree)) for tree in plain) == report.leaves > 50
    assert sum(map(len, plain)) < 40 * report.leaves
    assert all(report.parts >= report.checked == report.leaves for _ in plain)


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield where the lists of a document that are not empty are."""
    if isinstance(value, list) and value:
        yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield from places(inner, (*path, key))


def at(document: Any, path: tuple[Any, ...]) -> Any:
    """Return the value at a place."""
    for key in path:
        document = document[key]
    return document


def test_every_list_made_shorter_is_refused(uc2: dict[str, Any], tmp_path: Path):
    paths = list(places(uc2))
    assert len(paths) > 250
    for path in paths:
        if path[0] == "not_certified":
            continue
        for end in (0, -1):
            changed = copy.deepcopy(uc2)
            del at(changed, path)[end]
            assert refused(tmp_path, changed), (path, end)


def number(text: str) -> Fraction:
    """Return the value of an exact number."""
    return Fraction(text)


def nudged(text: str) -> str:
    """Return an exact number a little larger."""
    return str(Fraction(text) + Fraction(1, 10**6))


DATA = [
    ("robot", "mass_kg"),
    ("robot", "gravity_m_s2", 2),
    ("external_force_N", 0),
    *(("robot", "centre_of_mass_m", k) for k in range(3)),
    *(
        ("robot", "cables", i, key, k)
        for i in (0, 1)
        for key in ("frame_anchor_m", "platform_anchor_m")
        for k in range(3)
    ),
]


@pytest.mark.parametrize("path", DATA, ids=str)
def test_other_data_of_the_robot_are_refused(uc2: dict[str, Any], path: tuple[Any, ...], tmp_path: Path):
    changed = copy.deepcopy(uc2)
    at(changed, path[:-1])[path[-1]] = nudged(at(uc2, path))
    assert refused(tmp_path, changed)


@pytest.mark.parametrize("cable", [0, 1])
@pytest.mark.parametrize("end", [0, 1])
def test_other_lengths_are_refused(uc2: dict[str, Any], cable: int, end: int, tmp_path: Path):
    changed = copy.deepcopy(uc2)
    changed["lengths_m"][cable] = [nudged(v) for v in uc2["lengths_m"][cable]]
    assert refused(tmp_path, changed)
    changed["lengths_m"][cable] = list(uc2["lengths_m"][cable])
    value = number(uc2["lengths_m"][cable][end]) + Fraction(2 * end - 1, 10**6)
    changed["lengths_m"][cable][end] = str(value)
    assert refused(tmp_path, changed)


def moved(bounds: list[str], by: float) -> list[str]:
    """Return bounds with both ends moved."""
    return [(float.fromhex(v) + by).hex() for v in bounds]


BOXES = ["position_m", "height_m", "tensions_N", "distances_m", "rotation"]


@pytest.mark.parametrize("key", BOXES)
@pytest.mark.parametrize("solution", range(8))
def test_bounds_beside_the_pose_are_refused(uc2: dict[str, Any], key: str, solution: int, tmp_path: Path):
    changed = copy.deepcopy(uc2)
    listed = changed["solutions"][solution]
    if key == "height_m":
        listed[key] = moved(listed[key], 1e-6)
    elif key == "rotation":
        listed[key][1][0] = moved(listed[key][1][0], 1e-6)
    else:
        listed[key][0] = moved(listed[key][0], -1e-6)
    assert refused(tmp_path, changed)


OTHER = [
    ("stability", "stable"),
    ("stability", "unstable"),
    ("states", ["taut", "slack"]),
    ("taut", [0]),
    ("slack_respected", False),
    (
        "family",
        {"kind": "all-rotations", "axis_point_m": None, "axis_direction": None, "angle_ranges_rad": []},
    ),
]


@pytest.mark.parametrize(("key", "value"), OTHER, ids=str)
def test_other_claims_are_refused(uc2: dict[str, Any], key: str, value: Any, tmp_path: Path):
    for k, listed in enumerate(uc2["solutions"]):
        if listed[key] != value:
            changed = copy.deepcopy(uc2)
            changed["solutions"][k][key] = value
            assert refused(tmp_path, changed), k


def test_a_tension_of_the_other_sign_is_refused(uc2: dict[str, Any], tmp_path: Path):
    changed = copy.deepcopy(uc2)
    lo, hi = changed["solutions"][3]["tensions_N"][1]
    changed["solutions"][3]["tensions_N"][1] = [(-float.fromhex(v)).hex() for v in (hi, lo)]
    assert refused(tmp_path, changed)


def test_a_solution_taken_out_or_listed_twice_is_refused(uc2: dict[str, Any], tmp_path: Path):
    for k in range(8):
        changed = copy.deepcopy(uc2)
        del changed["solutions"][k]
        for search in changed["subsets"][2]["searches"]:
            for root in search["roots"]:
                pose = root["pose"]
                root["pose"] = None if pose == k else pose - 1 if pose > k else pose
        assert refused(tmp_path, changed)
    changed = copy.deepcopy(uc2)
    changed["solutions"].append(copy.deepcopy(changed["solutions"][0]))
    assert refused(tmp_path, changed)
    search = next(s for s in changed["subsets"][2]["searches"] if any(r["pose"] == 0 for r in s["roots"]))
    again = copy.deepcopy(next(r for r in search["roots"] if r["pose"] == 0))
    search["roots"].append({**again, "pose": 8})
    assert refused(tmp_path, changed)


def widened(bounds: list[str], factor: float) -> list[str]:
    """Return bounds with another width about the same middle."""
    lo, hi = map(float.fromhex, bounds)
    middle, half = (lo + hi) / 2, (hi - lo) / 2 * factor
    return [(middle - half).hex(), (middle + half).hex()]


@pytest.mark.parametrize("search", [0, 1])
def test_root_boxes_beside_the_root_or_around_two_are_refused(
    uc2: dict[str, Any], search: int, tmp_path: Path
):
    for k, root in enumerate(uc2["subsets"][2]["searches"][search]["roots"]):
        for key, place, change in (
            ("u", 1, lambda b: moved(b, 2.0)),
            ("x", 0, lambda b: moved(b, 1.0)),
            ("u", 1, lambda b: widened(b, 100.0)),
            ("x", 2, lambda b: widened(b, -1.0)),
            ("u", 0, lambda b: ["-0x1p-30", "0x1p-30"]),
        ):
            changed = copy.deepcopy(uc2)
            other = changed["subsets"][2]["searches"][search]["roots"][k]
            other[key][place] = change(root[key][place])
            assert refused(tmp_path, changed), (k, key)


def test_a_listed_box_wider_than_the_root_s_is_refused(uc2: dict[str, Any], tmp_path: Path):
    changed = copy.deepcopy(uc2)
    changed["solutions"][0]["position_m"] = [widened(b, 1e14) for b in changed["solutions"][0]["position_m"]]
    assert refused(tmp_path, changed)


def with_tree(
    document: dict[str, Any], search: int, chart: int, change: Callable[[bytes], bytes]
) -> dict[str, Any]:
    """Return a document with another tree."""
    changed = copy.deepcopy(document)
    trees = changed["subsets"][-1]["searches"][search]["trees"]
    trees[chart] = base64.b64encode(change(base64.b64decode(trees[chart]))).decode()
    return changed


def inner(tree: bytes) -> list[int]:
    """Return where splits are below which there is a root."""
    found = []
    for place in reader.nodes(tree):
        part = tree[place : reader.subtree(tree, place)]
        if tree[place] < 6 and Node.ROOT in reader.leaves(part):
            found.append(place)
    return found


def without(tree: bytes, place: int, instead: bytes) -> bytes:
    """Return a tree with something instead of a subtree."""
    return tree[:place] + instead + tree[reader.subtree(tree, place) :]


def swapped(tree: bytes, place: int) -> bytes:
    """Return a tree in which the halves of a cell have changed places."""
    middle = reader.subtree(tree, place + 1)
    end = reader.subtree(tree, middle)
    return tree[: place + 1] + tree[middle:end] + tree[place + 1 : middle] + tree[end:]


def false_leaves(generator: random.Random) -> list[bytes]:
    """Return leaves that exclude a cell, or settle it, for no reason."""
    y = struct.pack("<6i", *(generator.randrange(-(2**31), 2**31) for _ in range(6)))
    return [
        bytes([Node.NO_POSITION]),
        bytes([Node.NO_LENGTH]),
        bytes([Node.UNBALANCED]) + y,
        b"",
        bytes([Node.TOO_LONG, 0]),
    ]


@pytest.mark.slow
def test_trees_with_parts_dropped_swapped_or_made_up_are_refused(
    uc2: dict[str, Any], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
):
    # What is false stays so in more parts; fewer are refused sooner.
    monkeypatch.setattr(leaves, "PIECES", 16)
    generator = random.Random(SEED)
    for search in (0, 1):
        for chart in (0, 2):
            tree = base64.b64decode(uc2["subsets"][2]["searches"][search]["trees"][chart])
            splits = inner(tree)
            if not splits:
                continue
            place = splits[-1]
            changed = with_tree(uc2, search, chart, lambda t, p=place: swapped(t, p))
            assert refused(tmp_path, changed)
            for leaf in false_leaves(generator):
                changed = with_tree(uc2, search, chart, lambda t, p=place, v=leaf: without(t, p, v))
                assert refused(tmp_path, changed), (search, chart, leaf)
            changed = with_tree(uc2, search, chart, lambda t: bytes([Node.ROOT]))
            assert refused(tmp_path, changed)


def test_a_chart_left_out_is_refused_and_a_pending_one_is_said_to_be(uc2: dict[str, Any], tmp_path: Path):
    changed = copy.deepcopy(uc2)
    changed["subsets"][2]["searches"][0]["trees"][0] = None
    assert refused(tmp_path, changed)
    for node in (Node.PENDING, Node.UNDECIDED):
        path = tmp_path / "open.cert"
        path.write_bytes(pack(with_tree(uc2, 1, 2, lambda t, n=node: bytes([n]))))
        report = check(path)
        assert report.verdict is Verdict.PROVED and not report.complete
        assert report.pending + report.undecided == 1
        assert "partial" in report.lines()[0]


def one_root_lost(problem: Problem, options: Options, result: Result) -> Result:
    """Forget the first root of the second search, and its pose, as an unsound solver might."""
    assert options.record is not None
    searches = options.record.searches[0, 1]
    lost, kept = searches[1].roots[0], searches[1].roots[1:]
    searches[1] = replace(searches[1], roots=kept)
    from solvers.six_dof.cells.roots import pose_of

    centre = np.array([float(x.mid()) for x in pose_of(lost, searches[1].reduced.frame).centre.entries()])
    far = [s for s in result.solutions if np.abs(s.position.mean(axis=1) - centre).max() > 1e-3]
    assert len(far) == 7
    return replace(result, solutions=tuple(far))


def test_a_lost_root_is_not_passed_over(tmp_path: Path):
    problem, options, result = solved("uc2", LENGTHS, "c1,c2")
    result = one_root_lost(problem, options, result)
    path = tmp_path / "lost.cert"
    path.write_bytes(pack(document_of(problem, options, result)))
    report = check(path, sample=10)
    assert not report.complete and report.undecided > 0


def test_a_solver_that_drops_cells_is_found_out(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    problem, options, result = solved("uc2", LENGTHS, "c1,c2")
    result = one_root_lost(problem, options, result)
    node = Trees.node

    def careless(self: Trees, cell: Cell, fate: int, data: Sequence[float]) -> bytes:
        """Exclude small cells that cannot be excluded."""
        is_small = fate < 6 and cell[3] - cell[2] < 0.02
        return node(self, cell, UNBALANCED if is_small else fate, data)

    monkeypatch.setattr(Trees, "node", careless)
    assert verdict(tmp_path, document_of(problem, options, result)) is Verdict.NOT_PROVED


def test_a_solver_that_settles_cells_too_early_is_found_out(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    problem, options, result = solved("uc2", LENGTHS, "c1,c2")
    everywhere = np.array([[chart, *[-99.0, 99.0] * 6] for chart in range(4)])
    monkeypatch.setattr(Recorder, "boxes", lambda self: everywhere)
    monkeypatch.setattr(Recorder, "is_doubtful", lambda self, cell, node: False)
    assert verdict(tmp_path, document_of(problem, options, result)) is Verdict.NOT_PROVED


def test_a_certificate_holds_for_all_lengths_in_their_ranges_and_no_others(tmp_path: Path):
    document = document_of(*solved("uc2", "7.5+-0.0001,8", "c1,c2"))
    assert len(document["solutions"]) == 8 and not document["not_certified"]
    assert verdict(tmp_path, document) is Verdict.PROVED
    for wider in (["7.4995", "7.5001"], ["7.4999", "7.5005"]):
        changed = copy.deepcopy(document)
        changed["lengths_m"][0] = wider
        assert verdict(tmp_path, changed) is Verdict.NOT_PROVED


def test_what_is_unstable_for_all_lengths_is_not_stable(tmp_path: Path):
    document = copy.deepcopy(made("swing, ranges").document)
    two = next(s for s in document["solutions"] if s["taut"] == [0, 1])
    truth = [forward_kinematics(TURNED, ["3", length]).solutions for length in ("6.1", "6.1014", "6.1028")]
    assert {str(s.stability) for found in truth for s in found if s.taut == (0, 1)} == {"unstable"}
    for word, expected in (("unstable", Verdict.PROVED), ("stable", Verdict.NOT_PROVED)):
        two["stability"] = word
        assert verdict(tmp_path, document) is expected


@pytest.fixture(scope="module")
def uc3() -> dict[str, Any]:
    """The certificate of the three taut cables of uc3: 14 poses, 30 000 cells."""
    return document_of(*solved("uc3", "7.5,8,7", "c1,c2,c3"))


def searches_of(document: dict[str, Any]) -> searches.SubsetSearches:
    """Return the searches of a certificate's only subset."""
    return Certificate(pack(document)).searches(0)


def confirmed(found: searches.SubsetSearches, leaf: Any) -> bool:
    """Return True when the checker confirms a leaf in both arithmetics."""
    place, one = leaf
    try:
        with ctx.workprec(BITS):
            found.check(place, leaves.Cells.of([one], np.zeros(1, dtype=int)), np.ones(1, dtype=bool))
    except NotProved:
        return False
    return True


@pytest.mark.slow
def test_leaves_of_a_large_certificate_are_confirmed(uc3: dict[str, Any]):
    found = searches_of(uc3)
    cells = found.tally()
    assert cells.leaves > 10_000 and cells.pending == cells.undecided == 0
    assert sum(map(len, reader.trees(uc3))) < 40 * cells.leaves
    with ctx.workprec(BITS):
        assert check_all_roots(found, Certificate(pack(uc3)).solutions) == set(range(14))
    generator = random.Random(SEED)
    for leaf in generator.sample(list(found.leaves()), 150):
        assert confirmed(found, leaf), leaf[1]


@pytest.mark.slow
def test_false_leaves_of_a_large_certificate_are_refused(
    uc3: dict[str, Any], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(leaves, "PIECES", 16)
    generator, tried = random.Random(SEED), 0
    before = {leaf for _, leaf in searches_of(uc3).leaves()}
    while tried < 12:
        chart = generator.randrange(4)
        tree = base64.b64decode(uc3["subsets"][0]["searches"][0]["trees"][chart])
        splits = inner(tree)
        if not splits:
            continue
        place, tried = generator.choice(splits), tried + 1
        instead = generator.choice([v for v in false_leaves(generator) if v and v[0] != Node.TOO_LONG])
        changed = with_tree(uc3, 0, chart, lambda t, p=place, v=instead: without(t, p, v))
        found = searches_of(changed)
        new = [leaf for leaf in found.leaves() if leaf[1] not in before]
        assert new and not all(confirmed(found, leaf) for leaf in new)


@pytest.mark.slow
def test_a_tree_with_swapped_halves_is_refused(uc3: dict[str, Any]):
    generator = random.Random(SEED)
    before = {leaf for _, leaf in searches_of(uc3).leaves()}
    for chart in range(4):
        tree = base64.b64decode(uc3["subsets"][0]["searches"][0]["trees"][chart])
        place = generator.choice(inner(tree)[-20:])
        found = searches_of(with_tree(uc3, 0, chart, lambda t, p=place: swapped(t, p)))
        new = [leaf for leaf in found.leaves() if leaf[1] not in before]
        assert new and not all(confirmed(found, leaf) for leaf in new)


def slings() -> dict[str, Any]:
    """Return the certificate of two cables from one exit point: two families that turn about the vertical."""
    cables = [([0.0, 0.0, 3.0], [-1.0, 0.0, 0.5]), ([0.0, 0.0, 3.0], [1.0, 0.0, 0.5])]
    options = Options(record=Record())
    robot = point_certificates.robot([tuple(a) for a, _ in cables], [tuple(b) for _, b in cables])
    problem = pose_problem(robot, ["1.5", "1.6"], "c0,c1", None, options)
    return document_of(problem, options, answer_question(problem, options))


def test_a_family_listed_twice_is_refused(tmp_path: Path):
    document = slings()
    assert verdict(tmp_path, document) is Verdict.PROVED and len(document["solutions"]) == 2
    for other in (0, 1):
        changed = copy.deepcopy(document)
        changed["solutions"].append(copy.deepcopy(document["solutions"][other]))
        roots = changed["subsets"][0]["searches"][0]["roots"]
        roots.append({**next(r for r in roots if r["pose"] == other), "pose": 2})
        assert verdict(tmp_path, changed) is Verdict.NOT_PROVED


def test_one_family_for_two_roots_is_refused(tmp_path: Path):
    changed = slings()
    del changed["solutions"][1]
    everything = [(-10.0).hex(), (10.0).hex()]
    for key in ("position_m", "tensions_N", "distances_m"):
        changed["solutions"][0][key] = [everything] * len(changed["solutions"][0][key])
    changed["solutions"][0] |= {
        "rotation": [[everything] * 3] * 3,
        "height_m": everything,
        "stability": "undecided",
    }
    for root in changed["subsets"][0]["searches"][0]["roots"]:
        root["pose"] = 0
    assert refused(tmp_path, changed)


def test_cables_that_are_too_long_cannot_be_called_undecided(tmp_path: Path):
    options = Options(record=Record(), ignore_slack=True)
    problem = pose_problem(load_robot("uc3"), "7.5,8,2", "c1,c2", None, options)
    document = document_of(problem, options, answer_question(problem, options))
    assert verdict(tmp_path, document) is Verdict.PROVED and len(document["solutions"]) == 8
    document["question"]["ignore_slack"] = False
    for listed in document["solutions"]:
        listed |= {"states": ["undecided"] * 3, "taut": [], "stability": "undecided", "slack_respected": None}
    assert verdict(tmp_path, document) is Verdict.NOT_PROVED


def test_a_box_around_poses_that_one_cable_holds_alone_is_refused(tmp_path: Path):
    # The second cable hardly carries: out of the plane, 3 cm away, there are poses at which it is just tight.
    document = document_of(*solved("uc2", "7.5,16.405353909", "c1,c2"))
    assert verdict(tmp_path, document) is Verdict.PROVED and len(document["solutions"]) == 1
    listed = document["solutions"][0]
    for bounds in (listed["position_m"], *listed["rotation"]):
        for k, (lo, hi) in enumerate(bounds):
            bounds[k] = [(float.fromhex(lo) - 0.02).hex(), (float.fromhex(hi) + 0.02).hex()]
    assert verdict(tmp_path, document) is Verdict.NOT_PROVED


def test_lengths_below_all_doubles_end(uc2: dict[str, Any], tmp_path: Path):
    changed = copy.deepcopy(uc2)
    changed["lengths_m"] = [["1e-400", "1e-400"]] * 2
    assert refused(tmp_path, changed)


COGIRO = (
    "10.737826963826153,10.996863446575965,10.519354683477053,10.587410916921941,"
    "9.838356404726296,9.423395407318322,9.501702491749816,11.157614327874176"
)
"""Lengths at which the searches of these subsets have thousands of cells that are hard to confirm."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("taut", "poses"), [("c2,c3,c4", 0), ("c5,c6,c8", 0), ("c1,c2,c3,c4", 0), ("c1,c2,c3,c6", 1)]
)
def test_robots_whose_cables_lie_close_together_are_proved(taut: str, poses: int, tmp_path: Path):
    document = document_of(*solved("cogiro", COGIRO, taut))
    (tmp_path / "c").write_bytes(pack(document))
    report = check(tmp_path / "c")
    assert report.complete and report.solutions == poses, report.lines()[0]
    # Cables are too long where the others have their lengths: elsewhere in a cell they need not be.
    assert report.parts < 1.5 * report.leaves
