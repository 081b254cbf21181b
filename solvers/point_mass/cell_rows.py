"""Cells of positions of a point mass: rows of numbers, cut in halves.

A cell is a row ``x lo, x hi, y lo, y hi, z lo, z hi, share``, (WIDTH,) ; ``box`` (3, 2) of positions;
``children`` (>= 2, WIDTH).
"""

from __future__ import annotations

from typing import Any

from cdpr_interval.kernels.interval import mid
from cdpr_interval.kernels.kernel import entry

WIDTH = 7
SHARE = 6
SMALL = 2
"""Leaf: smaller than the smallest width, neither proved nor excluded."""


@entry()
def box_of(cell: Any, box: Any) -> None:
    """Write the box of a cell."""
    for j in range(3):
        box[j, 0], box[j, 1] = cell[2 * j], cell[2 * j + 1]


@entry()
def keep(box: Any, cell: Any, child: Any) -> None:
    """Write what a box has left of a cell to a row (WIDTH,)."""
    for j in range(3):
        child[2 * j], child[2 * j + 1] = box[j, 0], box[j, 1]
    child[SHARE] = cell[SHARE]


@entry()
def widest(box: Any) -> int:
    """Return the widest side of a box."""
    side = 0
    for j in range(3):
        if box[j, 1] - box[j, 0] > box[side, 1] - box[side, 0]:
            side = j
    return side


@entry()
def halve(box: Any, side: int, smallest: float, children: Any) -> int:
    """Cut the first of the children, whose box is given, along a side; one no wider than ``smallest`` stays.

    Returns
    -------
    int
        2, or -``SMALL``: see `cdpr_interval.engine.depth_first`.
    """
    middle = mid(box[side, 0], box[side, 1])
    if box[side, 1] - box[side, 0] <= smallest or not box[side, 0] < middle < box[side, 1]:
        return -SMALL
    for j in range(WIDTH):
        children[1, j] = children[0, j]
    children[0, 2 * side + 1] = middle
    children[1, 2 * side] = middle
    children[0, SHARE] = children[1, SHARE] = 0.5 * children[0, SHARE]
    return 2
