"""A point mass with routed cables as the arrays of the compiled kernels, ranges of data included.

Positions are relative to the first cable's A, lengths and forces in units that are powers of two near the
robot's own size, as in `solvers.point_mass.arrays`.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact.enclosure import Bounds, enclose
from cdpr_interval.exact.range import Range, as_range
from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.cables.route_rows import route_rows
from cdpr_interval.mechanics.loaded import MOST_KEPT, LoadedRobot
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import exact_point, middle_point
from solvers.point_mass.arrays import force_unit_of, frame_rows, power_of_two

Routed = tuple[Bounds, NDArray[np.bool_], Bounds, Bounds, Bounds]
"""``(routes, elastic, lengths, k, load)``: what the kernels know, (lo, hi) on the last axis. (N, ROUTE, 2)
routes; (N,) flags; (N, 2) unstretched lengths and spring constants (of inextensible cables zero); (3, 2)
load."""


@dataclass(frozen=True, eq=False)
class RoutedMass:
    """The part of the arrays that depends on the robot and the load only."""

    robot: Robot
    routes: Bounds
    elastic: NDArray[np.bool_]
    constant: NDArray[np.bool_]
    """(N,) True where the spring constant is given, False where EA is."""
    given: Bounds
    """(N, 2) spring constant or EA, in the kernels' units."""
    load: Bounds
    """(3, 2) in units of force."""
    frame: Bounds
    """(9, 2), see `solvers.point_mass.fields.report`."""

    load_exact: Vector
    """N, of the middle robot."""
    exact: bool
    """No number is a range."""

    @property
    def unit(self) -> float:
        """Of length, m."""
        return float(self.frame[0, 0])


@lru_cache(maxsize=MOST_KEPT)
def routed_mass(loaded: LoadedRobot) -> RoutedMass:
    """Return the arrays of a robot under a load that is not zero, kept from an earlier call.

    Raises
    ------
    NotSupportedError
        Gravity is a range.
    """
    robot = loaded.robot
    origin = middle_point(robot.cables[0].frame_anchor)
    middles = [middle_point(cable.frame_anchor) for cable in robot.cables]
    apart = [abs(x - o) for point in middles for x, o in zip(point, origin, strict=True)]
    size = max(apart)
    if not size:
        # One exit point: what is known of the robot's size is its pulleys.
        size = max(
            (
                as_range(c.pulley.arm_length).hi + as_range(c.pulley.lead_in).hi
                for c in robot.cables
                if c.pulley
            ),
            default=Fraction(1),
        )
    unit = power_of_two(size)
    force_unit = force_unit_of(loaded.middle.load)
    scale = Range.exact(Fraction(force_unit))
    return RoutedMass(
        robot,
        route_rows(robot, origin, Fraction(unit)),
        np.array([cable.elasticity is not None for cable in robot.cables]),
        np.array([c.elasticity is not None and c.elasticity.stiffness is not None for c in robot.cables]),
        _given(robot, Fraction(unit), Fraction(force_unit)),
        np.array([_bounds(f / scale) for f in loaded.load_ranges]),
        frame_rows(
            origin, exact_point(robot.platform.centre_of_mass), exact_point(robot.gravity), unit, force_unit
        ),
        loaded.middle.load,
        loaded.is_exact,
    )


def _bounds(x: Range) -> tuple[float, float]:
    return enclose(x.lo)[0], enclose(x.hi)[1]


def _given(robot: Robot, unit: Fraction, force_unit: Fraction) -> Bounds:
    rows = []
    for cable in robot.cables:
        if cable.elasticity is None:
            rows.append((0.0, 0.0))
        elif cable.elasticity.stiffness is not None:
            rows.append(_bounds(as_range(cable.elasticity.stiffness) * Range.exact(unit / force_unit)))
        else:
            assert cable.elasticity.axial_stiffness is not None
            rows.append(_bounds(as_range(cable.elasticity.axial_stiffness) * Range.exact(1 / force_unit)))
    return np.array(rows)
