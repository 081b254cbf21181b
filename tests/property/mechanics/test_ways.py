"""Compiled ways of cables over boxes hold the paths to the points of the boxes, which balls enclose."""

from __future__ import annotations

import math
from fractions import Fraction as F
from random import Random
from typing import Any

import numpy as np
import pytest
from flint import arb
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.exact.range import Range
from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.cables import ways as compiled
from cdpr_interval.mechanics.cables.path import Balls, OffTheCable
from cdpr_interval.mechanics.cables.route_rows import route_rows
from cdpr_interval.mechanics.cables.rows import ROUTE, SNUG
from cdpr_interval.mechanics.cables.way_at import way_at
from cdpr_interval.robots.pulley import BISECTOR, EXACT, Pulley
from tests.support.kernel_callers import Callers
from tests.support.pulleys import (
    KINDS,
    ORIGIN,
    anchor_at,
    as_balls,
    near_or_far,
    random_point,
    random_pulley,
    robot_of,
    route_of,
    sample,
    with_ranges,
)

Floats = NDArray[np.float64]
ways = Callers(compiled)
BALLS = Balls()


def holds(bounds: Floats, x: arb) -> bool:
    """Return True unless a number lies outside bounds for certain."""
    lo, hi = float(bounds[0]), float(bounds[1])
    assert not (math.isnan(lo) or math.isnan(hi)) and lo < math.inf and hi > -math.inf
    return not (lo > -math.inf and x < arb(lo)) and not (hi < math.inf and x > arb(hi))


class Over:
    """The way of a cable over a box."""

    def __init__(self, pulley: Pulley | None, point: Vector, box: Floats) -> None:
        self.row = route_rows(robot_of(pulley, point), ORIGIN, F(1))
        self.way = np.full((1, ways.WAY, 2), np.nan)
        self.turning = np.full((1, 3, 3, 2), np.nan)
        self.reached = ways.ways_over(self.row, box, self.way, self.turning)
        self.gradient, self.sharp = np.full((3, 2), np.nan), self.way[0].copy()
        if self.reached:
            ways.gradient_over(self.row[0], self.way[0], self.gradient)
            scratch = np.empty((ways.WAY, 2))
            ways.sharpened_length(self.row[0], box, self.sharp, self.gradient, scratch)

    def require(self, pulley: Pulley | None, point: Vector, anchor: Any) -> bool:
        """Assert that a path is held; False where there is none."""
        route = route_of(pulley, point)
        try:
            path = route.path(anchor, BALLS)
        except OffTheCable:
            return False
        assert self.reached, "a way to a box without ways"
        where = f"{pulley} {[str(x) for x in anchor]}"
        way = self.way[0]
        assert holds(way[ways.LENGTH], path.length), where
        assert holds(self.sharp[ways.LENGTH], path.length), where
        assert holds(way[ways.FREE], path.free) and holds(way[ways.WRAP], path.wrap), where
        claimed = route.turning(path, anchor, BALLS)
        for i in range(3):
            assert holds(way[ways.ALONG + i], path.direction[i]), where
            for j in range(3):
                assert holds(self.turning[0, i, j], claimed[i][j]), where
        return True

    def require_slope(self, pulley: Pulley, point: Vector, anchor: Any) -> None:
        """Assert that the difference quotient of the length lies in the gradient."""
        route, e = route_of(pulley, point), arb(10) ** -14
        for j in range(3):
            ends = []
            for side in (1, -1):
                moved = list(anchor)
                moved[j] = anchor[j] + side * e
                try:
                    ends.append(route.path(tuple(moved), BALLS).length)
                except OffTheCable:
                    return
            lo, hi = self.gradient[j]
            assert holds(np.array([lo - 1e-9, hi + 1e-9]), (ends[0] - ends[1]) / (2 * e))


def box_around(anchor: Floats, rng: Random) -> Floats:
    """Return a box of any width from 1e-9 to 1 m, flat in some directions, with the anchor in it."""
    width = 10 ** rng.uniform(-9, 0) * np.array([rng.choice([1, 1, rng.random(), 0]) for _ in range(3)])
    lo = anchor - width * [rng.random() for _ in range(3)]
    return np.stack([lo, lo + width], axis=1)


def inside(box: Floats, corner: bool, rng: Random) -> Any:
    """Return a point of a box, one of its corners or any, in balls."""
    parts = [F(rng.randint(0, 1)) if corner else F(rng.randint(0, 64), 64) for _ in range(3)]
    x, y, z = (
        balls.from_fraction(F(lo) + part * (F(hi) - F(lo)))
        for part, (lo, hi) in zip(parts, box.tolist(), strict=True)
    )
    return x, y, z


