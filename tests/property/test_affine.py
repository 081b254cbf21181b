"""Every affine kernel against exact fractions: the exact value lies within the error of the linear part."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from cdpr_interval.kernels import affine

ROWS = 16
OUT = 12
SYMBOLS = (3, 4, 6)
LARGEST = 1.7976931348623157e308
DENORMAL = 5e-324
EXPONENTS = {
    "plain": (-3, 3),
    "mixed": (-60, 60),
    "tiny": (-1074, -500),
    "huge": (300, 520),
    "wild": (-1074, 1000),
}
"""Powers of two of the coefficients; products of tiny ones underflow, those of huge ones overflow."""


def coefficient(rng: random.Random, scale: str) -> float:
    """Return a random double: zero, short, or with a full mantissa."""
    low, high = EXPONENTS[scale]
    kind = rng.random()
    if kind < 0.15:
        return rng.choice([0.0, -0.0])
    mantissa = float(rng.choice([1, 3, 5])) if kind < 0.3 else rng.uniform(1.0, 2.0)
    return rng.choice([-1.0, 1.0]) * math.ldexp(mantissa, rng.randint(low, high))


def random_forms(rng: random.Random, symbols: int, scale: str) -> Any:
    """Return forms; a third of their errors are zero, so that lost roundings show."""
    F = np.zeros((ROWS, symbols + 2))
    for i in range(ROWS):
        for k in range(symbols + 1):
            F[i, k] = coefficient(rng, scale)
        F[i, symbols + 1] = 0.0 if rng.random() < 0.33 else abs(coefficient(rng, scale))
    return F


def unit_value(rng: random.Random) -> Fraction:
    """Return a number in [-1, 1], often an end."""
    kind = rng.random()
    if kind < 0.4:
        return Fraction(rng.choice([-1, 1]))
    if kind < 0.5:
        return Fraction(0)
    return Fraction(rng.randint(-(10**30), 10**30), 10**30)


def linear(row: Any, eps: Sequence[Fraction]) -> Fraction:
    """Return centre + linear part at a point of the cell."""
    return sum((Fraction(a) * e for a, e in zip(row[1:-1], eps, strict=True)), Fraction(row[0]))


class Case:
    """Random forms, a point of the cell, and one value that each form encloses there."""

    def __init__(self, rng: random.Random, symbols: int, scale: str) -> None:
        self.F = random_forms(rng, symbols, scale)
        self.eps = [unit_value(rng) for _ in range(symbols)]
        self.values = [linear(row, self.eps) + Fraction(row[-1]) * unit_value(rng) for row in self.F]

    def check(self, out: int, exact: Fraction) -> bool:
        """Assert that row ``out`` encloses ``exact``; return whether it is finite."""
        lo, hi = affine.bounds(self.F, out)
        assert lo <= exact <= hi
        if not np.all(np.isfinite(self.F[out])):
            assert (lo, hi) == (-math.inf, math.inf)
            return False
        assert abs(exact - linear(self.F[out], self.eps)) <= Fraction(self.F[out, -1])
        return True


def cases(scale: str, count: int, seed: int = 0) -> list[Case]:
    """Return random cases over all numbers of symbols."""
    rng = random.Random(f"{scale} {seed}")
    return [Case(rng, SYMBOLS[k % len(SYMBOLS)], scale) for k in range(count)]


every_scale = pytest.mark.parametrize("scale", EXPONENTS)


@every_scale
def test_bounds(scale: str) -> None:
    for case in cases(scale, 150):
        for i, value in enumerate(case.values):
            case.check(i, value)


def test_bounds_reach_the_extreme_points() -> None:
    for case in cases("mixed", 150):
        for row in range(ROWS):
            corner = [Fraction(1 if a >= 0 else -1) for a in case.F[row, 1:-1]]
            most = linear(case.F[row], corner) + Fraction(case.F[row, -1])
            assert affine.bounds(case.F, row)[1] >= most


def test_bounds_after_an_overflow_are_the_whole_line() -> None:
    for bad in (math.inf, -math.inf, math.nan):
        for k in range(6):
            F = np.ones((2, 6))
            F[0, k] = bad if k < 5 else abs(bad)
            if k == 0 and math.isinf(bad):
                # An infinite centre comes with an infinite error from every kernel.
                F[0, 5] = math.inf
            assert affine.bounds(F, 0) == (-math.inf, math.inf)


@every_scale
def test_add_and_subtract(scale: str) -> None:
    for case in cases(scale, 150):
        v = case.values
        affine.add(case.F, OUT, 0, 1)
        case.check(OUT, v[0] + v[1])
        affine.subtract(case.F, OUT, 2, 3)
        case.check(OUT, v[2] - v[3])
        affine.subtract(case.F, OUT, 4, 4)
        # The row's own error is one unknown, but a kernel must not rely on that.
        case.check(OUT, Fraction(0))


@every_scale
def test_combine3(scale: str) -> None:
    rng = random.Random(1)
    for case in cases(scale, 150):
        c = [coefficient(rng, rng.choice([scale, "plain"])) for _ in range(3)]
        value = coefficient(rng, scale)
        error = rng.choice([0.0, abs(coefficient(rng, scale))])
        v = case.values
        affine.combine3(case.F, OUT, 5, *c, value, error)
        exact = sum((Fraction(x) * y for x, y in zip(c, v[5:8], strict=True)), Fraction(value))
        case.check(OUT, exact + Fraction(error) * unit_value(rng))


@every_scale
@pytest.mark.parametrize("terms", [1, 2, 3, 4])
def test_dot(scale: str, terms: int) -> None:
    for case in cases(scale, 80, terms):
        v = case.values
        for a, b in ((0, 4), (0, 0), (2, 3)):
            affine.dot(case.F, OUT, a, b, terms)
            case.check(OUT, sum((v[a + j] * v[b + j] for j in range(terms)), Fraction(0)))


@every_scale
def test_multiply_and_minor(scale: str) -> None:
    for case in cases(scale, 150):
        v = case.values
        affine.multiply(case.F, OUT, 0, 1)
        case.check(OUT, v[0] * v[1])
        for a, b, c, d in ((0, 1, 2, 3), (0, 1, 4, 4), (5, 5, 5, 5)):
            affine.minor(case.F, OUT, a, b, c, d)
            case.check(OUT, v[a] * v[b] - v[c] * v[d])


def test_products_of_error_free_forms_stay_sharp() -> None:
    """Roundings cost little: only the quadratic part may enlarge the error."""
    for case in cases("plain", 200):
        case.F[:, -1] = 0.0
        case.F[:, 2:-1] = 0.0
        affine.multiply(case.F, OUT, 0, 1)
        size = (abs(case.F[0, :2]).sum()) * (abs(case.F[1, :2]).sum())
        quadratic = 0.5 * abs(case.F[0, 1] * case.F[1, 1])
        assert case.F[OUT, -1] <= quadratic + 1e-13 * size + 1e-300


def test_sums_stay_sharp() -> None:
    for case in cases("plain", 200):
        affine.add(case.F, OUT, 0, 1)
        size = abs(case.F[:2]).sum()
        assert case.F[OUT, -1] <= case.F[0, -1] + case.F[1, -1] + 1e-14 * size


@every_scale
def test_reciprocal(scale: str) -> None:
    rng = random.Random(2)
    proved = 0
    for case in cases(scale, 250):
        F = case.F
        # Shrink the linear part and the error so that the centre decides the sign.
        F[0, 1:] *= 2.0 ** -rng.choice([2, 4, 20, 60])
        F[0, -1] = abs(F[0, -1])
        value = linear(F[0], case.eps) + Fraction(F[0, -1]) * unit_value(rng)
        if not affine.reciprocal(F, OUT, 0):
            continue
        assert value > 0
        proved += case.check(OUT, 1 / value)
    assert proved >= (15 if scale in ("plain", "mixed", "huge") else 0)


@pytest.mark.parametrize("form", [[1.0, 1.0, 0.0], [1.0, 0.5, 0.5], [-3.0, 1.0, 0.0], [math.nan, 0.0, 0.0]])
def test_reciprocal_refuses_what_is_not_proved_positive(form: list[float]) -> None:
    F = np.zeros((2, 3))
    F[0] = form
    assert not affine.reciprocal(F, 1, 0)
    assert not F[1].any()


def test_reciprocal_does_not_raise_on_tiny_or_huge_forms() -> None:
    for centre in (DENORMAL, 1e-320, 1e-300, 1e-160, 1e160, 1e300, LARGEST):
        F = np.zeros((2, 4))
        F[0, 0] = centre
        if affine.reciprocal(F, 1, 0):
            lo, hi = affine.bounds(F, 1)
            assert lo <= 1 / Fraction(centre) <= hi


def test_reciprocal_is_sharp() -> None:
    for ratio in (1.0, 1.5, 3.0):
        F = np.zeros((2, 3))
        affine.variable(F, 0, 1, 2.0, 2.0 * ratio)
        assert affine.reciprocal(F, 1, 0)
        assert F[1, 2] <= 0.5 * (0.5 + 0.5 / ratio - 1.0 / math.sqrt(ratio)) + 1e-14


ENDS = [
    (0.0, 0.0), (-1.0, 1.0), (0.1, 0.3), (DENORMAL, DENORMAL), (0.0, DENORMAL), (-DENORMAL, 2 * DENORMAL),
    (1.0, math.nextafter(1.0, 2.0)), (-1e-320, 1.0), (1e308, 1e308), (-1.5e308, -1.5e308),
    (LARGEST, LARGEST), (1e308, 1.5e308), (-LARGEST, LARGEST), (-1.0, 1e300), (3e-324, 1e-310),
]  # fmt: skip


def random_ends(rng: random.Random) -> tuple[float, float]:
    a, b = coefficient(rng, "wild"), coefficient(rng, rng.choice(["wild", "plain"]))
    if rng.random() < 0.3:
        b = math.nextafter(a, math.inf)
    return min(a, b), max(a, b)


@pytest.mark.parametrize("symbol", [1, 4])
def test_variable_covers_its_interval(symbol: int) -> None:
    """For every x in [lo, hi] there is a value of the symbol in [-1, 1] that gives x exactly."""
    rng = random.Random(3)
    for lo, hi in [*ENDS, *(random_ends(rng) for _ in range(2000))]:
        F = np.full((1, 6), 7.0)
        affine.variable(F, 0, symbol, lo, hi)
        found = affine.bounds(F, 0)
        assert found[0] <= lo and hi <= found[1]
        if not np.all(np.isfinite(F)):
            continue
        centre, radius = Fraction(F[0, 0]), Fraction(F[0, symbol])
        assert centre - radius <= Fraction(lo) and Fraction(hi) <= centre + radius
        assert np.count_nonzero(F[0, 1:]) <= 1
        ulp = Fraction(math.ulp(max(abs(lo), abs(hi))))
        assert radius <= (Fraction(hi) - Fraction(lo)) / 2 + ulp + 2 * Fraction(DENORMAL)


@every_scale
def test_constant(scale: str) -> None:
    rng = random.Random(4)
    for case in cases(scale, 100):
        value, error = coefficient(rng, scale), abs(coefficient(rng, scale))
        affine.constant(case.F, OUT, value, error)
        case.check(OUT, Fraction(value) + Fraction(error) * unit_value(rng))
        assert not case.F[OUT, 1:-1].any()
