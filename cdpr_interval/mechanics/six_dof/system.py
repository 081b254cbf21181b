"""The full square system of a taut subset: interval evaluation, float Newton, Krawczyk proof.

Unknowns z = (u (3), p (3), t (n)) with t_i = tension_i / l_i; p is the centre of mass in the model's
base frame. Equations: |e_i|^2 - l_i^2 = 0 (n), then the force and moment sums sum t_i e_i + f and
sum t_i r_i x (A_i - p) (r_i x e_i is the same), of which a reduced problem keeps only combinations:
``rows`` (m, 6) are the combinations of the six statics equations and ``free`` the indices of z
that are not fixed, with len(free) = n + m. ``data`` are a model's numbers in one chart, see ``fill_data``.

Interval arrays have shape (..., 2); bounds of every entry enclose over the box. Signatures are explicit, and
plain arrays: numba compiles a function that takes a whole model many times slower.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from cdpr_interval.kernels import interval
from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.rounding import down, up

PERRON_STEPS = 12
"""Steps of the search for a positive vector that proves a matrix close to the identity regular."""
PERRON_FLOOR = 1e-3
"""Share of the vector before that is kept."""
KEEP_BELOW = 1e-3
"""Newton step over (1 + |z|) from which on the derivative is kept."""
SLOW = 0.1
"""Steps that shrink by less than this ask for a new derivative."""
GOOD = 0.5
"""Growth that is good enough: no better estimate is sought."""
BELOW_ONE = 1.0 - 2.0**-53
"""Largest double below 1."""


@njit("void(f8[:, :, ::1], i8, i8, f8, f8)", cache=True, nogil=True)
def accumulate(out: Any, i: int, j: int, lo: float, hi: float) -> None:
    """Add [lo, hi] to entry (i, j) of an interval matrix."""
    out[i, j, 0] = down(out[i, j, 0] + lo)
    out[i, j, 1] = up(out[i, j, 1] + hi)


@njit("void(f8[:, ::1], f8[:, :, ::1], f8[:, :, :, ::1])", cache=True, nogil=True)
def rotation_interval(z: Any, R: Any, dR: Any) -> None:
    """Enclose R(u) (3, 3, 2) and its derivatives dR[k] (3, 3, 3, 2) over the box z."""
    slo, shi = 1.0, 1.0
    for k in range(3):
        a, b = interval.sqr(z[k, 0], z[k, 1])
        slo, shi = interval.add(slo, shi, a, b)
    glo, ghi = interval.div(2.0, 2.0, slo, shi)
    # N = [u]_x + u u^T - |u|^2 I and dN/du_k, exact products of the entries of u.
    for i in range(3):
        for j in range(3):
            if i == j:
                a, b = (i + 1) % 3, (i + 2) % 3
                qlo, qhi = interval.sqr(z[a, 0], z[a, 1])
                rlo, rhi = interval.sqr(z[b, 0], z[b, 1])
                nlo, nhi = interval.add(qlo, qhi, rlo, rhi)
                nlo, nhi = -nhi, -nlo
            else:
                k = 3 - i - j
                nlo, nhi = interval.mul(z[i, 0], z[i, 1], z[j, 0], z[j, 1])
                # [u]_x has -u_k at (i, j) when (i, j, k) is an even permutation, +u_k otherwise.
                if (j - i) % 3 == 1:
                    nlo, nhi = interval.sub(nlo, nhi, z[k, 0], z[k, 1])
                else:
                    nlo, nhi = interval.add(nlo, nhi, z[k, 0], z[k, 1])
            nlo, nhi = interval.mul(glo, ghi, nlo, nhi)
            for k in range(3):
                dlo, dhi = 0.0, 0.0
                if i == j:
                    if k != i:
                        dlo, dhi = -2.0 * z[k, 1], -2.0 * z[k, 0]
                else:
                    if k == i:
                        dlo, dhi = z[j, 0], z[j, 1]
                    elif k == j:
                        dlo, dhi = z[i, 0], z[i, 1]
                    elif (j - i) % 3 == 1:
                        dlo, dhi = -1.0, -1.0
                    else:
                        dlo, dhi = 1.0, 1.0
                # d(g N) = g dN - g u_k (g N), since dg/du_k = -g^2 u_k.
                tlo, thi = interval.mul(z[k, 0], z[k, 1], nlo, nhi)
                dlo, dhi = interval.sub(dlo, dhi, tlo, thi)
                dlo, dhi = interval.mul(glo, ghi, dlo, dhi)
                dR[k, i, j, 0] = dlo
                dR[k, i, j, 1] = dhi
            if i == j:
                nlo, nhi = interval.add(1.0, 1.0, nlo, nhi)
            # The entries of a rotation lie in [-1, 1].
            R[i, j, 0] = max(nlo, -1.0)
            R[i, j, 1] = min(nhi, 1.0)


@njit(cache=True, nogil=True)
def fill_data(model: Any, chart: int, data: Any) -> None:
    """Write the bounds of a model's data to ``data`` (n + 1, 7, 2).

    A row of a taut cable holds A_i, D_c b_i and l_i^2; the last one the load.
    """
    n = model.n_taut
    for i in range(n):
        for k in range(3):
            x, e = model.anchors[i, k], model.anchors_err[i, k]
            data[i, k, 0], data[i, k, 1] = down(x - e), up(x + e)
            x, e = model.points[chart, i, k], model.points_err[i, k]
            data[i, 3 + k, 0], data[i, 3 + k, 1] = down(x - e), up(x + e)
        x, e = model.lengths_sq[i], model.lengths_sq_err[i]
        data[i, 6, 0], data[i, 6, 1] = down(x - e), up(x + e)
    for k in range(3):
        x, e = model.load[k], model.load_err[k]
        data[n, k, 0], data[n, k, 1] = down(x - e), up(x + e)


@njit("void(f8[:, :, ::1], f8[:, :, ::1], i8, f8[:, ::1])", cache=True, nogil=True)
def matrix_point(M: Any, data: Any, i: int, out: Any) -> None:
    """Enclose M b_i in out (3, 2)."""
    for r in range(3):
        lo, hi = 0.0, 0.0
        for c in range(3):
            a0, a1 = interval.mul(M[r, c, 0], M[r, c, 1], data[i, 3 + c, 0], data[i, 3 + c, 1])
            lo, hi = interval.add(lo, hi, a0, a1)
        out[r, 0] = lo
        out[r, 1] = hi


@njit(
    "void(i8, i8, f8, f8, f8[:, ::1], f8[:, ::1], f8[:, ::1], f8[:, :, ::1], f8[:, :, ::1])",
    cache=True,
    nogil=True,
)
def cable_derivatives(n: int, i: int, t0: float, t1: float, r: Any, q: Any, e: Any, dr: Any, J: Any) -> None:
    """Add cable i's part of the derivatives by u and p."""
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


