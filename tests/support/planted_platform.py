"""Platforms with an equilibrium known exactly: pose, tensions and data are fractions."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations

import numpy as np

from cdpr_interval.exact.range import Range, RangeVector
from cdpr_interval.mechanics.six_dof.arrays import Model, build_model

Vector = list[Fraction]
HALF_TURN_SIGNS = ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))


def dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def cross(a: Sequence[Fraction], b: Sequence[Fraction]) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def minus(a: Sequence[Fraction], b: Sequence[Fraction]) -> Vector:
    return [x - y for x, y in zip(a, b, strict=True)]


def apply(matrix: Sequence[Sequence[Fraction]], v: Sequence[Fraction]) -> Vector:
    return [dot(row, v) for row in matrix]


def determinant(m: Sequence[Sequence[Fraction]]) -> Fraction:
    return dot(m[0], cross(m[1], m[2]))


def solve3(m: Sequence[Sequence[Fraction]], right: Sequence[Fraction]) -> Vector:
    """Solve m x = right by Cramer's rule."""
    columns = [list(c) for c in zip(*m, strict=True)]
    det = determinant(m)
    return [determinant([*columns[:k], list(right), *columns[k + 1 :]]) / det for k in range(3)]


def cayley(u: Sequence[Fraction]) -> list[Vector]:
    """Return the rotation of the quaternion (1, u), from the textbook matrix of a quaternion."""
    x, y, z = u
    s = 1 + x * x + y * y + z * z
    return [
        [(1 + x * x - y * y - z * z) / s, 2 * (x * y - z) / s, 2 * (x * z + y) / s],
        [2 * (x * y + z) / s, (1 - x * x + y * y - z * z) / s, 2 * (y * z - x) / s],
        [2 * (x * z - y) / s, 2 * (y * z + x) / s, (1 - x * x - y * y + z * z) / s],
    ]


def fraction(rng: random.Random, lo: int, hi: int) -> Fraction:
    """Return a random fraction in [lo, hi] that is not a double."""
    d = 30_011
    return Fraction(rng.randint(lo * d, hi * d), d)


def root_range(x: Fraction) -> Range:
    """Return a range of width 2^-200 around the square root of x."""
    scaled = math.isqrt((x * 4**200).__floor__())
    return Range(Fraction(scaled, 2**200), Fraction(scaled + 1, 2**200))


def widen(rng: random.Random, r: Range, width: Fraction) -> Range:
    return Range(r.lo - width * fraction(rng, 0, 1), r.hi + width * fraction(rng, 0, 1))


@dataclass(frozen=True)
class Planted:
    """A robot whose first cables balance the load at a known pose; the others are slack or just tight."""

    model: Model
    chart: int
    n: int
    u: Vector
    p: Vector
    t: Vector
    anchors: list[Vector]
    points: list[Vector]
    load: Vector
    lengths_sq: list[Fraction]
    """Squared lengths that the data hold; of the taut cables exactly |e_i|^2."""

    def rotation(self, u: Sequence[Fraction]) -> list[Vector]:
        """Return R(u) D_c."""
        signs = HALF_TURN_SIGNS[self.chart]
        return [[x * s for x, s in zip(row, signs, strict=True)] for row in cayley(u)]

    def centre(self, u: Sequence[Fraction], i: int) -> Vector:
        """Return c_i = A_i - R b_i."""
        return minus(self.anchors[i], apply(self.rotation(u), self.points[i]))

    def frame(self, u: Sequence[Fraction]) -> list[Vector]:
        """Return d_2, d_3 and m of the triple; in a plane d_3 is its normal."""
        if self.model.planar:
            d = minus(self.centre(u, 1), self.centre(u, 0))
            normal = [Fraction(0), Fraction(1), Fraction(0)]
            return [d, normal, cross(d, normal)]
        i, j, k = (int(c) for c in self.model.orders[0, :3])
        first = self.centre(u, i)
        d, e = minus(self.centre(u, j), first), minus(self.centre(u, k), first)
        return [d, e, cross(d, e)]

    def offsets(self, u: Sequence[Fraction]) -> Vector:
        """Return K_2 and K_3 of the triple; in a plane K_3 = 0."""
        d, e, _ = self.frame(u)
        l_sq = self.lengths_sq
        if self.model.planar:
            return [(dot(d, d) + l_sq[0] - l_sq[1]) / 2, Fraction(0)]
        i, j, k = (int(c) for c in self.model.orders[0, :3])
        return [(dot(d, d) + l_sq[i] - l_sq[j]) / 2, (dot(e, e) + l_sq[i] - l_sq[k]) / 2]

    def position(self, u: Sequence[Fraction], branch: int) -> Vector | None:
        """Return x on one branch of the triple, up to 2^-150; None where there is none."""
        d, e, m = self.frame(u)
        square = dot(m, m)
        if square == 0:
            return None
        foot = solve3([d, e, m], [*self.offsets(u), Fraction(0)])
        height_sq = self.lengths_sq[self.pivot] - dot(foot, foot)
        if height_sq < 0:
            return None
        height = branch * root_range(height_sq / square).lo
        return [a + height * b for a, b in zip(foot, m, strict=True)]

    @property
    def pivot(self) -> int:
        """The first cable of the order."""
        return int(self.model.orders[0, 0])

    def way(self) -> Vector:
        """Return x of the equilibrium."""
        return minus(self.p, self.centre(self.u, self.pivot))

    def branch(self) -> int:
        """Return the sign of sigma = m . x at the equilibrium; 1 for zero."""
        return 1 if dot(self.frame(self.u)[2], self.way()) >= 0 else -1

    def ordered(self) -> list[Planted]:
        """Return the robot with each of its orders in the first place."""
        orders = self.model.orders
        count = len(orders)
        changed = [np.ascontiguousarray(np.roll(orders, -k, axis=0)) for k in range(count)]
        return [replace(self, model=self.model._replace(orders=o)) for o in changed]

    def in_chart(self, chart: int) -> Planted | None:
        """Return the same equilibrium seen in another chart; None where its u is not finite."""
        # R(u) D_c is the rotation of the quaternion (1, u) e_c.
        q = quaternion_product([Fraction(1), *self.u], unit_quaternion(self.chart))
        back = [x if k == 0 else -x for k, x in enumerate(unit_quaternion(chart))]
        q = quaternion_product(q, back)
        return replace(self, chart=chart, u=[x / q[0] for x in q[1:]]) if q[0] else None

    def views(self, most: int = 2) -> list[Planted]:
        """Return the equilibrium in all charts in which no |u_k| exceeds ``most``; its own comes first."""
        others = [self.in_chart(c) for c in range(4) if c != self.chart]
        return [self, *(r for r in others if r is not None and max(map(abs, r.u)) <= most)]


