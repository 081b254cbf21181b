"""A solver prepared for one point-mass robot of either class, straight or routed, for controllers."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.errors import InputError
from cdpr_interval.exact.enclosure import Bounds, length_bounds
from cdpr_interval.mechanics.loaded import NO_FORCE, loaded
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.given import require_robot
from cdpr_interval.robots.numbers import Point
from solvers.point_mass.controller import PointMassPose, PoseStatus, StraightPointMass, pose_of
from solvers.point_mass.fields import OPEN
from solvers.point_mass.one_call import DECIDED
from solvers.point_mass.scope import accepts, is_routed, refuses
from solvers.questions.checked import require_treated
from solvers.questions.errors import InputErrors
from solvers.questions.force import NO_LOAD, ZERO, no_load, read_force_ranges
from solvers.questions.lengths import read_lengths
from solvers.questions.quick import quick_bounds
from solvers.routed_mass.data import RoutedMass, routed_mass
from solvers.routed_mass.forward import NO_POSE
from solvers.routed_mass.over_ranges import find_all
from solvers.routed_mass.pose import Effort
from solvers.routed_mass.pose import quick_pose as routed_pose

ON_CIRCLE = "the mass hangs on one pulley's cable alone, anywhere on a circle"
UNFINISHED = "the search for further poses took more cells than a call may"


class PointMass(StraightPointMass):
    """The forward kinematics of one point-mass robot, prepared for many calls.

    Parameters
    ----------
    robot : Robot
        All platform anchors at the centre of mass; cables of any kind. Its numbers are enclosed here, once.

    Raises
    ------
    InputError
        The robot is no point mass.
    NotSupportedError
        No solver of this version can treat it.

    Notes
    -----
    Instances may be shared by threads: a call allocates what it needs, about 3 kB for eight cables.
    The compiled path releases Python's lock.

    Examples
    --------
    >>> from cdpr_interval import load_robot
    >>> solver = PointMass(load_robot("merlet_4_1"))
    >>> pose = solver.solve([3.1, 3.2, 3.3, 3.4])
    >>> pose.proved, pose.taut
    (True, (0, 1, 2))
    """

    __slots__ = ("_routed", "_weightless")

    def __init__(self, robot: Robot | str | os.PathLike[str]) -> None:
        robot = require_robot(robot)
        self._routed = accepts(robot) and is_routed(robot)
        if not self._routed:
            super().__init__(robot)
            return
        require_treated(robot, refuses(robot))
        self._robot = robot
        self._weightless = not any(loaded(robot.middle()).load)

    def warm_up(self) -> None:
        """Compile or load the kernels now, so that no later call waits for them.

        Without it the first calls take tenths of a second to load kernels, and a minute where they were
        never compiled on this machine. The constructor compiles nothing.
        """
        if not self._routed:
            super().warm_up()
            return
        force: Point = (Fraction(0), Fraction(0), Fraction(-1)) if self._weightless else NO_FORCE
        mass = routed_mass(loaded(self._robot, force))
        for reach in (16.0, 1e-3):
            # Hanging far below, and too short to hang at all.
            routed_answer(mass, np.full((len(self._robot.cables), 2), reach * mass.unit))

    def solve(
        self, lengths: str | Sequence[Any] | Mapping[str, Any], external_force: Sequence[Any] | None = None
    ) -> PointMassPose:
        """Find the static pose for given cable lengths and prove that it is the only one.

        Parameters
        ----------
        lengths : sequence, mapping or str
            As in `forward_kinematics`: one length per cable in m, unstretched for elastic cables. A float
            is that exact double, a pair (lo, hi) a range. Sequences of floats or of pairs of floats, and
            float64 arrays (N,) or (N, 2), are the quick way.
        external_force : sequence of 3 numbers, optional
            Constant force at the centre of mass in N, base axes, added to the weight. What it changes is
            computed when it differs from the force of the call before.

        Returns
        -------
        PointMassPose
            A proof that fails is its status, never an exception.

        Raises
        ------
        InputError
            One message per entry that is wrong: number of lengths, not a number, not finite, not
            positive, a range upside down; or weight and external force cancel.

        Guarantee
        ---------
        That of `PointMassPose`. For the same numbers the bounds are those of the solution that
        `forward_kinematics` returns; where it reports no pose or an undecided region, so does this. Over
        ranges that one takes the time for sharper bounds, which lie within these.

        Notes
        -----
        Straight cables of one kind: some ten microseconds where every cable is clearly taut or slack. Over
        pulleys, or with cables of two kinds: a tenth of a millisecond. Elsewhere milliseconds, next to a
        pulley seconds.
        """
        if not self._routed:
            return super().solve(lengths, external_force)
        force: Point = NO_FORCE
        bounds = quick_bounds(lengths, len(self._robot.cables))
        if bounds is None or external_force is not None:
            errors = InputErrors()
            ranges = errors.read(read_lengths, lengths, self._robot.cable_names)
            if external_force is not None:
                force = errors.read(read_force_ranges, external_force) or ZERO
            if (complaint := no_load(loaded(self._robot, force))) is not None:
                errors.add(complaint)
            errors.require_none()
            assert ranges is not None
            bounds = length_bounds(ranges)
        elif self._weightless:
            raise InputError(NO_LOAD)
        return routed_answer(routed_mass(loaded(self._robot, force)), bounds)


def routed_answer(mass: RoutedMass, lengths: Bounds) -> PointMassPose:
    """Return the pose of a point mass on routed cables for lengths (N, 2) in m."""
    status, bounds, states = routed_pose(mass, lengths)
    if status == DECIDED and not (states == OPEN).any():
        return PointMassPose(PoseStatus.PROVED, bounds, states)
    found = find_all(mass, lengths, Effort.of(None, None))
    names = mass.robot.cable_names
    if found.complete and len(found.poses) == 1 and not found.families:
        return pose_of(found.poses[0], names)
    if found.complete and not found.poses:
        return PointMassPose(PoseStatus.NO_POSE, *_nothing(len(names), np.nan), NO_POSE)
    several = ON_CIRCLE if found.families else f"{len(found.poses)} static poses are proved"
    reason = several if found.complete else found.regions[0].reason if found.regions else UNFINISHED
    return PointMassPose(PoseStatus.UNPROVED, *_nothing(len(names), np.inf), reason)


def _nothing(count: int, far: float) -> tuple[Bounds, NDArray[np.int64]]:
    """Return bounds (4 + 2 N, 2) that say nothing, and undecided states."""
    bounds = np.empty((4 + 2 * count, 2))
    bounds[:4] = -far, far
    bounds[4:] = far * 0.0 if math.isnan(far) else 0.0, far
    return bounds, np.full(count, OPEN, dtype=np.int64)
