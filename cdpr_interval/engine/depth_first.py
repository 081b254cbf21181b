"""The inner loop of branch and prune: depth first over a stack of cells, compiled with its problem.

A cell is one row of float64; what its columns mean is the problem's business, except for the
last one, which holds the cell's share of the whole search volume (for progress only).

A problem gives ``process(context, cell, children) -> int``:

* 0: the cell is proved empty (or settled otherwise);
* k > 0: the cell is replaced by the k cells written to the first rows of ``children``;
* -k < 0: the cell is a leaf of kind k, written (perhaps contracted) to ``children[0]``.

``process`` must depend on the context and the cell only; then the set of leaves is the same
for any order and any number of threads.
"""

from __future__ import annotations

from typing import Any

import cdpr_interval.kernels  # noqa: F401  its cache
from cdpr_interval.kernels.kernel import part

MAX_CHILDREN = 4
"""Rows of ``children`` a problem may fill."""


# Inlined into its caller: numba does not cache a call that passes a function as a value.
@part()
def depth_first(
    process: Any,
    context: Any,
    stack: Any,
    count: int,
    leaves: Any,
    kinds: Any,
    children: Any,
    cell_limit: int,
) -> tuple[int, int, int]:
    """Explore the first ``count`` rows of ``stack`` until it is empty or a limit is reached.

    Parameters
    ----------
    process, context
        The problem, see above.
    stack : (capacity, width)
        Cells; rows ``0 .. count - 1`` are pending on entry and on return.
    leaves, kinds : (m, width), (m,)
        Filled with the leaves found and their kinds.
    children : (>= MAX_CHILDREN, width)
        Scratch.
    cell_limit
        Cells looked at before returning.

    Returns
    -------
    count, n_leaves, cells
        Pending rows, leaves written, cells looked at.
    """
    n_leaves = 0
    cells = 0
    width = stack.shape[1]
    room = stack.shape[0] - MAX_CHILDREN
    while 0 < count <= room and cells < cell_limit and n_leaves < leaves.shape[0]:
        count -= 1
        cells += 1
        verdict = process(context, stack[count], children)
        if verdict < 0:
            kinds[n_leaves] = -verdict
            for k in range(width):
                leaves[n_leaves, k] = children[0, k]
            n_leaves += 1
        else:
            for i in range(verdict):
                for k in range(width):
                    stack[count + i, k] = children[i, k]
            count += verdict
    return count, n_leaves, cells
