"""The arrays that kernels fill for a batch of cells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.rows import Table
from cdpr_interval.kernels.lanes import LANES
from cdpr_interval.kernels.second_order import Symbols, width

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Scratch(NamedTuple):
    """What one thread's kernels work in; kernels call the first four S, F, W and C."""

    symbols: Symbols
    """The forms' symbols."""
    forms: Floats
    """(rows, columns of a form, LANES); the rows have names in a table."""
    work: Floats
    """(rows, columns, LANES); the rows have names in a table."""
    cells: Floats
    """(1, width of a cell, LANES) the cells, one column of a cell a row of lanes."""
    states: Ints
    """(LANES,) what is known of each lane's cell, see ``engine.rows``."""
    verdicts: Ints
    """(LANES,) what becomes of it, see ``engine.batches``."""


def new_scratch(forms: Table, work: Table, symbols: Symbols, cell_width: int) -> Scratch:
    """Return arrays as high as the tables, for cells of ``cell_width`` columns."""
    return Scratch(
        symbols,
        np.zeros((forms.height, width(symbols), LANES)),
        np.zeros((work.height, work.columns, LANES)),
        np.zeros((1, cell_width, LANES)),
        np.zeros(LANES, dtype=np.int64),
        np.zeros(LANES, dtype=np.int64),
    )
