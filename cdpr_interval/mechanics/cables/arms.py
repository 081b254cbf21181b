"""The rope around a pulley that its arm holds, and the arm where the rope leaves it, compiled and enclosed.

Arrays: ``route`` (ROUTE, 2) as `cdpr_interval.mechanics.cables.rows` has it; ``flat`` (2, 2) bounds the
anchor from A in the plane of the cable, along u, along k, in which ``q`` (2, 2), ``arm`` (2, 2), ``n``
(2, 2), ``normal`` (2, 2) and ``turn`` (2, 2) lie, too; ``r`` (2,) the radius; ``parts`` (8, 2) are the
pieces of a way, see `held_way`. The last axis is (lo, hi).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.kernels.interval import (
    HALF_PI_HI,
    HALF_PI_LO,
    add,
    atan,
    div,
    mag,
    mid,
    mul,
    sqr,
    sqrt,
    sub,
)
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.mechanics.cables.rows import (
    ARM,
    BALANCED,
    BEFORE,
    BISECTED,
    KIND,
    LEAD_IN,
    ONE_JOINT,
    RADIUS,
    SNUG,
    THETA,
)

WIDENINGS = 3
"""Times that the range of an arm is widened before it counts as unknown: the box is too wide."""
STEPS = 12
"""Newton steps for the arm in floats; each is quadratic."""


@kernel()
def leg(q: Any, r: Any, side: int, normal: Any) -> tuple[float, float]:
    """Enclose the unit vector ``normal`` (2, 2) to where the tangent to a point at q touches; return sigma.

    ``r`` (2,) is the radius; ``side`` is 1 for the rope that leaves, -1 for the one that arrives. A sigma
    with a bound (inf, -inf): all points lie inside the pulley.
    """
    alo, ahi = sqr(q[0, 0], q[0, 1])
    blo, bhi = sqr(q[1, 0], q[1, 1])
    slo, shi = add(alo, ahi, blo, bhi)
    rlo, rhi = sqr(r[0], r[1])
    flo, fhi = sub(slo, shi, rlo, rhi)
    flo, fhi = sqrt(flo, fhi)
    if not flo <= fhi:
        return flo, fhi
    # Tangents exist where rho >= r only.
    slo = max(slo, rlo)
    for j in range(2):
        lo, hi = mul(flo, fhi, q[1 - j, 0], q[1 - j, 1])
        if (j == 0) == (side == 1):
            lo, hi = -hi, -lo
        clo, chi = mul(r[0], r[1], q[j, 0], q[j, 1])
        lo, hi = add(lo, hi, clo, chi)
        lo, hi = div(lo, hi, slo, shi)
        normal[j, 0], normal[j, 1] = max(lo, -1.0), min(hi, 1.0)
    return flo, fhi


@kernel()
def angle_of(n: Any, hangs: bool) -> tuple[float, float]:
    """Enclose the angle of n (2, 2), rad, with the cut at -3/4 pi, or at -pi / 2 for a pulley that ``hangs``.

    All angles where n may lie on the cut.
    """
    # The angle of n turned by -pi / 4 or -pi / 2, whose cut is at pi, plus that.
    if hangs:
        slo, shi = -n[0, 1], -n[0, 0]
        clo, chi = n[1, 0], n[1, 1]
    else:
        slo, shi = sub(n[1, 0], n[1, 1], n[0, 0], n[0, 1])
        clo, chi = add(n[1, 0], n[1, 1], n[0, 0], n[0, 1])
    if clo > 0.0:
        lo, hi = div(slo, shi, clo, chi)
        lo, hi = atan(lo, hi)
    elif slo > 0.0:
        lo, hi = div(clo, chi, slo, shi)
        lo, hi = atan(lo, hi)
        lo, hi = sub(HALF_PI_LO, HALF_PI_HI, lo, hi)
    elif shi < 0.0:
        lo, hi = div(clo, chi, slo, shi)
        lo, hi = atan(lo, hi)
        lo, hi = sub(-HALF_PI_HI, -HALF_PI_LO, lo, hi)
    else:
        lo, hi = -2.0 * HALF_PI_HI, 2.0 * HALF_PI_HI
    part = 1.0 if hangs else 0.5
    return add(lo, hi, part * HALF_PI_LO, part * HALF_PI_HI)


@kernel()
def held_way(route: Any, flat: Any, arm: Any, parts: Any) -> bool:
    """Write the pieces of the way around a pulley held at a unit vector ``arm`` (2, 2) from A.

    ``parts`` (8, 2): length, sigma, wrap, n (2 rows), normal at K (2 rows), straight piece that arrives.
    False: every point ``flat`` (2, 2) lies inside the pulley.
    """
    q = np.empty((2, 2))
    h = route[ARM]
    r = route[RADIUS]
    for j in range(2):
        lo, hi = mul(h[0], h[1], arm[j, 0], arm[j, 1])
        q[j, 0], q[j, 1] = sub(flat[j, 0], flat[j, 1], lo, hi)
    parts[1, 0], parts[1, 1] = leg(q, r, 1, parts[3:5])
    if not parts[1, 0] <= parts[1, 1]:
        return False
    if route[KIND, 0] == ONE_JOINT:
        parts[7, 0], parts[7, 1] = route[BEFORE, 0], route[BEFORE, 1]
        tlo, thi = route[THETA, 0], route[THETA, 1]
        parts[5:7] = 0.0
    else:
        for j in range(2):
            lo, hi = mul(h[0], h[1], arm[j, 0], arm[j, 1])
            q[j, 0], q[j, 1] = -hi, -lo
        q[1, 0], q[1, 1] = sub(q[1, 0], q[1, 1], route[LEAD_IN, 0], route[LEAD_IN, 1])
        parts[7, 0], parts[7, 1] = leg(q, r, -1, parts[5:7])
        if not parts[7, 0] <= parts[7, 1]:
            return False
        tlo, thi = angle_of(parts[5:7], True)
    plo, phi = angle_of(parts[3:5], route[KIND, 0] != ONE_JOINT)
    lo, hi = sub(tlo, thi, plo, phi)
    if route[KIND, 0] == BALANCED or (route[SNUG, 0] == 1.0 and route[KIND, 0] == ONE_JOINT):
        # `balanced_arm` knows that the rope presses on the pulley; or the rope arrives along the axis, and
        # the anchor is on the pulley's side of it.
        lo, hi = max(lo, 0.0), max(hi, 0.0)
    parts[2, 0], parts[2, 1] = lo, hi
    lo, hi = mul(r[0], r[1], lo, hi)
    lo, hi = add(lo, hi, parts[1, 0], parts[1, 1])
    parts[0, 0], parts[0, 1] = add(lo, hi, parts[7, 0], parts[7, 1])
    return True


@kernel()
def arm_forces(route: Any, arm: Any, parts: Any) -> tuple[float, float, float, float, float]:
    """Enclose dl/ddelta and d2l/ddelta2 of an arm held at a unit vector (2, 2); ``parts`` as `held_way`.

    The last number is a lower bound of the rope's pull along the arm, times its length.
    """
    # a = (n_k, -n_u), c = (-n'_k, n'_u): the sum of both pulls.
    pulls = np.empty((2, 2))
    pulls[0, 0], pulls[0, 1] = sub(parts[4, 0], parts[4, 1], parts[6, 0], parts[6, 1])
    pulls[1, 0], pulls[1, 1] = sub(parts[5, 0], parts[5, 1], parts[3, 0], parts[3, 1])
    # f = (-arm_k, arm_u).
    alo, ahi = mul(arm[0, 0], arm[0, 1], pulls[1, 0], pulls[1, 1])
    blo, bhi = mul(arm[1, 0], arm[1, 1], pulls[0, 0], pulls[0, 1])
    lo, hi = sub(blo, bhi, alo, ahi)
    slo, shi = mul(route[ARM, 0], route[ARM, 1], lo, hi)
    alo, ahi = mul(arm[0, 0], arm[0, 1], pulls[0, 0], pulls[0, 1])
    blo, bhi = mul(arm[1, 0], arm[1, 1], pulls[1, 0], pulls[1, 1])
    lo, hi = add(alo, ahi, blo, bhi)
    klo, khi = mul(route[ARM, 0], route[ARM, 1], lo, hi)
    pull = klo
    for i in range(2):
        clo, chi = across_arm(route, arm, parts[3 + 2 * i : 5 + 2 * i])
        clo, chi = sqr(clo, chi)
        free = parts[1] if i == 0 else parts[7]
        clo, chi = div(clo, chi, free[0], free[1])
        klo, khi = add(klo, khi, max(clo, 0.0), chi)
    return slo, shi, klo, khi, pull


@kernel()
def across_arm(route: Any, arm: Any, n: Any) -> tuple[float, float]:
    """Enclose h f . n for the unit vectors ``arm`` and n (2, 2); f is the arm turned by a quarter."""
    alo, ahi = mul(arm[0, 0], arm[0, 1], n[1, 0], n[1, 1])
    blo, bhi = mul(arm[1, 0], arm[1, 1], n[0, 0], n[0, 1])
    lo, hi = sub(alo, ahi, blo, bhi)
    return mul(route[ARM, 0], route[ARM, 1], lo, hi)


@kernel()
def arm_at(w_lo: float, w_hi: float, arm: Any) -> None:
    """Enclose the arm (2, 2) = (sin delta, -cos delta) for tan(delta / 2) = w, 0 <= w."""
    slo, shi = sqr(w_lo, w_hi)
    dlo, dhi = add(1.0, 1.0, slo, shi)
    # cos = 2 / (1 + w^2) - 1; sin = 2 w / (1 + w^2), which rises up to w = 1.
    clo, chi = div(2.0, 2.0, dlo, dhi)
    clo, chi = sub(clo, chi, 1.0, 1.0)
    lo, hi = div(2.0 * w_lo, 2.0 * w_hi, dlo, dhi)
    arm[0, 0], arm[0, 1] = max(lo, 0.0), min(hi, 1.0)
    arm[1, 0], arm[1, 1] = max(-chi, -1.0), min(-clo, 1.0)


@kernel()
def must_touch(route: Any, flat: Any) -> bool:
    """Return True where no arm lets the rope pass: (h - r) |X - C| < lead_in x for all points."""
    lo, hi = add(flat[1, 0], flat[1, 1], route[LEAD_IN, 0], route[LEAD_IN, 1])
    lo, hi = sqr(lo, hi)
    alo, ahi = sqr(flat[0, 0], flat[0, 1])
    lo, hi = add(lo, hi, alo, ahi)
    lo, hi = sqrt(lo, hi)
    alo, ahi = sub(route[ARM, 0], route[ARM, 1], route[RADIUS, 0], route[RADIUS, 1])
    alo, ahi = max(alo, 0.0), max(ahi, 0.0)
    if route[SNUG, 0] == 1.0:
        alo, ahi = 0.0, 0.0
    lo, hi = mul(alo, ahi, lo, hi)
    alo, ahi = mul(route[LEAD_IN, 0], route[LEAD_IN, 1], flat[0, 0], flat[0, 1])
    return hi < alo


@kernel()
def balanced_arm(route: Any, flat: Any, arm: Any, parts: Any) -> bool:
    """Write the arm (2, 2) in exact balance for all points ``flat`` (2, 2); False where none is proved.

    Interval Newton in w = tan(delta / 2), with legs that touch the pulley for every arm in the range. Only
    one balance has the rope on the pulley and a pull along the arm. ``parts`` (8, 2) is scratch.
    """
    touches = must_touch(route, flat)
    here = np.empty((2, 2))
    for j in range(2):
        here[j, 0] = mid(flat[j, 0], flat[j, 1])
        here[j, 1] = here[j, 0]
    norm = math.hypot(here[0, 0], here[1, 0])
    # tan(phi / 4) for the bisector, phi measured from the direction of C.
    half = math.sqrt(max(0.5 * (1.0 - here[1, 0] / norm), 1e-30)) if norm > 0.0 else 1.0
    w = math.sqrt(max((1.0 - half) / (1.0 + half), 0.0))
    for _ in range(STEPS):
        arm_at(w, w, arm)
        if not held_way(route, here, arm, parts):
            return False
        slo, shi, klo, khi, _ = arm_forces(route, arm, parts)
        step = mid(slo, shi) / (mid(klo, khi) * 2.0 / (1.0 + w * w))
        if not abs(step) < math.inf:
            return False
        w = max(w - step, 0.0)
        if abs(step) < 1e-16 * (1.0 + w):
            break
    arm_at(w, w, arm)
    if not held_way(route, flat, arm, parts) or not (parts[1, 0] > 0.0 and parts[7, 0] > 0.0):
        return False
    slo, shi, klo, khi, _ = arm_forces(route, arm, parts)
    reach = 1.5 * mag(slo, shi) / max(mid(klo, khi) * 2.0 / (1.0 + w * w), 1e-300) + 1e-15
    for _ in range(WIDENINGS):
        wlo, whi = max(w - reach, 0.0), w + reach
        arm_at(wlo, whi, arm)
        if not held_way(route, flat, arm, parts) or not (parts[1, 0] > 0.0 and parts[7, 0] > 0.0):
            return False
        _, _, klo, khi, pull = arm_forces(route, arm, parts)
        dlo, dhi = sqr(wlo, whi)
        dlo, dhi = add(1.0, 1.0, dlo, dhi)
        dlo, dhi = div(2.0, 2.0, dlo, dhi)
        klo, khi = mul(klo, khi, dlo, dhi)
        if not (klo > 0.0 and pull > 0.0 and (touches or parts[2, 0] > 0.0)):
            return False
        lo, hi = div(slo, shi, klo, khi)
        lo, hi = sub(w, w, lo, hi)
        if wlo < lo and hi < whi:
            arm_at(max(lo, 0.0), hi, arm)
            return True
        reach *= 2.0
    return False


@kernel()
def bisecting_arm(flat: Any, arm: Any) -> bool:
    """Write the arm (2, 2) along the bisector of C - A and X - A for all points ``flat`` (2, 2)."""
    alo, ahi = sqr(flat[0, 0], flat[0, 1])
    blo, bhi = sqr(flat[1, 0], flat[1, 1])
    nlo, nhi = add(alo, ahi, blo, bhi)
    nlo, nhi = sqrt(nlo, nhi)
    # (0, -1) |X| + X.
    blo, bhi = sub(flat[1, 0], flat[1, 1], nlo, nhi)
    bhi = min(bhi, 0.0)
    slo, shi = sqr(blo, bhi)
    slo, shi = add(alo, ahi, slo, shi)
    slo, shi = sqrt(slo, shi)
    if not slo > 0.0:
        return False
    lo, hi = div(flat[0, 0], flat[0, 1], slo, shi)
    arm[0, 0], arm[0, 1] = max(lo, 0.0), min(hi, 1.0)
    lo, hi = div(blo, bhi, slo, shi)
    arm[1, 0], arm[1, 1] = max(lo, -1.0), min(hi, 0.0)
    return True


@kernel()
def arm_of(route: Any, flat: Any, arm: Any, parts: Any) -> bool:
    """Write the unit vector ``arm`` (2, 2) from A to the pulley's centre; False where it is not known."""
    kind = route[KIND, 0]
    if kind == ONE_JOINT:
        arm[0, 0], arm[0, 1], arm[1, 0], arm[1, 1] = 1.0, 1.0, 0.0, 0.0
        return True
    if kind == BISECTED:
        return bisecting_arm(flat, arm)
    return balanced_arm(route, flat, arm, parts)


@kernel()
def half_turn(flat: Any, turn: Any) -> None:
    """Enclose the gradient of arg(X - A) / 2 over flat points (2, 2) in turn (2, 2)."""
    lo, hi = sqr(flat[0, 0], flat[0, 1])
    blo, bhi = sqr(flat[1, 0], flat[1, 1])
    lo, hi = add(lo, hi, blo, bhi)
    lo, hi = 2.0 * lo, 2.0 * hi
    turn[0, 0], turn[0, 1] = div(-flat[1, 1], -flat[1, 0], lo, hi)
    turn[1, 0], turn[1, 1] = div(flat[0, 0], flat[0, 1], lo, hi)
