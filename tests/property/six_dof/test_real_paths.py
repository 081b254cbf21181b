"""What is said of a cable over a ball of anchors holds at sampled anchors, near its swivel axis, too."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cdpr_interval.kernels.kernel import entry
from solvers.six_dof.real.columns import (
    ALONG,
    DRIFT,
    FOOT,
    FREE,
    LEAST_FREE,
    LOOSE,
    PATH,
    SEEN,
)
from solvers.six_dof.real.path import around, see
from tests.support.planted.pulleys import plant


@entry()
def see_around(real: Any, i: int, x: Any, reach: float, seen: Any) -> bool:
    """See a cable from x (3,) and bound it within a reach."""
    see(real, i, x[0], x[1], x[2], seen)
    return bool(around(real, i, reach, seen))


@pytest.mark.parametrize("near", [0.02, 0.2, 2.0])
@pytest.mark.parametrize("seed", range(6))
def test_length_and_tangent_point_stay_within_their_bounds(seed: int, near: float) -> None:
    """``near`` : how far anchors are from the swivel axis, m."""
    planted = plant(seed, 4)
    real = planted.real()
    rng = np.random.default_rng(seed)
    seen = np.zeros((4, SEEN))
    looked = 0
    for _ in range(300):
        i = int(rng.integers(4))
        cable = planted.cables[i]
        k = cable.axis / np.linalg.norm(cable.axis)
        side = rng.normal(size=3)
        side -= (side @ k) * k
        side *= near * rng.random() / np.linalg.norm(side)
        x = cable.exit - k * rng.uniform(0.3, 2.0) + side
        reach = 10.0 ** rng.uniform(-4.0, 0.0)
        if not see_around(real, i, x, reach, seen):
            continue
        looked += 1
        foot, start = seen[i, FOOT : FOOT + 3], seen[i, PATH] - seen[i, FREE]
        length, along, free = cable.path(x)
        assert abs(length - seen[i, PATH]) < 1e-12
        assert np.allclose(along, seen[i, ALONG : ALONG + 3], atol=1e-9)
        for _ in range(20):
            step = rng.normal(size=3)
            other = x + step * (reach * rng.random() ** 0.3 / np.linalg.norm(step))
            length, along, free = cable.path(other)
            assert free >= seen[i, LEAST_FREE]
            assert abs(length - (np.linalg.norm(other - foot) + start)) <= seen[i, LOOSE] + 1e-12
            assert np.linalg.norm(other - free * along - foot) <= seen[i, DRIFT] + 1e-12
    assert looked > 20
