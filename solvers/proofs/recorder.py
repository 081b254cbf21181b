"""The record of one search for a certificate: notes of the run are completed until the checker has a rule for all.

The run's own notes say what became of most cells of u. What it did beyond the certificate's rules is searched on by
these alone: compiled, in the engine, with what is left of the run's budget. What is not looked at by then is
pending. Nothing here needs to be trusted: what is written is checked.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.engine.search import Run, search
from certificates.frames import Setting
from certificates.leaves import confirmed, longest
from certificates.problem import Listed
from certificates.problem import Problem as Question
from certificates.searches import Search
from certificates.tree import Node
from solvers.proofs.allowance import Allowance
from solvers.proofs.claims import claim, root_entry
from solvers.proofs.tree import TURNED, Cell, Fate, Trees, box_of, leaf_of
from solvers.six_dof import rotation_cells as turn
from solvers.six_dof.noted_search import NotedPoses, NotedTurns
from solvers.six_dof.record import Searched

Floats = NDArray[np.float64]

DOUBTFUL = 2.0**-9
"""Narrower leaves, near poses and folds, are tried with the checker's test before they are written."""
SMALLEST = 1e-7
"""Width of u at which a cell is written as undecided."""
MOST_UNDECIDED = 2_000
"""Undecided cells after which no more is tried: they surround what the checker has no rule for."""
UNKNOWN = base64.b64encode(bytes([Node.UNDECIDED])).decode("ascii")
"""A tree of one leaf."""
UNDECIDED: Fate = (Node.UNDECIDED, bytes([Node.UNDECIDED]), ())


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

    def watching(self, run: Run) -> Run:
        """Return a run whose leaves that are too small use patience up."""

        def watched(stack: Any, count: int, leaves: Any, kinds: Any, *rest: Any) -> tuple[int, int, int]:
            done = run(stack, count, leaves, kinds, *rest)
            self.left -= int(np.count_nonzero(kinds[: done[1]] == turn.SMALL))
            if self.left < 0:
                self.interrupt()
            return done

        return watched


class Recorder:
    """Completes the record of one search of one subset, and writes it."""

    def __init__(self, question: Question, setting: Setting, searched: Searched, listed: list[Listed]) -> None:
        reduced = searched.reduced
        # The format has no leaf for poses that belong to a smaller subset.
        self.model, self.reduced, self.listed = reduced.model._replace(hanging=False), reduced, listed
        self.found, self.notes = searched.roots, searched.notes
        n = len(setting.taut)
        order = [setting.taut[k] for k in reduced.model.orders[0][:n]]
        charts = [None if setting.frozen(chart) is None else UNKNOWN for chart in range(4)]
        self.search = Search(question, setting, {"order": order, "roots": [], "trees": charts}, len(listed))
        others = [i for i in range(len(question.names)) if i not in setting.taut]
        self.unit = 1.0 / float(self.search.platform.per_unit)
        moments = self.unit / self.model.size
        self.trees = Trees([*setting.taut, *others], moments, self.search.reach, setting.planar)
        self.starts: dict[int, Cell] = {}
        for chart in range(4):
            frozen = setting.frozen(chart)
            if frozen is not None:
                u = [v for k in range(3) for v in ((0.0, 0.0) if k in frozen else (-1.0, 1.0))]
                self.starts[chart] = (*u, float(chart), 0.0)
        self.sure: set[Cell] = set()
        """Doubtful cells that the checker confirmed."""

    def claim_roots(self, allowance: Allowance) -> None:
        """Add what the checker confirms about the roots, until the allowance is spent."""
        for root in self.found:
            if allowance.is_spent:
                return
            with allowance.spending():
                found = claim(self.search, self.reduced, root, self.listed)
                if found is not None:
                    self.search.roots.append(found)

    def complete(self, allowance: Allowance, threads: int) -> None:
        """Put the run's notes together and search what is missing, until nothing is or the budget is spent."""
        patience = Patience(allowance.budget)
        if patience.stop() is not None:
            return
        with allowance.spending():
            self.trees.add(self.notes.taken(), self.notes.columns)
            missing = self.missing(self.starts.values(), patience)
            while missing and patience.stop() is None:
                for is_turned in (True, False):
                    cells = [cell for cell in missing if (len(cell) == TURNED) == is_turned]
                    if cells:
                        self.look(cells, patience, threads)
                missing = self.missing(missing, patience)

    def missing(self, cells: Iterable[Cell], budget: Budget) -> list[Cell]:
        """Return the parts of cells of which nothing is known; leaves that are doubtful are tried on the way."""
        found, waiting = [], list(cells)
        while waiting:
            cell = waiting.pop()
            fate = self.trees.fates.get(cell)
            if fate is not None and self.is_doubtful(cell, fate):
                if budget.stop() is not None:
                    return []
                fate = self.tried(cell, fate)
            if fate is None:
                found.append(cell)
            else:
                waiting += fate[2]
        return found

    def is_doubtful(self, cell: Cell, fate: Fate) -> bool:
        """Return True for what the checker might not confirm, and has not yet."""
        node = fate[0]
        if cell in self.sure:
            return False
        if node is Node.CUT:
            return cell in self.trees.tied
        is_claim = node in (Node.NO_POSITION, Node.NO_LENGTH, Node.TOO_LONG, Node.UNBALANCED)
        return is_claim and max(cell[2 * k + 1] - cell[2 * k] for k in range(3)) < DOUBTFUL

    def tried(self, cell: Cell, fate: Fate) -> Fate:
        """Try a doubtful cell with the checker's test; return its fate, another one where that fails."""
        box = box_of(cell)
        if confirmed(self.search, leaf_of(cell, fate), box):
            self.sure.add(cell)
            return fate
        k = longest(self.search, box)
        lo, hi = box.bounds[k]
        if hi - lo < SMALLEST * (1.0 if k < 3 else self.unit):
            self.trees.fates[cell] = UNDECIDED
        else:
            self.trees.split(cell, k)
        return self.trees.fates[cell]

    def look(self, cells: list[Cell], budget: Patience, threads: int) -> None:
        """Search cells of one kind by the rules of the certificate, and add what becomes of them."""
        boxes = self.boxes()
        seen = NotedTurns() if len(cells[0]) == TURNED else NotedPoses()

        def run() -> Run:
            """Return a thread's search."""
            if isinstance(seen, NotedTurns):
                return budget.watching(seen.certified_run(self.model, boxes, SMALLEST))
            return budget.watching(seen.certified_run(self.model, boxes, SMALLEST, self.unit))

        rows = np.array([[*cell, 1.0 / len(cells)] for cell in cells])
        with budget.whole.listening():
            search(run, rows, budget, threads=threads)
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
