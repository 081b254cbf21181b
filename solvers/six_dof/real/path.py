"""The path of one cable over its pulley around one anchor position: a point, and bounds over a ball about it.

In the plane of the cable, g = X - A = x u + y k with the swivel axis k and x > 0. From the pulley's centre
A + h u the anchor is at q = (x - h, y), rho = |q|; sigma = sqrt(rho^2 - r^2) is the free length, n = (cos
psi, sin psi) with psi = arg q + acos(r / rho) the direction of the tangent point T = A + h u + r n, a = (sin
psi, - cos psi) the unit vector from there to X and L = fixed - r psi + sigma the length of the path. With w =
k x u and c = (h + r cos psi) / x, where 0 <= c because r <= h,

    grad L = a,   grad psi = n / sigma,   grad sigma = a + (r / sigma) n,   dT/dX = c w w^T - (r / sigma) a
    n^T, Hess L = n n^T / sigma + (1 - c) / sigma w w^T.

Rounding: the point is evaluated in floats. Errors of the data and of g are, to first order and with a wide
margin, a change of X: L has slope one, T a slope of at most max(r / sigma, (h + r) / x). What is rounded
after that is off by a few units of ``SIZE``, by rho / sigma times as many where the anchor is near the
pulley.

Arrays: ``real`` is a ``RealModel``; ``seen`` (N, SEEN) the cables seen from X, columns as in
``real.columns``.
"""

from __future__ import annotations

import math
from typing import Any

from cdpr_interval.kernels.kernel import kernel
from solvers.six_dof.real.columns import (
    ACROSS,
    ALONG,
    ASIDE,
    AWAY,
    DRIFT,
    FOOT,
    FREE,
    HEIGHT,
    LEAST_FREE,
    LEAST_SIDE,
    LOOSE,
    OFF_LENGTH,
    OFF_POINT,
    PATH,
    REACH,
    RHO,
    SIDE,
    SIZE,
    WRAP,
)

ROUNDING = 2e-14
"""Error of a length over the sum of the sizes of its terms: some ninety units, of about thirty needed."""
MARGIN = 1.0 + 1e-12
"""What bounds that were computed in floats are multiplied by."""
LOWEST_WRAP = 0.75 * math.pi
"""Less psi than minus this counts as more than pi: no rope leaves there."""
LEAST_SHARE = 1e-3
"""Least sigma and x over ``SIZE`` at which a cable is looked at: rounding is divided by them."""


@kernel()
def see(real: Any, i: int, x0: float, x1: float, x2: float, seen: Any) -> None:
    """Write what is seen of cable ``i`` from X; NaN where the anchor is inside the pulley."""
    r, h = real.radius[i], real.arm[i]
    g0, g1, g2 = x0 - real.exits[i, 0], x1 - real.exits[i, 1], x2 - real.exits[i, 2]
    away = math.sqrt(g0 * g0 + g1 * g1 + g2 * g2)
    size = away + h + r + real.fixed[i] + abs(x0) + abs(x1) + abs(x2)
    # The arm: X is the sum of the platform's position and a turned arm, either far from where both end.
    size += abs(real.exits[i, 0]) + abs(real.exits[i, 1]) + abs(real.exits[i, 2]) + real.arm_lengths[i]
    seen[i, AWAY], seen[i, SIZE] = away, size
    if r == 0.0:
        seen[i, PATH], seen[i, FREE], seen[i, SIDE], seen[i, RHO] = real.fixed[i] + away, away, away, away
        seen[i, HEIGHT], seen[i, WRAP] = 0.0, 0.0
        for k in range(3):
            seen[i, FOOT + k] = real.exits[i, k]
            seen[i, ACROSS + k], seen[i, ASIDE + k] = 0.0, 0.0
        seen[i, ALONG], seen[i, ALONG + 1], seen[i, ALONG + 2] = g0 / away, g1 / away, g2 / away
        seen[i, OFF_LENGTH] = ROUNDING * size + real.shift[i, 0]
        seen[i, OFF_POINT] = ROUNDING * size + real.shift[i, 0]
        return
    k0, k1, k2 = real.axes[i, 0], real.axes[i, 1], real.axes[i, 2]
    y = g0 * k0 + g1 * k1 + g2 * k2
    u0, u1, u2 = g0 - y * k0, g1 - y * k1, g2 - y * k2
    x = math.sqrt(u0 * u0 + u1 * u1 + u2 * u2)
    u0, u1, u2 = u0 / x, u1 / x, u2 / x
    q = x - h
    rho = math.sqrt(q * q + y * y)
    sigma = math.sqrt((rho - r) * (rho + r)) if rho > r else math.nan
    nu, nk = (r * q - sigma * y) / (rho * rho), (r * y + sigma * q) / (rho * rho)
    psi = math.atan2(y, q) + math.atan2(sigma, r)
    seen[i, PATH], seen[i, FREE], seen[i, SIDE] = real.fixed[i] - r * psi + sigma, sigma, x
    seen[i, HEIGHT], seen[i, RHO], seen[i, WRAP] = y, rho, psi
    f = h + r * nu
    seen[i, FOOT] = real.exits[i, 0] + f * u0 + r * nk * k0
    seen[i, FOOT + 1] = real.exits[i, 1] + f * u1 + r * nk * k1
    seen[i, FOOT + 2] = real.exits[i, 2] + f * u2 + r * nk * k2
    seen[i, ALONG] = nk * u0 - nu * k0
    seen[i, ALONG + 1] = nk * u1 - nu * k1
    seen[i, ALONG + 2] = nk * u2 - nu * k2
    seen[i, ACROSS] = nu * u0 + nk * k0
    seen[i, ACROSS + 1] = nu * u1 + nk * k1
    seen[i, ACROSS + 2] = nu * u2 + nk * k2
    seen[i, ASIDE] = k1 * u2 - k2 * u1
    seen[i, ASIDE + 1] = k2 * u0 - k0 * u2
    seen[i, ASIDE + 2] = k0 * u1 - k1 * u0
    turned = real.shift[i, 1]
    moved = ROUNDING * size + real.shift[i, 0] + turned * away
    rounded = ROUNDING * size * (1.0 + rho / sigma)
    seen[i, OFF_LENGTH] = moved + rounded
    seen[i, OFF_POINT] = moved * (1.0 + max(r / sigma, (h + r) / x)) + rounded + turned * (h + r)


