"""All equilibria of one taut subset on real cables, in rounds: search to a leaf size, prove, go on.

Each round searches the cells that are left with all roots proved so far; a cell whose equilibria all lie in a
root's uniqueness box is settled. What remains at the last leaf size is undecided.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.engine.rows import SMALL
from cdpr_interval.engine.scratch import new_scratch
from cdpr_interval.engine.search import Report, Run, search
from cdpr_interval.kernels.lanes import LANES
from cdpr_interval.kernels.second_order import WHOLE_POSE
from cdpr_interval.mechanics.six_dof.rows import MOST_TAUT
from solvers.six_dof.real.cells import RealContext, run
from solvers.six_dof.real.columns import DENSITIES, REAL_COLUMNS
from solvers.six_dof.real.model import RealModel
from solvers.six_dof.real.roots import RealRoot, find_roots
from solvers.six_dof.real.rows import FORMS, WORK
from solvers.six_dof.real.survey import new_desk

Floats = NDArray[np.float64]

FIRST_LEAF = 0.04
LEAF_RATIO = 0.125
LAST_LEAF = 1e-7
"""Leaf size at which the search gives up."""
SPREAD_SHARE = 0.04
"""Last leaf size over the width of the length ranges in units of the platform's size."""
FIRST_SHARE = 0.25
"""First leaf size over the same width, at least: of wide ranges all cells of a small one would be left."""
SPREAD_RATIO = 0.7
"""Ratio of leaf sizes below the width of the ranges: poses spread over such leaves, which get many."""
ENOUGH_LEAVES = 5_000
"""So many leaves below the width of the ranges are not cut again."""
MOST_OF_FAMILY = 2
"""So many taut cables may let the platform turn about an axis: its poses are no points, and no search
ends."""
FAMILY_CELLS = 400_000
"""Cells for such a subset; where it has no pose, a tenth of them is enough."""
FAMILY_REASON = "these cables may have a family of poses, which is not resolved for cables over pulleys yet"
MANY_REASON = "too many cells remain: the solutions seem to form a continuum"
SMALL_REASON = "the smallest cells could neither be excluded nor proved"
MOST_LEAVES = 60_000
"""More leaves than this, and more than in the round before, are no neighbourhoods of single points."""


class Share(Budget):
    """A part of a budget: so many cells of it, for a search that need not end."""

    def __init__(self, whole: Budget, cells: int) -> None:
        super().__init__(None, cells)
        self.whole = whole

    def reserve(self, wanted: int) -> int:
        """Return how many cells may be looked at now, by both budgets."""
        own = super().reserve(wanted)
        both = self.whole.reserve(own) if own else 0
        super().settle(own - both, 0)
        return both

    def settle(self, reserved: int, used: int) -> None:
        """Book the cells really looked at in both."""
        super().settle(reserved, used)
        self.whole.settle(reserved, used)

    def stop(self) -> Stop | None:
        """Return why the search must stop now, or None."""
        return self.whole.stop() or super().stop()