def unit_quaternion(chart: int) -> Vector:
    return [Fraction(int(k == chart)) for k in range(4)]


def quaternion_product(a: Vector, b: Vector) -> Vector:
    v = [a[0] * y + b[0] * x + z for x, y, z in zip(a[1:], b[1:], cross(a[1:], b[1:]), strict=True)]
    return [a[0] * b[0] - dot(a[1:], b[1:]), *v]


def balance_moments(t: Vector, arms: list[Vector], spokes: list[Vector]) -> bool:
    """Change three entries of the first two spokes so that sum t r x e vanishes; False where that fails."""
    total = [Fraction(0)] * 3
    for tension, r, e in zip(t, arms, spokes, strict=True):
        total = [a + tension * b for a, b in zip(total, cross(r, e), strict=True)]
    unit = [[Fraction(int(i == j)) for j in range(3)] for i in range(3)]
    places = [(i, k) for i in range(2) for k in range(3)]
    columns = {(i, k): [t[i] * x for x in cross(arms[i], unit[k])] for i, k in places}

    def size(chosen: tuple[tuple[int, int], ...]) -> Fraction:
        return abs(determinant([columns[c] for c in chosen]))

    best = max(combinations(places, 3), key=size)
    if size(best) == 0:
        return False
    rows = [[columns[c][row] for c in best] for row in range(3)]
    for (i, k), change in zip(best, solve3(rows, [-x for x in total]), strict=True):
        spokes[i][k] += change
    return True


def random_u(rng: random.Random) -> Vector:
    """Return u in [-1, 1]^3, sometimes on a face or an axis of the chart."""
    u = [fraction(rng, -1, 1) for _ in range(3)]
    if rng.random() < 0.4:
        u[rng.randrange(3)] = Fraction(rng.choice([-1, 0, 1]))
    return u


