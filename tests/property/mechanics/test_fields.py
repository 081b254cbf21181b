"""What solutions report against exact fractions: planted equilibria in rational frames."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import combinations
from typing import Any

import numpy as np
import pytest

from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.mechanics.six_dof import fields as pf
from tests.support.planted_platform import (
    HALF_TURN_SIGNS,
    Planted,
    Vector,
    apply,
    cayley,
    cross,
    dot,
    minus,
    plant,
    root_range,
)

COUNTS = (1, 2, 3, 4, 5, 6)
WIDTHS = (0.0, 1e-12, 1e-6, 1e-3, 0.05)
UP = [Fraction(2, 3), Fraction(-1, 3), Fraction(2, 3)]


def column(v: Sequence[Fraction]) -> Any:
    return np.array([enclose(x) for x in v]).reshape(-1, 1, 2)


def bounds_of(m: Sequence[Sequence[Fraction]]) -> Any:
    return np.array([[enclose(x) for x in row] for row in m])


def product(a: list[Vector], b: list[Vector]) -> list[Vector]:
    return [[dot(row, c) for c in zip(*b, strict=True)] for row in a]


def transposed(a: list[Vector]) -> list[Vector]:
    return [list(c) for c in zip(*a, strict=True)]


def plus(a: Sequence[Fraction], b: Sequence[Fraction]) -> Vector:
    return [x + y for x, y in zip(a, b, strict=True)]


@dataclass(frozen=True)
class Placed:
    """A planted platform in frames of its own: what the search sees are other ones."""

    planted: Planted
    plain: bool
    base: list[Vector]
    platform: list[Vector]
    origin: Vector
    centre: Vector
    exits: list[Vector]
    arms: list[Vector]
    load: Vector

    def cables(self) -> pf.Cables:
        return pf.Cables(
            exits=np.array([column(a) for a in self.exits]),
            arms=np.array([column(b) for b in self.arms]),
            centre=column(self.centre),
            up=column(UP).reshape(1, 3, 2),
            load=column(self.load),
        )

    def frame(self) -> pf.FrameBounds:
        return pf.FrameBounds(
            self.plain,
            bounds_of(transposed(self.base)),
            bounds_of(self.platform),
            column([-x for x in self.origin]),
        )

    def pose(self, z: Sequence[Fraction]) -> tuple[list[Vector], Vector]:
        """Return the rotation and the centre of mass in the robot's frames."""
        signs = HALF_TURN_SIGNS[self.planted.chart]
        model = [[x * s for x, s in zip(row, signs, strict=True)] for row in cayley(z[:3])]
        back = transposed(self.base)
        return product(product(back, model), self.platform), plus(apply(back, z[3:6]), self.origin)


def place(rng: random.Random, planted: Planted) -> Placed:
    zero = [Fraction(0)] * 3
    plain = rng.random() < 0.3
    base, platform = (
        cayley(zero if plain else [Fraction(rng.randint(-9, 9), 7) for _ in zero]) for _ in "ab"
    )
    origin = zero if plain else [Fraction(rng.randint(-99, 99), 13) for _ in zero]
    back = transposed(base)
    return Placed(
        planted,
        plain,
        base,
        platform,
        origin,
        [Fraction(rng.randint(-9, 9), 11) for _ in zero],
        [plus(apply(back, a), origin) for a in planted.anchors],
        [apply(transposed(platform), b) for b in planted.points],
        apply(back, planted.load),
    )


@cache
def robots(n: int) -> list[Placed]:
    rng = random.Random(300 + n)
    return [place(rng, plant_any(rng, n)) for _ in range(6)]


def plant_any(rng: random.Random, n: int) -> Planted:
    """Plant n taut cables; one alone pulls through the centre of mass."""
    if n > 1:
        return plant(rng, n, slack=2)
    two = plant(rng, 2, slack=1)
    return Planted(
        two.model, two.chart, 1, two.u, two.p, two.t[:1], two.anchors, two.points, two.load, two.lengths_sq
    )


def exact_unknowns(robot: Planted) -> Vector:
    return [*robot.u, *robot.p, *(robot.t if robot.n < 6 else [Fraction(0)] * 6)]


def box_around(rng: random.Random, z: Vector, width: float, n: int) -> Any:
    box = np.array([enclose(x) for x in z])
    for k in range(6 + n if n < 6 else 6):
        box[k, 0] -= width * rng.random()
        box[k, 1] += width * rng.random()
    return box


def member(rng: random.Random, box: Any) -> Vector:
    def value(lo: float, hi: float) -> Fraction:
        share = rng.choice([Fraction(0), Fraction(1), Fraction(rng.randint(0, 97), 97)])
        return Fraction(lo) + (Fraction(hi) - Fraction(lo)) * share

    return [value(lo, hi) for lo, hi in box.tolist()]


