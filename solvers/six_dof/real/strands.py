"""Ranges of lengths that are too wide for one proof: they are cut, and the roots of the parts are joined.

For lengths in a part a root is the only zero in its box. Two parts that share a face have the same root there
if they have for one choice on it: on a face the zeros of both move continuously with the lengths, and are
regular, so that the choices for which they agree are an open and closed part of it. Roots so joined are a
strand: one zero for every choice in the whole ranges, which moves continuously with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.engine.rows import SMALL
from cdpr_interval.engine.search import search
from solvers.six_dof.real.columns import DENSITIES, REAL_COLUMNS
from solvers.six_dof.real.model import RealModel
from solvers.six_dof.real.roots import NEWTON_STEPS, RealRoot, root_near
from solvers.six_dof.real.subset import RealSearch, Share
from solvers.six_dof.real.system import existence_box, improve, new_bench, system

Floats = NDArray[np.float64]

MOST_PIECES = 700
"""Ranges that seem to need more parts are not cut."""
MOST_CUTS = 12
"""Cuts one after the other before the ranges are given up."""
MOST_CELLS = 200_000
"""Cells spent on the parts of one cluster."""
MOST_PARTS = 2_000
"""Parts of all sizes that are looked at for one cluster."""
LEAF = 0.25
"""First leaf size in a part, over the width of its ranges in units of the platform's size."""
ROUNDS = 3
"""Leaf sizes, each half the one before, that a part is searched at."""
KANTOROVICH = 4.4
"""What is proved in one piece has a growth below one over this, by the box of the first-order reach."""


class Piece(NamedTuple):
    """A root for the lengths of a part."""

    real: RealModel
    """With the part's lengths."""
    root: RealRoot


Strand = list[Piece]
"""The roots of parts that cover the ranges, joined."""


def strands_in(
    real: RealModel, cells: Floats, known: Sequence[RealRoot], budget: Budget, threads: int = 1
) -> tuple[list[Strand] | None, int]:
    """Return the strands of all equilibria in some cells of one chart, and how many cells that cost.

    None where they could not be had. ``known`` : roots for the whole ranges; equilibria in their boxes are no
    strands again.

    Guarantee
    ---------
    For every choice of the lengths each equilibrium in the cells, with tensions that are not negative, is the
    zero of exactly one strand or lies in the uniqueness box of a known root.
    """
    chart = int(cells[0, REAL_COLUMNS.chart])
    start = middle_of(cells)
    shares = None if real.elastic else shares_of(real, chart, start)
    if shares is None:
        return None, 0
    cutting = Cutting(known, Share(budget, MOST_CELLS), threads, shares)
    return cutting.strands(real, whole_cell(cells), start, 0), cutting.cells


def middle_of(cells: Floats) -> Floats:
    """Return the middle (6,) of the cell in the middle of some cells."""
    middles = 0.5 * (cells[:, 0:12:2] + cells[:, 1:12:2])
    away = np.abs(middles - np.median(middles, axis=0)).max(axis=1)
    return np.asarray(middles[int(np.argmin(away))])


def whole_cell(cells: Floats) -> Floats:
    """Return one cell (1, width) that holds all of some cells of one chart."""
    whole = cells[:1].copy()
    last = REAL_COLUMNS.share
    for first in (0, DENSITIES):
        end = REAL_COLUMNS.chart if first == 0 else last
        whole[0, first:end:2] = cells[:, first:end:2].min(axis=0)
        whole[0, first + 1 : end : 2] = cells[:, first + 1 : end : 2].max(axis=0)
    return whole


def cells_of(root: RealRoot, cells: Floats) -> Floats:
    """Return the part of one cell (1, width) in which a root's zeros can be; no row where there is none."""
    part = cells.copy()
    part[0, 0:12:2] = np.maximum(part[0, 0:12:2], root.box[:6, 0])
    part[0, 1:12:2] = np.minimum(part[0, 1:12:2], root.box[:6, 1])
    return part[(part[:, 0:12:2] <= part[:, 1:12:2]).all(axis=1)]


