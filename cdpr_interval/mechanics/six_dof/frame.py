"""Frames in which a subset of taut cables is solved, and the way back to the robot's frames."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.exact.range import Range, RangeVector, difference
from cdpr_interval.mechanics.rotation import HALF_TURNS
from cdpr_interval.mechanics.six_dof.fields import FrameBounds

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Frame:
    """Model base = ``base`` (A - origin), model platform = ``platform`` b, both rotations."""

    origin: RangeVector
    base: arb_mat
    platform: arb_mat

    @staticmethod
    def plain() -> Frame:
        """Return the robot's own frames."""
        zero = Range.exact(0)
        return Frame((zero, zero, zero), balls.identity(), balls.identity())

    @cached_property
    def bounds(self) -> FrameBounds:
        """The frame in arrays."""
        unit = balls.identity()
        plain = not any(map(any, self.origin)) and self.base == unit and self.platform == unit
        with balls.precision():
            return FrameBounds(
                plain,
                balls.bounds_array(self.base.transpose()).reshape(3, 3, 2),
                balls.bounds_array(self.platform).reshape(3, 3, 2),
                balls.bounds_array(balls.ranges(self.origin) * -1).reshape(3, 1, 2),
            )

    def exit_point(self, a: RangeVector) -> RangeVector:
        """Return an exit point in the model's base frame."""
        return turned(self.base, difference(a, self.origin))

    def arm(self, b: RangeVector) -> RangeVector:
        """Return an arm in the model's platform frame."""
        return turned(self.platform, b)

    def force(self, f: RangeVector) -> RangeVector:
        """Return a force in the model's base frame."""
        return turned(self.base, f)


def turned(rotation: arb_mat, v: RangeVector) -> RangeVector:
    """Return rotation v as exact ranges; v itself where the rotation is the identity."""
    if all(x.is_exact() and x == int(i % 4 == 0) for i, x in enumerate(rotation.entries())):
        return v
    x, y, z = (balls.to_range(e) for e in (rotation * balls.ranges(v)).entries())
    return (x, y, z)


@dataclass(frozen=True)
class Pose:
    """A certified pose of the centre of mass in the robot's frames, with the taut cables' t."""

    rotation: arb_mat
    centre: arb_mat
    densities: tuple[arb, ...]
    """t = tension / length of each taut cable, in the subset's order."""


def cayley(u: list[arb]) -> arb_mat:
    """Return R(u)."""
    x, y, z = u
    k = arb_mat([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return balls.identity() + (k + k * k) * (2 / one_plus_norm_sq(u))


def one_plus_norm_sq(u: list[arb]) -> arb:
    """Return 1 + |u|^2, at least 1 for wide balls too."""
    return 1 + sum(((x * x).nonnegative_part() for x in u), arb(0))


def half_turn(chart: int) -> arb_mat:
    """Return D_c."""
    d = [int(x) for x in HALF_TURNS[chart]]
    return arb_mat(3, 3, [d[0], 0, 0, 0, d[1], 0, 0, 0, d[2]])


def centred_cayley(u: list[arb]) -> arb_mat:
    """Enclose R over a box: R(m) + sum_k dR/du_k (u_k - m_k)."""
    mids = [x.mid() for x in u]
    x, y, z = u
    k = arb_mat([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    g = 2 / one_plus_norm_sq(u)
    rest = (k + k * k) * g
    generators = [
        arb_mat([[0, 0, 0], [0, 0, -1], [0, 1, 0]]),
        arb_mat([[0, 0, 1], [0, 0, 0], [-1, 0, 0]]),
        arb_mat([[0, -1, 0], [1, 0, 0], [0, 0, 0]]),
    ]
    result = cayley(mids)
    for e, x_k, m_k in zip(generators, u, mids, strict=True):
        slope = (e + e * k + k * e - rest * x_k) * g
        result = result + slope * (x_k - m_k)
    return result


def coordinates(pose: Pose, frame: Frame, chart: int) -> tuple[list[arb], list[arb]] | None:
    """Return (u, p) of a pose in a chart of the model, or None where the chart may not reach it."""
    model_rotation = frame.base * pose.rotation * frame.platform.transpose() * half_turn(chart)
    r = model_rotation
    trace = 1 + r[0, 0] + r[1, 1] + r[2, 2]
    if not trace > 0:
        return None
    u = [(r[2, 1] - r[1, 2]) / trace, (r[0, 2] - r[2, 0]) / trace, (r[1, 0] - r[0, 1]) / trace]
    p = balls.entries(frame.base * (pose.centre - balls.ranges(frame.origin)))
    return u, p


def upward(load: RangeVector) -> arb_mat:
    """Return the unit vector up = -f / |f| of a load f, of ranges for all of them."""
    f = balls.ranges(load)
    return f * (-1 / balls.norm(f))