@njit("void(f8[:, :, ::1], f8[:, ::1], f8[:, ::1], f8[:, :, ::1], b1)", cache=True, nogil=True)
def system(data: Any, z: Any, f: Any, J: Any, jacobian: bool) -> None:
    """Enclose all n + 6 equations f (n + 6, 2) and, if asked, their derivatives J (n + 6, 6 + n, 2)."""
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


@njit("void(i8, f8[:, ::1], f8[:, ::1], f8[:, ::1])", cache=True, nogil=True)
def keep(n: int, rows: Any, f: Any, out: Any) -> None:
    """Keep the n length equations and the combinations ``rows`` of the statics ones of f (n + 6, 2)."""
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


@njit(
    "void(f8[:, :, ::1], f8[:, ::1], i8[::1], f8[:, ::1], f8[:, ::1], f8[:, :, ::1])", cache=True, nogil=True
)
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


@njit("void(f8[:, :, ::1], f8[:, ::1], f8[:, ::1], f8[:, ::1])", cache=True, nogil=True)
def residual_at(data: Any, rows: Any, z: Any, out: Any) -> None:
    """Enclose the reduced equations (m, 2) over the box z (6 + n, 2)."""
    n = data.shape[0] - 1
    f = np.empty((n + 6, 2))
    unused = np.empty((1, 1, 2))
    system(data, z, f, unused, False)
    keep(n, rows, f, out)


