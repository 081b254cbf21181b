"""Singular values of matrices of balls, enclosed by one guess of the decomposition in doubles."""

from __future__ import annotations

import numpy as np
from flint import arb, arb_mat

from cdpr_interval.exact import balls


def singular_values(matrix: arb_mat) -> list[arb]:
    """Enclose the singular values of every matrix in a matrix of balls (m, n), largest first.

    With M = U S V near enough in doubles, the values of U' M V' are within |U' M V' - S| (Frobenius) of S
    (Weyl), and those of M within the factors 1 +- |U' U - I| and 1 +- |V V' - I| of these (Ostrowski). Where
    nothing follows, bounds are infinite.
    """
    m, n = matrix.nrows(), matrix.ncols()
    count = min(m, n)
    middle = balls.middle(matrix)
    if not np.isfinite(middle).all():
        return [arb(0, np.inf)] * count
    u, s, v = np.linalg.svd(middle)
    left, right = arb_mat(u.tolist()), arb_mat(v.tolist())
    core = left.transpose() * matrix * right.transpose()
    diagonal = arb_mat(m, n, [float(s[i]) if i == j else 0 for i in range(m) for j in range(n)])
    off = _size(core - diagonal)
    first = _size(left.transpose() * left - balls.identity(m))
    second = _size(right * right.transpose() - balls.identity(n))
    if not (first < arb(0.5) and second < arb(0.5)):
        return [arb(0, np.inf)] * count
    spread = (1 + first) * (1 + second)
    shrunk = (1 - first) * (1 - second)
    found = []
    for value in s.tolist():
        low = ((arb(value) - off) / spread).nonnegative_part().lower()
        found.append(low.union(((arb(value) + off) / shrunk).upper()))
    return found


def _size(matrix: arb_mat) -> arb:
    """Return an upper bound of the Frobenius norm."""
    return sum((x.abs_upper() ** 2 for x in matrix.entries()), arb(0)).sqrt().upper()
