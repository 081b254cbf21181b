"""What cells of both kinds are put to: tests that empty them, equations that contract them.

Arrays: ``F`` (rows, columns of a form, LANES) forms, ``W`` (rows, columns, LANES) scratch, both with the
rows of ``engine.rows`` and ``mechanics.six_dof.rows``; ``C`` (1, width of a cell, LANES) cells, ``states``
(LANES,) of them; ``S`` the forms' symbols; ``model`` is an ``arrays.Model``; ``children`` (2 LANES, width).

Kernels that are given a model and called once are inlined: each call would count references to its arrays.
"""

from __future__ import annotations

from typing import Any

from cdpr_interval.engine.batch_cells import any_open, contract_open, mark, open_first, open_lanes
from cdpr_interval.engine.contraction import blank, cannot_vanish
from cdpr_interval.engine.rows import EQUATION, NO_LENGTH, NOT_SLACK, UNBALANCED, UNLOADED
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LaneArray
from cdpr_interval.kernels.second_order import Forms, Symbols
from cdpr_interval.mechanics.six_dof.balance import balance_free, limit_tensions, statics_equations
from cdpr_interval.mechanics.six_dof.directions import centre_columns
from cdpr_interval.mechanics.six_dof.geometry import wrench_rows
from cdpr_interval.mechanics.six_dof.rows import DIMENSIONS, MOST_TAUT, U_SYMBOLS
from cdpr_interval.mechanics.six_dof.unloaded import unloaded
from solvers.six_dof.cells.bounds import slack_excluded


@kernel(inline="always")
def exclude_by_length(F: Forms, W: LaneArray, row: int, states: Any, S: Symbols) -> bool:
    """Mark open lanes where a length's equation cannot hold; True when a lane is still open."""
    return bool(mark(W, cannot_vanish(F, row, S), states, NO_LENGTH))


@kernel(inline="always")
def exclude_by_slack(F: Forms, W: LaneArray, model: Any, states: Any, S: Symbols) -> bool:
    """Mark open lanes where another cable would be too long; True when a lane is still open."""
    if not (model.slack and any_open(states)):
        return bool(any_open(states))
    return bool(mark(W, slack_excluded(F, W, model, open_lanes(W, states), S), states, NOT_SLACK))


@kernel(inline="always")
def exclude_by_balance(F: Forms, W: LaneArray, model: Any, rank: int, states: Any, S: Symbols) -> bool:
    """Write the wrenches; give open lanes without a balance their states; True when a lane is still open.

    The direction y that proves a lane UNBALANCED stands in W[Y].
    """
    wrench_rows(F, model, S)
    if model.hanging and not mark(W, unloaded(F, W, model, rank, S), states, UNLOADED):
        return False
    if not model.statics:
        return True
    n = model.n_taut
    centre_columns(F, W, n)
    return bool(mark(W, balance_free(F, W, n, rank, open_lanes(W, states), S), states, UNBALANCED))


@kernel(inline="always")
def balance_equations(
    F: Forms, W: LaneArray, model: Any, lengths: int, rank: int, variables: int, S: Symbols
) -> int:
    """Write equations of the statics behind those of the lengths in EQUATION..; return how many there are.

    In (u, x) the pivots stay in them: the contraction solves for all ``variables`` at once. Where tension
    signs are to be ignored all six lengths are given and no statics enters.
    """
    n = model.n_taut
    if n == MOST_TAUT:
        return lengths
    centre_columns(F, W, n)
    limited = limit_tensions(F, W, n, rank, S)
    statics_equations(F, W, n, lengths, rank if variables == U_SYMBOLS else 0, S)
    for e in range(DIMENSIONS - n):
        blank(F, EQUATION + lengths + e, limited, S)
    return int(lengths + DIMENSIONS - n)


@kernel(inline="always")
def process_cells(
    exclude: Any,
    settle: Any,
    narrow_lanes: Any,
    verdict: Any,
    context: Any,
    count: int,
    children: Any,
) -> None:
    """Exclude, settle or contract a batch of cells, then keep, split or give up each; see ``engine.batches``.

    Parameters
    ----------
    exclude
        ``exclude(F, W, model, C, states, S)`` gives open lanes without equilibrium their states; returns the
        number of lengths in EQUATION.. and the most pivots of a lane. Lanes still OPEN afterwards have all
        rows written.
    settle
        ``settle(F, W, model, roots, C, chart, states, S)`` marks the open lanes as SETTLED all of whose
        equilibria are one root's.
    narrow_lanes
        ``narrow_lanes(model, C, states)`` leaves those open that are worth contracting; True when there are
        any.
    verdict
        ``verdict(context, lane, children)`` writes a lane's children or leaf and returns its verdict.
    context
        A ``kinds.Context``.
    """
    S, F, W, C, states, verdicts = context.scratch
    model = context.model
    open_first(states, count)
    lengths, rank = exclude(F, W, model, C, states, S)
    if any_open(states):
        settle(F, W, model, context.roots, C, context.columns.chart, states, S)
        if narrow_lanes(model, C, states):
            equations = balance_equations(F, W, model, lengths, rank, len(context.variables), S)
            contract_open(F, W, C, states, equations, context.variables, S)
    for lane in range(count):
        verdicts[lane] = verdict(context, lane, children)
