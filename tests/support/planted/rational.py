"""Small exact linear algebra on fractions, for robots whose static pose is known exactly."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from fractions import Fraction

from flint import fmpq, fmpq_mat

Vector = tuple[Fraction, Fraction, Fraction]
Matrix = tuple[Vector, Vector, Vector]

HALF_TURN_SIGNS = ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))
"""Diagonals of the half turns that lead from one chart of the rotations to the others."""


def decimal(rng: random.Random, low: float, high: float, digits: int = 3) -> Fraction:
    """Return a random decimal between two bounds."""
    return Fraction(round(rng.uniform(low, high) * 10**digits), 10**digits)


def decimals(rng: random.Random, low: float, high: float) -> Vector:
    """Return a vector of random decimals."""
    return decimal(rng, low, high), decimal(rng, low, high), decimal(rng, low, high)


def dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    """Return a . b."""
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def combine(*terms: tuple[Fraction | int, Vector]) -> Vector:
    """Return the sum of multiples of vectors."""
    x, y, z = (sum((Fraction(k) * v[i] for k, v in terms), Fraction(0)) for i in range(3))
    return x, y, z


def apply(matrix: Matrix, v: Vector) -> Vector:
    """Return matrix v."""
    return dot(matrix[0], v), dot(matrix[1], v), dot(matrix[2], v)


def transpose(m: Matrix) -> Matrix:
    """Return the transpose."""
    return (
        (m[0][0], m[1][0], m[2][0]),
        (m[0][1], m[1][1], m[2][1]),
        (m[0][2], m[1][2], m[2][2]),
    )


def rotation_of(chart: int, u: Vector) -> Matrix:
    """Return R(u) D_chart: the rotation of the quaternion (1, u) after a half turn."""
    x, y, z = u
    s = 1 + x * x + y * y + z * z
    a, b, c = HALF_TURN_SIGNS[chart]
    return (
        (a * (1 + x * x - y * y - z * z) / s, b * 2 * (x * y - z) / s, c * 2 * (x * z + y) / s),
        (a * 2 * (x * y + z) / s, b * (1 - x * x + y * y - z * z) / s, c * 2 * (y * z - x) / s),
        (a * 2 * (x * z - y) / s, b * 2 * (y * z + x) / s, c * (1 - x * x - y * y + z * z) / s),
    )


def root(x: Fraction) -> Fraction:
    """Return the square root to 60 decimals."""
    return Fraction(math.isqrt((x * 10**120).__floor__()), 10**60)


def project(
    start: Sequence[Fraction], rows: Sequence[Sequence[Fraction]], right: Sequence[Fraction]
) -> list[Fraction] | None:
    """Return the solution of rows y = right nearest to ``start``; None where there is none.

    The rows may be dependent.
    """
    augmented = fmpq_mat([[_fmpq(x) for x in [*row, b]] for row, b in zip(rows, right, strict=True)])
    echelon, rank = augmented.rref()
    count = len(start)
    table = [[echelon[i, j] for j in range(count + 1)] for i in range(rank)]
    if any(not any(row[:count]) for row in table):
        return None
    m = fmpq_mat([row[:count] for row in table])
    y = fmpq_mat([[_fmpq(x)] for x in start])
    gap = fmpq_mat([row[count:] for row in table]) - m * y
    y += m.transpose() * (m * m.transpose()).solve(gap)
    return [Fraction(int(x.p), int(x.q)) for x in y.entries()]


def _fmpq(x: Fraction) -> fmpq:
    return fmpq(x.numerator, x.denominator)
