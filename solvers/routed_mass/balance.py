"""The static pose of a point mass on routed cables: its equations, and the proof of a zero.

Unknowns are the position X and the tensions T of the inextensible cables that are taut. With L_i the lengths
of the ways, a_i their directions and k_i the spring constants, the equations are

sum over elastic cables of k_i max(0, L_i(X) - l_i) a_i(X)  +  sum T_j a_j(X) - f = 0,    L_j(X) - l_j = 0.

The first are Lipschitz; between two points of a box their increments lie in the hull of the generalised
Jacobians (F. H. Clarke, Optimization and Nonsmooth Analysis, 1983, proposition 2.6.5), in which a cable that
is taut in a part of the box only enters with every weight from 0 to 1.

Arrays, for N cables of which m inextensible ones are taut, n = 3 + m: ``data`` is a
`solvers.routed_mass.data.Routed`; ``taut`` (>= m,) are their indices; ``box`` (n, 2) bounds X, then T;
``ways`` (N, WAY, 2) and ``gradients`` (N, 3, 2) are those over its position, ``turning`` (3, 3, 2)
scratch; ``J`` and ``E`` (n, n, 2); ``C`` (n, n); ``x`` (n,) a guess.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.engine.krawczyk import (
    LOST,
    Contractions,
    Tries,
    around,
    correction,
    deviation,
    preconditioner,
)
from cdpr_interval.kernels.box import point
from cdpr_interval.kernels.interval import add, mid, mul, sub
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.mechanics.cables.rows import ALONG, BISECTED, FIXED, FREE, KIND, LENGTH, WAY, WRAP
from cdpr_interval.mechanics.cables.ways import CUT, gradient_over, turning_over, way_over

TRIES = Tries(boxes=12, growth=1.2, kept=1.0)
"""Each box tried is larger, so more would only diverge."""
CONTRACTIONS = Contractions(most=6, gain=0.9)
"""Exact input needs one, wide ranges a few."""
CORRECTIONS = 3
"""Newton steps before a proof, with one preconditioner: guesses are near."""
CORRECTED = 1e-14
"""A step of this share of the unknowns is the last."""


@kernel()
def survey(data: Any, box: Any, ways: Any, gradients: Any) -> bool:
    """Write ways and gradients over a box of positions; False: all of it lies inside a pulley."""
    routes = data[0]
    for i in range(routes.shape[0]):
        if not way_over(routes[i], box, ways[i]):
            return False
        gradient_over(routes[i], ways[i], gradients[i])
    return True


@kernel()
def pull(data: Any, i: int, way: Any) -> tuple[float, float, float, float]:
    """Enclose the tension of an elastic cable over a box with this way (WAY, 2), and its weight in J."""
    _, _, lengths, k, _ = data
    lo, hi = sub(way[LENGTH, 0], way[LENGTH, 1], lengths[i, 0], lengths[i, 1])
    if hi <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    weight = 1.0 if lo > 0.0 else 0.0
    lo, hi = mul(k[i, 0], k[i, 1], max(lo, 0.0), hi)
    return max(lo, 0.0), hi, weight, 1.0


@kernel()
def residual(context: Any, box: Any, out: Any) -> None:
    """Enclose the equations (n, 2) over a box (n, 2); the context is ``(data, taut, C)``."""
    data, taut, C = context
    routes, elastic, lengths, _, load = data
    ways, gradients = np.empty((routes.shape[0], WAY, 2)), np.empty((routes.shape[0], 3, 2))
    n = C.shape[0]
    if not survey(data, box, ways, gradients):
        for r in range(n):
            out[r, 0], out[r, 1] = -math.inf, math.inf
        return
    for j in range(3):
        out[j, 0], out[j, 1] = -load[j, 1], -load[j, 0]
    for i in range(routes.shape[0]):
        if elastic[i]:
            tlo, thi, _, _ = pull(data, i, ways[i])
            if thi > 0.0:
                put(ways[i], tlo, thi, out)
    for b in range(n - 3):
        way = ways[taut[b]]
        put(way, box[3 + b, 0], box[3 + b, 1], out)
        length = lengths[taut[b]]
        out[3 + b, 0], out[3 + b, 1] = sub(way[LENGTH, 0], way[LENGTH, 1], length[0], length[1])


@kernel()
def put(way: Any, tlo: float, thi: float, out: Any) -> None:
    """Add a tension along a way (WAY, 2) to the first three rows of out (>= 3, 2)."""
    for j in range(3):
        lo, hi = mul(tlo, thi, way[ALONG + j, 0], way[ALONG + j, 1])
        out[j, 0], out[j, 1] = add(out[j, 0], out[j, 1], lo, hi)


@kernel()
def smooth(way: Any) -> bool:
    """Return True when a way (WAY, 2) ends outside its pulley everywhere and its length has no jump.

    It has one where the angle at which the rope leaves is cut, by a turn around the pulley.
    """
    return way[FREE, 0] > 0.0 and way[WRAP, 1] - way[WRAP, 0] < CUT


@kernel()
def is_off(route: Any, way: Any) -> bool:
    """Return True when all of a box with this way (WAY, 2) lies outside of its pulley, if it has one."""
    return route[KIND, 0] == FIXED or way[FREE, 0] > 0.0


@kernel()
def off_pulleys(data: Any, ways: Any) -> bool:
    """Return True when all of a box with these ways (N, WAY, 2) lies outside of every pulley."""
    for i in range(ways.shape[0]):  # noqa: SIM110 - numba compiles no generator expressions
        if not is_off(data[0][i], ways[i]):
            return False
    return True


@kernel()
def jacobian(data: Any, taut: Any, box: Any, J: Any) -> bool:
    """Enclose the generalised Jacobians J (n, n, 2) over a box; False where a loaded way is not `smooth`."""
    routes, elastic, _, k, _ = data
    ways, gradients = np.empty((routes.shape[0], WAY, 2)), np.empty((routes.shape[0], 3, 2))
    turning = np.empty((3, 3, 2))
    n = J.shape[0]
    J[:] = 0.0
    if not survey(data, box, ways, gradients):
        return False
    for i in range(routes.shape[0]):
        if not elastic[i]:
            continue
        tlo, thi, wlo, whi = pull(data, i, ways[i])
        if whi == 0.0:
            continue
        if not smooth(ways[i]):
            return False
        turning_over(routes[i], ways[i], turning)
        klo, khi = mul(k[i, 0], k[i, 1], wlo, whi)
        for a in range(3):
            for b in range(3):
                lo, hi = mul(
                    ways[i, ALONG + a, 0], ways[i, ALONG + a, 1], gradients[i, b, 0], gradients[i, b, 1]
                )
                if a == b and routes[i, KIND, 0] != BISECTED:
                    lo = max(lo, 0.0)
                lo, hi = mul(klo, khi, lo, hi)
                J[a, b, 0], J[a, b, 1] = add(J[a, b, 0], J[a, b, 1], lo, hi)
        bend(turning, tlo, thi, J)
    for c in range(n - 3):
        i = taut[c]
        if not smooth(ways[i]):
            return False
        turning_over(routes[i], ways[i], turning)
        bend(turning, box[3 + c, 0], box[3 + c, 1], J)
        for a in range(3):
            J[a, 3 + c, 0], J[a, 3 + c, 1] = ways[i, ALONG + a, 0], ways[i, ALONG + a, 1]
            J[3 + c, a, 0], J[3 + c, a, 1] = gradients[i, a, 0], gradients[i, a, 1]
    return True


@kernel()
def bend(turning: Any, tlo: float, thi: float, J: Any) -> None:
    """Add a tension times da/dX (3, 3, 2) to the upper left block of J (n, n, 2)."""
    for a in range(3):
        for b in range(3):
            lo, hi = mul(tlo, thi, turning[a, b, 0], turning[a, b, 1])
            J[a, b, 0], J[a, b, 1] = add(J[a, b, 0], J[a, b, 1], lo, hi)


@kernel()
def deviate(context: Any, box: Any, E: Any) -> None:
    """Enclose I - C J in E (n, n, 2) over a box (n, 2), see `cdpr_interval.engine.krawczyk`."""
    data, taut, C = context
    J = np.empty(E.shape)
    if jacobian(data, taut, box, J):
        deviation(C, J, E)
    else:
        E[:, :, 0] = -math.inf
        E[:, :, 1] = math.inf


@entry()
def prove_balance(data: Any, taut: Any, x: Any, cover: Any, box: Any, domain: Any) -> bool:
    """Prove and enclose the zero near a guess.

    Parameters
    ----------
    data, taut
        See above; ``x`` has n = 3 + m entries.
    x : (n,)
        Guess, improved by Newton steps in floats.
    cover : (n, 2)
        A box the domain must contain; rows (inf, -inf) ask for nothing.
    box, domain : (n, 2)
        Written, see the guarantee.

    Guarantee
    ---------
    True: for all data in their ranges the equations have exactly one zero in ``domain``, all generalised
    Jacobians there are regular, and the zero lies in ``box``.
    """
    n = x.shape[0]
    C, J = np.empty((n, n)), np.empty((n, n, 2))
    value, shift = np.empty((n, 2)), np.empty((n, 2))
    context = (data, taut, C)
    for r in range(n):
        # The middle of the generalised Jacobians around the zero, not one side of a kink.
        reach = 1e-12 * abs(x[r]) + 1e-300
        box[r, 0], box[r, 1] = min(x[r] - reach, cover[r, 0]), max(x[r] + reach, cover[r, 1])
    if not jacobian(data, taut, box, J) or not preconditioner(J, C):
        return False
    for _ in range(CORRECTIONS):
        point(x, box)
        residual(context, box, value)
        correction(C, value, shift)
        moved = False
        for r in range(n):
            if not abs(shift[r, 0]) + abs(shift[r, 1]) < LOST:
                return False
            moved = moved or abs(mid(shift[r, 0], shift[r, 1])) > CORRECTED * (1.0 + abs(x[r]))
        if not moved:
            break
        for r in range(n):
            x[r] += mid(shift[r, 0], shift[r, 1])
    if moved:
        point(x, box)
        residual(context, box, value)
        correction(C, value, shift)
    return around(deviate, context, x, shift, cover, (TRIES, CONTRACTIONS), box, domain)
