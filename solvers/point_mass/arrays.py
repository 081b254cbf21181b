"""A point-mass robot and its lengths as the arrays of the compiled kernels.

Exact rationals enter as the tightest doubles around them. Positions are relative to the first exit
point (subtracted exactly), lengths and forces in units that are powers of two near the robot's own size,
so that huge and tiny robots meet the same numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.errors import InputError, NotSupportedError
from cdpr_interval.exact.enclosure import Bounds, enclose
from cdpr_interval.exact.irrational import root_bounds
from cdpr_interval.exact.range import LengthRange
from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.loaded import MOST_KEPT, LoadedRobot
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import exact, exact_point
from solvers.questions.problem import Problem

NO_LOAD = "load: the weight and the external force cancel; without a load the pose is not determined"


Cables = tuple[NDArray[np.bool_], Bounds, Bounds, Bounds, Bounds]
"""``(elastic, exits, lengths, k, w)``: what the kernels know of the cables, (lo, hi) on the last axis. (N,)
flags; (N, 3, 2) exit points relative to A_0; (N, 2) lengths, spring constants k and products w = k l."""


@dataclass(frozen=True, eq=False)
class RobotArrays:
    """The part of the arrays that depends on the robot and the load only."""

    robot: Robot
    load_exact: Vector
    """f in N."""
    origin: Vector
    """A_0 in m, from which the kernels measure; also of a robot that is some of the cables of another."""
    elastic: NDArray[np.bool_]
    constant: NDArray[np.bool_]
    """(N,) True where the spring constant is given, False where EA is."""
    exit_bounds: Bounds
    given: Bounds
    """(N, 2) spring constant or EA, in the kernels' units."""
    load: Bounds
    """(3, 2) f in units of force."""
    frame: Bounds
    """(9, 2), see `solvers.point_mass.fields.report`."""

    @property
    def is_elastic(self) -> bool:
        """True when the cables stretch; they do all or none."""
        return self.robot.cables[0].elasticity is not None

    @cached_property
    def exits(self) -> tuple[Vector, ...]:
        """A_i in m."""
        return tuple(exact_point(cable.frame_anchor) for cable in self.robot.cables)

    @cached_property
    def centre(self) -> Vector:
        """The centre of mass, and with it all anchors, in the platform frame, m."""
        return exact_point(self.robot.platform.centre_of_mass)


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


@lru_cache(maxsize=MOST_KEPT)
def up_direction(gravity: Vector) -> tuple[tuple[Fraction, Fraction], ...]:
    """Enclose the unit vector against gravity, exact ranges."""
    lo, hi = root_bounds(sum((g * g for g in gravity), Fraction(0)))
    return tuple((min(-g / lo, -g / hi), max(-g / lo, -g / hi)) for g in gravity)


@lru_cache(maxsize=MOST_KEPT)
def frame_rows(origin: Vector, centre: Vector, gravity: Vector, unit: float, force_unit: float) -> Bounds:
    """Return the rows (9, 2) of `solvers.point_mass.fields.report`."""
    up = up_direction(gravity)
    height_lo = sum((min(u[0] * a, u[1] * a) for u, a in zip(up, origin, strict=True)), Fraction(0))
    height_hi = sum((max(u[0] * a, u[1] * a) for u, a in zip(up, origin, strict=True)), Fraction(0))
    rows = [(unit, unit), (force_unit, force_unit)]
    rows += [enclose(a - c) for a, c in zip(origin, centre, strict=True)]
    rows += [(enclose(lo)[0], enclose(hi)[1]) for lo, hi in (*up, (height_lo, height_hi))]
    return np.array(rows, dtype=np.float64)


def build_arrays(robot: Robot, load: Vector) -> RobotArrays:
    """Return the arrays of a robot under the force ``load`` (N, base axes).

    Raises
    ------
    InputError
        The load is zero.
    NotSupportedError
        Some cables stretch and others do not, or a number is a range.
    """
    if not any(load):
        raise InputError(NO_LOAD)
    if robot.is_mixed:
        raise NotSupportedError("elastic and inextensible cables in one robot are not supported yet")
    exits = tuple(exact_point(cable.frame_anchor) for cable in robot.cables)
    origin = exits[0]
    unit, exit_bounds = _exit_bounds(exits)
    force_unit = force_unit_of(load)
    return RobotArrays(
        robot=robot,
        load_exact=load,
        origin=origin,
        elastic=np.array([cable.elasticity is not None for cable in robot.cables]),
        constant=np.array(
            [c.elasticity is not None and c.elasticity.stiffness is not None for c in robot.cables]
        ),
        exit_bounds=exit_bounds,
        given=_given(robot, Fraction(unit), Fraction(force_unit)),
        load=load_bounds(load, force_unit),
        frame=frame_rows(
            origin,
            exact_point(robot.platform.centre_of_mass),
            exact_point(robot.gravity),
            unit,
            force_unit,
        ),
    )


