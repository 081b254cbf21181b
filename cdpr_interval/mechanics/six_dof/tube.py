"""Tubes: one zero for every choice of the data, as a polynomial in the data and a box around it.

z~(delta) is a polynomial of degree two in the symbols of the data (``form_system``). With C(delta) a float
polynomial of degree one near the inverse of the Jacobian J along it,

    r >= |C(delta) F(z~(delta), delta)|,    E(w) >= |I - C(delta) J(z~(delta) + w', delta)| for |w'| <= w

over all choices (w' rides on symbols of its own, to first order): r + E(w) w < w proves a zero in
z~(delta) + [-w, w] for each, the only one there, and E(v) x < x for some x > 0 that z~(delta) + [-v, v] holds
no two (Krawczyk's operator; the mean value theorem row by row with one matrix C(delta) for each choice).

With spreads of the points (``form_system``) the data of this system are delta and a choice d of the points
and the load, and z(delta, d) is its zero. It is a pose of d with the cables' own lengths l where
g_i(delta) = |e_i(d)|^2 - l_i^2 vanishes at z(delta, d), e_i(d) being the vector between d's own points. There
is just one such delta in [-1, 1]^n, and so one pose for each choice:

* There is one (Poincare and Miranda): e_i(d) differs from the vector of the middle points by at most the
  cable's gap, and that one is at least l_i + gap long at delta_i = 1, where g_i >= 0, and at most l_i - gap
  at -1, where g_i <= 0.
* The zeros of g are regular, with one sign of its determinant, as the derivatives with the lengths of d's
  own points are enclosed in J and regular all along: their number is the degree of g, which is 1.

Every pose for d within v of z~(delta), at the delta of its own middle points, is that one.

Arrays, for n taut cables and m equations: ``F`` (rows, columns of a form, LANES) forms with the rows of
``TABLE``; ``free`` (m,), ``rows`` (m - n, 6) as in ``six_dof.system``; ``z`` (6 + n,) a zero; ``C`` (m, m)
about the inverse of the Jacobian at z~(0); ``r, w, v`` (m,) residuals and radii; ``E`` (m, m, 2); ``model``
is an ``arrays.Model``.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import types

from cdpr_interval.engine.krawczyk import growth, preconditioner, stretched
from cdpr_interval.engine.rows import Table
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.lanes import splat, store
from cdpr_interval.kernels.rounding import down, up
from cdpr_interval.kernels.second_order import (
    ALONG_ALL_DATA,
    ALONG_DATA,
    Forms,
    Symbols,
    add_product,
    add_scaled,
    bounds,
    close,
    columns,
    combine2,
    constant,
    copy,
    largest,
    signatures,
    slope_column,
)
from cdpr_interval.mechanics.six_dof import form_system as base
from cdpr_interval.mechanics.six_dof.form_system import EQUATIONS, MOST_UNKNOWNS, Z, derivative, form_system

TABLE = Table(base.TABLE.ranges)
KEPT = TABLE.take("KEPT", MOST_UNKNOWNS)
"""The equations that are kept."""
SLOPES = TABLE.take("SLOPES", MOST_UNKNOWNS * MOST_UNKNOWNS)
"""Their derivatives by the free unknowns."""
INVERSE = TABLE.take("INVERSE", MOST_UNKNOWNS * MOST_UNKNOWNS)
"""C(delta)."""
OUT = TABLE.take("OUT")
GIVEN = TABLE.take("GIVEN")
"""The value of a tension that is given instead of its cable's length."""
TAUT_ONE = TABLE.take("TAUT_ONE", MOST_UNKNOWNS)
SLACK_ONE = TABLE.take("SLACK_ONE", MOST_UNKNOWNS)
"""Polynomials kept for later: of the system with a cable's length, and of that with its tension 0."""
SYMBOLS = ALONG_DATA
"""The symbols of forms where points and load are exact,"""
ALL_SYMBOLS = ALONG_ALL_DATA
"""and where they are not: z~ has slopes in these, too."""
NONE = -1
"""No cable."""
LANE = 0
"""The lane that is looked at."""
POLYNOMIAL_STEPS = 2
"""Chord steps from z~(0) to the polynomial of degree two, one for each order. A third one changes the radii
of UC4 with 0.1 to 3 mm in the sixth digit."""
INFLATIONS = 12
LARGER = 1.2
"""The next radii over the image of the last ones."""
LEAST_RADIUS = 1e-15
CONTRACTIONS = 4
"""Of the radii of a tube after its proof: each takes a constant share of what is above the residuals."""
NARROWEST = 1e-9
"""Radii of a tube without extent, over its largest unknown: far above rounding, too small for curvature."""


@kernel()
def place(i: int, j: int) -> int:
    """Return where the entry (i, j) of a matrix stands behind its first row."""
    return MOST_UNKNOWNS * i + j


