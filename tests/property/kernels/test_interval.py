"""Rounding, interval arithmetic and enclosures of rationals against exact fractions and Arb balls."""

from __future__ import annotations

import math
import random
from fractions import Fraction

import flint
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.kernels import interval
from cdpr_interval.kernels.rounding import ETA, LARGEST, down, inflate, up

INF = math.inf
finite = st.floats(allow_nan=False, allow_infinity=False, width=64)
special = st.sampled_from(
    [
        0.0,
        -0.0,
        ETA,
        -ETA,
        2.0**-1022,
        1.0,
        -1.0,
        1.0 + 2.0**-52,
        1.0 - 2.0**-53,
        LARGEST,
        -LARGEST,
        1e308,
        1e-308,
    ]
)
number = st.one_of(finite, special, st.floats(-10.0, 10.0))
bound = st.one_of(number, st.sampled_from([INF, -INF]))


@st.composite
def intervals(draw: st.DrawFn, bounds: st.SearchStrategy[float] = bound) -> tuple[float, float]:
    """Draw lo <= hi; no interval is one infinite point."""
    lo = draw(bounds)
    hi = lo if draw(st.booleans()) else draw(bounds)
    lo, hi = min(lo, hi), max(lo, hi)
    return (-LARGEST if lo == INF else lo), (LARGEST if hi == -INF else hi)


@st.composite
def members(draw: st.DrawFn) -> tuple[tuple[float, float], Fraction]:
    """Draw an interval and an exact number in it."""
    lo, hi = draw(intervals())
    a = (
        Fraction(max(lo, -LARGEST))
        if lo > -INF
        else Fraction(min(hi, LARGEST)) - 10 ** draw(st.integers(0, 400))
    )
    b = Fraction(hi) if hi < INF else max(a, Fraction(max(lo, -LARGEST))) + 10 ** draw(st.integers(0, 400))
    weight = Fraction(draw(st.integers(0, 64)), 64)
    return (lo, hi), a + weight * (b - a)


def inside(result: tuple[float, float], exact: Fraction) -> bool:
    """Return True when an exact number lies in bounds that may be infinite."""
    lo, hi = result
    assert not (math.isnan(lo) or math.isnan(hi))
    return (lo == -INF or (lo < INF and Fraction(lo) <= exact)) and (
        hi == INF or (hi > -INF and exact <= Fraction(hi))
    )


@given(number)
def test_down_and_up_reach_the_neighbours(r: float) -> None:
    assert down(r) <= math.nextafter(r, -INF) and up(r) >= math.nextafter(r, INF)
    for bounded, direction in ((down(r), -INF), (up(r), INF)):
        if math.isfinite(bounded):
            two = math.nextafter(math.nextafter(r, direction), direction)
            assert abs(bounded - r) <= abs(two - r)


def test_overflow_and_infinities_round_to_safe_bounds() -> None:
    assert down(INF) == LARGEST and up(-INF) == -LARGEST
    assert up(INF) == INF and down(-INF) == -INF
    assert math.isnan(down(math.nan)) and math.isnan(up(math.nan))


@given(st.lists(st.tuples(number, number), min_size=1, max_size=12))
def test_inflate_covers_the_rounding_of_a_sum_of_products(pairs: list[tuple[float, float]]) -> None:
    total, size = 0.0, 0.0
    for a, b in pairs:
        total += a * b
        size += abs(a * b) + abs(total)
    if not math.isfinite(total) or not math.isfinite(size):
        return
    exact = sum((Fraction(a) * Fraction(b) for a, b in pairs), Fraction(0))
    error = inflate(0.0, size, 4.0 * len(pairs))
    assert abs(exact - Fraction(total)) <= (Fraction(error) if math.isfinite(error) else abs(exact) + 1)


@given(members(), members())
@example(((0.0, INF), Fraction(10) ** 400), ((0.0, 0.0), Fraction(0)))
@example(((-INF, INF), Fraction(0)), ((ETA, ETA), Fraction(ETA)))
@example(((ETA, ETA), Fraction(ETA)), ((ETA, ETA), Fraction(ETA)))
def test_arithmetic_encloses(
    a: tuple[tuple[float, float], Fraction], b: tuple[tuple[float, float], Fraction]
) -> None:
    (x, p), (y, q) = a, b
    assert inside(interval.add(*x, *y), p + q)
    assert inside(interval.sub(*x, *y), p - q)
    assert inside(interval.mul(*x, *y), p * q)
    assert inside(interval.sqr(*x), p * p)
    if q != 0:
        assert inside(interval.div(*x, *y), p / q)
    if math.isfinite(y[0]):
        assert inside(interval.scale(y[0], *x), Fraction(y[0]) * p)


@given(members())
def test_square_roots_enclose(a: tuple[tuple[float, float], Fraction]) -> None:
    x, p = a
    lo, hi = interval.sqrt(*x)
    if x[1] < 0.0:
        assert (lo, hi) == (INF, -INF)
        return
    assert 0.0 <= lo <= hi
    if p >= 0:
        # Squares keep the comparison exact.
        assert Fraction(lo) ** 2 <= p and (hi == INF or p <= Fraction(hi) ** 2)


