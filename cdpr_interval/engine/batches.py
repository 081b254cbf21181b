"""The inner loop of branch and prune for problems that look at ``LANES`` cells at once; see ``depth_first``.

A problem gives ``process(context, count, children)``, which reads and writes ``context.scratch``:

* ``cells`` (1, width, LANES): the batch, one column of a cell a row of lanes; it may be overwritten. Lanes
  from ``count`` on repeat the last cell and their verdicts are not read.
* ``verdicts`` (LANES,): for every lane 0, the number of children (1 or 2), or minus the kind of a leaf.

It writes to ``children`` (2 LANES, width) those of lane j in the rows 2 j, 2 j + 1; a leaf in row 2 j.

What becomes of a cell must not depend on its neighbours; then the set of leaves is the same for any
order and any number of threads.
"""

from __future__ import annotations

from typing import Any

from cdpr_interval.kernels.kernel import part
from cdpr_interval.kernels.lanes import LANES

CHILDREN = 2
"""Most children of a cell."""


# Inlined into its caller: numba does not cache a call that passes a function as a value.
@part()
def batches(
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
        The problem, see above; its ``context`` is a ``NamedTuple`` with a ``Scratch`` called ``scratch``.
    stack : (capacity, width)
        Cells; rows ``0 .. count - 1`` are pending on entry and on return.
    leaves, kinds : (m, width), (m,)
        Filled with the leaves found and their kinds.
    children : (2 LANES, width)
        Scratch.
    cell_limit
        Cells looked at before returning.

    Returns
    -------
    count, n_leaves, cells
        Pending rows, leaves written, cells looked at.
    """
    n_leaves = 0
    done = 0
    cells, verdicts = context.scratch.cells, context.scratch.verdicts
    width = stack.shape[1]
    room = stack.shape[0] - CHILDREN * LANES
    while 0 < count <= room and done < cell_limit and n_leaves + LANES <= leaves.shape[0]:
        batch = min(LANES, count, cell_limit - done)
        count -= batch
        done += batch
        for lane in range(LANES):
            row = count + min(lane, batch - 1)
            for k in range(width):
                cells[0, k, lane] = stack[row, k]
        process(context, batch, children)
        for lane in range(batch):
            verdict = verdicts[lane]
            row = CHILDREN * lane
            if verdict < 0:
                kinds[n_leaves] = -verdict
                for k in range(width):
                    leaves[n_leaves, k] = children[row, k]
                n_leaves += 1
            else:
                for i in range(verdict):
                    for k in range(width):
                        stack[count + i, k] = children[row + i, k]
                count += verdict
    return count, n_leaves, done
