"""Every kernel of second-order forms against exact fractions: the exact value lies within a row's error."""

from __future__ import annotations

import math
import random
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from cdpr_interval.kernels import second_order as kernels
from cdpr_interval.kernels.second_order import ROTATION_ONLY, WHOLE_POSE, Symbols, width
from tests.exact_rows import Point, polynomial

ROWS = 13
OUT = 10
EXPONENTS = {
    "plain": (-3, 3),
    "mixed": (-60, 60),
    "tiny": (-1074, -500),
    "huge": (300, 520),
    "wild": (-1074, 1000),
}
"""Powers of two of the coefficients; products of tiny ones underflow, those of huge ones overflow."""

every_scale = pytest.mark.parametrize("scale", EXPONENTS)
every_count = pytest.mark.parametrize("S", [ROTATION_ONLY, WHOLE_POSE], ids=["4", "6"])


def coefficient(rng: random.Random, scale: str) -> float:
    """Return a random double: zero, short, or with a full mantissa."""
    low, high = EXPONENTS[scale]
    kind = rng.random()
    if kind < 0.2:
        return rng.choice([0.0, -0.0])
    mantissa = float(rng.choice([1, 3, 5])) if kind < 0.3 else rng.uniform(1.0, 2.0)
    return rng.choice([-1.0, 1.0]) * math.ldexp(mantissa, rng.randint(low, high))


def unit_value(rng: random.Random) -> Fraction:
    """Return a number in [-1, 1], often an end."""
    kind = rng.random()
    if kind < 0.4:
        return Fraction(rng.choice([-1, 1]))
    if kind < 0.5:
        return Fraction(0)
    return Fraction(rng.randint(-(3**30), 3**30), 3**30)


def check_sums(row: Any, k: int) -> None:
    """Assert that the sums |l| and |q| of a row are right up to rounding."""
    for coefficients, found in ((row[1 : 1 + k], row[-2]), (row[1 + k : -3], row[-1])):
        exact = sum((abs(Fraction(a)) for a in coefficients), Fraction(0))
        assert abs(Fraction(found) - exact) <= exact / 2**48 + Fraction(1, 2**1069)


class Case:
    """Random rows, a point of the cell, and one value that each row encloses there."""

    def __init__(self, rng: random.Random, S: Symbols, scale: str) -> None:
        self.S = S
        self.F = np.zeros((ROWS, width(S)))
        # A quarter holds linear rows without errors, whose products lose nothing but roundings.
        linear = scale in ("plain", "mixed", "tiny") and rng.random() < 0.25
        for row in self.F:
            for k in range(width(S) - 3):
                row[k] = coefficient(rng, scale)
            # A third has no error, so that lost roundings show.
            row[-3] = 0.0 if rng.random() < 0.33 else abs(coefficient(rng, scale))
            if linear:
                row[1 + len(S) :] = 0.0
        for i in range(ROWS):
            kernels.close(self.F, i, S)
        self.at = Point([unit_value(rng) for _ in S])
        self.shares = [unit_value(rng) for _ in range(ROWS)]

    def value(self, i: int) -> Fraction:
        """Return the number that row ``i`` encloses."""
        return polynomial(self.F[i], self.at) + Fraction(self.F[i, -3]) * self.shares[i]

    def check(self, out: int, exact: Fraction) -> bool:
        """Assert that row ``out`` encloses ``exact``; return whether it is finite."""
        row = self.F[out]
        lo, hi = kernels.bounds(self.F, out, self.S)
        assert lo <= exact <= hi
        if not np.all(np.isfinite(row)):
            assert (lo, hi) == (-math.inf, math.inf)
            return False
        assert abs(exact - polynomial(row, self.at)) <= Fraction(row[-3])
        most = kernels.largest(self.F, out, self.S)
        assert most == math.inf or abs(exact) <= Fraction(most)
        check_sums(row, len(self.S))
        return True


def cases(scale: str, S: Symbols, count: int, seed: int = 0) -> list[Case]:
    rng = random.Random(f"{scale} {len(S)} {seed}")
    return [Case(rng, S, scale) for _ in range(count)]


@every_count
@every_scale
def test_bounds_largest_and_close(scale: str, S: Symbols) -> None:
    for case in cases(scale, S, 20):
        for i in range(ROWS):
            case.check(i, case.value(i))