@kernel()
def keep_forms(F: Forms, n: int, rows: Any, free: Any, loose: int, slopes: bool, S: Symbols) -> None:
    """Copy the equations that are kept, and their derivatives by the free unknowns.

    Of the cable ``loose``, if any, the equation is t = GIVEN instead of its length.
    """
    for i in range(free.shape[0]):
        if i == loose:
            combine2(F, KEPT + i, Z + 6 + i, splat(1.0), GIVEN, splat(-1.0), S)
            if slopes:
                for j in range(free.shape[0]):
                    own = 1.0 if free[j] == 6 + i else 0.0
                    constant(F, SLOPES + place(i, j), splat(own), splat(0.0), S)
            continue
        if i < n:
            copy(F, KEPT + i, EQUATIONS + i, S)
            if slopes:
                for j in range(free.shape[0]):
                    copy(F, SLOPES + place(i, j), derivative(i, free[j]), S)
            continue
        constant(F, KEPT + i, splat(0.0), splat(0.0), S)
        for k in range(6):
            if rows[i - n, k] != 0.0:
                add_scaled(F, KEPT + i, EQUATIONS + n + k, splat(rows[i - n, k]), S)
        if slopes:
            for j in range(free.shape[0]):
                out = SLOPES + place(i, j)
                constant(F, out, splat(0.0), splat(0.0), S)
                for k in range(6):
                    if rows[i - n, k] != 0.0:
                        add_scaled(F, out, derivative(n + k, free[j]), splat(rows[i - n, k]), S)


@kernel()
def evaluate(
    F: Forms, model: Any, chart: int, rows: Any, free: Any, loose: int, slopes: bool, S: Symbols
) -> None:
    """Write the kept equations and, with ``slopes``, their derivatives at the forms Z."""
    form_system(F, model, chart, slopes, S)
    keep_forms(F, model.n_taut, rows, free, loose, slopes, S)


@kernel(signatures(types.void, types.int64))
def as_polynomial(F: Forms, row: int, S: Symbols) -> None:
    """Take a row's coefficients in the symbols of the data for exact: it is what they say."""
    K = len(S.noise)
    Q = 1 + K + K * (K + 1) // 2
    store(F, row, Q, 0.0)
    for offset in range(MOST_UNKNOWNS):
        store(F, row, Q + 3 + offset, 0.0)
    close(F, row, S)


@kernel()
def subtract_step(F: Forms, C: Any, free: Any, S: Symbols) -> None:
    """Subtract C times the equations from the unknowns, as polynomials."""
    m = free.shape[0]
    for i in range(m):
        for k in range(m):
            add_scaled(F, Z + free[i], KEPT + k, splat(-C[i, k]), S)
    for i in range(m):
        as_polynomial(F, Z + free[i], S)


@kernel()
def middle_slopes(F: Forms, column: int, m: int, out: Any) -> None:
    """Write a column of the derivatives' coefficients to out (m, m, 2)."""
    for i in range(m):
        for j in range(m):
            out[i, j, 0] = out[i, j, 1] = F[SLOPES + place(i, j), column, LANE]


@kernel()
def inverse_forms(F: Forms, C: Any, n: int, part: Any, S: Symbols) -> None:
    """Write C(delta) = C - sum C J_k C delta_k; ``part`` (m, m, 2) is scratch."""
    m, K = C.shape[0], len(S.noise)
    half = np.empty((m, m))
    for i in range(m):
        for j in range(m):
            constant(F, INVERSE + place(i, j), splat(C[i, j]), splat(0.0), S)
    for symbol in range(K + len(S.data)):
        if n <= symbol < K + MOST_UNKNOWNS:
            continue
        column = slope_column(symbol, S)
        middle_slopes(F, column, m, part)
        for i in range(m):
            for j in range(m):
                total = 0.0
                for k in range(m):
                    total += part[i, k, 0] * C[k, j]
                half[i, j] = total
        for i in range(m):
            for j in range(m):
                total = 0.0
                for k in range(m):
                    total -= C[i, k] * half[k, j]
                store(F, INVERSE + place(i, j), column, total)
    for i in range(m):
        for j in range(m):
            close(F, INVERSE + place(i, j), S)


@kernel()
def residuals(F: Forms, r: Any, S: Symbols) -> None:
    """Write upper bounds of |C(delta) F| to r (m,)."""
    m = r.shape[0]
    for i in range(m):
        constant(F, OUT, splat(0.0), splat(0.0), S)
        for k in range(m):
            add_product(F, OUT, INVERSE + place(i, k), KEPT + k, 1.0, S)
        r[i] = first_lane(largest(F, OUT, S), F)