def filled(robot: Placed, box: Any, taut: Sequence[int], lengths: Any) -> pf.Fields:
    n, count = len(taut), len(robot.exits)
    fields = pf.Fields(
        np.empty((1, 3, 3, 2)),
        np.empty((1, 3, 2)),
        np.empty((1, 2)),
        np.empty((1, count, 2)),
        np.empty((1, n, 2)),
        np.zeros((1, count, 2)),
        np.empty(1, dtype=np.int64),
    )
    charts = np.array([robot.planted.chart])
    pf.fill_fields(robot.cables(), robot.frame(), box[None], charts, np.array(taut), lengths, fields)
    return fields


def contains(bounds: Any, x: Fraction) -> bool:
    return bool(bounds[0] <= x <= bounds[1])


def check_pose(robot: Placed, fields: pf.Fields, z: Vector) -> None:
    """Rotation, position, height and the distances of the cables that are not taut."""
    rotation, centre = robot.pose(z)
    for i in range(3):
        assert all(contains(fields.rotation[0, i, j], rotation[i][j]) for j in range(3))
    position = minus(centre, apply(rotation, robot.centre))
    assert all(contains(b, x) for b, x in zip(fields.position[0], position, strict=True))
    assert contains(fields.height[0], dot(UP, centre))
    for i in range(robot.planted.n, len(robot.exits)):
        e = minus(minus(robot.exits[i], centre), apply(rotation, robot.arms[i]))
        lo, hi = (Fraction(x) for x in fields.distances[0, i])
        assert lo**2 <= dot(e, e) <= hi**2
        assert not np.any(fields.tensions[0, i])


def check_equilibrium(robot: Placed, fields: pf.Fields, taut: Sequence[int]) -> None:
    planted = robot.planted
    for j, i in enumerate(taut):
        length = root_range(planted.lengths_sq[i])
        assert contains(fields.densities[0, j], planted.t[j])
        lo, hi = (Fraction(x) for x in fields.tensions[0, i])
        assert lo <= planted.t[j] * length.hi and planted.t[j] * length.lo <= hi
        lo, hi = (Fraction(x) for x in fields.distances[0, i])
        assert lo <= length.hi and length.lo <= hi


def lengths_of(robot: Placed) -> Any:
    ranges = [root_range(x) for x in robot.planted.lengths_sq]
    return np.array([[enclose(r.lo)[0], enclose(r.hi)[1]] for r in ranges])


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("n", COUNTS)
def test_every_field_holds_its_exact_value(n: int, width: float) -> None:
    rng = random.Random(1)
    for robot in robots(n):
        z = exact_unknowns(robot.planted)
        box = box_around(rng, z, width, n)
        taut = tuple(range(n))
        fields = filled(robot, box, taut, lengths_of(robot))
        check_pose(robot, fields, z)
        if n < 6 or np.isfinite(fields.densities).all():
            check_equilibrium(robot, fields, taut)
        else:
            assert width > 1e-6
        for _ in range(4):
            check_pose(robot, fields, member(rng, box))


@pytest.mark.parametrize("n", COUNTS)
def test_fields_of_thin_boxes_are_tight(n: int) -> None:
    rng = random.Random(2)
    for robot in robots(n):
        fields = filled(
            robot, box_around(rng, exact_unknowns(robot.planted), 0.0, n), range(n), lengths_of(robot)
        )
        assert np.ptp(fields.rotation, axis=-1).max() < 1e-14
        assert np.ptp(fields.position, axis=-1).max() < 1e-13
        assert np.ptp(fields.distances, axis=-1).max() < 1e-13
        assert fields.verdicts[0] != pf.OPEN


def quadratic(spokes: list[Vector], arms: list[Vector], t: Sequence[Fraction], motion: Vector) -> Fraction:
    """Return Q of one motion (v, omega), straight from its definition."""
    v, omega = motion[:3], motion[3:]
    total = Fraction(0)
    for e, r, density in zip(spokes, arms, t, strict=True):
        first = cross(omega, r)
        moved = plus(v, first)
        total += density * (dot(moved, moved) - dot(e, cross(omega, first)))
    return total


def kernel(rows: list[Vector]) -> list[Vector]:
    """Return a basis of the exact kernel of rows (n, 6)."""
    rows = [list(row) for row in rows]
    pivots: list[int] = []
    for k in range(6):
        i = next((i for i in range(len(pivots), len(rows)) if rows[i][k]), None)
        if i is None:
            continue
        at = len(pivots)
        rows[at], rows[i] = rows[i], rows[at]
        rows[at] = [x / rows[at][k] for x in rows[at]]
        for j in range(len(rows)):
            if j != at:
                rows[j] = [x - rows[j][k] * y for x, y in zip(rows[j], rows[at], strict=True)]
        pivots.append(k)
    basis = []
    for free in (k for k in range(6) if k not in pivots):
        v = [Fraction(int(k == free)) for k in range(6)]
        for row, k in zip(rows, pivots, strict=False):
            v[k] = -row[free]
        basis.append(v)
    return basis


def determinant(a: list[Vector]) -> Fraction:
    if not a:
        return Fraction(1)
    return sum(
        ((-1) ** j * a[0][j] * determinant([row[:j] + row[j + 1 :] for row in a[1:]]) for j in range(len(a))),
        Fraction(0),
    )


