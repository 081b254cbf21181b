"""The gradient of the energy of a point mass on springs in interval arithmetic.

E(p) = sum k_i / 2 max(0, |p - A_i| - l_i)^2 - f . p is convex and grows without bound, and where its gradient

    F(p) = sum max(0, k_i - k_i l_i / |p - A_i|) (p - A_i) - f

vanishes some cable is taut (f is not zero) and E is strictly convex: there is exactly one zero. F is
Lipschitz; between two points of a box its increments are (p - q) times a matrix of the hull of its
generalised Jacobians (F. H. Clarke, Optimization and Nonsmooth Analysis, 1983, proposition 2.6.5), in
which a cable that is taut in a part of the box only enters with every weight from 0 to 1.

Arrays: ``cables`` is an ``arrays.Cables``; ``load`` (3, 2); ``box`` (3, 2) of positions.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.engine.krawczyk import LOST, Contractions, around, correction, deviation, preconditioner
from cdpr_interval.kernels.box import point
from cdpr_interval.kernels.interval import add, div, mag, mul, sqr, sub
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.mechanics.cables.compiled import density
from solvers.point_mass.fields import distance
from solvers.point_mass.system import TRIES

CONTRACTIONS = Contractions(most=6, gain=math.inf)
"""H jumps where a cable stops being slack anywhere in the box: a step that gains little may be followed by
one that gains much."""


@entry()
def multiplier(cables: Any, c: int, box: Any) -> tuple[float, float, float, float]:
    """Enclose max(0, k - k l / rho) over a box, and return the bounds of rho where the cable may be taut.

    (0, 0, 1, 1) when the cable is slack on the whole box.
    """
    _, exits, lengths, _, _ = cables
    near, far = distance(exits, c, box)
    if far <= lengths[c, 0]:
        return 0.0, 0.0, 1.0, 1.0
    near = max(near, lengths[c, 0])
    lo, hi = density(cables, c, near, far)
    return lo, hi, near, far


@entry()
def gradient_bounds(cables: Any, load: Any, box: Any, out: Any) -> None:
    """Write an enclosure out (3, 2) of F over a box."""
    _, exits, lengths, _, _ = cables
    for j in range(3):
        out[j, 0], out[j, 1] = -load[j, 1], -load[j, 0]
    for c in range(lengths.shape[0]):
        tlo, thi, _, _ = multiplier(cables, c, box)
        if thi == 0.0:
            continue
        for j in range(3):
            lo, hi = sub(box[j, 0], box[j, 1], exits[c, j, 0], exits[c, j, 1])
            lo, hi = mul(tlo, thi, lo, hi)
            out[j, 0], out[j, 1] = add(out[j, 0], out[j, 1], lo, hi)


@entry()
def curvature(cables: Any, box: Any, out: Any) -> None:
    """Write an enclosure out (3, 3, 2) of all generalised Jacobians of F over a box."""
    _, exits, lengths, _, w = cables
    e = np.empty((3, 2))
    for a in range(3):
        for b in range(3):
            out[a, b, 0], out[a, b, 1] = 0.0, 0.0
    for c in range(lengths.shape[0]):
        tlo, thi, near, far = multiplier(cables, c, box)
        if thi == 0.0:
            continue
        # k l / rho^3 times e e^T, with weight [0, 1] where the cable may be slack.
        slo, shi = sqr(near, far)
        slo, shi = mul(slo, shi, near, far)
        slo, shi = div(w[c, 0], w[c, 1], slo, shi)
        if tlo == 0.0:
            slo = 0.0
        for j in range(3):
            e[j, 0], e[j, 1] = sub(box[j, 0], box[j, 1], exits[c, j, 0], exits[c, j, 1])
        for a in range(3):
            for b in range(a, 3):
                if a == b:
                    lo, hi = sqr(e[a, 0], e[a, 1])
                else:
                    lo, hi = mul(e[a, 0], e[a, 1], e[b, 0], e[b, 1])
                lo, hi = mul(slo, shi, lo, hi)
                if a == b:
                    lo, hi = add(lo, hi, tlo, thi)
                out[a, b, 0], out[a, b, 1] = add(out[a, b, 0], out[a, b, 1], lo, hi)
    for a in range(3):
        for b in range(a):
            out[a, b, 0], out[a, b, 1] = out[b, a, 0], out[b, a, 1]


@kernel()
def deviate(context: Any, box: Any, E: Any) -> None:
    """Enclose I - C H in E (3, 3, 2) over a box (3, 2), see `cdpr_interval.engine.krawczyk`.

    The context is ``(cables, C)``: see `solvers.point_mass.system.evaluate`, and C (3, 3).
    """
    cables, C = context
    H = np.empty((3, 3, 2))
    curvature(cables, box, H)
    deviation(C, H, E)


@kernel()
def correction_at(cables: Any, load: Any, x: Any, around_x: Any, C: Any, shift: Any) -> bool:
    """Enclose -C F(x) in shift (3, 2) for x (3,); C (3, 3) inverts the middle of H over ``around_x`` (3, 2).

    False where that is singular. ``cables`` and ``load`` (3, 2) as in `solvers.point_mass.system.evaluate`.
    """
    here, value, H = np.empty((3, 2)), np.empty((3, 2)), np.empty((3, 3, 2))
    point(x, here)
    gradient_bounds(cables, load, here, value)
    curvature(cables, around_x, H)
    if not preconditioner(H, C):
        return False
    correction(C, value, shift)
    for r in range(3):  # noqa: SIM110 - numba compiles no generator expressions
        if not mag(shift[r, 0], shift[r, 1]) < LOST:
            return False
    return True


@entry()
def gradient_krawczyk(cables: Any, load: Any, x: Any, cover: Any, box: Any, domain: Any) -> bool:
    """Prove and enclose the zero of F near a guess.

    Parameters
    ----------
    cables, load
        See `solvers.point_mass.system.evaluate`; all cables elastic.
    x : (3,)
        Guess, improved by one Newton step in floats.
    cover : (3, 2)
        A box the domain must contain; rows (inf, -inf) ask for nothing.
    box, domain : (3, 2)
        Written, see the guarantee.

    Guarantee
    ---------
    True: for all parameters in their ranges F has exactly one zero in ``domain``, and it lies in ``box``.
    """
    C, shift = np.empty((3, 3)), np.empty((3, 2))
    point(x, box)
    if not correction_at(cables, load, x, box, C, shift):
        return False
    for r in range(3):
        x[r] += 0.5 * shift[r, 0] + 0.5 * shift[r, 1]
        # The middle of the generalised Jacobians around the point, not one side of a kink.
        reach = 2.0 * (0.5 * (shift[r, 1] - shift[r, 0])) + 1e-14 * abs(x[r]) + 1e-300
        box[r, 0], box[r, 1] = min(x[r] - reach, cover[r, 0]), max(x[r] + reach, cover[r, 1])
    if not correction_at(cables, load, x, box, C, shift):
        return False
    return around(deviate, (cables, C), x, shift, cover, (TRIES, CONTRACTIONS), box, domain)
