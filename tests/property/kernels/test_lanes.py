"""Lanes of doubles: every operation gives in each lane what it gives on doubles, bit by bit."""

from __future__ import annotations

import math
import operator
import random
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numba import njit

from cdpr_interval.kernels import dense, rounding
from cdpr_interval.kernels.lanes import LANES
from tests.support import lane_calls as calls
from tests.support.kernel_callers import caller

solve_definite = caller(dense.solve_definite)


SPECIAL = [
    *(0.0, 5e-324, 1e-310, 2.0**-1022, 1e-160, 0.3, 1.0, 1.0 + 2.0**-52, 2.0, 1e16, 1e160, 1.7e308),
    *(1.7976931348623157e308, math.inf),
]
POOL = [*SPECIAL, *(-x for x in SPECIAL), math.nan]


def values(rng: random.Random) -> Any:
    """Return a double for every lane: anything, or with a full mantissa."""
    return np.array(
        [
            rng.choice(POOL)
            if rng.random() < 0.5
            else rng.choice([-1, 1]) * math.ldexp(rng.uniform(1.0, 2.0), rng.randint(-1074, 1023))
            for _ in range(LANES)
        ]
    )


def bits(x: Any) -> list[str]:
    """Return doubles so that -0 and 0 differ, and NaN equals NaN."""
    return [float(v).hex() for v in x]


OPERATIONS = {
    "add": (operator.add, operator.iadd),
    "sub": (operator.sub, operator.isub),
    "mul": (operator.mul, operator.imul),
    "div": (operator.truediv, operator.itruediv),
}


@pytest.mark.parametrize("name", OPERATIONS)
@pytest.mark.parametrize("in_place", [False, True])
def test_arithmetic_is_that_of_doubles(name: str, in_place: bool) -> None:
    rng = random.Random(1)
    operation = OPERATIONS[name][in_place]
    of_lanes, with_right, with_left = calls.binary(operation)
    with np.errstate(all="ignore"):
        for _ in range(200):
            a, b = values(rng), values(rng)
            assert bits(of_lanes(a, b)) == bits(OPERATIONS[name][0](a, b))
            x = rng.choice(POOL)
            assert bits(with_right(a, x)) == bits(OPERATIONS[name][0](a, x))
            if not in_place:
                assert bits(with_left(x, a)) == bits(OPERATIONS[name][0](x, a))


def test_signs_and_roots() -> None:
    rng = random.Random(2)
    absolute, negative = calls.unary(abs), calls.unary(operator.neg)
    with np.errstate(all="ignore"):
        for _ in range(200):
            a = values(rng)
            assert bits(absolute(a)) == bits(abs(a))
            assert bits(negative(a)) == bits(-a)
            assert bits(calls.root(a)) == bits(np.sqrt(a))


def test_splat_fills_every_lane() -> None:
    for x in POOL:
        assert bits(calls.splat(x)) == bits([x] * LANES)


def test_load_and_store_reach_one_entry_only() -> None:
    rng = random.Random(3)
    for _ in range(100):
        shape, other = (rng.randint(1, 4), rng.randint(1, 5)), (rng.randint(1, 4), rng.randint(1, 5))
        a, b = np.random.default_rng(1).random((*shape, LANES)), np.zeros((*other, LANES))
        i, k, j, m = (rng.randrange(n) for n in (*shape, *other))
        calls.copy_entry(a, i, k, b, j, m)
        assert np.array_equal(b[j, m], a[i, k]) and np.count_nonzero(b) == LANES
        calls.store_float(b, j, m, 7.0)
        assert np.array_equal(b[j, m], [7.0] * LANES) and np.count_nonzero(b) == LANES


def test_where_less_chooses_lane_by_lane() -> None:
    rng = random.Random(4)
    seen = set()
    for _ in range(500):
        a, b, yes, no = (values(rng) for _ in range(4))
        if rng.random() < 0.3:
            b = rng.choice([1.0, -1.0]) * a
        expected = [y if p < q else n for p, q, y, n in zip(a, b, yes, no, strict=True)]
        assert bits(calls.where_less(a, b, yes, no)) == bits(expected)
        x, y = rng.choice(POOL), rng.choice(POOL)
        expected = [y if p < x else n for p, n in zip(a, no, strict=True)]
        assert bits(calls.where_less_mixed(a, x, y, no)) == bits(expected)
        seen |= {(bool(p < q), bool(p == q), bool(p != p or q != q)) for p, q in zip(a, b, strict=True)}
    # Smaller, equal, larger, and NaN, where ``no`` is right.
    assert len(seen) == 4
    nan, one, two = np.full(LANES, math.nan), np.ones(LANES), np.full(LANES, 2.0)
    for a, b in ((nan, one), (one, nan), (nan, nan)):
        assert bits(calls.where_less(a, b, one, two)) == bits(two)


