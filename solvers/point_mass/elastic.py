"""Elastic poses where a cable is just taut or just slack, or whose length ranges are wide.

The energy of springs has exactly one minimum, whatever the lengths (see `solvers.point_mass.gradient`):
existence and uniqueness need no computation, only the enclosure and the cables' states do.
"""

from __future__ import annotations

import numpy as np

from cdpr_interval.kernels.interval import mul, sub
from solvers.point_mass.arrays import Cables, RobotArrays, is_range
from solvers.point_mass.degenerate import Enclosed, open_note
from solvers.point_mass.fields import OPEN, SLACK, TAUT, distance
from solvers.point_mass.gradient import gradient_krawczyk
from solvers.point_mass.one_call import anywhere, guess_elastic, middles
from solvers.point_mass.switching import just_switching
from solvers.point_mass.trap import trap


def settle_springs(arrays: RobotArrays, cables: Cables) -> Enclosed:
    """Enclose the pose of elastic cables without knowing which of them are taut."""
    _, exits, lengths, stiffness, axial = cables
    load, count = arrays.load, len(lengths)
    A, L, k, f = middles(cables, load)
    taut = np.zeros(max(count, 4), dtype=np.int64)
    x = np.zeros(3 + max(count, 4))
    guess_elastic(A, L, k, f, taut, x)
    box, domain = np.empty((3, 2)), np.empty((3, 2))
    guess = x[:3].copy()
    if not (np.isfinite(guess).all() and gradient_krawczyk(cables, load, guess, anywhere(3), box, domain)):
        box = trap(cables, load)
    tension = np.zeros((count, 2))
    states = np.full(count, SLACK, dtype=np.int64)
    for i in range(count):
        near, far = distance(exits, i, box)
        if far <= lengths[i, 0]:
            continue
        states[i] = TAUT if near > lengths[i, 1] else OPEN
        # k (rho - l), with k l as it is known.
        lo, hi = sub(*mul(*stiffness[i], near, far), *axial[i])
        tension[i] = max(lo, 0.0), max(hi, 0.0)
    if not is_range(lengths):
        states = just_switching(arrays, cables, box, tension, states)
    return Enclosed(box, tension, states, open_note(arrays, lengths, states))