def shares_of(real: RealModel, chart: int, pose: Floats) -> Floats | None:
    """Return how much each length (n,) moves the root near a pose; None where too many parts are needed."""
    n = real.n_taut
    z, C = zero_at(real, chart, pose, real.lengths[:n].mean(axis=1))
    if z is None:
        return None
    half = 0.5 * (real.lengths[:n, 1] - real.lengths[:n, 0])
    moved = np.abs(C[:, :n]) * half
    reach = moved.sum(axis=1) + 1e-12
    bench = new_bench(real, chart)
    box = np.ascontiguousarray(np.stack([z - reach, z + reach], axis=1))
    ranged = int(np.count_nonzero(half > 1e-9))
    needed = KANTOROVICH * growth_of(bench, C, box)
    if not needed**ranged < MOST_PIECES:
        return None
    return np.asarray((np.abs(C[:, :n]) / reach[:, None]).sum(axis=0))


def growth_of(bench: object, C: Floats, box: Floats) -> float:
    """Return the spectral radius of |I - C J| over a box, in floats: an estimate."""
    size = len(box)
    f, J = np.empty((size, 2)), np.empty((size, size, 2))
    if not system(bench, box, f, J, True):
        return np.inf
    spread = np.abs(C) @ (0.5 * (J[..., 1] - J[..., 0]))
    E = np.abs(np.eye(size) - C @ J.mean(axis=2)) + spread
    return float(np.abs(np.linalg.eigvals(E)).max()) if np.isfinite(E).all() else np.inf


def zero_at(real: RealModel, chart: int, pose: Floats, lengths: Floats) -> tuple[Floats | None, Floats]:
    """Return where Newton leads (6 + n,) from a pose for exact lengths (n,), and the inverse there."""
    n = real.n_taut
    bench = new_bench(at_lengths(real, lengths), chart)
    z, C = np.concatenate([pose[:6], np.zeros(n)]), np.empty((6 + n, 6 + n))
    f, J = np.empty((6 + n, 2)), np.empty((6 + n, 6 + n, 2))
    if not system(bench, np.repeat(z[:, None], 2, axis=1), f, J, True):
        return None, C
    load = np.concatenate([real.load, np.zeros(3)])
    z[6:] = np.linalg.lstsq(J[n:, 6:].mean(axis=2), -load, rcond=1e-8)[0]
    if not improve(bench, z, C, NEWTON_STEPS) or not np.isfinite(z).all():
        return None, C
    return z, C


def at_lengths(real: RealModel, lengths: Floats) -> RealModel:
    """Return a model with exact lengths (n,) of its taut cables, or with ranges (n, 2) of them."""
    ends = np.stack([lengths, lengths], axis=1) if lengths.ndim == 1 else lengths
    both = real.lengths.copy(), real.paths.copy()
    for array in both:
        array[: real.n_taut] = ends
    return real._replace(lengths=both[0], paths=both[1])


