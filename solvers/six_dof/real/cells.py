"""Cells in (u, p) of platforms on real cables: what they are put to, and the compiled search.

A cell is surveyed first (``survey``): its box of positions is cut, and one that is still wide is bisected at
once. Then all equations become forms (``shape``), whose tests are those of every platform: lengths, slack
cables, the balance of forces; what is left is contracted by all equations at once.

Arrays: as in ``cells.tests``; a cell has the columns ``REAL_COLUMNS``; ``context`` is a ``RealContext``,
``real`` is a ``RealModel``, ``desk`` is a ``Desk``, ``held`` (LANES, HELD) its; ``roots`` (m, 1 + 2 (6 + n))
as in ``cells.bounds``.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from cdpr_interval.engine.batch_cells import (
    any_open,
    contract_open,
    copy_cell,
    covers,
    halve,
    is_empty,
    leaf,
    mark,
    open_first,
    open_lanes,
)
from cdpr_interval.engine.batches import ADMITTED, gathered
from cdpr_interval.engine.contraction import blank, cannot_vanish, cut_pivots, shrunk, solve_for_pivots
from cdpr_interval.engine.rows import (
    BOUNDED,
    EMPTY,
    EQUATION,
    FLAGS,
    NO_LENGTH,
    NOT_SLACK,
    OPEN,
    SCRATCH,
    SETTLED,
    SMALL,
    SMALLER,
    UNBALANCED,
    VERDICTS,
    WIDE,
)
from cdpr_interval.engine.scratch import Scratch
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, Lanes, splat, store, where_less
from cdpr_interval.kernels.rounding import up
from cdpr_interval.kernels.second_order import Forms, Symbols, bounds
from cdpr_interval.mechanics.six_dof.balance import (
    balance_free,
    limit_tensions,
    statics_equations,
    tension_bounds,
)
from cdpr_interval.mechanics.six_dof.directions import centre_columns
from cdpr_interval.mechanics.six_dof.geometry import rotation_rows
from cdpr_interval.mechanics.six_dof.rows import BEFORE, DIMENSIONS, MOST_TAUT, MOST_TENSION, MOVING, TENSIONS
from solvers.six_dof.real import survey as surveys
from solvers.six_dof.real.columns import BOX, CENTRE, DENSITIES, FORMED, NEXT, REAL_COLUMNS, TIGHTER
from solvers.six_dof.real.pull import add_pulls, cannot_balance
from solvers.six_dof.real.shape import (
    back_to_box,
    from_middle,
    length_row,
    load_rows,
    position_rows,
    product_rows,
    spot,
    wrench_rows,
)
from solvers.six_dof.real.survey import look_again, survey

CHART, VARIABLES = REAL_COLUMNS.chart, REAL_COLUMNS.variables
V = (0, 0, 0, 0, 0, 0)
"""An entry for each variable, so that the compiler knows how many there are."""
CUTS = 3
"""Most looks at the lengths before the other tests."""
CONTRACT_WIDTH = 0.6
"""Width of u below which a cell that is not excluded is contracted by all equations."""
POSITION_SHARE = 2.0
"""How wide positions may be over what the rotations move the platform by: wider ones are bisected."""
COUNTS = 0.25
"""Least stretch, over what the rotations move an anchor by, whose loss is worth another look."""


class RealContext(NamedTuple):
    """What a compiled search looks at cells with."""

    real: Any
    """``RealModel``."""
    roots: Any
    """(m, 1 + 2 (6 + n)) chart, lo and hi of the uniqueness boxes of the roots known."""
    leaf_size: float
    desk: Any
    """``Desk``."""
    scratch: Scratch


@kernel(inline="always")
def look(context: Any, states: Any, first: bool) -> None:
    """Write the shared forms of the lanes that move; states become NO_LENGTH, or stay."""
    S, F, W, C, _, _ = context.scratch
    real, desk = context.real, context.desk
    for lane in range(LANES):
        if W[MOVING, 0, lane] == 0.0 or not first:
            continue
        if look_again(real, C, lane, desk):
            spot(real, lane, desk)
            from_middle(C, lane, desk)
        else:
            states[lane] = NO_LENGTH
            W[MOVING, 0, lane] = 0.0
    position_rows(F, C, S)
    product_rows(F, S)


@kernel(inline="always")
def cut_by_lengths(context: Any, states: Any) -> int:
    """Cut the open lanes' cells by the lengths until that gains little; return the most pivots of a lane.

    Lanes still OPEN afterwards: the rows in F are those of the cell as it is now; its columns 6..11 bound v.
    """
    S, F, W, C, _, _ = context.scratch
    # More than six lengths are no more equations than unknowns: the survey has used all.
    real, n = context.real, min(context.real.n_taut, MOST_TAUT)
    rank = 0
    for lane in range(LANES):
        W[MOVING, 0, lane] = 1.0 if states[lane] == OPEN else 0.0
    for turn in range(CUTS):
        look(context, states, turn == 0)
        if not any_open(states):
            return 0
        for i in range(n):
            length_row(F, EQUATION + i, real, i, context.desk.spots, S)
            if not mark(W, cannot_vanish(F, EQUATION + i, S), states, NO_LENGTH):
                return 0
        rank = solve_for_pivots(F, W, 0, n, VARIABLES, S)
        for lane in range(LANES):
            moving = W[MOVING, 0, lane] > 0.0 and states[lane] == OPEN
            W[MOVING, 0, lane] = 1.0 if moving else 0.0
            W[VERDICTS, 0, lane] = OPEN if moving else EMPTY
            for k in range(2 * VARIABLES if moving else 0):
                W[BEFORE, k, lane] = C[0, k, lane]
        cut_pivots(F, W, C, rank, S)
        again = False
        for lane in range(LANES):
            if W[MOVING, 0, lane] > 0.0:
                after_cut(W, C, lane, states, turn == CUTS - 1)
                again = again or W[MOVING, 0, lane] > 0.0
        if not again:
            break
    return rank


@kernel()
def after_cut(W: LaneArray, C: LaneArray, lane: int, states: Any, last: bool) -> None:
    """Decide what a cut did to a lane: empty, u much smaller (a new cell), v (look again), or little."""
    if W[VERDICTS, 0, lane] == EMPTY:
        states[lane] = NO_LENGTH
        W[MOVING, 0, lane] = 0.0
        return
    for k in range(3):
        now = C[0, 2 * k + 1, lane] - C[0, 2 * k, lane]
        if shrunk(now, W[BEFORE, 2 * k + 1, lane] - W[BEFORE, 2 * k, lane]):
            states[lane] = SMALLER
            W[MOVING, 0, lane] = 0.0
            return
    in_position = W[VERDICTS, 0, lane] == SMALLER and not last
    for k in range(6 if in_position else 2 * VARIABLES):
        C[0, k, lane] = W[BEFORE, k, lane]
    if not in_position:
        W[MOVING, 0, lane] = 0.0


@kernel(inline="always")
def slack_excluded(F: Forms, W: LaneArray, real: Any, spots: Any, needed: Lanes, S: Symbols) -> Lanes:
    """Return 1 where a cable outside the subset would be too long over the whole cell, else 0."""
    excluded = splat(0.0)
    for i in range(real.n_taut, real.exits.shape[0]):
        length_row(F, SCRATCH, real, i, spots, S)
        below, _ = bounds(F, SCRATCH, S)
        excluded = where_less(0.0, below, 1.0, excluded)
        if covers(W, excluded, needed):
            break
    return excluded


@kernel(inline="always")
def exclude(context: Any, states: Any) -> int:
    """Give the open lanes that hold no equilibrium their states; return the most pivots of a lane."""
    S, F, W, _, _, _ = context.scratch
    real, spots = context.real, context.desk.spots
    n = real.n_taut
    rank = cut_by_lengths(context, states)
    if not any_open(states):
        return 0
    if real.slack:
        excluded = slack_excluded(F, W, real, spots, open_lanes(W, states), S)
        if not mark(W, excluded, states, NOT_SLACK):
            return 0
    wrench_rows(F, real, spots, S)
    if real.statics and n <= MOST_TAUT:
        centre_columns(F, W, n)
        mark(W, balance_free(F, W, n, rank, open_lanes(W, states), S), states, UNBALANCED)
    return rank


@kernel(inline="always")
def balance_equations(context: Any, rank: int) -> int:
    """Write equations of the statics behind those of the lengths in EQUATION..; return how many there are."""
    S, F, W, _, _, _ = context.scratch
    n = context.real.n_taut
    if n >= MOST_TAUT:
        return MOST_TAUT
    centre_columns(F, W, n)
    limited = limit_tensions(F, W, n, rank, S)
    statics_equations(F, W, n, n, 0, S)
    for e in range(DIMENSIONS - n):
        blank(F, EQUATION + n + e, limited, S)
    return DIMENSIONS


@kernel(inline="always")
def bound_densities(context: Any, rank: int, states: Any) -> None:
    """Cut the densities of open lanes by the balance of forces; one that loses much makes a lane SMALLER."""
    S, F, W, C, _, _ = context.scratch
    n = context.real.n_taut
    centre_columns(F, W, n)
    store(W, FLAGS, BOUNDED, limit_tensions(F, W, n, rank, S))
    for lane in range(LANES):
        if states[lane] == OPEN:
            for i in range(n):
                high = W[MOST_TENSION, i, lane] if W[FLAGS, BOUNDED, lane] > 0.0 else math.inf
                if cut_density(context.real, C, lane, i, -math.inf, high):
                    states[lane] = SMALLER
                    context.desk.held[lane, TIGHTER] = 1.0
    store(W, FLAGS, BOUNDED, tension_bounds(F, W, n, S))
    for lane in range(LANES):
        mine = states[lane] == OPEN or context.desk.held[lane, TIGHTER] > 0.0
        if mine and W[FLAGS, BOUNDED, lane] > 0.0:
            for i in range(n):
                if cut_density(context.real, C, lane, i, W[TENSIONS, i, lane], W[TENSIONS + 1, i, lane]):
                    states[lane] = SMALLER
                    context.desk.held[lane, TIGHTER] = 1.0
    for lane in range(LANES):
        if states[lane] == OPEN or context.desk.held[lane, TIGHTER] > 0.0:
            for i in range(n):
                if C[0, DENSITIES + 2 * i, lane] > C[0, DENSITIES + 2 * i + 1, lane]:
                    states[lane] = UNBALANCED


@kernel(inline="always")
def pull_equations(context: Any, rank: int, states: Any) -> int:
    """Write what the pulls of stretched cables must satisfy behind the first six equations; return all.

    They count as a part of the load, which the cables that do not stretch must balance: the row LOAD is
    overwritten. Lanes where they cannot become UNBALANCED.
    """
    S, F, W, _, _, _ = context.scratch
    real, rigid = context.real, context.real.rigid
    add_pulls(F, real, context.desk.spots, S)
    centre_columns(F, W, rigid)
    limited = limit_tensions(F, W, rigid, rank, S)
    statics_equations(F, W, rigid, DIMENSIONS, 0, S)
    for k in range(DIMENSIONS):
        blank(F, EQUATION + DIMENSIONS + k, limited if k < DIMENSIONS - rigid else splat(0.0), S)
    mark(W, cannot_balance(F, W, DIMENSIONS, S), states, UNBALANCED)
    return 2 * DIMENSIONS - rigid


@kernel()
def cut_density(real: Any, C: LaneArray, lane: int, i: int, low: float, high: float) -> bool:
    """Cut the bounds of a density; True where much of a stretch is gone that counted."""
    k = DENSITIES + 2 * i
    before = C[0, k + 1, lane] - C[0, k, lane]
    C[0, k, lane] = max(C[0, k, lane], low)
    C[0, k + 1, lane] = min(C[0, k + 1, lane], high)
    turned = 0.0
    for j in range(3):
        turned = max(turned, C[0, 2 * j + 1, lane] - C[0, 2 * j, lane])
    counts = real.compliance[i, 1] * real.lengths[i, 1] * before > COUNTS * turned * real.arm_lengths[i]
    return bool(counts and shrunk(C[0, k + 1, lane] - C[0, k, lane], before))


@kernel()
def near_root(roots: Any, k: int, C: LaneArray, lane: int, size: int) -> bool:
    """Return True when a lane's u lies in the uniqueness box of root ``k``, in its chart."""
    near = roots[k, 0] == C[0, CHART, lane]
    for c in range(3):
        near = near and roots[k, 1 + c] <= C[0, 2 * c, lane]
        near = near and C[0, 2 * c + 1, lane] <= roots[k, 1 + size + c]
    return bool(near)


