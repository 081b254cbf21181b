"""Kernels on lanes, called with arrays: a value in every lane is an array (LANES,).

Lanes exist inside compiled code only. Nothing here is cached, so that a changed kernel is always seen.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from cdpr_interval.kernels import lanes, rounding, second_order
from cdpr_interval.kernels.lanes import LANES


@njit
def get(x: Any) -> Any:
    """Return an array (LANES,) as lanes."""
    return lanes.load(x.reshape((1, 1, LANES)), 0, 0)


@njit
def put(x: Any) -> Any:
    """Return lanes as an array."""
    a = np.empty((1, 1, LANES))
    lanes.store(a, 0, 0, x)
    return a[0, 0]


def binary(operation: Any) -> Any:
    """Return a compiled operation on two values, of lanes, or of lanes and a float."""

    @njit
    def of_lanes(a: Any, b: Any) -> Any:
        return put(operation(get(a), get(b)))

    @njit
    def with_right(a: Any, b: float) -> Any:
        return put(operation(get(a), b))

    @njit
    def with_left(a: float, b: Any) -> Any:
        return put(operation(a, get(b)))

    return of_lanes, with_right, with_left


def unary(operation: Any) -> Any:
    """Return a compiled operation on lanes."""

    @njit
    def of_lanes(x: Any) -> Any:
        return put(operation(get(x)))

    return of_lanes


root = unary(lanes.root)
down = unary(rounding.down_lanes)
up = unary(rounding.up_lanes)


@njit
def splat(x: float) -> Any:
    return put(lanes.splat(x))


@njit
def where_less(a: Any, b: Any, yes: Any, no: Any) -> Any:
    return put(lanes.where_less(get(a), get(b), get(yes), get(no)))


@njit
def where_less_mixed(a: Any, b: float, yes: float, no: Any) -> Any:
    return put(lanes.where_less(get(a), b, yes, get(no)))


@njit
def copy_entry(a: Any, i: int, k: int, b: Any, j: int, m: int) -> None:
    """Set b[j, m] to a[i, k] through a register."""
    lanes.store(b, j, m, lanes.load(a, i, k))


@njit
def store_float(a: Any, i: int, k: int, x: float) -> None:
    lanes.store(a, i, k, x)


@njit
def inflate(error: Any, magnitude: Any, operations: float) -> Any:
    return put(rounding.inflate_lanes(get(error), get(magnitude), operations))


@njit
def magnitude(F: Any, i: int, S: Any) -> Any:
    return put(second_order.magnitude(F, i, S))


@njit
def largest(F: Any, i: int, S: Any) -> Any:
    return put(second_order.largest(F, i, S))


@njit
def bounds(F: Any, i: int, S: Any) -> Any:
    lo, hi = second_order.bounds(F, i, S)
    return put(lo), put(hi)


@njit
def constant(F: Any, out: int, value: Any, error: Any, S: Any) -> None:
    second_order.constant(F, out, get(value), get(error), S)


@njit
def widen(F: Any, i: int, error: Any, S: Any) -> None:
    second_order.widen(F, i, get(error), S)


@njit
def scale(F: Any, out: int, a: int, c: Any, S: Any) -> None:
    second_order.scale(F, out, a, get(c), S)


@njit
def combine2(F: Any, out: int, a: int, ca: Any, b: int, cb: Any, S: Any) -> None:
    second_order.combine2(F, out, a, get(ca), b, get(cb), S)


@njit
def add_scaled(F: Any, out: int, a: int, c: Any, S: Any) -> None:
    second_order.add_scaled(F, out, a, get(c), S)


@njit
def combine3(F: Any, out: int, a: int, c: Any, error: Any, S: Any) -> None:
    """``c`` : (3, LANES)."""
    second_order.combine3(F, out, a, get(c[0]), get(c[1]), get(c[2]), get(error), S)
