"""A robot under a load: what follows from its data and a constant force, whatever the lengths.

Views whose names end on `_ranges` are of numbers that may be ranges; so are `middle`, `spread` and
`load_factor`. All others are of exact numbers: of a robot with a range where one looks, it raises
`NotSupportedError`. What treats ranges encloses those, or looks at the views of `middle` and adds `spread`.

Robots under a load are kept, so that what is computed from one (here, and by the classes of robots in caches
keyed by it) is computed once. A robot is recognised as the same object, not by its contents: hashing all its
rationals would cost more than it saves. The cache is bounded, and safe to use from several threads.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache

from cdpr_interval.errors import NotSupportedError
from cdpr_interval.exact.range import Range, RangeVector, as_range, difference
from cdpr_interval.exact.vector import Vector, minus
from cdpr_interval.mechanics.cables.law import CableModel, model_of
from cdpr_interval.mechanics.spread import Spread, spread_of
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import Point, exact, exact_point, is_exact_point, middle_point, range_point

NO_FORCE: Vector = (Fraction(0), Fraction(0), Fraction(0))
MOST_KEPT = 8
"""Robots under a load that are kept: a controller asks about one or a few again and again."""


@dataclass(frozen=True, eq=False)
class LoadedRobot:
    """A robot and the constant force on it. Compared and hashed by identity; made by `loaded`."""

    robot: Robot
    external_force: Point
    """At the centre of mass, base axes, N; added to the weight."""

    @cached_property
    def is_exact(self) -> bool:
        """True when no number of the robot and of the force is a range."""
        return self.robot.is_exact and is_exact_point(self.external_force)

    @cached_property
    def middle(self) -> LoadedRobot:
        """The middle robot under the middle of the force; where all numbers are exact, this one itself."""
        return self if self.is_exact else loaded(self.robot.middle(), middle_point(self.external_force))

    @cached_property
    def spread(self) -> Spread:
        """By how much geometry and load may differ from those of `middle`."""
        return spread_of(self.robot, self.external_force)

    @cached_property
    def load_ranges(self) -> RangeVector:
        """The tightest ranges of the components of f = m g + F, N, base axes."""
        mass = as_range(self.robot.platform.mass)
        x, y, z = (
            mass * as_range(g) + as_range(extra)
            for g, extra in zip(self.robot.gravity, self.external_force, strict=True)
        )
        return x, y, z

    @cached_property
    def load_direction_ranges(self) -> RangeVector:
        """The ranges of f divided by a number in ``load_factor``, N: of a load that is only scaled exact."""
        if self.load_factor.lo != self.spread.load_scale.lo:
            return self.load_ranges
        x, y, z = (
            Range.exact(f).widened(half / self.load_factor.lo)
            for f, half in zip(self.middle.load, self.spread.load, strict=True)
        )
        return x, y, z

    @cached_property
    def load_factor(self) -> Range:
        """What ``load_direction_ranges`` is multiplied by in the loads: positive numbers around 1."""
        scale = self.spread.load_scale
        return scale if scale.lo > 0 else Range.exact(1)

    @cached_property
    def exit_ranges(self) -> tuple[RangeVector, ...]:
        """A_i in the base frame, m, file order."""
        return tuple(range_point(cable.frame_anchor) for cable in self.robot.cables)

    @cached_property
    def anchor_ranges(self) -> tuple[RangeVector, ...]:
        """B_i in the platform frame, m, file order."""
        return tuple(range_point(cable.platform_anchor) for cable in self.robot.cables)

    @cached_property
    def centre_ranges(self) -> RangeVector:
        """The centre of mass G in the platform frame, m."""
        return range_point(self.robot.platform.centre_of_mass)

    @cached_property
    def arm_ranges(self) -> tuple[RangeVector, ...]:
        """B_i - G in the platform frame, m, file order."""
        return tuple(difference(anchor, self.centre_ranges) for anchor in self.anchor_ranges)

    @cached_property
    def gravity_ranges(self) -> RangeVector:
        """The gravitational acceleration g in the base frame, m/s2."""
        return range_point(self.robot.gravity)

    @cached_property
    def gravity(self) -> Vector:
        """The gravitational acceleration g in the base frame, m/s2."""
        return exact_point(self.robot.gravity)

    @cached_property
    def load(self) -> Vector:
        """The force f = m g + F on the platform, N, base axes."""
        mass = exact(self.robot.platform.mass)
        g, extra = self.gravity, exact_point(self.external_force)
        return (mass * g[0] + extra[0], mass * g[1] + extra[1], mass * g[2] + extra[2])

    @cached_property
    def models(self) -> tuple[CableModel, ...]:
        """Route and law of each cable, file order."""
        return tuple(model_of(cable, self.robot.gravity) for cable in self.robot.cables)

    @cached_property
    def exits(self) -> tuple[Vector, ...]:
        """A_i in the base frame, m, file order; `NotSupportedError` where a cable runs over a pulley."""
        exits = [model.route.fixed_exit for model in self.models]
        if None in exits:
            raise NotSupportedError(f"robot '{self.robot.name}': pulleys are not supported here yet")
        return tuple(x for x in exits if x is not None)

    @cached_property
    def centre(self) -> Vector:
        """The centre of mass G in the platform frame, m."""
        return exact_point(self.robot.platform.centre_of_mass)

    @cached_property
    def anchors(self) -> tuple[Vector, ...]:
        """B_i in the platform frame, m, file order."""
        return tuple(exact_point(cable.platform_anchor) for cable in self.robot.cables)

    @cached_property
    def arms(self) -> tuple[Vector, ...]:
        """B_i - G in the platform frame, m, file order."""
        return tuple(minus(anchor, self.centre) for anchor in self.anchors)


class _Same:
    """A robot as the key of a cache: equal only to itself. Holds it, so that its identity stays its own."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot

    def __hash__(self) -> int:
        return id(self.robot)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and self.robot is other.robot


def loaded(robot: Robot, external_force: Point = NO_FORCE) -> LoadedRobot:
    """Return a robot under its weight and a constant force (N, base axes), kept from an earlier call."""
    return _loaded(_Same(robot), external_force)


@lru_cache(maxsize=MOST_KEPT)
def _loaded(robot: _Same, external_force: Point) -> LoadedRobot:
    return LoadedRobot(robot.robot, external_force)