@njit("b1(f8[:, :, ::1], f8[:, ::1])", cache=True, nogil=True)
def inverse_at(J: Any, C: Any) -> bool:
    """Write the float inverse of the middle of J (m, m, 2) to C (m, m)."""
    m = J.shape[0]
    a = np.zeros((m, 2 * m))
    for i in range(m):
        for j in range(m):
            a[i, j] = 0.5 * (J[i, j, 0] + J[i, j, 1])
        a[i, m + i] = 1.0
    if not solve_in_place(a, m, m):
        return False
    for i in range(m):
        for j in range(m):
            C[i, j] = a[i, m + j]
    return True


@njit("b1(f8[:, :, ::1], f8[:, ::1], i8[::1], f8[::1], f8[:, ::1], i8)", cache=True, nogil=True)
def newton(data: Any, rows: Any, free: Any, z: Any, C: Any, steps: int) -> bool:
    """Improve z (6 + n,) by Newton steps in floats; True when it converged.

    Near the root the derivative is kept, which costs a third and converges as fast as the steps are small;
    ``C`` (m, m) is left as the inverse of the last one.
    """
    m = free.shape[0]
    box = np.empty((z.shape[0], 2))
    J = np.empty((m, m, 2))
    f = np.empty((m, 2))
    last, fresh = math.inf, True
    for _ in range(steps):
        for k in range(z.shape[0]):
            box[k, 0] = z[k]
            box[k, 1] = z[k]
        if fresh:
            jacobian_over(data, rows, free, box, f, J)
            if not inverse_at(J, C):
                return False
        else:
            residual_at(data, rows, box, f)
        step = 0.0
        for i in range(m):
            change = 0.0
            for j in range(m):
                change += C[i, j] * (0.5 * (f[j, 0] + f[j, 1]))
            z[free[i]] -= change
            step = max(step, abs(change) / (1.0 + abs(z[free[i]])))
        if not step < 1e6:
            return False
        if step < 1e-14 or (step < 1e-10 and step >= last):
            return True
        fresh = step > KEEP_BELOW or step > SLOW * last
        last = step
    return last < 1e-9


@njit(
    "void(f8[:, :, ::1], f8[:, ::1], i8[::1], f8[:, ::1], f8[:, ::1], f8[:, :, ::1])", cache=True, nogil=True
)
def krawczyk_matrix(data: Any, rows: Any, free: Any, C: Any, z: Any, out: Any) -> None:
    """Enclose I - C J(z) in out (m, m, 2)."""
    m = free.shape[0]
    J, f = np.empty((m, m, 2)), np.empty((m, 2))
    jacobian_over(data, rows, free, z, f, J)
    for i in range(m):
        for j in range(m):
            lo = 1.0 if i == j else 0.0
            hi = lo
            for k in range(m):
                a, b = interval.scale(C[i, k], J[k, j, 0], J[k, j, 1])
                lo, hi = interval.sub(lo, hi, a, b)
            out[i, j, 0] = lo
            out[i, j, 1] = hi


