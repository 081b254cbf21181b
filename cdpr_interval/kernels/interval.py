"""Interval arithmetic on scalar bounds ``lo, hi``: every function returns bounds that enclose.

An interval is a pair of doubles with lo <= hi; bounds may be infinite. Guarantee of every
function: the result encloses the exact image of all real numbers in the arguments.
Products of 0 and an infinite bound count as 0 (an infinite bound stands for arbitrarily large
real numbers, never for infinity itself).
"""

from __future__ import annotations

import math

from cdpr_interval.kernels.kernel import entry
from cdpr_interval.kernels.rounding import down, up


@entry()
def add(alo: float, ahi: float, blo: float, bhi: float) -> tuple[float, float]:
    """Enclose a + b."""
    return down(alo + blo), up(ahi + bhi)


@entry()
def sub(alo: float, ahi: float, blo: float, bhi: float) -> tuple[float, float]:
    """Enclose a - b."""
    return down(alo - bhi), up(ahi - blo)


@entry()
def product(a: float, b: float) -> float:
    """Return a b rounded to nearest, with 0 times infinity = 0."""
    if a == 0.0 or b == 0.0:
        return 0.0
    return a * b


@entry()
def mul(alo: float, ahi: float, blo: float, bhi: float) -> tuple[float, float]:
    """Enclose a b."""
    p1 = product(alo, blo)
    p2 = product(alo, bhi)
    p3 = product(ahi, blo)
    p4 = product(ahi, bhi)
    return down(min(min(p1, p2), min(p3, p4))), up(max(max(p1, p2), max(p3, p4)))


@entry()
def scale(c: float, alo: float, ahi: float) -> tuple[float, float]:
    """Enclose c a for a finite double c."""
    p = product(c, alo)
    q = product(c, ahi)
    return down(min(p, q)), up(max(p, q))


@entry()
def div(alo: float, ahi: float, blo: float, bhi: float) -> tuple[float, float]:
    """Enclose a / b; the whole line where b touches zero."""
    if blo <= 0.0 <= bhi:
        return -math.inf, math.inf
    q1 = quotient(alo, blo)
    q2 = quotient(alo, bhi)
    q3 = quotient(ahi, blo)
    q4 = quotient(ahi, bhi)
    return down(min(min(q1, q2), min(q3, q4))), up(max(max(q1, q2), max(q3, q4)))


@entry()
def quotient(a: float, b: float) -> float:
    """Return a / b rounded to nearest for b != 0; infinity over infinity counts as 0.

    The bounds 0 .. (another corner) enclose such quotients because the other corner with the
    same infinite numerator and the finite denominator bound is infinite.
    """
    if a == 0.0 or math.isinf(b):
        return 0.0
    return a / b


@entry()
def sqr(alo: float, ahi: float) -> tuple[float, float]:
    """Enclose a^2."""
    if alo >= 0.0:
        return max(0.0, down(alo * alo)), up(ahi * ahi)
    if ahi <= 0.0:
        return max(0.0, down(ahi * ahi)), up(alo * alo)
    m = max(-alo, ahi)
    return 0.0, up(m * m)


@entry()
def sqrt(alo: float, ahi: float) -> tuple[float, float]:
    """Enclose the square roots of the non-negative part of a; (inf, -inf) where there is none."""
    if ahi < 0.0:
        return math.inf, -math.inf
    lo = 0.0
    if alo > 0.0:
        lo = max(0.0, down(math.sqrt(alo)))
    return lo, up(math.sqrt(ahi))


HALF_PI_LO, HALF_PI_HI = 1.5707963267948966, 1.5707963267948968
"""The doubles on both sides of pi / 2."""
HALVINGS = 2
"""Times that an angle below pi / 4 is halved before its series is summed: then its tangent is below 0.2."""
TERMS = 13
"""Of the series: 0.2^27 / 27 is below 1e-20."""


@entry()
def series_of_atan(lo: float, hi: float) -> tuple[float, float]:
    """Enclose atan over [lo, hi] within [0, 0.2] by its alternating series."""
    slo, shi = sqr(lo, hi)
    lo_sum, hi_sum = 0.0, 0.0
    for i in range(TERMS - 1, -1, -1):
        odd = 2.0 * i + 1.0
        lo_sum, hi_sum = mul(slo, shi, lo_sum, hi_sum)
        lo_sum, hi_sum = sub(1.0 / odd - 1e-16, 1.0 / odd + 1e-16, lo_sum, hi_sum)
    # The rest of an alternating series with falling terms lies between zero and its first term.
    return mul(lo, hi, down(lo_sum - 1e-18), up(hi_sum + 1e-18))


@entry()
def atan_of_point(t: float) -> tuple[float, float]:
    """Enclose atan(t) for t >= 0, which may be infinite."""
    lo, hi = t, t
    turned = t > 1.0
    if turned:
        lo, hi = div(1.0, 1.0, t, t)
    for _ in range(HALVINGS):
        # tan(x / 2) = t / (1 + sqrt(1 + t^2)).
        slo, shi = sqr(lo, hi)
        slo, shi = add(1.0, 1.0, slo, shi)
        slo, shi = sqrt(slo, shi)
        slo, shi = add(1.0, 1.0, slo, shi)
        lo, hi = div(lo, hi, slo, shi)
    lo, hi = series_of_atan(lo, hi)
    lo, hi = 4.0 * lo, 4.0 * hi
    if turned:
        lo, hi = sub(HALF_PI_LO, HALF_PI_HI, lo, hi)
    return lo, hi


@entry()
def atan(alo: float, ahi: float) -> tuple[float, float]:
    """Enclose the arc tangents of a in rad; bounds may be infinite."""
    lo = atan_of_point(alo)[0] if alo >= 0.0 else -atan_of_point(-alo)[1]
    hi = atan_of_point(ahi)[1] if ahi >= 0.0 else -atan_of_point(-ahi)[0]
    return lo, hi


@entry()
def mid(alo: float, ahi: float) -> float:
    """Return a finite number inside a (the middle, up to rounding)."""
    if alo == -math.inf:
        if ahi == math.inf:
            return 0.0
        return min(ahi, -1.0) * 2.0 if ahi > -1e300 else ahi
    if ahi == math.inf:
        return max(alo, 1.0) * 2.0 if alo < 1e300 else alo
    m = 0.5 * alo + 0.5 * ahi
    return min(max(m, alo), ahi)


@entry()
def rad(alo: float, ahi: float) -> float:
    """Return an upper bound of the distance from ``mid(a)`` to the points of a."""
    m = mid(alo, ahi)
    return max(up(ahi - m), up(m - alo))


@entry()
def mag(alo: float, ahi: float) -> float:
    """Return max |a|."""
    return max(abs(alo), abs(ahi))


@entry()
def mig(alo: float, ahi: float) -> float:
    """Return min |a|."""
    if alo > 0.0:
        return alo
    if ahi < 0.0:
        return -ahi
    return 0.0
