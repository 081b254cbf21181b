"""What proves the zeros of data with ranges: tubes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.per_thread import per_thread
from cdpr_interval.kernels.lanes import LANES
from cdpr_interval.kernels.second_order import Symbols, width
from cdpr_interval.mechanics.six_dof.arrays import Model
from cdpr_interval.mechanics.six_dof.form_system import MOST_UNKNOWNS
from cdpr_interval.mechanics.six_dof.rows import MOST_TAUT
from cdpr_interval.mechanics.six_dof.tube import ALL_SYMBOLS, SYMBOLS, TABLE
from solvers.six_dof.cells.kinds import (
    RANGED_POSE_CELLS,
    RANGED_ROTATION_CELLS,
    SPREAD_POSE_CELLS,
    SPREAD_ROTATION_CELLS,
    CellKind,
)
from solvers.six_dof.cells.root_search import MOST_STARTS
from solvers.six_dof.cells.roots import Prover, Reduction, Root
from solvers.six_dof.cells.tube import Tube, around
from solvers.six_dof.cells.tube_offsets import Tubes
from solvers.six_dof.cells.tube_search import TERMS, TubeBench, find_tubes

Floats = NDArray[np.float64]

ROUNDING = 1e-15
"""Relative width of a length's bounds up to which it is one number, not a range."""


def prover_of(model: Model, reduction: Reduction) -> Prover:
    """Return what proves the zeros of a model: tubes where its data have ranges, else roots."""
    if has_spread(model):
        return SpreadProver(model, reduction)
    return TubeProver(model, reduction) if has_ranges(model) else Prover(model, reduction)


def has_ranges(model: Model) -> bool:
    """Return whether a datum of the taut cables has a range, by more than the rounding of one number."""
    lengths = model.lengths[: model.n_taut]
    return has_spread(model) or bool((lengths[:, 1] - lengths[:, 0] > ROUNDING * lengths[:, 1]).any())


def has_spread(model: Model) -> bool:
    """Return whether points or load have a range, by more than the rounding of one number."""
    force = np.abs(model.load).max()
    return bool(model.gaps[: model.n_taut].any() or (model.load_err > ROUNDING * force).any())


class TubeProver(Prover):
    """Finds and proves the zeros of one reduced system: tubes, of data with ranges."""

    kinds: ClassVar[tuple[CellKind, CellKind]] = (RANGED_ROTATION_CELLS, RANGED_POSE_CELLS)
    find_zeros: ClassVar[Callable[..., tuple[int, int]]] = staticmethod(find_tubes)

    def seen_by_cells(self, roots: Sequence[Root]) -> Tubes:
        """Return tubes as the cells' kernels see them."""
        return self.tubes(roots, len(roots))

    def tubes(self, roots: Sequence[Root], room: int) -> Tubes:
        """Return tubes in arrays with room for so many."""
        k = 6 + self.model.n_taut
        tubes = Tubes(
            np.zeros(room, dtype=np.int64),
            np.zeros((room, 3, 2)),
            np.zeros((room, k)),
            np.zeros((room, k, MOST_TAUT)),
            np.zeros((room, k, len(symbols_of(self.model).data) - MOST_UNKNOWNS)),
            np.zeros((room, k)),
            np.zeros((room, k)),
        )
        for i, root in enumerate(roots):
            assert isinstance(root, Tube)
            tubes.charts[i], tubes.near[i], tubes.centres[i] = root.chart, root.near, root.polynomial[:, 0]
            tubes.slopes[i], tubes.sways[i] = root.slopes, root.sways_of_cells
            tubes.rests[i], tubes.reach[i] = root.rests, root.reach
        return tubes

    def bench(self, roots: Sequence[Root]) -> TubeBench:
        """Return scratch that holds the tubes known, with room for as many as one call may find."""
        room, k = len(roots) + MOST_STARTS, 6 + self.model.n_taut
        turn, pose = self.kinds
        return TubeBench(
            turn.scratch(),
            pose.scratch(),
            symbols_of(self.model),
            forms_of_thread(symbols_of(self.model)),
            self.tubes(roots, room),
            np.empty((room, k, TERMS)),
            np.empty((room, k)),
            np.empty((room, k, 2)),
        )

    def root(self, bench: Any, k: int) -> Tube:
        """Return the tube in row ``k``."""
        n = self.model.n_taut
        polynomial, radii, reach = (x[k].copy() for x in (bench.polynomials, bench.radii, bench.tubes.reach))
        middle = polynomial[:, 0]
        found = Tube(
            chart=int(bench.tubes.charts[k]),
            box=bench.hulls[k].copy(),
            unique=np.stack([middle - reach, middle + reach], axis=1),
            core=around(middle, radii),
            squares=self.model.lengths_sq[:n].copy(),
            radii_of_squares=self.model.lengths_sq_err[:n].copy(),
            polynomial=polynomial,
            sways=bench.tubes.sways[k].copy(),
            radii=radii,
            reach=reach,
        )
        # The signs are their own inverse.
        return replace(found, sways=found.sways_of_cells)


class SpreadProver(TubeProver):
    """Finds and proves tubes where points or load have ranges, too: cells know the symbols of these."""

    kinds: ClassVar[tuple[CellKind, CellKind]] = (SPREAD_ROTATION_CELLS, SPREAD_POSE_CELLS)

    def root(self, bench: Any, k: int) -> Tube:
        """Return the tube in row ``k``; its core is the zero for the middle points and lengths."""
        found, n = super().root(bench, k), self.model.n_taut
        gaps = self.model.gaps[:n]
        squares = (
            0.5 * (self.model.lengths[:n, 0] + gaps) ** 2 + 0.5 * (self.model.lengths[:n, 1] - gaps) ** 2
        )
        at, _ = found.zero_at(squares)
        # Where the squares are rounded the zero is off by far less.
        reach = found.reach * (1.0 - 1e-9)
        unique = np.stack([at - reach, at + reach], axis=1)
        return replace(found, core=around(at, found.radii), unique=unique)


def symbols_of(model: Model) -> Symbols:
    """Return the symbols along which a model's tubes are proved."""
    return ALL_SYMBOLS if has_spread(model) else SYMBOLS


@per_thread
def forms_of_thread(symbols: Symbols) -> Floats:
    """Return a thread's forms for tubes."""
    return np.zeros((TABLE.height, width(symbols), LANES))