@every_count
@every_scale
def test_bounds_reach_the_extreme_points(scale: str, S: Symbols) -> None:
    """At every corner, at the vertex in one symbol and with the whole error."""
    rng = random.Random(1)
    for case in cases(scale, S, 20):
        for i in range(ROWS):
            row = case.F[i]
            lo, hi = kernels.bounds(case.F, i, S)
            eps = [Fraction(rng.choice([-1, 1])) for _ in S]
            k = rng.randrange(len(S))
            square = Fraction(row[1 + len(S) + k])
            if square:
                others = [*eps[:k], Fraction(0), *eps[k + 1 :]]
                base = polynomial(row, Point(others))
                slope = polynomial(row, Point([*eps[:k], Fraction(1), *eps[k + 1 :]])) - base - square
                eps[k] = min(max(-slope / (2 * square), Fraction(-1)), Fraction(1))
            value = polynomial(row, Point(eps))
            assert lo <= value - Fraction(row[-3]) and value + Fraction(row[-3]) <= hi


@every_count
def test_bounds_of_one_symbol_are_its_range(S: Symbols) -> None:
    rng = random.Random(2)
    K = len(S)
    for case in cases("plain", S, 100):
        F, k = case.F, rng.randrange(K)
        c, slope, square = F[0, 0], F[0, 1 + k], F[0, 1 + K + k]
        F[0, 1:-3] = 0.0
        F[0, 1 + k], F[0, 1 + K + k] = slope, square
        kernels.close(F, 0, S)
        values = [c + slope + square, c - slope + square]
        if abs(slope) < 2 * abs(square):
            values.append(c - slope**2 / (4 * square))
        lo, hi = kernels.bounds(F, 0, S)
        room = 1e-12 * (abs(c) + abs(slope) + abs(square) + F[0, -3]) + 1e-300
        error = F[0, -3]
        assert min(values) - error - room <= lo <= min(values) - error + room
        assert max(values) + error - room <= hi <= max(values) + error + room


@every_count
def test_bounds_after_an_overflow_are_the_whole_line(S: Symbols) -> None:
    for bad in (math.inf, -math.inf, math.nan):
        for k in range(width(S) - 2):
            F = np.ones((1, width(S)))
            F[0, k] = bad if k < width(S) - 3 else abs(bad)
            kernels.close(F, 0, S)
            assert kernels.bounds(F, 0, S) == (-math.inf, math.inf)
            assert not kernels.largest(F, 0, S) < math.inf


@every_count
@every_scale
def test_constant_and_widen(scale: str, S: Symbols) -> None:
    rng = random.Random(3)
    for case in cases(scale, S, 25):
        value, error = coefficient(rng, scale), abs(coefficient(rng, scale))
        kernels.constant(case.F, OUT, value, error, S)
        case.check(OUT, Fraction(value) + Fraction(error) * unit_value(rng))
        assert not case.F[OUT, 1:-3].any()
        exact = case.value(0)
        extra = abs(coefficient(rng, rng.choice([scale, "plain"])))
        kernels.widen(case.F, 0, extra, S)
        for sign in (-1, 1):
            case.check(0, exact + sign * Fraction(extra))


@every_count
@every_scale
def test_scale_and_add_scaled(scale: str, S: Symbols) -> None:
    rng = random.Random(4)
    for case in cases(scale, S, 25):
        c, d, e = (coefficient(rng, rng.choice([scale, "plain"])) for _ in range(3))
        one, two, three = (case.value(i) for i in range(3))
        kernels.scale(case.F, OUT, 0, c, S)
        case.check(OUT, Fraction(c) * one)
        kernels.scale(case.F, 0, 0, d, S)
        case.check(0, Fraction(d) * one)
        kernels.add_scaled(case.F, 2, 1, e, S)
        case.check(2, three + Fraction(e) * two)
        # A row's own error is one unknown, but a kernel must not rely on that.
        kernels.add_scaled(case.F, 3, 3, -1.0, S)
        case.check(3, Fraction(0))
        kernels.scale(case.F, 4, 5, -1.0, S)
        kernels.add_scaled(case.F, 4, 6, 1.0, S)
        case.check(4, case.value(6) - case.value(5))


@every_count
@every_scale
def test_combine3(scale: str, S: Symbols) -> None:
    rng = random.Random(5)
    for case in cases(scale, S, 25):
        c = [coefficient(rng, rng.choice([scale, "plain"])) for _ in range(3)]
        error = rng.choice([0.0, abs(coefficient(rng, scale))])
        kernels.combine3(case.F, OUT, 5, *c, error, S)
        exact = sum((Fraction(x) * case.value(5 + k) for k, x in enumerate(c)), Fraction(0))
        case.check(OUT, exact + Fraction(error) * unit_value(rng))


