"""Certificates of platforms over pulleys: proved, and refused where they are false."""

from __future__ import annotations

import base64
import copy
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import arb, arb_mat, ctx, fmpq

from cdpr_interval import load_robot
from cdpr_interval.exact import balls
from cdpr_interval.mechanics.cables.path import Balls, OffTheCable
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.pulley import Pulley
from certificates import check
from certificates.arithmetic.balls import BITS, unit
from certificates.arithmetic.floats import Floats
from certificates.arithmetic.forms import Form
from certificates.arithmetic.integers import Integers
from certificates.arithmetic.vectors import cross
from certificates.certificate import Certificate
from certificates.claims import Pose
from certificates.container import pack
from certificates.problem import read_problem
from certificates.root_claims import is_rejected
from certificates.routed.views import Lengths, Shells
from certificates.search import RoutedSearch
from certificates.stability import rope_to
from certificates.tree import Node
from certificates.verdicts import NotProved, Report, Verdict
from solvers.forward import answer_question, pose_problem
from solvers.proofs import routed
from solvers.proofs.document import certificate_document
from solvers.proofs.entries import subset_entries
from solvers.questions.problem import Options
from solvers.six_dof.record import Record
from tests.support.made_certificates import changed

SEED = 20261130
BIT = fmpq(1, 10**9)
Json = dict[str, Any]


def one_pulley() -> Robot:
    """Return UC3 with a pulley at one exit, and a lead-in: two cables stay straight."""
    robot = load_robot("uc3")
    first, *others = robot.cables
    return robot.replace(cables=[first.replace(pulley=Pulley("0.1", axis=(0, 0, 1), lead_in="0.5")), *others])


GRAB = "1.54832", "1.64748", "1.53246"
UC3 = "8", "8", "7"
CASES = {"grab33": (lambda: load_robot("grab33"), GRAB), "uc3": (one_pulley, UC3)}


def document(robot: Robot, lengths: Any, taut: str | None = "c1,c2,c3", **asked: bool) -> Json:
    """Return a certificate."""
    options = Options(record=Record(), **asked)
    problem = pose_problem(robot, list(lengths), taut, None, options)
    result = answer_question(problem, options)
    return certificate_document(problem, options, result, subset_entries(problem, options, result))


@pytest.fixture(scope="module", params=CASES)
def partial(request: pytest.FixtureRequest) -> Json:
    """Return certificates with all roots, and trees that end early."""
    robot, lengths = CASES[request.param]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(routed, "MOST_CELLS", 12_000)
        return document(robot(), lengths)


def checked(given: Json) -> Report:
    """Return what the checker says."""
    return check(pack(given), seed=SEED)


def tree_of(given: Json, chart: int = 3) -> bytes:
    """Return a tree."""
    return base64.b64decode(given["subsets"][0]["searches"][0]["trees"][chart])


def with_tree(given: Json, tree: bytes, chart: int = 3) -> Json:
    """Return a certificate with another tree."""
    text = base64.b64encode(tree).decode("ascii")
    return changed(given, "subsets", 0, "searches", 0, "trees", chart, value=text)


def test_what_is_recorded_follows(partial: Json):
    report = checked(partial)
    assert report.verdict is Verdict.PROVED and not report.complete
    assert report.solutions >= 7 and report.leaves > 1000 and report.pending and not report.undecided


@pytest.mark.slow
def test_all_poses_are_proved_to_be_all():
    """UC3 takes more cells than are written; its roots and claims are looked at above."""
    given = document(load_robot("grab33"), GRAB)
    report = checked(given)
    assert (report.verdict, report.complete) == (Verdict.PROVED, True)
    lost = copy.deepcopy(given)
    for root in lost["subsets"][0]["searches"][0]["roots"]:
        root["pose"] = None if root["pose"] == 0 else root["pose"] and root["pose"] - 1
    del lost["solutions"][0]
    assert checked(lost).verdict is Verdict.NOT_PROVED


def test_there_is_no_pose_of_short_cables():
    """The anchors of GRAB_33 cannot reach each other: complete, in a few cells."""
    report = checked(document(load_robot("grab33"), ("0.5", "0.5", "0.5")))
    assert (report.verdict, report.complete, report.solutions) == (Verdict.PROVED, True, 0)


def moved(given: Json, *keys: Any, by: str = "1/1000000000") -> Json:
    """Return a certificate with another exact number."""
    place = given
    for key in keys:
        place = place[key]
    return changed(given, *keys, value=str(fmpq(*map(int, by.split("/"))) + ratio(str(place))))


def ratio(text: str) -> fmpq:
    """Return an exact number of a certificate."""
    return fmpq(*Fraction(text).as_integer_ratio())


@pytest.mark.parametrize("key", ["frame_anchor_m", "platform_anchor_m"])
def test_another_robot_is_refused(partial: Json, key: str):
    assert checked(moved(partial, "robot", "cables", 1, key, 2)).verdict is Verdict.NOT_PROVED


