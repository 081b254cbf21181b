"""The positions of a Delta in balls: knees, poses by three spheres, drives by two circles, limits.

Seen from the platform's centre, chain i ends at P if its shoulder is moved inwards by R_B: all three pass
through one point, and P lies on three spheres of radius L_B around the moved knees

    C_i = (R_A - R_B) e_i + L_A (cos alpha e_i - sin alpha z),    or    (R_A - R_B) e_i + s d_i

with the unit vectors e_i outwards and d_i along the rail. Work under `balls.precision`; numbers may be as
wide as tolerances make them, and everything encloses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from flint import arb, arb_mat, fmpq

from cdpr_interval.exact import balls
from cdpr_interval.exact.angle import Angle
from cdpr_interval.exact.range import as_range
from cdpr_interval.robots.delta import DeltaRobot
from cdpr_interval.robots.numbers import Scalar

Vector = list[arb]
CONTRACTIONS = 8
"""Most steps that make an enclosure narrower."""
NARROW = 2.0**-80
"""m: less than doubles show."""


@dataclass(frozen=True)
class Chain:
    """One of the three."""

    outward: Vector
    """e_i."""
    shoulder: Vector
    """(R_A - R_B) e_i."""
    rail: Vector | None
    """d_i; None for an arm."""

    @property
    def tangent(self) -> Vector:
        """t_i = z x e_i, the axis about which an arm turns, and along which the two bars lie apart."""
        x, y, _ = self.outward
        return [-y, x, arb(0)]


@dataclass(frozen=True)
class Delta:
    """A Delta in balls."""

    chains: tuple[Chain, Chain, Chain]
    radius: arb
    """R_A - R_B."""
    arm: arb | None
    bar: arb
    tool: Vector

    def knee(self, i: int, drive: arb) -> Vector:
        """Return C_i for an angle in rad, or a carriage's position in m."""
        chain = self.chains[i]
        if chain.rail is not None:
            return [a + drive * d for a, d in zip(chain.shoulder, chain.rail, strict=True)]
        assert self.arm is not None
        out, down = self.arm * drive.cos(), self.arm * drive.sin()
        x, y, z = (a + out * e for a, e in zip(chain.shoulder, chain.outward, strict=True))
        return [x, y, z - down]

    def knee_rate(self, i: int, drive: arb) -> Vector:
        """Return the derivative of C_i by its drive."""
        chain = self.chains[i]
        if chain.rail is not None:
            return chain.rail
        assert self.arm is not None
        x, y, z = (-self.arm * drive.sin() * e for e in chain.outward)
        return [x, y, z - self.arm * drive.cos()]


def delta_of(robot: DeltaRobot) -> Delta:
    """Return a robot in balls."""
    radius = scalar(robot.base_radius) - scalar(robot.platform_radius)
    chains = []
    for i, theta in enumerate(robot.arm_angles):
        cosine, sine = cosine_and_sine(theta)
        rail = None
        if robot.is_linear:
            assert robot.rail_directions is not None
            rail = unit([scalar(x) for x in robot.rail_directions[i]])
        chains.append(Chain([cosine, sine, arb(0)], [radius * cosine, radius * sine, arb(0)], rail))
    first, second, third = chains
    arm = None if robot.is_linear or robot.arm is None else scalar(robot.arm)
    tool = [scalar(x) for x in robot.tool_offset]
    return Delta((first, second, third), radius, arm, scalar(robot.bar), tool)


def scalar(value: Scalar) -> arb:
    """Enclose a number of the data."""
    return balls.from_range(as_range(value))


def radians(angle: Angle) -> arb:
    """Enclose an angle in rad."""
    ball = balls.from_range(angle.bounds)
    return ball * arb.pi() / 180 if angle.in_degrees else ball


def cosine_and_sine(angle: Angle) -> tuple[arb, arb]:
    """Enclose both; those of 120 degrees are exact where they are rational."""
    if angle.in_degrees and angle.is_exact:
        turn = angle.bounds.lo / 180
        sine, cosine = arb.sin_cos_pi_fmpq(fmpq(turn.numerator, turn.denominator))
        return cosine, sine
    ball = radians(angle)
    return ball.cos(), ball.sin()


def dot(a: Sequence[arb], b: Sequence[arb]) -> arb:
    """Return a . b."""
    return sum((x * y for x, y in zip(a, b, strict=True)), arb(0))


