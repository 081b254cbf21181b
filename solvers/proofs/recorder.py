"""The record of one search for a certificate: notes of a run, completed until there is a rule for all cells.

The run's own notes say what became of most cells of u. What it did beyond the certificate's rules is searched
on by these alone: compiled, in the engine, with what is left of the run's budget. What is not looked at by
then is pending. Nothing here needs to be trusted: what is written is checked.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from flint import fmpq
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.engine.notes import Notes
from cdpr_interval.engine.rows import SMALL
from cdpr_interval.engine.search import Run, search
from cdpr_interval.mechanics.six_dof.arrays import Model
from certificates.arithmetic.balls import hull
from certificates.frames import Setting
from certificates.leaves import LANES, confirmed_at_once, longest
from certificates.problem import Listed
from certificates.problem import Problem as Question
from certificates.search import Search
from certificates.tree import Node
from solvers.proofs.account import Account
from solvers.proofs.allowance import Allowance
from solvers.proofs.claims import claim, root_entry
from solvers.proofs.tree import TURNED, Cell, Trees, box_of
from solvers.six_dof.cells.noted import NotedPoses, NotedTurns
from solvers.six_dof.record import Searched

Floats = NDArray[np.float64]

DOUBTFUL = 2.0**-9
"""Narrower leaves, near poses and folds, are tried with the checker's test before they are written."""
CLAIMS = (Node.CUT, Node.NO_POSITION, Node.NO_LENGTH, Node.TOO_LONG, Node.UNBALANCED, Node.ROOT)
"""What a node may say of the poses in a cell."""
SAMPLE = 30
"""Cuts that are tried in each round, though nothing is doubtful about them."""
SMALLEST = 1e-7
"""Width of u at which a cell is written as undecided."""
MOST_UNDECIDED = 2_000
"""Undecided cells after which no more is tried: they surround what the checker has no rule for."""
MOST_CELLS = 1_000_000
"""Of one search, after which no more is tried: they take 500 MB, and their trees 20 MB."""
ROUNDING = 2.0**-52
"""Relative error of a number as a double."""
UNKNOWN = base64.b64encode(bytes([Node.UNDECIDED])).decode("ascii")
"""A tree of one leaf."""


class Patience(Budget):
    """A run's budget, until too many cells are undecided."""

    def __init__(self, whole: Budget) -> None:
        super().__init__()
        self.whole, self.left = whole, MOST_UNDECIDED

    def stop(self) -> Stop | None:
        """Return why the search must stop now, or None."""
        return super().stop() or self.whole.stop()

    def reserve(self, wanted: int) -> int:
        """Return how many cells may be looked at now; 0 when spent."""
        return 0 if self.stop() is not None else self.whole.reserve(min(wanted, MOST_UNDECIDED))

    def settle(self, reserved: int, used: int) -> None:
        """Book the cells really looked at."""
        self.whole.settle(reserved, used)

    def watching(self, run: Run, seen: Notes) -> Run:
        """Return a run that ends with patience, of which small leaves take some, or the room for notes."""

        def watched(stack: Any, count: int, leaves: Any, kinds: Any, *rest: Any) -> tuple[int, int, int]:
            done = run(stack, count, leaves, kinds, *rest)
            self.left -= int(np.count_nonzero(kinds[: done[1]] == SMALL))
            if self.left < 0 or seen.room == 0:
                self.interrupt()
            return done

        return watched