def plant(
    rng: random.Random, n: int, *, slack: int = 0, width: Fraction = Fraction(0), zero_tension: bool = False
) -> Planted:
    """Return a random platform with n taut and some slack cables, and an equilibrium of it.

    ``width`` widens every datum to a range in which the exact one lies somewhere.
    """
    while True:
        chart, u = rng.randrange(4), random_u(rng)
        p = [fraction(rng, -2, 2) for _ in range(3)]
        points = [[fraction(rng, -1, 1) / 2 for _ in range(3)] for _ in range(n + slack)]
        signs = HALF_TURN_SIGNS[chart]
        rotation = [[x * s for x, s in zip(row, signs, strict=True)] for row in cayley(u)]
        arms = [apply(rotation, b) for b in points]
        spokes = [[fraction(rng, -1, 1), fraction(rng, -1, 1), fraction(rng, 1, 3)] for _ in range(n + slack)]
        t = [fraction(rng, 5, 50) for _ in range(n)]
        if zero_tension:
            t[n - 1] = Fraction(0)
        if balance_moments(t, arms[:n], spokes[:n]) and max(abs(x) for e in spokes for x in e) < 6:
            break
    anchors = [
        [a + b + c for a, b, c in zip(p, r, e, strict=True)] for r, e in zip(arms, spokes, strict=True)
    ]
    load = [-sum((a * e[k] for a, e in zip(t, spokes, strict=False)), Fraction(0)) for k in range(3)]
    lengths_sq = [dot(e, e) for e in spokes]
    lengths = [root_range(x) for x in lengths_sq]
    for i in range(n, n + slack):
        # Every other slack cable is exactly tight.
        longer = Fraction(0) if i % 2 else fraction(rng, 0, 1)
        lengths[i] = Range(lengths[i].lo, lengths[i].hi + longer)

    def data(v: Vector) -> RangeVector:
        x, y, z = (widen(rng, Range.exact(c), width) for c in v)
        return x, y, z

    model = build_model(
        [data(a) for a in anchors],
        [data(b) for b in points],
        [widen(rng, r, width) for r in lengths],
        data(load),
        n,
    )
    return Planted(model, chart, n, u, p, t, anchors, points, load, lengths_sq)


def plant_planar(rng: random.Random, *, slack: int = 0, width: Fraction = Fraction(0)) -> Planted:
    """Return a random platform on two taut cables in the plane y = 0; slack ones lie anywhere.

    The load is vertical; ``width`` widens what may be uncertain within the plane.
    """
    zero = Fraction(0)
    while True:
        chart, u = rng.choice([0, 2]), [zero, fraction(rng, -1, 1), zero]
        p = [fraction(rng, -2, 2), zero, fraction(rng, -2, 2)]
        signs = HALF_TURN_SIGNS[chart]
        rotation = [[x * s for x, s in zip(row, signs, strict=True)] for row in cayley(u)]
        points = [[fraction(rng, -1, 1) / 2, zero, fraction(rng, -1, 1) / 2] for _ in range(2)]
        points += [[fraction(rng, -1, 1) / 2 for _ in range(3)] for _ in range(slack)]
        arms = [apply(rotation, b) for b in points]
        t = [fraction(rng, 5, 50) for _ in range(2)]
        if abs(arms[1][0]) < Fraction(1, 10):
            continue
        # No force along x, then no moment about y.
        x, z = fraction(rng, -1, 1), fraction(rng, 1, 3)
        across = -t[0] * x / t[1]
        up = (t[0] * (arms[0][2] * x - arms[0][0] * z) + t[1] * arms[1][2] * across) / (t[1] * arms[1][0])
        spokes = [[x, zero, z], [across, zero, up]]
        spokes += [[fraction(rng, -1, 1), fraction(rng, -1, 1), fraction(rng, 1, 3)] for _ in range(slack)]
        if max(abs(x) for e in spokes for x in e) < 6:
            break
    anchors = [
        [a + b + c for a, b, c in zip(p, r, e, strict=True)] for r, e in zip(arms, spokes, strict=True)
    ]
    load = [zero, zero, -(t[0] * z + t[1] * up)]
    lengths_sq = [dot(e, e) for e in spokes]
    lengths = [widen(rng, root_range(x), width) for x in lengths_sq]
    for i in range(2, 2 + slack):
        lengths[i] = Range(lengths[i].lo, lengths[i].hi + fraction(rng, 0, 1))

    def data(v: Vector) -> RangeVector:
        x, y, z = (widen(rng, Range.exact(c), width if c else zero) for c in v)
        return x, y, z

    model = build_model(
        [data(a) for a in anchors], [data(b) for b in points], lengths, data(load), 2, planar=True
    )
    return Planted(model, chart, 2, u, p, t, anchors, points, load, lengths_sq)


UNCERTAIN = ("exits", "arms", "exit_steps", "arm_steps", "square", "lengths_sq", "load")
"""Arrays of a model that have an error array beside them."""


def shifted(robot: Planted, name: str, size: float) -> Planted:
    """Return the robot with one array of its model moved by up to ``size``, and its errors grown by as much.

    The exact data stay in the enclosures, at their border: a kernel that forgets this error misses them.
    """
    value, error = getattr(robot.model, name), getattr(robot.model, f"{name}_err")
    step = size * np.cos(1.0 + np.arange(value.size)).reshape(value.shape)
    grown = np.abs(step).max(axis=0) if value.ndim > error.ndim else np.abs(step)
    changed = {name: value + step, f"{name}_err": error + grown * (1.0 + 1e-6)}
    return replace(robot, model=robot.model._replace(**changed))
