"""One leg of a way of a platform on real cables: its pose for all lengths there, and what cables do.

While the lengths go straight from one place of the way to another they are l = m + s v + r with -1/2 <= s <=
1/2, the same s for all cables, and r of each within its own bounds. They enter the equations of
``real.system`` as they are, so that C F at a point is that for l = m and C (s v + r): what goes together
stays together. Krawczyk's operator then proves one zero for each choice.

Arrays: ``at`` is a ``Bench`` of n taut cables and N - n slack ones; z (6 + n,), ``C`` (6 + n, 6 + n); boxes
(6 + n, 2) bound (u, p, t).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.engine.krawczyk import Contractions, Tries, around, correction, preconditioner
from cdpr_interval.kernels import interval
from cdpr_interval.kernels.box import point
from cdpr_interval.kernels.kernel import entry
from cdpr_interval.kernels.rounding import up
from solvers.six_dof.real.columns import FREE, LEAST_FREE, OFF_LENGTH, OFF_POINT, PATH
from solvers.six_dof.real.system import deviate, see_over, system, turning

STEPS = (Tries(boxes=6, growth=1.25, kept=1.0), Contractions(most=3, gain=0.9))
ROUNDED = 1e-14
"""Covers the rounding of a sum of a few products, relative to their sizes."""

HELD, SLACKENS, TIGHTENS, LIFTS, ENDS = range(5)
"""What is proved of a leg: all of it, or not because a taut cable may become slack, a slack one taut, a rope
lift off its pulley or come too near to it, or because no one zero is proved."""


@entry()
def prove(at: Any, z: Any, way: Any, room: Any, cover: Any, C: Any, box: Any, domain: Any) -> bool:
    """Prove the zero near z for all lengths on a leg; the model has those in its middle.

    ``way`` (n,) is v and ``room`` (n,) bounds |r|, of the taut cables. ``cover`` is a box that ``domain`` has
    to hold.

    Guarantee: with True there is exactly one zero in ``domain`` for each choice of the lengths; it lies in
    ``box``.
    """
    m, n = C.shape[0], way.shape[0]
    here, f, J, shift = np.empty((m, 2)), np.empty((m, 2)), np.empty((m, m, 2)), np.empty((m, 2))
    point(z, here)
    if not (system(at, here, f, J, True) and preconditioner(J, C) and np.isfinite(C).all()):
        return False
    correction(C, f, shift)
    for i in range(m):
        along, size, apart = 0.0, 0.0, 0.0
        for j in range(n):
            along += C[i, j] * way[j]
            size += abs(C[i, j] * way[j])
            apart += abs(C[i, j]) * room[j]
        off = up((0.5 * abs(along) + ROUNDED * size + apart) * (1.0 + ROUNDED))
        shift[i, 0], shift[i, 1] = interval.add(shift[i, 0], shift[i, 1], -off, off)
    return bool(around(deviate, (at, C), z, shift, cover, STEPS, box, domain))


@entry()
def loads(at: Any, box: Any, switching: int, spans: Any) -> tuple[int, int]:
    """Prove over a box that taut cables carry and that the others are slack; else say why not, and which.

    Of the taut cable ``switching`` (-1: none) no tension is asked. ``spans`` (N, 4) is given the bounds of
    free lengths and of path lengths of the cables looked at.
    """
    real = at.real
    middle, R, dR = np.empty((3, 3)), np.empty((3, 3, 2)), np.empty((3, 3, 3, 2))
    turned = turning(real, at.chart, box, middle, R, dR)
    status, cable = HELD, -1
    for i in range(real.exits.shape[0]):
        is_taut = i < real.n_taut
        if is_taut and i != switching and not box[6 + i, 0] > 0.0:
            return SLACKENS, i
        reach = see_over(real, i, middle, turned, box, at.seen)
        if not reach < math.inf:
            if is_taut:
                return LIFTS, i
            status, cable = LIFTS, i
            continue
        off = (1.0 + real.sway[i] / at.seen[i, LEAST_FREE]) * reach * (1.0 + 1e-12)
        off = up(off + at.seen[i, OFF_POINT])
        spans[i, 0], spans[i, 1] = interval.add(at.seen[i, FREE], at.seen[i, FREE], -off, off)
        spans[i, 0] = max(spans[i, 0], 0.0)
        far = up(reach + at.seen[i, OFF_LENGTH])
        spans[i, 2], spans[i, 3] = interval.add(at.seen[i, PATH], at.seen[i, PATH], -far, far)
        if not (is_taut or spans[i, 3] < real.lengths[i, 0]):
            return TIGHTENS, i
    return status, cable