def test_rounding_is_that_of_doubles() -> None:
    """Bit by bit, where ``test_interval_kernels`` proves the bounds of the scalar kernels."""
    rng = random.Random(5)
    for start in range(0, len(POOL), LANES):
        a = np.array([POOL[(start + k) % len(POOL)] for k in range(LANES)])
        assert bits(calls.down(a)) == bits(map(rounding.down, a))
        assert bits(calls.up(a)) == bits(map(rounding.up, a))
    for _ in range(500):
        a = values(rng)
        assert bits(calls.down(a)) == bits(map(rounding.down, a))
        assert bits(calls.up(a)) == bits(map(rounding.up, a))
        for x, lo, hi in zip(a, calls.down(a), calls.up(a), strict=True):
            if math.isfinite(x):
                assert lo <= math.nextafter(x, -math.inf) and math.nextafter(x, math.inf) <= hi
            elif math.isinf(x):
                assert lo < math.inf and hi > -math.inf
            else:
                assert math.isnan(lo) and math.isnan(hi)


def test_inflation_is_that_of_doubles() -> None:
    rng = random.Random(6)
    for _ in range(500):
        error, magnitude = abs(values(rng)), abs(values(rng))
        operations = float(rng.choice([1, 4, 10, 60, 200, 1000]))
        found = calls.inflate(error, magnitude, operations)
        expected = [rounding.inflate(e, m, operations) for e, m in zip(error, magnitude, strict=True)]
        assert bits(found) == bits(expected)
        for e, m, x in zip(error, magnitude, found, strict=True):
            if math.isfinite(e) and math.isfinite(m):
                least = Fraction(e) * (1 + Fraction(2 * operations) / 2**53) + Fraction(m) / 2**53
                assert x == math.inf or Fraction(x) >= least + Fraction(operations) / 2**1074
            else:
                assert not x < math.inf


def test_a_function_of_lanes_does_not_depend_on_their_place() -> None:
    """Also where several registers are alive at once."""

    @njit
    def mix(a: Any, b: Any, c: Any) -> Any:
        x, y, z = calls.get(a), calls.get(b), calls.get(c)
        total = x - x
        for k in range(5):
            total = calls.lanes.where_less(x * y, z + float(k), total + abs(x) / z, total - y)
            x, y, z = y, z, calls.lanes.root(abs(x * z))
        total += 2.0 * z
        total *= -1.0
        return calls.put(total)

    rng = random.Random(7)
    for _ in range(100):
        a, b, c = (values(rng) for _ in range(3))
        found = mix(a, b, c)
        order = rng.sample(range(LANES), LANES)
        assert bits(mix(a[order], b[order], c[order])) == bits(found[order])
        for lane in range(LANES):
            alone = mix(*(np.full(LANES, v[lane]) for v in (a, b, c)))
            assert bits(alone) == bits([found[lane]] * LANES)


@pytest.mark.parametrize("n", range(1, 8))
def test_solve_definite_solves_another_system_in_every_lane(n: int) -> None:
    rng = np.random.default_rng(n)
    for columns in range(1, 8):
        first = n % 3
        a = np.full((first + n + 1, n + columns + 1, LANES), 7.0)
        rows = a[first : first + n]
        b = rng.normal(size=(n, columns, LANES))
        for lane in range(LANES):
            root = rng.normal(size=(n, n + 2))
            rows[:, :n, lane] = root @ root.T + 0.1 * np.eye(n)
        rows[:, n : n + columns] = b
        matrices = rows[:, :n].copy()
        solve_definite(a, first, n, columns)
        for lane in range(LANES):
            expected = np.linalg.solve(matrices[:, :, lane], b[:, :, lane])
            assert np.allclose(rows[:, n:-1, lane], expected, rtol=1e-9, atol=1e-9 * abs(expected).max())
        # Nothing beyond the system is touched.
        assert np.all(a[:first] == 7.0) and np.all(a[first + n] == 7.0) and np.all(a[:, -1] == 7.0)


def test_solve_definite_gives_no_numbers_where_a_lane_is_singular() -> None:
    for n in range(1, 7):
        for bad in range(LANES):
            for kind in range(3):
                a = np.zeros((n, n + 1, LANES))
                for lane in range(LANES):
                    a[:, :n, lane] = np.eye(n) * (lane + 1.0)
                    a[:, n, lane] = np.arange(1.0, n + 1.0)
                if kind == 0:
                    a[n - 1, :n, bad] = a[:n, n - 1, bad] = 0.0
                elif kind == 1:
                    # Rank one; the elimination is exact.
                    a[:, :n, bad] = 1.0 if n > 1 else 0.0
                else:
                    a[0, 0, bad] = math.nan
                solve_definite(a, 0, n, 1)
                assert not np.all(np.isfinite(a[:, n, bad]))
                for lane in range(LANES):
                    if lane != bad:
                        assert np.allclose(a[:, n, lane], np.arange(1.0, n + 1.0) / (lane + 1.0), rtol=1e-14)
