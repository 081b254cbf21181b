"""The path of one cable over its pulley around one anchor position: a point, and bounds over a ball about it.

In the plane of the cable, g = X - A = x u + y k with the swivel axis k and x > 0. From the pulley's centre H
the anchor is at q, rho = |q|; sigma = sqrt(rho^2 - r^2) is the free length, n = (cos psi, sin psi) with psi =
arg q + acos(r / rho) the direction of the tangent point T = H + r n, a = (sin psi, - cos psi) the unit vector
from there to X. With w = k x u and T_u the part of T - A along u,

    grad L = a,   grad psi = kappa n,   Hess L = kappa n n^T + (1 - T_u / x) / sigma w w^T,
    dT/dX = (T_u / x) w w^T + (h beta f - r kappa a) n^T,   grad sigma = a + (r kappa - h (a . f) beta) n.

One joint: H = A + h u, kappa = 1 / sigma, beta = 0, and L = fixed - r psi + sigma; 0 <= T_u since r <= h.

Two joints: H = h f', f' = (sin delta, - cos delta) along the sum of a and c, c the unit vector along the leg
that arrives, f = (cos delta, sin delta). With sigma' the length of that leg, W the wrap and m = sin(W / 2),

    beta = 1 / (sigma (2 + h m (1 / sigma + 1 / sigma'))),   kappa = 1 / sigma - h m beta / sigma,

so that 0 <= 1 / sigma - kappa <= h / (2 sigma^2) and beta <= 1 / (2 sigma). W changes by at most (1 + h / (2
sigma')) / sigma for one unit of X. Where X is 2 (h + r) or farther from A, and C 3 (h + r), delta -> the
direction of a + c is a contraction by (h / sigma + h / sigma') / 2 <= 3/4: there is one delta, and an arm in
balance if W > 0, without another one.

A rope that does not touch runs straight from C: one joint, where psi is above theta_K; two, where W < 0,
which is where the line from C to X passes A at less than h - r. Of the line the part from where the rope
would meet the pulley at the change, a length ``before`` from C, counts as free: T, with it sigma and the
direction, is continuous, and stays within h + r of A. (Where X is nearer to C than that, next to the pulley
then, T is a thousandth of s before X; there no cable counts as smooth.) With s = |X - C|

    Hess L = (I - a a^T) / s,   dT/dX = before (I - a a^T) / s,   grad sigma = a.

Rounding: the point is evaluated in floats. Errors of the data and of g are, to first order and with a wide
margin, a change of X: L has slope one, T a slope of at most max(sway / sigma, (h + r) / x), sway = r with one
joint, r + h / 2 with two. What is rounded after that is off by a few units of ``SIZE``, by rho / sigma times
as many where the anchor is near the pulley; and of two joints by what is left of the balance: an angle off
by e is delta off by at most 4 e, which moves T by h (1 + r / sigma) as much.

Arrays: ``real`` is a ``RealModel``, ``rows`` (N, ROW) what it has of that name; ``seen`` (N, SEEN) the
cables seen from X, columns as in ``real.columns``.
"""

from __future__ import annotations

import math
from typing import Any

from cdpr_interval.kernels.kernel import kernel
from solvers.six_dof.real.columns import (
    ACROSS,
    ALONG,
    ARM,
    ASIDE,
    AWAY,
    AXIS,
    BEFORE,
    BOTH,
    DRIFT,
    EXIT,
    FOOT,
    FREE,
    HEIGHT,
    JOINTS,
    LEAD,
    LEAN,
    LEAST_FREE,
    LEAST_SIDE,
    LIFT_ABOVE,
    LIFT_OFF,
    LOOSE,
    OFF_LENGTH,
    OFF_POINT,
    OUT,
    PAST,
    PATH,
    PRESSED,
    RADIUS,
    REACH,
    RHO,
    SHIFT,
    SIDE,
    SIZE,
    STATE,
    STRAIGHT,
    SWAY,
    TURN,
    WRAP,
)

