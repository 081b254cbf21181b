"""A static pose while the tension of one cable goes from nothing to some value, compiled: one tube.

Of the cable k, the last of the n that may carry, the density t_k = tau is given instead of its length: the
data are the other lengths and tau. Over a box of them a tube is proved (``mechanics.six_dof.tube``), and
along it

1. the other tensions are positive at tau = 0 and wherever the distance of cable k is not below its shortest
   length, and the cables outside are shorter than their lengths, for every choice;
2. the distance of cable k decreases with tau: d (|e_k|^2) / d tau = g J^-1 e_k < 0 with its gradient g, where
   J is the derivative with the row of t_k; and
3. where it ends: for the largest tau the distance of cable k is below all of its lengths.

From tau = 0 to a tube's end, for given lengths of the others, the distance of k thus falls from that of the
pose without k to one below its length. If it begins at or below it, the pose without k is static and no other
one of these is; else exactly one tau > 0 has k as long as it is, and that is static: one for each choice.

Arrays, for n taut cables of N and m = 6 + n equations: ``F`` (rows, columns of a form, LANES) forms with the
rows of ``tube.TABLE``; ``model`` is an ``arrays.Model`` whose lengths are written; ``lengths`` (N, 2) in m,
taut cables first; ``tau`` (2,) bounds; ``z`` (6 + n,); ``C`` (m, m); ``v, w, reach, radii`` (m,) radii;
``polynomial`` (m, TERMS); ``E`` (m, m, 2).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr_interval.kernels import interval
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.lanes import splat, store
from cdpr_interval.kernels.rounding import down, up
from cdpr_interval.kernels.second_order import (
    Symbols,
    add_product,
    add_scaled,
    bounds,
    close,
    constant,
    copy,
    largest,
)
from cdpr_interval.mechanics.six_dof.form_system import EQUATIONS, Z, derivative, excess, rotation_forms
from cdpr_interval.mechanics.six_dof.rows import MOST_TAUT
from cdpr_interval.mechanics.six_dof.tube import (
    GIVEN,
    INVERSE,
    KEPT,
    LANE,
    as_polynomial,
    deviations,
    evaluate,
    extents,
    first_lane,
    inverse_at,
    place,
    polynomial,
    proved_within,
)
from cdpr_interval.mechanics.six_dof.tube_fields import place_tube
from cdpr_interval.mechanics.six_dof.tube_terms import column_of, levelled

NEWTON_STEPS = 12
SHARES = (0.03, 0.1, 0.3)
"""Radii without a second zero over what the tube extends to, as they are tried."""
GROW = 1.4
"""The next radii tried over the last ones without a second zero."""
ASIDE = 1.4
"""Radii of the position there over those of the proof."""
GROWTHS = 24
"""Most of these steps: cells find their way to the zero from there."""
LEAST_PART = 0.1
"""Of the norm in which errors of a direction are bounded, in units of each unknown over the largest entry."""
GIVEN_SHARE = 1e-6
"""Radius of the tension that is given over that of another one: more than rounding."""
FAILED, PROVED, ENDED = 0, 1, 2
"""No tube; a tube; one at whose end the cable is shorter than its length."""


@kernel()
def put_data(F: Any, S: Symbols, model: Any, lengths: Any, tau: Any) -> None:
    """Write the lengths to the model, of cable k the shortest alone, and the given density to GIVEN."""
    k = model.n_taut - 1
    for i in range(lengths.shape[0]):
        lo, hi = interval.sqr(lengths[i, 0], lengths[i, 1])
        model.lengths[i, 0], model.lengths[i, 1] = lengths[i, 0], lengths[i, 1]
        model.lengths_sq[i] = 0.5 * lo + 0.5 * hi
        model.lengths_sq_err[i] = up(max(up(hi - model.lengths_sq[i]), up(model.lengths_sq[i] - lo)))
    model.lengths_sq[k], model.lengths_sq_err[k] = down(lengths[k, 0] * lengths[k, 0]), 0.0
    middle = 0.5 * tau[0] + 0.5 * tau[1]
    constant(F, GIVEN, splat(middle), splat(0.0), S)
    store(F, GIVEN, 1 + k, splat(up(max(up(tau[1] - middle), up(middle - tau[0])))))
    close(F, GIVEN, S)


@kernel()
def improve(F: Any, S: Symbols, model: Any, chart: int, z: Any, C: Any) -> bool:
    """Move z (6 + n,) to the zero for the middles of the data by Newton steps; C is the inverse there."""
    m = z.shape[0]
    free, rows, f = np.arange(m), np.eye(6), np.empty(m)
    for _ in range(NEWTON_STEPS):
        if not inverse_at(F, S, model, chart, rows, free, model.n_taut - 1, z, C):
            return False
        for i in range(m):
            f[i] = F[KEPT + i, 0, LANE]
        most, size = 0.0, 0.0
        for i in range(m):
            step = 0.0
            for j in range(m):
                step += C[i, j] * f[j]
            z[i] -= step
            most, size = max(most, abs(step)), max(size, abs(z[i]))
        if not most < 1e6 * (1.0 + size):
            return False
        if most <= 1e-13 * size:
            return True
    return False


@kernel()
def stretch(E: Any, v: Any, i: int) -> float:
    """Bound row i of |E| v from above."""
    total = 0.0
    for j in range(v.shape[0]):
        total = up(total + up(interval.mag(E[i, j, 0], E[i, j, 1]) * v[j]))
    return total


@kernel()
def draws_nearer(F: Any, S: Symbols, model: Any, chart: int, v: Any, w: Any) -> bool:
    """Prove that the distance of cable k decreases with its tension, along the tube in the rows Z.

    x = J^-1 e_k solves x = C e_k + E x, E = I - C J: with g the growth of E in the norm of some y >= |C e_k|,
    |x - C e_k| <= |E| |x| and |x| <= |C e_k| + y g / (1 - g). The row of cable k's length is
    that for ``lengths_sq[k]``; its gradient for the square of the distance instead differs by 2 u_m times
    their difference.
    """
    k, m = model.n_taut - 1, v.shape[0]
    free, rows, column, most, off = np.arange(m), np.eye(6), np.empty(m), np.empty(m), np.empty(m)
    norm, E = np.empty(m), np.empty((m, m, 2))
    with_errors(F, S, w)
    evaluate(F, model, chart, rows, free, k, True, S)
    deviations(F, E, S)
    scale = 0.0
    for i in range(m):
        column[i] = first_lane(largest(F, INVERSE + place(i, k), S), F)
        if i != 6 + k:
            scale = max(scale, column[i] / v[i])
    for i in range(m):
        norm[i] = column[i] + LEAST_PART * scale * v[i]
    growth = 0.0
    for i in range(m):
        growth = max(growth, up(stretch(E, norm, i) / norm[i]))
    if not growth < 1.0:
        return False
    for i in range(m):
        most[i] = up(column[i] + up(norm[i] * up(growth / down(1.0 - growth))))
    for i in range(m):
        off[i] = stretch(E, most, i)
    error = 0.0
    other = first_lane(largest(F, EQUATIONS + k, S), F)
    for c in range(6):
        slope = first_lane(largest(F, derivative(k, c), S), F)
        error = up(error + up(slope * off[c]))
        if c < 3:
            u = first_lane(largest(F, Z + c, S), F)
            error = up(error + up(up(up(2.0 * u) * other) * up(column[c] + off[c])))
    constant(F, KEPT, splat(0.0), splat(0.0), S)
    for c in range(6):
        add_product(F, KEPT, derivative(k, c), INVERSE + place(c, k), 1.0, S)
    _, hi = bounds(F, KEPT, S)
    return first_lane(hi, F) < -error


@kernel()
def with_errors(F: Any, S: Symbols, w: Any) -> None:
    """Add errors w (m,) to the polynomials in the rows Z."""
    K = len(S.noise)
    for i in range(w.shape[0]):
        store(F, Z + i, 1 + K + K * (K + 1) // 2, splat(w[i]))


@kernel()
def widest(F: Any, S: Symbols, model: Any, chart: int, C: Any, v: Any, reach: Any) -> None:
    """Write the largest multiples of v (m,) to reach (m,) that hold no second zero of the tube in the rows Z.

    Of v with larger radii of the position: in cells the lengths bound it less than the tube does.
    """
    m = v.shape[0]
    free, rows, w, E = np.arange(m), np.eye(6), np.empty(m), np.empty((m, m, 2))
    more = np.empty(m)
    more[:] = v
    more[3:6] *= ASIDE
    reach[:] = v
    for _ in range(GROWTHS):
        if not proved_within(F, S, model, chart, rows, free, model.n_taut - 1, C, more, w, E):
            return
        reach[:] = more
        more *= GROW


@kernel()
def alone(F: Any, S: Symbols, model: Any, chart: int, C: Any, v: Any, w: Any, E: Any) -> bool:
    """Prove the tube in the rows Z alone within some radii v (m,), which are found."""
    k, m = model.n_taut - 1, v.shape[0]
    free, rows = np.arange(m), np.eye(6)
    for share in SHARES:
        extents(F, free, share, v, S)
        levelled(F, model.size, free, v)
        # This one is given.
        v[6 + k] = GIVEN_SHARE * v[5 + k]
        if proved_within(F, S, model, chart, rows, free, k, C, v, w, E):
            return True
    return False


@kernel()
def end_of(polynomial: Any, k: int, side: float, w: Any, out: Any, radii: Any) -> None:
    """Write a polynomial for the symbol k at a side, -1 or 1, to out (m, TERMS), errors with w to radii."""
    for c in range(out.shape[0]):
        size = 0.0
        for q in range(out.shape[1]):
            out[c, q] = polynomial[c, q]
            size += abs(polynomial[c, q])
        out[c, 0] += side * out[c, 1 + k] + out[c, column_of(k, k)]
        out[c, 1 + k] = out[c, column_of(k, k)] = 0.0
        for i in range(MOST_TAUT):
            if i != k:
                q = column_of(min(i, k), max(i, k))
                out[c, 1 + i] += side * out[c, q]
                out[c, q] = 0.0
        radii[c] = up(w[c] + 1e-15 * size)


@kernel()
def carries_at_start(polynomial: Any, k: int, w: Any) -> bool:
    """Prove that the other tensions are positive for the smallest tau."""
    start, radii = np.empty(polynomial.shape), np.empty(w.shape[0])
    end_of(polynomial, k, -1.0, w, start, radii)
    for i in range(k):
        least = down(start[6 + i, 0] - radii[6 + i])
        for q in range(1, start.shape[1]):
            least = down(least - abs(start[6 + i, q]))
        if not least > 0.0:
            return False
    return True


@kernel()
def carries_if_taut(F: Any, S: Symbols, model: Any) -> bool:
    """Prove that the others carry wherever the distance of cable k is not below its shortest length.

    There its length's row G = s (|e_k|^2 - l_k^2) is not negative: with some mu >= 0 it is enough that
    t - mu G is positive. Needs the rows that ``draws_nearer`` leaves.
    """
    k = model.n_taut - 1
    for i in range(k):
        slope, own = F[Z + 6 + i, 1 + k, LANE], F[EQUATIONS + k, 1 + k, LANE]
        mu = slope / own if own != 0.0 else 0.0
        copy(F, KEPT, Z + 6 + i, S)
        lo, _ = bounds(F, KEPT, S)
        if first_lane(lo, F) > 0.0:
            continue
        if not mu > 0.0:
            return False
        add_scaled(F, KEPT, EQUATIONS + k, splat(-mu), S)
        lo, _ = bounds(F, KEPT, S)
        if not first_lane(lo, F) > 0.0:
            return False
    return True


@kernel()
def others_are_slack(F: Any, S: Symbols, model: Any, chart: int, w: Any) -> bool:
    """Prove along the tube that the cables outside are shorter than their lengths."""
    with_errors(F, S, w)
    rotation_forms(F, S)
    for j in range(model.n_taut, model.lengths.shape[0]):
        if not first_lane(excess(F, model, chart, j, S), F) < 0.0:
            return False
    return True


@kernel()
def without_errors(F: Any, S: Symbols, m: int) -> None:
    """Take the rows Z for polynomials again."""
    for i in range(m):
        as_polynomial(F, Z + i, S)


@kernel()
def is_short_at_end(
    F: Any, S: Symbols, model: Any, chart: int, lengths: Any, polynomial: Any, w: Any
) -> bool:
    """Prove that at the largest tau cable k is shorter than all of its lengths."""
    k = model.n_taut - 1
    end, radii = np.empty(polynomial.shape), np.empty(w.shape[0])
    end_of(polynomial, k, 1.0, w, end, radii)
    place_tube(F, end, np.empty((radii.shape[0], 0)), radii, S)
    lo, hi = interval.sqr(lengths[k, 0], lengths[k, 1])
    model.lengths_sq[k] = 0.5 * lo + 0.5 * hi
    model.lengths_sq_err[k] = up(max(up(hi - model.lengths_sq[k]), up(model.lengths_sq[k] - lo)))
    rotation_forms(F, S)
    return first_lane(excess(F, model, chart, k, S), F) < 0.0


@entry()
def prove_given(
    F: Any, S: Any, model: Any, chart: int, lengths: Any, tau: Any, z: Any, polynomials: Any, w: Any,
    reach: Any,
) -> int:  # fmt: skip
    """Prove the tube over the other lengths and tau, and what is asked along it, from z (6 + n,) near it.

    Parameters
    ----------
    z : (6 + n,)
        Written: the zero for the middles of the data.
    polynomials : (m, TERMS)
        Written, with w (m,) and reach (m,): for each choice of the data the zero is within w, and no other
        one within reach.

    Returns
    -------
    FAILED, PROVED or, where 3. of the module is proved too, ENDED.
    """
    k, m = model.n_taut - 1, z.shape[0]
    free, rows = np.arange(m), np.eye(6)
    C, v, E = np.empty((m, m)), np.empty(m), np.empty((m, m, 2))
    put_data(F, S, model, lengths, tau)
    if not improve(F, S, model, chart, z, C):
        return FAILED
    polynomial(F, S, model, chart, rows, free, k, z, C)
    if not alone(F, S, model, chart, C, v, w, E):
        return FAILED
    for c in range(m):
        for q in range(polynomials.shape[1]):
            polynomials[c, q] = F[Z + c, q, LANE]
    if not draws_nearer(F, S, model, chart, v, w) or not carries_if_taut(F, S, model):
        return FAILED
    if tau[0] == 0.0 and not carries_at_start(polynomials, k, w):
        return FAILED
    if not others_are_slack(F, S, model, chart, w):
        return FAILED
    without_errors(F, S, m)
    widest(F, S, model, chart, C, v, reach)
    return ENDED if is_short_at_end(F, S, model, chart, lengths, polynomials, w) else PROVED
