"""The full square system of a taut subset: interval evaluation, and what Newton and Krawczyk need of it.

Unknowns z = (u (3), p (3), t (n)) with t_i = tension_i / l_i; p is the centre of mass in the model's
base frame. Equations: |e_i|^2 - l_i^2 = 0 (n), then the force and moment sums sum t_i e_i + f and
sum t_i r_i x (A_i - p) (r_i x e_i is the same), of which a reduced problem keeps only combinations:
``rows`` are the combinations of the six statics equations and ``free`` the indices of the m unknowns that
are not fixed. ``data`` are a model's numbers in one chart, see ``fill_data``.

Arrays: ``data`` (n + 1, 7, 2), ``rows`` (m - n, 6), ``free`` (m,); ``C`` (m, m) is about the inverse of the
reduced Jacobian; ``model`` is an ``arrays.Model``, ``context`` is ``(data, rows, free, C, z)``, see
``residual``.

Interval arrays have shape (..., 2); bounds of every entry enclose over the box. Signatures are explicit, and
plain arrays: numba compiles a function that takes a whole model many times slower.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr_interval.engine.krawczyk import deviation, existence, over, preconditioner
from cdpr_interval.engine.krawczyk import growth as stretch
from cdpr_interval.engine.newton import Pace, newton
from cdpr_interval.kernels import interval
from cdpr_interval.kernels.box import accumulate, copy, gather, point, scatter
from cdpr_interval.kernels.kernel import entry, kernel, part
from cdpr_interval.kernels.rounding import down, up
from cdpr_interval.mechanics.rotation import rotation_interval

PACE = Pace(converged=1e-14, stalled=1e-10, fresh=1e-3, slow=0.1, lost=1e6)
"""Newton's steps; unknowns lie near 1, in units near the platform's own."""
CONVERGED = 1e-9
"""Length of the last step at which its root is one, though the steps ended before they were short enough."""


@entry()
def fill_data(model: Any, chart: int, data: Any) -> None:
    """Write the bounds of a model's data to ``data`` (n + 1, 7, 2).

    A row of a taut cable holds A_i, D_c b_i and l_i^2; the last one the load.
    """
    n = model.n_taut
    for i in range(n):
        for k in range(3):
            x, e = model.exits[i, k], model.exits_err[i, k]
            data[i, k, 0], data[i, k, 1] = down(x - e), up(x + e)
            x, e = model.arms[chart, i, k], model.arms_err[i, k]
            data[i, 3 + k, 0], data[i, 3 + k, 1] = down(x - e), up(x + e)
        x, e = model.lengths_sq[i], model.lengths_sq_err[i]
        data[i, 6, 0], data[i, 6, 1] = down(x - e), up(x + e)
    for k in range(3):
        x, e = model.load[k], model.load_err[k]
        data[n, k, 0], data[n, k, 1] = down(x - e), up(x + e)


@entry("void(f8[:, :, ::1], f8[:, :, ::1], i8, f8[:, ::1])")
def matrix_point(M: Any, data: Any, i: int, out: Any) -> None:
    """Enclose M b_i in out (3, 2) for M (3, 3, 2)."""
    for r in range(3):
        lo, hi = 0.0, 0.0
        for c in range(3):
            a0, a1 = interval.mul(M[r, c, 0], M[r, c, 1], data[i, 3 + c, 0], data[i, 3 + c, 1])
            lo, hi = interval.add(lo, hi, a0, a1)
        out[r, 0] = lo
        out[r, 1] = hi


@entry("void(i8, i8, f8, f8, f8[:, ::1], f8[:, ::1], f8[:, ::1], f8[:, :, ::1], f8[:, :, ::1])")
def cable_derivatives(n: int, i: int, t0: float, t1: float, r: Any, q: Any, e: Any, dr: Any, J: Any) -> None:
    """Add cable i's part of the derivatives by u and p to J (n + 6, 6 + n, 2).

    ``r, q, e`` : (3, 2) r_i, A_i - p and e_i; ``dr`` : (3, 3, 2) the derivatives of r_i by u.
    """
    for k in range(3):
        # |e|^2 by u_k: -2 e . dr_k; by p_k: -2 e_k.
        s0, s1 = 0.0, 0.0
        for c in range(3):
            x0, x1 = interval.mul(e[c, 0], e[c, 1], dr[k, c, 0], dr[k, c, 1])
            s0, s1 = interval.add(s0, s1, x0, x1)
            # Force by u_k: -t dr_k.
            x0, x1 = interval.mul(t0, t1, dr[k, c, 0], dr[k, c, 1])
            accumulate(J, n + c, k, -x1, -x0)
            # Moment by u_k: t dr_k x q.
            a, b = (c + 1) % 3, (c + 2) % 3
            m0, m1 = interval.mul(dr[k, a, 0], dr[k, a, 1], q[b, 0], q[b, 1])
            v0, v1 = interval.mul(dr[k, b, 0], dr[k, b, 1], q[a, 0], q[a, 1])
            m0, m1 = interval.sub(m0, m1, v0, v1)
            m0, m1 = interval.mul(t0, t1, m0, m1)
            accumulate(J, n + 3 + c, k, m0, m1)
        J[i, k, 0], J[i, k, 1] = -2.0 * s1, -2.0 * s0
        J[i, 3 + k, 0], J[i, 3 + k, 1] = -2.0 * e[k, 1], -2.0 * e[k, 0]
        accumulate(J, n + k, 3 + k, -t1, -t0)
        # Moment t r x (A - p) by p_k: -t r x unit_k = t unit_k x r.
        a, b = (k + 1) % 3, (k + 2) % 3
        x0, x1 = interval.mul(t0, t1, r[b, 0], r[b, 1])
        accumulate(J, n + 3 + a, 3 + k, -x1, -x0)
        x0, x1 = interval.mul(t0, t1, r[a, 0], r[a, 1])
        accumulate(J, n + 3 + b, 3 + k, x0, x1)


@entry("void(f8[:, :, ::1], f8[:, ::1], f8[:, ::1], f8[:, :, ::1], b1)")
def system(data: Any, z: Any, f: Any, J: Any, jacobian: bool) -> None:
    """Enclose all n + 6 equations f (n + 6, 2) and, if asked, their derivatives J (n + 6, 6 + n, 2).

    Over a box z (6 + n, 2).
    """
    n = data.shape[0] - 1
    R = np.empty((3, 3, 2))
    dR = np.empty((3, 3, 3, 2))
    rotation_interval(z, R, dR)
    r = np.empty((3, 2))
    dr = np.empty((3, 3, 2))
    q = np.empty((3, 2))
    e = np.empty((3, 2))
    f[:, :] = 0.0
    if jacobian:
        J[:, :, :] = 0.0
    for k in range(3):
        f[n + k, 0] = data[n, k, 0]
        f[n + k, 1] = data[n, k, 1]
    for i in range(n):
        matrix_point(R, data, i, r)
        t0, t1 = z[6 + i, 0], z[6 + i, 1]
        s0, s1 = 0.0, 0.0
        for k in range(3):
            q[k, 0], q[k, 1] = interval.sub(data[i, k, 0], data[i, k, 1], z[3 + k, 0], z[3 + k, 1])
            e[k, 0], e[k, 1] = interval.sub(q[k, 0], q[k, 1], r[k, 0], r[k, 1])
            x0, x1 = interval.sqr(e[k, 0], e[k, 1])
            s0, s1 = interval.add(s0, s1, x0, x1)
        f[i, 0], f[i, 1] = interval.sub(s0, s1, data[i, 6, 0], data[i, 6, 1])
        for k in range(3):
            x0, x1 = interval.mul(t0, t1, e[k, 0], e[k, 1])
            f[n + k, 0], f[n + k, 1] = interval.add(f[n + k, 0], f[n + k, 1], x0, x1)
            a, b = (k + 1) % 3, (k + 2) % 3
            m0, m1 = interval.mul(r[a, 0], r[a, 1], q[b, 0], q[b, 1])
            v0, v1 = interval.mul(r[b, 0], r[b, 1], q[a, 0], q[a, 1])
            m0, m1 = interval.sub(m0, m1, v0, v1)
            x0, x1 = interval.mul(t0, t1, m0, m1)
            f[n + 3 + k, 0], f[n + 3 + k, 1] = interval.add(f[n + 3 + k, 0], f[n + 3 + k, 1], x0, x1)
            if jacobian:
                J[n + k, 6 + i, 0], J[n + k, 6 + i, 1] = e[k, 0], e[k, 1]
                J[n + 3 + k, 6 + i, 0], J[n + 3 + k, 6 + i, 1] = m0, m1
        if jacobian:
            for k in range(3):
                matrix_point(dR[k], data, i, dr[k])
            cable_derivatives(n, i, t0, t1, r, q, e, dr, J)


@entry("void(i8, f8[:, ::1], f8[:, ::1], f8[:, ::1])")
def keep(n: int, rows: Any, f: Any, out: Any) -> None:
    """Keep n lengths and the combinations ``rows`` of the statics of f (n + 6, 2) in out (m, 2)."""
    for i in range(n):
        out[i, 0] = f[i, 0]
        out[i, 1] = f[i, 1]
    for i in range(rows.shape[0]):
        lo, hi = 0.0, 0.0
        for k in range(6):
            if rows[i, k] != 0.0:
                a, b = interval.scale(rows[i, k], f[n + k, 0], f[n + k, 1])
                lo, hi = interval.add(lo, hi, a, b)
        out[n + i, 0] = lo
        out[n + i, 1] = hi


@entry("void(f8[:, :, ::1], f8[:, ::1], i8[::1], f8[:, ::1], f8[:, ::1], f8[:, :, ::1])")
def jacobian_over(data: Any, rows: Any, free: Any, z: Any, f: Any, J: Any) -> None:
    """Enclose the reduced equations f (m, 2) and their Jacobian J (m, m, 2) over the box z (6 + n, 2)."""
    n = data.shape[0] - 1
    full_f = np.empty((n + 6, 2))
    full = np.empty((n + 6, 6 + n, 2))
    system(data, z, full_f, full, True)
    keep(n, rows, full_f, f)
    for j in range(free.shape[0]):
        for i in range(n):
            J[i, j, 0] = full[i, free[j], 0]
            J[i, j, 1] = full[i, free[j], 1]
        for i in range(rows.shape[0]):
            lo, hi = 0.0, 0.0
            for k in range(6):
                if rows[i, k] != 0.0:
                    a, b = interval.scale(rows[i, k], full[n + k, free[j], 0], full[n + k, free[j], 1])
                    lo, hi = interval.add(lo, hi, a, b)
            J[n + i, j, 0] = lo
            J[n + i, j, 1] = hi


@entry("void(f8[:, :, ::1], f8[:, ::1], f8[:, ::1], f8[:, ::1])")
def residual_at(data: Any, rows: Any, z: Any, out: Any) -> None:
    """Enclose the reduced equations in out (m, 2) over the box z (6 + n, 2)."""
    n = data.shape[0] - 1
    f = np.empty((n + 6, 2))
    unused = np.empty((1, 1, 2))
    system(data, z, f, unused, False)
    keep(n, rows, f, out)


# Inlined where they are handed in: the system is large, and would be compiled once more in each of them.
@part()
def residual(context: Any, part: Any, f: Any) -> None:
    """Enclose the reduced equations over a box of the free unknowns, see `cdpr_interval.engine.krawczyk`.

    Parameters
    ----------
    context
        ``(data, rows, free, C, z)``: (n + 1, 7, 2), (m - n, 6), (m,), (m, m), (6 + n, 2); z holds the
        unknowns that are fixed, and is scratch for the others.
    part, f : (m, 2)
        The box, and the equations.
    """
    data, rows, free, _, z = context
    scatter(part, free, z)
    residual_at(data, rows, z, f)


@part()
def deviate(context: Any, part: Any, E: Any) -> None:
    """Enclose I - C J in E (m, m, 2) over a box (m, 2) of the free unknowns; context as ``residual``."""
    data, rows, free, C, z = context
    scatter(part, free, z)
    krawczyk_matrix(data, rows, free, C, z, E)


@part()
def linearise(context: Any, part: Any, f: Any, C: Any) -> bool:
    """Write residuals f (m, 2) and inverse C (m, m) at ``part`` (m, 2), see `cdpr_interval.engine.newton`."""
    data, rows, free, _, z = context
    J = np.empty((free.shape[0], free.shape[0], 2))
    scatter(part, free, z)
    jacobian_over(data, rows, free, z, f, J)
    return preconditioner(J, C)


@entry("b1(f8[:, :, ::1], f8[:, ::1], i8[::1], f8[::1], f8[:, ::1], i8)")
def improve(data: Any, rows: Any, free: Any, z: Any, C: Any, steps: int) -> bool:
    """Improve the free unknowns of z (6 + n,) by Newton steps in floats; True when they converged.

    ``C`` (m, m) is left as the inverse of the last derivative.
    """
    whole, x = np.empty((z.shape[0], 2)), np.empty(free.shape[0])
    point(z, whole)
    for i in range(free.shape[0]):
        x[i] = z[free[i]]
    last = newton(linearise, residual, (data, rows, free, C, whole), x, C, steps, PACE)
    for i in range(free.shape[0]):
        z[free[i]] = x[i]
    return last < CONVERGED


@part()
def krawczyk_matrix(data: Any, rows: Any, free: Any, C: Any, z: Any, out: Any) -> None:
    """Enclose I - C J(z) in out (m, m, 2) over the box z (6 + n, 2)."""
    m = free.shape[0]
    J, f = np.empty((m, m, 2)), np.empty((m, 2))
    jacobian_over(data, rows, free, z, f, J)
    deviation(C, J, out)


@part()
def apply(context: Any, part: Any, image: Any) -> bool:
    """Apply the Krawczyk operator to a box (m, 2) of the free unknowns; context as ``residual``."""
    return over(residual, deviate, context, context[3], part, image)


@entry("b1(f8[:, :, ::1], f8[:, ::1], i8[::1], f8[:, ::1], f8[:, ::1], f8[:, ::1])")
def krawczyk(data: Any, rows: Any, free: Any, C: Any, z: Any, image: Any) -> bool:
    """Apply the Krawczyk operator to the box z (6 + n, 2); True when the image lies strictly inside.

    Guarantee: True proves that for every choice of the data in their enclosures (lengths in
    their ranges included) the box holds exactly one zero of the reduced square system, and that
    it lies in ``image`` (6 + n, 2). Fixed unknowns keep their (exact, zero-width) values in both.
    """
    whole, part, inner = np.empty(z.shape), np.empty((free.shape[0], 2)), np.empty((free.shape[0], 2))
    copy(z, whole)
    copy(z, image)
    gather(z, free, part)
    inside = apply((data, rows, free, C, whole), part, inner)
    scatter(inner, free, image)
    return inside


@kernel("f8(f8[::1])")
def largest(z: Any) -> float:
    """Return the largest coordinate of the pose of z (>= 6,): unknowns near 0 are off by its rounding."""
    most = 0.0
    for k in range(6):
        most = max(most, abs(z[k]))
    return most


@entry("b1(f8[:, :, ::1], f8[:, ::1], i8[::1], f8[:, ::1], f8[::1], f8[:, ::1], f8[:, ::1])")
def existence_box(data: Any, rows: Any, free: Any, C: Any, z: Any, f: Any, box: Any) -> bool:
    """Grow a box around z (6 + n,) until the Krawczyk operator maps it strictly into itself, and contract it.

    ``f`` (m, 2) are the residuals at z. Of exact data only rounding is left after one step.

    Guarantee: where True is returned, ``box`` (6 + n, 2) holds exactly one zero for every choice of data.
    """
    whole, part, x = np.empty(box.shape), np.empty((free.shape[0], 2)), np.empty(free.shape[0])
    point(z, box)
    point(z, whole)
    for i in range(free.shape[0]):
        x[i] = z[free[i]]
    proved = existence(apply, (data, rows, free, C, whole), C, x, f, largest(z), False, part)
    scatter(part, free, box)
    return proved


@entry("f8(f8[:, :, ::1], f8[:, ::1], i8[::1], f8[:, ::1], f8[:, ::1])")
def growth(data: Any, rows: Any, free: Any, C: Any, z: Any) -> float:
    """Return how much |I - C J(z)| stretches a positive vector: below 1 only with a proof.

    Guarantee: a value below 1 proves that the square system has at most one zero in the box z (6 + n, 2), for
    every choice of data.
    """
    m = free.shape[0]
    E, part = np.empty((m, m, 2)), np.empty((m, 2))
    krawczyk_matrix(data, rows, free, C, z, E)
    gather(z, free, part)
    return float(stretch(E, part))


def regular(data: Any, rows: Any, free: Any, C: Any, z: Any) -> bool:
    """Return True when the square system has at most one zero in the box z (for every choice of data)."""
    return bool(growth(data, rows, free, C, z) < 1.0)
