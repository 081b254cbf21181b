"""All equilibria of one taut subset, in rounds: search down to a leaf size, prove roots, go on smaller.

Each round searches the cells that are left with all roots proved so far; a cell whose
equilibria all lie in a root's uniqueness box is settled. What remains at the last leaf size
is undecided. Every round is deterministic, whatever the number of threads.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.engine.search import Report, Run, search
from solvers import platform_position as position
from solvers import platform_sigma as sigma
from solvers.platform_forms import FORM_ROWS, WORK_SHAPE
from solvers.platform_model import Model
from solvers.platform_roots import Prover, Reduction, Root

Floats = NDArray[np.float64]

FIRST_LEAF = 0.04
"""Leaf size of the first round: most roots can be proved from such cells."""
LEAF_RATIO = 0.125
"""Each round's leaf size over that of the round before: three bisections of every variable."""
LAST_LEAF = 1e-8
"""Leaf size at which the search gives up: near a double root the tests see its square, close to rounding."""
SPREAD_SHARE = 0.5
"""Last leaf size over (width of the length ranges / platform size)."""
GROWING_LEAVES = 60_000
"""More leaves than this, and more than in the round before, mean a continuum that no search resolves."""
CLAIM = 3.0
"""A Newton start speaks for the other leaves within this many leaf sizes in u."""


@dataclass
class SubsetSearch:
    """What the search of one taut subset has found so far."""

    model: Model
    reduction: Reduction
    budget: Budget
    threads: int = 1
    report: Report | None = None
    roots: list[Root] = field(default_factory=list)
    undecided: Floats = field(default_factory=lambda: np.empty((0, sigma.WIDTH)))
    """Leaves of the (u, sigma) search that could not be decided."""
    undecided_position: Floats = field(default_factory=lambda: np.empty((0, position.P_WIDTH)))
    """The same of the (u, p) search."""
    reason: str = ""
    pending: int = 0
    cells: int = 0
    stop: Stop = Stop.EXHAUSTED

    def solve(self) -> None:
        """Run all rounds of the (u, sigma) search, then of the (u, p) search on what it hands on."""
        flat = self.rounds(start_cells(self.model, self.reduction), in_position=False)
        if len(flat) and self.stop is Stop.EXHAUSTED:
            self.rounds(position_cells(self.model, flat), in_position=True)

    def rounds(self, cells: Floats, *, in_position: bool) -> Floats:
        """Search ``cells`` round by round; return the flat leaves that are handed on to (u, p)."""
        prover = Prover(self.model, self.reduction)
        leaf_size = FIRST_LEAF
        before = 0
        handed_on: list[Floats] = [np.empty((0, sigma.WIDTH))]
        while len(cells):
            small, flat = self.one_round(cells, leaf_size, in_position)
            handed_on.append(flat)
            if self.stop is not Stop.EXHAUSTED:
                self.pending += len(small) + sum(map(len, handed_on))
                return np.empty((0, sigma.WIDTH))
            self.find_roots(prover, small, leaf_size, in_position)
            growing = GROWING_LEAVES < before < len(small)
            cells, before = small, len(small)
            leaf_size *= LEAF_RATIO
            if growing or leaf_size < last_leaf(self.model):
                self.give_up(prover.unsettled(cells, self.roots, in_position), in_position, growing)
                break
        return np.concatenate(handed_on)

    def one_round(self, cells: Floats, leaf_size: float, in_position: bool) -> tuple[Floats, Floats]:
        """Search down to ``leaf_size``; flat leaves restart with the next triple while there is one."""
        small: list[Floats] = []
        flat_all: list[Floats] = [np.empty((0, sigma.WIDTH))]
        make_run = position_run if in_position else sigma_run
        while len(cells):
            result = search(
                lambda: make_run(self.model, self.roots, leaf_size),
                cells,
                self.budget,
                threads=self.threads,
                report=self.report,
            )
            self.cells += result.cells
            small.append(result.leaves[result.kinds == sigma.SMALL])
            if result.stop is not Stop.EXHAUSTED:
                self.stop = result.stop
                self.pending += len(result.pending) + int((result.kinds == sigma.FLAT).sum())
                break
            if in_position:
                break
            cells, flat = next_triple(self.model, result.leaves[result.kinds == sigma.FLAT])
            flat_all.append(flat)
        width = position.P_WIDTH if in_position else sigma.WIDTH
        return np.concatenate([*small, np.empty((0, width))]), np.concatenate(flat_all)

    def give_up(self, cells: Floats, in_position: bool, too_many: bool) -> None:
        """Keep what is left as undecided."""
        if len(cells) == 0:
            return
        if last_leaf(self.model) > LAST_LEAF:
            self.reason = "some lengths in the given ranges may have a pose here: neither proved nor excluded"
        elif too_many:
            self.reason = "too many cells remain: the solutions seem to form a continuum"
        else:
            self.reason = "the smallest cells could neither be excluded nor proved"
        if in_position:
            self.undecided_position = cells
        else:
            self.undecided = cells

    def find_roots(self, prover: Prover, leaves: Floats, leaf_size: float, in_position: bool) -> None:
        """Start Newton from leaves spread over each cluster and prove what it finds."""
        chart_column = position.P_CHART if in_position else sigma.CHART
        charts = leaves[:, chart_column].astype(int) if len(leaves) else np.empty(0, dtype=int)
        middles = 0.5 * (leaves[:, 0:8:2] + leaves[:, 1:8:2]) if len(leaves) else np.empty((0, 4))
        open_ = np.ones(len(leaves), dtype=bool)
        for k in range(len(leaves)):
            if not open_[k] or self.budget.stop() is not None:
                continue
            near = (charts == charts[k]) & (
                np.abs(middles[:, :3] - middles[k, :3]).max(axis=1) <= CLAIM * leaf_size
            )
            if not in_position:
                near &= np.sign(middles[:, 3]) == np.sign(middles[k, 3])
            open_[near] = False
            open_[k] = False
            u = middles[k, :3]
            p = (
                0.5 * (leaves[k, 6:12:2] + leaves[k, 7:12:2])
                if in_position
                else prover.position_of(leaves[k])
            )
            self.try_root(prover, int(charts[k]), u, p)

    def try_root(self, prover: Prover, chart: int, u: Floats, p: Floats) -> None:
        """Run Newton from a pose; add the root if it is new and can be proved."""
        z = prover.polish(chart, prover.start(chart, u, p))
        if z is None or self.known(chart, z):
            return
        root = prover.prove(chart, z)
        if root is not None and not any(same_root(root, other) for other in self.roots):
            self.roots.append(root)

    def known(self, chart: int, z: Floats) -> bool:
        """Return True when a float root lies in a uniqueness box of this chart: it cannot be a new one."""
        return any(
            root.chart == chart and np.all(root.unique[:, 0] <= z) and np.all(z <= root.unique[:, 1])
            for root in self.roots
        )


