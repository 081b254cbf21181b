"""Every kernel of second-order forms against exact fractions: the exact value lies within a row's error.

Every lane holds a case of its own and is checked on its own.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from cdpr_interval.kernels import second_order
from cdpr_interval.kernels.lanes import LANES
from cdpr_interval.kernels.second_order import ALL_SYMBOLS, Symbols, width
from tests.support import lane_calls as calls
from tests.support.exact_rows import Point, error_column, polynomial
from tests.support.kernel_callers import Callers

kernels = Callers(second_order)


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
every_count = pytest.mark.parametrize("S", ALL_SYMBOLS, ids=lambda S: f"{len(S.noise)}+{len(S.data)}")


def coefficient(rng: random.Random, scale: str) -> float:
    """Return a random double: zero, short, or with a full mantissa."""
    low, high = EXPONENTS[scale]
    kind = rng.random()
    if kind < 0.2:
        return rng.choice([0.0, -0.0])
    mantissa = float(rng.choice([1, 3, 5])) if kind < 0.3 else rng.uniform(1.0, 2.0)
    return rng.choice([-1.0, 1.0]) * math.ldexp(mantissa, rng.randint(low, high))


def coefficients(rng: random.Random, scale: str) -> Any:
    """Return a random double for every lane."""
    return np.array([coefficient(rng, scale) for _ in range(LANES)])


def unit_value(rng: random.Random) -> Fraction:
    """Return a number in [-1, 1], often an end."""
    kind = rng.random()
    if kind < 0.4:
        return Fraction(rng.choice([-1, 1]))
    if kind < 0.5:
        return Fraction(0)
    return Fraction(rng.randint(-(3**30), 3**30), 3**30)


def symbols(S: Symbols) -> int:
    """Return how many symbols there are."""
    return len(S.noise) + len(S.data)


def check_sums(row: Any, S: Symbols) -> None:
    """Assert that the sums |l|, |q| and |d| of a row are right up to rounding."""
    k, e = len(S.noise), error_column(S)
    sums = [(row[1 : 1 + k], row[e + 1]), (row[1 + k : e], row[e + 2])]
    if S.data:
        sums.append((row[e + 3 : -1], row[-1]))
    for coefficients, found in sums:
        exact = sum((abs(Fraction(a)) for a in coefficients), Fraction(0))
        assert abs(Fraction(found) - exact) <= exact / 2**48 + Fraction(1, 2**1069)


class Case:
    """One lane's rows, a point of its cell, and one value that each row encloses there."""

    def __init__(self, F: Any, rng: random.Random, S: Symbols) -> None:
        self.F = F
        self.error = error_column(S)
        self.at = Point([unit_value(rng) for _ in S.noise], [unit_value(rng) for _ in S.data])
        self.shares = [unit_value(rng) for _ in range(ROWS)]

    def value(self, i: int) -> Fraction:
        """Return the number that row ``i`` encloses."""
        return polynomial(self.F[i], self.at) + Fraction(self.F[i, self.error]) * self.shares[i]


class Batch:
    """Random rows, another case in every lane."""

    def __init__(self, rng: random.Random, S: Symbols, scale: str) -> None:
        self.S = S
        e = error_column(S)
        self.F = np.zeros((ROWS, width(S), LANES))
        for lane in range(LANES):
            # A quarter holds linear rows without errors, whose products lose nothing but roundings.
            linear = scale in ("plain", "mixed", "tiny") and rng.random() < 0.25
            for row in self.F[:, :, lane]:
                for k in range(width(S)):
                    row[k] = coefficient(rng, scale)
                # A third has no error, so that lost roundings show.
                row[e] = 0.0 if rng.random() < 0.33 else abs(coefficient(rng, scale))
                if linear:
                    row[1 + len(S.noise) :] = 0.0
        self.close()
        self.cases = [Case(self.F[:, :, lane], rng, S) for lane in range(LANES)]

    def close(self) -> None:
        """Bring the sums of all rows into step."""
        for i in range(ROWS):
            kernels.close(self.F, i, self.S)

    def values(self, i: int) -> list[Fraction]:
        """Return what row ``i`` encloses, lane by lane."""
        return [case.value(i) for case in self.cases]

    def check(self, out: int, exact: Sequence[Fraction]) -> None:
        """Assert that row ``out`` encloses ``exact`` in every lane."""
        low, high = calls.bounds(self.F, out, self.S)
        largest = calls.largest(self.F, out, self.S)
        for case, value, lo, hi, most in zip(self.cases, exact, low, high, largest, strict=True):
            row = case.F[out]
            assert lo <= value <= hi
            if not np.all(np.isfinite(row)):
                assert (lo, hi) == (-math.inf, math.inf)
                continue
            assert abs(value - polynomial(row, case.at)) <= Fraction(row[case.error])
            assert most == math.inf or abs(value) <= Fraction(most)
            check_sums(row, self.S)


