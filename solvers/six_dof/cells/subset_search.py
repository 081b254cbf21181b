"""All equilibria of one taut subset, in rounds: search down to a leaf size, prove roots, go on smaller.

Each round searches the cells that are left with all roots proved so far; a cell whose
equilibria all lie in a root's uniqueness box is settled. What remains at the last leaf size
is undecided. Every round is deterministic, whatever the number of threads.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.engine.rows import FOLDED, SMALL
from cdpr_interval.engine.search import Report, Run, search
from cdpr_interval.mechanics.six_dof.arrays import Model
from solvers.six_dof.cells.columns import POSE_COLUMNS, ROTATION_COLUMNS
from solvers.six_dof.cells.kinds import ROTATION_CELLS, CellKind
from solvers.six_dof.cells.roots import Reduction, Root
from solvers.six_dof.cells.tube_prover import has_ranges, prover_of

Floats = NDArray[np.float64]

FIRST_LEAF = 0.04
"""Leaf size of the first round: most roots can be proved from such cells."""
LEAF_RATIO = 0.125
"""Each round's leaf size over that of the round before: three bisections of every variable."""
LAST_LEAF = 1e-8
"""Leaf size at which the search gives up: near a double root the tests see its square, close to rounding."""
SPREAD_SHARE = 0.5
"""Last leaf size over (width of the length ranges / platform size), and over that of the load's direction."""
GROWING_LEAVES = 60_000
"""More leaves than this, and more than in the round before, mean a continuum that no search resolves."""
RANGED_REASON = "some choice in the given ranges may have a pose here: neither proved nor excluded"
DEEP = 2e-5
"""Leaf size from which on the leaves lie around single points."""
GROWING_DEEP = 2_000
"""More leaves than this around points, and more than in the round before: smaller ones decide no more."""


class Observer(Protocol):
    """Whoever sees what becomes of the cells in u."""

    def solver_run(self, model: Model, roots: Floats, leaf_size: float) -> Run:
        """Return one thread's search, as the kind of cells has it, but seen; ``roots`` as in `Context`."""
        ...


@dataclass
class SubsetSearch:
    """What the search of one taut subset has found so far."""

    model: Model
    reduction: Reduction
    budget: Budget
    threads: int = 1
    report: Report | None = None
    observer: Observer | None = None
    """Sees what becomes of the cells in u."""
    roots: list[Root] = field(default_factory=list)
    undecided: Floats = field(default_factory=lambda: np.empty((0, ROTATION_COLUMNS.width)))
    """Leaves of the search in u that could not be decided."""
    undecided_position: Floats = field(default_factory=lambda: np.empty((0, POSE_COLUMNS.width)))
    """The same of the search in (u, x)."""
    reason: str = ""
    pending: int = 0
    cells: int = 0
    stop: Stop = Stop.EXHAUSTED
    first_leaf: float = FIRST_LEAF

    def __post_init__(self) -> None:
        self.prover = prover_of(self.model, self.reduction)

    def solve(self, cells: Floats | None = None) -> None:
        """Run all rounds of the search in u, then of the search in (u, x) on what it hands on.

        ``cells``: where to search; the default is everywhere.
        """
        everywhere = start_cells(self.reduction) if cells is None else cells
        turn, pose = self.prover.kinds
        folded = self.rounds(everywhere, turn)
        if len(folded) and self.stop is Stop.EXHAUSTED:
            self.rounds(position_cells(self.model, folded), pose)

    @property
    def left(self) -> int:
        """How many cells could not be decided."""
        return len(self.undecided) + len(self.undecided_position)

    def solve_cells(self, cells: Floats, cells_in_position: Floats) -> None:
        """Run all rounds on cells of both kinds, and on what those in u hand on."""
        turn, pose = self.prover.kinds
        folded = self.rounds(cells, turn)
        if self.stop is Stop.EXHAUSTED:
            more = position_cells(self.model, folded)
            self.rounds(np.concatenate([cells_in_position, more]), pose)
        else:
            self.pending += len(cells_in_position)

    def rounds(self, cells: Floats, kind: CellKind) -> Floats:
        """Search ``cells`` round by round; return the folded leaves that are handed on to (u, x)."""
        prover = self.prover
        leaf_size = self.first_leaf
        before = 0
        handed_on: list[Floats] = [np.empty((0, cells.shape[1]))]
        while len(cells):
            small, folded = self.one_round(cells, leaf_size, kind)
            handed_on.append(folded)
            if self.stop is not Stop.EXHAUSTED:
                self.pending += len(small) + sum(map(len, handed_on))
                return handed_on[0]
            most = GROWING_LEAVES if leaf_size > DEEP else GROWING_DEEP
            growing = most < len(small) and before < len(small)
            cells, before = small, len(small)
            if len(small):
                found, cells = prover.find(small, leaf_size, kind, self.roots, self.budget)
                self.roots += found
            leaf_size *= LEAF_RATIO
            if growing or leaf_size < last_leaf(self.model):
                self.give_up(prover.unsettled(cells, self.roots, kind), kind, growing)
                break
        return np.concatenate(handed_on)

    def one_round(self, cells: Floats, leaf_size: float, kind: CellKind) -> tuple[Floats, Floats]:
        """Search down to ``leaf_size``; return small and folded leaves."""
        rows = self.prover.seen_by_cells(self.roots)
        result = search(
            lambda: self.run(kind, rows, leaf_size),
            cells,
            self.budget,
            threads=self.threads,
            report=self.report,
        )
        self.cells += result.cells
        self.stop = result.stop
        self.pending += len(result.pending)
        return result.leaves[result.kinds == SMALL], result.leaves[result.kinds == FOLDED]

    def run(self, kind: CellKind, rows: Any, leaf_size: float) -> Run:
        """Return the compiled search of one thread; ``rows`` : what the prover has for cells."""
        if self.observer is not None and kind is ROTATION_CELLS:
            return self.observer.solver_run(self.model, rows, leaf_size)
        return kind.run(self.model, rows, leaf_size)

    def give_up(self, cells: Floats, kind: CellKind, too_many: bool) -> None:
        """Keep what is left as undecided."""
        if len(cells) == 0:
            return
        if has_ranges(self.model):
            self.reason = RANGED_REASON
        elif too_many and len(cells) > GROWING_LEAVES:
            self.reason = "too many cells remain: the solutions seem to form a continuum"
        elif too_many:
            self.reason = "smaller cells decide no more: the wrenches are nearly dependent, or poses meet"
        else:
            self.reason = "the smallest cells could neither be excluded nor proved"
        if kind.columns.in_position:
            self.undecided_position = cells
        else:
            self.undecided = cells