@kernel(inline="always")
def settled(context: Any, states: Any) -> None:
    """Mark as SETTLED the open lanes all of whose equilibria lie in one root's uniqueness box."""
    _, _, W, C, _, _ = context.scratch
    roots, n, held = context.roots, context.real.n_taut, context.desk.held
    size, bounded_by_forces = 6 + n, n if n <= MOST_TAUT else context.real.rigid
    bounded = False
    for k in range(roots.shape[0]):
        for lane in range(LANES):
            if states[lane] != OPEN or not near_root(roots, k, C, lane, size):
                continue
            if not bounded:
                bound_tensions(context)
                bounded = True
            inside = W[FLAGS, BOUNDED, lane] > 0.0
            for c in range(3):
                inside = inside and roots[k, 4 + c] <= place_of(C, lane, c, held, False)
                inside = inside and place_of(C, lane, c, held, True) <= roots[k, 4 + size + c]
            for j in range(n):
                low, high = -math.inf, math.inf
                if j < bounded_by_forces:
                    low, high = W[TENSIONS, j, lane], W[TENSIONS + 1, j, lane]
                if context.real.elastic:
                    low = max(low, C[0, DENSITIES + 2 * j, lane])
                    high = min(high, C[0, DENSITIES + 2 * j + 1, lane])
                inside = inside and roots[k, 7 + j] <= low
                inside = inside and high <= roots[k, 7 + size + j]
            if inside:
                states[lane] = SETTLED


