"""Vectors of real balls: lists of three, and columns for products with matrices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from flint import arb, arb_mat

from certificates.arithmetic.vectors import dot

Vector = list[arb]
BITS = 200
"""Working precision: far beyond the doubles that a certificate lists."""


def hull(lo: Any, hi: Any) -> arb:
    """Return a ball that holds [lo, hi], exact numbers."""
    return arb(lo) if lo == hi else arb(lo).union(arb(hi))


def inside(x: arb, bounds: tuple[float, float]) -> bool:
    """Return True when a ball surely lies within bounds."""
    return bool(x >= bounds[0] and x <= bounds[1])


def all_inside(values: Sequence[arb], bounds: Sequence[tuple[float, float]]) -> bool:
    """Return True when every ball surely lies within its bounds."""
    return all(inside(x, b) for x, b in zip(values, bounds, strict=True))


def column(v: Sequence[Any]) -> arb_mat:
    """Return a vector as a matrix of one column."""
    return arb_mat(len(v), 1, [arb(x) for x in v])


def minus(a: Sequence[Any], b: Sequence[Any]) -> Vector:
    """Return a - b."""
    return [arb(x) - y for x, y in zip(a, b, strict=True)]


def norm(v: Sequence[Any]) -> arb:
    """Return |v|."""
    return arb(dot(v, v)).nonnegative_part().sqrt()


def unit(v: Sequence[Any]) -> Vector:
    """Return v / |v|."""
    return [x / norm(v) for x in v]
