"""The ways of cables to all points of a box, compiled: lengths, directions and their derivatives, enclosed.

The formulas are those of `cdpr_interval.mechanics.cables.pulley`; a fixed exit point is a route of its own
kind.

Arrays: ``route`` (ROUTE, 2) is a row of ``routes`` (N, ROUTE, 2), see ``EXIT`` and below, as
`cdpr_interval.mechanics.cables.route_rows` makes it; ``box`` (3, 2) bounds the anchor X; ``way`` (WAY, 2) is
written, see ``LENGTH`` and below; ``turning`` (3, 3, 2) is da/dX; ``parts`` (8, 2) are the pieces of a way,
see `held_way`; ``u`` (3, 2); ``q`` (2, 2), ``flat`` (2, 2), ``arm`` (2, 2) and ``n`` (2, 2) lie in the plane
of the cable: along u, along k. The last axis is (lo, hi).
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
from cdpr_interval.kernels.kernel import entry, kernel

FIXED, ONE_JOINT, BALANCED, BISECTED = 0, 1, 2, 3
"""Kinds of routes: a fixed exit point, a pulley on one joint, on two in exact balance, on two with the
bisector."""
KIND, EXIT, AXIS, RADIUS, ARM, LEAD_IN, BEFORE, THETA, SNUG = 0, 1, 4, 7, 8, 9, 10, 11, 12
"""Rows of a route: kind; A (3 rows); unit vector k (3); radius, arm and lead-in; the straight piece that
arrives (all of what lies before a fixed exit) and the angle of K, both for one joint; 1 where the arm is
the radius."""
ROUTE = 13
LENGTH, ALONG, ACROSS, OUTWARD, FREE, WRAP, SWING, NORMAL, PLANE, TILT = 0, 1, 4, 5, 6, 7, 8, 10, 12, 15
"""Rows of a way: L; a (3 rows); x, the distance from the axis; a_u; sigma; the wrap (rad); the gradient of
psi in the plane (2); n in the plane (2); u (3); dL/dX - a in the plane (2), which only the bisector has."""
WAY = 17


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
def plane_of(route: Any, box: Any, flat: Any, u: Any) -> None:
    """Enclose the anchor from A in the plane of the cable, flat (2, 2), and the unit vector u (3, 2)."""
    g = np.empty((3, 2))
    ylo, yhi = 0.0, 0.0
    for j in range(3):
        g[j, 0], g[j, 1] = sub(box[j, 0], box[j, 1], route[EXIT + j, 0], route[EXIT + j, 1])
        lo, hi = mul(g[j, 0], g[j, 1], route[AXIS + j, 0], route[AXIS + j, 1])
        ylo, yhi = add(ylo, yhi, lo, hi)
    slo, shi = 0.0, 0.0
    for i in range(3):
        # The part across the axis, (I - k k^T) g row by row: an axis along z leaves no trace of z.
        lo, hi = 0.0, 0.0
        for j in range(3):
            klo, khi = mul(route[AXIS + i, 0], route[AXIS + i, 1], route[AXIS + j, 0], route[AXIS + j, 1])
            if i == j:
                klo, khi = sqr(route[AXIS + i, 0], route[AXIS + i, 1])
                klo, khi = sub(1.0, 1.0, klo, khi)
                klo, khi = max(klo, 0.0), max(khi, 0.0)
            else:
                klo, khi = -khi, -klo
            klo, khi = mul(klo, khi, g[j, 0], g[j, 1])
            lo, hi = add(lo, hi, klo, khi)
        u[i, 0], u[i, 1] = lo, hi
        lo, hi = sqr(lo, hi)
        slo, shi = add(slo, shi, lo, hi)
    flat[0, 0], flat[0, 1] = sqrt(slo, shi)
    flat[1, 0], flat[1, 1] = ylo, yhi
    for i in range(3):
        if flat[0, 0] > 0.0:
            u[i, 0], u[i, 1] = div(u[i, 0], u[i, 1], flat[0, 0], flat[0, 1])
            u[i, 0], u[i, 1] = max(u[i, 0], -1.0), min(u[i, 1], 1.0)
        else:
            u[i, 0], u[i, 1] = -1.0, 1.0


@kernel()
def from_flat(route: Any, flat: Any, u: Any, out: Any) -> None:
    """Enclose a flat vector (2, 2) in base axes, out (3, 2)."""
    for j in range(3):
        lo, hi = mul(flat[0, 0], flat[0, 1], u[j, 0], u[j, 1])
        klo, khi = mul(flat[1, 0], flat[1, 1], route[AXIS + j, 0], route[AXIS + j, 1])
        lo, hi = add(lo, hi, klo, khi)
        out[j, 0], out[j, 1] = max(lo, -1.0), min(hi, 1.0)


@kernel()
def straight_way(route: Any, box: Any, way: Any) -> bool:
    """Write the way of a cable from a fixed exit point; as `way_over`."""
    slo, shi = 0.0, 0.0
    for j in range(3):
        lo, hi = sub(box[j, 0], box[j, 1], route[EXIT + j, 0], route[EXIT + j, 1])
        way[ALONG + j, 0], way[ALONG + j, 1] = lo, hi
        lo, hi = sqr(lo, hi)
        slo, shi = add(slo, shi, lo, hi)
    lo, hi = sqrt(slo, shi)
    way[FREE, 0], way[FREE, 1] = lo, hi
    way[LENGTH, 0], way[LENGTH, 1] = add(lo, hi, route[BEFORE, 0], route[BEFORE, 1])
    for j in range(3):
        if lo > 0.0:
            alo, ahi = div(way[ALONG + j, 0], way[ALONG + j, 1], lo, hi)
            way[ALONG + j, 0], way[ALONG + j, 1] = max(alo, -1.0), min(ahi, 1.0)
        else:
            way[ALONG + j, 0], way[ALONG + j, 1] = -1.0, 1.0
    # A straight cable is convex everywhere.
    way[OUTWARD, 0], way[OUTWARD, 1] = 1.0, 1.0
    way[ACROSS, 0], way[ACROSS, 1] = lo, hi
    way[WRAP, 0], way[WRAP, 1] = 0.0, 0.0
    return True


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


CUT = 1.5
"""Rad: a wrap that is known better than this comes from angles away from their cut."""
WIDENINGS = 3
"""Times that the range of an arm is widened before it counts as unknown: the box is too wide."""
STEPS = 12
"""Newton steps for the arm in floats; each is quadratic."""


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


@kernel()
def swing(route: Any, flat: Any, arm: Any, parts: Any, out: Any) -> None:
    """Enclose the gradient of psi in the plane, out (2, 2), for an arm and ``parts`` as `held_way` has."""
    n = parts[3:5]
    free = parts[1]
    kind = route[KIND, 0]
    for j in range(2):
        out[j, 0], out[j, 1] = div(n[j, 0], n[j, 1], free[0], free[1])
    if kind == ONE_JOINT:
        return
    alo, ahi = across_arm(route, arm, n)
    alo, ahi = div(alo, ahi, free[0], free[1])
    if kind == BISECTED:
        turn = np.empty((2, 2))
        half_turn(flat, turn)
        for j in range(2):
            lo, hi = mul(alo, ahi, turn[j, 0], turn[j, 1])
            out[j, 0], out[j, 1] = sub(out[j, 0], out[j, 1], lo, hi)
        return
    # n times 1 / sigma - (h f . n / sigma)^2 / l'', which is not negative.
    _, _, klo, khi, _ = arm_forces(route, arm, parts)
    alo, ahi = sqr(alo, ahi)
    alo, ahi = div(alo, ahi, klo, khi)
    lo, hi = div(1.0, 1.0, free[0], free[1])
    lo, hi = sub(lo, hi, alo, ahi)
    lo = max(lo, 0.0)
    for j in range(2):
        out[j, 0], out[j, 1] = mul(n[j, 0], n[j, 1], lo, hi)


@kernel()
def way_over(route: Any, box: Any, way: Any) -> bool:
    """Write the way (WAY, 2) of a cable to all anchors in a box (3, 2).

    Returns
    -------
    bool
        False: no point of the box has a way, all lie inside the pulley.

    Guarantee
    ---------
    The rows enclose the quantities of the way to every point of the box that has one. Where little is known,
    bounds are infinite, of unit vectors [-1, 1].
    """
    if route[KIND, 0] == FIXED:
        return straight_way(route, box, way)
    flat, arm, parts = np.empty((2, 2)), np.empty((2, 2)), np.empty((8, 2))
    u = way[PLANE : PLANE + 3]
    plane_of(route, box, flat, u)
    way[ACROSS, 0], way[ACROSS, 1] = flat[0, 0], flat[0, 1]
    way[TILT : TILT + 2] = 0.0
    if not arm_of(route, flat, arm, parts):
        unknown_way(route, box, way)
        return True
    if not held_way(route, flat, arm, parts):
        return False
    swing(route, flat, arm, parts, way[SWING : SWING + 2])
    if route[KIND, 0] == BISECTED:
        # The slope by the arm's angle, times how the bisector turns.
        slo, shi, _, _, _ = arm_forces(route, arm, parts)
        turn = np.empty((2, 2))
        half_turn(flat, turn)
        for j in range(2):
            way[TILT + j, 0], way[TILT + j, 1] = mul(slo, shi, turn[j, 0], turn[j, 1])
    if not parts[2, 0] >= 0.0:
        lift(route, flat, parts, way)
    way[LENGTH], way[FREE], way[WRAP] = parts[0], parts[1], parts[2]
    way[NORMAL], way[NORMAL + 1] = parts[3], parts[4]
    along = np.empty((2, 2))
    along[0, 0], along[0, 1] = parts[4, 0], parts[4, 1]
    along[1, 0], along[1, 1] = -parts[3, 1], -parts[3, 0]
    way[OUTWARD] = along[0]
    from_flat(route, along, u, way[ALONG : ALONG + 3])
    return True


@kernel()
def unknown_way(route: Any, box: Any, way: Any) -> None:
    """Write what holds whatever the arm does: no rope is shorter than the straight line."""
    for j in range(LENGTH, WAY):
        if j != ACROSS and not PLANE <= j < TILT:
            way[j, 0], way[j, 1] = -math.inf, math.inf
    for j in range(3):
        way[ALONG + j, 0], way[ALONG + j, 1] = -1.0, 1.0
    way[FREE, 0] = 0.0
    slo, shi = 0.0, 0.0
    for j in range(3):
        lo, hi = mul(route[LEAD_IN, 0], route[LEAD_IN, 1], route[AXIS + j, 0], route[AXIS + j, 1])
        lo, hi = sub(route[EXIT + j, 0], route[EXIT + j, 1], lo, hi)
        lo, hi = sub(box[j, 0], box[j, 1], lo, hi)
        lo, hi = sqr(lo, hi)
        slo, shi = add(slo, shi, lo, hi)
    way[LENGTH, 0] = sqrt(slo, shi)[0]


@kernel()
def past_way(route: Any, flat: Any, parts: Any, out: Any) -> None:
    """Write the pieces of a way that runs past the pulley, straight from C: ``parts`` as `held_way` does.

    ``out`` (2, 2) is written as by `swing`.
    """
    lo, hi = add(flat[1, 0], flat[1, 1], route[LEAD_IN, 0], route[LEAD_IN, 1])
    alo, ahi = sqr(lo, hi)
    blo, bhi = sqr(flat[0, 0], flat[0, 1])
    alo, ahi = add(alo, ahi, blo, bhi)
    alo, ahi = sqrt(alo, ahi)
    parts[:] = 0.0
    parts[0, 0], parts[0, 1] = alo, ahi
    parts[1, 0], parts[1, 1] = alo, ahi
    # a = (n_k, -n_u) is the direction from C.
    lo, hi = div(-hi, -lo, alo, ahi)
    parts[3, 0], parts[3, 1] = max(lo, -1.0), min(hi, 1.0)
    lo, hi = div(flat[0, 0], flat[0, 1], alo, ahi)
    parts[4, 0], parts[4, 1] = max(lo, 0.0), min(hi, 1.0)
    for j in range(2):
        out[j, 0], out[j, 1] = div(parts[3 + j, 0], parts[3 + j, 1], alo, ahi)


@kernel()
def lift(route: Any, flat: Any, parts: Any, way: Any) -> None:
    """Widen the pieces ``parts`` (8, 2) of a way, its swing and tilt to a rope that may run past the pulley.

    It does where the wrap would be negative. Length and direction go on there without a step.
    """
    past, out = np.empty((8, 2)), np.empty((2, 2))
    past_way(route, flat, past, out)
    if parts[2, 1] < 0.0:
        outside = parts[1, 0] > 0.0
        parts[:] = past
        if not outside:
            # Points of the box may lie inside the pulley, as sigma tells: they have no way.
            parts[1, 0] = 0.0
        way[SWING : SWING + 2] = out
        way[TILT : TILT + 2] = 0.0
        return
    parts[2, 0] = 0.0
    for j in range(8):
        parts[j, 0], parts[j, 1] = min(parts[j, 0], past[j, 0]), max(parts[j, 1], past[j, 1])
    for j in range(2):
        k = SWING + j
        way[k, 0], way[k, 1] = min(way[k, 0], out[j, 0]), max(way[k, 1], out[j, 1])
        k = TILT + j
        way[k, 0], way[k, 1] = min(way[k, 0], 0.0), max(way[k, 1], 0.0)


@kernel()
def turning_over(route: Any, way: Any, turning: Any) -> None:
    """Enclose da/dX, turning (3, 3, 2), for a way (WAY, 2) that `way_over` has written."""
    if route[KIND, 0] == FIXED:
        for i in range(3):
            for j in range(3):
                if i == j:
                    lo, hi = sqr(way[ALONG + i, 0], way[ALONG + i, 1])
                    lo, hi = sub(1.0, 1.0, lo, hi)
                    lo = max(lo, 0.0)
                else:
                    lo, hi = mul(way[ALONG + i, 0], way[ALONG + i, 1], way[ALONG + j, 0], way[ALONG + j, 1])
                    lo, hi = -hi, -lo
                turning[i, j, 0], turning[i, j, 1] = div(lo, hi, way[FREE, 0], way[FREE, 1])
        return
    n, g, w = np.empty((3, 2)), np.empty((3, 2)), np.empty((3, 2))
    u = way[PLANE : PLANE + 3]
    from_flat(route, way[NORMAL : NORMAL + 2], u, n)
    for j in range(3):
        lo, hi = mul(way[SWING, 0], way[SWING, 1], u[j, 0], u[j, 1])
        klo, khi = mul(way[SWING + 1, 0], way[SWING + 1, 1], route[AXIS + j, 0], route[AXIS + j, 1])
        g[j, 0], g[j, 1] = add(lo, hi, klo, khi)
        a, b = (j + 1) % 3, (j + 2) % 3
        lo, hi = mul(route[AXIS + a, 0], route[AXIS + a, 1], u[b, 0], u[b, 1])
        klo, khi = mul(route[AXIS + b, 0], route[AXIS + b, 1], u[a, 0], u[a, 1])
        w[j, 0], w[j, 1] = sub(lo, hi, klo, khi)
    slo, shi = div(way[OUTWARD, 0], way[OUTWARD, 1], way[ACROSS, 0], way[ACROSS, 1])
    for i in range(3):
        for j in range(3):
            lo, hi = mul(n[i, 0], n[i, 1], g[j, 0], g[j, 1])
            if i == j:
                wlo, whi = sqr(w[i, 0], w[i, 1])
            else:
                wlo, whi = mul(w[i, 0], w[i, 1], w[j, 0], w[j, 1])
            wlo, whi = mul(slo, shi, wlo, whi)
            turning[i, j, 0], turning[i, j, 1] = add(lo, hi, wlo, whi)


@kernel()
def gradient_over(route: Any, way: Any, gradient: Any) -> None:
    """Enclose dL/dX, gradient (3, 2): the direction, but for the bisector; for a way as `turning_over`."""
    for j in range(3):
        gradient[j, 0], gradient[j, 1] = way[ALONG + j, 0], way[ALONG + j, 1]
        if route[KIND, 0] == BISECTED:
            lo, hi = mul(way[TILT, 0], way[TILT, 1], way[PLANE + j, 0], way[PLANE + j, 1])
            klo, khi = mul(way[TILT + 1, 0], way[TILT + 1, 1], route[AXIS + j, 0], route[AXIS + j, 1])
            lo, hi = add(lo, hi, klo, khi)
            gradient[j, 0], gradient[j, 1] = add(gradient[j, 0], gradient[j, 1], lo, hi)


@kernel()
def sharpened_length(route: Any, box: Any, way: Any, gradient: Any, at_middle: Any) -> None:
    """Cut the length of a way by the mean value theorem around the middle of its box.

    ``gradient`` (3, 2) over the box; ``at_middle`` (WAY, 2) is scratch, then the way to the middle.
    """
    if route[KIND, 0] != FIXED and not (way[FREE, 0] > 0.0 and way[WRAP, 1] - way[WRAP, 0] < CUT):
        # The line from the middle to a point may cross the pulley, or where the angle of its rope is cut.
        return
    here = np.empty((3, 2))
    for j in range(3):
        here[j, 0] = mid(box[j, 0], box[j, 1])
        here[j, 1] = here[j, 0]
    if not way_over(route, here, at_middle):
        return
    lo, hi = at_middle[LENGTH, 0], at_middle[LENGTH, 1]
    for j in range(3):
        dlo, dhi = sub(box[j, 0], box[j, 1], here[j, 0], here[j, 0])
        dlo, dhi = mul(gradient[j, 0], gradient[j, 1], dlo, dhi)
        lo, hi = add(lo, hi, dlo, dhi)
    way[LENGTH, 0], way[LENGTH, 1] = max(way[LENGTH, 0], lo), min(way[LENGTH, 1], hi)


@entry()
def ways_over(routes: Any, box: Any, ways: Any, turnings: Any) -> bool:
    """Write the ways (N, WAY, 2) and da/dX (N, 3, 3, 2) of cables (N, ROUTE, 2) over a box (3, 2) of anchors.

    False: all points lie inside one pulley.
    """
    for i in range(routes.shape[0]):
        if not way_over(routes[i], box, ways[i]):
            return False
        turning_over(routes[i], ways[i], turnings[i])
    return True