@dataclass
class RealSearch:
    """What the search of one taut subset has found so far."""

    real: RealModel
    budget: Budget
    threads: int = 1
    report: Report | None = None
    most_cells: int | None = None
    """Cells that may be spent on it; more of them leave it undecided."""
    roots: list[RealRoot] = field(default_factory=list)
    undecided: Floats = field(default_factory=lambda: np.empty((0, REAL_COLUMNS.width)))
    reason: str = ""
    pending: int = 0
    cells: int = 0
    stop: Stop = Stop.EXHAUSTED

    def __post_init__(self) -> None:
        """Refuse what the tests on forms have no rows for; bound the cells of possible families."""
        if self.real.n_taut > MOST_TAUT and self.real.rigid > MOST_TAUT:
            raise ValueError("more than six taut cables: those behind the sixth must stretch")
        if self.most_cells is None and self.real.n_taut <= MOST_OF_FAMILY:
            self.most_cells = FAMILY_CELLS

    def solve(self, cells: Floats | None = None) -> None:
        """Run all rounds; ``cells`` : where to search, by default everywhere."""
        cells = start_cells(self.real) if cells is None else cells
        budget = self.budget if self.most_cells is None else Share(self.budget, self.most_cells)
        leaf, before = max(FIRST_LEAF, FIRST_SHARE * self.spread), 0
        while len(cells):
            result = search(partial(self.run, leaf), cells, budget, threads=self.threads, report=self.report)
            self.cells += result.cells
            small = result.leaves[result.kinds == SMALL]
            if result.stop is not Stop.EXHAUSTED:
                self.end_early(result.stop, np.concatenate([result.pending, small]))
                return
            growing = len(small) > MOST_LEAVES and before < len(small)
            if growing and leaf < self.spread:
                # Those of the round before say as much, in fewer cells.
                self.undecided, self.reason = cells, SMALL_REASON
                return
            cells, before = small, len(small)
            if len(cells):
                self.roots += find_roots(self.real, cells, leaf, self.roots, budget)
            spread = self.spread
            enough = leaf < spread and len(cells) > ENOUGH_LEAVES
            leaf = leaf * SPREAD_RATIO if leaf < spread else max(leaf * LEAF_RATIO, SPREAD_RATIO * spread)
            if growing or enough or leaf < max(LAST_LEAF, SPREAD_SHARE * spread):
                self.undecided = cells
                self.reason = MANY_REASON if growing else SMALL_REASON
                return

    def end_early(self, stop: Stop, cells: Floats) -> None:
        """Keep what is left when a budget is spent: as pending, or of a possible family as undecided."""
        if self.most_cells is not None and self.budget.stop() is None:
            self.undecided, self.reason = cells, FAMILY_REASON
        else:
            self.stop, self.pending = stop, self.pending + len(cells)

    @property
    def spread(self) -> float:
        """The width of the length ranges of taut cables, in units of the platform's size."""
        n = self.real.n_taut
        return float((self.real.lengths[:n, 1] - self.real.lengths[:n, 0]).max()) / self.real.size

    def context(self, leaf_size: float) -> RealContext:
        """Return what the compiled search looks at cells with."""
        width = 1 + 2 * (6 + self.real.n_taut)
        rows = np.array(
            [np.concatenate([[r.chart], r.unique[:, 0], r.unique[:, 1]]) for r in self.roots]
        ).reshape(len(self.roots), width)
        scratch = new_scratch(FORMS, WORK, WHOLE_POSE, REAL_COLUMNS.width)
        return RealContext(self.real, rows, leaf_size, new_desk(len(self.real.exits), LANES), scratch)

    def run(self, leaf_size: float) -> Run:
        """Bind the compiled search to its data and one thread's scratch."""
        context = self.context(leaf_size)

        def bound(*stack: object) -> tuple[int, int, int]:
            return run(context, *stack)

        return bound


def start_cells(real: RealModel) -> Floats:
    """Return one cell for every chart: u in [-1, 1]^3, and all positions that the cables can reach."""
    n = real.n_taut if not real.slack else len(real.exits)
    far = real.paths[:n, 1] - real.least_excess[:n] + real.arm_lengths[:n]
    far = (far + 1e-9 * (1.0 + far))[:, None]
    lo, hi = (real.exits[:n] - far).max(axis=0), (real.exits[:n] + far).min(axis=0)
    if not (lo <= hi).all():
        return np.empty((0, REAL_COLUMNS.width))
    cells = np.zeros((4, REAL_COLUMNS.width))
    cells[:, 0:6:2], cells[:, 1:6:2] = -1.0, 1.0
    cells[:, 6:12:2], cells[:, 7:12:2] = lo, hi
    cells[:, REAL_COLUMNS.chart] = np.arange(4)
    cells[:, DENSITIES + 1 : REAL_COLUMNS.share : 2] = np.inf
    cells[:, REAL_COLUMNS.share] = 0.25
    return cells