@kernel(inline="always")
def bound_tensions(context: Any) -> None:
    """Write bounds of the densities by the balance of forces to W[TENSIONS..], where they hold to BOUNDED.

    Of more than six taut cables those only that do not stretch: they balance the load and the others' pulls.
    """
    S, F, W, _, _, _ = context.scratch
    real = context.real
    if real.n_taut <= MOST_TAUT:
        store(W, FLAGS, BOUNDED, tension_bounds(F, W, real.n_taut, S))
    else:
        add_pulls(F, real, context.desk.spots, S)
        store(W, FLAGS, BOUNDED, tension_bounds(F, W, real.rigid, S))
        load_rows(F, real, S)


@kernel()
def place_of(C: LaneArray, lane: int, k: int, held: Any, upper: bool) -> float:
    """Return a bound of position ``k`` of a lane whose columns 6..11 bound v."""
    c = held[lane, CENTRE + k]
    if upper:
        return float(min(held[lane, BOX + 2 * k + 1], up(C[0, 7 + 2 * k, lane] + c)))
    return float(max(held[lane, BOX + 2 * k], -up(-C[0, 6 + 2 * k, lane] - c)))


@kernel()
def small_lanes(C: LaneArray, states: Any) -> bool:
    """Leave only those lanes open that are narrow enough to be contracted; True when there are any."""
    found = False
    for lane in range(LANES):
        if states[lane] == OPEN:
            for k in range(3):
                if C[0, 2 * k + 1, lane] - C[0, 2 * k, lane] > CONTRACT_WIDTH:
                    states[lane] = WIDE
            found = found or states[lane] == OPEN
    return found


