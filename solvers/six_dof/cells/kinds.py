"""The two kinds of cells of the search as data: in u alone, and in (u, x)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.contraction import VARIABLES_OF_POSE, VARIABLES_OF_ROTATION
from cdpr_interval.engine.per_thread import per_thread
from cdpr_interval.engine.scratch import Scratch, new_scratch
from cdpr_interval.engine.search import Run
from cdpr_interval.kernels.second_order import (
    POSE_AND_ALL_DATA,
    POSE_AND_DATA,
    ROTATION_AND_ALL_DATA,
    ROTATION_AND_DATA,
    ROTATION_ONLY,
    WHOLE_POSE,
    Symbols,
)
from cdpr_interval.mechanics.six_dof.arrays import Model
from cdpr_interval.mechanics.six_dof.rows import FORMS, WORK
from solvers.six_dof.cells import pose_cells, ranged_cells, rotation_cells
from solvers.six_dof.cells.columns import POSE_COLUMNS, ROTATION_COLUMNS, Columns

Floats = NDArray[np.float64]


class Context(NamedTuple):
    """What a compiled search looks at cells with."""

    model: Model
    roots: Any
    """(m, 1 + 2 (6 + n)) chart, lo and hi of the uniqueness boxes of the roots known; or ``Tubes``."""
    leaf_size: float
    columns: Columns
    variables: tuple[int, ...]
    """An entry for each variable of the search."""
    scratch: Scratch


@dataclass(frozen=True, eq=False)
class CellKind:
    """A kind of cells: what their columns mean, and the kernels that look at them."""

    columns: Columns
    symbols: Symbols
    variables: tuple[int, ...]
    """An entry for each variable of the search, so that the compiler knows how many there are."""
    enclose_cell: Callable[..., bool]
    """``enclose_cell(scratch, model, cell, lo, hi)``, compiled."""
    run_cells: Callable[..., tuple[int, int, int]]
    """``run_cells(context, stack, ...)``, compiled; see ``engine.search.Run``."""

    def scratch(self) -> Scratch:
        """Return the thread's scratch for these cells; only one search may use it at a time."""
        return scratch_of(self)

    def enclose(self, model: Model, cell: Floats, lo: Floats, hi: Floats) -> bool:
        """Enclose (u, p, t) of every equilibrium of the taut cables in a cell; False where that fails.

        Parameters
        ----------
        cell : (width,)
        lo, hi : (6 + n,) or (6,)
            Written; with six entries only the pose.
        """
        return bool(self.enclose_cell(self.scratch(), model, cell, lo, hi))

    def context(self, model: Model, roots: Any, leaf_size: float) -> Context:
        """Return what the compiled search looks at cells with in this thread."""
        return Context(model, roots, leaf_size, self.columns, self.variables, self.scratch())

    def run(self, model: Model, roots: Any, leaf_size: float) -> Run:
        """Bind the compiled search to its data and one thread's scratch; see ``Context``."""
        context = self.context(model, roots, leaf_size)

        def run(*stack: object) -> tuple[int, int, int]:
            return self.run_cells(context, *stack)

        return run


@per_thread
def scratch_of(kind: CellKind) -> Scratch:
    """Return a thread's scratch for a kind of cells."""
    return new_scratch(FORMS, WORK, kind.symbols, kind.columns.width)


ROTATION_CELLS = CellKind(
    ROTATION_COLUMNS, ROTATION_ONLY, VARIABLES_OF_ROTATION, rotation_cells.enclose_cell, rotation_cells.run
)
"""Cells in u, on one branch of the position or on both."""
POSE_CELLS = CellKind(POSE_COLUMNS, WHOLE_POSE, VARIABLES_OF_POSE, pose_cells.enclose_cell, pose_cells.run)
"""Cells in (u, x)."""
RANGED_ROTATION_CELLS = CellKind(
    ROTATION_COLUMNS,
    ROTATION_AND_DATA,
    VARIABLES_OF_ROTATION,
    rotation_cells.enclose_cell,
    ranged_cells.run_turns,
)
"""Cells in u of a robot whose lengths have ranges."""
RANGED_POSE_CELLS = CellKind(
    POSE_COLUMNS, POSE_AND_DATA, VARIABLES_OF_POSE, pose_cells.enclose_cell, ranged_cells.run_poses
)
"""Cells in (u, x) of such a robot."""
SPREAD_ROTATION_CELLS = replace(RANGED_ROTATION_CELLS, symbols=ROTATION_AND_ALL_DATA)
"""Cells in u of a robot whose points or load have ranges."""
SPREAD_POSE_CELLS = replace(RANGED_POSE_CELLS, symbols=POSE_AND_ALL_DATA)
"""Cells in (u, x) of such a robot."""
