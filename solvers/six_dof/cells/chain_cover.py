"""Cells of the search with a cable taut all of whose static poses are on a chain where that cable may switch.

A static pose of a cell has some density tau >= 0 of that cable. It is the chain's where, with tau in its
bounds, it lies within the reach of the polynomials for the same lengths and tau: none other is there. As in
``cells.tube_offsets`` its offset is bounded as a form in the lengths; what the polynomial moves with tau
within these bounds is an error.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.mechanics.six_dof.arrays import Model
from cdpr_interval.mechanics.six_dof.rows import MOST_TAUT
from solvers.six_dof.cells import ranged_cells
from solvers.six_dof.cells.chain import Chain
from solvers.six_dof.cells.chain_parts import part_of, split_terms
from solvers.six_dof.cells.kinds import CellKind
from solvers.six_dof.cells.roots import Reduction
from solvers.six_dof.cells.subset_search import SubsetSearch, last_leaf, position_cells
from solvers.six_dof.cells.tube import Tube
from solvers.six_dof.cells.tube_offsets import Tubes

Floats = NDArray[np.float64]

ROUNDS = 4
"""Of bisecting the cells that are left."""
LEAF_RATIO = 0.25
"""Leaf size of a round over that of the round before."""
MOST_CELLS = 4_000
"""More cells than this are no neighbourhood of one chain."""
NARROWINGS = 7
"""Of the bounds of tau in a cell, at most."""
MOST_HALVINGS = 10
"""Of the lengths of a tube, one after the other."""
ROUNDED = 1e-14
"""Relative rounding of where tubes end."""
PROGRESS = 0.7
"""Of a narrowing: bounds must shrink to this share."""


class Strand:
    """One tube of a chain as cells of a subset see it: rows and symbols in the order of its cables."""

    def __init__(self, tube: Tube, own: NDArray[np.int64]) -> None:
        k, n = len(own) - 1, len(own)
        rows = np.array([*range(6), *(6 + own)])
        polynomial = tube.polynomial[rows]
        constant, slopes, squares, mixed = split_terms(polynomial)
        other = [i for i in range(MOST_TAUT) if i != k]
        above = np.triu_indices(MOST_TAUT - 1, 1)
        self.middle, self.radius = float(tube.squares[-1]), float(tube.radii_of_squares[-1])
        self.first, self.last = self.middle - self.radius, self.middle + self.radius
        self.reach = tube.reach[rows]
        self.k = int(np.argmax(own))
        self._constant, self._slope, self._square = constant, slopes[:, k].copy(), squares[:, k].copy()
        self._slopes, self._mixed = (np.zeros((len(rows), MOST_TAUT)) for _ in range(2))
        self._slopes[:, :n], self._mixed[:, :n] = slopes[:, own], mixed[:, own, k]
        self._slopes[:, self.k] = self._mixed[:, self.k] = 0.0
        self._crossed = np.abs(mixed[:, other, k]).sum(axis=1)
        self._rest = np.abs(squares[:, other]).sum(axis=1) + 1e-14 * np.abs(polynomial).sum(axis=1)
        self._rest += np.abs(mixed[:, other][:, :, other][:, above[0], above[1]]).sum(axis=1)
        charts, near = np.array([tube.chart]), np.zeros((1, 3, 2))
        m = len(rows)
        slopes, sways, rests = np.zeros((1, m, MOST_TAUT)), np.zeros((1, m, 0)), np.zeros((1, m))
        self._tubes = Tubes(charts, near, np.zeros((1, m)), slopes, sways, rests, np.zeros((1, m)))

    def tubes(self, first: float, last: float) -> Tubes:
        """Return the tube for densities between two, what the density moves an error.

        Of densities outside of the tube's the other unknowns are those at its nearest end.
        """
        at = 0.5 * first + 0.5 * last
        delta = min(max((at - self.middle) / self.radius, -1.0), 1.0)
        half = (0.5 * (last - first) / self.radius + 1e-14 * (1.0 + at / self.radius)) * (1.0 + 1e-12)
        tubes = self._tubes
        tubes.centres[0] = self._constant + delta * (self._slope + delta * self._square)
        tubes.centres[0, 6 + self.k] = at
        tubes.slopes[0] = self._slopes + delta * self._mixed
        moved = np.abs(self._slope + 2.0 * delta * self._square) + self._crossed
        rest = self._rest + half * (moved + half * np.abs(self._square))
        tubes.rests[0] = rest * (1.0 + 1e-12)
        return tubes

    def apart(self, constant: Floats, slopes: Floats, rest: Floats) -> Floats:
        """Bound how far a polynomial (6 + n,), (6 + n, 6) of the lengths is from this tube's for its density.

        ``rest`` (6 + n,) bounds what the polynomial leaves out.
        """
        row = 6 + self.k
        at, step, off = (x[row] / self.radius for x in (constant - self.middle, slopes, rest))
        most = float(np.abs(step).sum() + off)
        gain = self._slope + 2.0 * at * self._square
        middle = self._constant + at * (self._slope + at * self._square)
        moved = self._slopes + at * self._mixed + gain[:, None] * step
        other = self._rest + np.abs(gain) * off + np.abs(self._square) * most**2 + self._crossed * most
        size = np.abs(constant) + np.abs(middle) + np.abs(slopes).sum(axis=1) + np.abs(moved).sum(axis=1)
        found = np.abs(constant - middle) + np.abs(slopes - moved).sum(axis=1) + rest + other
        return np.asarray(found * (1.0 + 1e-12) + 1e-14 * size * (1.0 + abs(at)) ** 2)

    def holds(self, off: Floats) -> bool:
        """Return True when offsets (6 + n,) are within reach; that of the density is its bounds."""
        inside = off < self.reach
        inside[6 + self.k] = True
        return bool(inside.all())


class Carpet:
    """A chain as cells of the subset with the cable see it.

    Parameters
    ----------
    own : (n,)
        Where each cable of the subset, in file order, stands in the chain's order.
    """

    def __init__(self, chain: Chain, own: NDArray[np.int64]) -> None:
        self.chart = chain.tubes[0].chart
        self.own = own
        self.chain = chain
        self.strands = [Strand(tube, own) for tube in chain.tubes]
        self.k = self.strands[0].k
        self.end = self.strands[-1].last * (1.0 - ROUNDED)

    def has(self, model: Model, cell: Floats, kind: CellKind) -> bool:
        """Return True when all static poses of a cell are on the chain, for all lengths in the model."""
        if int(cell[kind.columns.chart]) != self.chart or model.n_taut == MOST_TAUT:
            # Of six cables cells bound no tensions.
            return False
        bounds = self.densities(model, cell, kind)
        if bounds is None:
            return False
        lo, hi = bounds
        if hi < 0.0:
            return True
        if hi > self.end:
            return False
        room = ROUNDED * self.end
        for strand in self.strands:
            first, last = max(lo, strand.first - room, 0.0), min(hi, strand.last + room)
            if first > last:
                continue
            off = offsets(model, cell, kind, strand.tubes(first, last))
            if off is None or not strand.holds(off):
                return False
        return True

    def has_tube(self, tube: Tube, depth: int = 0, over: Sequence[Tube] = ()) -> bool:
        """Return True when all static poses of a tube of the subset, over the chain's lengths, are on it.

        ``over`` : the chain's tubes over the same part of the lengths as the tube; by default all of it.
        """
        constant, slopes, squares, mixed = split_terms(tube.polynomial)
        rest = np.abs(squares).sum(axis=1) + 0.5 * np.abs(mixed).sum(axis=(1, 2)) + tube.radii
        row = 6 + self.k
        off = float(np.abs(slopes[row]).sum() + rest[row]) * (1.0 + 1e-12)
        lo, hi = float(constant[row]) - off, float(constant[row]) + off
        if hi < 0.0:
            return True
        if tube.chart != self.chart:
            return False
        over = over or self.chain.tubes
        if hi <= self.end:
            room = ROUNDED * self.end
            strands = [Strand(one, self.own) for one in over]
            near = [one for one in strands if one.last + room >= lo and one.first - room <= hi]
            if all(one.holds(one.apart(constant, slopes, rest)) for one in near):
                return True
        if depth == MOST_HALVINGS:
            return False
        symbol = int(np.argmax((np.abs(slopes) / self.strands[0].reach[:, None]).max(axis=0)))
        for side in (-0.5, 0.5):
            # The density is a symbol of the strands; its cable's length is none.
            same = [part_of(one, int(self.own[symbol]), side) if symbol != self.k else one for one in over]
            if not self.has_tube(part_of(tube, symbol, side), depth + 1, same):
                return False
        return True

    def densities(self, model: Model, cell: Floats, kind: CellKind) -> tuple[float, float] | None:
        """Return bounds of the density of the cable that may switch over a cell's equilibria."""
        lo, hi = -np.inf, np.inf
        at = 0.5 * self.end
        for _ in range(NARROWINGS):
            before = hi - lo
            # Any tensions do for the bounds of one. From a bound to the other side they are sharp.
            for share in (0.5, 0.0, 1.0):
                at = at if lo == -np.inf else lo + share * (hi - lo)
                strand = next((one for one in self.strands if at <= one.last), self.strands[-1])
                off = offsets(model, cell, kind, strand.tubes(at, at))
                if off is None:
                    return None
                lo, hi = max(lo, at - off[6 + self.k]), min(hi, at + off[6 + self.k])
            if not hi - lo < PROGRESS * before:
                break
        return lo, hi