def check_verdict(verdict: int, robot: Placed, z: Vector) -> None:
    """A proved verdict holds for the exact form at z on the exact kernel."""
    n = robot.planted.n
    rotation, centre = robot.pose(z)
    arms = [apply(rotation, b) for b in robot.arms[:n]]
    spokes = [minus(minus(a, centre), r) for a, r in zip(robot.exits[:n], arms, strict=True)]
    basis = kernel([[*e, *cross(r, e)] for e, r in zip(spokes, arms, strict=True)])

    def form(x: Vector) -> Fraction:
        return quadratic(spokes, arms, z[6:], x)

    q = [[(form(plus(a, b)) - form(a) - form(b)) / 2 for b in basis] for a in basis]
    d = len(q)
    if verdict == pf.STABLE:
        assert all(determinant([row[:k] for row in q[:k]]) > 0 for k in range(1, d + 1))
    elif verdict == pf.UNSTABLE:
        minors = [s for k in range(1, d + 1) for s in combinations(range(d), k)]
        assert any(determinant([[q[i][j] for j in s] for i in s]) < 0 for s in minors)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("n", COUNTS[:5])
def test_verdicts_hold_for_the_exact_form(n: int, width: float) -> None:
    rng = random.Random(3)
    seen = set()
    for robot in robots(n):
        for high in (False, True):
            z = exact_unknowns(robot.planted)
            if high:
                # Tensions of mixed size, no equilibrium: the form alone is looked at.
                z[6:] = [t * rng.choice([1, 100]) for t in z[6:]]
            box = box_around(rng, z, width, n)
            verdict = int(filled(robot, box, range(n), lengths_of(robot)).verdicts[0])
            seen.add(verdict)
            for x in (z, *(member(rng, box) for _ in range(3))):
                check_verdict(verdict, robot, x)
    assert width > 1e-6 or pf.OPEN not in seen


def polar(arms: list[Vector], spokes: list[Vector], t: Sequence[Fraction]) -> list[Vector]:
    """Return the symmetric matrix of the form from its values."""
    units = [[Fraction(int(i == k)) for k in range(6)] for i in range(6)]

    def form(x: Vector) -> Fraction:
        return quadratic(spokes, arms, t, x)

    single = [form(x) for x in units]
    return [
        [(form(plus(units[i], units[j])) - single[i] - single[j]) / 2 for j in range(6)] for i in range(6)
    ]


@pytest.mark.parametrize("width", [*WIDTHS, 1.0])
def test_the_form_and_the_wrenches_are_enclosed(width: float) -> None:
    """Entry by entry, for independent spokes, arms and densities, also negative ones, mostly at corners."""
    rng = random.Random(6)
    for n in (1, 2, 5):
        for _ in range(4):
            boxes = np.array([[rng.uniform(-3.0, 3.0)] * 2 for _ in range(7 * n)])
            boxes += width * np.array([[-rng.random(), rng.random()] for _ in range(7 * n)])
            e, r = (boxes[k * 3 * n : (k + 1) * 3 * n].reshape(n, 3, 1, 2) for k in range(2))
            t, Q, row = boxes[6 * n :], np.empty((6, 6, 2)), np.empty((6, 2))
            pf.quadratic_form(e, r, t, Q)
            for _ in range(6):
                z = member(rng, boxes)
                spokes, arms = ([z[k : k + 3] for k in range(s, s + 3 * n, 3)] for s in (0, 3 * n))
                exact = polar(arms, spokes, z[6 * n :])
                assert all(contains(Q[i, j], exact[i][j]) for i in range(6) for j in range(6))
                pf.wrench(e[0], r[0], row)
                wrench = [*spokes[0], *cross(arms[0], spokes[0])]
                assert all(contains(b, x) for b, x in zip(row, wrench, strict=True))
            assert width or np.ptp(Q, axis=-1).max() < 1e-12


def test_both_verdicts_occur() -> None:
    """The test above would pass for a kernel that proves only one of them."""
    rng = random.Random(4)
    seen = set()
    for n in COUNTS[:5]:
        for robot in robots(n):
            box = box_around(rng, exact_unknowns(robot.planted), 1e-9, n)
            seen.add(int(filled(robot, box, range(n), lengths_of(robot)).verdicts[0]))
    assert {pf.STABLE, pf.UNSTABLE} <= seen


def test_dependent_wrenches_leave_the_tensions_of_six_cables_open() -> None:
    rng = random.Random(5)
    robot = robots(6)[0]
    cables = robot.cables()
    cables.exits[5], cables.arms[5] = cables.exits[4], cables.arms[4]
    box = box_around(rng, exact_unknowns(robot.planted), 1e-9, 6)
    lengths = lengths_of(robot)
    fields = filled(robot, box, range(6), lengths)
    assert np.isfinite(fields.densities).all()
    charts = np.array([robot.planted.chart])
    pf.fill_fields(cables, robot.frame(), box[None], charts, np.arange(6), lengths, fields)
    assert np.isnan(fields.densities).all()
