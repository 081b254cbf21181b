"""Vectors of three exact numbers."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

Vector = tuple[Fraction, Fraction, Fraction]


def minus(a: Sequence[Fraction], b: Sequence[Fraction]) -> Vector:
    """Return a - b exactly."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def along(a: Sequence[Fraction], s: Fraction, d: Sequence[Fraction]) -> Vector:
    """Return a + s d exactly."""
    return (a[0] + s * d[0], a[1] + s * d[1], a[2] + s * d[2])


def dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    """Return a . b exactly."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Sequence[Fraction], b: Sequence[Fraction]) -> Vector:
    """Return a x b exactly."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def is_zero(a: Vector) -> bool:
    """Return True for the zero vector."""
    return not any(a)
