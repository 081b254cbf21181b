"""The hull of cells in the robot's frames: every rotation and every platform origin of their poses.

Arrays: ``cells`` (m, width) with the columns ``REAL_COLUMNS``; boxes have (lo, hi) last.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.kernels import interval
from cdpr_interval.kernels.kernel import entry
from cdpr_interval.mechanics.rotation import HALF_TURNS, rotation_interval
from solvers.six_dof.real.columns import REAL_COLUMNS

Floats = NDArray[np.float64]
CHART = REAL_COLUMNS.chart


def hull_of(cells: Floats, centre: Floats) -> tuple[Floats, Floats]:
    """Return bounds (3, 2) of the platform's origins and (3, 3, 2) of the rotations of cells.

    Parameters
    ----------
    cells : (m, width)
        At least one; of any charts.
    centre : (3, 2)
        Bounds of the centre of mass in the platform frame, m.

    Guarantee
    ---------
    Encloses both for every pose in any of the cells.
    """
    position, rotation = np.empty((3, 2)), np.empty((3, 3, 2))
    enclose(np.ascontiguousarray(cells), np.ascontiguousarray(centre), position, rotation)
    return position, np.clip(rotation, -1.0, 1.0)


@entry()
def enclose(cells: Any, centre: Any, position: Any, rotation: Any) -> None:
    """Write what ``hull_of`` returns, entries of rotations as they come."""
    u, R, unused = np.empty((3, 2)), np.empty((3, 3, 2)), np.empty((3, 3, 3, 2))
    position[:, 0], position[:, 1] = math.inf, -math.inf
    rotation[:, :, 0], rotation[:, :, 1] = math.inf, -math.inf
    for m in range(cells.shape[0]):
        chart = int(cells[m, CHART])
        for k in range(3):
            u[k, 0], u[k, 1] = cells[m, 2 * k], cells[m, 2 * k + 1]
        rotation_interval(u, R, unused)
        for i in range(3):
            lo, hi = cells[m, 6 + 2 * i], cells[m, 7 + 2 * i]
            for j in range(3):
                a, b = R[i, j, 0], R[i, j, 1]
                if HALF_TURNS[chart, j] < 0.0:
                    a, b = -b, -a
                rotation[i, j, 0], rotation[i, j, 1] = min(rotation[i, j, 0], a), max(rotation[i, j, 1], b)
                a, b = interval.mul(a, b, centre[j, 0], centre[j, 1])
                lo, hi = interval.sub(lo, hi, a, b)
            position[i, 0], position[i, 1] = min(position[i, 0], lo), max(position[i, 1], hi)
