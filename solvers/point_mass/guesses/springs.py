"""The minimum of the energy of a point mass on springs in plain floating point: a guess, proved elsewhere.

E(p) = sum k_i / 2 max(0, |p - A_i| - l_i)^2 - f . p is convex; its gradient is piecewise smooth. Newton's
method on the gradient with an exact search along each direction decreases E at every step.

Arrays: ``A`` (N, 3) exit points, ``L`` (N,) lengths, ``k`` (N,) spring constants, ``f`` (3,) load; ``p, q``
(3,) points, ``g`` (3,) a gradient, ``step`` (3,) a direction; ``work`` (3, 4) is scratch for a linear
system.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.kernel import entry

STEPS = 200
"""Most Newton steps: 5 to 15 are usual, stiff springs that change state one at a time need more."""
SECTIONS = 60
"""Most bisections of one line search: to the last digit of the step."""
RESIDUAL = 1e-15
"""Relative residual at which the iteration ends: the rounding error of the sum of the forces."""


@entry()
def gradient(A: Any, L: Any, k: Any, f: Any, p: Any, g: Any) -> float:
    """Write sum of the spring forces minus f at p; return the sum of the force magnitudes."""
    size = 0.0
    for j in range(3):
        g[j] = -f[j]
        size += abs(f[j])
    for i in range(A.shape[0]):
        x, y, z = p[0] - A[i, 0], p[1] - A[i, 1], p[2] - A[i, 2]
        rho = math.sqrt(x * x + y * y + z * z)
        if rho > L[i]:
            t = k[i] * ((rho - L[i]) / rho)
            g[0] += t * x
            g[1] += t * y
            g[2] += t * z
            # A unit roundoff of the distance is a force of this size.
            size += t * rho + k[i] * rho
    return size


@entry()
def direction(A: Any, L: Any, k: Any, f: Any, p: Any, g: Any, work: Any, step: Any) -> bool:
    """Write the Newton direction at p, with a little damping where the energy is flat."""
    for a in range(3):
        for b in range(4):
            work[a, b] = 0.0
        work[a, 3] = -g[a]
    size = 1.0
    for i in range(A.shape[0]):
        size = max(size, L[i])
        x, y, z = p[0] - A[i, 0], p[1] - A[i, 1], p[2] - A[i, 2]
        rho = math.sqrt(x * x + y * y + z * z)
        if rho > L[i]:
            t = k[i] * ((rho - L[i]) / rho)
            c = (k[i] - t) / (rho * rho)
            work[0, 0] += t + c * x * x
            work[0, 1] += c * x * y
            work[0, 2] += c * x * z
            work[1, 1] += t + c * y * y
            work[1, 2] += c * y * z
            work[2, 2] += t + c * z * z
    work[1, 0], work[2, 0], work[2, 1] = work[0, 1], work[0, 2], work[1, 2]
    trace = work[0, 0] + work[1, 1] + work[2, 2]
    force = math.sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2])
    for a in range(3):
        # Where every cable is slack the energy is linear: go down by the size of the robot.
        work[a, a] += 1e-15 * trace if trace > 0.0 else force / size
    if not solve_in_place(work, 3, 1):
        return False
    for a in range(3):
        step[a] = work[a, 3]
    return True


@entry()
def slope(A: Any, L: Any, k: Any, f: Any, p: Any, step: Any, a: float, q: Any, g: Any) -> float:
    """Return the derivative of E along ``step`` at p + a step, writing that point and its gradient."""
    for j in range(3):
        q[j] = p[j] + a * step[j]
    gradient(A, L, k, f, q, g)
    return g[0] * step[0] + g[1] * step[1] + g[2] * step[2]


@entry()
def lowest_energy(A: Any, L: Any, k: Any, f: Any, p: Any) -> bool:
    """Move p to the minimum of the energy.

    Parameters
    ----------
    A, L, k, f : (N, 3), (N,), (N,), (3,)
        Exit points, unstretched lengths, spring constants and load.
    p : (3,)
        Start, overwritten with the best point found.

    Returns
    -------
    bool
        True when the residual is of the size of the rounding errors.
    """
    g = np.empty(3)
    h = np.empty(3)
    q = np.empty(3)
    step = np.empty(3)
    work = np.empty((3, 4))
    size = gradient(A, L, k, f, p, g)
    best = math.inf
    for _ in range(STEPS):
        norm = math.sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2])
        if not norm < math.inf:
            return False
        if norm <= RESIDUAL * size:
            return True
        if not direction(A, L, k, f, p, g, work, step):
            return False
        start = g[0] * step[0] + g[1] * step[1] + g[2] * step[2]
        a, b = 0.0, 1.0
        s = slope(A, L, k, f, p, step, b, q, h)
        # The slope of a convex function rises: double until it is positive, then bisect.
        if abs(s) > 0.5 * abs(start):
            for _ in range(SECTIONS):
                if s >= 0.0:
                    break
                a = b
                b *= 2.0
                s = slope(A, L, k, f, p, step, b, q, h)
            for _ in range(SECTIONS):
                c = 0.5 * (a + b)
                s = slope(A, L, k, f, p, step, c, q, h)
                if abs(s) <= 0.1 * abs(start) or not a < c < b:
                    break
                if s < 0.0:
                    a = c
                else:
                    b = c
        size = gradient(A, L, k, f, q, h)
        new = math.sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2])
        if norm <= 100.0 * RESIDUAL * size:
            # At the rounding level steps only wander: keep the better point and end.
            if new < norm:
                for j in range(3):
                    p[j] = q[j]
            return True
        best = min(best, new)
        for j in range(3):
            p[j] = q[j]
            g[j] = h[j]
    return best <= 1e-9 * size
