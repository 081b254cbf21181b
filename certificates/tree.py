"""The search tree of one chart: bytes that split it into cells, each with the reason why it is settled."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from enum import IntEnum

from certificates.clock import in_time
from certificates.verdicts import Malformed

DEEPEST = 400
"""Most nodes above a leaf."""


class Node(IntEnum):
    """The first byte of a node. 0 to 5: the cell is halved in that entry of (u, x)."""

    SIDES = 6
    """The two sides of the plane of the centres, + first."""
    CUT = 7
    """The lengths cannot hold in the rest of the cell, on its side: a byte of bits, then new bounds."""
    HAND_ON = 8
    """From cells in u to cells in (u, x)."""
    NO_POSITION = 16
    NO_LENGTH = 17
    TOO_LONG = 18
    """Then a byte: the cable."""
    UNBALANCED = 19
    """Then y: six integers of 32 bits."""
    ROOT = 20
    PENDING = 21
    UNDECIDED = 22

    @property
    def reason(self) -> str:
        """What a leaf says."""
        return self.name.lower().replace("_", " ")


LEAVES = {int(node): node for node in tuple(Node)[3:]}
DATA = {int(Node.TOO_LONG): "B", int(Node.UNBALANCED): "6i"}
"""What follows the byte of a leaf."""


@dataclass(frozen=True)
class Cell:
    """A box of poses. ``bounds`` of u, or of u and x: pairs of doubles."""

    chart: int
    bounds: tuple[tuple[float, float], ...]
    side: int = 0

    @property
    def placed(self) -> bool:
        """The cell is a box in x too."""
        return len(self.bounds) == 6

    def with_bounds(self, k: int, lo: float, hi: float) -> Cell:
        """Return the cell with other bounds of one entry."""
        return Cell(self.chart, (*self.bounds[:k], (lo, hi), *self.bounds[k + 1 :]), self.side)

    def halves(self, k: int) -> tuple[Cell, Cell]:
        """Return the halves in one entry, split at the double nearest to the middle."""
        lo, hi = self.bounds[k]
        middle = 0.5 * (lo + hi)
        return self.with_bounds(k, lo, middle), self.with_bounds(k, middle, hi)


@dataclass(frozen=True)
class Leaf:
    """A cell and what is said of it: no pose (and why), all poses known, or nothing; or a cut."""

    cell: Cell
    node: Node
    data: tuple[int, ...] = ()
    """The cable that is too long; y."""
    kept: Cell | None = None
    """What is left of a cell that is cut."""


def decode(content: bytes, start: Cell, reach: float, planar: bool) -> Iterator[Leaf]:
    """Yield the leaves and cuts of a tree in the order of its bytes.

    ``reach`` : no entry of x is larger. Raises `Malformed`.
    """
    place = 0

    def take(form: str) -> tuple[float, ...]:
        nonlocal place
        try:
            found = struct.unpack_from("<" + form, content, place)
        except struct.error:
            raise Malformed("a tree ends too early") from None
        place += struct.calcsize("<" + form)
        return found

    waiting = [(start, 0)]
    while waiting:
        in_time()
        cell, depth = waiting.pop()
        if depth > DEEPEST:
            raise Malformed("a tree is too deep")
        code = int(take("B")[0])
        below: tuple[Cell, ...] = ()
        if code < 6:
            below = halved(cell, code)
        elif code == Node.SIDES and not cell.placed and cell.side == 0:
            below = (replace(cell, side=1), replace(cell, side=-1))
        elif code == Node.HAND_ON and not cell.placed:
            most = [(-reach, reach) if k != 1 or not planar else (0.0, 0.0) for k in range(3)]
            below = (Cell(cell.chart, (*cell.bounds, *most)),)
        elif code == Node.CUT and (cell.placed or cell.side != 0):
            kept = cut(cell, take)
            yield Leaf(cell, Node.CUT, kept=kept)
            below = (kept,)
        elif code in LEAVES and not (code == Node.NO_POSITION and cell.placed):
            yield Leaf(cell, LEAVES[code], tuple(map(int, take(DATA[code]))) if code in DATA else ())
        else:
            raise Malformed(f"a tree has a node {code} where none such can be")
        waiting += [(child, depth + 1) for child in reversed(below)]
    if place != len(content):
        raise Malformed("bytes follow the end of a tree")


def halved(cell: Cell, k: int) -> tuple[Cell, Cell]:
    """Return both halves, refused where there are none."""
    if k >= len(cell.bounds):
        raise Malformed("a tree splits x before it has bounds")
    lo, hi = cell.bounds[k]
    if not lo < 0.5 * (lo + hi) < hi:
        raise Malformed("a tree splits a cell that is too small")
    return cell.halves(k)


def cut(cell: Cell, take: Callable[[str], tuple[float, ...]]) -> Cell:
    """Return what is left of a cell, refused where an entry is cut that it does not have."""
    mask = int(take("B")[0])
    if mask >> len(cell.bounds):
        raise Malformed("a tree cuts an entry that its cell does not have")
    for k in range(len(cell.bounds)):
        if mask >> k & 1:
            lo, hi = take("dd")
            cell = narrowed(cell, k, lo, hi)
    return cell


def narrowed(cell: Cell, k: int, lo: float, hi: float) -> Cell:
    """Return the cell with new bounds of one entry, refused where they do not lie within the old ones."""
    old = cell.bounds[k]
    if not (math.isfinite(lo) and math.isfinite(hi) and old[0] <= lo <= hi <= old[1]):
        raise Malformed("a tree cuts a cell to bounds outside it")
    return cell.with_bounds(k, lo, hi)
