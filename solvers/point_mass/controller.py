"""A solver prepared for one point-mass robot: calls of some ten microseconds, for controllers.

`forward_kinematics` reads, checks and reports everything anew in each call. Here the robot's data are
enclosed once, a call with plain floats goes straight to one compiled kernel, and the answer is one light
object. The kernels and the fallbacks are those of `forward_kinematics`, so the answers are the same.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.errors import InputError
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.given import require_robot
from cdpr_interval.robots.numbers import is_exact_point
from solvers.answers.data import CableState
from solvers.point_mass import scope
from solvers.point_mass.arrays import RobotArrays, build_arrays, exact_ends, with_load
from solvers.point_mass.convex import Finding, NoPose, after_quick, quick_pose, scaled_cables, settle
from solvers.point_mass.entry import STATES, Fields
from solvers.point_mass.fields import OPEN, SLACK, TAUT
from solvers.point_mass.one_call import DECIDED
from solvers.point_mass.over_choices import find_over_choices
from solvers.point_mass.trap import trap
from solvers.questions.checked import require_treated
from solvers.questions.errors import InputErrors
from solvers.questions.force import NO_LOAD, ZERO, no_load, read_force, read_force_ranges
from solvers.questions.lengths import read_lengths
from solvers.questions.problem import Problem
from solvers.questions.quick import checked, force_key, quick_bounds


class PoseStatus(StrEnum):
    """What is proved for all lengths in their ranges."""

    PROVED = "proved"
    """There is exactly one static pose in all of space, and the bounds enclose it."""
    NO_POSE = "no-pose"
    """There is no static pose: no point is in reach of all cables, or only one, where nothing holds it."""
    UNPROVED = "unproved"
    """Neither of the two; ``reason`` says why."""


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class PointMassPose:
    """The static pose of a point mass, as `PointMass.solve` returns it.

    Bounds are float64 arrays whose last axis is (lo, hi).

    Guarantee
    ---------
    With status PROVED the robot has exactly one static pose for every choice of lengths in their ranges,
    wherever in space, and ``position``, ``height``, ``tensions`` and ``distances`` enclose it; the cables
    in ``taut`` are proved to carry tension, those that are SLACK to carry none within their lengths.
    With NO_POSE there is none for any choice. With UNPROVED nothing is claimed.
    """

    status: PoseStatus
    bounds: Bounds
    """(4 + 2 N, 2), in rows: position, height, tensions, distances. NaN with NO_POSE; with UNPROVED the
    position is where a pose would be, and nothing is known of the rest."""
    kernel_states: NDArray[np.int64]
    """(N,) states as the compiled kernels number them; ``states`` has their names."""
    reason: str = ""
    """Empty with PROVED; else one sentence: which cables cannot reach, or what is not decided."""
    note: str = ""
    """With PROVED, one sentence where a cable's state is undecided."""

    def __repr__(self) -> str:
        if self.status is not PoseStatus.PROVED:
            return f"<PointMassPose {self.status}: {self.reason}>"
        place = ", ".join(f"{x:.6g}" for x in self.point)
        return f"<PointMassPose {self.status}: ({place}) m, taut {self.taut}>"

    @property
    def proved(self) -> bool:
        """True when the pose exists, is the only one, and lies in the bounds."""
        return self.status is PoseStatus.PROVED

    @property
    def complete(self) -> bool:
        """True when nothing is open: there is no pose, or it is proved and so is every cable's state."""
        if self.status is PoseStatus.PROVED:
            return not (self.kernel_states == OPEN).any()
        return self.status is PoseStatus.NO_POSE

    @property
    def position(self) -> Bounds:
        """(3, 2) m: platform origin in the base frame."""
        return self.bounds[:3]

    @property
    def point(self) -> tuple[float, float, float]:
        """Middle of ``position`` in m; plain floats, not certified."""
        (xlo, xhi), (ylo, yhi), (zlo, zhi) = self.bounds[:3].tolist()
        return 0.5 * xlo + 0.5 * xhi, 0.5 * ylo + 0.5 * yhi, 0.5 * zlo + 0.5 * zhi

    @property
    def height(self) -> Bounds:
        """(2,) m: of the centre of mass, along up."""
        return self.bounds[3]

    @property
    def tensions(self) -> Bounds:
        """(N, 2) N, file order; [0, 0] for a slack cable."""
        return self.bounds[4 : 4 + len(self.kernel_states)]

    @property
    def distances(self) -> Bounds:
        """(N, 2) m: from the exit points to the platform."""
        return self.bounds[4 + len(self.kernel_states) :]

    @property
    def states(self) -> tuple[CableState, ...]:
        """What is proved about each cable, file order; UNDECIDED throughout unless the pose is PROVED."""
        return tuple([STATES[state] for state in self.kernel_states.tolist()])

    @property
    def taut(self) -> tuple[int, ...]:
        """Indices of the cables proved taut."""
        return tuple([i for i, state in enumerate(self.kernel_states.tolist()) if state == TAUT])

    @property
    def not_slack(self) -> tuple[int, ...]:
        """Indices of the cables that may be taut."""
        return tuple([i for i, state in enumerate(self.kernel_states.tolist()) if state != SLACK])


