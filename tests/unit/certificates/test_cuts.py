"""Cuts of cells of u on one side: honest ones are confirmed, and none that takes a pose away."""

import random
import struct
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from flint import ctx

from cdpr_interval import load_robot
from certificates import check
from certificates.arithmetic.balls import BITS
from certificates.arithmetic.floats import Floats
from certificates.arithmetic.integers import Integers
from certificates.arithmetic.vectors import cross, dot
from certificates.certificate import Certificate
from certificates.geometry import Rotated
from certificates.leaves import Cells, check_cells, confirmed
from certificates.search import Root, Search
from certificates.tree import Cell, Leaf, Node, decode
from certificates.verdicts import Malformed, NotProved, Verdict
from solvers.forward import answer_question, pose_problem
from solvers.proofs.document import certificate_bytes
from solvers.questions.problem import Options
from solvers.six_dof.record import Record
from tests.reference.six_dof.test_under_constrained import SIX_LEGS

SEED = 20261130
CHART = 2
REACH = 1.5
TURN = Cell(CHART, ((-1.0, 1.0), (-0.5, 0.5), (0.0, 1.0)))
ONE = ((0.25, 0.5),)
"""Bounds within every entry of it."""


def certificate(robot: str, lengths: str, taut: str, **asked: bool) -> bytes:
    """Return the certificate of a subset."""
    options = Options(record=Record(), **asked)
    problem = pose_problem(load_robot(robot), lengths, taut, None, options)
    return certificate_bytes(problem, options, answer_question(problem, options))


@pytest.fixture(scope="module")
def uc4() -> tuple[Search, list[Leaf]]:
    """The search of the four taut cables of uc4, and its cuts of cells of u."""
    search = Certificate(certificate("uc4", "7.5,8,7,9", "c1,c2,c3,c4")).searches(0).searches[0]
    return search, [leaf for leaf in search.leaves() if leaf.node is Node.CUT and not leaf.cell.placed]


def holds(search: Search, leaf: Leaf) -> tuple[bool, bool]:
    """Return whether a cut is confirmed by doubles, and whether by integers."""
    with ctx.workprec(BITS):
        cells = Cells.of([leaf], np.zeros(1, dtype=int))
        return tuple(bool(confirmed(search, cells, kind)[0]) for kind in (Floats, Integers))


def cut_node(mask: int, *bounds: tuple[float, float]) -> bytes:
    """Return a cut as a tree has it."""
    return bytes([Node.CUT, mask]) + b"".join(struct.pack("<dd", *b) for b in bounds)


def read(tree: bytes, start: Cell = TURN) -> list[Leaf]:
    """Return the leaves and cuts of a tree."""
    return list(decode(tree, start, REACH, planar=False))


def test_what_is_left_of_a_cell_keeps_its_side() -> None:
    below = cut_node(0b101, *ONE * 2) + bytes([0, Node.PENDING, Node.PENDING])
    found = read(bytes([Node.SIDES]) + below + below)
    assert [leaf.node for leaf in found] == [Node.CUT, Node.PENDING, Node.PENDING] * 2
    for first, side in ((0, 1), (3, -1)):
        kept = Cell(CHART, (*ONE, TURN.bounds[1], *ONE), side)
        assert found[first].cell == replace(TURN, side=side) and found[first].kept == kept
        assert [leaf.cell for leaf in found[first + 1 : first + 3]] == list(kept.halves(0))


MALFORMED = {
    "no side": cut_node(1, *ONE),
    "no side, nothing cut": cut_node(0),
    **{f"entry {k}": bytes([Node.SIDES]) + cut_node(1 << k, *ONE) for k in range(3, 8)},
    "above": bytes([Node.SIDES]) + cut_node(4, (0.5, 1.25)),
    "below": bytes([Node.SIDES]) + cut_node(4, (-0.25, 0.5)),
    "empty": bytes([Node.SIDES]) + cut_node(1, (0.5, 0.25)),
    "no number": bytes([Node.SIDES]) + cut_node(1, (float("nan"), 0.5)),
    "infinite": bytes([Node.SIDES]) + cut_node(1, (-float("inf"), 0.5)),
    **{f"entry {k} of (u, x)": bytes([Node.HAND_ON]) + cut_node(1 << k, *ONE) for k in (6, 7)},
}


@pytest.mark.parametrize("tree", MALFORMED.values(), ids=MALFORMED.keys())
def test_cuts_of_what_a_cell_does_not_have_are_malformed(tree: bytes) -> None:
    with pytest.raises(Malformed):
        read(tree + bytes([Node.PENDING]) * 3)


def test_a_cut_without_its_bounds_is_malformed() -> None:
    for end in range(1, 1 + 2 + 16):
        with pytest.raises(Malformed):
            read((bytes([Node.SIDES]) + cut_node(1, *ONE))[:end])


