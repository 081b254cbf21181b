"""The way of a cable to a point in plain floats, compiled: for guesses that are proved elsewhere.

Arrays: ``route`` (ROUTE, 2) as `cdpr_interval.mechanics.cables.ways` has it, of which the middles count;
``x`` (3,) the anchor; ``a`` (3,) its direction, written; ``turning`` (3, 3) da/dX, written; ``n`` (2,) the
normal where a leg touches the pulley.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.mechanics.cables.ways import (
    ARM,
    AXIS,
    BEFORE,
    BISECTED,
    EXIT,
    FIXED,
    KIND,
    LEAD_IN,
    ONE_JOINT,
    RADIUS,
    STEPS,
    THETA,
)


@kernel()
def middle(route: Any, row: int) -> float:
    """Return the middle of a row of a route (ROUTE, 2)."""
    return 0.5 * route[row, 0] + 0.5 * route[row, 1]


@kernel()
def touch(qx: float, qy: float, r: float, side: float, n: Any) -> float:
    """Write the normal n (2,) where the tangent to (qx, qy) touches a pulley at the origin; return sigma.

    A point inside counts as one on the pulley.
    """
    square = max(qx * qx + qy * qy, r * r, 1e-300)
    free = math.sqrt(square - r * r)
    n[0] = (r * qx - side * free * qy) / square
    n[1] = (r * qy + side * free * qx) / square
    return free


@kernel()
def angle_at(n: Any) -> float:
    """Return the angle of n (2,), with the cut at -3/4 pi."""
    return math.atan2(n[1] - n[0], n[1] + n[0]) + 0.25 * math.pi


@kernel()
def arm_stiffness(h: float, s: float, c: float, n: Any, free: float, m: Any, before: float) -> Any:
    """Return dl/ddelta, d2l/ddelta2 and h f . n of an arm at (s, -c) with normals n and m (2,)."""
    px, py = n[1] - m[1], m[0] - n[0]
    slope = -h * (c * px + s * py)
    across = h * (c * n[0] + s * n[1])
    arriving = h * (c * m[0] + s * m[1])
    stiffness = h * (s * px - c * py) + across * across / max(free, 1e-300)
    return slope, stiffness + arriving * arriving / max(before, 1e-300), across


@entry()
def way_at(route: Any, x: Any, a: Any, turning: Any) -> float:
    """Write direction a (3,) and da/dX (3, 3) of the way of a cable to x (3,); return its length.

    Where there is no way, inside a pulley or on its axis, numbers are those of a point next to it.
    """
    kind = int(route[KIND, 0])
    before = middle(route, BEFORE)
    total, y = 0.0, 0.0
    u, k = np.empty(3), np.empty(3)
    for j in range(3):
        u[j] = x[j] - middle(route, EXIT + j)
        k[j] = middle(route, AXIS + j)
        total += u[j] * u[j]
        y += u[j] * k[j]
    if kind == FIXED:
        free = max(math.sqrt(total), 1e-300)
        for i in range(3):
            a[i] = u[i] / free
        for i in range(3):
            for j in range(3):
                turning[i, j] = ((1.0 if i == j else 0.0) - a[i] * a[j]) / free
        return before + free
    across = 0.0
    for j in range(3):
        u[j] -= y * k[j]
        across += u[j] * u[j]
    across = max(math.sqrt(across), 1e-300)
    for j in range(3):
        u[j] /= across
    r, h, lead = middle(route, RADIUS), middle(route, ARM), middle(route, LEAD_IN)
    n, m = np.empty(2), np.empty(2)
    s, c = 1.0, 0.0
    if kind != ONE_JOINT:
        delta = 0.5 * math.atan2(across, -y)
        for _ in range(STEPS):
            s, c = math.sin(delta), math.cos(delta)
            if kind == BISECTED:
                break
            free = touch(across - h * s, y + h * c, r, 1.0, n)
            before = touch(-h * s, h * c - lead, r, -1.0, m)
            slope, stiffness, _ = arm_stiffness(h, s, c, n, free, m, before)
            step = slope / stiffness
            delta -= step
            if abs(step) < 1e-16 * (1.0 + abs(delta)):
                break
        s, c = math.sin(delta), math.cos(delta)
    free = touch(across - h * s, y + h * c, r, 1.0, n)
    shift, theta, swing = 0.0, middle(route, THETA), 1.0 / max(free, 1e-300)
    gx, gy = n[0] * swing, n[1] * swing
    if kind != ONE_JOINT:
        before = touch(-h * s, h * c - lead, r, -1.0, m)
        theta = angle_at(m)
        slope, stiffness, shift = arm_stiffness(h, s, c, n, free, m, before)
        shift *= swing
        if kind == BISECTED:
            square = 2.0 * (across * across + y * y)
            gx += shift * y / square
            gy -= shift * across / square
        else:
            gx -= shift * shift / stiffness * n[0]
            gy -= shift * shift / stiffness * n[1]
    for i in range(3):
        a[i] = n[1] * u[i] - n[0] * k[i]
    for i in range(3):
        p, q = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            v, w = (j + 1) % 3, (j + 2) % 3
            sideways = (k[p] * u[q] - k[q] * u[p]) * (k[v] * u[w] - k[w] * u[v])
            turning[i, j] = (n[0] * u[i] + n[1] * k[i]) * (gx * u[j] + gy * k[j])
            turning[i, j] += n[1] / across * sideways
    return before + r * (theta - angle_at(n)) + free
