"""What became of the cells of a search, noted by an observer while it runs: the record of a proof.

A note is one row of float64: the cell as it was taken from the stack (its columns but the last, its
share), its fate, and data that belong to the fate. Cells whose fate has no word here are not noted. A problem
is observed by a ``process`` around its own one, which copies the cells, calls it, and adds the fates; the
engine itself does not know of observers, and a search that nobody observes has none of their code.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.search import CHUNK_CELLS, Run
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LaneArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

UNNOTED = -1
"""The fate of a cell that is not noted."""
SIDES, CUT, HAND_ON, IN_BOX, UNDECIDED = range(32, 37)
"""Fates: the two branches; cut to bounds; to be searched with more variables; within a root's box; too small
to be halved. 0 to 5: halved in that variable; the states of lanes proved empty stand for themselves."""


@kernel()
def begin_notes(C: LaneArray, count: int, notes: Any, noted: Any, columns: int) -> None:
    """Copy the first cells of a batch to the next rows of ``notes``.

    ``C`` : (1, width, LANES); ``notes`` : (rows, > columns); ``noted`` : (1,) rows used so far.
    """
    for lane in range(count):
        for k in range(columns):
            notes[noted[0] + lane, k] = C[0, k, lane]


@kernel()
def halved_in(C: LaneArray, note: Any, lane: int, variables: int, children: Any) -> int:
    """Return the variable in which a cell was halved; UNNOTED where its bounds were changed before.

    ``C`` : (1, width, LANES); ``note`` : (> 2 variables,) the cell as it was, bounds first; ``children`` :
    (2 LANES, width).
    """
    found = UNNOTED
    for k in range(variables):
        if C[0, 2 * k, lane] != note[2 * k] or C[0, 2 * k + 1, lane] != note[2 * k + 1]:
            return UNNOTED
        if children[2 * lane, 2 * k + 1] != note[2 * k + 1]:
            found = k
    return found


class Notes:
    """The notes of a search; several threads may add to them.

    Parameters
    ----------
    columns
        Columns of a cell that are noted.
    data
        Columns of data.
    most
        Notes kept at most: later ones are lost, and with them a part of the record.
    """

    def __init__(self, columns: int, data: int, most: int) -> None:
        self.columns, self.width = columns, columns + 1 + data
        self.room = most
        self.rows: list[Floats] = []
        self._lock = threading.Lock()

    def observed(
        self, run: Callable[..., tuple[int, int, int]], context: Callable[[Floats, Ints], Any]
    ) -> Run:
        """Return a thread's run that takes notes: ``run(context(notes, noted), *stack)`` writes them."""
        notes, noted = np.empty((CHUNK_CELLS, self.width)), np.zeros(1, dtype=np.int64)
        own = context(notes, noted)

        def observed_run(*stack: Any) -> tuple[int, int, int]:
            noted[0] = 0
            done = run(own, *stack)
            self.add(notes[: noted[0]])
            return done

        return observed_run

    def add(self, notes: Floats) -> None:
        """Keep a copy of the notes that say something."""
        with self._lock:
            kept = notes[notes[:, self.columns] != UNNOTED][: self.room]
            self.room -= len(kept)
            self.rows.append(kept)

    def taken(self) -> Floats:
        """Return all notes so far and forget them."""
        with self._lock:
            found = np.concatenate([*self.rows, np.empty((0, self.width))])
            self.rows.clear()
            return found
