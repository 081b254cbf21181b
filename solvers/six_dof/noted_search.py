"""The compiled searches that take notes, bound to their data."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.notes import Notes
from cdpr_interval.engine.search import Run
from cdpr_interval.kernels.lanes import LANES
from cdpr_interval.kernels.second_order import ROTATION_ONLY, WHOLE_POSE
from cdpr_interval.mechanics.six_dof.arrays import Model
from solvers.six_dof import certified_pose_cells, certified_turn_cells, noted_turn_cells
from solvers.six_dof import pose_cells as pose
from solvers.six_dof import rotation_cells as turn
from solvers.six_dof.cell_kinds import form_arrays

Floats = NDArray[np.float64]


def turn_notes(most: int) -> Notes:
    """Return room for the notes of a search in u."""
    return Notes(noted_turn_cells.COLUMNS, noted_turn_cells.DATA, most)


def pose_notes(most: int) -> Notes:
    """Return room for the notes of a search in (u, x)."""
    return Notes(certified_pose_cells.COLUMNS, certified_pose_cells.DATA, most)


def noted_turn_run(notes: Notes, model: Model, roots: Floats, leaf_size: float) -> Run:
    """Bind the solver's search in u to its data and one thread's scratch.

    ``roots`` : their uniqueness boxes as ``rotation_cells`` has them.
    """
    scratch = form_arrays(ROTATION_ONLY, turn.WIDTH)
    return bound(notes, noted_turn_cells.run, model, roots, leaf_size, ROTATION_ONLY, *scratch)


def certified_turn_run(notes: Notes, model: Model, boxes: Floats, smallest: float) -> Run:
    """Bind the search in u by a certificate's rules.

    ``boxes`` : (m, 13) of roots, chart, then (lo, hi) of (u, x). Leaves: too small (SMALL), to be handed on (FOLDED).
    """
    scratch = form_arrays(ROTATION_ONLY, turn.WIDTH)
    return bound(notes, certified_turn_cells.run, model, boxes, smallest, ROTATION_ONLY, *scratch)


def certified_pose_run(notes: Notes, model: Model, boxes: Floats, smallest: float, unit: float) -> Run:
    """Bind the search in (u, x) by a certificate's rules; ``unit`` : the format's length in m."""
    scratch = form_arrays(WHOLE_POSE, pose.P_WIDTH)
    return bound(notes, certified_pose_cells.run, model, boxes, smallest, unit, WHOLE_POSE, *scratch)


def bound(notes: Notes, run: Any, *data: Any) -> Run:
    """Return a compiled search with its data and what a thread needs."""
    states, verdicts = np.zeros((2, LANES), dtype=np.int64)

    def start(*rest: Any) -> tuple[int, int, int]:
        done: tuple[int, int, int] = run(*data, states, verdicts, *rest)
        return done

    return notes.observed(start)