def cross(a: Sequence[arb], b: Sequence[arb]) -> Vector:
    """Return a x b."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def square(a: Sequence[arb]) -> arb:
    """Return |a|^2, which is not negative."""
    return sum((x * x for x in a), arb(0)).nonnegative_part()


def unit(a: Sequence[arb]) -> Vector:
    """Return a / |a|."""
    norm = square(a).sqrt()
    return [x / norm for x in a]


def minus(a: Sequence[arb], b: Sequence[arb]) -> Vector:
    """Return a - b."""
    return [x - y for x, y in zip(a, b, strict=True)]


class Spheres(NamedTuple):
    """Where three spheres of one radius meet."""

    poses: tuple[Vector, ...]
    """Platform centres, lower first where that is known; two, or none."""
    is_decided: bool
    """The poses are all there are, and each of them is one."""
    is_ordered: bool
    """The first one is lower."""
    reason: str


def meeting(centres: Sequence[Vector], radius: arb) -> Spheres:
    """Return where three spheres around moved knees meet.

    With a, b from the first centre to the others and m = a x b, the foot is (|b|^2 m x a + |a|^2 b x m) /
    2|m|^2 from it, and the poses lie along m on both sides. Nothing is divided by the height of m: knees
    above each other are no exception, only knees on one line are.
    """
    first = centres[0]
    a, b = minus(centres[1], first), minus(centres[2], first)
    m = cross(a, b)
    size = square(m)
    if not size > 0:
        return Spheres((), False, False, "the three knees may lie on one line")
    foot = [
        (square(b) * p + square(a) * q) / (2 * size) for p, q in zip(cross(m, a), cross(b, m), strict=True)
    ]
    left = radius * radius - square(foot)
    if left < 0:
        return Spheres((), True, True, "the bars are too short to meet")
    if not left > 0:
        return Spheres((), False, False, "the bars may just meet: one pose, two or none")
    along = (left / size).sqrt()
    up = -1 if m[2] > 0 else 1
    poses = tuple(
        [c + f + sign * along * v for c, f, v in zip(first, foot, m, strict=True)] for sign in (up, -up)
    )
    is_ordered = bool(m[2] > 0 or m[2] < 0)
    return Spheres(
        poses, True, is_ordered, "" if is_ordered else "which of the two poses is lower is not known"
    )


def narrowed(centres: Sequence[Vector], radius: arb, pose: Vector) -> Vector:
    """Return a narrower enclosure of the pose that an enclosure holds for every choice of centres and radius.

    Krawczyk's operator around the middle: P - Y F(P_m) - (I - Y J)(P - P_m) with F_i = |P - C_i|^2 - L_B^2
    holds all zeros of F in the enclosure. One that only rounding makes wide stays as it is.
    """
    if all(x.rad() < NARROW for x in (*pose, *(x for c in centres for x in c))):
        return pose
    for _ in range(CONTRACTIONS):
        middle = [x.mid() for x in pose]
        jacobian = arb_mat([[2 * v for v in minus(pose, c)] for c in centres])
        try:
            inverse = arb_mat([[2 * v.mid() for v in minus(middle, c)] for c in centres]).inv().mid()
        except ZeroDivisionError:
            return pose
        values = balls.vector([square(minus(middle, c)) - radius * radius for c in centres])
        around = balls.vector(minus(pose, middle))
        image = balls.vector(middle) - inverse * values + (balls.identity() - inverse * jacobian) * around
        found, gained = [], False
        for new, old in zip(image.entries(), pose, strict=True):
            both = new.intersection(old) if new.overlaps(old) else old
            gained |= bool(both.rad() < old.rad() * arb(0.9))
            found.append(both if both.rad() < old.rad() else old)
        pose = found
        if not gained:
            break
    return pose


class Drives(NamedTuple):
    """What brings one chain to a point: the useful branch, and the other one."""

    useful: arb | None
    other: arb | None
    reach: bool | None
    """False: the point is proved to be out of reach; None: that is not known."""


def drives_at(delta: Delta, i: int, centre: Vector) -> Drives:
    """Return the angles of an arm in rad, or the positions of a carriage in m, at a platform's centre.

    An arm: A cos alpha + B sin alpha = K with A = 2 R - Q, B = 2 z, K = S + Q R / L_A, Q = 2 e . P and
    S = (L_B^2 - L_A^2 - R^2 - |P|^2) / L_A: alpha = atan2(B, A) +- arccos(K / |(A, B)|). The useful branch
    has the plus: its knee lies outwards of the line from shoulder to platform; of a carriage, the minus.
    """
    chain, bar = delta.chains[i], delta.bar
    if chain.rail is not None:
        way = minus(centre, chain.shoulder)
        along = dot(chain.rail, way)
        root = bar * bar - square(way) + along * along
        if root < 0:
            return Drives(None, None, False)
        if not root >= 0:
            return Drives(None, None, None)
        half = root.sqrt()
        near, far = (narrowed_drive(delta, i, centre, v) for v in (along - half, along + half))
        return Drives(near, far, True)
    arm, radius = delta.arm, delta.radius
    assert arm is not None
    q = 2 * dot(chain.outward, centre)
    k = (bar * bar - arm * arm - radius * radius - square(centre)) / arm + q * radius / arm
    a, b = 2 * radius - q, 2 * centre[2]
    across = a * a + b * b
    if k * k > across:
        return Drives(None, None, False)
    if not (across > 0 and k * k <= across):
        return Drives(None, None, None)
    turn, half = arb.atan2(b, a), (k / across.sqrt()).acos()
    if not half.is_finite():
        return Drives(None, None, None)
    useful, other = (narrowed_drive(delta, i, centre, v) for v in (turn + half, turn - half))
    return Drives(principal(useful), principal(other), True)


def narrowed_drive(delta: Delta, i: int, centre: Vector, drive: arb) -> arb:
    """Return a narrower enclosure of the drive that an enclosure holds, by Newton's interval operator."""
    if drive.rad() < NARROW:
        return drive
    for _ in range(CONTRACTIONS):
        middle = drive.mid()
        value = square(minus(centre, delta.knee(i, middle))) - delta.bar * delta.bar
        slope = -2 * dot(minus(centre, delta.knee(i, drive)), delta.knee_rate(i, drive))
        if not (slope > 0 or slope < 0):
            break
        found = middle - value / slope
        if not (found.rad() < drive.rad() * arb(0.9) and found.overlaps(drive)):
            break
        drive = found.intersection(drive)
    return drive