@lru_cache(maxsize=MOST_KEPT)
def _exit_bounds(exits: tuple[Vector, ...]) -> tuple[float, Bounds]:
    """Return the unit of length, and the exit points (N, 3, 2) in it relative to the first.

    Kept, like all of a robot that does not depend on its springs: a batch asks for thousands of robots that
    differ in nothing else.
    """
    relative = [x - o for exit_point in exits for x, o in zip(exit_point, exits[0], strict=True)]
    unit = power_of_two(max(abs(x) for x in relative))
    scale = Fraction(unit)
    return unit, _bounds(x / scale for x in relative).reshape(-1, 3, 2)


@lru_cache(maxsize=MOST_KEPT)
def force_unit_of(load: Vector) -> float:
    """Return the unit of force, N, for a load (N)."""
    return power_of_two(max(abs(x) for x in load))


@lru_cache(maxsize=MOST_KEPT)
def load_bounds(load: Vector, force_unit: float) -> Bounds:
    """Enclose a load (N) in units of force, (3, 2)."""
    unit = Fraction(force_unit)
    return _bounds(x / unit for x in load)


def _given(robot: Robot, unit: Fraction, force_unit: Fraction) -> Bounds:
    """Enclose spring constants or EA (N, 2) in the kernels' units; zero where a cable does not stretch."""
    given = []
    for cable in robot.cables:
        if cable.elasticity is None:
            given.append(Fraction(0))
        elif cable.elasticity.stiffness is not None:
            given.append(exact(cable.elasticity.stiffness) * unit / force_unit)
        else:
            assert cable.elasticity.axial_stiffness is not None
            given.append(exact(cable.elasticity.axial_stiffness) / force_unit)
    return _bounds(given)


def with_load(arrays: RobotArrays, load: Vector) -> RobotArrays:
    """Return the arrays of the same robot under another force, equal to those `build_arrays` returns.

    Raises
    ------
    InputError
        The load is zero.
    """
    if not any(load):
        raise InputError(NO_LOAD)
    unit, force_unit = float(arrays.frame[0, 0]), force_unit_of(load)
    bounds = load_bounds(load, force_unit)
    if force_unit == arrays.frame[1, 0]:
        return replace(arrays, load_exact=load, load=bounds)
    frame = arrays.frame.copy()
    frame[1] = force_unit
    given = _given(arrays.robot, Fraction(unit), Fraction(force_unit))
    return replace(arrays, load_exact=load, load=bounds, given=given, frame=frame)


@lru_cache(maxsize=MOST_KEPT)
def robot_arrays(loaded: LoadedRobot) -> RobotArrays:
    """Return the arrays of a robot under a load, kept from an earlier call.

    Raises
    ------
    InputError
        The load is zero.
    NotSupportedError
        Some cables stretch and others do not, or a number is a range.
    """
    return build_arrays(loaded.robot, loaded.load)


def ranged(lengths: Bounds) -> NDArray[np.bool_]:
    """Return which lengths (N, 2) are more uncertain than a decimal read as a double."""
    return np.asarray(lengths[:, 1] - lengths[:, 0] > 1e-14 * lengths[:, 1])


def is_range(lengths: Bounds) -> bool:
    """Return True when some length (N, 2) is more uncertain than a decimal read as a double."""
    return bool(ranged(lengths).any())


def exact_lengths(problem: Problem, chosen: Sequence[int] | None = None) -> list[Fraction] | None:
    """Return the lengths in m of some cables (default: all) exactly; None where one of them is a range."""
    return exact_ends(problem.lengths if chosen is None else [problem.lengths[i] for i in chosen])


def exact_ends(ranges: Sequence[LengthRange]) -> list[Fraction] | None:
    """Return lengths in m that are no ranges; None where one of them is."""
    return [lo for lo, _ in ranges] if all(lo == hi for lo, hi in ranges) else None


def select(cables: Cables, chosen: Sequence[int]) -> Cables:
    """Return the arrays of some of the cables."""
    index = np.array(chosen, dtype=np.int64)
    elastic, exits, lengths, stiffness, axial = cables
    return elastic[index], exits[index], lengths[index], stiffness[index], axial[index]
