"""The Krawczyk operator and Newton's method of the engine, on a system of two equations with known zeros.

F(x, y) = (x^2 + y^2 - 2 (1 + d), x - y) for all d in a range; its zeros are x = y = +-sqrt(1 + d).
"""

from __future__ import annotations

import math
import random
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numba import njit

from cdpr_interval.engine import krawczyk as engine
from cdpr_interval.engine.krawczyk import Contractions, Tries
from cdpr_interval.engine.newton import Pace, newton
from cdpr_interval.kernels.interval import add, mul, scale, sqr, sub
from tests.support.kernel_callers import Callers

called = Callers(engine)
TRIES = Tries(boxes=12, growth=1.2, kept=1.0)
CONTRACTIONS = Contractions(most=6, gain=0.99)
ANYWHERE = np.array([[np.inf, -np.inf]] * 2)
PACE = Pace(converged=1e-14, stalled=1e-10, fresh=1e-3, slow=0.1)


@njit
def residual(context: Any, box: Any, f: Any) -> None:
    """Enclose F (2, 2) over a box (2, 2); the context is (d (2,), C (2, 2))."""
    d, _ = context
    a, b = sqr(box[0, 0], box[0, 1])
    lo, hi = sqr(box[1, 0], box[1, 1])
    lo, hi = add(a, b, lo, hi)
    a, b = add(2.0, 2.0, 2.0 * d[0], 2.0 * d[1])
    f[0, 0], f[0, 1] = sub(lo, hi, a, b)
    f[1, 0], f[1, 1] = sub(box[0, 0], box[0, 1], box[1, 0], box[1, 1])


@njit
def jacobian(box: Any, J: Any) -> None:
    """Enclose F' (2, 2, 2) over a box (2, 2)."""
    for j in range(2):
        J[0, j, 0], J[0, j, 1] = 2.0 * box[j, 0], 2.0 * box[j, 1]
        J[1, j, 0], J[1, j, 1] = 1.0 - 2.0 * j, 1.0 - 2.0 * j


@njit
def deviate(context: Any, box: Any, E: Any) -> None:
    """Enclose I - C F' (2, 2, 2)."""
    J = np.empty((2, 2, 2))
    jacobian(box, J)
    engine.deviation(context[1], J, E)


@njit
def linearise(context: Any, box: Any, f: Any, C: Any) -> bool:
    """Write residuals (2, 2) and inverse (2, 2)."""
    J = np.empty((2, 2, 2))
    jacobian(box, J)
    residual(context, box, f)
    return engine.preconditioner(J, C)


@njit
def apply(context: Any, box: Any, image: Any) -> bool:
    """Apply the operator to a box (2, 2)."""
    return engine.over(residual, deviate, context, context[1], box, image)


@njit
def around(d: Any, C: Any, x: Any, shift: Any, cover: Any, box: Any, domain: Any) -> bool:
    """Prove a zero near x."""
    return engine.around(deviate, (d, C), x, shift, cover, (TRIES, CONTRACTIONS), box, domain)


@njit
def existence(d: Any, C: Any, x: Any, f: Any, refine: bool, box: Any) -> bool:
    """Grow a box around x."""
    return engine.existence(apply, (d, C), C, x, f, 1.0, refine, box)


@njit
def improve(d: Any, x: Any, C: Any, steps: int) -> float:
    """Improve x by Newton steps."""
    return newton(linearise, residual, (d, C), x, C, steps, PACE)


def root_bounds(d: Fraction | float, digits: int = 160) -> tuple[Fraction, Fraction]:
    """Return fractions around sqrt(1 + d)."""
    below = math.isqrt(((1 + Fraction(d)) * 4**digits).__floor__())
    return Fraction(below, 2**digits), Fraction(below + 1, 2**digits)


