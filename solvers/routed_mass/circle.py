"""A point mass that hangs on the cable of one pulley alone: anywhere on a circle about the swivel axis.

The axis is along the load. A pose at which only this cable is taut has its direction along the load: the rope
leaves straight down, at x = arm + radius from the axis, and its length says how far below. So all such poses
are one circle; they are static where every other cable is slack.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat

from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.cables.rows import ARM, AXIS, BEFORE, EXIT, KIND, ONE_JOINT, RADIUS, THETA
from cdpr_interval.robots.numbers import is_exact_point
from solvers.answers.data import Family
from solvers.routed_mass.data import Routed, RoutedMass


@dataclass(frozen=True, eq=False)
class Circle:
    """Where the mass hangs on one cable, in the kernels' units."""

    cable: int
    around: Bounds
    """(3, 2): the whole circle."""
    listed: Bounds
    """(3, 2): the pose at angle 0."""
    family: Family


def circle_of(mass: RoutedMass, data: Routed, cable: int, load: Vector) -> Circle | None:
    """Return the circle of poses on a cable; None where it has none, or another one, or there are ranges."""
    if data[0][cable, KIND, 0] != ONE_JOINT or not _along(mass, cable, load):
        return None
    with balls.precision():
        route = [balls.from_bounds(*row) for row in data[0][cable].tolist()]
        k, exit_point = balls.vector(route[AXIS : AXIS + 3]), balls.vector(route[EXIT : EXIT + 3])
        f = balls.vector([balls.from_bounds(*row) for row in data[4].tolist()])
        length, weight = balls.from_bounds(*data[2][cable].tolist()), balls.norm(f)
        if mass.elastic[cable]:
            length += weight / balls.from_bounds(*data[3][cable].tolist())
        # Down is -k: at psi = 0 the rope runs against the direction in which it arrives.
        if not balls.dot(f, k) < 0:
            return None
        drop = length - route[BEFORE] - route[RADIUS] * route[THETA]
        if not drop > 0:
            return None
        wide = route[ARM] + route[RADIUS]
        centre = exit_point - k * drop
        side = _across(k)
        around = arb(0, 1) * wide
        box = balls.bounds_array(centre + balls.vector([around, around, around]))
        listed = balls.bounds_array(centre + side * wide)
        unit = arb(mass.unit)
        offset = balls.vector([balls.from_bounds(*row) for row in mass.frame[2:5].tolist()])
        whole = [balls.to_bounds(-arb.pi()), balls.to_bounds(arb.pi())]
        family = Family(
            kind="rotation",
            axis_point=balls.bounds_array(exit_point * unit + offset),
            axis_direction=balls.bounds_array(k),
            angle_ranges=np.array([whole]),
        )
    return Circle(cable, box, listed, family)


def _along(mass: RoutedMass, cable: int, load: Vector) -> bool:
    """Return True when the swivel axis is exactly along the load."""
    robot = mass.robot
    pulley = robot.cables[cable].pulley
    axis = robot.gravity if pulley is None or pulley.axis is None else pulley.axis
    if not is_exact_point(axis):
        return False
    x, y, z = axis
    return not any((y * load[2] - z * load[1], z * load[0] - x * load[2], x * load[1] - y * load[0]))  # type: ignore[operator]


def _across(k: arb_mat) -> arb_mat:
    """Enclose a unit vector at right angles to a unit vector."""
    turn = balls.right_handed(k)
    return balls.vector([turn[i, 1] for i in range(3)])
