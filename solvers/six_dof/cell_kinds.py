"""The scratch arrays of one thread, and the kernels that enclose a single cell called with them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.per_thread import per_thread
from cdpr_interval.kernels.lanes import LANES
from cdpr_interval.kernels.second_order import ROTATION_ONLY, WHOLE_POSE, Symbols, width
from cdpr_interval.mechanics.six_dof.arrays import Model
from cdpr_interval.mechanics.six_dof.geometry import FORM_ROWS, WORK_SHAPE
from solvers.six_dof import pose_cells as pose
from solvers.six_dof import rotation_cells as turn

Floats = NDArray[np.float64]


class Scratch(NamedTuple):
    """Arrays that a kernel fills for a batch of cells; only one thread may use them at a time."""

    forms: Floats
    """(FORM_ROWS, width of a form, LANES)."""
    work: Floats
    """WORK_SHAPE."""
    cells: Floats
    """(1, width of a cell, LANES)."""


@per_thread
def form_arrays(symbols: Symbols, cell_width: int) -> Scratch:
    """Return a thread's scratch for cells of ``cell_width`` columns on these symbols."""
    forms = np.zeros((FORM_ROWS, width(symbols), LANES))
    return Scratch(forms, np.zeros(WORK_SHAPE), np.zeros((1, cell_width, LANES)))


def enclose_turn_cell(scratch: Scratch, model: Model, cell: Floats, lo: Floats, hi: Floats) -> bool:
    """Enclose (u, p, t) of every equilibrium in a cell in u; see ``rotation_cells.enclose_cell``."""
    forms, work, cells = scratch
    return bool(turn.enclose_cell(forms, work, model, cell, ROTATION_ONLY, cells, lo, hi))


def enclose_pose_cell(scratch: Scratch, model: Model, cell: Floats, lo: Floats, hi: Floats) -> bool:
    """Enclose (u, p, t) of every equilibrium in a cell in (u, x); see ``pose_cells.enclose_cell``."""
    forms, work, cells = scratch
    return bool(pose.enclose_cell(forms, work, model, cell, WHOLE_POSE, cells, lo, hi))