ROUNDING = 2e-14
"""Error of a length over the sum of the sizes of its terms: some ninety units, of about thirty needed."""
MARGIN = 1.0 + 1e-12
"""What bounds that were computed in floats are multiplied by."""
LOWEST_WRAP = 0.75 * math.pi
"""Less psi than minus this counts as more than pi: no rope leaves there."""
HIGHEST_WRAP = 1.25 * math.pi
"""Of a rope that runs past its pulley on one joint psi is below this, where the model cuts angles."""
LEAST_HUNG = -1.5
"""Wrap on two joints, rad: between the least and, less a turn, the greatest, of ends far from A."""
ROOM, LEAD_ROOM = 2.0, 3.0
"""Least distances of X and C from A, over h + r, at which two joints have one balance."""
BALANCED = 1e-12
"""Most by which the angle of a + c may be off."""
HANGINGS = 12
"""Most steps to the balance of an arm; four are usual."""
LEAST_SHARE = 1e-3
"""Least sigma and x over ``SIZE`` at which a cable is looked at: rounding is divided by them."""


@kernel(inline="always")
def see(real: Any, i: int, x0: float, x1: float, x2: float, seen: Any) -> None:
    """Write what is seen of cable ``i`` from X; NaN where the anchor is inside the pulley."""
    see_simple(real, i, x0, x1, x2, seen)
    # By its row: to hand over the model costs more than to see a simple cable.
    if not real.simple[i]:
        see_more(real.rows, i, x0, x1, x2, seen)


@kernel(inline="always")
def see_simple(real: Any, i: int, x0: float, x1: float, x2: float, seen: Any) -> None:
    """As `see`, of a cable that is straight or touches its pulley on one joint, wherever it is."""
    r, h = real.radius[i], real.arm[i]
    g0, g1, g2 = x0 - real.exits[i, 0], x1 - real.exits[i, 1], x2 - real.exits[i, 2]
    away = math.sqrt(g0 * g0 + g1 * g1 + g2 * g2)
    size = away + h + r + real.fixed[i] + abs(x0) + abs(x1) + abs(x2)
    # The arm: X is the sum of the platform's position and a turned arm, either far from where both end.
    size += abs(real.exits[i, 0]) + abs(real.exits[i, 1]) + abs(real.exits[i, 2]) + real.arm_lengths[i]
    seen[i, AWAY], seen[i, SIZE] = away, size
    if r == 0.0:
        seen[i, PATH], seen[i, FREE], seen[i, SIDE], seen[i, RHO] = real.fixed[i] + away, away, away, away
        seen[i, HEIGHT], seen[i, WRAP], seen[i, STATE] = 0.0, 0.0, STRAIGHT
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
    seen[i, HEIGHT], seen[i, RHO], seen[i, WRAP], seen[i, STATE] = y, rho, psi, PRESSED
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
def see_more(rows: Any, i: int, x0: float, x1: float, x2: float, seen: Any) -> None:
    """As `see`, of any cable over a pulley of which ``see_simple`` has told what it would on one joint."""
    if rows[i, JOINTS] == 2.0:
        see_hung(rows, i, x0, x1, x2, seen)
    if seen[i, WRAP] > rows[i, LIFT_ABOVE] or (rows[i, JOINTS] == 2.0 and seen[i, WRAP] < 0.0):
        see_past(rows, i, x0, x1, x2, seen)


@kernel()
def see_hung(rows: Any, i: int, x0: float, x1: float, x2: float, seen: Any) -> None:
    """Write what is seen of a cable on two joints from X; needs what one joint at the same A says."""
    r, h, x, y = rows[i, RADIUS], rows[i, ARM], seen[i, SIDE], seen[i, HEIGHT]
    pu, pk, nu, nk, left = hang(r, h, rows[i, LEAD], x, y, i, seen)
    sigma, lean, f, fk = seen[i, FREE], h * seen[i, LEAN], h * pu + r * nu, h * pk + r * nk
    seen[i, OUT] = f
    for k in range(3):
        axis = rows[i, AXIS + k]
        u = ((x0 if k == 0 else (x1 if k == 1 else x2)) - rows[i, EXIT + k] - y * axis) / x
        seen[i, FOOT + k] = rows[i, EXIT + k] + f * u + fk * axis
        seen[i, ALONG + k] = nk * u - nu * axis
        seen[i, ACROSS + k] = nu * u + nk * axis
        seen[i, LEAN + k] = lean * (pu * axis - pk * u)
    size, turned = seen[i, SIZE], rows[i, SHIFT + 1]
    moved = ROUNDING * size + rows[i, SHIFT] + turned * seen[i, AWAY]
    rounded = ROUNDING * size * (1.0 + seen[i, RHO] / sigma) + left
    seen[i, OFF_LENGTH] = moved + rounded
    seen[i, OFF_POINT] = moved * (1.0 + max(rows[i, SWAY] / sigma, (h + r) / x)) + rounded + turned * (h + r)


