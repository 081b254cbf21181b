"""Search trees as they are written: notes of cells become the nodes that the checker reads and confirms."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest
from flint import ctx

from cdpr_interval import load_robot
from cdpr_interval.engine import notes
from cdpr_interval.engine.budget import Budget
from cdpr_interval.engine.notes import Notes
from cdpr_interval.engine.rows import NO_LENGTH, NO_POSITION, NOT_SLACK, UNBALANCED
from certificates import check
from certificates.arithmetic.balls import BITS
from certificates.certificate import Certificate
from certificates.leaves import confirmed_at_once
from certificates.tree import Cell as Box
from certificates.tree import Leaf, Node, decode
from certificates.verdicts import Verdict
from solvers.forward import answer_question, pose_problem
from solvers.proofs import recorder
from solvers.proofs.document import certificate_bytes
from solvers.proofs.recorder import Patience
from solvers.proofs.tree import TURNED, Cell, Trees, box_of
from solvers.questions.problem import Options
from solvers.six_dof.record import Record
from tests.support.planted import platform

SEED = 20261128
REACH = 1.5
START: Cell = (-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, 2.0, 0.0)
Y = (0.5, -0.25, 0.0, 1.0, 0.0, -1.0)


def grown(generator: random.Random, trees: Trees, start: Cell, size: int) -> dict[Cell, int]:
    """Note random fates below a cell, about so many; return them."""
    fates: dict[Cell, int] = {}
    waiting = [start]
    while waiting:
        cell = waiting.pop(generator.randrange(len(waiting)))
        if cell in fates:
            # Both sides hand on the same cell.
            continue
        turned = len(cell) == 8
        inner = [k for k in range(3 if turned else 6) if cell[2 * k] < cell[2 * k + 1]]
        inner += [notes.HAND_ON] if turned else []
        inner += [notes.CUT] if not turned or cell[7] != 0.0 else []
        inner += [notes.SIDES] if turned and cell[7] == 0.0 else []
        outer = [NO_LENGTH, NOT_SLACK, UNBALANCED, notes.IN_BOX, notes.UNDECIDED]
        fate = generator.choice(inner if len(fates) < size else outer + [NO_POSITION] * turned)
        data = [0.0] * 13
        if fate == notes.CUT:
            bounds = 6 if turned else 12
            data[:bounds] = cell[:bounds]
            data[2] = 0.5 * (cell[2] + cell[3])
            data[bounds - 1] = 0.25 * cell[bounds - 2] + 0.75 * cell[bounds - 1]
        elif fate == NOT_SLACK:
            data[0] = 1.0
        elif fate == UNBALANCED:
            data[:6] = Y
        fates[cell] = fate
        trees.add(np.array([[*cell, float(fate), *data]]), len(cell))
        waiting += trees.parts(cell, trees.nodes[cell])
    return fates


@pytest.mark.parametrize("planar", [False, True])
def test_the_checker_reads_the_cells_and_fates_that_were_noted(planar: bool) -> None:
    generator = random.Random(SEED)
    for _ in range(30):
        trees = Trees([7, 3], 2.0, REACH, planar)
        fates = grown(generator, trees, START, generator.randrange(40))
        tree = trees.encoded(START, lambda cell, node: False)
        read = set(decode(tree, box_of(START), REACH, planar))
        boxes = {box_of(cell): fate for cell, fate in fates.items()}
        inner = (*range(6), notes.SIDES, notes.HAND_ON)
        ends = {box: fate for box, fate in boxes.items() if fate not in inner}
        assert len(read) == len(ends)
        for leaf in read:
            fate = ends[leaf.cell]
            if fate == notes.CUT:
                assert leaf.node is Node.CUT and leaf.kept is not None and leaf.kept != leaf.cell
                assert leaf.kept.side == leaf.cell.side and leaf.cell.placed == (leaf.cell.side == 0)
            elif fate == NOT_SLACK:
                assert leaf.node is Node.TOO_LONG and leaf.data == (3,)
            elif fate == UNBALANCED:
                assert leaf.node is Node.UNBALANCED and leaf.data[3] == 2**31 - 1 and leaf.data[0] == 2**29
            else:
                names = {notes.IN_BOX: Node.ROOT, notes.UNDECIDED: Node.UNDECIDED}
                assert leaf.node is names.get(fate, Node.NO_LENGTH if fate == NO_LENGTH else Node.NO_POSITION)
        assert {trees.leaf(cell, trees.nodes[cell]) for cell in fates if box_of(cell) in ends} == read
        # What is cut in u is tried before it is written: the checker has its own way to the position.
        assert trees.tied == {
            cell for cell, fate in fates.items() if fate == notes.CUT and len(cell) == TURNED
        }


def test_what_is_missing_or_doubtful_is_pending() -> None:
    trees = Trees([], 1.0, REACH, False)
    trees.add(np.array([[*START, 1.0, *[0.0] * 6]]), 8)
    low, high = trees.parts(START, trees.nodes[START])
    trees.add(np.array([[*low, float(NO_LENGTH), *[0.0] * 6]]), 8)
    assert trees.encoded(START, lambda *_: False) == bytes([1, Node.NO_LENGTH, Node.PENDING])
    assert trees.encoded(START, lambda cell, node: cell == low) == bytes([1, Node.PENDING, Node.PENDING])
    assert trees.encoded(high, lambda *_: False) == bytes([Node.PENDING])


def test_a_direction_that_is_no_number_is_written_as_none() -> None:
    trees = Trees([], 1.0, REACH, False)
    for y in ([np.nan] + [1.0] * 5, [np.inf] + [1.0] * 5, [0.0] * 6):
        assert trees.written_y(y) == bytes(24)


def test_notes_are_kept_up_to_their_number_and_only_such_as_say_something() -> None:
    kept = Notes(columns=2, data=1, most=3)
    rows = np.array([[k, k, notes.UNNOTED if k % 2 else 0.0, k] for k in range(10)])
    kept.add(rows)
    assert kept.room == 0 and kept.taken()[:, 0].tolist() == [0.0, 2.0, 4.0] and len(kept.taken()) == 0


def test_patience_ends_with_the_run_or_with_undecided_cells() -> None:
    whole = Budget(cell_limit=10)
    patience = Patience(whole)
    assert patience.reserve(100) == 10
    patience.settle(10, 4)
    assert whole.cells == 4 and patience.stop() is None
    patience.interrupt()
    assert patience.reserve(1) == 0 and whole.stop() is None
    whole.interrupt()
    assert Patience(whole).stop() is not None


def recorded(robot: str, lengths: str, taut: str) -> bytes:
    """Return the certificate of a subset."""
    options = Options(record=Record())
    problem = pose_problem(load_robot(robot), lengths, taut, None, options)
    return certificate_bytes(problem, options, answer_question(problem, options))


@pytest.fixture(scope="module")
def uc3() -> Certificate:
    return Certificate(recorded("uc3", "7.5,8,7", "c1,c2,c3"))


def leaves_of(certificate: Certificate, subset: int) -> Iterator[tuple[recorder.Search, Leaf]]:
    """Yield all leaves and cuts of a subset's searches."""
    found = certificate.searches(subset)
    for place, leaf in found.leaves():
        yield found.searches[place], leaf