@kernel()
def first_lane(value: Any, F: Forms) -> float:
    """Return the first lane's number."""
    store(F, OUT, 0, value)
    return float(F[OUT, 0, LANE])


@kernel()
def is_zero(F: Forms, row: int, S: Symbols) -> bool:
    """Return True when a row is 0 without error in the lane that is looked at."""
    for q in range(columns(S)):  # noqa: SIM110 - numba compiles no generator expressions
        if F[row, q, LANE] != 0.0:
            return False
    return True


@kernel()
def deviations(F: Forms, E: Any, S: Symbols) -> None:
    """Write bounds of the entries of I - C(delta) J to E (m, m, 2)."""
    m = E.shape[0]
    present = np.empty((m, m), dtype=np.bool_)
    for k in range(m):
        for j in range(m):
            # Some equations lack some of the unknowns: of the lengths the tensions, say. Never true for NaN.
            present[k, j] = not is_zero(F, SLOPES + place(k, j), S)
    for i in range(m):
        for j in range(m):
            constant(F, OUT, splat(1.0 if i == j else 0.0), splat(0.0), S)
            for k in range(m):
                if present[k, j]:
                    add_product(F, OUT, INVERSE + place(i, k), SLOPES + place(k, j), -1.0, S)
            most = first_lane(largest(F, OUT, S), F)
            E[i, j, 0], E[i, j, 1] = -most, most


@kernel()
def deviations_around(
    F: Forms, model: Any, chart: int, rows: Any, free: Any, v: Any, E: Any, S: Symbols
) -> None:
    """Write E (m, m, 2) over z~(delta) + [-v, v]; the unknowns are left without errors."""
    for i in range(free.shape[0]):
        store(F, Z + free[i], slope_column(len(S.noise) + free[i], S), splat(v[i]))
        close(F, Z + free[i], S)
    evaluate(F, model, chart, rows, free, NONE, True, S)
    deviations(F, E, S)
    for i in range(free.shape[0]):
        as_polynomial(F, Z + free[i], S)


@kernel()
def radii_proved(
    F: Forms, model: Any, chart: int, rows: Any, free: Any, r: Any, w: Any, E: Any, S: Symbols
) -> bool:
    """Find radii w (m,) with r + E(w) w < w; False where none are found."""
    m = free.shape[0]
    image = np.empty(m)
    for i in range(m):
        w[i] = LARGER * r[i] + LEAST_RADIUS
    for _ in range(INFLATIONS):
        deviations_around(F, model, chart, rows, free, w, E, S)
        inside = stretched(E, w, r, image)
        largest_image = 0.0
        for i in range(m):
            largest_image = max(largest_image, image[i])
            if not image[i] < math.inf:
                return False
        if inside:
            for i in range(m):
                w[i] = image[i]
            return True
        if largest_image > 1e6:
            return False
        for i in range(m):
            w[i] = LARGER * max(image[i], 0.5 * w[i])
    return False


@entry()
def tube(
    F: Any, S: Any, model: Any, chart: int, rows: Any, free: Any, z: Any, C: Any, w: Any, hull: Any
) -> bool:
    """Find and prove the tube through a zero z (6 + n,) at the middle of the data.

    Its polynomial is left in the rows Z of ``F``, its radii in ``w`` (m,), C(delta) in the rows INVERSE, the
    bounds of all its zeros in ``hull`` (6 + n, 2). ``C`` (m, m) is written.

    Guarantee: where True is returned, there is exactly one zero in z~(delta) + [-w, w] for every choice of
    the data.
    """
    n, m = model.n_taut, free.shape[0]
    J, E, r = np.empty((m, m, 2)), np.empty((m, m, 2)), np.empty(m)
    for k in range(6 + n):
        constant(F, Z + k, splat(z[k]), splat(0.0), S)
    evaluate(F, model, chart, rows, free, NONE, True, S)
    middle_slopes(F, 0, m, J)
    if not preconditioner(J, C):
        return False
    for _ in range(POLYNOMIAL_STEPS):
        subtract_step(F, C, free, S)
        evaluate(F, model, chart, rows, free, NONE, False, S)
    evaluate(F, model, chart, rows, free, NONE, True, S)
    inverse_forms(F, C, n, J, S)
    residuals(F, r, S)
    if not radii_proved(F, model, chart, rows, free, r, w, E, S):
        return False
    hull_of(F, free, w, z, hull, S)
    return True


@entry()
def inverse_at(
    F: Any, S: Any, model: Any, chart: int, rows: Any, free: Any, loose: int, z: Any, C: Any
) -> bool:
    """Write the inverse of the derivative at a zero z (6 + n,) to ``C`` (m, m), in floats; False without one.

    ``loose`` as in ``polynomial``.
    """
    J = np.empty((free.shape[0], free.shape[0], 2))
    for k in range(6 + model.n_taut):
        constant(F, Z + k, splat(z[k]), splat(0.0), S)
    evaluate(F, model, chart, rows, free, loose, True, S)
    middle_slopes(F, 0, free.shape[0], J)
    return bool(preconditioner(J, C))


