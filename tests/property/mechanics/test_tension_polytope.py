"""Tensions that are not unique: every admissible one lies in the bounds, and bounds are sharp."""

from __future__ import annotations

import numpy as np
import pytest
from flint import arb

from cdpr_interval.exact import balls
from cdpr_interval.mechanics.energy import to_matrix
from cdpr_interval.mechanics.six_dof.tension_polytope import are_independent, tension_bounds, tension_rays


def admissible(columns, start, rng, count=200):
    """Return tensions t >= 0 with the same sum of wrenches as ``start``, by hit and run."""
    null = np.linalg.svd(columns)[2][np.linalg.matrix_rank(columns) :]
    t, found = start.copy(), []
    for _ in range(count):
        way = rng.normal(size=len(null)) @ null
        with np.errstate(divide="ignore"):
            steps = -t / way
        low = max((s for s, d in zip(steps, way, strict=True) if d > 1e-12), default=-1e3)
        high = min((s for s, d in zip(steps, way, strict=True) if d < -1e-12), default=1e3)
        t = np.maximum(t + rng.choice([low, high, rng.uniform(low, high)]) * way, 0.0)
        found.append(t)
    return found


def blurred(middle, radius):
    """Return the balls of a radius around a float matrix, whose own rank means nothing."""
    wide = to_matrix(middle)
    for i in range(wide.nrows()):
        for j in range(wide.ncols()):
            wide[i, j] += arb(0, radius)
    return wide


@pytest.mark.parametrize("seed", range(12))
def test_bounds_hold_all_tensions_and_are_attained(seed):
    rng = np.random.default_rng(seed)
    rank, n = [(3, 4), (3, 5), (6, 7), (6, 8), (5, 6), (2, 4)][seed % 6]
    basis = rng.normal(size=(6, rank))
    # All in one half space: no self-stress.
    columns = basis @ np.vstack([1 + rng.uniform(size=n), rng.normal(size=(rank - 1, n))])
    t = rng.uniform(0.2, 1.0, size=n)
    with balls.precision():
        matrix = blurred(np.column_stack([columns, -columns @ t]), 1e-13)
        rays = tension_rays(matrix)
        assert rays is not None and rays.parts
        assert not are_independent(matrix)
        bounds = tension_bounds(matrix, rays)
    samples = np.array(admissible(columns, t, rng))
    for k, (low, high) in enumerate(bounds):
        assert high is not None
        assert float(low) - 1e-7 <= samples[:, k].min() and samples[:, k].max() <= float(high) + 1e-7
        if n - rank == 1:
            assert samples[:, k].min() - float(low) < 1e-6
            assert float(high) - samples[:, k].max() < 1e-6
        assert not (rays.always(k) and samples[:, k].min() < 1e-9)


def test_cables_that_pull_against_each_other_have_no_upper_bound():
    columns = np.zeros((6, 3))
    columns[:3] = [[1, -1, 0], [0, 0, 0], [1, 1, 1]]
    columns[2] = [0.0, 0.0, 1.0]
    with balls.precision():
        matrix = to_matrix(np.column_stack([columns, [0, 0, -2, 0, 0, 0]]))
        rays = tension_rays(matrix)
        (_, a), (_, b), (low, c) = tension_bounds(matrix, rays)
    assert a is None and b is None
    assert float(low) == pytest.approx(2.0, abs=1e-2) and c is None


def test_over_a_neighbourhood():
    """Bounds for wide wrenches hold for each matrix in them."""
    rng = np.random.default_rng(3)
    basis = rng.normal(size=(6, 3))
    columns = basis @ np.vstack([1 + rng.uniform(size=4), rng.normal(size=(2, 4))])
    t = rng.uniform(0.2, 1.0, size=4)
    middle = np.column_stack([columns, -columns @ t])
    radius = 1e-5
    with balls.precision():
        wide = blurred(middle, radius)
        rays = tension_rays(wide)
        bounds = tension_bounds(wide, rays)
    for _ in range(50):
        moved = columns + rng.uniform(-radius, radius, size=columns.shape)
        # Balance exactly with tensions near t: change the last wrench within its width.
        rest = -(middle[:, 4] + moved[:, :3] @ t[:3]) / t[3]
        if np.all(np.abs(rest - columns[:, 3]) <= radius):
            for k, (low, high) in enumerate(bounds):
                assert float(low) <= t[k] <= float(high)


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_bounds_do_not_depend_on_the_unit_of_force(scale):
    """A robot in mm, or a heavy one: the load's numbers may be any number of times as large."""
    rng = np.random.default_rng(3)
    columns = rng.normal(size=(6, 6)) @ np.vstack([1 + rng.uniform(size=7), rng.normal(size=(5, 7))])
    t = rng.uniform(0.2, 1.0, size=7)
    found = []
    with balls.precision():
        for factor in (1.0, scale):
            matrix = to_matrix(np.column_stack([columns, -factor * (columns @ t)]))
            rays = tension_rays(matrix)
            assert rays is not None and rays.parts
            found.append([float(high) / factor for _, high in tension_bounds(matrix, rays)])
    assert np.allclose(found[0], found[1], rtol=1e-6)