def offsets(model: Model, cell: Floats, kind: CellKind, tubes: Tubes) -> Floats | None:
    """Bound how far a cell's equilibria are from a tube (6 + n,); None: unknown."""
    out = np.empty(6 + model.n_taut)
    look = ranged_cells.pose_offsets if kind.columns.in_position else ranged_cells.turn_offsets
    found = look(kind.scratch(), model, cell, tubes, 0, out)
    return out if found and np.isfinite(out).all() else None


class Cover:
    """The cells of one subset that are left when those on chains are gone, for one box of lengths."""

    def __init__(self, model: Model, reduction: Reduction, budget: Budget, threads: int) -> None:
        self.search = SubsetSearch(model, reduction, budget, threads)
        self.model = model

    def left(self, cells: Floats, in_position: Floats, carpet: Carpet | None) -> tuple[Floats, Floats]:
        """Return the cells in u and in (u, x) that are left; without a carpet those no root settles."""
        turn, pose = self.search.prover.kinds
        rest, folded = self.rounds(cells, turn, carpet)
        more = position_cells(self.model, folded)
        rest_in_position, _ = self.rounds(np.concatenate([in_position, more]), pose, carpet)
        return rest, rest_in_position

    def rounds(self, cells: Floats, kind: CellKind, carpet: Carpet | None) -> tuple[Floats, Floats]:
        """Look at cells, bisect those left and look again; return those left and those handed on."""
        search, folded = self.search, [np.empty((0, cells.shape[1]))]
        cells = self.unsettled(cells, kind, carpet)
        leaf = last_leaf(self.model)
        for _ in range(ROUNDS):
            if not 0 < len(cells) <= MOST_CELLS:
                break
            before = cells
            small, more = search.one_round(cells, leaf, kind)
            if search.stop is not Stop.EXHAUSTED or len(small) > MOST_CELLS:
                return before, np.concatenate(folded)
            folded.append(more)
            cells = self.unsettled(small, kind, carpet)
            leaf *= LEAF_RATIO
        return cells, np.concatenate(folded)

    def unsettled(self, cells: Floats, kind: CellKind, carpet: Carpet | None) -> Floats:
        """Return the cells that neither a root settles nor the carpet has."""
        if len(cells) == 0:
            return cells
        cells = self.search.prover.unsettled(cells, self.search.roots, kind)
        if carpet is None:
            return cells
        kept = [not carpet.has(self.model, cell, kind) for cell in cells]
        return cells[np.array(kept, dtype=np.bool_)]
