"""Proof of an equilibrium of a point mass: a Krawczyk operator in the pose and the multipliers.

For a set of taut cables the unknowns are p (the pose) and t_i (multipliers, tension over distance).
With e_i = p - A_i the square system is

    (|e_i|^2 - h_i(t_i)^2) / 2 = 0   for each taut cable,      sum t_i e_i - f = 0,

with h_i = l_i for an inextensible cable and h_i = k_i l_i / (k_i - t_i) for an elastic one, which is
tension = k_i (|e_i| - l_i) with tension = t_i |e_i|. Its Jacobian is a saddle matrix that stays regular as
a cable gets stiffer.

References: R. Krawczyk, Computing 4 (1969), 187-201; A. Neumaier, Interval Methods for Systems of
Equations (1990), theorems 5.1.8 and 5.2.2: if K(X) lies in the interior of X, then for every value of the
parameters X holds exactly one zero, and it lies in K(X).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.interval import add, div, mag, mid, mul, sqr, sub
from cdpr_interval.kernels.rounding import down, up

INFLATIONS = 12
"""Tries to find a box that is mapped into itself; each enlarges it, so more would only diverge."""
CONTRACTIONS = 6
"""Most Krawczyk steps after the proof; exact input needs one, wide length ranges a few."""


@njit(cache=True, nogil=True)
def reach(
    elastic: bool,
    length_lo: float,
    length_hi: float,
    k_lo: float,
    k_hi: float,
    w_lo: float,
    w_hi: float,
    t_lo: float,
    t_hi: float,
) -> tuple[float, float]:
    """Enclose h(t): the distance at which a cable has the multiplier t; the line where t reaches k.

    ``w`` encloses k l.
    """
    if not elastic:
        return length_lo, length_hi
    lo, hi = sub(k_lo, k_hi, t_lo, t_hi)
    if not lo > 0.0:
        # t = k - k l / |e| is below k; beyond it h^2 has a branch without meaning.
        return -math.inf, math.inf
    return div(w_lo, w_hi, lo, hi)


@njit(cache=True, nogil=True)
def evaluate(cables: Any, load: Any, taut: Any, m: int, box: Any, arms: Any, out: Any) -> None:
    """Enclose the system over a box.

    Parameters
    ----------
    cables
        ``(elastic, anchors, lengths, k, w)``: (N,) bool, (N, 3, 2), (N, 2), (N, 2), (N, 2).
    load : (3, 2)
        Enclosure of f.
    taut : (>= m,)
        Cable indices.
    box : (3 + m, 2)
        p, then t.
    arms : (m, 3, 2)
        Written: e_i.
    out : (3 + m, 2)
        Written: the m length equations, then the three force equations.
    """
    elastic, anchors, lengths, k, w = cables
    for j in range(3):
        out[m + j, 0], out[m + j, 1] = -load[j, 1], -load[j, 0]
    for i in range(m):
        c = taut[i]
        slo, shi = 0.0, 0.0
        for j in range(3):
            lo, hi = sub(box[j, 0], box[j, 1], anchors[c, j, 0], anchors[c, j, 1])
            arms[i, j, 0], arms[i, j, 1] = lo, hi
            qlo, qhi = sqr(lo, hi)
            slo, shi = add(slo, shi, qlo, qhi)
            lo, hi = mul(box[3 + i, 0], box[3 + i, 1], lo, hi)
            out[m + j, 0], out[m + j, 1] = add(out[m + j, 0], out[m + j, 1], lo, hi)
        hlo, hhi = reach(
            elastic[c],
            lengths[c, 0],
            lengths[c, 1],
            k[c, 0],
            k[c, 1],
            w[c, 0],
            w[c, 1],
            box[3 + i, 0],
            box[3 + i, 1],
        )
        hlo, hhi = sqr(hlo, hhi)
        lo, hi = sub(slo, shi, hlo, hhi)
        out[i, 0], out[i, 1] = 0.5 * lo, 0.5 * hi


@njit(cache=True, nogil=True)
def compliance(cables: Any, c: int, t_lo: float, t_hi: float) -> tuple[float, float]:
    """Enclose d/dt (-h(t)^2 / 2) = -h^2 / (k - t) of cable ``c``."""
    elastic, _, lengths, k, w = cables
    if not elastic[c]:
        return 0.0, 0.0
    lo, hi = reach(True, lengths[c, 0], lengths[c, 1], k[c, 0], k[c, 1], w[c, 0], w[c, 1], t_lo, t_hi)
    lo, hi = sqr(lo, hi)
    klo, khi = sub(k[c, 0], k[c, 1], t_lo, t_hi)
    lo, hi = div(lo, hi, klo, khi)
    return -hi, -lo


@njit(cache=True, nogil=True)
def invert_at(cables: Any, taut: Any, m: int, x: Any, inverse: Any) -> bool:
    """Write an approximate inverse of the Jacobian at the floats ``x``; False where it is singular."""
    anchors = cables[1]
    n = 3 + m
    work = np.zeros((n, 2 * n))
    total = 0.0
    for i in range(m):
        c = taut[i]
        total += x[3 + i]
        for j in range(3):
            e = x[j] - mid(anchors[c, j, 0], anchors[c, j, 1])
            work[i, j] = e
            work[m + j, 3 + i] = e
        lo, hi = compliance(cables, c, x[3 + i], x[3 + i])
        work[i, 3 + i] = mid(lo, hi)
    for j in range(3):
        work[m + j, j] = total
    for i in range(n):
        work[i, n + i] = 1.0
    if not solve_in_place(work, n, n):
        return False
    for i in range(n):
        for j in range(n):
            v = work[i, n + j]
            if not abs(v) < 1e200:
                return False
            inverse[i, j] = v
    return True


@njit(cache=True, nogil=True)
def deviation(cables: Any, taut: Any, m: int, box: Any, arms: Any, inverse: Any, magnitude: Any) -> None:
    """Write upper bounds of |I - C J| over a box whose arms are given, entry by entry."""
    n = 3 + m
    tlo, thi = 0.0, 0.0
    for i in range(m):
        tlo, thi = add(tlo, thi, box[3 + i, 0], box[3 + i, 1])
    for r in range(n):
        for j in range(3):
            slo, shi = mul(inverse[r, m + j], inverse[r, m + j], tlo, thi)
            for i in range(m):
                lo, hi = mul(inverse[r, i], inverse[r, i], arms[i, j, 0], arms[i, j, 1])
                slo, shi = add(slo, shi, lo, hi)
            d = 1.0 if r == j else 0.0
            slo, shi = sub(d, d, slo, shi)
            magnitude[r, j] = mag(slo, shi)
        for i in range(m):
            clo, chi = compliance(cables, taut[i], box[3 + i, 0], box[3 + i, 1])
            slo, shi = mul(inverse[r, i], inverse[r, i], clo, chi)
            for j in range(3):
                lo, hi = mul(inverse[r, m + j], inverse[r, m + j], arms[i, j, 0], arms[i, j, 1])
                slo, shi = add(slo, shi, lo, hi)
            d = 1.0 if r == 3 + i else 0.0
            slo, shi = sub(d, d, slo, shi)
            magnitude[r, 3 + i] = mag(slo, shi)


@njit(cache=True, nogil=True)
def spread(x: Any, radius: Any, n: int, box: Any) -> None:
    """Write a box that holds x +- radius."""
    for i in range(n):
        box[i, 0] = down(x[i] - radius[i])
        box[i, 1] = up(x[i] + radius[i])


@njit(cache=True, nogil=True)
def krawczyk(cables: Any, load: Any, taut: Any, m: int, x: Any, cover: Any, box: Any, domain: Any) -> bool:
    """Prove the equilibrium of a taut set near a guess and enclose it to the float limit.

    Parameters
    ----------
    cables, load, taut, m
        See `evaluate`; 1 <= m.
    x : (3 + m,)
        Guess: p, then t. Improved by Newton steps in floats.
    cover : (3 + m, 2)
        A box the domain must contain; rows (inf, -inf) ask for nothing.
    box : (3 + m, 2)
        Written: an enclosure of the zero for all parameters in ``cables`` and ``load``.
    domain : (3 + m, 2)
        Written: the box in which the zero is unique.

    Returns
    -------
    bool
        True: for every value of the parameters the system has exactly one zero in ``domain``, the
        Jacobian is regular there, and the zero lies in ``box``. False: nothing is claimed.
    """
    n = 3 + m
    arms = np.empty((m, 3, 2))
    value = np.empty((n, 2))
    inverse = np.empty((n, n))
    magnitude = np.empty((n, n))
    shift = np.empty((n, 2))
    first = np.empty(n)
    radius = np.empty(n)
    image = np.empty(n)
    for _ in range(2):
        for i in range(n):
            box[i, 0], box[i, 1] = x[i], x[i]
        if not invert_at(cables, taut, m, x, inverse):
            return False
        evaluate(cables, load, taut, m, box, arms, value)
        for r in range(n):
            step = 0.0
            for i in range(n):
                step += inverse[r, i] * (0.5 * value[i, 0] + 0.5 * value[i, 1])
            image[r] = x[r] - step
        for r in range(n):
            if not abs(image[r]) < 1e200:
                return False
            x[r] = image[r]
    for i in range(n):
        box[i, 0], box[i, 1] = x[i], x[i]
    if not invert_at(cables, taut, m, x, inverse):
        return False
    evaluate(cables, load, taut, m, box, arms, value)
    for r in range(n):
        slo, shi = 0.0, 0.0
        for i in range(n):
            lo, hi = mul(inverse[r, i], inverse[r, i], value[i, 0], value[i, 1])
            slo, shi = add(slo, shi, lo, hi)
        shift[r, 0], shift[r, 1] = -shi, -slo
        first[r] = mag(slo, shi)
        radius[r] = 1.5 * first[r] + 1e-17 * abs(x[r]) + 1e-300
        radius[r] = max(radius[r], 1.01 * max(up(x[r] - cover[r, 0]), up(cover[r, 1] - x[r])))
    proved = False
    for _ in range(INFLATIONS):
        spread(x, radius, n, box)
        evaluate(cables, load, taut, m, box, arms, value)
        deviation(cables, taut, m, box, arms, inverse, magnitude)
        inside = True
        for r in range(n):
            total = first[r]
            for i in range(n):
                total = up(total + up(magnitude[r, i] * radius[i]))
            image[r] = total
            # Strictly inside; a NaN fails the comparison.
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
    for step_ in range(CONTRACTIONS):
        # Every zero of the domain lies in x + shift +- |I - C J| radius, hence in x +- image.
        gain = False
        for r in range(n):
            if image[r] < 0.99 * radius[r]:
                gain = True
            radius[r] = min(image[r], radius[r])
        if step_ > 0 and not gain:
            break
        spread(x, radius, n, box)
        evaluate(cables, load, taut, m, box, arms, value)
        deviation(cables, taut, m, box, arms, inverse, magnitude)
        for r in range(n):
            total = 0.0
            for i in range(n):
                total = up(total + up(magnitude[r, i] * radius[i]))
            image[r] = min(up(first[r] + total), radius[r])
            box[r, 0] = max(box[r, 0], down(x[r] + down(shift[r, 0] - total)))
            box[r, 1] = min(box[r, 1], up(x[r] + up(shift[r, 1] + total)))
    return True
