"""The ways of cables to all points of a box, compiled: lengths, directions and their derivatives, enclosed.

The formulas are those of `cdpr_interval.mechanics.cables.pulley`; a fixed exit point is a route of its own
kind.

Arrays: ``route`` (ROUTE, 2) is a row of ``routes`` (N, ROUTE, 2), as `cdpr_interval.mechanics.cables.rows`
has it; ``box`` (3, 2) bounds the anchor X; ``way`` (WAY, 2) is written; ``turning`` (3, 3, 2) is da/dX;
``parts`` (8, 2) are the pieces of a way, see `cdpr_interval.mechanics.cables.arms.held_way`; ``u`` (3, 2);
``flat`` (2, 2), ``arm`` (2, 2) and ``n`` (2, 2) lie in the plane of the cable: along u, along k. The last
axis is (lo, hi).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.kernels.interval import add, div, mid, mul, sqr, sqrt, sub
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.mechanics.cables.arms import across_arm, arm_forces, arm_of, half_turn, held_way
from cdpr_interval.mechanics.cables.rows import (
    ACROSS,
    ALONG,
    AXIS,
    BEFORE,
    BISECTED,
    EXIT,
    FIXED,
    FREE,
    KIND,
    LEAD_IN,
    LENGTH,
    NORMAL,
    ONE_JOINT,
    OUTWARD,
    PLANE,
    SWING,
    TILT,
    WAY,
    WRAP,
)

CUT = 1.5
"""Rad: a wrap that is known better than this comes from angles away from their cut."""


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
