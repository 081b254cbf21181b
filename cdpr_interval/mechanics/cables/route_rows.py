"""The routes of a robot's cables as the rows that compiled kernels take, ranges of data included."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.exact.range import Range, as_range, difference
from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.cables.rows import (
    ARM,
    AXIS,
    BALANCED,
    BEFORE,
    BISECTED,
    EXIT,
    FIXED,
    KIND,
    LEAD_IN,
    ONE_JOINT,
    RADIUS,
    ROUTE,
    SNUG,
    THETA,
)
from cdpr_interval.robots.cable_robot import Cable, Robot
from cdpr_interval.robots.numbers import range_point
from cdpr_interval.robots.pulley import BISECTOR, Pulley

Floats = NDArray[np.float64]


def route_rows(robot: Robot, origin: Vector, unit: Fraction) -> Floats:
    """Return the routes (N, ROUTE, 2) of all cables, file order.

    Parameters
    ----------
    robot : Robot
    origin : Vector
        Base frame, m: points are measured from here.
    unit : Fraction
        m: a power of two, the unit of length.

    Guarantee
    ---------
    The rows enclose the data for every choice of numbers in their ranges.
    """
    with balls.precision():
        return np.array([_row(cable, robot, origin, unit) for cable in robot.cables])


def _row(cable: Cable, robot: Robot, origin: Vector, unit: Fraction) -> Floats:
    row = np.zeros((ROUTE, 2))
    start = tuple(Range.exact(x) for x in origin)
    for j, x in enumerate(difference(range_point(cable.frame_anchor), (start[0], start[1], start[2]))):
        row[EXIT + j] = _bounds(balls.from_range(x / Range.exact(unit)))
    row[KIND] = FIXED
    pulley = cable.pulley
    if pulley is None:
        return row
    row[AXIS : AXIS + 3] = balls.bounds_array(_axis(pulley, robot))
    lead_in = balls.from_range(as_range(pulley.lead_in) / Range.exact(unit))
    row[BEFORE] = row[LEAD_IN] = _bounds(lead_in)
    if pulley.is_plain:
        return row
    row[KIND] = ONE_JOINT if pulley.joints == 1 else BISECTED if pulley.balance == BISECTOR else BALANCED
    radius = balls.from_range(as_range(pulley.radius) / Range.exact(unit))
    arm = balls.from_range(as_range(pulley.arm_length) / Range.exact(unit))
    row[RADIUS], row[ARM] = _bounds(radius), _bounds(arm)
    # A range of both is that of one number only where no arm is given.
    snug = pulley.arm is None or (pulley.arm == pulley.radius and not isinstance(pulley.arm, Range))
    row[SNUG] = float(snug)
    if pulley.joints == 1:
        before, theta = (lead_in, arb.pi()) if snug else _arrival(radius, arm, lead_in)
        row[BEFORE], row[THETA] = _bounds(before), _bounds(theta)
    return row


def _axis(pulley: Pulley, robot: Robot) -> arb_mat:
    """Enclose the unit vector in which the rope arrives."""
    if pulley.axis is not None:
        axis = balls.ranges(range_point(pulley.axis))
    else:
        axis = -balls.ranges(range_point(robot.gravity))
    return axis * (1 / balls.norm(axis))


def _arrival(radius: arb, arm: arb, lead_in: arb) -> tuple[arb, arb]:
    """Enclose |CK| and the angle of K for one joint."""
    square = arm * arm + lead_in * lead_in
    before = (square - radius * radius).nonnegative_part().sqrt()
    theta = arb.pi() + (lead_in / arm).atan() - (before / radius).atan()
    return before, theta


def _bounds(x: arb) -> Any:
    return balls.to_bounds(x)