@kernel()
def around(real: Any, i: int, reach: float, seen: Any) -> bool:
    """Bound cable ``i`` over all X within ``reach`` of where it is seen from; False: it is not smooth.

    Writes REACH .. DRIFT. Guarantee: |L(X) - (|X - T0| + L0 - sigma0)| <= LOOSE for the exact path length L,
    T0 the tangent point as it stands in ``seen`` and L0, sigma0 likewise, |T(X) - T0| <= DRIFT, sigma(X) >=
    LEAST_FREE, x(X) >= LEAST_SIDE. Proof of the first: both sides have value and gradient in common at X0;
    the Hessians differ by at most (h + r) / (sigma x) + 2 tau / (sigma (sigma - tau)), tau the change of T.

    Near the swivel axis T turns about it, within 2 (h + r), while L goes on: it depends on (x, y) alone, has
    slope one, and bends downward on the axis, where sin psi = -(h + r cos psi) / sigma <= 0.
    """
    r, h, size = real.radius[i], real.arm[i], seen[i, SIZE]
    seen[i, REACH] = reach
    off = ROUNDING * size + real.shift[i, 0] + real.shift[i, 1] * seen[i, AWAY]
    rho = (seen[i, RHO] - reach) * (1.0 - 1e-12) - off
    if r == 0.0:
        seen[i, LEAST_FREE], seen[i, LEAST_SIDE] = rho, rho
        seen[i, LOOSE], seen[i, DRIFT] = seen[i, OFF_LENGTH] * 2.0, seen[i, OFF_POINT]
        return bool(rho > LEAST_SHARE * size)
    if not rho > r:
        return False
    sigma = math.sqrt((rho - r) * (rho + r)) * (1.0 - 1e-12)
    side = (seen[i, SIDE] - reach) * (1.0 - 1e-12) - off
    seen[i, LEAST_FREE], seen[i, LEAST_SIDE] = sigma, side
    if not (sigma > LEAST_SHARE * size and seen[i, SIDE] > 0.0):
        return False
    # No way around the pulley's centre: psi stays on its branch, whose cut is where no rope leaves. The rope
    # touches the pulley all over the ball: past theta_K it would run straight from C.
    turn = reach / sigma + 1e-9
    if not (-LOWEST_WRAP + turn < seen[i, WRAP] < real.lift_off[i] - turn):
        return False
    if seen[i, SIDE] - h <= 0.0 and not abs(seen[i, HEIGHT]) > reach + off:
        return False
    farthest = 2.0 * (h + r) + off
    point = min(seen[i, OFF_POINT], farthest)
    drift = (farthest + point) * MARGIN
    is_off_axis = side > LEAST_SHARE * size
    if is_off_axis:
        drift = min(drift, (max(r / sigma, (h + r) / side) * reach + point) * MARGIN)
    seen[i, DRIFT] = drift
    if not drift < 0.5 * sigma:
        return False
    # By the gradients, a and the direction from T0: they differ by at most 2 tau / (2 sigma - tau).
    loose = reach * 2.0 * drift / (2.0 * sigma - drift)
    if is_off_axis:
        bend = (h + r) / (sigma * side) + 2.0 * drift / (sigma * (sigma - drift))
        loose = min(loose, 0.5 * bend * reach * reach + 2.0 * point * reach / sigma)
    seen[i, LOOSE] = (loose + seen[i, OFF_LENGTH] + 2.0 * point) * MARGIN
    return True