class Recorder:
    """Completes the record of one search of one subset, and writes it."""

    def __init__(
        self, question: Question, setting: Setting, searched: Searched, listed: list[Listed]
    ) -> None:
        reduced = searched.reduced
        self.reduced, self.listed = reduced, listed
        self.found, self.notes = searched.roots, searched.notes
        n = len(setting.taut)
        order = [setting.taut[k] for k in reduced.model.orders[0][:n]]
        charts = [None if setting.frozen(chart) is None else UNKNOWN for chart in range(4)]
        self.search = Search(question, setting, {"order": order, "roots": [], "trees": charts}, len(listed))
        others = [i for i in range(len(question.names)) if i not in setting.taut]
        self.model = as_checked(reduced.model, [question.lengths[i] for i in (*setting.taut, *others)])
        self.ranged = any(lo < hi for lo, hi in question.lengths)
        self.unit = 1.0 / float(self.search.platform.per_unit)
        moments = self.unit / self.model.size
        self.trees = Trees([*setting.taut, *others], moments, self.search.reach, setting.planar)
        self.starts: dict[int, Cell] = {}
        for chart in range(4):
            frozen = setting.frozen(chart)
            if frozen is not None:
                u = [v for k in range(3) for v in ((0.0, 0.0) if k in frozen else (-1.0, 1.0))]
                self.starts[chart] = (*u, float(chart), 0.0)
        self.trusts = not self.ranged
        """The compiled tests are taken to agree with the checker's, but where they are doubtful. Over wide
        ranges they are too far from them."""
        self.sure: set[Cell] = set()
        """Doubtful cells that the checker confirmed."""
        self.walked = 0
        """Nodes below which nothing is missing any more."""

    def claim_roots(self, allowance: Allowance, account: Account) -> None:
        """Add what the checker confirms about the roots, until the allowance is spent."""
        for root in self.found:
            if allowance.is_spent:
                return
            with allowance.spending():
                account.step(0.0)
                found = claim(self.search, self.reduced, root, self.listed)
                if found is not None:
                    self.search.roots.append(found)

    def complete(self, allowance: Allowance, account: Account, threads: int) -> None:
        """Put the notes together and search what is missing, until nothing is or the budget is spent."""
        patience = Patience(allowance.budget)
        if patience.stop() is not None:
            return
        with allowance.spending():
            self.trees.add(self.notes.taken(), self.notes.columns)
            missing = self.missing(self.starts.values(), patience, account)
            while missing and patience.stop() is None and len(self.trees.nodes) < MOST_CELLS:
                for is_turned in (True, False):
                    cells = [cell for cell in missing if (len(cell) == TURNED) == is_turned]
                    if cells:
                        self.look(cells, patience, account, threads)
                self.try_some()
                missing = self.missing(missing if self.trusts else self.starts.values(), patience, account)

    def try_some(self) -> None:
        """Try some cuts with the checker's test; where one fails no claim is written untried.

        A cut must be confirmed at once, where leaves may be bisected: one that is not refutes the file.
        """
        cuts = [c for c, v in self.trees.nodes.items() if v[0] == Node.CUT and not self.is_doubtful(c, v)]
        some = cuts[:: max(1, len(cuts) // SAMPLE)]
        leaves = [self.trees.leaf(cell, self.trees.nodes[cell]) for cell in some]
        self.trusts = self.trusts and all(confirmed_at_once(self.search, leaves))

    def missing(self, cells: Iterable[Cell], budget: Patience, account: Account) -> list[Cell]:
        """Return the parts of cells of which nothing is known; what is doubtful is tried on the way."""
        found, waiting = [], list(cells)
        account.next_step()
        walked, known = 0, len(self.trees.nodes) - self.walked
        while waiting:
            # Both sides may hand on the same cell.
            doubtful: dict[Cell, None] = {}
            while waiting:
                cell = waiting.pop()
                walked += 1
                account.step(walked / max(known, walked))
                node = self.trees.nodes.get(cell)
                if node is None:
                    found.append(cell)
                elif self.is_doubtful(cell, node):
                    doubtful[cell] = None
                else:
                    waiting += self.trees.parts(cell, node)
            waiting = list(doubtful)
            for first in range(0, len(waiting), LANES):
                if budget.whole.stop() is not None:
                    return []
                self.try_all(waiting[first : first + LANES])
        self.walked += walked - len(found)
        return found

    def is_doubtful(self, cell: Cell, node: bytes) -> bool:
        """Return True for what the checker might not confirm, and has not yet."""
        if node[0] not in CLAIMS or cell in self.sure:
            return False
        if node[0] == Node.ROOT:
            # The compiled test knows the root's box, but not how wide the checker's positions are.
            return True
        if not self.trusts or cell in self.trees.tied:
            return True
        return max(cell[2 * k + 1] - cell[2 * k] for k in range(3)) < DOUBTFUL

    def try_all(self, cells: Sequence[Cell]) -> None:
        """Try doubtful cells with the checker's tests; those that fail get other nodes."""
        leaves = [self.trees.leaf(cell, self.trees.nodes[cell]) for cell in cells]
        for cell, is_one in zip(cells, confirmed_at_once(self.search, leaves), strict=True):
            if is_one:
                self.sure.add(cell)
                continue
            k = longest(self.search, box_of(cell).bounds)
            is_small = cell[2 * k + 1] - cell[2 * k] < SMALLEST * (1.0 if k < 3 else self.unit)
            self.trees.nodes[cell] = bytes([Node.UNDECIDED if is_small else k])

    def look(self, cells: list[Cell], budget: Patience, account: Account, threads: int) -> None:
        """Search cells of one kind by the rules of the certificate, and add what becomes of them."""
        boxes = self.boxes()
        seen = NotedTurns() if len(cells[0]) == TURNED else NotedPoses()

        def run() -> Run:
            """Return a thread's search."""
            if isinstance(seen, NotedTurns):
                return budget.watching(seen.certified_run(self.model, boxes, SMALLEST, self.ranged), seen)
            certified = seen.certified_run(self.model, boxes, SMALLEST, self.ranged, self.unit)
            return budget.watching(certified, seen)

        rows = np.array([[*cell, 1.0 / len(cells)] for cell in cells])
        account.next_step()
        with budget.whole.listening():
            search(run, rows, budget, threads=threads, report=account.searched)
        self.trees.add(seen.taken(), seen.columns)

    def boxes(self) -> Floats:
        """Return the claimed roots' boxes as the kernels read them."""
        rows = [[root.chart, *(v for pair in root.box for v in pair)] for root in self.search.roots]
        return np.array(rows, dtype=np.float64).reshape(len(rows), 13)

    def entry(self) -> dict[str, Any]:
        """Return the search as the document has it."""
        trees = [
            base64.b64encode(self.trees.encoded(self.starts[chart], self.is_doubtful)).decode("ascii")
            if chart in self.starts
            else None
            for chart in range(4)
        ]
        return {
            "order": list(self.search.order),
            "roots": [root_entry(r) for r in self.search.roots],
            "trees": trees,
        }


def as_checked(model: Model, lengths: Sequence[tuple[fmpq, fmpq]]) -> Model:
    """Return the model with the rules and numbers of the checker.

    Its squares of lengths in ranges have another middle, and the format has no leaf for poses that belong to
    a smaller subset.
    """
    squares = [hull(lo, hi) ** 2 for lo, hi in lengths[: len(model.lengths_sq)]]
    middles = np.array([float(square.mid()) for square in squares])
    errors = np.array([float(square.rad()) for square in squares]) + ROUNDING * middles
    return model._replace(hanging=False, lengths_sq=middles, lengths_sq_err=errors)