def last_leaf(model: Model) -> float:
    """Return the leaf size at which to give up.

    Cells smaller than the spread of poses over the lengths cannot be excluded, and the roots that
    can be proved are proved by then.
    """
    n = model.n_taut
    spread = float((model.lengths[:n, 1] - model.lengths[:n, 0]).max()) / model.size
    return max(LAST_LEAF, SPREAD_SHARE * spread)


def same_root(a: Root, b: Root) -> bool:
    """Return True when two proved roots of one chart are proved to be the same."""
    return (
        a.chart == b.chart
        and bool(np.all(b.unique[:, 0] <= a.core[:, 0]))
        and bool(np.all(a.core[:, 1] <= b.unique[:, 1]))
    )


def start_cells(model: Model, reduction: Reduction) -> Floats:
    """Return one cell for every chart: u in [-1, 1]^3, |sigma| <= l_1 max |m|."""
    i, j = model.orders[0, 0], model.orders[0, 1]
    reach = 1.0 if model.planar else centre_distance(model, i, model.orders[0, 2])
    return full_sigma(
        model,
        np.array(
            [
                [*u_range(reduction.frozen[chart] or ()), 0.0, 0.0, chart, 0, 1.0]
                for chart in range(4)
                if reduction.frozen[chart] is not None
            ]
        ),
        centre_distance(model, i, j) * reach,
    )


def u_range(frozen: tuple[int, ...]) -> list[float]:
    """Return u's bounds in a whole chart, entry by entry."""
    return [x for k in range(3) for x in ((0.0, 0.0) if k in frozen else (-1.0, 1.0))]


def full_sigma(model: Model, cells: Floats, most: float) -> Floats:
    """Give each cell the proved range |sigma| <= l_1 max |m| of its order; ``most`` bounds |m|."""
    for cell in cells:
        i = model.orders[int(cell[sigma.ORDER]), 0]
        s = model.lengths[i, 1] * most * (1.0 + 1e-12)
        cell[sigma.SIGMA_LO], cell[sigma.SIGMA_HI] = -s, s
    cells[:, sigma.SHARE] /= max(1.0, cells[:, sigma.SHARE].sum())
    return cells


