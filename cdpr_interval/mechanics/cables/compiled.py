"""The laws of straight cables in compiled interval arithmetic, with the derivatives that solvers need.

Arrays: ``cables`` is ``(elastic, exits, lengths, k, w)``: (N,) flags; (N, 3, 2) exit points; (N, 2) lengths
(unstretched, m); (N, 2) spring constants k (N/m); (N, 2) enclosures of k l (N). The last axis is (lo, hi). A
density t is tension / distance, N/m: the multiplier of a cable's length. A new law is a branch of these
functions, and of no others.
"""

from __future__ import annotations

import math
from typing import Any

from cdpr_interval.kernels.interval import div, sqr, sub
from cdpr_interval.kernels.kernel import kernel


@kernel(inline="always")
def reach(cables: Any, c: int, t_lo: float, t_hi: float) -> tuple[float, float]:
    """Enclose h(t): the distance at which cable ``c`` has the density t; the line where t reaches k."""
    elastic, _, lengths, k, w = cables
    if not elastic[c]:
        return lengths[c, 0], lengths[c, 1]
    lo, hi = sub(k[c, 0], k[c, 1], t_lo, t_hi)
    if not lo > 0.0:
        # t = k - k l / |e| is below k; beyond it h^2 has a branch without meaning.
        return -math.inf, math.inf
    return div(w[c, 0], w[c, 1], lo, hi)


@kernel(inline="always")
def compliance(cables: Any, c: int, t_lo: float, t_hi: float) -> tuple[float, float]:
    """Enclose d/dt (-h(t)^2 / 2) = -h^2 / (k - t) of cable ``c``."""
    elastic, _, _, k, _ = cables
    if not elastic[c]:
        return 0.0, 0.0
    lo, hi = reach(cables, c, t_lo, t_hi)
    lo, hi = sqr(lo, hi)
    klo, khi = sub(k[c, 0], k[c, 1], t_lo, t_hi)
    lo, hi = div(lo, hi, klo, khi)
    return -hi, -lo


@kernel(inline="always")
def density(cables: Any, c: int, near: float, far: float) -> tuple[float, float]:
    """Enclose max(0, k - k l / rho) of an elastic cable ``c`` for distances rho from near > 0 to far."""
    _, _, _, k, w = cables
    lo, hi = div(w[c, 0], w[c, 1], near, far)
    lo, hi = sub(k[c, 0], k[c, 1], lo, hi)
    return max(lo, 0.0), max(hi, 0.0)