def last_leaf(model: Model) -> float:
    """Return the leaf size at which to give up.

    Cells smaller than the spread of poses over the data cannot be excluded, and the roots that
    can be proved are proved by then.
    """
    n = model.n_taut
    spread = float((model.lengths[:n, 1] - model.lengths[:n, 0]).max()) / model.size
    turned = float(np.abs(model.load_err).max() / np.abs(model.load).max())
    return max(LAST_LEAF, SPREAD_SHARE * spread, SPREAD_SHARE * turned)


@cache
def start_cells(reduction: Reduction) -> Floats:
    """Return one cell for every chart: u in [-1, 1]^3, both branches. There are only a few reductions."""
    used = [chart for chart in range(4) if reduction.frozen[chart] is not None]
    cells = np.array([[*u_range(reduction.frozen[c] or ()), c, 0, 1.0 / len(used)] for c in used])
    cells.setflags(write=False)
    return cells


def u_range(frozen: tuple[int, ...]) -> list[float]:
    """Return u's bounds in a whole chart, entry by entry."""
    return [x for k in range(3) for x in ((0.0, 0.0) if k in frozen else (-1.0, 1.0))]


def unique_u(cells: Floats) -> Floats:
    """Drop cells that stand for the same u box twice (they differed in the branch only)."""
    keys = np.column_stack([cells[:, :6], cells[:, ROTATION_COLUMNS.chart]])
    _, first = np.unique(keys, axis=0, return_index=True)
    return cells[np.sort(first)]


def position_cells(model: Model, folded: Floats) -> Floats:
    """Return (u, x) cells for folded u boxes: |x| <= l of the first order's pivot."""
    reach = model.lengths[model.orders[0, 0], 1]
    folded = unique_u(folded)
    cells = np.zeros((len(folded), POSE_COLUMNS.width))
    cells[:, :6] = folded[:, :6]
    for k in range(3):
        # Two cables in a plane: the equilibrium lies in y = 0.
        most = 0.0 if k == 1 and model.planar else reach
        cells[:, 6 + 2 * k], cells[:, 7 + 2 * k] = -most, most
    cells[:, POSE_COLUMNS.chart] = folded[:, ROTATION_COLUMNS.chart]
    cells[:, POSE_COLUMNS.share] = 1.0 / max(1, len(folded))
    return cells
