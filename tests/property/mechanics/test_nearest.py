"""The nearest point of the wrenches' hull: a direction with positive products whenever there is one."""

from __future__ import annotations

import numpy as np
import pytest

from cdpr_interval.kernels.lanes import LANES
from cdpr_interval.mechanics.six_dof import nearest as platform_nearest
from cdpr_interval.mechanics.six_dof.rows import COLUMNS, WORK, Y
from tests.support.kernel_callers import Callers

CALLERS = Callers(platform_nearest)


def nearest(columns: np.ndarray, lane: int = 1) -> np.ndarray:
    """Return the direction for columns (6, m) in one lane of fresh scratch."""
    work = np.full((WORK.height, WORK.columns, LANES), np.nan)
    work[COLUMNS : COLUMNS + columns.shape[1], :6, lane] = columns.T
    CALLERS.nearest_point(work, lane, columns.shape[1])
    return work[Y, :6, lane]


def unit(columns: np.ndarray) -> np.ndarray:
    return columns / np.linalg.norm(columns, axis=0)


@pytest.mark.parametrize("seed", range(60))
def test_a_direction_is_found_whenever_there_is_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, rank = int(rng.integers(2, 8)), int(rng.integers(2, 7))
    basis = rng.normal(size=(6, rank))
    axis = rng.normal(size=rank)
    axis /= np.linalg.norm(axis)
    inside = rng.normal(size=(rank, m))
    # All columns have a product of at least 0.02 with one direction of the span.
    inside += np.outer(axis, np.abs(axis @ inside) + 0.02 - axis @ inside)
    orthonormal = np.linalg.qr(basis)[0][:, :rank]
    columns = unit(orthonormal @ inside)
    products = columns.T @ nearest(columns)
    assert products.min() > 0.0
    # It is the best one: no direction of its length has a larger least product.
    best = products.min() / np.linalg.norm(nearest(columns))
    for _ in range(300):
        other = orthonormal @ rng.normal(size=rank)
        assert (columns.T @ other).min() / np.linalg.norm(other) <= best + 1e-7


@pytest.mark.parametrize("seed", range(20))
def test_nothing_is_found_around_the_origin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    m = int(rng.integers(3, 8))
    columns = rng.normal(size=(6, m))
    weights = rng.uniform(0.2, 1.0, size=m)
    columns[:, -1] = -(columns[:, :-1] @ weights[:-1]) / weights[-1]
    columns = unit(columns)
    assert (columns.T @ nearest(columns)).min() < 1e-9


def test_a_wrench_that_vanishes_ends() -> None:
    columns = np.zeros((6, 3))
    columns[0] = [1.0, 1.0, np.nan]
    assert nearest(columns).shape == (6,)
