"""Small matrices of intervals: products, linear systems, kernels and definiteness, each with a proof.

An interval matrix is an array (rows, columns, 2) of bounds lo <= hi; it stands for every real matrix with
entries inside. Floats only guess: what is returned holds for all of these matrices. Signatures are
explicit, so that every kernel is compiled once.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.kernels import interval
from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.kernel import entry
from cdpr_interval.kernels.rounding import down, up

POSITIVE, NEGATIVE, OPEN = 1, -1, 0
"""What ``definiteness`` proves: positive definite, negative along one direction, neither."""


@entry("void(f8[:, :, ::1], f8[:, :, ::1], f8[:, :, ::1])")
def multiply(A: Any, B: Any, out: Any) -> None:
    """Enclose A B in out (m, n, 2) for A (m, k, 2) and B (k, n, 2)."""
    for i in range(A.shape[0]):
        for j in range(B.shape[1]):
            lo, hi = 0.0, 0.0
            for k in range(A.shape[1]):
                a, b = interval.mul(A[i, k, 0], A[i, k, 1], B[k, j, 0], B[k, j, 1])
                lo, hi = interval.add(lo, hi, a, b)
            out[i, j, 0] = lo
            out[i, j, 1] = hi


@entry("void(f8[:, :, ::1], f8[:, :, ::1], f8[:, :, ::1])")
def congruence(W: Any, Q: Any, out: Any) -> None:
    """Enclose W^T Q W in out (d, d, 2) for a symmetric Q (n, n, 2) and W (n, d, 2)."""
    n, d = W.shape[0], W.shape[1]
    turned = np.empty((d, n, 2))
    half = np.empty((n, d, 2))
    for i in range(n):
        for j in range(d):
            turned[j, i, 0] = W[i, j, 0]
            turned[j, i, 1] = W[i, j, 1]
    multiply(Q, W, half)
    multiply(turned, half, out)


@entry("void(f8[:, :, ::1], f8[:, ::1], i8, f8[::1], f8, f8[:, :, ::1])")
def solve_column(A: Any, a: Any, j: int, slack: Any, norm: float, X: Any) -> None:
    """Enclose column j of the solutions X (m, c, 2) of the systems A (m, m + c, 2), see ``solve``.

    The last m columns of ``a`` (m, 2 m) hold C, and ``slack`` (m,) the row sums of |I - C M|, the largest of
    which is ``norm``.
    """
    m = A.shape[0]
    guess = np.zeros(m)
    residual = np.empty((m, 2))
    for i in range(m):
        for k in range(m):
            guess[i] += a[i, m + k] * (0.5 * (A[k, m + j, 0] + A[k, m + j, 1]))
    for k in range(m):
        lo, hi = A[k, m + j, 0], A[k, m + j, 1]
        for i in range(m):
            p, q = interval.scale(guess[i], A[k, i, 0], A[k, i, 1])
            lo, hi = interval.sub(lo, hi, p, q)
        residual[k, 0] = lo
        residual[k, 1] = hi
    most = 0.0
    for i in range(m):
        lo, hi = 0.0, 0.0
        for k in range(m):
            p, q = interval.scale(a[i, m + k], residual[k, 0], residual[k, 1])
            lo, hi = interval.add(lo, hi, p, q)
        X[i, j, 0] = lo
        X[i, j, 1] = hi
        most = max(most, interval.mag(lo, hi))
    most = up(most / down(1.0 - norm))
    for i in range(m):
        error = up(slack[i] * most)
        X[i, j, 0] = down(guess[i] + down(X[i, j, 0] - error))
        X[i, j, 1] = up(guess[i] + up(X[i, j, 1] + error))


@entry("b1(f8[:, :, ::1], f8[:, :, ::1])")
def solve(A: Any, X: Any) -> bool:
    """Enclose the solutions X (m, c, 2) of the systems A (m, m + c, 2) = [M | B].

    Guarantee: where True is returned, every matrix in M is regular and M^-1 B lies in X for every B. With C a
    float inverse, x~ = C b and E = I - C M: d = x - x~ satisfies d = C (b - M x~) + E d, hence
    |d| <= |r| / (1 - |E|) in the maximum norm and then d in r + E [-1, 1] |d|. With |E| < 1, M is regular.
    """
    m, c = A.shape[0], A.shape[1] - A.shape[0]
    a = np.zeros((m, 2 * m))
    for i in range(m):
        for j in range(m):
            a[i, j] = 0.5 * (A[i, j, 0] + A[i, j, 1])
        a[i, m + i] = 1.0
    if not solve_in_place(a, m, m) or not np.isfinite(a).all():
        return False
    slack = np.empty(m)
    norm = 0.0
    for i in range(m):
        slack[i] = 0.0
        for j in range(m):
            lo, hi = (1.0, 1.0) if i == j else (0.0, 0.0)
            for k in range(m):
                p, q = interval.scale(a[i, m + k], A[k, j, 0], A[k, j, 1])
                lo, hi = interval.sub(lo, hi, p, q)
            slack[i] = up(slack[i] + interval.mag(lo, hi))
        # Also False for NaN.
        if not slack[i] < 1.0:
            return False
        norm = max(norm, slack[i])
    for j in range(c):
        solve_column(A, a, j, slack, norm, X)
    return bool(np.isfinite(X).all())


@entry("b1(f8[:, :, ::1], i8[::1])")
def pivot_columns(G: Any, columns: Any) -> bool:
    """Order the columns (n,) of G (m, n, 2) so that the first m are well conditioned (complete pivoting)."""
    m, n = G.shape[0], G.shape[1]
    a = np.empty((m, n))
    for j in range(n):
        columns[j] = j
        for i in range(m):
            a[i, j] = 0.5 * (G[i, j, 0] + G[i, j, 1])
    for k in range(m):
        row, column = k, k
        for i in range(k, m):
            for j in range(k, n):
                if abs(a[i, j]) > abs(a[row, column]):
                    row, column = i, j
        if not 0.0 < abs(a[row, column]) < 1e300:
            return False
        for j in range(n):
            a[k, j], a[row, j] = a[row, j], a[k, j]
        for i in range(m):
            a[i, k], a[i, column] = a[i, column], a[i, k]
        columns[k], columns[column] = columns[column], columns[k]
        for i in range(k + 1, m):
            f = a[i, k] / a[k, k]
            for j in range(k, n):
                a[i, j] -= f * a[k, j]
    return True


@entry("b1(f8[:, :, ::1], f8[:, :, ::1])")
def kernel_basis(G: Any, basis: Any) -> bool:
    """Enclose a basis (n, n - m, 2) of the kernel of G (m, n, 2), m < n.

    Guarantee: where True is returned, every matrix in G has full row rank, and the columns of one matrix in
    ``basis`` span its kernel. With the columns ordered as G = [P | F] the basis is (-P^-1 F; I).
    """
    m, n = G.shape[0], G.shape[1]
    columns = np.empty(n, dtype=np.int64)
    if not pivot_columns(G, columns):
        return False
    ordered = np.empty((m, n, 2))
    X = np.empty((m, n - m, 2))
    for j in range(n):
        for i in range(m):
            ordered[i, j, 0] = G[i, columns[j], 0]
            ordered[i, j, 1] = G[i, columns[j], 1]
    if not solve(ordered, X):
        return False
    for j in range(n - m):
        for i in range(m):
            basis[columns[i], j, 0] = -X[i, j, 1]
            basis[columns[i], j, 1] = -X[i, j, 0]
        for i in range(m, n):
            basis[columns[i], j, 0] = 1.0 if i == m + j else 0.0
            basis[columns[i], j, 1] = basis[columns[i], j, 0]
    return True


@entry("i8(f8[:, :, ::1])")
def definiteness(Q: Any) -> int:
    """Return ``POSITIVE``, ``NEGATIVE`` or ``OPEN`` for the symmetric matrices in Q (d, d, 2).

    Guarantee: POSITIVE, every symmetric matrix in Q is positive definite: S Q S^T is strictly diagonally
    dominant with a positive diagonal for one S (Gershgorin; such an S is regular). NEGATIVE: one
    direction makes all of them negative. S comes from a float L D L^T of the middle.
    """
    d = Q.shape[0]
    a = np.empty((d, d))
    S = np.zeros((d, d, 2))
    for i in range(d):
        S[i, i, 0] = 1.0
        for j in range(d):
            a[i, j] = 0.25 * (Q[i, j, 0] + Q[i, j, 1] + Q[j, i, 0] + Q[j, i, 1])
    lowest, worst = -1, 0.0
    for k in range(d):
        if not 1e-300 < abs(a[k, k]) < 1e300:
            return OPEN
        norm = 0.0
        for j in range(k + 1):
            norm += S[k, j, 0] * S[k, j, 0]
        if a[k, k] / norm < worst:
            lowest, worst = k, a[k, k] / norm
        for i in range(k + 1, d):
            f = a[i, k] / a[k, k]
            for j in range(k, d):
                a[i, j] -= f * a[k, j]
            for j in range(k + 1):
                S[i, j, 0] -= f * S[k, j, 0]
    if not np.isfinite(S).all():
        return OPEN
    if lowest >= 0:
        direction = np.empty((d, 1, 2))
        value = np.empty((1, 1, 2))
        for j in range(d):
            direction[j, 0, 0] = S[lowest, j, 0]
            direction[j, 0, 1] = S[lowest, j, 0]
        congruence(direction, Q, value)
        return NEGATIVE if value[0, 0, 1] < 0.0 else OPEN
    columns = np.empty((d, d, 2))
    for i in range(d):
        scale = 1.0 / math.sqrt(a[i, i])
        for j in range(d):
            columns[j, i, 0] = S[i, j, 0] * scale
            columns[j, i, 1] = columns[j, i, 0]
    congruence(columns, Q, S)
    for i in range(d):
        others = 0.0
        for j in range(d):
            if j != i:
                others = up(others + interval.mag(S[i, j, 0], S[i, j, 1]))
        if not S[i, i, 0] > others:
            return OPEN
    return POSITIVE
