"""Least squares with non-negative unknowns, for a handful of cables."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

RANK_TOLERANCE = 1e-10
"""Singular values below this share of the largest count as zero."""


def nonnegative_least_squares(matrix: Floats, target: Floats) -> Floats:
    """Return x >= 0 that minimises |matrix x - target|.

    Parameters
    ----------
    matrix : (m, n) array
    target : (m,) array

    Returns
    -------
    (n,) array
        Of all minimisers one with independent columns in use.

    References
    ----------
    Lawson and Hanson, Solving Least Squares Problems, 1974, algorithm NNLS (23.10).
    """
    count = matrix.shape[1]
    x = np.zeros(count)
    passive = np.zeros(count, dtype=bool)
    scale = float(np.abs(matrix).sum(axis=0).max(initial=0.0)) * max(float(np.linalg.norm(target)), 1e-300)
    tolerance = 10 * max(matrix.shape) * np.finfo(float).eps * scale
    # Every pass lowers the residual strictly; the bound only guards against rounding.
    for _ in range(10 * (count + 1)):
        gradient = matrix.T @ (target - matrix @ x)
        gradient[passive] = -np.inf
        entering = int(np.argmax(gradient)) if count else 0
        if count == 0 or gradient[entering] <= tolerance:
            break
        passive[entering] = True
        while True:
            trial = np.zeros(count)
            trial[passive] = np.linalg.lstsq(matrix[:, passive], target, rcond=None)[0]
            negative = passive & (trial <= 0.0)
            if not negative.any():
                break
            step = float(np.min(x[negative] / np.maximum(x[negative] - trial[negative], 1e-300)))
            x = x + step * (trial - x)
            passive &= x > tolerance / max(scale, 1e-300)
            x[~passive] = 0.0
            if not passive.any():
                trial = x
                break
        x = trial
    return x


def smallest_nonnegative_solution(matrix: Floats, target: Floats) -> Floats:
    """Return the x >= 0 of least norm among those that solve matrix x = target.

    Where there is none (up to rounding), the result is that of `nonnegative_least_squares`.

    Parameters
    ----------
    matrix : (m, n) array
    target : (m,) array

    References
    ----------
    Lawson and Hanson, 1974, problem LDP (23.27): with x = x_p + N z the task is to minimise |z|
    subject to N z >= -x_p, which is a non-negative least-squares problem in the multipliers.
    """
    fit = nonnegative_least_squares(matrix, target)
    _, singular, rows = np.linalg.svd(matrix)
    rank = int(np.sum(singular > RANK_TOLERANCE * singular.max(initial=0.0)))
    kernel = rows[rank:].T
    if kernel.shape[1] == 0:
        return fit
    particular = np.linalg.lstsq(matrix, target, rcond=RANK_TOLERANCE)[0]
    size = max(float(np.abs(particular).max(initial=0.0)), 1e-300)
    system = np.vstack([kernel.T, -particular / size])
    unit = np.zeros(len(system))
    unit[-1] = 1.0
    remainder = system @ nonnegative_least_squares(system, unit) - unit
    if abs(remainder[-1]) < RANK_TOLERANCE:
        return fit
    solution = particular - size * (kernel @ remainder[:-1]) / remainder[-1]
    used = solution > RANK_TOLERANCE * size
    polished = np.zeros(len(solution))
    polished[used] = np.linalg.lstsq(matrix[:, used], target, rcond=RANK_TOLERANCE)[0]
    candidates = [x for x in (polished, np.maximum(solution, 0.0)) if (x >= 0.0).all()]
    best = min(candidates, key=lambda x: float(np.linalg.norm(matrix @ x - target)))
    error = float(np.linalg.norm(matrix @ best - target))
    allowed = float(np.linalg.norm(matrix @ fit - target)) + 1e-9 * float(np.linalg.norm(target))
    return best if error <= allowed else fit
