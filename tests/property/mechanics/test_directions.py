"""The dual basis of badly conditioned and of dependent wrenches."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from cdpr_interval.kernels.lanes import LANES
from cdpr_interval.mechanics.six_dof import directions as platform_directions
from cdpr_interval.mechanics.six_dof.rows import WORK
from tests.support.kernel_callers import Callers

Floats = NDArray[np.float64]

directions = Callers(platform_directions)


def work(columns: Floats) -> Floats:
    """Return W with normalised columns (LANES, m, 6), and their dual basis."""
    W = np.zeros((WORK.height, WORK.columns, LANES))
    unit = columns / np.linalg.norm(columns, axis=2, keepdims=True)
    for lane in range(LANES):
        W[directions.COLUMNS : directions.COLUMNS + columns.shape[1], :6, lane] = unit[lane]
    directions.dual_columns(W, columns.shape[1])
    return W


@pytest.mark.parametrize("m", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize("distance", [1.0, 1e-3, 1e-6, 1e-9])
def test_the_dual_basis_of_nearly_dependent_columns(m: int, distance: float) -> None:
    """A Gram matrix would have lost all digits at 1e-8."""
    rng = np.random.default_rng(m)
    for _ in range(20):
        columns = rng.normal(size=(LANES, m, 6))
        if m > 1:
            mixed = np.einsum("lj,ljk->lk", rng.normal(size=(LANES, m - 1)), columns[:, :-1])
            columns[:, -1] = mixed + distance * rng.normal(size=(LANES, 6))
        W = work(columns)
        for lane in range(LANES):
            unit = W[directions.COLUMNS : directions.COLUMNS + m, :6, lane]
            dual = W[directions.DUAL : directions.DUAL + m, :6, lane]
            basis = W[directions.BASIS : directions.BASIS + m, :6, lane]
            size = np.abs(dual).max()
            assert np.abs(dual @ unit.T - np.eye(m)).max() < 1e-13 * (1.0 + size)
            assert np.abs(basis @ basis.T - np.eye(m)).max() < 1e-13
            W[directions.COLUMNS : directions.COLUMNS + m, directions.RIGHT, lane] = 1.0 + np.arange(m)
        directions.choose_y(W, m)
        for lane in range(LANES):
            unit = W[directions.COLUMNS : directions.COLUMNS + m, :6, lane]
            y = W[directions.Y, :6, lane]
            assert np.abs(unit @ y - 1.0 - np.arange(m)).max() < 1e-12 * (1.0 + np.abs(y).max())


@pytest.mark.parametrize("place", [1, 2, 3])
def test_a_dependent_column_is_left_out(place: int) -> None:
    """Its direction would be rounding; the others have their dual basis as if it were not there."""
    rng = np.random.default_rng(place)
    for _ in range(20):
        columns = rng.normal(size=(LANES, 4, 6))
        mixed = np.einsum("lj,ljk->lk", rng.normal(size=(LANES, place)), columns[:, :place])
        columns[0, place] = mixed[0]
        W = work(columns)
        others = [j for j in range(4) if j != place]
        for lane in range(LANES):
            unit = W[directions.COLUMNS : directions.COLUMNS + 4, :6, lane]
            dual = W[directions.DUAL : directions.DUAL + 4, :6, lane]
            used = others if lane == 0 else list(range(4))
            assert np.abs((dual @ unit.T)[np.ix_(used, used)] - np.eye(len(used))).max() < 1e-10
            assert dual[place].any() == (lane != 0)
        directions.complete_basis(W, 3)
        for lane in range(1, LANES):
            basis = W[directions.BASIS : directions.BASIS + 6, :6, lane]
            assert np.abs(basis @ basis.T - np.eye(6)).max() < 1e-13


def test_columns_that_are_no_numbers_stay_so() -> None:
    """A wrench that vanishes at the centre proves nothing, in its lane alone."""
    columns = np.random.default_rng(7).normal(size=(LANES, 3, 6))
    columns[1, 1] = np.nan
    W = work(columns)
    dual = W[directions.DUAL : directions.DUAL + 3, :6]
    assert np.isnan(dual[1:, :, 1]).all()
    assert np.isfinite(dual[..., [0, 2, 3]]).all()
