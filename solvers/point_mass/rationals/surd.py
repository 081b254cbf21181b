"""The pose of at most three inextensible cables in exact arithmetic: numbers a + b sqrt(D), a, b, D rational.

Its coordinates, the multipliers of its cables and its squared distances to all exit points are of this
form, so the sign of every tension and slack is decidable when the lengths are exact.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

from cdpr_interval.exact.vector import Vector, along, cross, dot, minus

Surd = tuple[Fraction, Fraction]
"""(a, b) stands for a + b sqrt(D), with the D of its pose."""


@dataclass(frozen=True)
class ExactPose:
    """The lowest common point q + r sqrt(D) of the spheres of one to three cables, D > 0."""

    base: Vector
    slope: Vector
    radicand: Fraction
    multipliers: tuple[Surd, ...]
    """t_i with sum t_i (p - A_i) = f, one for each cable."""

    def sign(self, number: Surd) -> int:
        """Return -1, 0 or 1."""
        a, b = number
        sa, sb = (a > 0) - (a < 0), (b > 0) - (b < 0)
        if sa * sb >= 0:
            return sa or sb
        difference = a * a - b * b * self.radicand
        return sa * ((difference > 0) - (difference < 0))

    def excess(self, exit_point: Vector, length: Fraction) -> int:
        """Return the sign of |p - A| - l."""
        e = minus(self.base, exit_point)
        a = dot(e, e) + self.radicand * dot(self.slope, self.slope) - length**2
        return self.sign((a, 2 * dot(e, self.slope)))

    def component(self, direction: Vector, origin: Vector) -> int:
        """Return the sign of direction . (p - origin)."""
        return self.sign((dot(direction, minus(self.base, origin)), dot(direction, self.slope)))

    def carried(self) -> bool:
        """Return True when every multiplier is positive."""
        return all(self.sign(t) > 0 for t in self.multipliers)


def exact_pose(exits: Sequence[Vector], lengths: Sequence[Fraction], load: Vector) -> ExactPose | None:
    """Return the pose of one to three cables that alone carry the load.

    None where the directions of the cables are dependent or the spheres do not cross.
    """
    zero = Fraction(0)
    a, size = exits[0], lengths[0]
    if len(exits) == 1:
        radicand = size**2 / dot(load, load)
        return ExactPose(a, load, radicand, ((zero, 1 / radicand),))
    d = minus(exits[1], a)
    dd = dot(d, d)
    if len(exits) == 2:
        if dd == 0:
            return None
        q = dot(load, d) / dd
        g = along(load, -q, d)
        c = (1 + (size**2 - lengths[1] ** 2) / dd) / 2
        square, gg = size**2 - c * c * dd, dot(g, g)
        if square <= 0 or gg == 0:
            return None
        radicand = square / gg
        return ExactPose(along(a, c, d), g, radicand, ((q, (1 - c) / radicand), (-q, c / radicand)))
    e = minus(exits[2], a)
    m = cross(d, e)
    mm, fm = dot(m, m), dot(load, m)
    if mm == 0 or fm == 0:
        return None
    k2 = (dd + size**2 - lengths[1] ** 2) / 2
    k3 = (dot(e, e) + size**2 - lengths[2] ** 2) / 2
    v = along(tuple(k2 * x for x in e), -k3, d)
    radicand = size**2 * mm - dot(v, v)
    if radicand <= 0:
        return None
    side = 1 if fm > 0 else -1
    x0 = tuple(x / mm for x in cross(v, m))
    x1 = tuple(side * x / mm for x in m)
    # The sum of the multipliers is T = f . m / (side sqrt(D)); the rest is linear in T x - f.
    total = side * fm / radicand
    w0 = along(tuple(-x for x in load), total * radicand, x1)
    w1 = tuple(total * x for x in x0)
    second = tuple(dot(cross(w, e), m) / mm for w in (w0, w1))
    third = tuple(dot(cross(d, w), m) / mm for w in (w0, w1))
    return ExactPose(
        along(a, Fraction(1), x0),
        (x1[0], x1[1], x1[2]),
        radicand,
        (
            (-second[0] - third[0], total - second[1] - third[1]),
            (second[0], second[1]),
            (third[0], third[1]),
        ),
    )


def is_pose_of(pose: ExactPose, exits: Sequence[Vector], lengths: Sequence[Fraction], load: Vector) -> bool:
    """Return True when a pose is, exactly, also the lowest common point of the spheres of other cables."""
    if any(pose.excess(a, s) != 0 for a, s in zip(exits, lengths, strict=True)):
        return False
    a = exits[0]
    if len(exits) == 1:
        axes = [cross(load, unit) for unit in _UNITS]
        return all(pose.component(axis, a) == 0 for axis in axes) and pose.component(load, a) > 0
    d = minus(exits[1], a)
    if len(exits) == 2:
        low = along(load, -dot(load, d) / dot(d, d), d)
        return pose.component(cross(d, load), a) == 0 and pose.component(low, a) > 0
    m = cross(d, minus(exits[2], a))
    return pose.component(m, a) * dot(load, m) > 0


def corners(
    exits: Sequence[Vector], lengths: Sequence[Fraction], load: Vector, subsets: Iterable[tuple[int, ...]]
) -> Iterator[tuple[tuple[int, ...], ExactPose]]:
    """Yield the subsets, with their pose, that alone carry the load at the lowest point of all balls.

    The point is the same for all of them. Where the balls have a common inner point, all tensions that hold
    the load are means of those of such subsets.
    """
    for few in subsets:
        pose = exact_pose([exits[i] for i in few], [lengths[i] for i in few], load)
        if pose is None or not pose.carried():
            continue
        if all(pose.excess(a, s) <= 0 for a, s in zip(exits, lengths, strict=True)):
            yield few, pose


_UNITS: tuple[Vector, ...] = (
    (Fraction(1), Fraction(0), Fraction(0)),
    (Fraction(0), Fraction(1), Fraction(0)),
    (Fraction(0), Fraction(0), Fraction(1)),
)
