"""Singular poses of a Delta: ranks of its bars, decided exactly where the data are exact.

With u_k along the bars of chain k, t_k its tangent and n_k = t_k x u_k the normal of its parallelogram, the
six bars hold the platform by the rows (u_k, p_k x u_k) and (0, n_k), p_k the joint's place from the centre.
Their determinant is a multiple of det[u_1 u_2 u_3] det[n_1 n_2 n_3]. A drive is singular where its joint
cannot push: u_k . dC_k/dq_k = 0, where its two branches meet.

Numbers here are balls, or `Surd` for exact data: the knees are then numbers over sqrt 3 and three roots.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from typing import Any

from flint import arb

from cdpr_interval.exact.surds import Root3, Surd, rational, roots_of
from cdpr_interval.exact.vector import Vector as ExactVector
from cdpr_interval.robots.delta import DeltaRobot
from cdpr_interval.robots.numbers import exact, exact_point

COSINES = {
    0: Root3(Fraction(1)),
    30: Root3(Fraction(0), Fraction(1, 2)),
    60: Root3(Fraction(1, 2)),
    90: Root3(Fraction(0)),
}
"""Of the angles up to a quarter turn at which cosine and sine have no other root than that of 3."""
Row = list[Any]


@dataclass(frozen=True)
class Bars:
    """The bars of the three chains at a pose, in numbers of any kind."""

    along: list[Row]
    """u_k, times the bars' length."""
    normals: list[Row]
    """n_k, times the bars' length."""
    joints: list[Row]
    """p_k."""
    drives: list[Any]
    """u_k . dC_k/dq_k, times the bars' length; of exact data a multiple of it."""


@dataclass(frozen=True)
class Ranks:
    """What the bars hold; None where it is not known."""

    six: int | None
    """Of the six rows: 6 minus the freedoms that the platform gains."""
    bars: int | None
    """Of the three u."""
    normals: int | None
    """Of the three n."""
    kinds: tuple[str, ...]
    """Words of `KINDS`."""
    drives: tuple[bool | None, ...]
    """Of each chain: its drive is singular."""

    @property
    def is_singular(self) -> bool | None:
        """Whether the pose is singular in any way."""
        known = [*self.drives, None if self.six is None else self.six < 6]
        return True if True in known else None if None in known else False


KINDS = {
    "a": "all bars are parallel",
    "b": "the bars of two chains are parallel",
    "c": "two parallelograms lie in parallel planes",
    "d": "all parallelograms lie in parallel planes",
    "coplanar bars": "the bars are parallel to one plane, no two of them to each other",
    "coplanar normals": "the parallelograms are parallel to one line, no two of them to each other",
}
"""Kinds of singular poses: a to d as the source has them, and two that it leaves out."""


