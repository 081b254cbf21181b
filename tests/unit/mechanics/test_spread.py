"""By how much the data of a loaded robot may differ from those of its middle."""

from __future__ import annotations

import itertools
import random
from fractions import Fraction as F

from cdpr_interval.exact.range import Range
from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.loaded import LoadedRobot, loaded
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Robot

FORCE = (F(1), Range(F(2), F(3)), F(0))


def robot(mass: object = 10, gravity: object = (0, 0, "-9.81"), exit_point: object = (0, 0, 3)) -> Robot:
    cables = (Cable("c1", exit_point, (0, 0, 0)), Cable("c2", (4, 0, 3), (1, 0, 0)))
    return Robot("r", Platform(mass), cables, gravity)


def test_an_exact_robot_is_its_own_middle() -> None:
    one = robot()
    under_load = loaded(one)
    assert one.is_exact and one.middle() is one
    assert under_load.is_exact and under_load.middle is under_load
    spread = under_load.spread
    assert spread.is_zero and spread.points_are_exact and spread.load_is_exact
    assert spread.load_scale == Range(F(1), F(1))
    assert under_load.load_ranges == tuple(Range(x, x) for x in under_load.load)


def test_the_middle_of_every_number_is_taken() -> None:
    elastic = Elasticity(stiffness=(900, 1100))
    one = robot((9, 11), ((-1, 3), 0, -10), ((0, "0.5"), 0, 3))
    first = one.cables[0].replace(elasticity=elastic, platform_anchor=(0, (-1, 2), 0))
    one = one.replace(cables=(first, one.cables[1]))
    assert len(one.uncertain) == 5 and not one.is_exact
    middle = one.middle()
    assert middle.is_exact and middle is one.middle()
    assert middle.platform.mass == 10 and middle.gravity == (1, 0, -10)
    assert middle.cables[0].frame_anchor == (F(1, 4), 0, 3)
    assert middle.cables[0].platform_anchor == (0, F(1, 2), 0)
    assert middle.cables[0].elasticity == Elasticity(stiffness=1000)
    assert middle.cables[1] == one.cables[1]
    under_load = loaded(one, FORCE)
    assert under_load.middle.robot is middle
    assert under_load.middle.external_force == (1, F(5, 2), 0)
    assert under_load.middle is loaded(one, FORCE).middle
    assert under_load.spread.exits == ((F(1, 4), 0, 0), (0, 0, 0))
    assert under_load.spread.anchors == ((0, F(3, 2), 0), (0, 0, 0))


def test_a_mass_with_a_range_only_scales_the_load() -> None:
    spread = loaded(robot((9, 11))).spread
    assert spread.load == (0, 0, 0) and spread.load_scale == Range(F(9, 10), F(11, 10))
    assert spread.points_are_exact and not spread.is_zero


def test_a_force_with_a_range_does_not_scale_it() -> None:
    spread = loaded(robot(), (F(0), F(0), Range(F(1), F(3)))).spread
    assert spread.load == (0, 0, 1) and spread.load_scale == Range(F(1), F(1))


def ends(value: object) -> tuple[F, ...]:
    return tuple(value) if isinstance(value, Range) else (value,)


def loads(under_load: LoadedRobot, rng: random.Random) -> list[Vector]:
    """Return the loads of the corners and of random choices."""
    robot, force = under_load.robot, under_load.external_force
    sets = [ends(x) for x in (robot.platform.mass, *robot.gravity, *force)]
    choices = list(itertools.product(*sets))
    for _ in range(50):
        choices.append(tuple(min(s) + (max(s) - min(s)) * F(rng.randrange(101), 100) for s in sets))
    return [tuple(c[0] * g + f for g, f in zip(c[1:4], c[4:], strict=True)) for c in choices]


def test_every_load_is_a_scaled_middle_and_a_rest() -> None:
    """For some scale of its range, the rest of every choice lies within the spread."""
    rng = random.Random(7)
    for _ in range(60):

        def scalar(low: int, high: int, widest: int) -> object:
            lo = F(rng.randint(low, high), 10)
            return rng.choice([lo, Range(lo, lo + F(rng.randint(1, widest), 10))])

        gravity = (scalar(-20, 20, 5), scalar(-20, 20, 5), scalar(-120, -80, 5))
        one = robot(scalar(50, 100, 20), gravity)
        under_load = loaded(one, tuple(scalar(-50, 50, 30) for _ in range(3)))
        spread, middle = under_load.spread, under_load.middle.load
        for load in loads(under_load, rng):
            scales = spread.load_scale
            for f, m, rest in zip(load, middle, spread.load, strict=True):
                if m:
                    a, b = sorted(((f - rest) / m, (f + rest) / m))
                    scales = Range(max(scales.lo, a), min(scales.hi, b))
                else:
                    assert abs(f) <= rest
            assert scales.lo <= scales.hi
            assert all(f in r for f, r in zip(load, under_load.load_ranges, strict=True))


def test_the_ranges_of_a_load_are_reached() -> None:
    rng = random.Random(8)
    one = robot(Range(F(9), F(11)), (Range(F(-1), F(1)), F(0), Range(F(-10), F(-9))))
    under_load = loaded(one, FORCE)
    for k, (lo, hi) in enumerate(under_load.load_ranges):
        seen = [load[k] for load in loads(under_load, rng)]
        assert (lo, hi) == (min(seen), max(seen))
