"""The inner loop of branch and prune for problems that look at ``LANES`` cells at once; see ``depth_first``.

A problem gives ``process(context, count, children)``, which reads and writes ``context.scratch``:

* ``cells`` (1, width, LANES): the batch, one column of a cell a row of lanes; it may be overwritten. Lanes
  from ``count`` on repeat the last cell and their verdicts are not read.
* ``verdicts`` (LANES,): for every lane 0, the number of children (1 or 2), or minus the kind of a leaf.

It writes to ``children`` (2 LANES, width) those of lane j in the rows 2 j, 2 j + 1; a leaf in row 2 j.

A problem may look at every cell alone before (``gathered``), by ``admit(context, lane, children)``, which
finds it in its lane of ``cells`` and returns such a verdict, or ADMITTED: batches are then made of admitted
cells, which that function may have cut.

What becomes of a cell must not depend on its neighbours; then the set of leaves is the same for any
order and any number of threads.
"""

from __future__ import annotations

from typing import Any

from cdpr_interval.kernels.kernel import part
from cdpr_interval.kernels.lanes import LANES

CHILDREN = 2
"""Most children of a cell."""
ADMITTED = 3
"""Verdict on a cell that is to be part of a batch."""


@part()
def take(stack: Any, row: int, cells: Any, lane: int) -> None:
    """Copy a row of the stack to a lane."""
    for k in range(stack.shape[1]):
        cells[0, k, lane] = stack[row, k]


@part()
def deliver(
    verdict: int, lane: int, children: Any, stack: Any, count: int, leaves: Any, kinds: Any, n_leaves: int
) -> tuple[int, int]:
    """Put what became of a lane's cell on the stack or among the leaves; return how many these hold."""
    row = CHILDREN * lane
    if verdict < 0:
        kinds[n_leaves] = -verdict
        for k in range(stack.shape[1]):
            leaves[n_leaves, k] = children[row, k]
        return count, n_leaves + 1
    for i in range(verdict):
        for k in range(stack.shape[1]):
            stack[count + i, k] = children[row + i, k]
    return count + verdict, n_leaves


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
    room = stack.shape[0] - CHILDREN * LANES
    while 0 < count <= room and done < cell_limit and n_leaves + LANES <= leaves.shape[0]:
        batch = min(LANES, count, cell_limit - done)
        count -= batch
        done += batch
        for lane in range(LANES):
            take(stack, count + min(lane, batch - 1), cells, lane)
        process(context, batch, children)
        for lane in range(batch):
            count, n_leaves = deliver(verdicts[lane], lane, children, stack, count, leaves, kinds, n_leaves)
    return count, n_leaves, done


@part()
def gathered(
    admit: Any,
    process: Any,
    context: Any,
    stack: Any,
    count: int,
    leaves: Any,
    kinds: Any,
    children: Any,
    cell_limit: int,
) -> tuple[int, int, int]:
    """Explore as ``batches`` does, in batches of cells that ``admit`` has let in.

    Parameters and results as there. Each cell counts once. Cells that were admitted when a limit is reached
    are processed before it returns.
    """
    n_leaves = 0
    done = 0
    cells, verdicts = context.scratch.cells, context.scratch.verdicts
    # What a batch leaves, and what the cell looked at last does.
    room, most = stack.shape[0] - CHILDREN * LANES - 1, leaves.shape[0] - LANES - 1
    while 0 < count <= room and done < cell_limit and n_leaves <= most:
        batch = 0
        while batch < LANES and 0 < count <= room and done < cell_limit and n_leaves <= most:
            count -= 1
            done += 1
            take(stack, count, cells, batch)
            verdict = admit(context, batch, children)
            if verdict == ADMITTED:
                batch += 1
            else:
                count, n_leaves = deliver(verdict, batch, children, stack, count, leaves, kinds, n_leaves)
        for lane in range(batch, LANES if batch > 0 else 0):
            for k in range(stack.shape[1]):
                cells[0, k, lane] = cells[0, k, batch - 1]
        if batch > 0:
            process(context, batch, children)
        for lane in range(batch):
            count, n_leaves = deliver(verdicts[lane], lane, children, stack, count, leaves, kinds, n_leaves)
    return count, n_leaves, done