def parts(x: Any, d: Any) -> tuple[Any, Any]:
    """Return the preconditioner and the residuals at a point."""
    C, f = np.empty((2, 2)), np.empty((2, 2))
    assert linearise((d, C), np.column_stack([x, x]), f, C)
    return C, f


def holds(box: Any, d: float, sign: int = 1) -> bool:
    """Return True when a box holds the zero (s, s), s near sign sqrt(1 + d), for one d."""
    low, high = root_bounds(d)
    low, high = (low, high) if sign > 0 else (-high, -low)
    return all(Fraction(lo) <= low and high <= Fraction(hi) for lo, hi in box)


@pytest.mark.parametrize("width", [0.0, 1e-12, 1e-6, 1e-3, 0.05])
def test_both_ways_enclose_the_zeros_of_all_data(width: float) -> None:
    rng = random.Random(7)
    for _ in range(50):
        middle = rng.uniform(-0.5, 3.0)
        d = np.array([middle - width, middle + width])
        sign = rng.choice([-1, 1])
        x = np.full(2, sign * math.sqrt(1.0 + middle)) + np.array([rng.uniform(-1, 1) for _ in "xy"]) * 1e-7
        C, f = parts(x, d)
        shift = np.empty((2, 2))
        called.correction(C, f, shift)
        box, domain = np.empty((2, 2)), np.empty((2, 2))
        cover = np.column_stack([x - 1e-3, x + 1e-3])
        assert around(d, C, x, shift, cover, box, domain)
        assert np.all(domain[:, 0] <= cover[:, 0]) and np.all(cover[:, 1] <= domain[:, 1])
        grown = np.empty((2, 2))
        assert existence(d, C, x, f, width > 0.0, grown)
        for some in (*d, middle, *(rng.uniform(*d) for _ in range(5))):
            assert holds(box, some, sign) and holds(domain, some, sign) and holds(grown, some, sign)
            assert not holds(domain, some, -sign) and not holds(grown, some, -sign)
        # As narrow as the zeros lie apart, but for a share that grows with the range.
        apart = math.sqrt(1.0 + d[1]) - math.sqrt(1.0 + d[0])
        for found in (box, grown):
            assert np.ptp(found, axis=1).max() <= apart * (1.2 + 10.0 * width) + 1e-13


def test_nothing_is_proved_without_a_single_zero() -> None:
    """No zero, a double one, two of them in the cover, and numbers that are none."""
    box, domain = np.empty((2, 2)), np.empty((2, 2))
    for d, x, cover in (
        (-2.0, 1.0, ANYWHERE),
        (-1.0, 1e-9, ANYWHERE),
        (0.0, 1.0, np.array([[-1.5, 1.5]] * 2)),
        (math.nan, 1.0, ANYWHERE),
        (math.inf, 1.0, ANYWHERE),
    ):
        data, point = np.array([d, d]), np.full(2, x)
        C, f = parts(point, data)
        shift = np.empty((2, 2))
        called.correction(C, f, shift)
        assert not around(data, C, point, shift, cover, box, domain)
        if cover is ANYWHERE:
            assert not existence(data, C, point, f, True, box)


def test_an_image_holds_every_zero_and_lies_inside_only_around_one() -> None:
    rng = random.Random(8)
    proved = 0
    for _ in range(300):
        d = np.full(2, rng.uniform(-0.5, 2.0))
        zero = math.sqrt(1.0 + d[0])
        radius = 10.0 ** rng.uniform(-9, 0)
        x = zero + radius * np.array([rng.uniform(-1.5, 1.5) for _ in "xy"])
        C, _ = parts(np.full(2, zero), d)
        box, image = np.column_stack([x - radius, x + radius]), np.empty((2, 2))
        inside = apply((d, C), box, image)
        if holds(box, d[0]):
            assert holds(image, d[0])
        elif not any(lo <= zero <= hi for lo, hi in box):
            assert not inside
        if inside:
            proved += 1
            assert holds(image, d[0]) and np.all(box[:, 0] < image[:, 0]) and np.all(image[:, 1] < box[:, 1])
    assert proved > 20