def drive_of_knee(delta: Delta, i: int, knee: Vector) -> arb:
    """Return the drive that brings a moved knee to a place."""
    chain, way = delta.chains[i], minus(knee, delta.chains[i].shoulder)
    return arb.atan2(-way[2], dot(chain.outward, way)) if chain.rail is None else dot(chain.rail, way)


def principal(angle: arb) -> arb:
    """Return an angle moved into (-pi, pi]; one that may lie on either side of the cut stays where it is."""
    if angle > arb.pi():
        return angle - 2 * arb.pi()
    return angle + 2 * arb.pi() if angle <= -arb.pi() else angle


def lean(delta: Delta, i: int, centre: Vector, drive: arb) -> arb:
    """Return the angle by which the bars of a chain lean out of its plane, not negative."""
    bars = minus(centre, delta.knee(i, drive))
    sine = abs(dot(delta.chains[i].tangent, bars)) / delta.bar
    return _quarter(sine.lower()).union(_quarter(sine.upper()))


def _quarter(sine: arb) -> arb:
    """Return the arc sine of an exact number, of its nearest one in 0 to 1."""
    return arb.pi() / 2 if sine >= 1 else sine.max(arb(0)).asin()


def elbow(delta: Delta, i: int, centre: Vector, drive: arb) -> arb:
    """Return the angle at the knee from arm to bars, in the plane of the chain, 0 to 2 pi: useful below pi.

    Folded and unfolded beyond 0 are a whole turn apart: where both may be, so is everything between.
    """
    outward, knee = delta.chains[i].outward, delta.knee(i, drive)
    inner, bars = minus(delta.chains[i].shoulder, knee), minus(centre, knee)
    (a, b), (c, d) = ((dot(v, outward), v[2]) for v in (inner, bars))
    sine, cosine = a * d - b * c, a * c + b * d
    if sine < 0 or cosine < 0:
        return arb.pi() + arb.atan2(-sine, -cosine)
    if sine >= 0:
        return arb.atan2(sine, cosine)
    return arb.pi() + arb.pi() * arb(0, 1)