def centre_distance(model: Model, i: int, j: int) -> float:
    """Return an upper bound of |c_i - c_j| over all rotations."""
    a = np.linalg.norm(np.abs(model.anchor_steps[i, j]) + model.anchor_steps_err[i, j])
    b = np.linalg.norm(np.abs(model.point_steps[0, i, j]) + model.point_steps_err[i, j])
    # 1e-12 covers the dozen roundings of two norms and a sum.
    return float(a + b) * (1.0 + 1e-12)


def next_triple(model: Model, flat: Floats) -> tuple[Floats, Floats]:
    """Split flat leaves into cells restarted with their next triple and those that have none."""
    if len(flat) == 0:
        return flat, flat
    flat = flat.copy()
    flat[:, sigma.ORDER] += 1
    last = flat[:, sigma.ORDER] >= len(model.orders)
    again, done = flat[~last], flat[last]
    for order in range(1, len(model.orders)):
        chosen = again[:, sigma.ORDER] == order
        if chosen.any():
            i, j, k = model.orders[order, :3]
            most = centre_distance(model, i, j) * centre_distance(model, i, k)
            share = again[chosen, sigma.SHARE].copy()
            again[chosen] = full_sigma(model, again[chosen], most)
            again[chosen, sigma.SHARE] = share
    return unique_u(again), unique_u(done)


def unique_u(cells: Floats) -> Floats:
    """Drop cells that restart the same u box twice (they differed in sigma only)."""
    if len(cells) == 0:
        return cells
    keys = np.column_stack([cells[:, :6], cells[:, sigma.CHART], cells[:, sigma.ORDER]])
    _, first = np.unique(keys, axis=0, return_index=True)
    return cells[np.sort(first)]


def position_cells(model: Model, flat: Floats) -> Floats:
    """Return (u, p) cells for flat u boxes: p in the intersection of |p - A_i| <= l_i + |b_i|, as a box."""
    lo, hi = np.full(3, -np.inf), np.full(3, np.inf)
    for i in range(model.n_taut):
        reach = model.lengths[i, 1] + float(np.linalg.norm(np.abs(model.points[0, i]) + model.points_err[i]))
        reach = reach * (1.0 + 1e-12) + 1e-300
        a, e = model.anchors[i], model.anchors_err[i]
        pad = reach + e + 1e-12 * (np.abs(a) + reach)
        lo = np.maximum(lo, a - pad)
        hi = np.minimum(hi, a + pad)
    if np.any(lo > hi):
        return np.empty((0, position.P_WIDTH))
    if model.planar:
        lo[1] = hi[1] = 0.0
    flat = unique_u(flat)
    cells = np.zeros((len(flat), position.P_WIDTH))
    cells[:, :6] = flat[:, :6]
    for k in range(3):
        cells[:, 6 + 2 * k] = lo[k]
        cells[:, 7 + 2 * k] = hi[k]
    cells[:, position.P_CHART] = flat[:, sigma.CHART]
    cells[:, position.P_SHARE] = 1.0 / max(1, len(flat))
    return cells


def root_rows(model: Model, roots: list[Root]) -> Floats:
    """Return the uniqueness boxes as one array for the kernels."""
    width = 1 + 2 * (6 + model.n_taut)
    return np.array([root.row() for root in roots]).reshape(len(roots), width)


def sigma_run(model: Model, roots: list[Root], leaf_size: float) -> Run:
    """Bind the compiled (u, sigma) search to its data and one thread's scratch."""
    rows = root_rows(model, roots)
    forms, work, (lo, hi) = np.zeros((FORM_ROWS, 6)), np.zeros(WORK_SHAPE), np.zeros((2, 6 + model.n_taut))

    def run(*stack: object) -> tuple[int, int, int]:
        done: tuple[int, int, int] = sigma.run(model, rows, leaf_size, forms, work, lo, hi, *stack)
        return done

    return run


def position_run(model: Model, roots: list[Root], leaf_size: float) -> Run:
    """Bind the compiled (u, p) search to its data and one thread's scratch."""
    rows = root_rows(model, roots)
    forms, work, (lo, hi) = np.zeros((FORM_ROWS, 8)), np.zeros(WORK_SHAPE), np.zeros((2, 6 + model.n_taut))

    def run(*stack: object) -> tuple[int, int, int]:
        done: tuple[int, int, int] = position.run_position(
            model, rows, leaf_size, model.size, forms, work, lo, hi, *stack
        )
        return done

    return run
