"""Proof of an equilibrium of a point mass: a Krawczyk operator in the pose and the multipliers.

For a set of taut cables the unknowns are p (the pose) and t_i (multipliers, tension over distance).
With e_i = p - A_i the square system is

    (|e_i|^2 - h_i(t_i)^2) / 2 = 0   for each taut cable,      sum t_i e_i - f = 0,

with h_i = l_i for an inextensible cable and h_i = k_i l_i / (k_i - t_i) for an elastic one, which is
tension = k_i (|e_i| - l_i) with tension = t_i |e_i|. Its Jacobian is a saddle matrix that stays regular as
a cable gets stiffer.

Arrays, for N cables of which m are taut: ``cables`` is an ``arrays.Cables``, ``context`` is ``(cables,
load, taut, spokes, C)``, see `residual`; ``exits`` (N, 3, 2); ``spokes`` (m, 3, 2) are e_i; ``box`` (3 + m,
2) bounds p, then t; ``C`` (3 + m, 3 + m).

References: R. Krawczyk, Computing 4 (1969), 187-201; A. Neumaier, Interval Methods for Systems of
Equations (1990), theorems 5.1.8 and 5.2.2: if K(X) lies in the interior of X, then for every value of the
parameters X holds exactly one zero, and it lies in K(X).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr_interval.engine.krawczyk import LOST, Contractions, Tries, around, correction
from cdpr_interval.engine.newton import Pace, newton
from cdpr_interval.kernels.box import point
from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.interval import add, mid, mul, scale, sqr, sub
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.mechanics.cables.compiled import compliance, reach

NEWTON_STEPS = 2
"""The guesses are near: two steps give the digits that are left."""
PACE = Pace()
"""Both steps are made, each with its own derivative."""
TRIES = Tries(boxes=12, growth=1.2, kept=1.0)
"""Each box tried is larger, so more would only diverge."""
CONTRACTIONS = Contractions(most=6, gain=0.99)
"""Exact input needs one, wide length ranges a few."""


@kernel("void(f8[:, :, ::1], i8[::1], i8, f8[:, ::1], f8[:, :, ::1])")
def spokes_over(exits: Any, taut: Any, m: int, box: Any, spokes: Any) -> None:
    """Enclose e_i = p - A_i in spokes (m, 3, 2), for m cables of ``taut`` (>= m,), over a box (>= 3, 2)."""
    for i in range(m):
        for j in range(3):
            lo, hi = exits[taut[i], j, 0], exits[taut[i], j, 1]
            spokes[i, j, 0], spokes[i, j, 1] = sub(box[j, 0], box[j, 1], lo, hi)


@entry()
def evaluate(cables: Any, load: Any, taut: Any, m: int, box: Any, spokes: Any, out: Any) -> None:
    """Enclose the system over a box.

    Parameters
    ----------
    cables
        ``(elastic, exits, lengths, k, w)``: (N,) bool, (N, 3, 2), (N, 2), (N, 2), (N, 2).
    load : (3, 2)
        Enclosure of f.
    taut : (>= m,)
        Cable indices.
    box : (3 + m, 2)
        p, then t.
    spokes : (m, 3, 2)
        Written: e_i.
    out : (3 + m, 2)
        Written: the m length equations, then the three force equations.
    """
    exits = cables[1]
    spokes_over(exits, taut, m, box, spokes)
    for j in range(3):
        out[m + j, 0], out[m + j, 1] = -load[j, 1], -load[j, 0]
    for i in range(m):
        c = taut[i]
        slo, shi = 0.0, 0.0
        for j in range(3):
            lo, hi = spokes[i, j, 0], spokes[i, j, 1]
            qlo, qhi = sqr(lo, hi)
            slo, shi = add(slo, shi, qlo, qhi)
            lo, hi = mul(box[3 + i, 0], box[3 + i, 1], lo, hi)
            out[m + j, 0], out[m + j, 1] = add(out[m + j, 0], out[m + j, 1], lo, hi)
        hlo, hhi = reach(cables, c, box[3 + i, 0], box[3 + i, 1])
        hlo, hhi = sqr(hlo, hhi)
        lo, hi = sub(slo, shi, hlo, hhi)
        out[i, 0], out[i, 1] = 0.5 * lo, 0.5 * hi


@kernel()
def residual(context: Any, box: Any, out: Any) -> None:
    """Enclose the system (3 + m, 2) over a box (3 + m, 2), see `cdpr_interval.engine.krawczyk`.

    The context is ``(cables, load, taut, spokes, C)``: see `evaluate`, and C (3 + m, 3 + m).
    """
    cables, load, taut, spokes, C = context
    evaluate(cables, load, taut, C.shape[0] - 3, box, spokes, out)


@kernel()
def linearise(context: Any, box: Any, out: Any, C: Any) -> bool:
    """Write the system (3 + m, 2) and an approximate inverse C of its Jacobian at a point (3 + m, 2).

    False where that is singular. See `cdpr_interval.engine.newton`.
    """
    cables, _, taut, _, _ = context
    exits = cables[1]
    n = C.shape[0]
    m = n - 3
    work = np.zeros((n, 2 * n))
    total = 0.0
    for i in range(m):
        c = taut[i]
        t = box[3 + i, 0]
        total += t
        for j in range(3):
            e = box[j, 0] - mid(exits[c, j, 0], exits[c, j, 1])
            work[i, j] = e
            work[m + j, 3 + i] = e
        lo, hi = compliance(cables, c, t, t)
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
            if not abs(v) < LOST:
                return False
            C[i, j] = v
    residual(context, box, out)
    return True


@kernel()
def deviate(context: Any, box: Any, E: Any) -> None:
    """Enclose I - C J in E (3 + m, 3 + m, 2) over a box (3 + m, 2); context as `residual`."""
    cables, _, taut, spokes, C = context
    n = C.shape[0]
    m = n - 3
    spokes_over(cables[1], taut, m, box, spokes)
    tlo, thi = 0.0, 0.0
    for i in range(m):
        tlo, thi = add(tlo, thi, box[3 + i, 0], box[3 + i, 1])
    for r in range(n):
        for j in range(3):
            slo, shi = scale(C[r, m + j], tlo, thi)
            for i in range(m):
                lo, hi = scale(C[r, i], spokes[i, j, 0], spokes[i, j, 1])
                slo, shi = add(slo, shi, lo, hi)
            d = 1.0 if r == j else 0.0
            E[r, j, 0], E[r, j, 1] = sub(d, d, slo, shi)
        for i in range(m):
            clo, chi = compliance(cables, taut[i], box[3 + i, 0], box[3 + i, 1])
            slo, shi = scale(C[r, i], clo, chi)
            for j in range(3):
                lo, hi = scale(C[r, m + j], spokes[i, j, 0], spokes[i, j, 1])
                slo, shi = add(slo, shi, lo, hi)
            d = 1.0 if r == 3 + i else 0.0
            E[r, 3 + i, 0], E[r, 3 + i, 1] = sub(d, d, slo, shi)


@entry()
def krawczyk(cables: Any, load: Any, taut: Any, m: int, x: Any, cover: Any, box: Any, domain: Any) -> bool:
    """Prove the equilibrium of a taut set near a guess and enclose it to the float limit.

    Parameters
    ----------
    cables, load, taut, m
        See `evaluate`; 1 <= m.
    x : (>= 3 + m,)
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
    C, value, shift = np.empty((n, n)), np.empty((n, 2)), np.empty((n, 2))
    context = (cables, load, taut, np.empty((m, 3, 2)), C)
    if not newton(linearise, residual, context, x, C, NEWTON_STEPS, PACE) < LOST:
        return False
    point(x, box)
    if not linearise(context, box, value, C):
        return False
    correction(C, value, shift)
    return around(deviate, context, x, shift, cover, (TRIES, CONTRACTIONS), box, domain)
