"""A point-mass robot and its lengths as the arrays of the compiled kernels.

Exact rationals enter as the tightest doubles around them. Positions are relative to the first exit
point (subtracted exactly), lengths and forces in units that are powers of two near the robot's own size,
so that huge and tiny robots meet the same numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.errors import InputError, NotSupportedError
from cdpr_interval.kernels.enclosure import enclose
from cdpr_interval.robots.model import Robot, Vector
from solvers.problem import LengthRange, Problem
from solvers.result import Bounds

NO_LOAD = "load: the weight and the external force cancel; without a load the pose is not determined"


Cables = tuple[NDArray[np.bool_], Bounds, Bounds, Bounds, Bounds]
"""``(elastic, anchors, lengths, k, w)``: what the kernels know of the cables, (lo, hi) on the last axis. (N,)
flags; (N, 3, 2) exit points relative to A_0; (N, 2) lengths, spring constants k and products w = k l."""


@dataclass(frozen=True, eq=False)
class RobotArrays:
    """The part of the arrays that depends on the robot and the load only."""

    robot: Robot
    load_exact: Vector
    """f in N."""
    elastic: NDArray[np.bool_]
    constant: NDArray[np.bool_]
    """(N,) True where the spring constant is given, False where EA is."""
    anchors: Bounds
    given: Bounds
    """(N, 2) spring constant or EA, in the kernels' units."""
    load: Bounds
    """(3, 2) f in units of force."""
    frame: Bounds
    """(9, 2), see `solvers.point_mass_fields.report`."""


def power_of_two(size: Fraction | float) -> float:
    """Return a power of two near a positive number, within the range where squares do not overflow."""
    if size <= 0:
        return 1.0
    if isinstance(size, Fraction):
        exponent = size.numerator.bit_length() - size.denominator.bit_length()
    else:
        exponent = math.frexp(size)[1]
    return math.ldexp(1.0, max(-400, min(400, exponent)))


def _bounds(numbers: Iterable[Fraction]) -> Bounds:
    return np.array([enclose(x) for x in numbers], dtype=np.float64)


def _root(x: Fraction) -> tuple[Fraction, Fraction]:
    """Enclose the square root of a positive rational to about 80 bits."""
    shift = max(0, 160 - x.numerator.bit_length() + x.denominator.bit_length())
    shift += shift % 2
    scaled = (x.numerator << shift) // x.denominator
    low = math.isqrt(scaled)
    unit = Fraction(1, 1 << (shift // 2))
    return low * unit, (low + 1) * unit


def up_direction(gravity: Vector) -> tuple[tuple[Fraction, Fraction], ...]:
    """Enclose the unit vector against gravity, exact ranges."""
    lo, hi = _root(sum((g * g for g in gravity), Fraction(0)))
    return tuple((min(-g / lo, -g / hi), max(-g / lo, -g / hi)) for g in gravity)


def _frame(robot: Robot, unit: float, force_unit: float) -> Bounds:
    origin, centre = robot.cables[0].frame_anchor, robot.platform.centre_of_mass
    up = up_direction(robot.gravity)
    height_lo = sum((min(u[0] * a, u[1] * a) for u, a in zip(up, origin, strict=True)), Fraction(0))
    height_hi = sum((max(u[0] * a, u[1] * a) for u, a in zip(up, origin, strict=True)), Fraction(0))
    rows = [(unit, unit), (force_unit, force_unit)]
    rows += [enclose(a - c) for a, c in zip(origin, centre, strict=True)]
    rows += [(enclose(lo)[0], enclose(hi)[1]) for lo, hi in (*up, (height_lo, height_hi))]
    return np.array(rows, dtype=np.float64)


def _robot_arrays(robot: Robot, load: Vector) -> RobotArrays:
    if not any(load):
        raise InputError(NO_LOAD)
    if robot.is_mixed:
        raise NotSupportedError("elastic and inextensible cables in one robot are not supported yet")
    origin = robot.cables[0].frame_anchor
    relative = [
        tuple(a - o for a, o in zip(cable.frame_anchor, origin, strict=True)) for cable in robot.cables
    ]
    span = max((abs(x) for anchor in relative for x in anchor), default=Fraction(0))
    unit = power_of_two(span)
    force_unit = power_of_two(max(abs(x) for x in load))
    exact_unit, exact_force = Fraction(unit), Fraction(force_unit)
    given = []
    for cable in robot.cables:
        if cable.elasticity is None:
            given.append(Fraction(0))
        elif cable.elasticity.stiffness is not None:
            given.append(cable.elasticity.stiffness * exact_unit / exact_force)
        else:
            assert cable.elasticity.axial_stiffness is not None
            given.append(cable.elasticity.axial_stiffness / exact_force)
    return RobotArrays(
        robot=robot,
        load_exact=load,
        elastic=np.array([cable.elasticity is not None for cable in robot.cables]),
        constant=np.array(
            [c.elasticity is not None and c.elasticity.stiffness is not None for c in robot.cables]
        ),
        anchors=_bounds(x / exact_unit for anchor in relative for x in anchor).reshape(-1, 3, 2),
        given=_bounds(given),
        load=_bounds(x / exact_force for x in load),
        frame=_frame(robot, unit, force_unit),
    )


_latest: list[tuple[Robot, Vector, RobotArrays]] = []
"""The arrays of the robot asked about last: a controller asks about one robot again and again."""


def robot_arrays(problem: Problem) -> RobotArrays:
    """Return the arrays of a problem's robot and load, kept from the last call where they are the same.

    Raises
    ------
    InputError
        The load is zero.
    NotSupportedError
        Some cables stretch and others do not.
    """
    robot, force = problem.robot, problem.external_force
    for known, known_force, arrays in _latest:
        if known is robot and (known_force is force or known_force == force):
            return arrays
    arrays = _robot_arrays(robot, problem.load)
    _latest[:] = [(robot, force, arrays)]
    return arrays


def length_bounds(lengths: Iterable[LengthRange]) -> Bounds:
    """Return the tightest doubles around exact ranges, (N, 2)."""
    rows = []
    for lo, hi in lengths:
        below = enclose(lo)
        rows.append(below if lo is hi else (below[0], enclose(hi)[1]))
    return np.array(rows, dtype=np.float64)


def select(cables: Cables, chosen: Sequence[int]) -> Cables:
    """Return the arrays of some of the cables."""
    index = np.array(chosen, dtype=np.int64)
    elastic, anchors, lengths, stiffness, axial = cables
    return elastic[index], anchors[index], lengths[index], stiffness[index], axial[index]
