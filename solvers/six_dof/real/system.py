"""The square system of a taut subset on real cables over a box, and what Newton and Krawczyk need of it.

Unknowns z = (u (3), p (3), t (n)), t_i = tension_i / sigma_i. With e_i = T_i - X_i, X_i = p + r_i, r_i = R(u)
b_i,

    L_i(X_i) - c_i t_i sigma_i - l_i = 0 (n),    sum t_i e_i + f = 0,    sum t_i r_i x e_i = 0,

c_i the stretch by 1 N. Everything of a cable is a function of X_i: it is evaluated at the middle, and bounded
over the ball around that by how fast it changes there (``path``). dT/dX = N changes at most by

    |DN| <= r K + h B + 2 w m / sigma + w / (sigma x) + 3 (h + r) / x^2,  m = max(1 / sigma, 1 / x),

for one unit of X, w = sway, K and B what kappa and beta change by: (1 + r / sigma) / sigma^2 and 0 with one
joint, see ``swings`` for two; past the pulley by 3 ``before`` / s^2. de/dX = N - I. Where a rope may touch
its pulley and run past it the derivatives jump: such a box is not looked at.

Arrays: ``real`` is a ``RealModel``; ``z`` (6 + n, 2) a box, ``f`` (6 + n, 2), ``J`` (6 + n, 6 + n, 2) bounds;
``C`` (6 + n, 6 + n) is about the inverse of J; ``seen`` (N, SEEN) cables as in ``real.path``; ``at`` is a
``Bench``; ``R`` (3, 3, 2) and ``dR`` (3, 3, 3, 2) bound R(u) and its derivatives.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.krawczyk import deviation, existence, over, preconditioner
from cdpr_interval.engine.krawczyk import growth as stretch
from cdpr_interval.engine.newton import Pace, newton
from cdpr_interval.kernels import interval
from cdpr_interval.kernels.box import copy, point
from cdpr_interval.kernels.kernel import entry, kernel, part
from cdpr_interval.mechanics.rotation import HALF_TURNS, rotation_interval
from solvers.six_dof.real.columns import (
    ACROSS,
    ALONG,
    ASIDE,
    BOTH,
    DRIFT,
    FOOT,
    FREE,
    LEAN,
    LEAST_FREE,
    LEAST_SIDE,
    OFF_LENGTH,
    OFF_POINT,
    OUT,
    PAST,
    PATH,
    SEEN,
    SIDE,
    SIZE,
    STATE,
    TURN,
    WRAP,
)
from solvers.six_dof.real.path import LEAST_SHARE, ROUNDING, around, see

PACE = Pace(converged=1e-14, stalled=1e-9, fresh=1e-3, slow=0.1, lost=1e6)
"""Newton's steps; unknowns lie near 1, in units near the platform's own."""
CONVERGED = 1e-9
"""Length of the last step at which its root is one, though the steps ended before they were short enough."""


class Bench(NamedTuple):
    """What the system is evaluated in, and of."""

    real: Any
    """``RealModel``."""
    chart: int
    seen: NDArray[np.float64]
    """(N, SEEN)."""
    scratch: NDArray[np.float64]
    """(34, 3, 2) intervals."""


def new_bench(real: Any, chart: int) -> Bench:
    """Return arrays for a chart of a model."""
    return Bench(real, chart, np.zeros((len(real.exits), SEEN)), np.zeros((34, 3, 2)))


@kernel()
def turning(real: Any, chart: int, z: Any, middle: Any, R: Any, dR: Any) -> float:
    """Enclose R(u) D_c and its derivatives over z, and R at the middle of u; return how far u is from it.

    ``middle`` (3, 3) in floats.
    """
    centre, R0, unused = np.empty((3, 2)), np.empty((3, 3, 2)), np.empty((3, 3, 3, 2))
    total = 0.0
    for k in range(3):
        centre[k, 0] = interval.mid(z[k, 0], z[k, 1])
        centre[k, 1] = centre[k, 0]
        w = max(z[k, 1] - centre[k, 0], centre[k, 0] - z[k, 0])
        total += w * w
    rotation_interval(centre, R0, unused)
    rotation_interval(z, R, dR)
    for i in range(3):
        for j in range(3):
            middle[i, j] = 0.5 * (R0[i, j, 0] + R0[i, j, 1]) * HALF_TURNS[chart, j]
            if HALF_TURNS[chart, j] < 0.0:
                R[i, j, 0], R[i, j, 1] = -R[i, j, 1], -R[i, j, 0]
                for k in range(3):
                    dR[k, i, j, 0], dR[k, i, j, 1] = -dR[k, i, j, 1], -dR[k, i, j, 0]
    return float(math.sqrt(total) * (1.0 + 1e-14))


@kernel()
def times_arm(M: Any, real: Any, i: int, out: Any) -> None:
    """Enclose M b_i in out (3, 2) for M (3, 3, 2)."""
    off = real.shift[i, 0]
    for k in range(3):
        lo, hi = 0.0, 0.0
        for j in range(3):
            a, b = interval.scale(real.arms[i, j], M[k, j, 0], M[k, j, 1])
            lo, hi = interval.add(lo, hi, a, b)
        out[k, 0], out[k, 1] = interval.add(lo, hi, -2.0 * off, 2.0 * off)


@kernel()
def see_over(real: Any, i: int, middle: Any, turned: float, z: Any, seen: Any) -> float:
    """See a cable from the middle of a box and bound it; return the reach, infinite where it is not smooth.

    ``middle`` (3, 3) the rotation there, ``turned`` how far u is from it.
    """
    total = 0.0
    for k in range(3):
        w = 0.5 * (z[3 + k, 1] - z[3 + k, 0])
        total += w * w
    x = np.empty(3)
    for k in range(3):
        x[k] = interval.mid(z[3 + k, 0], z[3 + k, 1])
        for j in range(3):
            x[k] += middle[k, j] * real.arms[i, j]
    see(real, i, x[0], x[1], x[2], seen)
    reach = math.sqrt(total) + 2.0 * turned * real.arm_lengths[i]
    reach = reach * (1.0 + 1e-12) + ROUNDING * seen[i, SIZE]
    if not around(real, i, reach, seen) or seen[i, LEAST_SIDE] <= LEAST_SHARE * seen[i, SIZE]:
        return math.inf
    if seen[i, STATE] == BOTH:
        return math.inf
    return reach


@kernel()
def foot_slopes(real: Any, i: int, reach: float, seen: Any, out: Any) -> None:
    """Enclose dT/dX - I over the ball in out (3, 3, 2)."""
    r, h = real.radius[i], real.arm[i]
    if r == 0.0:
        for j in range(3):
            for k in range(3):
                out[j, k, 0] = -1.0 if j == k else 0.0
                out[j, k, 1] = out[j, k, 0]
        return
    sigma, side = seen[i, LEAST_FREE], seen[i, LEAST_SIDE]
    m = max(1.0 / sigma, 1.0 / side)
    if seen[i, STATE] == PAST:
        whole = seen[i, FREE] + real.before[i]
        q = real.before[i] / whole
        bend = 3.0 * real.before[i] / (sigma + real.before[i]) ** 2
        off = bend * (reach + seen[i, OFF_POINT]) * (1.0 + 1e-12) + ROUNDING * (2.0 + seen[i, SIZE] * m)
        for j in range(3):
            for k in range(3):
                value = -q * seen[i, ALONG + j] * seen[i, ALONG + k]
                value -= 1.0 - q if j == k else 0.0
                out[j, k, 0], out[j, k, 1] = value - off, value + off
        return
    turned, leant, _ = swings(real.joints[i], r, h, real.lead[i], sigma)
    sway, q = real.sway[i], r / seen[i, FREE]
    if real.joints[i] == 2:
        c, q = seen[i, OUT] / seen[i, SIDE], r * seen[i, TURN]
    else:
        c = (h + r * math.cos(seen[i, WRAP])) / seen[i, SIDE]
    bend = r * turned + h * leant + 2.0 * sway * m / sigma
    bend += sway / (sigma * side) + 3.0 * (h + r) / (side * side)
    # The floats at the middle are off by what a change of X by their rounding makes, and some units.
    off = bend * (reach + seen[i, OFF_POINT]) * (1.0 + 1e-12) + ROUNDING * (2.0 + seen[i, SIZE] * m)
    for j in range(3):
        g = -q * seen[i, ALONG + j]
        if real.joints[i] == 2:
            g += seen[i, LEAN + j]
        for k in range(3):
            value = c * seen[i, ASIDE + j] * seen[i, ASIDE + k] + g * seen[i, ACROSS + k]
            value -= 1.0 if j == k else 0.0
            out[j, k, 0], out[j, k, 1] = value - off, value + off


@kernel()
def swings(joints: int, r: float, h: float, lead: float, sigma: float) -> tuple[float, float, float]:
    """Bound what kappa, beta and grad sigma . n of a rope on its pulley change by for one unit of X.

    ``sigma`` is its least.

    Two joints, all of it from ``path``: with S = 1 / sigma, S' = 1 / sigma', P = 2 + h m (S + S') >= 2 and
    beta = S / P <= S / 2, for one unit of X in the plane sigma changes by at most 1 + sway S, the wrap by S
    (1 + h S' / 2), m by half of that, sigma' = sigma'(delta) by at most h S / 2 (1 + r S').
    """
    s = 1.0 / sigma
    if joints == 1:
        along = (1.0 + r * s) * s * s
        return along, 0.0, r * along
    along = (1.0 + (r + 0.5 * h) * s) * s * s
    other = 1.0 / math.sqrt((lead - h) ** 2 - r * r) * (1.0 + 1e-12)
    wound = s * (1.0 + 0.5 * h * other)
    arriving = 0.5 * h * s * (1.0 + r * other) * other * other
    share = h * (0.5 * wound * (s + other) + along + arriving)
    leant = (0.5 * along + 0.25 * s * share) * (1.0 + 1e-12)
    turned = (along + h * (0.25 * wound * s * s + 0.5 * along * s + s * leant)) * (1.0 + 1e-12)
    return turned, leant, r * turned + h * leant + 0.25 * h * s * wound * (1.0 + 1e-12)


@kernel()
def cross(a: Any, b: Any, out: Any) -> None:
    """Enclose a x b in out (3, 2) for a, b (3, 2)."""
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        m0, m1 = interval.mul(a[i, 0], a[i, 1], b[j, 0], b[j, 1])
        v0, v1 = interval.mul(a[j, 0], a[j, 1], b[i, 0], b[i, 1])
        out[k, 0], out[k, 1] = interval.sub(m0, m1, v0, v1)


@kernel()
def put(out: Any, i: int, j: int, t0: float, t1: float, lo: float, hi: float) -> None:
    """Add [t0, t1] [lo, hi] to entry (i, j) of out (m, n, 2)."""
    a, b = interval.mul(t0, t1, lo, hi)
    out[i, j, 0], out[i, j, 1] = interval.add(out[i, j, 0], out[i, j, 1], a, b)


@kernel()
def cable(
    real: Any, i: int, reach: float, R: Any, dR: Any, z: Any, seen: Any, f: Any, J: Any, slopes: bool
) -> None:
    """Add cable i's part of the equations and, if asked, of their derivatives."""
    n = real.n_taut
    t0, t1 = z[6 + i, 0], z[6 + i, 1]
    c0, c1 = real.compliance[i, 0], real.compliance[i, 1]
    arm, e, moment = np.empty((3, 2)), np.empty((3, 2)), np.empty((3, 2))
    times_arm(R, real, i, arm)
    off = seen[i, DRIFT]
    for k in range(3):
        x0, x1 = interval.add(z[3 + k, 0], z[3 + k, 1], arm[k, 0], arm[k, 1])
        e[k, 0], e[k, 1] = interval.sub(seen[i, FOOT + k] - off, seen[i, FOOT + k] + off, x0, x1)
    cross(arm, e, moment)
    # The path length by its value at the middle; it changes by at most the reach.
    far = reach + seen[i, OFF_LENGTH]
    f[i, 0], f[i, 1] = interval.sub(
        seen[i, PATH] - far, seen[i, PATH] + far, real.lengths[i, 0], real.lengths[i, 1]
    )
    s_off = (1.0 + real.sway[i] / seen[i, LEAST_FREE]) * reach * (1.0 + 1e-12) + seen[i, OFF_POINT]
    s0, s1 = interval.add(seen[i, FREE], seen[i, FREE], -s_off, s_off)
    cs0, cs1 = interval.mul(c0, c1, s0, s1)
    a, b = interval.mul(t0, t1, cs0, cs1)
    f[i, 0], f[i, 1] = interval.sub(f[i, 0], f[i, 1], a, b)
    for k in range(3):
        a, b = interval.mul(t0, t1, e[k, 0], e[k, 1])
        f[n + k, 0], f[n + k, 1] = interval.add(f[n + k, 0], f[n + k, 1], a, b)
        a, b = interval.mul(t0, t1, moment[k, 0], moment[k, 1])
        f[n + 3 + k, 0], f[n + 3 + k, 1] = interval.add(f[n + 3 + k, 0], f[n + 3 + k, 1], a, b)
    if slopes:
        J[i, 6 + i, 0], J[i, 6 + i, 1] = -cs1, -cs0
        for k in range(3):
            J[n + k, 6 + i, 0], J[n + k, 6 + i, 1] = e[k, 0], e[k, 1]
            J[n + 3 + k, 6 + i, 0], J[n + 3 + k, 6 + i, 1] = moment[k, 0], moment[k, 1]
        cable_slopes(real, i, reach, arm, e, dR, z, seen, J)


@kernel()
def cable_slopes(
    real: Any, i: int, reach: float, arm: Any, e: Any, dR: Any, z: Any, seen: Any, J: Any
) -> None:
    """Add cable i's part of the derivatives by u and p; ``arm, e`` (3, 2)."""
    n = real.n_taut
    t0, t1 = z[6 + i, 0], z[6 + i, 1]
    moved, change, by, moment = np.empty((3, 2)), np.empty((3, 2)), np.empty((3, 2)), np.empty((3, 2))
    N = np.empty((3, 3, 2))
    foot_slopes(real, i, reach, seen, N)
    r = real.radius[i]
    sigma, side = seen[i, LEAST_FREE], seen[i, LEAST_SIDE]
    # a = grad L changes by at most max(1 / sigma, 1 / x), grad sigma = a + slant n by some more.
    m = max(1.0 / sigma, 1.0 / side)
    off = (m * reach + 2.0 * seen[i, OFF_POINT] * m) * (1.0 + 1e-12) + ROUNDING
    slant, more = 0.0, off
    if r > 0.0 and seen[i, STATE] != PAST:
        slant = r / seen[i, FREE]
        if real.joints[i] == 2:
            slant = r * seen[i, TURN]
            for k in range(3):
                slant -= seen[i, LEAN + k] * seen[i, ALONG + k]
        more = off * (1.0 + real.sway[i] / sigma)
        slopes = swings(real.joints[i], r, real.arm[i], real.lead[i], sigma)
        more += slopes[2] * (reach + seen[i, OFF_POINT])
    ct0, ct1 = interval.mul(real.compliance[i, 0], real.compliance[i, 1], t0, t1)
    pull = np.empty((3, 2))
    for k in range(3):
        a = seen[i, ALONG + k]
        g = a + slant * seen[i, ACROSS + k] if slant != 0.0 else a
        b0, b1 = interval.mul(ct0, ct1, g - more, g + more)
        pull[k, 0], pull[k, 1] = interval.sub(a - off, a + off, b0, b1)
    for j in range(6):
        for k in range(3):
            moved[k, 0] = 1.0 if j - 3 == k else 0.0
            moved[k, 1] = moved[k, 0]
        if j < 3:
            times_arm(dR[j], real, i, moved)
        for k in range(3):
            lo, hi = 0.0, 0.0
            for c in range(3):
                a, b = interval.mul(N[k, c, 0], N[k, c, 1], moved[c, 0], moved[c, 1])
                lo, hi = interval.add(lo, hi, a, b)
            change[k, 0], change[k, 1] = lo, hi
            put(J, i, j, pull[k, 0], pull[k, 1], moved[k, 0], moved[k, 1])
            put(J, n + k, j, t0, t1, lo, hi)
        cross(arm, change, moment)
        for k in range(3):
            put(J, n + 3 + k, j, t0, t1, moment[k, 0], moment[k, 1])
        if j < 3:
            cross(moved, e, by)
            for k in range(3):
                put(J, n + 3 + k, j, t0, t1, by[k, 0], by[k, 1])


@entry()
def system(at: Any, z: Any, f: Any, J: Any, slopes: bool) -> bool:
    """Enclose all equations and, if asked, derivatives over a box; False where a cable is not smooth."""
    real = at.real
    n = real.n_taut
    middle, R, dR = np.empty((3, 3)), np.empty((3, 3, 2)), np.empty((3, 3, 3, 2))
    turned = turning(real, at.chart, z, middle, R, dR)
    f[:, :] = 0.0
    if slopes:
        J[:, :, :] = 0.0
    for k in range(3):
        f[n + k, 0] = real.load[k] - real.load_err[k]
        f[n + k, 1] = real.load[k] + real.load_err[k]
    for i in range(n):
        reach = see_over(real, i, middle, turned, z, at.seen)
        if not reach < math.inf:
            return False
        cable(real, i, reach, R, dR, z, at.seen, f, J, slopes)
    return True


@part()
def residual(context: Any, box: Any, f: Any) -> None:
    """Enclose the equations over a box; context (at, C), see ``cdpr_interval.engine.krawczyk``."""
    at, _ = context
    unused = np.empty((1, 1, 2))
    if not system(at, box, f, unused, False):
        f[:, 0] = -math.inf
        f[:, 1] = math.inf


@part()
def linearise(context: Any, box: Any, f: Any, C: Any) -> bool:
    """Write residuals and the inverse of their derivatives at a point, as Newton asks for."""
    at, _ = context
    J = np.empty((C.shape[0], C.shape[0], 2))
    return system(at, box, f, J, True) and preconditioner(J, C)


@part()
def deviate(context: Any, box: Any, E: Any) -> None:
    """Enclose I - C J in E (m, m, 2) over a box."""
    at, C = context
    J, f = np.empty(E.shape), np.empty((E.shape[0], 2))
    if system(at, box, f, J, True):
        deviation(C, J, E)
    else:
        E[:, :, 0] = -math.inf
        E[:, :, 1] = math.inf


@part()
def apply(context: Any, box: Any, image: Any) -> bool:
    """Apply the Krawczyk operator to a box (m, 2)."""
    return over(residual, deviate, context, context[1], box, image)


@entry()
def improve(at: Any, z: Any, C: Any, steps: int) -> bool:
    """Improve z (6 + n,) by Newton steps in floats, C the last inverse; True when they converged."""
    return newton(linearise, residual, (at, C), z, C, steps, PACE) < CONVERGED


@entry()
def existence_box(at: Any, z: Any, C: Any, box: Any) -> bool:
    """Grow a box (6 + n, 2) around z (6 + n,) until the operator maps it strictly into itself.

    Guarantee: where True is returned, ``box`` holds exactly one zero.
    """
    here, f, J = np.empty(box.shape), np.empty(box.shape), np.empty((C.shape[0], C.shape[0], 2))
    point(z, here)
    copy(here, box)
    if not (system(at, here, f, J, True) and preconditioner(J, C) and np.isfinite(C).all()):
        return False
    size = 1.0
    for k in range(6):
        size = max(size, abs(z[k]))
    return existence(apply, (at, C), C, z, f, size, True, box)


@entry()
def growth(at: Any, C: Any, box: Any) -> float:
    """Return how much |I - C J| stretches a positive vector over a box: below 1 only with a proof.

    Guarantee: a value below 1 proves that the box holds at most one zero.
    """
    E = np.empty((C.shape[0], C.shape[0], 2))
    deviate((at, C), box, E)
    return float(stretch(E, box))