def cross(a: Sequence[Any], b: Sequence[Any]) -> Row:
    """Return a x b."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def determinant(rows: Sequence[Sequence[Any]]) -> Any:
    """Return det of three rows."""
    return dot(rows[0], cross(rows[1], rows[2]))


def ball_is_zero(x: arb) -> bool | None:
    """Return whether a ball is 0: False, or not known unless it is exactly 0."""
    return False if x > 0 or x < 0 else True if x.is_zero() else None


def surd_is_zero(x: Surd) -> bool | None:
    """Return whether an exact number is 0."""
    return x.is_zero


def rank(rows: Sequence[Sequence[Any]], is_zero: Callable[[Any], bool | None]) -> int | None:
    """Return the rank of three rows of three or more entries, by minors; None where it is not known."""
    count = len(rows[0])
    for size in (3, 2, 1):
        minors = (
            minor([[rows[i][j] for j in columns] for i in chosen])
            for chosen in combinations(range(3), size)
            for columns in combinations(range(count), size)
        )
        seen = [is_zero(m) for m in minors]
        if False in seen:
            return size
        if None in seen:
            return None
    return 0


def minor(rows: Sequence[Sequence[Any]]) -> Any:
    """Return the determinant of one, two or three rows."""
    if len(rows) == 3:
        return determinant(rows)
    return rows[0][0] * rows[1][1] - rows[0][1] * rows[1][0] if len(rows) == 2 else rows[0][0]


def ranks_of(bars: Bars, is_zero: Callable[[Any], bool | None]) -> Ranks:
    """Return what the bars of a pose hold."""
    of_bars, of_normals = rank(bars.along, is_zero), rank(bars.normals, is_zero)
    drives = tuple(is_zero(v) for v in bars.drives)
    if of_bars is None or of_normals is None:
        return Ranks(None, of_bars, of_normals, (), drives)
    six: int | None = 3 + of_bars
    if of_normals < 3:
        # The n hold no turns about these axes: add the rank of the u with their moments there.
        axes = _free_axes(bars.normals, of_normals, is_zero)
        moments = [[dot(cross(p, u), w) for w in axes] for p, u in zip(bars.joints, bars.along, strict=True)]
        held = rank([[*u, *m] for u, m in zip(bars.along, moments, strict=True)], is_zero)
        six = None if held is None else of_normals + held
    return Ranks(six, of_bars, of_normals, _kinds(bars, of_bars, of_normals, is_zero), drives)


def _free_axes(normals: list[Row], of_normals: int, is_zero: Callable[[Any], bool | None]) -> list[Row]:
    """Return directions that span what is at right angles to three vectors."""
    one, nil = _one(normals[0][0]), normals[0][0] - normals[0][0]
    unit = [[one if i == j else nil for j in range(3)] for i in range(3)]
    if of_normals == 2:
        pairs = (cross(a, b) for a, b in combinations(normals, 2))
        return [next(c for c in pairs if any(is_zero(x) is False for x in c))]
    if of_normals == 1:
        n = next(n for n in normals if any(is_zero(x) is False for x in n))
        return [cross(n, e) for e in unit]
    return unit


def _one(like: Any) -> Any:
    return rational(Root3(Fraction(1)), like) if isinstance(like, Surd) else arb(1)


def _kinds(
    bars: Bars, of_bars: int, of_normals: int, is_zero: Callable[[Any], bool | None]
) -> tuple[str, ...]:
    found = []
    for size, rows, all_word, two_word, flat_word in (
        (of_bars, bars.along, "a", "b", "coplanar bars"),
        (of_normals, bars.normals, "d", "c", "coplanar normals"),
    ):
        if size < 2:
            found.append(all_word)
        elif size == 2:
            pairs = [[is_zero(x) for x in cross(a, b)] for a, b in combinations(rows, 2)]
            if any(all(pair) for pair in pairs):
                found.append(two_word)
            elif all(False in pair for pair in pairs):
                found.append(flat_word)
    # Where all bars are parallel the normals are coplanar anyhow, and where all planes are the bars are.
    if "a" in found or "d" in found:
        found = [word for word in found if not word.startswith("coplanar")]
    return tuple(found)


def exact_bars(robot: DeltaRobot, centre: ExactVector) -> Bars | None:
    """Return the bars at a platform's centre on the useful branch, in exact numbers.

    None where a number is a range, an angle is not a multiple of 30 degrees, a rail's length is not rational,
    or the pose is out of reach.
    """
    if robot.uncertain or any(not _is_easy(angle) for angle in robot.arm_angles):
        return None
    radius = Root3(exact(robot.base_radius) - exact(robot.platform_radius))
    platform = Root3(exact(robot.platform_radius))
    circles = [_circle(robot, i, radius, centre) for i in range(3)]
    if any(circle is None or circle[0].sign < 0 for circle in circles):
        return None
    given = [circle for circle in circles if circle is not None]
    roots = roots_of([square for square, *_ in given])
    along, normals, joints, drives = [], [], [], []
    for i, ((_, start, steps), root) in enumerate(zip(given, roots, strict=True)):
        cosine, sine = _easy(robot, i)
        knee = [rational(a, root) + rational(s, root) * root for a, s in zip(start, steps, strict=True)]
        u = [rational(Root3(c), root) - k for c, k in zip(centre, knee, strict=True)]
        t = [rational(x, root) for x in (-sine, cosine, Root3(Fraction(0)))]
        along.append(u)
        normals.append(cross(t, u))
        joints.append([rational(platform * x, root) for x in (cosine, sine, Root3(Fraction(0)))])
        drives.append(root)
    return Bars(along, normals, joints, drives)


def _circle(robot: DeltaRobot, i: int, radius: Root3, centre: ExactVector) -> Any:
    """Return D, and the knee as start + sqrt(D) steps, for a chain; None where it is not such a number."""
    cosine, sine = _easy(robot, i)
    nil = Root3(Fraction(0))
    p = [Root3(x) for x in centre]
    shoulder = [radius * cosine, radius * sine, nil]
    bar = Root3(exact(robot.bar))
    if robot.is_linear:
        assert robot.rail_directions is not None
        rail = exact_point(robot.rail_directions[i])
        norm = Root3(sum((x * x for x in rail), Fraction(0))).root()
        if norm is None:
            return None
        d = [Root3(x) * norm.inverse() for x in rail]
        way = [a - b for a, b in zip(p, shoulder, strict=True)]
        at = dot(d, way)
        square = bar * bar - dot(way, way) + at * at
        return square, [a + at * v for a, v in zip(shoulder, d, strict=True)], [-v for v in d]
    arm = Root3(exact(robot.arm)) if robot.arm is not None else nil
    two = Root3(Fraction(2))
    q = two * (cosine * p[0] + sine * p[1])
    k = (bar * bar - arm * arm - radius * radius - dot(p, p)) * arm.inverse() + q * radius * arm.inverse()
    a, b = two * radius - q, two * p[2]
    across = a * a + b * b
    if not across:
        return None
    share = arm * across.inverse()
    # cos alpha = (A K - B s) / (A^2 + B^2), sin alpha = (B K + A s) / (A^2 + B^2), s^2 = A^2 + B^2 - K^2.
    out, down = share * a * k, share * b * k
    start = [shoulder[0] + out * cosine, shoulder[1] + out * sine, -down]
    steps = [-(share * b) * cosine, -(share * b) * sine, -(share * a)]
    return across - k * k, start, steps


def _is_easy(angle: Any) -> bool:
    lo = angle.bounds.lo
    return bool(angle.is_exact and (lo == 0 or (angle.in_degrees and lo % 30 == 0)))


def _easy(robot: DeltaRobot, i: int) -> tuple[Root3, Root3]:
    """Return cosine and sine of a chain's angle, a multiple of 30 degrees."""
    degrees = int(robot.arm_angles[i].bounds.lo) % 360
    return _cosine(degrees), _cosine((degrees - 90) % 360)


def _cosine(degrees: int) -> Root3:
    degrees = min(degrees, 360 - degrees)
    return COSINES[degrees] if degrees <= 90 else -COSINES[180 - degrees]