@kernel()
def hang(
    r: float, h: float, lead: float, x: float, y: float, i: int, seen: Any
) -> tuple[float, float, float, float, float]:
    """Return the arm f' on two joints, n in the plane of the cable, and by how much T may be off.

    Writes PATH, FREE, RHO, WRAP, here the wrap itself, and TURN; beta to LEAN. NaN where no balance is found.
    """
    away = math.sqrt(x * x + y * y)
    # f' from the bisector of the angle at A on, y - away without its cancellation.
    pu, pk = x, (y - away if y < 0.0 else -x * x / (away + y))
    size = math.sqrt(pu * pu + pk * pk)
    pu, pk = pu / size, pk / size
    rest, sigma, before, rho = math.nan, math.nan, math.nan, math.nan
    nu, nk, mu, mk = 0.0, 0.0, 0.0, 0.0
    for turn in range(HANGINGS):
        qu, qk = x - h * pu, y - h * pk
        square = qu * qu + qk * qk
        rho = math.sqrt(square)
        sigma = math.sqrt((rho - r) * (rho + r)) if rho > r else math.nan
        nu, nk = (r * qu - sigma * qk) / square, (r * qk + sigma * qu) / square
        qu, qk = -h * pu, -lead - h * pk
        square = qu * qu + qk * qk
        before = math.sqrt(square - r * r) if square > r * r else math.nan
        mu, mk = (r * qu + before * qk) / square, (r * qk - before * qu) / square
        # The direction of a + c, by the sum of vectors that does not vanish.
        tu, tk = -nu - mu, -nk - mk
        if nu * mu + nk * mk < 0.0:
            tu, tk = nk - mk, mu - nu
        along, over = tu * pu + tk * pk, tk * pu - tu * pk
        rest = over / along if along > 0.0 else math.nan
        if not abs(rest) > 2e-16 or turn == HANGINGS - 1:
            break
        # Newton's step for delta less the angle of a + c.
        slope = 0.5 * h * ((nu * pk - nk * pu) / sigma - (mu * pk - mk * pu) / before)
        step = rest / (1.0 - slope)
        pu, pk = pu - step * pk, pk + step * pu
        size = math.sqrt(pu * pu + pk * pk)
        pu, pk = pu / size, pk / size
    wrap = math.atan2(nu * mk - nk * mu, nu * mu + nk * mk)
    if not abs(rest) < BALANCED:
        wrap = math.nan
    if wrap < LEAST_HUNG:
        wrap += 2.0 * math.pi
    m = math.sin(0.5 * wrap)
    beta = 1.0 / (sigma * (2.0 + h * m * (1.0 / sigma + 1.0 / before)))
    seen[i, PATH], seen[i, FREE], seen[i, RHO], seen[i, WRAP] = before + r * wrap + sigma, sigma, rho, wrap
    seen[i, LEAN], seen[i, TURN] = beta, (1.0 - h * m * beta) / sigma
    return pu, pk, nu, nk, 4.0 * h * (abs(rest) + ROUNDING) * (1.0 + r / sigma)


@kernel()
def see_past(rows: Any, i: int, x0: float, x1: float, x2: float, seen: Any) -> None:
    """Write what is seen of a cable that runs straight from C to X; needs AWAY and SIZE."""
    lead, before = rows[i, LEAD], rows[i, BEFORE]
    g0 = x0 - rows[i, EXIT] + lead * rows[i, AXIS]
    g1 = x1 - rows[i, EXIT + 1] + lead * rows[i, AXIS + 1]
    g2 = x2 - rows[i, EXIT + 2] + lead * rows[i, AXIS + 2]
    whole = math.sqrt(g0 * g0 + g1 * g1 + g2 * g2)
    seen[i, PATH], seen[i, FREE], seen[i, STATE] = whole, whole - before, PAST
    for k in range(3):
        a = (g0 if k == 0 else (g1 if k == 1 else g2)) / whole
        seen[i, ALONG + k] = a
        seen[i, FOOT + k] = rows[i, EXIT + k] - lead * rows[i, AXIS + k] + before * a
    moved = ROUNDING * seen[i, SIZE] + rows[i, SHIFT] + rows[i, SHIFT + 1] * (seen[i, AWAY] + lead)
    seen[i, OFF_LENGTH] = 2.0 * moved
    seen[i, OFF_POINT] = moved * (2.0 + before / whole)


