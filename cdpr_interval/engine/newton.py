"""Newton's method in plain floats: a guess for the zero of a square system, proved elsewhere.

A system hands in two kernels and a context of its own, any tuple:

* ``linearise(context, box, f, C) -> bool`` writes the residuals over a box (n, 2), here always a point, to f
  (n, 2), in bounds, and an approximate inverse of the Jacobian there to C (n, n); False where it is singular;
* ``residual(context, box, f)`` writes the residuals only, as for `cdpr_interval.engine.krawczyk`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from cdpr_interval.kernels.box import point
from cdpr_interval.kernels.kernel import part


class Pace(NamedTuple):
    """When to go on, with a new derivative or the last one, and when to stop.

    A step is measured over 1 + |x|, the largest of all unknowns.
    """

    converged: float = 0.0
    """A shorter step is the last one."""
    stalled: float = 0.0
    """A shorter step that is not shorter than the one before is the last one: only rounding is left."""
    fresh: float = 0.0
    """A longer step asks for a new derivative."""
    slow: float = 0.0
    """So does one that is longer than this share of the one before."""
    lost: float = 1e200
    """A longer step leads nowhere."""


# Inlined into its caller: numba does not cache a call that passes a function as a value.
@part()
def newton(linearise: Any, residual: Any, context: Any, x: Any, C: Any, steps: int, pace: Any) -> float:
    """Improve x (>= n,) by at most ``steps`` Newton steps; return the length of the last one.

    It is infinite where they fail. Near the root the derivative is kept, which costs less and converges as
    fast as the steps are small. ``C`` (n, n) is left as the inverse of the last one; ``pace`` is a `Pace`.
    """
    n = C.shape[0]
    here, f = np.empty((n, 2)), np.empty((n, 2))
    last, fresh = math.inf, True
    for _ in range(steps):
        point(x, here)
        if not fresh:
            residual(context, here, f)
        elif not linearise(context, here, f, C):
            return math.inf
        step = 0.0
        for i in range(n):
            change = 0.0
            for j in range(n):
                change += C[i, j] * (0.5 * (f[j, 0] + f[j, 1]))
            x[i] -= change
            step = max(step, abs(change) / (1.0 + abs(x[i])))
        if not step < pace.lost:
            return math.inf
        if step < pace.converged or (step < pace.stalled and step >= last):
            return step
        fresh = step > pace.fresh or step > pace.slow * last
        last = step
    return last
