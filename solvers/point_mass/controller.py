"""A solver prepared for one point-mass robot: calls of some ten microseconds, for controllers.

`forward_kinematics` reads, checks and reports everything anew in each call. Here the robot's data are
enclosed once, a call with plain floats goes straight to one compiled kernel, and the answer is one light
object. The kernels and the fallbacks are those of `forward_kinematics`, so the answers are the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from cdpr_interval.errors import InputError
from cdpr_interval.robots.cable_robot import Robot
from solvers.answers.result import Bounds
from solvers.forward import refuse_unsupported
from solvers.point_mass.arrays import RobotArrays, build_arrays, exact_ends, with_load
from solvers.point_mass.convex import NoPose, after_quick, quick_pose, settle
from solvers.point_mass.entry import Fields
from solvers.point_mass.fields import OPEN
from solvers.point_mass.one_call import DECIDED
from solvers.point_mass.pose import PointMassPose, PoseStatus
from solvers.questions.force import NO_LOAD, ZERO, read_force
from solvers.questions.lengths import read_lengths
from solvers.questions.problem import Problem
from solvers.questions.quick import checked, force_key, quick_bounds


class PointMass:
    """The forward kinematics of one point-mass robot, prepared for many calls.

    Parameters
    ----------
    robot : Robot
        All platform anchors at the centre of mass; all cables elastic or none. Its numbers are enclosed
        here, once.

    Raises
    ------
    InputError
        The robot is no point mass.
    NotSupportedError
        Uncertain scalars, or elastic and inextensible cables in one robot.

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

    __slots__ = ("_arrays", "_forced", "_robot")

    def __init__(self, robot: Robot) -> None:
        if not robot.is_point_mass:
            raise InputError(f"robot '{robot.name}': must be a point mass, this is a platform")
        refuse_unsupported(robot)
        self._robot = robot
        weight = Problem(robot, ()).load
        self._arrays = build_arrays(robot, weight) if any(weight) else None
        self._forced: tuple[tuple[float, ...], RobotArrays] | None = None

    @property
    def robot(self) -> Robot:
        """The robot this solver was prepared for."""
        return self._robot

    def warm_up(self) -> None:
        """Compile or load the kernels now, so that no later call waits for them.

        Without it the first call, and the first with a cable just taut or slack, take a tenth of a second
        each to load kernels, and many seconds where they were never compiled on this machine. Only the
        kernels for wide ranges of elastic cables are left out.
        """
        arrays = self._arrays
        if arrays is None:
            arrays = build_arrays(self._robot, (Fraction(0), Fraction(0), Fraction(-1)))
        # Cables that long reach each other's exit points: everything below is asked of a common point.
        reach = 16.0 * float(arrays.frame[0, 0])
        lengths = np.full((len(self._robot.cables), 2), reach)
        quick_pose(arrays, lengths)
        settle(arrays, lengths)

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
        That of `PointMassPose`. For the same numbers the bounds are bit for bit those of the solution
        that `forward_kinematics` returns; where it reports no pose or an undecided region, so does this.

        Notes
        -----
        Some ten microseconds where every cable is clearly taut or slack. Where a cable is only just taut
        or slack, without a common point of the cables, and for wide ranges, exact arithmetic follows:
        milliseconds, for wide ranges of elastic cables tenths of a second.
        """
        bounds = quick_bounds(lengths, len(self._robot.cables))
        quick = bounds is not None
        if bounds is None or external_force is not None or self._arrays is None:
            names = self._robot.cable_names
            bounds, arrays = checked(lengths, bounds, names, self._under, external_force)
        else:
            arrays = self._arrays
        status, found, states = quick_pose(arrays, bounds)
        if status == DECIDED:
            return PointMassPose(PoseStatus.PROVED, found, states)
        given = None if quick else exact_ends(read_lengths(lengths, self._robot.cable_names))
        return _settled(arrays, bounds, given)

    def _under(self, external_force: Any) -> RobotArrays:
        """Return the arrays under the weight and a force; the last ones are kept."""
        key = force_key(external_force)
        kept = self._forced
        if key is not None and kept is not None and kept[0] == key:
            return kept[1]
        force = ZERO if external_force is None else read_force(external_force)
        load = Problem(self._robot, (), force).load
        if not any(load):
            raise InputError(NO_LOAD)
        arrays = build_arrays(self._robot, load) if self._arrays is None else with_load(self._arrays, load)
        if key is not None:
            self._forced = key, arrays
        return arrays


def _settled(arrays: RobotArrays, lengths: Bounds, exact: list[Fraction] | None) -> PointMassPose:
    """Return the answer where the compiled path has decided nothing."""
    count = len(lengths)
    finding = after_quick(arrays, lengths, exact)
    if isinstance(finding, Fields):
        parts = (finding.position, finding.height[None], finding.tensions, finding.distances)
        return PointMassPose(PoseStatus.PROVED, np.concatenate(parts), finding.states, note=finding.note)
    states = np.full(count, OPEN, dtype=np.int64)
    bounds = np.empty((4 + 2 * count, 2))
    if isinstance(finding, NoPose):
        bounds[:] = np.nan
        message = finding.reason(arrays.robot.cable_names)
        return PointMassPose(PoseStatus.NO_POSE, bounds, states, message)
    bounds[:3], bounds[3], bounds[4:] = finding.position, (-np.inf, np.inf), (0.0, np.inf)
    return PointMassPose(PoseStatus.UNPROVED, bounds, states, finding.reason)