def test_another_pulley_or_length_is_refused(partial: Json):
    for keys in (("radius_m",), ("axis", 1), ("lead_in_m",)):
        assert checked(moved(partial, "robot", "cables", 0, "pulley", *keys)).verdict is Verdict.NOT_PROVED
    given = changed(
        partial, "lengths_m", 0, value=[str(ratio(partial["lengths_m"][0][0]) + fmpq(1, 10**9))] * 2
    )
    assert checked(given).verdict is Verdict.NOT_PROVED
    longer = moved(partial, "lengths_m", 0, 1)
    assert checked(longer).verdict is Verdict.MALFORMED, "ranges have no rule"


def test_a_false_claim_is_refused(partial: Json):
    stability = "unstable" if partial["solutions"][0]["stability"] == "stable" else "stable"
    assert (
        checked(changed(partial, "solutions", 0, "stability", value=stability)).verdict is Verdict.NOT_PROVED
    )
    other = partial["solutions"][1]["position_m"]
    assert checked(changed(partial, "solutions", 0, "position_m", value=other)).verdict is Verdict.NOT_PROVED
    given = changed(partial, "solutions", 0, "tensions_N", 0, value=[(8.0).hex(), (8.5).hex()])
    assert checked(given).verdict is Verdict.NOT_PROVED


def test_a_false_root_is_refused(partial: Json):
    roots = partial["subsets"][0]["searches"][0]["roots"]
    k = next(k for k, root in enumerate(roots) if root["pose"] is not None)
    path = ("subsets", 0, "searches", 0, "roots", k)
    assert checked(changed(partial, *path, "pose", value=None)).verdict is Verdict.NOT_PROVED
    wide = [[(-1.0).hex(), (1.0).hex()]] * 3
    assert checked(changed(partial, *path, "u", value=wide)).verdict is Verdict.NOT_PROVED
    chart = (roots[k]["chart"] + 1) % 4
    assert checked(changed(partial, *path, "chart", value=chart)).verdict is Verdict.NOT_PROVED


@pytest.mark.parametrize("leaf", [Node.NO_LENGTH, Node.ROOT, Node.UNBALANCED])
def test_a_false_leaf_is_refused(partial: Json, leaf: Node):
    """A whole chart is no such leaf."""
    tree = bytes([leaf]) + (bytes(24) if leaf is Node.UNBALANCED else b"")
    assert checked(with_tree(partial, tree)).verdict is Verdict.NOT_PROVED


def test_a_dropped_or_false_cut_is_refused(partial: Json):
    tree = tree_of(partial)
    assert checked(with_tree(partial, tree[:-1])).verdict is Verdict.MALFORMED
    cut = bytes([Node.CUT, 1]) + np.array([-1.0, 0.0]).tobytes() + bytes([Node.PENDING])
    assert checked(with_tree(partial, cut)).verdict is Verdict.NOT_PROVED
    for node in (Node.SIDES, Node.HAND_ON, Node.NO_POSITION):
        assert checked(with_tree(partial, bytes([node]))).verdict is Verdict.MALFORMED


def test_what_has_no_rule_is_malformed(partial: Json):
    assert (
        checked(changed(partial, "question", "ignore_tension_sign", value=True)).verdict is Verdict.MALFORMED
    )
    stiff = {**partial["robot"]["cables"][0], "stiffness_N_per_m": "500"}
    assert checked(changed(partial, "robot", "cables", 0, value=stiff)).verdict is Verdict.MALFORMED
    for pulley in ({}, {"radius_m": "0", "axis": ["0", "0", "1"], "lead_in_m": "0"}):
        given = changed(partial, "robot", "cables", 0, "pulley", value=pulley)
        assert checked(given).verdict is Verdict.MALFORMED
    for pulley in (
        {"radius_m": "0.1", "axis": ["0", "0", "0"], "lead_in_m": "0"},
        {"radius_m": "0.1", "axis": ["0", "0", "1"], "lead_in_m": "100"},
        {"radius_m": "0.1", "axis": ["0", "0", "1"], "lead_in_m": "-1"},
    ):
        given = changed(partial, "robot", "cables", 0, "pulley", value=pulley)
        assert checked(given).verdict is Verdict.MALFORMED


def test_a_subset_without_a_proof_is_refused(partial: Json):
    given = copy.deepcopy(partial)
    given["subsets"] = [{"taut": [0, 1, 2]}]
    assert checked(given).verdict is Verdict.NOT_PROVED


