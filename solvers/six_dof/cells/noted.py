"""The compiled searches that take notes, bound to their data."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.notes import Notes
from cdpr_interval.engine.scratch import Scratch
from cdpr_interval.engine.search import Run
from cdpr_interval.mechanics.six_dof.arrays import Model
from solvers.six_dof.cells import certified_pose_cells, certified_rotation_cells, noted_rotation_cells
from solvers.six_dof.cells.kinds import (
    POSE_CELLS,
    RANGED_POSE_CELLS,
    RANGED_ROTATION_CELLS,
    ROTATION_CELLS,
    Context,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_NOTES = 500_000
"""Cells that are noted at most: 60 or 110 MB. They make trees that the checker reads for an hour."""


class Noted(NamedTuple):
    """What the solver's own search looks at cells with while notes are taken."""

    model: Model
    scratch: Scratch
    search: Context
    """Of the search that is observed."""
    notes: Floats
    """(rows, width) see ``engine.notes``."""
    noted: Ints
    """(1,) rows used so far."""


class Certified(NamedTuple):
    """What a search by a certificate's rules looks at cells with."""

    model: Model
    scratch: Scratch
    boxes: Floats
    """(m, 13) of roots: chart, then (lo, hi) of (u, x)."""
    smallest: float
    """Width at which a cell is given up."""
    unit: float
    """The format's length in m."""
    notes: Floats
    noted: Ints


class NotedTurns(Notes):
    """Notes of searches in u."""

    def __init__(self) -> None:
        super().__init__(noted_rotation_cells.COLUMNS, noted_rotation_cells.DATA, MOST_NOTES)

    def solver_run(self, model: Model, roots: Floats, leaf_size: float) -> Run:
        """Bind the solver's own search to its data and one thread's scratch.

        ``roots`` : their uniqueness boxes as ``kinds.Context`` has them.
        """
        search = ROTATION_CELLS.context(model, roots, leaf_size)

        def context(notes: Floats, noted: Ints) -> Noted:
            return Noted(model, search.scratch, search, notes, noted)

        return self.observed(noted_rotation_cells.run, context)

    def certified_run(self, model: Model, boxes: Floats, smallest: float, ranged: bool) -> Run:
        """Bind the search by a certificate's rules; see `Certified`. ``ranged``: lengths have symbols.

        Leaves: too small (SMALL), or to be handed on (FOLDED).
        """
        kind = RANGED_ROTATION_CELLS if ranged else ROTATION_CELLS

        def context(notes: Floats, noted: Ints) -> Certified:
            return Certified(model, kind.scratch(), boxes, smallest, 1.0, notes, noted)

        return self.observed(certified_rotation_cells.run, context)


class NotedPoses(Notes):
    """Notes of searches in (u, x)."""

    def __init__(self) -> None:
        super().__init__(certified_pose_cells.COLUMNS, certified_pose_cells.DATA, MOST_NOTES)

    def certified_run(self, model: Model, boxes: Floats, smallest: float, ranged: bool, unit: float) -> Run:
        """Bind the search by a certificate's rules; see `Certified`. ``ranged``: lengths have symbols."""
        kind = RANGED_POSE_CELLS if ranged else POSE_CELLS

        def context(notes: Floats, noted: Ints) -> Certified:
            return Certified(model, kind.scratch(), boxes, smallest, unit, notes, noted)

        return self.observed(certified_pose_cells.run, context)