@njit("b1(f8[:, :, ::1], f8[:, ::1], i8[::1], f8[:, ::1], f8[:, ::1], f8[:, ::1])", cache=True, nogil=True)
def krawczyk(data: Any, rows: Any, free: Any, C: Any, z: Any, image: Any) -> bool:
    """Apply the Krawczyk operator to the box z (6 + n, 2); True when the image lies strictly inside.

    Guarantee: True proves that for every choice of the data in their enclosures (lengths in
    their ranges included) the box holds exactly one zero of the reduced square system, and that
    it lies in ``image``. (R. Krawczyk 1969; R. E. Moore 1977; S. M. Rump, Acta Numerica 2010, thm 13.2.)
    The middle is a point box inside z, and the derivative enclosure is that of z itself.
    """
    m = free.shape[0]
    middle = np.empty_like(z)
    for k in range(z.shape[0]):
        x = interval.mid(z[k, 0], z[k, 1])
        middle[k, 0] = x
        middle[k, 1] = x
        image[k, 0] = z[k, 0]
        image[k, 1] = z[k, 1]
    # Fixed unknowns keep their (exact, zero-width) values in both.
    f = np.empty((m, 2))
    residual_at(data, rows, middle, f)
    E = np.empty((m, m, 2))
    krawczyk_matrix(data, rows, free, C, z, E)
    inside = True
    for i in range(m):
        x = middle[free[i], 0]
        lo, hi = x, x
        for k in range(m):
            a, b = interval.scale(C[i, k], f[k, 0], f[k, 1])
            lo, hi = interval.sub(lo, hi, a, b)
        for j in range(m):
            y = middle[free[j], 0]
            d0, d1 = interval.sub(z[free[j], 0], z[free[j], 1], y, y)
            a, b = interval.mul(E[i, j, 0], E[i, j, 1], d0, d1)
            lo, hi = interval.add(lo, hi, a, b)
        image[free[i], 0] = lo
        image[free[i], 1] = hi
        if not (z[free[i], 0] < lo and hi < z[free[i], 1]):
            inside = False
    return inside


@njit("f8(f8[:, :, ::1], i8[::1], f8[:, ::1])", cache=True, nogil=True)
def stretch(E: Any, free: Any, z: Any) -> float:
    """Return how much |E| stretches a positive vector: below 1 only with a proof for E (m, m, 2).

    The vector comes from power iteration, started at the half widths of the box z; the value estimates the
    spectral radius of |E| from above.
    """
    m = free.shape[0]
    v = np.empty(m)
    image = np.empty(m)
    for i in range(m):
        v[i] = up(z[free[i], 1] - z[free[i], 0]) + 1e-300
    best = math.inf
    for _ in range(PERRON_STEPS):
        smaller = True
        ratio, largest = 0.0, 0.0
        for i in range(m):
            total = 0.0
            for j in range(m):
                total = up(total + up(interval.mag(E[i, j, 0], E[i, j, 1]) * v[j]))
            image[i] = total
            if not v[i] > 0.0:
                return best
            smaller = smaller and total < v[i]
            ratio = max(ratio, total / v[i])
            largest = max(largest, total)
        if not largest < math.inf:
            return math.inf
        best = min(best, min(ratio, BELOW_ONE) if smaller else max(ratio, 1.0))
        if not largest > 0.0 or best < GOOD:
            return best
        for i in range(m):
            # The floor keeps v positive and the comparison strict where a row of E vanishes.
            v[i] = image[i] / largest + PERRON_FLOOR * v[i]
    return best


@njit("f8(f8[:, :, ::1], f8[:, ::1], i8[::1], f8[:, ::1], f8[:, ::1])", cache=True, nogil=True)
def growth(data: Any, rows: Any, free: Any, C: Any, z: Any) -> float:
    """Return how much |I - C J(z)| stretches a positive vector: below 1 only with a proof.

    Guarantee: a value below 1 proves that the square system has at most one zero in the box z, for every
    choice of data. Proof: |I - C J(z)| v < v for one v > 0 shows that every matrix in C J(z) is regular; two
    zeros would differ by a kernel vector of one of them (mean value theorem, row by row).
    """
    m = free.shape[0]
    E = np.empty((m, m, 2))
    krawczyk_matrix(data, rows, free, C, z, E)
    return float(stretch(E, free, z))


def regular(data: Any, rows: Any, free: Any, C: Any, z: Any) -> bool:
    """Return True when the square system has at most one zero in the box z (for every choice of data)."""
    return bool(growth(data, rows, free, C, z) < 1.0)
