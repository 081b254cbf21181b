"""The way of a cable to a point in plain floats, compiled: for guesses that are proved elsewhere.

Arrays: ``route`` (ROUTE, 2) as `cdpr_interval.mechanics.cables.rows` has it, of which the middles count;
``x`` (3,) the anchor; ``a`` (3,) its direction, written; ``turning`` (3, 3) da/dX, written; ``n`` (2,) and
``m`` (2,) the normals where the legs that leave and arrive touch the pulley; ``u`` (3,) and ``k`` (3,) the
axes of the plane.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.mechanics.cables.arms import STEPS
from cdpr_interval.mechanics.cables.rows import (
    ARM,
    AXIS,
    BALANCED,
    BEFORE,
    BISECTED,
    EXIT,
    FIXED,
    KIND,
    LEAD_IN,
    ONE_JOINT,
    RADIUS,
    SNUG,
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
def angle_at(n: Any, hangs: bool) -> float:
    """Return the angle of n (2,), with the cut at -3/4 pi, or at -pi / 2 for a pulley that ``hangs``."""
    if hangs:
        return math.atan2(-n[0], n[1]) + 0.5 * math.pi
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


@kernel()
def hung_arm(route: Any, across: float, y: float, n: Any, m: Any) -> float:
    """Return the angle of an arm on two joints for an anchor at (across, y); ``n`` and ``m`` are scratch."""
    r, h, lead = middle(route, RADIUS), middle(route, ARM), middle(route, LEAD_IN)
    delta = 0.5 * math.atan2(across, -y)
    if int(route[KIND, 0]) == BISECTED:
        return delta
    for _ in range(STEPS):
        s, c = math.sin(delta), math.cos(delta)
        free = touch(across - h * s, y + h * c, r, 1.0, n)
        before = touch(-h * s, h * c - lead, r, -1.0, m)
        slope, stiffness, _ = arm_stiffness(h, s, c, n, free, m, before)
        step = slope / stiffness
        delta -= step
        if abs(step) < 1e-16 * (1.0 + abs(delta)):
            break
    return delta


@kernel()
def turn_with(u: Any, k: Any, n: Any, g: Any, across: float, turning: Any) -> None:
    """Write da/dX of a direction with the normal n (2,) that turns by the gradient g (2,) in its plane."""
    for i in range(3):
        p, q = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            v, w = (j + 1) % 3, (j + 2) % 3
            sideways = (k[p] * u[q] - k[q] * u[p]) * (k[v] * u[w] - k[w] * u[v])
            turning[i, j] = (n[0] * u[i] + n[1] * k[i]) * (g[0] * u[j] + g[1] * k[j])
            turning[i, j] += n[1] / across * sideways


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
    n, m, g = np.empty(2), np.empty(2), np.empty(2)
    s, c = 1.0, 0.0
    rise = y + lead
    straight = max(math.hypot(across, rise), 1e-300)
    past = False
    if kind != ONE_JOINT:
        delta = hung_arm(route, across, y, n, m)
        s, c = math.sin(delta), math.cos(delta)
    free = touch(across - h * s, y + h * c, r, 1.0, n)
    theta = middle(route, THETA)
    if kind != ONE_JOINT:
        before = touch(-h * s, h * c - lead, r, -1.0, m)
        theta = angle_at(m, True)
        if kind == BALANCED and (h - r) * straight >= lead * across:
            # The arm can hang beside the rope; it does where the rope does not pull along it.
            past = not s * (n[1] - m[1]) - c * (m[0] - n[0]) > 1e-6
    wrap = theta - angle_at(n, kind != ONE_JOINT)
    if kind == ONE_JOINT and route[SNUG, 0] == 1.0:
        wrap = max(wrap, 0.0)
    if past or wrap < 0.0:
        # The rope runs past the pulley, straight from C.
        n[0], n[1] = -rise / straight, across / straight
        free, before, wrap = straight, 0.0, 0.0
        past = True
    free = max(free, 1e-300)
    g[0], g[1] = n[0] / free, n[1] / free
    if kind != ONE_JOINT and not past:
        _, stiffness, shift = arm_stiffness(h, s, c, n, free, m, before)
        shift /= free
        if kind == BISECTED:
            square = 2.0 * (across * across + y * y)
            g[0] += shift * y / square
            g[1] -= shift * across / square
        else:
            g[0] -= shift * shift / stiffness * n[0]
            g[1] -= shift * shift / stiffness * n[1]
    for i in range(3):
        a[i] = n[1] * u[i] - n[0] * k[i]
    turn_with(u, k, n, g, across, turning)
    return before + r * wrap + free