def test_honest_cuts_are_confirmed_in_both_arithmetics(uc4: tuple[Search, list[Leaf]]) -> None:
    search, cuts = uc4
    assert len(cuts) > 100 and {leaf.cell.side for leaf in cuts} == {1, -1}
    for leaf in cuts[:: len(cuts) // 40]:
        assert holds(search, leaf) == (True, True), leaf


def with_entry(leaf: Leaf, k: int, lo: float, hi: float) -> Leaf:
    """Return a cut with other bounds of one entry that are left."""
    assert leaf.kept is not None
    return replace(leaf, kept=leaf.kept.with_bounds(k, lo, hi))


def cut_entries(leaf: Leaf) -> list[int]:
    """Return which entries are cut."""
    assert leaf.kept is not None
    return [k for k in range(3) if leaf.kept.bounds[k] != leaf.cell.bounds[k]]


def test_cuts_that_leave_nothing_are_refused(uc4: tuple[Search, list[Leaf]]) -> None:
    search, cuts = uc4
    tried = 0
    for leaf in cuts[:: len(cuts) // 30]:
        assert leaf.kept is not None
        if any(holds(search, replace(leaf, node=Node.NO_LENGTH, kept=None))):
            continue
        tried += 1
        for k in cut_entries(leaf):
            lo, hi = leaf.kept.bounds[k]
            for at in (lo, 0.5 * (lo + hi), hi):
                assert holds(search, with_entry(leaf, k, at, at)) == (False, False), (leaf, k, at)
    assert tried > 20


def test_a_cut_that_is_refused_is_not_bisected(uc4: tuple[Search, list[Leaf]]) -> None:
    search, cuts = uc4
    cut = next(leaf for leaf in cuts if not any(holds(search, replace(leaf, node=Node.NO_LENGTH, kept=None))))
    assert cut.kept is not None
    k = cut_entries(cut)[0]
    false = with_entry(cut, k, *[cut.kept.bounds[k][0]] * 2)
    with ctx.workprec(BITS), pytest.raises(NotProved, match="cut is not confirmed"):
        check_cells(search, Cells.of([false], np.zeros(1, dtype=int)), np.zeros(1, dtype=bool))


def test_cuts_on_the_other_side_are_refused(uc4: tuple[Search, list[Leaf]]) -> None:
    """Where the sides meet nearby, or the rest of the cell has no pose at all, a cut holds on both."""
    search, cuts = uc4
    other = []
    for leaf in cuts[:: len(cuts) // 40]:
        assert leaf.kept is not None
        cell, kept = (replace(v, side=-v.side) for v in (leaf.cell, leaf.kept))
        other.append(replace(leaf, cell=cell, kept=kept))
    found = [holds(search, leaf) for leaf in other]
    assert found.count((False, False)) > 0.6 * len(found)


def side_of(search: Search, root: Root) -> int:
    """Return the side of the plane of the centres on which a root is."""
    middle = [0.5 * (lo + hi) for lo, hi in root.box]
    (d2, _), (d3, _) = Rotated(search.platform.mapped(float), root.chart, middle[:3]).pair
    across = dot(cross(d2, d3), middle[3:])
    assert abs(across) > 1e-6
    return 1 if across > 0 else -1


def cuts_without(generator: random.Random, search: Search, roots: Sequence[Root], count: int) -> list[Leaf]:
    """Return cuts of random cells around roots, on their sides, that leave them out; just or by far."""
    found = []
    for root in generator.choices(roots, k=count):
        u = [0.5 * (lo + hi) for lo, hi in root.box[:3]]
        width = [10.0 ** generator.uniform(-7, -0.5) * generator.uniform(0.2, 1.0) for _ in u]
        below = [generator.random() for _ in u]
        bounds = tuple((v - w * b, v + w * (1.0 - b)) for v, w, b in zip(u, width, below, strict=True))
        cell = Cell(root.chart, bounds, side_of(search, root))
        k = generator.randrange(3)
        (lo, hi), gap = bounds[k], 10.0 ** generator.uniform(-4, 0)
        # Bounds of the root's u are far narrower than a gap.
        left, right = u[k] - gap * (u[k] - lo), u[k] + gap * (hi - u[k])
        kept = cell.with_bounds(k, *((lo, left) if generator.random() < 0.5 else (right, hi)))
        found.append(Leaf(cell, Node.CUT, kept=kept))
    return found


def test_no_cut_takes_a_pose_away(uc4: tuple[Search, list[Leaf]]) -> None:
    search, _ = uc4
    generator = random.Random(SEED)
    roots = [root for root in search.roots if root.pose is not None]
    assert len(roots) == 3
    for leaf in cuts_without(generator, search, roots, 400):
        assert holds(search, leaf) == (False, False), leaf


@pytest.mark.slow
def test_forty_poses_of_six_legs_are_proved_to_be_all() -> None:
    lengths = ",".join(str(v) for v in SIX_LEGS["lengths_m"])
    content = certificate("six_leg_40", lengths, "c1,c2,c3,c4,c5,c6", ignore_tension_sign=True)
    report = check(content)
    assert report.verdict is Verdict.PROVED and report.complete and report.solutions == 40, report
    search = Certificate(content).searches(0).searches[0]
    generator = random.Random(SEED)
    cuts = [leaf for leaf in search.leaves() if leaf.node is Node.CUT and not leaf.cell.placed]
    assert len(cuts) > 1000
    for leaf in generator.sample(cuts, 40):
        assert holds(search, leaf)[1], leaf
    for leaf in cuts_without(generator, search, search.roots, 400):
        assert holds(search, leaf) == (False, False), leaf
