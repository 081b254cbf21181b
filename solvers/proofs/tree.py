"""The trees of one search as a certificate has them, put together from notes of what became of its cells.

A cell is a tuple of floats: bounds of u or of (u, x), its chart, and for u the side. Notes say what became of a
cell; what becomes of its parts is found under their own bounds, whoever looked at them, and when. A cell of which
there is no note is missing: it may be looked at later, or is written as pending.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine import notes
from cdpr_interval.engine.batch_cells import NO_LENGTH, NO_POSITION, NOT_SLACK, UNBALANCED
from certificates.tree import DEEPEST, Leaf, Node
from certificates.tree import Cell as Box

Floats = NDArray[np.float64]
Cell = tuple[float, ...]
Fate = tuple[Node | int, bytes, tuple[Cell, ...]]
"""The node, all its bytes, and the parts of the cell."""

TURNED = 8
"""Numbers of a cell in u; those of one in (u, x) are 13."""
LARGEST_Y = 2**31 - 1
"""The largest of 32 bits."""
NODES = {
    notes.IN_BOX: Node.ROOT,
    notes.UNDECIDED: Node.UNDECIDED,
    NO_POSITION: Node.NO_POSITION,
    NO_LENGTH: Node.NO_LENGTH,
    NOT_SLACK: Node.TOO_LONG,
    UNBALANCED: Node.UNBALANCED,
}
"""Leaves by their fate."""
PENDING = bytes([Node.PENDING])


class Trees:
    """What is known of the cells of one search.

    Parameters
    ----------
    cables
        The certificate's number of each of the model's cables.
    moments
        What the moments of a noted y are multiplied by.
    reach
        No entry of x is larger, in m.
    planar
        All poses lie in the plane y = 0.
    """

    def __init__(self, cables: Sequence[int], moments: float, reach: float, planar: bool) -> None:
        self.cables, self.moments = cables, moments
        most = [[-reach, reach] if k != 1 or not planar else [0.0, 0.0] for k in range(3)]
        self.everywhere = tuple(v for pair in most for v in pair)
        self.fates: dict[Cell, Fate] = {}
        self.tied: set[Cell] = set()
        """Cells cut by pivots that the checker may choose in another order."""

    def add(self, rows: Floats, columns: int) -> None:
        """Add notes; a later one of a cell counts."""
        for row in rows.tolist():
            cell = tuple(row[:columns])
            self.fates[cell] = self.fate(cell, int(row[columns]), row[columns + 1 :])

    def fate(self, cell: Cell, code: int, data: Sequence[float]) -> Fate:
        """Return what a note says."""
        if code < 6:
            return code, bytes([code]), halves(cell, code)
        if code == notes.SIDES:
            return Node.SIDES, bytes([Node.SIDES]), ((*cell[:-1], 1.0), (*cell[:-1], -1.0))
        if code == notes.HAND_ON:
            return Node.HAND_ON, bytes([Node.HAND_ON]), ((*cell[:6], *self.everywhere, cell[6]),)
        if code == notes.CUT:
            if data[12]:
                self.tied.add(cell)
            return self.cut(cell, tuple(data[:12]))
        node = NODES[code]
        if node is Node.TOO_LONG:
            return node, bytes([node, self.cables[int(data[0])]]), ()
        return node, bytes([node]) + (self.written_y(data) if node is Node.UNBALANCED else b""), ()

    def cut(self, cell: Cell, kept: Cell) -> Fate:
        """Return the node that cuts a cell to bounds of (u, x)."""
        changed = [k for k in range(6) if kept[2 * k : 2 * k + 2] != cell[2 * k : 2 * k + 2]]
        content = bytes([Node.CUT, sum(1 << k for k in changed)])
        content += b"".join(struct.pack("<dd", *kept[2 * k : 2 * k + 2]) for k in changed)
        return Node.CUT, content, ((*kept, cell[12]),)

    def written_y(self, data: Sequence[float]) -> bytes:
        """Return a direction in 32 bits, its moments divided by the format's length."""
        y = [v * (1.0 if k < 3 else self.moments) for k, v in enumerate(data[:6])]
        most = max(map(abs, y))
        fits = 0.0 < most < math.inf and not any(map(math.isnan, y))
        return struct.pack("<6i", *(round(LARGEST_Y * v / most) if fits else 0 for v in y))

    def split(self, cell: Cell, k: int) -> None:
        """Let a cell be halved, whatever became of it."""
        self.fates[cell] = k, bytes([k]), halves(cell, k)

    def encoded(self, start: Cell, is_doubtful: Callable[[Cell, Fate], bool]) -> bytes:
        """Return the tree of a cell; what is missing or doubtful is pending."""
        parts, waiting = [], [(start, 0)]
        while waiting:
            cell, depth = waiting.pop()
            found = None if depth > DEEPEST else self.fates.get(cell)
            if found is None or is_doubtful(cell, found):
                parts.append(PENDING)
            else:
                parts.append(found[1])
                waiting += [(part, depth + 1) for part in reversed(found[2])]
        return b"".join(parts)


def halves(cell: Cell, k: int) -> tuple[Cell, Cell]:
    """Return the halves of a cell in one entry."""
    middle = 0.5 * (cell[2 * k] + cell[2 * k + 1])
    return (
        (*cell[: 2 * k + 1], middle, *cell[2 * k + 2 :]),
        (*cell[: 2 * k], middle, *cell[2 * k + 1 :]),
    )


def leaf_of(cell: Cell, fate: Fate) -> Leaf:
    """Return a leaf or cut as the checker has it."""
    node, content, parts = fate
    assert isinstance(node, Node)
    data = struct.unpack("<6i", content[1:]) if node is Node.UNBALANCED else tuple(content[1:2])
    kept = box_of(parts[0]) if node is Node.CUT else None
    return Leaf(box_of(cell), node, () if node is Node.CUT else data, kept)


def box_of(cell: Cell) -> Box:
    """Return a cell as the checker has it."""
    count = 3 if len(cell) == TURNED else 6
    bounds = tuple((cell[2 * k], cell[2 * k + 1]) for k in range(count))
    return Box(int(cell[2 * count]), bounds, int(cell[7]) if count == 3 else 0)
