"""The hull of cells holds every pose of each, whatever their charts."""

from __future__ import annotations

import numpy as np
import pytest

from solvers.six_dof.real.columns import REAL_COLUMNS
from solvers.six_dof.real.hull import hull_of
from solvers.six_dof.real.roots import rotation_of


@pytest.mark.parametrize("seed", range(6))
def test_the_hull_holds_every_pose_of_every_cell(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cells = np.zeros((5, REAL_COLUMNS.width))
    low = rng.uniform(-1.0, 1.0, (5, 6))
    cells[:, 0:12:2], cells[:, 1:12:2] = low, low + rng.uniform(0.0, 0.3, (5, 6))
    cells[:, REAL_COLUMNS.chart] = rng.integers(0, 4, 5)
    centre = np.sort(rng.uniform(-0.3, 0.3, (3, 2)), axis=1)
    position, rotation = hull_of(cells, centre)
    for cell in cells:
        for _ in range(50):
            z = rng.uniform(cell[0:12:2], cell[1:12:2])
            R = rotation_of(int(cell[REAL_COLUMNS.chart]), z[:3])
            origin = z[3:] - R @ rng.uniform(centre[:, 0], centre[:, 1])
            assert (rotation[..., 0] - 1e-12 <= R).all() and (rotation[..., 1] + 1e-12 >= R).all()
            assert (position[:, 0] - 1e-12 <= origin).all() and (origin <= position[:, 1] + 1e-12).all()


def test_the_hull_of_points_is_narrow() -> None:
    cells = np.zeros((1, REAL_COLUMNS.width))
    cells[0, :6] = [0.1, 0.1, -0.2, -0.2, 0.3, 0.3]
    cells[0, 6:12] = [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]
    position, rotation = hull_of(cells, np.array([[0.0, 0.0], [0.0, 0.0], [0.5, 0.5]]))
    assert np.ptp(rotation, axis=2).max() < 1e-14 and np.ptp(position, axis=1).max() < 1e-14
