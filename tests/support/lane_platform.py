"""Kernels of the platform solver on lanes, called with arrays; see ``lane_calls``."""

from __future__ import annotations

from typing import Any

from numba import njit

from cdpr_interval.engine import batch_cells as lanes
from cdpr_interval.engine import contraction as elimination
from cdpr_interval.mechanics.six_dof import balance as statics
from cdpr_interval.mechanics.six_dof import geometry as forms
from solvers.six_dof.cells import bounds
from solvers.six_dof.cells import branch as branches
from tests.support.lane_calls import binary, get, put

maximum = binary(lanes.maximum)[0]


@njit
def middle_and_radius(lo: Any, hi: Any) -> Any:
    m, r = forms.middle_and_radius(get(lo), get(hi))
    return put(m), put(r)


@njit
def half_turn(chart: Any) -> Any:
    x, y, z = forms.half_turn(get(chart))
    return put(x), put(y), put(z)


@njit
def usefulness(F: Any, i: int, S: Any) -> Any:
    return put(elimination.usefulness(F, i, S))


@njit
def pivot_slope(F: Any, row: int, W: Any, s: int, S: Any) -> Any:
    return put(elimination.pivot_slope(F, row, W, s, S))


@njit
def rest_bounds(F: Any, symbol: Any, S: Any) -> Any:
    low, high = elimination.rest_bounds(F, get(symbol), S)
    return put(low), put(high)


@njit
def blank(F: Any, row: int, keep: Any, S: Any) -> None:
    elimination.blank(F, row, get(keep), S)


@njit
def covers(W: Any, flags: Any, needed: Any) -> bool:
    return bool(lanes.covers(W, get(flags), get(needed)))


@njit
def balance_free(F: Any, W: Any, n: int, rank: int, needed: Any, S: Any) -> Any:
    return put(statics.balance_free(F, W, n, rank, get(needed), S))


@njit
def limit_tensions(F: Any, W: Any, n: int, rank: int, S: Any) -> Any:
    return put(statics.limit_tensions(F, W, n, rank, S))


@njit
def tension_bounds(F: Any, W: Any, n: int, S: Any) -> Any:
    return put(statics.tension_bounds(F, W, n, S))


@njit
def weigh(F: Any, W: Any, row: int, moving: bool, rank: int, S: Any) -> Any:
    lo, hi = statics.weigh(F, W, row, moving, rank, S)
    return put(lo), put(hi)


@njit
def on_branch(F: Any, W: Any, model: Any, branch: Any, S: Any) -> Any:
    return put(branches.on_branch(F, W, model, get(branch), S))


@njit
def no_position(F: Any, model: Any, S: Any) -> Any:
    pivot = model.orders[0, 0]
    square, square_err = model.lengths_sq[pivot], model.lengths_sq_err[pivot]
    return put(branches.no_position(F, forms.third_block(model), square, square_err, S))


@njit
def slack_excluded(F: Any, W: Any, model: Any, needed: Any, S: Any) -> Any:
    return put(bounds.slack_excluded(F, W, model, get(needed), S))


@njit
def solution_bounds(F: Any, W: Any, model: Any, S: Any) -> Any:
    return put(bounds.solution_bounds(F, W, model, S))