class StraightPointMass:
    """The forward kinematics of one point mass on straight cables of one kind, prepared for many calls.

    Parameters
    ----------
    robot : Robot
        All platform anchors at the centre of mass. Its numbers are enclosed here, once.

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
    >>> solver = StraightPointMass(load_robot("merlet_4_1"))
    >>> pose = solver.solve([3.1, 3.2, 3.3, 3.4])
    >>> pose.proved, pose.taut
    (True, (0, 1, 2))
    """

    __slots__ = ("_arrays", "_forced", "_robot")

    def __init__(self, robot: Robot | str | os.PathLike[str]) -> None:
        robot = require_robot(robot)
        if not scope.accepts(robot):
            raise InputError(f"robot '{robot.name}': must be a point mass, this is a platform")
        require_treated(robot, scope.refuses(robot))
        self._robot = robot
        middle = robot.middle()
        weight = loaded(middle).load
        self._arrays = build_arrays(middle, weight) if any(weight) else None
        self._forced: tuple[tuple[float, ...], RobotArrays] | None = None

    @property
    def robot(self) -> Robot:
        """The robot this solver was prepared for."""
        return self._robot

    def warm_up(self) -> None:
        """Compile or load the kernels now, so that no later call waits for them.

        Without it the first call, and the first with a cable just taut or slack, take a tenth of a second
        each to load kernels, and many seconds where they were never compiled on this machine. The
        constructor compiles nothing.
        """
        arrays = self._arrays
        if arrays is None:
            arrays = build_arrays(self._robot.middle(), (Fraction(0), Fraction(0), Fraction(-1)))
        # Cables that long reach each other's exit points: everything below is asked of a common point.
        reach = 16.0 * float(arrays.frame[0, 0])
        lengths = np.full((len(self._robot.cables), 2), reach)
        quick_pose(arrays, lengths)
        settle(arrays, lengths)
        if arrays.is_elastic:
            # Where length ranges are too wide for Newton.
            trap(scaled_cables(arrays, lengths), arrays.load)

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
        Over ranges that one takes the time for sharper bounds, which lie within these.

        Notes
        -----
        Some ten microseconds where every cable is clearly taut or slack. Where a cable is only just taut
        or slack, without a common point of the cables, and for wide ranges, exact arithmetic follows:
        milliseconds, for wide ranges of elastic cables tenths of a second. Of a robot or force with ranges
        every answer is that of `forward_kinematics`, in its time.
        """
        if not self._robot.is_exact or is_ranged(external_force):
            return self._over_choices(lengths, external_force)
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

    def _over_choices(self, lengths: Any, external_force: Any) -> PointMassPose:
        """Return the pose for every choice of data with ranges."""
        errors, names = InputErrors(), self._robot.cable_names
        ranges = errors.read(read_lengths, lengths, names)
        force = ZERO if external_force is None else errors.read(read_force_ranges, external_force)
        if force is not None and (complaint := no_load(loaded(self._robot, force))) is not None:
            errors.add(complaint)
        errors.require_none()
        assert ranges is not None and force is not None
        return pose_of(find_over_choices(Problem(self._robot, ranges, force)), names)

    def _under(self, external_force: Any) -> RobotArrays:
        """Return the arrays under the weight and a force; the last ones are kept."""
        key = force_key(external_force)
        kept = self._forced
        if key is not None and kept is not None and kept[0] == key:
            return kept[1]
        force = ZERO if external_force is None else read_force(external_force)
        load = loaded(self._robot, force).load
        if not any(load):
            raise InputError(NO_LOAD)
        arrays = build_arrays(self._robot, load) if self._arrays is None else with_load(self._arrays, load)
        if key is not None:
            self._forced = key, arrays
        return arrays


def is_ranged(force: Any) -> bool:
    """Return True for a force of which an entry is a range; for one that is none False."""
    if force is None or force_key(force) is not None:
        return False
    try:
        return not is_exact_point(read_force_ranges(force))
    except InputError:
        return False


def _settled(arrays: RobotArrays, lengths: Bounds, exact: list[Fraction] | None) -> PointMassPose:
    """Return the answer where the compiled path has decided nothing."""
    return pose_of(after_quick(arrays, lengths, exact), arrays.robot.cable_names)


def pose_of(finding: Finding, names: Sequence[str]) -> PointMassPose:
    """Return what was found as an answer."""
    count = len(names)
    if isinstance(finding, Fields):
        parts = (finding.position, finding.height[None], finding.tensions, finding.distances)
        return PointMassPose(PoseStatus.PROVED, np.concatenate(parts), finding.states, note=finding.note)
    states = np.full(count, OPEN, dtype=np.int64)
    bounds = np.empty((4 + 2 * count, 2))
    if isinstance(finding, NoPose):
        bounds[:] = np.nan
        message = finding.reason(names)
        return PointMassPose(PoseStatus.NO_POSE, bounds, states, message)
    bounds[:3], bounds[3], bounds[4:] = finding.position, (-np.inf, np.inf), (0.0, np.inf)
    return PointMassPose(PoseStatus.UNPROVED, bounds, states, finding.reason)