def batches(scale: str, S: Symbols, count: int, seed: int = 0) -> list[Batch]:
    """Return batches of altogether about ``count`` cases."""
    rng = random.Random(f"{scale} {len(S.noise)} {seed}")
    return [Batch(rng, S, scale) for _ in range(-(-count // LANES))]


def combined(*terms: tuple[Any, Sequence[Fraction]]) -> list[Fraction]:
    """Return the sum of coefficients times values, lane by lane."""
    return [
        sum((Fraction(c[lane]) * value[lane] for c, value in terms), Fraction(0)) for lane in range(LANES)
    ]


@every_count
@every_scale
def test_bounds_largest_and_close(scale: str, S: Symbols) -> None:
    for batch in batches(scale, S, 20):
        for i in range(ROWS):
            batch.check(i, batch.values(i))


@every_count
@every_scale
def test_bounds_reach_the_extreme_points(scale: str, S: Symbols) -> None:
    """At every corner, at the vertex in one symbol and with the whole error."""
    rng = random.Random(1)
    for batch in batches(scale, S, 20):
        for i in range(ROWS):
            for case, lo, hi in zip(batch.cases, *calls.bounds(batch.F, i, S), strict=True):
                row = case.F[i]
                eps, delta = ([Fraction(rng.choice([-1, 1])) for _ in x] for x in S)
                k = rng.randrange(len(S.noise))
                square = Fraction(row[1 + len(S.noise) + k])
                if square:
                    others = [*eps[:k], Fraction(0), *eps[k + 1 :]]
                    base = polynomial(row, Point(others, delta))
                    one = Point([*eps[:k], Fraction(1), *eps[k + 1 :]], delta)
                    slope = polynomial(row, one) - base - square
                    eps[k] = min(max(-slope / (2 * square), Fraction(-1)), Fraction(1))
                value, error = polynomial(row, Point(eps, delta)), Fraction(row[case.error])
                assert lo <= value - error and value + error <= hi


@every_count
def test_bounds_of_one_symbol_are_its_range(S: Symbols) -> None:
    rng = random.Random(2)
    K, e = len(S.noise), error_column(S)
    for batch in batches("plain", S, 100):
        for case in batch.cases:
            row, k = case.F[0], rng.randrange(K)
            slope, square, error = row[1 + k], row[1 + K + k], row[e]
            row[1:] = 0.0
            row[1 + k], row[1 + K + k], row[e] = slope, square, error
        kernels.close(batch.F, 0, S)
        for case, lo, hi in zip(batch.cases, *calls.bounds(batch.F, 0, S), strict=True):
            c, error = case.F[0, 0], case.F[0, e]
            slope, square = case.F[0, 1 : 1 + K].sum(), case.F[0, 1 + K : 1 + 2 * K].sum()
            values = [c + slope + square, c - slope + square]
            if abs(slope) < 2 * abs(square):
                values.append(c - slope**2 / (4 * square))
            room = 1e-12 * (abs(c) + abs(slope) + abs(square) + error) + 1e-300
            assert min(values) - error - room <= lo <= min(values) - error + room
            assert max(values) + error - room <= hi <= max(values) + error + room


@every_count
def test_bounds_after_an_overflow_are_the_whole_line(S: Symbols) -> None:
    """In the lane of the overflow only."""
    e, lane = error_column(S), 0
    columns = [*range(e + 1), *range(e + 3, e + 3 + len(S.data))]
    for bad in (math.inf, -math.inf, math.nan):
        for k in columns:
            F = np.ones((1, width(S), LANES))
            F[0, k, lane] = abs(bad) if k == e else bad
            kernels.close(F, 0, S)
            lo, hi = calls.bounds(F, 0, S)
            most = calls.largest(F, 0, S)
            for other in range(LANES):
                if other == lane:
                    assert (lo[other], hi[other]) == (-math.inf, math.inf)
                    assert not most[other] < math.inf
                else:
                    assert -len(columns) - 1 < lo[other] < hi[other] < len(columns) + 1
                    assert most[other] < len(columns) + 1
            lane = (lane + 1) % LANES


@every_count
@every_scale
def test_constant_widen_and_copy(scale: str, S: Symbols) -> None:
    rng = random.Random(3)
    for batch in batches(scale, S, 25):
        value, error = coefficients(rng, scale), abs(coefficients(rng, scale))
        calls.constant(batch.F, OUT, value, error, S)
        share = [unit_value(rng) for _ in range(LANES)]
        batch.check(OUT, combined((value, [Fraction(1)] * LANES), (error, share)))
        assert not np.delete(batch.F[OUT], [0, error_column(S)], axis=0).any()
        kernels.copy(batch.F, OUT, 1, S)
        assert np.array_equal(batch.F[OUT], batch.F[1])
        exact = batch.values(0)
        extra = abs(coefficients(rng, rng.choice([scale, "plain"])))
        calls.widen(batch.F, 0, extra, S)
        for sign in (-1, 1):
            batch.check(0, [x + sign * Fraction(e) for x, e in zip(exact, extra, strict=True)])


@every_count
@every_scale
def test_scale_and_add_scaled(scale: str, S: Symbols) -> None:
    rng = random.Random(4)
    one = np.ones(LANES)
    for batch in batches(scale, S, 25):
        c, d, e = (coefficients(rng, rng.choice([scale, "plain"])) for _ in range(3))
        v = [batch.values(i) for i in range(7)]
        calls.scale(batch.F, OUT, 0, c, S)
        batch.check(OUT, combined((c, v[0])))
        calls.scale(batch.F, 0, 0, d, S)
        batch.check(0, combined((d, v[0])))
        calls.add_scaled(batch.F, 2, 1, e, S)
        batch.check(2, combined((one, v[2]), (e, v[1])))
        # A row's own error is one unknown, but a kernel must not rely on that.
        calls.add_scaled(batch.F, 3, 3, -one, S)
        batch.check(3, [Fraction(0)] * LANES)
        calls.scale(batch.F, 4, 5, -one, S)
        calls.add_scaled(batch.F, 4, 6, one, S)
        batch.check(4, combined((one, v[6]), (-one, v[5])))


@every_count
@every_scale
def test_combine2(scale: str, S: Symbols) -> None:
    """Into another row and into either of the two; also a row with itself."""
    rng = random.Random(7)
    for batch in batches(scale, S, 25):
        c, d = (coefficients(rng, rng.choice([scale, "plain"])) for _ in range(2))
        for out, a, b in ((OUT, 0, 1), (2, 2, 3), (5, 4, 5), (OUT, 6, 6)):
            exact = combined((c, batch.values(a)), (d, batch.values(b)))
            calls.combine2(batch.F, out, a, c, b, d, S)
            batch.check(out, exact)


@every_count
@every_scale
def test_combine3(scale: str, S: Symbols) -> None:
    rng = random.Random(5)
    for batch in batches(scale, S, 25):
        c = np.array([coefficients(rng, rng.choice([scale, "plain"])) for _ in range(3)])
        error = rng.choice([0.0, 1.0]) * abs(coefficients(rng, scale))
        calls.combine3(batch.F, OUT, 5, c, error, S)
        share = [unit_value(rng) for _ in range(LANES)]
        batch.check(OUT, combined(*((c[k], batch.values(5 + k)) for k in range(3)), (error, share)))


@every_count
@every_scale
def test_combine6_and_moving6(scale: str, S: Symbols) -> None:
    rng = random.Random(6)
    for batch in batches(scale, S, 25):
        W = np.zeros((2 + symbols(S), 8, LANES))
        for lane in range(LANES):
            kind = rng.choice([scale, "plain"])
            for y in range(1, 2 + symbols(S)):
                for k in range(6):
                    W[y, k, lane] = coefficient(rng, kind)
        values = [batch.values(2 + k) for k in range(6)]
        kernels.combine6(batch.F, OUT, 2, W, 1, S)
        batch.check(OUT, combined(*((W[1, k], values[k]) for k in range(6))))
        kernels.moving6(batch.F, OUT, 2, W, 1, S)
        exact = []
        for lane, case in enumerate(batch.cases):
            y = [Fraction(W[1, k, lane]) for k in range(6)]
            for m, eps in enumerate([*case.at.eps, *case.at.delta]):
                y = [a + Fraction(W[2 + m, k, lane]) * eps for k, a in enumerate(y)]
            exact.append(sum((a * b[lane] for a, b in zip(y, values, strict=True)), Fraction(0)))
        batch.check(OUT, exact)


@every_count
@every_scale
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_add_product(scale: str, S: Symbols, sign: float) -> None:
    for batch in batches(scale, S, 25, int(sign)):
        # Also a row times itself, and a second product added to the first.
        values = [batch.values(i) for i in range(7)]
        first = [c + int(sign) * a * b for a, b, c in zip(*values[:3], strict=True)]
        kernels.add_product(batch.F, 2, 0, 1, sign, S)
        batch.check(2, first)
        second = [c - int(sign) * a * b for a, b, c in zip(*values[5:7], first, strict=True)]
        kernels.add_product(batch.F, 2, 5, 6, -sign, S)
        batch.check(2, second)
        square = [c + int(sign) * a**2 for a, c in zip(*values[3:5], strict=True)]
        kernels.add_product(batch.F, 4, 3, 3, sign, S)
        batch.check(4, square)


@every_count
@every_scale
def test_multiply_dot3_and_cross3(scale: str, S: Symbols) -> None:
    for batch in batches(scale, S, 15):
        v = [[case.value(i) for i in range(OUT)] for case in batch.cases]
        for a, b in ((0, 1), (2, 2)):
            kernels.multiply(batch.F, OUT, a, b, 1.0, S)
            batch.check(OUT, [x[a] * x[b] for x in v])
        for a, b in ((0, 3), (6, 6)):
            kernels.dot3(batch.F, OUT, a, b, S)
            batch.check(OUT, [sum((x[a + k] * x[b + k] for k in range(3)), Fraction(0)) for x in v])
        for a, b in ((0, 3), (4, 7)):
            kernels.cross3(batch.F, OUT, a, b, S)
            for k in range(3):
                i, j = (k + 1) % 3, (k + 2) % 3
                batch.check(OUT + k, [x[a + i] * x[b + j] - x[a + j] * x[b + i] for x in v])


def every_kernel(F: Any, c: Any, W: Any, S: Symbols) -> tuple[Any, ...]:
    """Call all kernels one after the other on the same rows; return their values."""
    calls.scale(F, 0, 1, c[0], S)
    calls.add_scaled(F, 1, 2, c[1], S)
    calls.combine2(F, 2, 3, c[2], 4, c[3], S)
    calls.combine3(F, 3, 5, c[:3], abs(c[4]), S)
    calls.constant(F, 4, c[5], abs(c[6]), S)
    calls.widen(F, 5, abs(c[7]), S)
    kernels.add_datum(F, 12, 11, 0, 0.75, S)
    kernels.combine6(F, 6, 0, W, 0, S)
    kernels.moving6(F, 7, 0, W, 1, S)
    kernels.add_product(F, 8, 1, 2, -1.0, S)
    kernels.multiply(F, 9, 0, 3, 1.0, S)
    kernels.copy(F, 11, 9, S)
    kernels.cross3(F, OUT, 1, 5, S)
    kernels.dot3(F, 9, 1, 5, S)
    kernels.close(F, 12, S)
    values = [value for i in range(ROWS) for value in (*calls.bounds(F, i, S), calls.largest(F, i, S))]
    return (*values, *(calls.magnitude(F, i, S) for i in range(ROWS)))


def garbage(rng: random.Random, shape: tuple[int, ...]) -> Any:
    """Return an array of anything a lane may hold."""
    pool = [math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324, 0.0, -0.0, 1.0, 1e-300, 3.7]
    return np.array([rng.choice(pool) for _ in range(math.prod(shape))]).reshape(shape)


def same_bits(a: Any, b: Any) -> bool:
    """Return True when two arrays hold the same doubles, NaN being one of them."""
    a, b = np.where(np.isnan(a), np.nan, a), np.where(np.isnan(b), np.nan, b)
    return bool(
        np.array_equal(np.ascontiguousarray(a).view(np.int64), np.ascontiguousarray(b).view(np.int64))
    )


@every_count
@every_scale
def test_a_lane_does_not_depend_on_its_neighbours_or_its_place(scale: str, S: Symbols) -> None:
    rng = random.Random(8)
    for batch in batches(scale, S, 12, 9):
        c = np.array([coefficients(rng, rng.choice([scale, "plain"])) for _ in range(8)])
        W = np.array([[coefficients(rng, scale) for _ in range(6)] for _ in range(2 + symbols(S))])
        F = batch.F.copy()
        values = every_kernel(F, c, W, S)
        order = rng.sample(range(LANES), LANES)
        moved = [np.ascontiguousarray(a[..., order]) for a in (batch.F, c, W)]
        found = every_kernel(*moved, S)
        assert same_bits(moved[0], F[..., order])
        assert all(same_bits(a, b[order]) for a, b in zip(found, values, strict=True))
        for lane in range(LANES):
            bad = [garbage(rng, a.shape) for a in (batch.F, c, W)]
            for a, b in zip(bad, (batch.F, c, W), strict=True):
                a[..., lane] = b[..., lane]
            found = every_kernel(*bad, S)
            assert same_bits(bad[0][..., lane], F[..., lane])
            assert all(same_bits(a[[lane]], b[[lane]]) for a, b in zip(found, values, strict=True))


@every_count
def test_plain_rows_stay_finite(S: Symbols) -> None:
    """The tests above would pass for kernels whose errors are infinite."""
    for batch in batches("plain", S, 10):
        kernels.cross3(batch.F, OUT, 0, 3, S)
        kernels.dot3(batch.F, 9, 0, 3, S)
        kernels.moving6(batch.F, 8, 0, np.ones((1 + symbols(S), 6, LANES)), 0, S)
        assert np.all(np.isfinite(batch.F))


@every_count
def test_products_of_linear_rows_are_exact_up_to_rounding(S: Symbols) -> None:
    K, e = len(S.noise), error_column(S)
    for batch in batches("plain", S, 100):
        F = batch.F
        F[:, 1 + K :] = 0.0
        batch.close()
        kernels.multiply(F, OUT, 0, 1, 1.0, S)
        size = abs(F[0, : 1 + K]).sum(axis=0) * abs(F[1, : 1 + K]).sum(axis=0)
        assert np.all(F[OUT, e] <= 1e-14 * size + 1e-300)
        batch.check(OUT, [a * b for a, b in zip(batch.values(0), batch.values(1), strict=True)])


@every_count
def test_products_drop_only_third_and_fourth_order(S: Symbols) -> None:
    """And products with symbols of data."""
    e = error_column(S)
    for batch in batches("plain", S, 100):
        F = batch.F
        F[:, e] = 0.0
        kernels.multiply(F, OUT, 0, 1, 1.0, S)
        (l0, q0, d0), (l1, q1, d1) = ((F[i, e + 1], F[i, e + 2], data_of(F, i, S)) for i in (0, 1))
        a, b = abs(F[0, 0]) + l0 + q0 + d0, abs(F[1, 0]) + l1 + q1 + d1
        dropped = l0 * q1 + q0 * l1 + q0 * q1 + d0 * (l1 + q1 + d1) + d1 * (l0 + q0)
        assert np.all(F[OUT, e] <= dropped * (1.0 + 1e-12) + 1e-14 * a * b)


def data_of(F: Any, i: int, S: Symbols) -> Any:
    """Return the sum |d| of a row, lane by lane."""
    return F[i, -1] if S.data else np.zeros(LANES)


@every_count
@every_scale
def test_add_datum(scale: str, S: Symbols) -> None:
    """A number times a symbol of data times a row; without such symbols, any number of that size."""
    rng = random.Random(10)
    for batch in batches(scale, S, 25):
        c, datum = coefficient(rng, rng.choice([scale, "plain"])), rng.randrange(max(1, len(S.data)))
        before, factor = batch.values(0), batch.values(1)
        delta = [case.at.delta[datum] if S.data else unit_value(rng) for case in batch.cases]
        kernels.add_datum(batch.F, 0, 1, datum, c, S)
        terms = zip(before, factor, delta, strict=True)
        batch.check(0, [x + Fraction(c) * d * y for x, y, d in terms])


@every_count
def test_a_datum_times_a_constant_is_exact_up_to_rounding(S: Symbols) -> None:
    e = error_column(S)
    for batch in batches("plain", S, 20):
        F = batch.F
        F[1, 1:] = 0.0
        F[0, e] = 0.0
        kernels.add_datum(F, 0, 1, 0, 0.5, S)
        most = abs(F[0]).sum(axis=0) + abs(F[1, 0])
        assert np.all(F[0, e] <= 1e-14 * most + (0.0 if S.data else 0.5 * abs(F[1, 0])))


@every_count
def test_sums_stay_sharp(S: Symbols) -> None:
    one, zero, e = np.ones(LANES), np.zeros(LANES), error_column(S)
    for batch in batches("plain", S, 100):
        F = batch.F
        size = np.delete(abs(F), e, axis=1).sum(axis=1)
        before = F[0, e] + F[1, e]
        calls.add_scaled(F, 0, 1, one, S)
        assert np.all(F[0, e] <= before * (1.0 + 1e-12) + 1e-14 * size[:2].sum(axis=0))
        calls.combine3(F, OUT, 3, np.array([one, -one, one]), zero, S)
        after = F[3:6, e].sum(axis=0) * (1.0 + 1e-12) + 1e-14 * size[3:6].sum(axis=0)
        assert np.all(F[OUT, e] <= after)
        before = F[6:8, e].sum(axis=0)
        calls.combine2(F, OUT, 6, one, 7, -one, S)
        assert np.all(F[OUT, e] <= before * (1.0 + 1e-12) + 1e-14 * size[6:8].sum(axis=0))