@every_count
@every_scale
def test_combine6_and_moving6(scale: str, S: Symbols) -> None:
    rng = random.Random(6)
    for case in cases(scale, S, 25):
        W = np.zeros((2 + len(S), 8))
        kind = rng.choice([scale, "plain"])
        for y in range(1, 2 + len(S)):
            for k in range(6):
                W[y, k] = coefficient(rng, kind)
        kernels.combine6(case.F, OUT, 2, W, 1, S)
        values = [case.value(2 + k) for k in range(6)]
        case.check(OUT, sum((Fraction(W[1, k]) * values[k] for k in range(6)), Fraction(0)))
        kernels.moving6(case.F, OUT, 2, W, 1, S)
        slopes = range(len(S))
        moved = [sum(Fraction(W[2 + m, k]) * case.at.eps[m] for m in slopes) for k in range(6)]
        y = [Fraction(W[1, k]) + moved[k] for k in range(6)]
        case.check(OUT, sum((a * b for a, b in zip(y, values, strict=True)), Fraction(0)))


@every_count
@every_scale
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_add_product(scale: str, S: Symbols, sign: float) -> None:
    for case in cases(scale, S, 25, int(sign)):
        # Also a row times itself, and a second product added to the first.
        exact = case.value(2) + int(sign) * case.value(0) * case.value(1)
        kernels.add_product(case.F, 2, 0, 1, sign, S)
        case.check(2, exact)
        kernels.add_product(case.F, 2, 5, 6, -sign, S)
        case.check(2, exact - int(sign) * case.value(5) * case.value(6))
        exact = case.value(4) + int(sign) * case.value(3) ** 2
        kernels.add_product(case.F, 4, 3, 3, sign, S)
        case.check(4, exact)


@every_count
@every_scale
def test_multiply_dot3_and_cross3(scale: str, S: Symbols) -> None:
    for case in cases(scale, S, 15):
        v = [case.value(i) for i in range(OUT)]
        for a, b in ((0, 1), (2, 2)):
            kernels.multiply(case.F, OUT, a, b, S)
            case.check(OUT, v[a] * v[b])
        for a, b in ((0, 3), (6, 6)):
            kernels.dot3(case.F, OUT, a, b, S)
            case.check(OUT, sum((v[a + k] * v[b + k] for k in range(3)), Fraction(0)))
        for a, b in ((0, 3), (4, 7)):
            kernels.cross3(case.F, OUT, a, b, S)
            for k in range(3):
                i, j = (k + 1) % 3, (k + 2) % 3
                case.check(OUT + k, v[a + i] * v[b + j] - v[a + j] * v[b + i])


@every_count
def test_plain_rows_stay_finite(S: Symbols) -> None:
    """The tests above would pass for kernels whose errors are infinite."""
    for case in cases("plain", S, 10):
        kernels.cross3(case.F, OUT, 0, 3, S)
        kernels.dot3(case.F, 9, 0, 3, S)
        kernels.moving6(case.F, 8, 0, np.ones((8, 6)), 0, S)
        assert np.all(np.isfinite(case.F))


@every_count
def test_products_of_linear_rows_are_exact_up_to_rounding(S: Symbols) -> None:
    K = len(S)
    for case in cases("plain", S, 100):
        F = case.F
        F[:, 1 + K : -2] = 0.0
        for i in range(ROWS):
            kernels.close(F, i, S)
        kernels.multiply(F, OUT, 0, 1, S)
        size = abs(F[0, : 1 + K]).sum() * abs(F[1, : 1 + K]).sum()
        assert F[OUT, -3] <= 1e-14 * size + 1e-300
        case.check(OUT, case.value(0) * case.value(1))


@every_count
def test_products_drop_only_third_and_fourth_order(S: Symbols) -> None:
    for case in cases("plain", S, 100):
        F = case.F
        F[:, -3] = 0.0
        kernels.multiply(F, OUT, 0, 1, S)
        a, b = (abs(F[i, 0]) + F[i, -2] + F[i, -1] for i in (0, 1))
        dropped = F[0, -2] * F[1, -1] + F[0, -1] * F[1, -2] + F[0, -1] * F[1, -1]
        assert F[OUT, -3] <= dropped * (1.0 + 1e-12) + 1e-14 * a * b


@every_count
def test_sums_stay_sharp(S: Symbols) -> None:
    for case in cases("plain", S, 100):
        F = case.F
        before = F[0, -3] + F[1, -3]
        size = abs(F[:2, :-3]).sum()
        kernels.add_scaled(F, 0, 1, 1.0, S)
        assert F[0, -3] <= before * (1.0 + 1e-12) + 1e-14 * size
        kernels.combine3(F, OUT, 3, 1.0, -1.0, 1.0, 0.0, S)
        assert F[OUT, -3] <= F[3:6, -3].sum() * (1.0 + 1e-12) + 1e-14 * abs(F[3:6, :-3]).sum()
