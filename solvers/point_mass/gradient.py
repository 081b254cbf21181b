"""The gradient of the energy of a point mass on springs in interval arithmetic.

E(p) = sum k_i / 2 max(0, |p - A_i| - l_i)^2 - f . p is convex and grows without bound, and where its gradient

    F(p) = sum max(0, k_i - k_i l_i / |p - A_i|) (p - A_i) - f

vanishes some cable is taut (f is not zero) and E is strictly convex: there is exactly one zero. F is
Lipschitz; between two points of a box its increments are (p - q) times a matrix of the hull of its
generalised Jacobians (F. H. Clarke, Optimization and Nonsmooth Analysis, 1983, proposition 2.6.5), in
which a cable that is taut in a part of the box only enters with every weight from 0 to 1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.interval import add, div, mag, mul, sqr, sub
from cdpr_interval.kernels.rounding import down, up
from solvers.point_mass.fields import distance
from solvers.point_mass.system import CONTRACTIONS, INFLATIONS, spread


@njit(cache=True, nogil=True)
def multiplier(cables: Any, c: int, box: Any) -> tuple[float, float, float, float]:
    """Enclose max(0, k - k l / rho) over a box, and return the bounds of rho where the cable may be taut.

    (0, 0, 1, 1) when the cable is slack on the whole box.
    """
    _, anchors, lengths, k, w = cables
    near, far = distance(anchors, c, box)
    if far <= lengths[c, 0]:
        return 0.0, 0.0, 1.0, 1.0
    near = max(near, lengths[c, 0])
    lo, hi = div(w[c, 0], w[c, 1], near, far)
    lo, hi = sub(k[c, 0], k[c, 1], lo, hi)
    return max(lo, 0.0), max(hi, 0.0), near, far


@njit(cache=True, nogil=True)
def gradient_bounds(cables: Any, load: Any, box: Any, out: Any) -> None:
    """Write an enclosure (3, 2) of F over a box."""
    _, anchors, lengths, _, _ = cables
    for j in range(3):
        out[j, 0], out[j, 1] = -load[j, 1], -load[j, 0]
    for c in range(lengths.shape[0]):
        tlo, thi, _, _ = multiplier(cables, c, box)
        if thi == 0.0:
            continue
        for j in range(3):
            lo, hi = sub(box[j, 0], box[j, 1], anchors[c, j, 0], anchors[c, j, 1])
            lo, hi = mul(tlo, thi, lo, hi)
            out[j, 0], out[j, 1] = add(out[j, 0], out[j, 1], lo, hi)


@njit(cache=True, nogil=True)
def curvature(cables: Any, box: Any, out: Any) -> None:
    """Write an enclosure (3, 3, 2) of all generalised Jacobians of F over a box."""
    _, anchors, lengths, _, w = cables
    e = np.empty((3, 2))
    out[:, :, :] = 0.0
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
            e[j, 0], e[j, 1] = sub(box[j, 0], box[j, 1], anchors[c, j, 0], anchors[c, j, 1])
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


@njit(cache=True, nogil=True)
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
    n = 3
    value = np.empty((3, 2))
    matrix = np.empty((3, 3, 2))
    work = np.empty((3, 6))
    magnitude = np.empty((3, 3))
    shift = np.empty((3, 2))
    first = np.empty(3)
    radius = np.empty(3)
    image = np.empty(3)
    for attempt in range(2):
        for j in range(3):
            box[j, 0], box[j, 1] = x[j], x[j]
        gradient_bounds(cables, load, box, value)
        if attempt == 1:
            # The middle of the generalised Jacobians around the point, not one side of a kink.
            for j in range(3):
                r = 2.0 * first[j] + 1e-14 * abs(x[j]) + 1e-300
                box[j, 0], box[j, 1] = min(x[j] - r, cover[j, 0]), max(x[j] + r, cover[j, 1])
        curvature(cables, box, matrix)
        for a in range(3):
            for b in range(3):
                work[a, b] = 0.5 * matrix[a, b, 0] + 0.5 * matrix[a, b, 1]
                work[a, 3 + b] = 1.0 if a == b else 0.0
        if not solve_in_place(work, 3, 3):
            return False
        for r in range(n):
            slo, shi = 0.0, 0.0
            for i in range(n):
                c = work[r, n + i]
                lo, hi = mul(c, c, value[i, 0], value[i, 1])
                slo, shi = add(slo, shi, lo, hi)
            shift[r, 0], shift[r, 1] = -shi, -slo
            first[r] = mag(slo, shi)
            if not first[r] < 1e200:
                return False
        if attempt == 0:
            for r in range(n):
                x[r] += 0.5 * shift[r, 0] + 0.5 * shift[r, 1]
                first[r] = 0.5 * (shift[r, 1] - shift[r, 0])
    for r in range(n):
        radius[r] = 1.5 * first[r] + 1e-17 * abs(x[r]) + 1e-300
        radius[r] = max(radius[r], 1.01 * max(up(x[r] - cover[r, 0]), up(cover[r, 1] - x[r])))
    proved = False
    for _ in range(INFLATIONS):
        spread(x, radius, n, box)
        deviate(cables, box, work, magnitude)
        inside = True
        for r in range(n):
            total = first[r]
            for i in range(n):
                total = up(total + up(magnitude[r, i] * radius[i]))
            image[r] = total
            if not total < radius[r]:
                inside = False
        if inside:
            proved = True
            break
        for r in range(n):
            if not image[r] < 1e200:
                return False
            radius[r] = max(1.2 * image[r], radius[r])
    if not proved:
        return False
    for i in range(n):
        domain[i, 0], domain[i, 1] = box[i, 0], box[i, 1]
    for _ in range(CONTRACTIONS):
        for r in range(n):
            radius[r] = min(image[r], radius[r])
        spread(x, radius, n, box)
        deviate(cables, box, work, magnitude)
        for r in range(n):
            total = 0.0
            for i in range(n):
                total = up(total + up(magnitude[r, i] * radius[i]))
            image[r] = min(up(first[r] + total), radius[r])
            box[r, 0] = max(box[r, 0], down(x[r] + down(shift[r, 0] - total)))
            box[r, 1] = min(box[r, 1], up(x[r] + up(shift[r, 1] + total)))
    return True


@njit(cache=True, nogil=True)
def deviate(cables: Any, box: Any, work: Any, magnitude: Any) -> None:
    """Write upper bounds of |I - C H| over a box, C in columns 3..5 of ``work``."""
    matrix = np.empty((3, 3, 2))
    curvature(cables, box, matrix)
    for r in range(3):
        for j in range(3):
            d = 1.0 if r == j else 0.0
            slo, shi = 0.0, 0.0
            for i in range(3):
                c = work[r, 3 + i]
                lo, hi = mul(c, c, matrix[i, j, 0], matrix[i, j, 1])
                slo, shi = add(slo, shi, lo, hi)
            slo, shi = sub(d, d, slo, shi)
            magnitude[r, j] = mag(slo, shi)