@pytest.mark.parametrize("ranges", [False, True], ids=["exact", "ranges"])
@pytest.mark.parametrize("kind", [None, *KINDS], ids=str)
def test_a_way_over_a_box_holds_the_paths_to_its_points(kind: tuple[int, str] | None, ranges: bool) -> None:
    """Anchors next to the pulley, next to the axis and anywhere."""
    rng, seen, narrow = Random(20), 0, 0
    for _ in range(250):
        point = random_point(rng)
        pulley = random_pulley(rng, kind) if kind else rng.choice([None, Pulley(0, lead_in=F(1, 3))])
        if ranges and pulley is not None:
            pulley = with_ranges(pulley, rng) if kind else Pulley(0, lead_in=Range(F(1, 3), F(1, 2)))
        place = near_or_far(pulley or Pulley(1), rng)
        box = box_around(anchor_at(pulley or Pulley(1), point, *place, rng), rng)
        over = Over(pulley, point, box)
        with balls.precision():
            for i in range(5):
                choice = sample(pulley, rng) if pulley else None
                anchor = inside(box, i < 2, rng)
                if over.require(choice, point, anchor):
                    seen += 1
                    if choice and i == 4:
                        over.require_slope(choice, point, anchor)
        way = over.way[0]
        if over.reached:
            narrow += bool(way[ways.LENGTH, 1] - way[ways.LENGTH, 0] < 1e-2)
    print(f"seed 20: {seen} paths, {narrow} narrow ways")
    # Infinite bounds hold everything.
    assert seen > 500 and narrow > 80, (seen, narrow)


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_boxes_where_contact_ends_and_angles_are_cut(kind: tuple[int, str]) -> None:
    """Long arms and a winch close by: the rope leaves the pulley, or its normal turns past its cut."""
    rng, seen, steps = Random(21), 0, 0
    joints, balance = kind
    for _ in range(300):
        r = F(rng.randint(10, 60), 1000)
        arm, lead_in = r + F(rng.randint(1, 500), 1000), F(rng.randint(0 if joints == 1 else 100, 700), 1000)
        pulley = Pulley(r, arm, joints, lead_in=lead_in, balance=balance)
        box = box_around(anchor_at(pulley, ORIGIN, rng.uniform(0, 0.6), rng.uniform(-0.6, 0.6), rng), rng)
        over = Over(pulley, ORIGIN, box)
        with balls.precision():
            wraps = set()
            for i in range(6):
                anchor = inside(box, i < 3, rng)
                if over.require(pulley, ORIGIN, anchor):
                    seen += 1
                    wraps.add(bool(route_of(pulley).path(anchor, BALLS).wrap > 0))
            steps += len(wraps) == 2
    print(f"seed 21: {seen} paths, {steps} boxes across the end of contact")
    assert seen > 600 and (steps > 5 or balance == EXACT)


def test_the_inner_quarter_below_a_snug_pulley() -> None:
    """There the rope would run around the whole pulley: the angle of its normal is cut."""
    rng, seen = Random(22), 0
    pulley = Pulley("0.06", lead_in="0.2")
    for _ in range(400):
        turn, distance = rng.uniform(-math.pi, -math.pi / 2), 0.06 * (1 + 10 ** rng.uniform(-6, 0))
        x, y = 0.06 + distance * math.cos(turn), distance * math.sin(turn)
        if x <= 0:
            continue
        box = box_around(np.array([x, 0.0, y]), rng)
        over = Over(pulley, ORIGIN, box)
        with balls.precision():
            for i in range(5):
                seen += over.require(pulley, ORIGIN, inside(box, i < 2, rng))
    assert seen > 500


def test_boxes_with_the_pulley_and_the_axis_in_them() -> None:
    for kind in KINDS:
        joints, balance = kind
        pulley = Pulley("0.05", "0.1", joints, lead_in=1, balance=balance)
        rng = Random(23)
        for size in (0.01, 0.1, 1.0):
            for centre in ((0, 0, 0), (0.1, 0, 0), (0, 0, -0.1), (0.05, 0.05, -0.5)):
                box = np.array([[c - size, c + size] for c in centre])
                over = Over(pulley, ORIGIN, box)
                with balls.precision():
                    for i in range(20):
                        over.require(pulley, ORIGIN, inside(box, i < 4, rng))


def test_a_box_inside_the_pulley_has_no_way() -> None:
    """Only then: False is a proof."""
    inner = np.array([[0.09, 0.11], [-0.001, 0.001], [-0.01, 0.01]])
    for lead_in in ("0", "2"):
        assert not Over(Pulley("0.05", "0.1", lead_in=lead_in), ORIGIN, inner).reached
    assert Over(Pulley("0.05", "0.1"), ORIGIN, inner + np.array([[0.04], [0.0], [0.0]])).reached
    assert Over(None, ORIGIN, inner).reached


