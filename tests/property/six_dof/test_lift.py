"""Boxes of poses in which no cable pulls against the load, against exact numbers."""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.rotation import HALF_TURNS
from cdpr_interval.mechanics.six_dof.arrays import Model, build_model
from solvers.six_dof.cells.lift import may_lift

Vector = tuple[Fraction, Fraction, Fraction]
BARELY = Fraction(1, 10**9)
"""m: so little above its anchor is an exit point of a cable that just pulls up."""


def decimal(x: float) -> Fraction:
    """Return a number of an input file: nine digits behind the point."""
    return Fraction(round(x * 10**9), 10**9)


def drawn(rng: random.Random, size: float) -> Vector:
    """Return a random vector, now and then with entries of zero."""
    x, y, z = (decimal(rng.choice([0.0, 1.0, 1.0, 1.0]) * rng.uniform(-size, size)) for _ in range(3))
    return x, y, z


def dot(a: Vector, b: Vector) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def turned(u: Vector, chart: int, b: Vector) -> Vector:
    """Return R(u) D_c b exactly."""
    x, y, z = (int(d) * v for d, v in zip(HALF_TURNS[chart], b, strict=True))
    across = (u[1] * z - u[2] * y, u[2] * x - u[0] * z, u[0] * y - u[1] * x)
    twice = (
        u[1] * across[2] - u[2] * across[1],
        u[2] * across[0] - u[0] * across[2],
        u[0] * across[1] - u[1] * across[0],
    )
    g = 2 / (1 + dot(u, u))
    return (x + g * (across[0] + twice[0]), y + g * (across[1] + twice[1]), z + g * (across[2] + twice[2]))


def pulls(load: Vector, exit_point: Vector, arm: Vector, chart: int, u: Vector, p: Vector) -> Fraction:
    """Return f . e exactly; negative where the cable pulls against the load."""
    r = turned(u, chart, arm)
    e = (exit_point[0] - p[0] - r[0], exit_point[1] - p[1] - r[1], exit_point[2] - p[2] - r[2])
    return dot(load, e)


def model_of(taut: int, exits: list[Vector], arms: list[Vector], load: Vector, statics: bool = True) -> Model:
    """Return the arrays of a platform whose first ``taut`` cables are taut."""
    return build_model(
        [ranged(a) for a in exits],
        [ranged(b) for b in arms],
        [Range.exact(Fraction(5))] * len(exits),
        ranged(load),
        taut,
        statics=statics,
    )


def ranged(v: Vector) -> tuple[Range, Range, Range]:
    return Range.exact(v[0]), Range.exact(v[1]), Range.exact(v[2])


def box_around(middle: Vector, reach: float) -> list[tuple[float, float]]:
    return [(float(x) - reach, float(x) + reach) for x in middle]


def corners_and_inside(rng: random.Random, box: np.ndarray, count: int) -> list[tuple[Vector, Vector]]:
    """Return poses in a box (6, 2), most of them at its ends."""
    found = []
    for _ in range(count):
        z = []
        for lo, hi in box:
            a, b = Fraction(float(lo)), Fraction(float(hi))
            z.append(a + (b - a) * rng.choice([0, 0, 1, 1, Fraction(rng.randrange(1001), 1000)]))
        found.append(((z[0], z[1], z[2]), (z[3], z[4], z[5])))
    return found


@given(st.integers(0, 10**12))
def test_no_cable_pulls_against_the_load_where_it_is_excluded(seed: int):
    """Random robots, loads and boxes: exactly, at corners and inside, nothing pulls up where that is said."""
    rng = random.Random(seed)
    count, size = rng.randint(1, 8), rng.choice([1e-3, 1.0, 1.0, 1e3])
    taut = rng.randint(1, min(6, count))
    load = (Fraction(0), Fraction(0), Fraction(0))
    while not any(load):
        load = drawn(rng, rng.choice([1e-3, 1.0, 1e4]))
    arms = [drawn(rng, size * rng.choice([0.1, 1.0])) for _ in range(count)]
    chart, p = rng.randrange(4), drawn(rng, size)
    # Doubles of a chart's cube, at its border now and then.
    u = tuple(Fraction(rng.choice([rng.uniform(-0.9, 0.9), 0.0])) for _ in range(3))
    reach = rng.choice([0.0, 1e-9, 1e-4, 1e-2, 0.1])
    # Exit points on the load's side of the platform, some of them barely.
    exits = []
    for arm in arms:
        r, far = turned(u, chart, arm), rng.choice([1e-9, 1e-3, 0.3, 3.0]) * size
        side = far / float(dot(load, load)) ** 0.5
        e = [r[k] + p[k] + decimal(side * float(load[k])) for k in range(3)]
        exits.append(tuple(decimal(float(x)) for x in e))
    model = model_of(taut, exits, arms, load)
    box = np.array([*box_around(u, reach), *box_around(p, reach * size * rng.choice([0.0, 1.0]))])
    if may_lift(model, np.array([float(chart)]), box[None])[0]:
        return
    for u_at, p_at in corners_and_inside(rng, box, 10):
        for i in range(taut):
            assert pulls(load, exits[i], arms[i], chart, u_at, p_at) >= 0