@entry()
def polynomial(
    F: Any, S: Any, model: Any, chart: int, rows: Any, free: Any, loose: int, z: Any, C: Any
) -> None:
    """Write the polynomial of degree two through a zero z (6 + n,) at the middle of the data to the rows Z.

    ``C`` (m, m) is near the inverse of the derivative there. ``loose`` is the cable of which t = GIVEN is the
    equation instead of its length, ``NONE`` for none.
    """
    for k in range(6 + model.n_taut):
        constant(F, Z + k, splat(z[k]), splat(0.0), S)
    for _ in range(POLYNOMIAL_STEPS):
        evaluate(F, model, chart, rows, free, loose, False, S)
        subtract_step(F, C, free, S)


@entry()
def proved_within(
    F: Any, S: Any, model: Any, chart: int, rows: Any, free: Any, loose: int, C: Any, v: Any, w: Any, E: Any
) -> bool:
    """Prove the tube whose polynomial is in the rows Z, alone within the radii v (m,).

    Less work than ``tube`` and ``alone_within``: the derivatives are looked at once. ``C`` and ``loose`` are
    those of ``polynomial``; w (m,) and E (m, m, 2) are written, the rows Z stay.

    Guarantee: where True is returned, for every choice of the data there is exactly one zero in
    z~(delta) + [-v, v], and it lies in z~(delta) + [-w, w]. E encloses I - C(delta) J over the former, and
    the rows INVERSE hold C(delta).
    """
    n, m = model.n_taut, free.shape[0]
    part, r, image = np.empty((m, m, 2)), np.empty(m), np.empty(m)
    for i in range(m):
        store(F, Z + free[i], slope_column(len(S.noise) + free[i], S), splat(v[i]))
        close(F, Z + free[i], S)
    evaluate(F, model, chart, rows, free, loose, True, S)
    inverse_forms(F, C, n, part, S)
    deviations(F, E, S)
    for i in range(m):
        as_polynomial(F, Z + free[i], S)
    evaluate(F, model, chart, rows, free, loose, False, S)
    residuals(F, r, S)
    if not stretched(E, v, r, w):
        return False
    for _ in range(CONTRACTIONS):
        # E holds for all radii up to v.
        image[:] = w
        stretched(E, image, r, w)
    return True


@kernel()
def extents(F: Forms, free: Any, share: float, out: Any, S: Symbols) -> None:
    """Write a share of what the polynomial in the rows Z extends to out (m,); a little where it does not."""
    most = 0.0
    for i in range(free.shape[0]):
        most = max(most, abs(F[Z + free[i], 0, LANE]))
    for i in range(free.shape[0]):
        extent = first_lane(largest(F, Z + free[i], S), F) - abs(F[Z + free[i], 0, LANE])
        out[i] = share * max(extent, 0.0) + NARROWEST * most


@kernel()
def moved_by_errors(F: Forms, C: Any, out: Any, S: Symbols) -> None:
    """Write how far the errors of the equations move the zeros to out (m,), in floats.

    Needs what ``polynomial`` left in ``F``; ``C`` (m, m) is its. Data with ranges that are no symbols are
    errors.
    """
    K = len(S.noise)
    errors = 1 + K + K * (K + 1) // 2
    for i in range(out.shape[0]):
        out[i] = 0.0
        for k in range(out.shape[0]):
            out[i] += abs(C[i, k]) * F[KEPT + k, errors, LANE]


@kernel()
def hull_of(F: Forms, free: Any, w: Any, z: Any, hull: Any, S: Symbols) -> None:
    """Write the bounds of the tube to hull (6 + n, 2)."""
    for k in range(z.shape[0]):
        hull[k, 0] = hull[k, 1] = z[k]
    for i in range(free.shape[0]):
        lo, hi = bounds(F, Z + free[i], S)
        hull[free[i], 0] = down(first_lane(lo, F) - w[i])
        hull[free[i], 1] = up(first_lane(hi, F) + w[i])


@entry()
def alone_within(F: Any, S: Any, model: Any, chart: int, rows: Any, free: Any, v: Any) -> float:
    """Return how much E stretches a positive vector over z~(delta) + [-v, v]: below 1 only with a proof.

    Needs what ``tube`` left in ``F``.
    """
    m = free.shape[0]
    E, box = np.empty((m, m, 2)), np.empty((m, 2))
    deviations_around(F, model, chart, rows, free, v, E, S)
    for i in range(m):
        box[i, 0], box[i, 1] = -v[i], v[i]
    return float(growth(E, box))
