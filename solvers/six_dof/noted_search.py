"""The compiled searches that take notes, bound to their data."""

from __future__ import annotations

from collections.abc import Callable
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

MOST_NOTES = 500_000
"""Cells that are noted at most: 60 or 110 MB. They make trees that the checker reads for an hour."""


class NotedTurns(Notes):
    """Notes of searches in u."""

    def __init__(self) -> None:
        super().__init__(noted_turn_cells.COLUMNS, noted_turn_cells.DATA, MOST_NOTES)

    def solver_run(self, model: Model, roots: Floats, leaf_size: float) -> Run:
        """Bind the solver's own search to its data and one thread's scratch.

        ``roots`` : their uniqueness boxes as ``rotation_cells`` has them.
        """
        data = (model, roots, leaf_size, ROTATION_ONLY, *form_arrays(ROTATION_ONLY, turn.WIDTH))
        return self.observed(bound(noted_turn_cells.run, data))

    def certified_run(self, model: Model, boxes: Floats, smallest: float) -> Run:
        """Bind the search by a certificate's rules.

        ``boxes`` : (m, 13) of roots, chart, then (lo, hi) of (u, x). Leaves: too small (SMALL), or to be
        handed on (FOLDED).
        """
        data = (model, boxes, smallest, ROTATION_ONLY, *form_arrays(ROTATION_ONLY, turn.WIDTH))
        return self.observed(bound(certified_turn_cells.run, data))


class NotedPoses(Notes):
    """Notes of searches in (u, x)."""

    def __init__(self) -> None:
        super().__init__(certified_pose_cells.COLUMNS, certified_pose_cells.DATA, MOST_NOTES)

    def certified_run(self, model: Model, boxes: Floats, smallest: float, unit: float) -> Run:
        """Bind the search by a certificate's rules; ``unit`` : the format's length in m."""
        data = (model, boxes, smallest, unit, WHOLE_POSE, *form_arrays(WHOLE_POSE, pose.P_WIDTH))
        return self.observed(bound(certified_pose_cells.run, data))


def bound(run: Any, data: tuple[Any, ...]) -> Callable[..., tuple[int, int, int]]:
    """Return a compiled search with its data: what a thread needs besides is made here."""
    states, verdicts = np.zeros((2, LANES), dtype=np.int64)

    def start(*rest: Any) -> tuple[int, int, int]:
        done: tuple[int, int, int] = run(*data, states, verdicts, *rest)
        return done

    return start