def test_narrow_boxes_have_narrow_ways() -> None:
    """Of pulleys as they are built: else infinite bounds would pass for ways."""
    rng = Random(24)
    for kind in KINDS:
        for _ in range(40):
            point, pulley = random_point(rng), random_pulley(rng, kind, roomy=True)
            anchor = anchor_at(pulley, point, rng.uniform(0.7, 4), rng.uniform(-4, 2), rng)
            box = np.stack([anchor - 1e-6, anchor + 1e-6], axis=1)
            over = Over(pulley, point, box)
            widths = over.way[0, :, 1] - over.way[0, :, 0]
            assert widths[ways.LENGTH] < 1e-4 and np.ptp(over.sharp[ways.LENGTH]) < 1e-5, pulley
            assert widths[ways.ALONG : ways.ALONG + 3].max() < 1e-4, pulley
            assert np.ptp(over.turning, axis=3).max() < 1e-2, pulley
            if kind[1] != BISECTOR:
                assert (over.gradient == over.way[0, ways.ALONG : ways.ALONG + 3]).all()


def test_rows_of_ranges_hold_the_rows_of_their_numbers() -> None:
    rng = Random(25)
    for _ in range(200):
        point, pulley = random_point(rng), with_ranges(random_pulley(rng), rng)
        wide = route_rows(robot_of(pulley, point), (F(1), F(2), F(3)), F(1, 4))[0]
        narrow = route_rows(robot_of(sample(pulley, rng), point), (F(1), F(2), F(3)), F(1, 4))[0]
        # A range may hold arms as long as the radius and others.
        rows = [i for i in range(ROUTE) if i != SNUG]
        assert (wide[rows, 0] <= narrow[rows, 1]).all() and (narrow[rows, 0] <= wide[rows, 1]).all(), pulley
        assert np.isfinite(wide).all()


def test_a_unit_and_an_origin_change_nothing_but_numbers() -> None:
    rng = Random(26)
    for kind in KINDS:
        point, pulley = random_point(rng), random_pulley(rng, kind, roomy=True)
        anchor = anchor_at(pulley, point, 1.5, -2.0, rng)
        origin, unit = (F(1), F(-2), F(1, 2)), F(4)
        row = route_rows(robot_of(pulley, point), origin, unit)
        here = (anchor - [float(x) for x in origin]) / 4
        way, turning = np.empty((1, ways.WAY, 2)), np.empty((1, 3, 3, 2))
        assert ways.ways_over(row, np.stack([here, here], axis=1), way, turning)
        with balls.precision():
            path = route_of(pulley, point).path(as_balls(anchor), BALLS)
        assert way[0, ways.LENGTH].mean() * 4 == pytest.approx(float(path.length.mid()), rel=1e-12)
        assert way[0, ways.WRAP].mean() == pytest.approx(float(path.wrap.mid()), abs=1e-9)


@pytest.mark.parametrize("kind", [None, *KINDS], ids=str)
def test_the_compiled_way_to_a_point_is_the_path(kind: tuple[int, str] | None) -> None:
    rng, seen = Random(27), 0
    a, turning = np.empty(3), np.empty((3, 3))
    for _ in range(300):
        point = random_point(rng)
        pulley = random_pulley(rng, kind, roomy=True) if kind else rng.choice([None, Pulley(0, lead_in=2)])
        place = (rng.uniform(0.1, 4), rng.uniform(-4, 2))
        anchor = anchor_at(pulley or Pulley(1), point, *place, rng)
        route = route_of(pulley, point)
        with balls.precision():
            try:
                path = route.path(as_balls(anchor), BALLS)
            except OffTheCable:
                continue
            claimed = route.turning(path, as_balls(anchor), BALLS)
        seen += 1
        row = route_rows(robot_of(pulley, point), ORIGIN, F(1))[0]
        length = way_at(row, anchor, a, turning)
        assert length == pytest.approx(float(path.length.mid()), rel=1e-12)
        assert a == pytest.approx([float(x.mid()) for x in path.direction], abs=1e-11)
        wanted = np.array([[float(x.mid()) for x in line] for line in claimed])
        assert turning == pytest.approx(wanted, abs=1e-9 * (1 + np.abs(wanted).max()))
    assert seen > 250


def test_a_point_without_a_way_has_finite_numbers() -> None:
    a, turning = np.empty(3), np.empty((3, 3))
    for kind in KINDS:
        joints, balance = kind
        pulley = Pulley("0.05", "0.1", joints, lead_in=1, balance=balance)
        row = route_rows(robot_of(pulley, ORIGIN), ORIGIN, F(1))[0]
        for x in ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.1, 0.0, -0.05)):
            assert math.isfinite(way_at(row, np.array(x), a, turning)), (kind, x)
            assert np.isfinite(a).all(), (kind, x)