def test_every_kind_of_claim_of_compiled_tests_is_confirmed_at_once(uc3: Certificate) -> None:
    """In (u, x) the compiled tests are those of the checker: little need be bisected, and no cut may be."""
    generator = random.Random(SEED)
    with ctx.workprec(BITS):
        kinds: dict[Node, list[tuple[recorder.Search, Leaf]]] = {}
        for search, leaf in leaves_of(uc3, 0):
            if leaf.cell.placed:
                kinds.setdefault(leaf.node, []).append((search, leaf))
        assert {Node.CUT, Node.NO_LENGTH, Node.UNBALANCED} <= set(kinds)
        assert not {Node.PENDING, Node.UNDECIDED} & set(kinds)
        for node, found in kinds.items():
            some = [leaf for _, leaf in generator.sample(found, min(400, len(found)))]
            share = confirmed_at_once(found[0][0], some).mean()
            assert share == 1.0 if node is Node.CUT else share > 0.98, node


def test_a_cut_that_the_checker_does_not_confirm_is_not_written(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a trial fails every claim is tried, and what is refused is halved: the file still holds."""
    refuse = random.Random(SEED)
    refused: set[Box] = set()
    test = recorder.confirmed_at_once

    def doubting(search: recorder.Search, leaves: Sequence[Leaf]) -> Any:
        found = test(search, leaves)
        for i, leaf in enumerate(leaves):
            if leaf.node is Node.CUT and (leaf.cell in refused or refuse.random() < 0.3):
                refused.add(leaf.cell)
                found[i] = False
        return found

    monkeypatch.setattr(recorder, "confirmed_at_once", doubting)
    content = recorded("uc4", "7.5,8,7,9", "c1,c4")
    left = {leaf.cell for _, leaf in leaves_of(Certificate(content), 0) if leaf.node is Node.CUT}
    assert refused and left and not refused & left
    report = check(content)
    assert report.verdict is Verdict.PROVED and report.complete, report


SMALL = 77_000_231
"""Of robots with up to a few hundred cells."""
PLANTED = [
    *(
        "two-cables",
        "two-parallel",
        "two-cables-interval-lengths",
        "a-vertical-line-2",
        "b-rod-2",
        "a-hook-2",
    ),
]


@pytest.mark.parametrize("kind", PLANTED)
def test_planted_robots_are_proved(kind: str) -> None:
    planted = platform.plant(kind, SMALL)
    options = Options(record=Record())
    taut = None if len(planted.lengths) <= 3 else planted.taut
    problem = pose_problem(planted.robot, planted.lengths, taut, planted.external_force, options)
    result = answer_question(problem, options)
    report = check(certificate_bytes(problem, options, result))
    assert report.verdict is Verdict.PROVED and report.complete, report
    assert report.solutions == len(result.solutions)