@kernel(inline="always")
def process(context: Any, count: int, children: Any) -> None:
    """Exclude, contract, settle or split a batch of cells; see ``engine.batches``."""
    S, F, W, C, states, verdicts = context.scratch
    desk = context.desk
    open_first(states, count)
    for lane in range(LANES):
        desk.held[lane, FORMED], desk.held[lane, TIGHTER] = 0.0, 0.0
    rotation_rows(F, C, CHART, S)
    rank = exclude(context, states)
    if any_open(states):
        if context.real.elastic and context.real.n_taut <= MOST_TAUT:
            bound_densities(context, rank, states)
        settled(context, states)
        for lane in range(LANES):
            if states[lane] == OPEN:
                choose_next(context.real, C, lane, context.leaf_size, desk)
        if small_lanes(C, states):
            equations = balance_equations(context, rank)
            if context.real.elastic and context.real.rigid < MOST_TAUT:
                equations = pull_equations(context, rank, states)
            contract_open(F, W, C, states, equations, V, S)
    for lane in range(count):
        verdicts[lane] = verdict(context, lane, children)


@kernel()
def choose_next(real: Any, C: LaneArray, lane: int, leaf_size: float, desk: Any) -> None:
    """Choose what to bisect if nothing else helps: a position where it is wide, else u.

    Ranges of lengths leave positions wide however small u is: below the leaf size u is no measure of them.
    """
    arm = 0.0
    for i in range(real.n_taut):
        arm = max(arm, real.arm_lengths[i])
    best, place = 0, 0
    held = desk.held
    for k in range(1, 3):
        if C[0, 2 * k + 1, lane] - C[0, 2 * k, lane] > C[0, 2 * best + 1, lane] - C[0, 2 * best, lane]:
            best = k
    turned = max(C[0, 2 * best + 1, lane] - C[0, 2 * best, lane], leaf_size)
    most = 0.0
    for k in range(3):
        wide = 0.5 * (place_of(C, lane, k, held, True) - place_of(C, lane, k, held, False))
        if wide > most:
            most, place = wide, k
    held[lane, NEXT] = 3 + place if most > POSITION_SHARE * arm * turned else best