@kernel(inline="always")
def around(real: Any, i: int, reach: float, seen: Any) -> bool:
    """Bound cable ``i`` over all X within ``reach`` of where it is seen from; False: it is not smooth.

    Writes REACH .. DRIFT, and BOTH to STATE where the rope may touch its pulley and run past it within
    ``reach``. Guarantee: |L(X) - (|X - T0| + L0 - sigma0)| <= LOOSE for the exact path length L, T0 the point
    T as it stands in ``seen`` and L0, sigma0 likewise, |T(X) - T0| <= DRIFT, sigma(X) >= LEAST_FREE, x(X) >=
    LEAST_SIDE, or the cable does not depend on x. Proof of the first: both sides have value and gradient in
    common at X0; the Hessians, which exist but where the rope lifts off, differ by at most max(h / (2
    sigma^2) with two joints, (h + r) / (sigma x)) on the pulley and before / (sigma s) past it, and 2 tau /
    (sigma (sigma - tau)), tau the change of T.

    Near the swivel axis T turns about it, within 2 (h + r), while L goes on: it depends on (x, y) alone, has
    slope one, and with one joint bends downward on the axis, where sin psi = -(h + r cos psi) / sigma <= 0.
    """
    is_simple = real.simple[i]
    return around_simple(real, i, reach, seen) if is_simple else around_any(real.rows, i, reach, seen)


@kernel(inline="always")
def around_simple(real: Any, i: int, reach: float, seen: Any) -> bool:
    """As `around`, of a cable that is straight or touches its pulley on one joint, wherever it is."""
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
    # No way around the pulley's centre: psi stays on its branch, whose cut is where no rope leaves.
    turn = reach / sigma + 1e-9
    if not (-LOWEST_WRAP + turn < seen[i, WRAP] < real.lift_off[i] - turn):
        return False
    if seen[i, SIDE] - h <= 0.0 and not abs(seen[i, HEIGHT]) > reach + off:
        return False
    is_off_axis = side > LEAST_SHARE * size
    slope = max(r / sigma, (h + r) / side) if is_off_axis else math.inf
    return loosened(i, reach, slope, (h + r) / (sigma * side), h + r, off, seen)


@kernel()
def loosened(i: int, reach: float, slope: float, bend: float, radius: float, off: float, seen: Any) -> bool:
    """Write LOOSE and DRIFT of a cable; False: T moves too far.

    T moves by at most ``slope`` (infinite: unknown) for one unit of X, and stays within ``radius`` of A; the
    Hessian of L is that of the sphere about T but for ``bend``.
    """
    sigma = seen[i, LEAST_FREE]
    farthest = 2.0 * radius + off
    point = min(seen[i, OFF_POINT], farthest)
    drift = (farthest + point) * MARGIN
    if slope < math.inf:
        drift = min(drift, (slope * reach + point) * MARGIN)
    seen[i, DRIFT] = drift
    if not drift < 0.5 * sigma:
        return False
    # By the gradients, a and the direction from T0: they differ by at most 2 tau / (2 sigma - tau).
    loose = reach * 2.0 * drift / (2.0 * sigma - drift)
    if slope < math.inf:
        bend += 2.0 * drift / (sigma * (sigma - drift))
        loose = min(loose, 0.5 * bend * reach * reach + 2.0 * point * reach / sigma)
    seen[i, LOOSE] = (loose + seen[i, OFF_LENGTH] + 2.0 * point) * MARGIN
    return True


