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
from solvers.six_dof.real.build import RealCable, build
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
from solvers.six_dof.real.model import RealModel
from solvers.six_dof.real.path import around, see
from tests.support.planted.pulleys import FloatCable, any_cable, exact, plant


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


def route_of(cable: FloatCable) -> OverPulley:
    """Return the exact route of a cable over a pulley."""
    sizes = (Fraction(x) for x in (cable.radius, cable.arm, cable.lead_in))
    return OverPulley(exact(cable.exit), exact(cable.axis), *sizes, cable.joints, False)


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
        route = route_of(cable)
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


def pulley_at_random(rng: np.random.Generator) -> FloatCable:
    """Return a cable over a pulley of any size, on a short arm or a long one, on one joint or two."""
    joints, radius = int(rng.integers(1, 3)), float(rng.choice([1e-9, 1e-6, 1e-3, 0.02, 0.3]))
    arm = radius * float(rng.choice([1.000001, 1.01, 1.5, 10.0]))
    if radius < 0.01 and rng.random() < 0.5:
        arm = 0.05
    near = 3.0 * (arm + radius)
    lead_in = near * float(rng.choice([1.00001, 1.5, 10.0])) if rng.random() < 0.5 else max(4.0, 2.0 * near)
    return FloatCable(rng.normal(size=3), rng.normal(size=3), radius, arm, lead_in, joints)


def close_to_lift_off(cable: FloatCable, rng: np.random.Generator) -> tuple[float, float]:
    """Return x and y of an anchor whose rope lifts off, or has, but for an angle of up to 0.1 rad.

    The angle of an arm on two joints is not known in balls where the rope touches by less than 1e-6 rad.
    """
    r, h, lead = cable.radius, cable.arm, cable.lead_in
    least, free = -12.0 if cable.joints == 1 else -6.0, rng.uniform(0.5, 2.5) + 2.0 * h
    off = rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(least, -1.0)
    if cable.joints == 1:
        psi = cable.arrival(h, 0.0)[1] + off
        return h + r * np.cos(psi) + free * np.sin(psi), r * np.sin(psi) - free * np.cos(psi)
    angle = np.arcsin((h - r) / lead) + off
    return abs((lead + free) * np.sin(angle)), (lead + free) * np.cos(angle) - lead


def close_to_the_axis(cable: FloatCable, rng: np.random.Generator) -> tuple[float, float]:
    """Return x and y of an anchor 1e-12 to 0.1 m from the swivel axis."""
    return 10.0 ** rng.uniform(-12.0, -1.0), rng.choice([-1.0, 1.0]) * (
        3.0 * cable.arm + rng.uniform(0.1, 2.0)
    )


def close_to_the_pulley(cable: FloatCable, rng: np.random.Generator) -> tuple[float, float]:
    """Return x and y of an anchor as near as two joints have one balance, or little farther."""
    away = (2.0 + 10.0 ** rng.uniform(-9.0, 0.0)) * (cable.arm + cable.radius)
    angle = rng.uniform(-0.5 * np.pi, 0.5 * np.pi)
    return away * np.cos(angle), away * np.sin(angle)


def model_of(cable: FloatCable) -> RealModel:
    """Return the arrays of one cable that ends at the centre of mass."""
    none, one = Fraction(0), Fraction(1)
    sizes = Fraction(cable.radius), Fraction(cable.arm), exact(cable.axis), Fraction(cable.lead_in)
    own = RealCable(exact(cable.exit), (none, none, none), (one, one), *sizes, cable.joints)
    return build([own], (none, none, one), 1)


def assert_within(seen: np.ndarray, cable: FloatCable, x: np.ndarray) -> None:
    """Assert that the exact route to an anchor keeps to the bounds over a ball that holds it."""
    foot, start = seen[FOOT : FOOT + 3], seen[PATH] - seen[FREE]
    length, along, free, is_past = routed(route_of(cable), x)
    assert seen[STATE] == BOTH or is_past == (seen[STATE] == PAST)
    assert free >= seen[LEAST_FREE]
    assert abs(length - (np.linalg.norm(x - foot) + start)) <= seen[LOOSE]
    assert np.linalg.norm(x - free * along - foot) <= seen[DRIFT]


@pytest.mark.parametrize("radius", [1e-9, 1e-6, 1e-3, 0.02])
def test_a_rope_lifts_off_a_pulley_of_any_size_where_its_exact_route_does(radius: float) -> None:
    """The angle of that place is known as well whatever the radius: T is nowhere near the pulley beyond."""
    cable = FloatCable(np.array([0.3, -0.2, 2.0]), np.array([0.1, 0.2, -1.0]), radius, 0.05, 4.0)
    k, seen = cable.axis / np.linalg.norm(cable.axis), np.zeros((1, SEEN))
    across = np.cross(k, [1.0, 0.0, 0.0])
    for power in range(1, 13):
        psi, free = cable.arrival(cable.arm, 0.0)[1] + 10.0**-power, 1.5
        x = cable.arm + radius * np.cos(psi) + free * np.sin(psi)
        y = radius * np.sin(psi) - free * np.cos(psi)
        anchor = cable.exit + across * (x / np.linalg.norm(across)) + k * y
        assert see_around(model_of(cable), 0, anchor, 1e-12, seen)
        assert_within(seen[0], cable, anchor)


@pytest.mark.parametrize("place", [close_to_lift_off, close_to_the_axis, close_to_the_pulley])
@pytest.mark.parametrize("seed", range(2))
def test_bounds_hold_where_ropes_change(seed: int, place: Any) -> None:
    """Pulleys from a nanometre to 0.3 m: in the smallest balls, too, a rope is what its exact route is."""
    rng = np.random.default_rng([seed, 5])
    seen, states = np.zeros((1, SEEN)), dict.fromkeys((PRESSED, PAST, BOTH), 0)
    for _ in range(120):
        cable = pulley_at_random(rng)
        k = cable.axis / np.linalg.norm(cable.axis)
        across = np.cross(k, rng.normal(size=3))
        x, y = place(cable, rng)
        anchor = cable.exit + across * (x / np.linalg.norm(across)) + k * y
        real = model_of(cable)
        reach = 10.0 ** rng.uniform(-12.0, -0.5)
        if not see_around(real, 0, anchor, reach, seen):
            continue
        states[seen[0, STATE]] += 1
        for share in (0.0, 1.0, 1.0, 1.0, rng.random()):
            step = rng.normal(size=3)
            other = anchor + step * (reach * share * (1.0 - 1e-9) / np.linalg.norm(step))
            assert_within(seen[0], cable, other)
    assert min(states[PRESSED], states[PAST] + states[BOTH]) > 5