class Cutting:
    """What the parts of some ranges have in common."""

    def __init__(self, known: Sequence[RealRoot], budget: Budget, threads: int, shares: Floats) -> None:
        self.known = known
        self.budget = budget
        self.threads = threads
        self.shares = shares
        self.cells, self.parts = 0, 0

    def strands(self, real: RealModel, cells: Floats, start: Floats, cuts: int) -> list[Strand] | None:
        """Return the strands in some cells for a part, by parts of it where there is no other way."""
        self.parts += 1
        run = RealSearch(real, self.budget, self.threads)
        run.roots = list(self.known)
        is_root = add_root(run, cells, start)
        if is_root or cuts == MOST_CUTS:
            left = self.left_of(run, cells)
            if left is None:
                return None
            found = run.roots[len(self.known) :]
            if not len(left):
                return [[Piece(real, root)] for root in found]
            # The zeros of the roots found must stay in the cells: nothing else brings them to the halves.
            cells = whole_cell(np.concatenate([left, *(cells_of(root, cells) for root in found)]))
            start = found[0].core[:6].mean(axis=1) if found else start
        if cuts == MOST_CUTS or self.parts > MOST_PARTS:
            return None
        return self.in_halves(real, cells, start, cuts)

    def left_of(self, run: RealSearch, cells: Floats) -> Floats | None:
        """Return what is left of cells in which a part has other equilibria than its roots; None: unknown."""
        leaf = LEAF * run.spread
        for _ in range(ROUNDS):
            result = search(partial(run.run, leaf), cells, self.budget, threads=self.threads)
            self.cells += result.cells
            if result.stop is not Stop.EXHAUSTED:
                return None
            cells = result.leaves[result.kinds == SMALL]
            if not len(cells):
                break
            add_root(run, cells, middle_of(cells))
            leaf *= 0.5
        return cells

    def in_halves(self, real: RealModel, cells: Floats, start: Floats, cuts: int) -> list[Strand] | None:
        """Return the strands of a part by those of its halves."""
        n = real.n_taut
        lengths = real.lengths[:n]
        k = int(np.argmax(self.shares * (lengths[:, 1] - lengths[:, 0])))
        at = 0.5 * (lengths[k, 0] + lengths[k, 1])
        if not lengths[k, 0] < at < lengths[k, 1]:
            return None
        found: list[list[Strand]] = []
        for side in (1, 0):
            ranges = lengths.copy()
            ranges[k, side] = at
            own = self.strands(at_lengths(real, ranges), cells, start, cuts + 1)
            if own is None or (found and len(own) != len(found[0])):
                return None
            found.append(own)
        face = lengths.mean(axis=1)
        face[k] = at
        return joined(found[0], found[1], face)


def add_root(run: RealSearch, cells: Floats, start: Floats) -> bool:
    """Add the root that Newton finds from a pose to those of a part; False where none is proved, or known."""
    root = root_near(run.real, int(cells[0, REAL_COLUMNS.chart]), start, run.roots)
    if root is not None:
        run.roots.append(root)
    return root is not None


def joined(first: list[Strand], second: list[Strand], face: Floats) -> list[Strand] | None:
    """Join the strands of two halves by their zeros for lengths (n,) on a face of both; None: not all."""
    whole, left = [], list(second)
    for strand in first:
        core = core_at(strand, face)
        partners = [other for other in left if core is not None and holds(other, face, core)]
        if len(partners) != 1:
            return None
        left = [other for other in left if other is not partners[0]]
        whole.append([*strand, *partners[0]])
    return None if left else whole


def core_at(strand: Strand, lengths: Floats) -> Floats | None:
    """Return a box (6 + n, 2) of a strand's zero for exact lengths; None where that is not proved."""
    piece = piece_at(strand, lengths)
    middle = piece.root.box.mean(axis=1)
    z, C = zero_at(piece.real, piece.root.chart, middle, lengths)
    core = np.empty((len(middle), 2))
    bench = new_bench(at_lengths(piece.real, lengths), piece.root.chart)
    if z is None or not existence_box(bench, z, C, core):
        return None
    return core if lies_in(core, piece.root.unique) else None


def holds(strand: Strand, lengths: Floats, core: Floats) -> bool:
    """Return whether a zero in a box for exact lengths is proved to be a strand's."""
    return lies_in(core, piece_at(strand, lengths).root.unique)


def piece_at(strand: Strand, lengths: Floats) -> Piece:
    """Return a piece whose part holds lengths (n,)."""
    n = len(lengths)
    for piece in strand:
        lo, hi = piece.real.lengths[:n].T
        if (lo <= lengths).all() and (lengths <= hi).all():
            return piece
    raise AssertionError("the parts cover the ranges")


def lies_in(box: Floats, other: Floats) -> bool:
    """Return whether a box (m, 2) lies in another."""
    return bool((other[:, 0] <= box[:, 0]).all() and (box[:, 1] <= other[:, 1]).all())
