"""By how much the data of a loaded robot may differ from those of its middle, in exact numbers."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from cdpr_interval.exact.range import Range
from cdpr_interval.exact.vector import Vector, along, dot, is_zero
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import Point, Scalar, middle, middle_point

ONE = Range.exact(1)


@dataclass(frozen=True)
class Spread:
    """Half widths of the ranges of geometry and load around their middles; stiffness is not among them.

    Guarantee
    ---------
    For every choice of the ranges each coordinate of A_i, B_i and G differs from that of the middle robot by
    at most its half width, and the load is f = scale * f_mid + rest, f_mid being the middle robot's load,
    scale a number in ``load_scale`` and rest a vector within +- ``load``.
    """

    exits: tuple[Vector, ...]
    """Of A_i, m, file order."""
    anchors: tuple[Vector, ...]
    """Of B_i, platform frame, m, file order."""
    centre: Vector
    """Of the centre of mass G, platform frame, m."""
    load: Vector
    """Of what the scaled middle load leaves, N, base axes."""
    load_scale: Range
    """Around 1: a mass with a range, and nothing else, scales the load."""

    @property
    def is_zero(self) -> bool:
        """True when geometry and load are exact."""
        return self.points_are_exact and self.load_is_exact

    @property
    def points_are_exact(self) -> bool:
        """True when exit points, anchors and centre of mass are exact."""
        return all(map(is_zero, (*self.exits, *self.anchors, self.centre)))

    @property
    def load_is_exact(self) -> bool:
        """True when the load is."""
        return is_zero(self.load) and self.load_scale == ONE


def spread_of(robot: Robot, external_force: Point) -> Spread:
    """Return the spread of a robot under a force (N, base axes)."""
    load, scale = _load_spread(robot, external_force)
    return Spread(
        exits=tuple(half_widths(cable.frame_anchor) for cable in robot.cables),
        anchors=tuple(half_widths(cable.platform_anchor) for cable in robot.cables),
        centre=half_widths(robot.platform.centre_of_mass),
        load=load,
        load_scale=scale,
    )


def half_widths(point: Point) -> Vector:
    """Return the half width of the range of each coordinate, zero where it is exact."""
    x, y, z = map(_half_width, point)
    return x, y, z


def _half_width(value: Scalar) -> Fraction:
    return value.width / 2 if isinstance(value, Range) else Fraction(0)


def _load_spread(robot: Robot, external_force: Point) -> tuple[Vector, Range]:
    """Return ``load`` and ``load_scale`` of a `Spread`.

    With f_mid = m0 g0 + F0 and g0 = a f_mid + h, h orthogonal to f_mid:

        f = m g + F = (1 + (m - m0) a) f_mid + (m - m0) h + m (g - g0) + (F - F0).
    """
    mass, g0, f0 = robot.platform.mass, middle_point(robot.gravity), middle_point(external_force)
    middle_load = along(f0, middle(mass), g0)
    size = dot(middle_load, middle_load)
    a = dot(g0, middle_load) / size if size else Fraction(0)
    across = along(g0, -a, middle_load)
    doubt = _half_width(mass)
    heaviest = middle(mass) + doubt
    x, y, z = (
        doubt * abs(h) + heaviest * dg + df
        for h, dg, df in zip(across, half_widths(robot.gravity), half_widths(external_force), strict=True)
    )
    return (x, y, z), ONE.widened(doubt * abs(a))