@kernel()
def around_any(rows: Any, i: int, reach: float, seen: Any) -> bool:
    """As `around`, of any cable over a pulley."""
    r, h, size, wrap = rows[i, RADIUS], rows[i, ARM], seen[i, SIZE], seen[i, WRAP]
    seen[i, REACH] = reach
    off = ROUNDING * size + rows[i, SHIFT] + rows[i, SHIFT + 1] * (seen[i, AWAY] + rows[i, LEAD])
    if rows[i, JOINTS] == 2.0:
        sigma, turn = hung(r, h, rows[i, LEAD], reach, off, i, seen)
        if not wrap > LEAST_HUNG:
            return False
        if not wrap > turn:
            is_past = seen[i, STATE] == PAST and is_beside(r, h, rows[i, LEAD], reach, off, i, seen)
            seen[i, STATE] = PAST if is_past else BOTH
    else:
        rho = (seen[i, RHO] - reach) * (1.0 - 1e-12) - off
        if not rho > r:
            return False
        sigma = math.sqrt((rho - r) * (rho + r)) * (1.0 - 1e-12)
        turn = reach / sigma + 1e-9
        if not -LOWEST_WRAP + turn < wrap < HIGHEST_WRAP - turn:
            return False
        if seen[i, SIDE] - h <= 0.0 and not abs(seen[i, HEIGHT]) > reach + off:
            return False
        if not wrap < rows[i, LIFT_OFF] - turn:
            seen[i, STATE] = PAST if wrap > rows[i, LIFT_ABOVE] + turn else BOTH
    side = (seen[i, SIDE] - reach) * (1.0 - 1e-12) - off
    if not (sigma > LEAST_SHARE * size and seen[i, SIDE] > 0.0):
        return False
    slope, bend = math.inf, math.inf
    if side > LEAST_SHARE * size:
        slope, bend = max(rows[i, SWAY] / sigma, (h + r) / side), (h + r) / (sigma * side)
        bend = max(bend, (rows[i, SWAY] - r) / (sigma * sigma))
    if seen[i, STATE] != PRESSED:
        whole = least_whole(rows[i, LEAD], reach, off, i, seen)
        free = whole - rows[i, BEFORE] * (1.0 + 1e-12)
        if seen[i, STATE] == PAST:
            sigma, side, slope, bend = free, free, 0.0, 0.0
        sigma = min(sigma, free)
        if not sigma > LEAST_SHARE * size:
            return False
        slope, bend = max(slope, rows[i, BEFORE] / whole), max(bend, rows[i, BEFORE] / (whole * sigma))
    seen[i, LEAST_FREE], seen[i, LEAST_SIDE] = sigma, side
    return loosened(i, reach, slope, bend, h + r, off, seen)


@kernel()
def hung(r: float, h: float, lead: float, reach: float, off: float, i: int, seen: Any) -> tuple[float, float]:
    """Return the least sigma of a rope on a pulley on two joints, and what its wrap changes by at most.

    NaN where the arm need not have one balance all over the ball. H stays within h of A, and moves by at most
    h / (2 sigma) for one unit of X. The ball has no hole: a wrap above zero at its middle, and by its slope
    all along the way from there, keeps the arm in balance by continuity.
    """
    away, near = (seen[i, AWAY] - reach) * (1.0 - 1e-12) - off, (h + r) * (1.0 + 1e-12)
    if not (away > ROOM * near and lead > LEAD_ROOM * near):
        return math.nan, math.inf
    rho = (away - h) * (1.0 - 1e-12)
    if seen[i, STATE] == PRESSED:
        moved = reach * (1.0 + 0.5 * h / math.sqrt((rho - r) * (rho + r)))
        rho = max(rho, (seen[i, RHO] - moved) * (1.0 - 1e-12) - 2.0 * (off + seen[i, OFF_POINT]))
    sigma = math.sqrt((rho - r) * (rho + r)) * (1.0 - 1e-12)
    before = math.sqrt((lead - h) ** 2 - r * r) * (1.0 - 1e-12)
    return sigma, reach / sigma * (1.0 + 0.5 * h / before) + 1e-9


@kernel()
def is_beside(r: float, h: float, lead: float, reach: float, off: float, i: int, seen: Any) -> bool:
    """Return True where the line from C to all X of a ball, beyond A, passes A at less than h - r."""
    room = (h - r) - 1e-15 * h
    far = lead * (seen[i, SIDE] + reach + off) * (1.0 + 1e-12)
    is_beyond = seen[i, HEIGHT] > reach + off
    return bool(is_beyond and far < room * least_whole(lead, reach, off, i, seen))


@kernel()
def least_whole(lead: float, reach: float, off: float, i: int, seen: Any) -> float:
    """Return the least distance from C within ``reach``."""
    rise = seen[i, HEIGHT] + lead
    whole = math.sqrt(seen[i, SIDE] * seen[i, SIDE] + rise * rise)
    return float((whole - reach) * (1.0 - 1e-12) - off)
