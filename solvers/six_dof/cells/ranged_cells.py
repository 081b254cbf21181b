"""Cells of robots whose data have ranges: the tests of both kinds, and tubes instead of roots.

Arrays: as in ``cells.tests`` and as in ``tube_offsets``; ``scratch`` is a ``Scratch``, ``context`` is a
``kinds.Context``, ``cell`` (width,).
"""

from __future__ import annotations

from typing import Any

from cdpr_interval.engine.batch_cells import covers
from cdpr_interval.engine.batches import batches
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.lanes import Lanes, splat
from cdpr_interval.mechanics.six_dof.geometry import wrench_rows
from solvers.six_dof.cells import pose_cells as pose
from solvers.six_dof.cells import rotation_cells as turn
from solvers.six_dof.cells.tests import process_cells
from solvers.six_dof.cells.tube_offsets import offsets, read_offsets, settled_in_tubes


@kernel(inline="always")
def process_turns(context: Any, count: int, children: Any) -> None:
    """Exclude, contract, settle or split a batch of cells in u; see ``tests.process_cells``."""
    process_cells(turn.exclude, settled_in_tubes, turn.narrow_lanes, turn.verdict, context, count, children)


@kernel(inline="always")
def process_poses(context: Any, count: int, children: Any) -> None:
    """Exclude, contract, settle or split a batch of cells in (u, x); see ``tests.process_cells``."""
    process_cells(pose.exclude, settled_in_tubes, pose.narrow_lanes, pose.verdict, context, count, children)


@entry()
def run_turns(
    context: Any, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, cell_limit: int
) -> tuple[int, int, int]:
    """Search cells in u depth first; see ``engine.batches``."""
    return batches(process_turns, context, stack, count, leaves, kinds, children, cell_limit)


@entry()
def run_poses(
    context: Any, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, cell_limit: int
) -> tuple[int, int, int]:
    """Search cells in (u, x) depth first; see ``engine.batches``."""
    return batches(process_poses, context, stack, count, leaves, kinds, children, cell_limit)


@kernel(inline="always")
def bounded_offsets(scratch: Any, model: Any, tubes: Any, k: int, proved: Lanes, out: Any) -> bool:
    """Bound how far the equilibria of the cell in all lanes are from tube ``k``; see ``turn_offsets``.

    ``proved`` : 1 where the position is enclosed.
    """
    S, F, W, C = scratch.symbols, scratch.forms, scratch.work, scratch.cells
    wrench_rows(F, model, S)
    proved = proved * offsets(F, W, model, tubes, k, C, S)
    read_offsets(W, 0, model, out)
    return bool(covers(W, proved, splat(1.0)))


@entry()
def turn_offsets(scratch: Any, model: Any, cell: Any, tubes: Any, k: int, out: Any) -> bool:
    """Bound how far a cell in u (width,) has equilibria from tube ``k``, in out (6 + n,); False: unknown."""
    if cell[turn.BRANCH] == 0.0:
        return False
    proved = turn.fill(scratch, model, cell)
    return bounded_offsets(scratch, model, tubes, k, proved, out)


@entry()
def pose_offsets(scratch: Any, model: Any, cell: Any, tubes: Any, k: int, out: Any) -> bool:
    """Bound how far equilibria of a cell in (u, x) (width,) are from tube ``k``; see ``turn_offsets``."""
    pose.fill(scratch, model, cell)
    return bounded_offsets(scratch, model, tubes, k, splat(1.0), out)