@given(st.floats(1e-300, 1e300), st.floats(1e-300, 1e300))
def test_against_arb(a: float, b: float) -> None:
    with flint.ctx.workprec(300):
        exact = flint.arb(a).sqrt() / flint.arb(b)
        root = interval.sqrt(a, a)
        lo, hi = interval.div(*root, b, b)
        assert not exact < flint.arb(lo) or math.isinf(lo)
        assert math.isinf(hi) or not exact > flint.arb(hi)
        if lo > 1e-290 and hi < 1e290:
            assert hi - lo <= 16 * 2.0**-52 * hi


@given(intervals())
def test_middle_radius_and_magnitudes(x: tuple[float, float]) -> None:
    lo, hi = x
    m = interval.mid(lo, hi)
    assert math.isfinite(m) and lo <= m <= hi
    r = interval.rad(lo, hi)
    if r < INF:
        assert Fraction(r) >= Fraction(hi) - Fraction(m) and Fraction(r) >= Fraction(m) - Fraction(lo)
    assert interval.mag(lo, hi) == max(abs(lo), abs(hi))
    smallest = 0.0 if lo <= 0.0 <= hi else min(abs(lo), abs(hi))
    assert interval.mig(lo, hi) == smallest


@pytest.mark.parametrize("operation", [interval.add, interval.sub, interval.mul, interval.div])
@given(members(), intervals(), intervals())
def test_wider_arguments_give_wider_results(operation, a, y, other) -> None:
    x = a[0]
    wide = (min(y[0], other[0]), max(y[1], other[1]))
    lo, hi = operation(*x, *y)
    lower, upper = operation(*x, *wide)
    assert lower <= lo and hi <= upper


def exact_atan(a: float) -> flint.arb:
    """Return the arc tangent of a double that may be infinite."""
    return flint.arb(a).atan() if math.isfinite(a) else math.copysign(1, a) * flint.arb.pi() / 2


@given(
    st.one_of(bound, st.floats(-math.pi / 2, math.pi / 2).map(math.tan)),
    st.one_of(bound, st.integers(-1074, 1023).map(lambda e: 2.0**e)),
    st.booleans(),
)
@example(0.0, -0.0, False)
@example(1.0, 1.0, True)
@example(math.nextafter(1.0, 2.0), math.nextafter(1.0, 0.0), False)
@example(-INF, INF, False)
@example(INF, INF, True)
@example(ETA, -ETA, False)
@example(LARGEST, -LARGEST, False)
def test_atan_encloses(a: float, b: float, point: bool) -> None:
    lo, hi = (a, a) if point else (min(a, b), max(a, b))
    found = interval.atan(lo, hi)
    with flint.ctx.workprec(300):
        # 300 bits tell the arc tangent of a tiny number from the number, unless it is below 1e-40.
        below, above = exact_atan(lo), exact_atan(hi)
        if abs(lo) > 1e-40 or lo == 0.0:
            assert flint.arb(found[0]) <= below
        if abs(hi) > 1e-40 or hi == 0.0:
            assert above <= flint.arb(found[1])
        assert found[0] <= lo or lo > 0.0 or abs(lo) > 1e-40
        assert found[1] >= hi or hi < 0.0 or abs(hi) > 1e-40
        # And closely.
        for bound, exact in zip(found, (below, above), strict=True):
            assert abs(bound - exact) <= flint.arb(1e-14) * abs(exact) + flint.arb(1e-300)


@pytest.mark.parametrize("seed", [0])
def test_atan_encloses_many_random_points(seed: int) -> None:
    rng = random.Random(seed)
    with flint.ctx.workprec(300):
        for _ in range(5000):
            a = math.tan(rng.uniform(-1.5707963, 1.5707963)) * rng.choice([1.0, 1.0, 1e-8, 1e8])
            lo, hi = interval.atan(a, a)
            assert flint.arb(lo) <= flint.arb(a).atan() <= flint.arb(hi), a


@given(
    st.fractions()
    | st.builds(lambda n, e: Fraction(n) * Fraction(10) ** e, st.integers(-99, 99), st.integers(-420, 420))
)
@example(Fraction(1, 10))
@example(Fraction(0))
@example(Fraction(ETA) / 2)
@example(Fraction(ETA) / 3)
@example(-Fraction(LARGEST) - 1)
@example(Fraction(LARGEST) * 2)
@example(Fraction(3, 2) * Fraction(ETA))
def test_enclose_returns_the_neighbours(x: Fraction) -> None:
    lo, hi = enclose(x)
    assert inside((lo, hi), x)
    if lo != hi:
        assert math.nextafter(lo, INF) == hi
        assert lo == -INF or Fraction(lo) < x
        assert hi == INF or x < Fraction(hi)
    else:
        assert Fraction(lo) == x
