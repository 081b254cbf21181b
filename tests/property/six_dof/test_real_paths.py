"""What is said of a cable over a ball of anchors holds at sampled anchors, near its swivel axis, too."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from cdpr_interval.exact import balls
from cdpr_interval.kernels.kernel import entry
from cdpr_interval.mechanics.cables.path import Balls
from cdpr_interval.mechanics.cables.pulley import OverPulley
from solvers.six_dof.real.columns import (
    ALONG,
    BOTH,
    DRIFT,
    FOOT,
    FREE,
    LEAST_FREE,
    LOOSE,
    OFF_LENGTH,
    PAST,
    PATH,
    PRESSED,
    SEEN,
    STATE,
)
from solvers.six_dof.real.path import around, see
from tests.support.planted.pulleys import any_cable, exact, plant


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


def routed(route: OverPulley, x: np.ndarray) -> tuple[float, np.ndarray, float, bool]:
    """Return length, direction, free part and whether the rope runs past, by the exact route."""
    with balls.precision():
        path = route.path(tuple(balls.from_fraction(Fraction(v)) for v in x.tolist()), Balls())
        free = path.free - route.arriving(Balls()) if path.is_past else path.free
        along = np.array([float(a.mid()) for a in path.direction])
        return float(path.length.mid()), along, float(free.mid()), path.is_past


@pytest.mark.parametrize("seed", range(6))
def test_two_joints_and_lifted_ropes_are_those_of_the_exact_routes(seed: int) -> None:
    """Values at the middle and bounds over balls of all sizes; a rope is on its pulley or not as is said."""
    planted = plant(seed, 4, any_cable)
    real = planted.real()
    rng = np.random.default_rng(seed)
    seen = np.zeros((4, SEEN))
    states: dict[float, int] = {PRESSED: 0, PAST: 0, BOTH: 0}
    for _ in range(120):
        i = int(rng.integers(4))
        cable = planted.cables[i]
        if cable.radius == 0.0:
            continue
        k = cable.axis / np.linalg.norm(cable.axis)
        side = rng.normal(size=3)
        side -= (side @ k) * k
        side *= rng.choice([0.02, 0.2, 2.0]) * rng.random() / np.linalg.norm(side)
        x = cable.exit + k * rng.uniform(-2.0, 2.0) + side
        reach = 10.0 ** rng.uniform(-4.0, -0.3)
        if not see_around(real, i, x, reach, seen):
            continue
        states[seen[i, STATE]] += 1
        route = OverPulley(
            exact(cable.exit),
            exact(cable.axis),
            Fraction(cable.radius),
            Fraction(cable.arm),
            Fraction(cable.lead_in),
            cable.joints,
            False,
        )
        length, along, free, _ = routed(route, x)
        assert abs(length - seen[i, PATH]) <= seen[i, OFF_LENGTH] + 1e-14
        assert np.allclose(along, seen[i, ALONG : ALONG + 3], atol=1e-9)
        assert np.allclose((length, free), (cable.path(x)[0], cable.path(x)[2]), atol=1e-9)
        foot, start = seen[i, FOOT : FOOT + 3], seen[i, PATH] - seen[i, FREE]
        for _ in range(6):
            step = rng.normal(size=3)
            other = x + step * (reach * rng.random() ** 0.3 / np.linalg.norm(step))
            length, along, free, is_past = routed(route, other)
            assert seen[i, STATE] == BOTH or is_past == (seen[i, STATE] == PAST)
            assert free >= seen[i, LEAST_FREE]
            assert abs(length - (np.linalg.norm(other - foot) + start)) <= seen[i, LOOSE] + 1e-13
            assert np.linalg.norm(other - free * along - foot) <= seen[i, DRIFT] + 1e-13
    assert states[PRESSED] > 10