@pytest.mark.parametrize("taut", [1, 3, 6])
@pytest.mark.parametrize("force", [(0, 0, -1), (0, 0, -123456), (3, -4, Fraction(1, 10))])
def test_a_cable_that_just_pulls_up_keeps_the_box(taut: int, force: tuple[float, float, float]):
    """One exit point is 1e-9 m against the load from its anchor: not even a box of one pose is excluded."""
    rng = random.Random(7)
    load: Vector = (Fraction(force[0]), Fraction(force[1]), Fraction(force[2]))
    for _ in range(50):
        chart, u = rng.randrange(4), tuple(Fraction(rng.uniform(-1, 1)) for _ in range(3))
        p, arms = drawn(rng, 3.0), [drawn(rng, 1.0) for _ in range(taut)]
        anchors = [tuple(a + b for a, b in zip(turned(u, chart, arm), p, strict=True)) for arm in arms]
        square = dot(load, load)
        exits = [tuple(x + load[k] / square for k, x in enumerate(a)) for a in anchors]
        box = np.array([*box_around(u, 0.0), *box_around(p, 0.0)])
        # p is nine digits, not a double: the box holds it with room of 1e-12.
        box[3:] += [-1e-12, 1e-12]
        charts = np.array([float(chart)])
        assert not may_lift(model_of(taut, exits, arms, load), charts, box[None])[0]
        which = rng.randrange(taut)
        exits[which] = tuple(x - BARELY * load[k] / square for k, x in enumerate(anchors[which]))
        assert may_lift(model_of(taut, exits, arms, load), charts, box[None])[0]


def test_pulls_below_the_rounding_of_doubles_keep_the_box():
    """The exit point is 1e-30 m against the load from its anchor, the box one pose of doubles."""
    rng = random.Random(8)
    for _ in range(200):
        chart, load = rng.randrange(4), (decimal(rng.uniform(-1, 1)), Fraction(1, 7), Fraction(-3, 2))
        u, p = (tuple(Fraction(rng.uniform(-1, 1)) for _ in range(3)) for _ in range(2))
        arm = drawn(rng, 1.0)
        r = turned(u, chart, arm)
        exit_point = tuple(a + b - f / 10**30 for a, b, f in zip(r, p, load, strict=True))
        box = np.array([*box_around(u, 0.0), *box_around(p, 0.0)])
        assert may_lift(model_of(1, [exit_point], [arm], load), np.array([float(chart)]), box[None])[0]


@pytest.mark.parametrize("spread", ["exit", "arm", "load"])
def test_data_that_are_ranges_are_taken_at_their_worst(spread: str):
    """As the frames of families have them: in the middle of the range the cable pulls down, at an end up."""
    wide, none = Range(Fraction(-1, 100), Fraction(1, 100)), Range.exact(0)
    for height, kept in ((Fraction(1, 200), True), (Fraction(1, 20), False)):
        exit_point = (Range.exact(1), none, Range.exact(-height) + (wide if spread == "exit" else none))
        arm = (none, none, wide if spread == "arm" else none)
        load = (wide if spread == "load" else none, none, Range.exact(-1))
        model = build_model([exit_point], [arm], [Range.exact(5)], load, 1)
        assert may_lift(model, np.zeros(1), np.zeros((1, 6, 2)))[0] == kept


def test_only_taut_cables_count_and_unknown_positions_exclude_nothing():
    down, up = (Fraction(1), Fraction(0), Fraction(-1)), (Fraction(1), Fraction(0), Fraction(1))
    arms = [(Fraction(1, 10), Fraction(0), Fraction(0)), (Fraction(0), Fraction(1, 10), Fraction(0))]
    load = (Fraction(0), Fraction(0), Fraction(-10))
    box = np.array([[[-0.1, 0.1]] * 6])
    chart = np.zeros(1)
    assert not may_lift(model_of(1, [down, up], arms, load), chart, box)[0]
    assert may_lift(model_of(2, [down, up], arms, load), chart, box)[0]
    assert may_lift(model_of(1, [down, up], arms, load, statics=False), chart, box)[0]
    box[0, 3:] = np.nan
    assert may_lift(model_of(1, [down, up], arms, load), chart, box)[0]
    assert len(may_lift(model_of(1, [down, up], arms, load), np.empty(0), np.empty((0, 6, 2)))) == 0


def test_boxes_as_large_as_doubles_exclude_nothing():
    arm, load = (Fraction(0), Fraction(0), Fraction(1, 10)), (Fraction(0), Fraction(0), Fraction(-10))
    far = (Fraction(0), Fraction(0), -(Fraction(10) ** 100))
    model = model_of(1, [far], [arm], load)
    box = np.array([[[-1.0, 1.0]] * 3 + [[-1.0, 1.0]] * 3])
    assert not may_lift(model, np.zeros(1), box)[0]
    for most in (1e101, 1e308, np.inf):
        box[0, 5] = -most, most
        assert may_lift(model, np.zeros(1), box)[0]
