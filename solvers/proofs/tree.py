"""The trees of one search as a certificate has them, put together from notes of what became of its cells.

A cell is a tuple of floats: bounds of u or of (u, x), its chart, and for u the side. Notes say what became of
a cell; what becomes of its parts is found under their own bounds, whoever looked at them, and when. A cell of
which there is no note is missing: it may be looked at later, or is written as pending.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine import notes
from cdpr_interval.engine.rows import NO_LENGTH, NO_POSITION, NOT_SLACK, UNBALANCED
from certificates.tree import DEEPEST, Leaf, Node
from certificates.tree import Cell as Box

Floats = NDArray[np.float64]
Cell = tuple[float, ...]
TURNED = 8
"""Numbers of a cell in u; those of one in (u, x) are 13."""
LARGEST_Y = 2**31 - 1
"""The largest of 32 bits."""
NODES = {
    notes.SIDES: Node.SIDES,
    notes.HAND_ON: Node.HAND_ON,
    notes.IN_BOX: Node.ROOT,
    notes.UNDECIDED: Node.UNDECIDED,
    NO_POSITION: Node.NO_POSITION,
    NO_LENGTH: Node.NO_LENGTH,
    NOT_SLACK: Node.TOO_LONG,
    UNBALANCED: Node.UNBALANCED,
}
"""Nodes by their fate."""
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
        self.nodes: dict[Cell, bytes] = {}
        """The node of each cell, as it is written."""
        self.tied: set[Cell] = set()
        """Cells cut by pivots instead of which the checker may choose others, and all cut cells in u:
        it has its own way to the position there."""

    def add(self, rows: Floats, columns: int) -> None:
        """Add notes of cells with so many columns; a later one of a cell counts."""
        for row in rows.tolist():
            cell = tuple(row[:columns])
            self.nodes[cell] = self.node(cell, int(row[columns]), row[columns + 1 :])

    def node(self, cell: Cell, fate: int, data: Sequence[float]) -> bytes:
        """Return the node that a note of a cell is written as."""
        if fate < 6:
            return bytes([fate])
        if fate == notes.CUT:
            entries = 3 if len(cell) == TURNED else 6
            if data[2 * entries] or entries == 3:
                self.tied.add(cell)
            changed = [k for k in range(entries) if (data[2 * k], data[2 * k + 1]) != cell[2 * k : 2 * k + 2]]
            bounds = (struct.pack("<dd", *data[2 * k : 2 * k + 2]) for k in changed)
            return bytes([Node.CUT, sum(1 << k for k in changed)]) + b"".join(bounds)
        node = NODES[fate]
        if node is Node.TOO_LONG:
            return bytes([node, self.cables[int(data[0])]])
        return bytes([node]) + (self.written_y(data[:6]) if node is Node.UNBALANCED else b"")

    def written_y(self, y: Sequence[float]) -> bytes:
        """Return a direction in 32 bits, its moments divided by the format's length."""
        y = [v * (1.0 if k < 3 else self.moments) for k, v in enumerate(y)]
        most = max(map(abs, y))
        fits = most > 0.0 and LARGEST_Y * most < math.inf and not any(map(math.isnan, y))
        return struct.pack("<6i", *(round(LARGEST_Y * v / most) if fits else 0 for v in y))

    def parts(self, cell: Cell, node: bytes) -> tuple[Cell, ...]:
        """Return the cells below a node."""
        code = node[0]
        if code < 6:
            return halves(cell, code)
        if code == Node.SIDES:
            return (*cell[:7], 1.0), (*cell[:7], -1.0)
        if code == Node.HAND_ON:
            return ((*cell[:6], *self.everywhere, cell[6]),)
        if code == Node.CUT:
            kept, left = list(cell), [k for k in range(6) if node[1] >> k & 1]
            for i, k in enumerate(left):
                kept[2 * k : 2 * k + 2] = struct.unpack_from("<dd", node, 2 + 16 * i)
            return (tuple(kept),)
        return ()

    def encoded(self, start: Cell, is_doubtful: Callable[[Cell, bytes], bool]) -> bytes:
        """Return the tree of a cell; what is missing or doubtful is pending."""
        content, waiting = [], [(start, 0)]
        while waiting:
            cell, depth = waiting.pop()
            node = None if depth > DEEPEST else self.nodes.get(cell)
            if node is None or is_doubtful(cell, node):
                content.append(PENDING)
            else:
                content.append(node)
                waiting += [(part, depth + 1) for part in reversed(self.parts(cell, node))]
        return b"".join(content)

    def leaf(self, cell: Cell, node: bytes) -> Leaf:
        """Return a leaf or cut as the checker has it."""
        code = Node(node[0])
        if code is Node.CUT:
            return Leaf(box_of(cell), code, kept=box_of(self.parts(cell, node)[0]))
        return Leaf(box_of(cell), code, struct.unpack("<6i", node[1:]) if len(node) > 2 else tuple(node[1:]))


def halves(cell: Cell, k: int) -> tuple[Cell, Cell]:
    """Return the halves of a cell in one entry."""
    middle = 0.5 * (cell[2 * k] + cell[2 * k + 1])
    return (
        (*cell[: 2 * k + 1], middle, *cell[2 * k + 2 :]),
        (*cell[: 2 * k], middle, *cell[2 * k + 1 :]),
    )


def box_of(cell: Cell) -> Box:
    """Return a cell as the checker has it."""
    count = 3 if len(cell) == TURNED else 6
    bounds = tuple((cell[2 * k], cell[2 * k + 1]) for k in range(count))
    return Box(int(cell[2 * count]), bounds, int(cell[7]) if count == 3 else 0)