def test_stretched_bounds_the_exact_product() -> None:
    rng = random.Random(24)
    verdicts = []
    for _ in range(300):
        m = rng.randint(2, 11)
        E = np.array([[sorted(rng.uniform(-1, 1) / m for _ in range(2)) for _ in range(m)] for _ in range(m)])
        start = np.array([rng.choice([0.0, 1e-12, 0.1]) * rng.random() for _ in range(m)])
        radius = np.array([rng.uniform(0.3, 1.0) for _ in range(m)])
        image = np.empty(m)
        inside = called.stretched(E, radius, start, image)
        for i in range(m):
            exact = Fraction(start[i])
            for j in range(m):
                exact += max(abs(Fraction(x)) for x in E[i, j]) * Fraction(radius[j])
            assert exact <= image[i] <= float(exact) * (1 + 1e-14) + 1e-300
        assert inside == bool(np.all(image < radius))
        verdicts.append(inside)
    assert 20 < sum(verdicts) < 280


def test_newton_converges_and_says_where_it_does_not() -> None:
    d, C = np.zeros(2), np.empty((2, 2))
    x = np.array([3.0, 0.5])
    assert improve(d, x, C, 30) < 1e-9
    assert np.allclose(x, 1.0, atol=1e-14) and np.allclose(C @ [[2.0, 2.0], [1.0, -1.0]], np.eye(2), atol=0.5)
    assert math.isinf(improve(d, np.zeros(2), C, 30))
    assert not improve(d, np.array([math.nan, 1.0]), C, 30) < 1e-9
    assert improve(np.full(2, -2.0), np.array([0.3, 0.3]), C, 30) > 1e-9
    x = np.array([3.0, 0.5])
    assert 1e-3 < improve(d, x, C, 1) < math.inf


@njit
def tube_deviate(context: Any, box: Any, E: Any) -> None:
    """Enclose I - C F' over z(e) + box for all e in [-1, 1]; the context is (slope of z(e), C (2, 2))."""
    slope, C = context
    whole, J = np.empty((2, 2)), np.empty((2, 2, 2))
    for k in range(2):
        lo, hi = add(1.0, 1.0, -slope, slope)
        whole[k, 0], whole[k, 1] = add(lo, hi, box[k, 0], box[k, 1])
    jacobian(whole, J)
    engine.deviation(C, J, E)


@njit
def tube(slope: float, C: Any, shift: Any, cover: Any, box: Any, domain: Any) -> bool:
    """Prove the offsets from a tube."""
    x = np.zeros(2)
    return engine.around(tube_deviate, (slope, C), x, shift, cover, (TRIES, CONTRACTIONS), box, domain)


def test_a_zero_that_moves_with_a_symbol_is_proved_along_its_tube() -> None:
    """d = width e for e in [-1, 1]: z(e) = 1 + width e / 2 is off by about width^2 / 8 only."""
    for width in (1e-6, 1e-3, 0.05):
        slope = 0.5 * width
        C, _ = parts(np.ones(2), np.zeros(2))
        # F(z(e), e) = (2 (slope e)^2, 0), its square between 0 and slope^2.
        f = np.zeros((2, 2))
        f[0, 1] = scale(2.0, *mul(slope, slope, slope, slope))[1]
        shift, box, domain = np.empty((2, 2)), np.empty((2, 2)), np.empty((2, 2))
        called.correction(C, f, shift)
        assert tube(slope, C, shift, ANYWHERE, box, domain)
        for k in range(-20, 21):
            e = Fraction(k, 20)
            low, high = root_bounds(Fraction(width) * e)
            way = 1 + Fraction(slope) * e
            assert all(Fraction(lo) <= low - way and high - way <= Fraction(hi) for lo, hi in box)
        assert np.ptp(box, axis=1).max() < 0.2 * width**2