@kernel(inline="always")
def verdict(context: Any, lane: int, children: Any) -> int:
    """Write a lane's children or leaf; see ``engine.batches``."""
    C, state, desk = context.scratch.cells, context.scratch.states[lane], context.desk
    if is_empty(state):
        return 0
    back_to_box(C, lane, desk)
    tighter = desk.held[lane, TIGHTER] > 0.0
    if state == SMALLER and (tighter or much_smaller(context.scratch.work, C, lane, desk.held)):
        return int(copy_cell(C, lane, children))
    return int(bisect(C, lane, int(desk.held[lane, NEXT]), children, context.leaf_size))


@kernel()
def much_smaller(W: LaneArray, C: LaneArray, lane: int, held: Any) -> bool:
    """Return True when a cell lost much of an entry of u or of a position since its forms were made."""
    found = False
    for k in range(3):
        now = C[0, 2 * k + 1, lane] - C[0, 2 * k, lane]
        found = found or shrunk(now, W[BEFORE, 2 * k + 1, lane] - W[BEFORE, 2 * k, lane])
        now = C[0, 7 + 2 * k, lane] - C[0, 6 + 2 * k, lane]
        found = found or shrunk(now, held[lane, BOX + 2 * k + 1] - held[lane, BOX + 2 * k])
    return found


@kernel()
def bisect(C: LaneArray, lane: int, k: int, children: Any, leaf_size: float) -> int:
    """Bisect a variable of a lane, or return a leaf."""
    turned = 0.0
    for j in range(3):
        turned = max(turned, C[0, 2 * j + 1, lane] - C[0, 2 * j, lane])
    if turned <= leaf_size and k < 3:
        return int(leaf(C, lane, children, SMALL))
    return int(halve(C, lane, children, 2 * k))


@kernel(inline="always")
def admit(context: Any, lane: int, children: Any) -> int:
    """Survey a cell: it is excluded, bisected at once, or put to the tests; see ``engine.batches``."""
    C, desk = context.scratch.cells, context.desk
    found = survey(context.real, C, lane, desk)
    if found == surveys.EMPTY:
        return 0
    if found == surveys.READY:
        return ADMITTED
    return int(bisect(C, lane, int(desk.held[lane, NEXT]), children, context.leaf_size))


@entry()
def run(
    context: Any, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, cell_limit: int
) -> tuple[int, int, int]:
    """Search cells in (u, p) depth first; see ``engine.batches``."""
    return gathered(admit, process, context, stack, count, leaves, kinds, children, cell_limit)