def test_a_rope_that_may_lie_beside_its_pulley_rejects_no_root():
    """Of an angle beyond 7 / 4 pi balls have another turn: such a zero is none, whatever its tensions are."""
    options = Options()
    problem = pose_problem(load_robot("grab33"), list(GRAB), "c1,c2,c3", None, options)
    result = answer_question(problem, options)
    question = read_problem(certificate_document(problem, options, result, []))
    with ctx.workprec(BITS), balls.precision():
        search = RoutedSearch(question, (0, 1, 2), {"order": [0, 1, 2], "roots": [], "trees": [""] * 4}, 0)
        rotation = arb_mat(3, 3, [int(i == j) for i in range(3) for j in range(3)])
        k, r = unit(question.pulleys[0].axis), arb(question.pulleys[0].radius)
        across = unit(cross(k, [arb(1), arb(2), arb(3)]))
        for x, y, is_known in ((1.0, -3.0, True), (0.02, -0.3, False)):
            # The anchor of the first cable at (x, y) radii from its exit point; one tension is negative.
            anchor = [
                arb(a) + r * (x * u + y * v) for a, u, v in zip(question.exits[0], across, k, strict=True)
            ]
            centre = arb_mat(3, 1, anchor) - arb_mat(3, 1, [arb(b) for b in question.points[0]])
            pose = Pose(rotation, centre, {0: arb(-1), 1: arb(1), 2: arb(1)}, {}, {})
            if is_known:
                assert is_rejected(search, pose)
            else:
                with pytest.raises(NotProved, match="may run past its pulley"):
                    is_rejected(search, pose)


def test_cells_about_which_nothing_is_known_are_refused_by_integers():
    """Products of unbounded forms do not fit into doubles."""
    huge = np.array([1, -1], dtype=object) * 2**3000
    assert list(Integers.doubles_near(huge)) == [np.inf, -np.inf]
    assert Integers.doubles_near(huge // 2**2900) == pytest.approx([2.0**40, -(2.0**40)])


def test_ways_over_pulleys_are_those_of_the_model():
    """The checker's formulas beside the model's, at random anchors around each pulley."""
    robot = load_robot("grab33")
    options = Options()
    problem = pose_problem(robot, list(GRAB), "c1,c2,c3", None, options)
    question = read_problem(certificate_document(problem, options, answer_question(problem, options), []))
    generator, seen = np.random.default_rng(SEED), 0
    with ctx.workprec(BITS), balls.precision():
        for _ in range(200):
            i = int(generator.integers(3))
            away = generator.normal(size=3) * generator.choice((0.06, 0.3, 2.0))
            anchor = [arb(a) + arb(float(x)) for a, x in zip(question.exits[i], away, strict=True)]
            try:
                rope = rope_to(question, i, anchor)
                path = problem.loaded.models[i].route.path(tuple(anchor), Balls())
            except (NotProved, OffTheCable):
                # Inside the pulley, or beside it: neither has a way there.
                continue
            seen += 1
            assert abs(rope.length - path.length) < 1e-30 and abs(rope.free - path.free) < 1e-30
            for e, a in zip(rope.pull, path.direction, strict=True):
                assert abs(e + a * path.free) < 1e-30
    assert seen > 100


@pytest.mark.parametrize("kind", [Floats, Integers])
def test_forms_enclose_the_ropes_of_all_poses_in_a_cell(kind: type[Form], partial: Json):
    """Lengths and wrenches at random places of random cells, in the view of lengths and of shells."""
    certificate = Certificate(pack(partial))
    generator = np.random.default_rng(SEED)
    with ctx.workprec(BITS), np.errstate(all="ignore"):
        search = certificate.searches(0).searches[0]
        ropes, start = search.over(kind), np.array(search.start(0, ()).bounds)
        smooth = 0
        for _ in range(40 if kind is Floats else 6):
            width = 10.0 ** generator.uniform(-4, -1)
            middle = start[:, 0] + generator.uniform(0.1, 0.9, 6) * (start[:, 1] - start[:, 0])
            e = generator.uniform(-1.0, 1.0, 6)
            lo, hi = middle - width, middle + width
            entries = [
                kind.between(np.array([a]), np.array([b]), k)
                for k, (a, b) in enumerate(zip(lo, hi, strict=True))
            ]
            at = [arb(float(m)) + arb(float(width * x)) for m, x in zip(middle, e, strict=True)]
            chart = int(generator.integers(4))
            exact = Lengths(search.platform, chart, at[:3])
            for view in (Lengths, Shells):
                over = view(ropes, np.array([chart]), entries[:3])
                numbers = [w for row in exact.wrenches(at[3:]) for w in row]
                forms = [w for row in over.wrenches(entries[3:]) for w in row]
                if view is Lengths:
                    numbers += [exact.rope(i, at[3:]).length for i in range(3)]
                    forms += [over.rope(i, entries[3:]).length for i in range(3)]
                for number, form in zip(numbers, forms, strict=True):
                    low, high = (float(np.ravel(v)[0] / kind.UNIT) for v in (form.lowest(), form.highest()))
                    # The place is rounded by less than this.
                    assert not number < low - 1e-12 and not number > high + 1e-12
                    smooth += view is Lengths and high - low < 1.0
    assert smooth > 50
