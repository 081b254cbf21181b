"""Enclosures of the lowest point of balls that need no guess of the taut cables.

For multipliers t >= 0 with sum T > 0 the Lagrangian -f . p + sum t_i / 2 (|p - A_i|^2 - l_i^2) is
d + T / 2 |p - c|^2 with c = (f + sum t_i A_i) / T. At the lowest point p* it is at most -f . p*, which
is at most -f . q for every point q of all balls. So T / 2 |p* - c|^2 <= -f . q - d: a ball around c, as
small as the duality gap allows, whatever cables are taut, for all lengths in their ranges.

Arrays: ``cables`` is an ``arrays.Cables``; ``load`` (3, 2); ``box`` (3, 2) of positions; ``q`` (3,) a
point.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.kernels.interval import add, div, mul, sqr, sub
from cdpr_interval.kernels.kernel import entry
from cdpr_interval.kernels.rounding import down, up
from solvers.point_mass.fields import distance


@entry()
def inside_all(cables: Any, q: Any) -> bool:
    """Prove that a point (3,) is strictly inside every ball, for all lengths and exit points."""
    _, exits, lengths, _, _ = cables
    box = np.empty((3, 2))
    for j in range(3):
        box[j, 0], box[j, 1] = q[j], q[j]
    for i in range(lengths.shape[0]):  # noqa: SIM110 - numba compiles no generator expressions
        if not distance(exits, i, box)[1] < lengths[i, 0]:
            return False
    return True


@entry()
def feasible_near(cables: Any, p: Any, deep: Any, q: Any) -> bool:
    """Write the point nearest to ``p`` on the way to ``deep`` that is proved inside every ball.

    ``p, deep`` : (3,).
    """
    step = 1e-17
    while step < 1.0:
        for j in range(3):
            q[j] = p[j] + step * (deep[j] - p[j])
        if inside_all(cables, q):
            return True
        step *= 2.0
    for j in range(3):
        q[j] = deep[j]
    return inside_all(cables, q)


@entry()
def duality_box(cables: Any, load: Any, t: Any, q: Any, box: Any) -> bool:
    """Enclose the lowest point of all balls.

    Parameters
    ----------
    cables, load
        See `solvers.point_mass.system.evaluate`; inextensible.
    t : (N,)
        Any multipliers >= 0 that are not all zero; good ones give a small box.
    q : (3,)
        A point proved to lie in all balls for all lengths.
    box : (3, 2)
        Written.

    Returns
    -------
    bool
        False when overflow leaves no bound.

    Guarantee
    ---------
    For all parameters in their ranges, the lowest point of the balls lies in ``box``.
    """
    _, exits, lengths, _, _ = cables
    tlo, thi = 0.0, 0.0
    for i in range(t.shape[0]):
        tlo, thi = add(tlo, thi, t[i], t[i])
    gap = 0.0
    for j in range(3):
        slo, shi = load[j, 0], load[j, 1]
        for i in range(t.shape[0]):
            lo, hi = mul(t[i], t[i], exits[i, j, 0], exits[i, j, 1])
            slo, shi = add(slo, shi, lo, hi)
        box[j, 0], box[j, 1] = div(slo, shi, tlo, thi)
        lo, hi = sub(box[j, 0], box[j, 1], q[j], q[j])
        lo, hi = mul(load[j, 0], load[j, 1], lo, hi)
        gap = up(gap + hi)
    for i in range(t.shape[0]):
        slo, shi = sqr(lengths[i, 0], lengths[i, 1])
        dlo, dhi = sqr(*distance(exits, i, box))
        lo, hi = sub(slo, shi, dlo, dhi)
        lo, hi = mul(0.5 * t[i], 0.5 * t[i], lo, hi)
        gap = up(gap + hi)
    # The gap is non-negative in exact arithmetic.
    radius = up(math.sqrt(up(up(2.0 * max(gap, 0.0)) / tlo)))
    if not radius < 1e200:
        return False
    for j in range(3):
        box[j, 0] = down(box[j, 0] - radius)
        box[j, 1] = up(box[j, 1] + radius)
    return True


@entry()
def largest_tension(cables: Any, load: Any, box: Any, q: Any, c: int) -> float:
    """Bound the tension cable ``c`` can have when the pose lies in a box, in units of force.

    For a point q strictly inside all balls and any multipliers in balance at p, taking the inner product
    of sum t_i (p - A_i) = f with p - q gives t_c (l_c^2 - |q - A_c|^2) / 2 <= f . (p - q): every taut cable
    contributes t_i (l_i^2 - |q - A_i|^2 + |p - q|^2) / 2 >= 0.
    """
    _, exits, lengths, _, _ = cables
    work = 0.0
    point = np.empty((3, 2))
    for j in range(3):
        point[j, 0], point[j, 1] = q[j], q[j]
        lo, hi = sub(box[j, 0], box[j, 1], q[j], q[j])
        lo, hi = mul(load[j, 0], load[j, 1], lo, hi)
        work = up(work + hi)
    slo, _ = sqr(lengths[c, 0], lengths[c, 1])
    _, dhi = sqr(*distance(exits, c, point))
    margin = down(slo - dhi)
    if not margin > 0.0:
        return math.inf
    t = up(up(2.0 * max(work, 0.0)) / margin)
    return up(t * lengths[c, 1])


@entry()
def closed_form_exists(cables: Any, load: Any, taut: Any, m: int) -> bool:
    """Return False when the spheres of two or three cables provably have no common point.

    ``taut`` : (>= m,) these cables.

    Two spheres: l_i^2 - a^2 with a the distance of the circle's plane from A_i. Three: the square of the
    coordinate along m = d x e is (l_i^2 |m|^2 - |K_2 e - K_3 d|^2) / |m|^2.
    """
    _, exits, lengths, _, _ = cables
    i = taut[0]
    d = np.empty((2, 3, 2))
    offset = np.empty((2, 2))
    square = np.empty((2, 2))
    first = sqr(lengths[i, 0], lengths[i, 1])
    for a in range(1, m):
        c = taut[a]
        slo, shi = 0.0, 0.0
        for j in range(3):
            lo, hi = sub(exits[c, j, 0], exits[c, j, 1], exits[i, j, 0], exits[i, j, 1])
            d[a - 1, j, 0], d[a - 1, j, 1] = lo, hi
            lo, hi = sqr(lo, hi)
            slo, shi = add(slo, shi, lo, hi)
        square[a - 1, 0], square[a - 1, 1] = slo, shi
        lo, hi = add(slo, shi, first[0], first[1])
        qlo, qhi = sqr(lengths[c, 0], lengths[c, 1])
        lo, hi = sub(lo, hi, qlo, qhi)
        offset[a - 1, 0], offset[a - 1, 1] = 0.5 * lo, 0.5 * hi
    if m == 1:
        return True
    if m == 2:
        lo, hi = mul(first[0], first[1], square[0, 0], square[0, 1])
        qlo, qhi = sqr(offset[0, 0], offset[0, 1])
        return not sub(lo, hi, qlo, qhi)[1] < 0.0
    mlo, mhi = 0.0, 0.0
    vlo, vhi = 0.0, 0.0
    for j in range(3):
        a, b = (j + 1) % 3, (j + 2) % 3
        lo, hi = mul(d[0, a, 0], d[0, a, 1], d[1, b, 0], d[1, b, 1])
        qlo, qhi = mul(d[0, b, 0], d[0, b, 1], d[1, a, 0], d[1, a, 1])
        lo, hi = sub(lo, hi, qlo, qhi)
        lo, hi = sqr(lo, hi)
        mlo, mhi = add(mlo, mhi, lo, hi)
        lo, hi = mul(offset[0, 0], offset[0, 1], d[1, j, 0], d[1, j, 1])
        qlo, qhi = mul(offset[1, 0], offset[1, 1], d[0, j, 0], d[0, j, 1])
        lo, hi = sub(lo, hi, qlo, qhi)
        lo, hi = sqr(lo, hi)
        vlo, vhi = add(vlo, vhi, lo, hi)
    lo, hi = mul(first[0], first[1], mlo, mhi)
    return not sub(lo, hi, vlo, vhi)[1] < 0.0
