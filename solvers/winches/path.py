"""A path of the platform: planned by inverse kinematics, and proved step by step before winches run it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.driver.reference import Reference
from cdpr_interval.driver.setpoints import PEAK_ACCELERATION, PEAK_SPEED, smooth
from cdpr_interval.driver.winch import bounds
from cdpr_interval.errors import CdprError
from cdpr_interval.mechanics.statics import Pose
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.winch import WinchLimits
from solvers.answers.data import CableState
from solvers.classes import class_of
from solvers.kinematics.inverse import inverse_kinematics
from solvers.questions.checked import on_legs, require_treated, uncertain_data
from solvers.winches.where import MeasuredPose, whereabouts

Floats = NDArray[np.float64]
Ranges = Sequence[tuple[float, float]]

SHARE = 0.8
"""Of the speed and acceleration limits, used by a path; the rest is for corrections by marks."""
WAYPOINTS = 64
"""At which the lengths are computed before the time of the path is known."""
LONGEST_PIECE = 1 / 200
"""Travel of a piece that is proved in one go, in longest cables of the path."""
FINE_PIECE = LONGEST_PIECE / 16
"""Down to which pieces are halved for what is said of tensions, not because they are not proved."""
WIDER, COARSER = 1.1, 0.02
"""Bounds of tensions over a longer piece: so much wider than at its start, and by that share of the largest
tension, are sharp enough. On a camera of 90 m pieces are then 0.4 m long; they take as long as short ones."""
SHORTEST_PIECE = 1e-7
"""The same: what cannot be proved over that way is not proved."""
GROWTH = 1.5
"""Of pieces after one that is proved; they are halved after one that is not."""
ROUNDED_UP = 1 + 1e-9
"""Covers the rounding of half widths, a billionth of a millimetre."""


HalfWidths = Callable[[Sequence[float]], Sequence[float]]


OPEN = "a cable may be taut or slack"
BLUNT = "tensions are known better over shorter pieces"


class PathRefused(CdprError):
    """The path is not proved to be safe; nothing was moved."""


@dataclass(frozen=True)
class Proved:
    """How far a path is proved, while that goes on."""

    pieces: int
    """Proofs."""
    seconds: float
    """s from the start."""
    duration: float
    """s of the whole path."""
    travel: float
    """Share of the whole, 0 to 1, by the cable that moves most."""


@dataclass(frozen=True)
class Path:
    """Set-points, one a cycle, every one between the limits, with a certified pose all along."""

    times: Floats
    """(K,) s, from one cycle on."""
    lengths: Floats
    """(K, N) m, unstretched."""
    taut: tuple[int, ...]
    """Cables proved taut all along."""
    tight: tuple[int, ...]
    """Cables never proved slack: those of ``taut``, and those that share the load in ways that depend on
    what is not known of the lengths."""
    tensions: Floats
    """(N, 2) N: proved bounds over the whole path."""
    uncertainty: Floats
    """(N,) m: so much may the lengths differ from the set-points in the proofs; 0 for a platform."""
    margins: Floats
    """(N,) m: least distance to a length limit."""
    speeds: Floats
    """(N,) m/s: largest."""
    accelerations: Floats
    """(N,) m/s^2: largest."""
    pieces: int
    """Proofs."""
    goal: Pose
    """Where it ends: the pose asked for, settled if that was asked for."""

    @property
    def points(self) -> list[tuple[float, list[float]]]:
        """Times and lengths as `WinchGroup.follow` takes them."""
        return [(float(t), row) for t, row in zip(self.times, self.lengths.tolist(), strict=True)]


def plan(
    robot: Robot,
    limits: Sequence[WinchLimits],
    commanded: Sequence[float],
    ranges: Ranges,
    goal: Pose,
    duration: float | None = None,
    settle: bool = False,
    half_widths: HalfWidths | None = None,
    progress: Callable[[Proved], None] | None = None,
) -> Path:
    """Plan and prove a path to a pose.

    A point mass goes in a straight line; for a platform the lengths change in proportion, because few cables
    hold it in few poses only.

    Parameters
    ----------
    robot : Robot
    limits : sequence of WinchLimits
    commanded : sequence of N floats
        m: lengths that the drives hold.
    ranges : sequence of (lo, hi)
        m: what is known of the lengths at the start.
    goal : Pose
    duration : float, optional
        s; the default is the shortest the limits allow.
    settle : bool
        Move the goal to the nearest static pose first.
    half_widths : callable, optional
        From set-points in m to how far each length may be from its own, in m (`half_widths_of`): drum
        tolerances add up along the way. Default: as far as at the start.
    progress : callable, optional
        Told after every proof how far the path is proved; what it raises ends the planning.

    Raises
    ------
    NotSupportedError
        For a robot with uncertain scalars.
    PathRefused
        With the place and the reason: a limit, a slack or overloaded cable, a pose that is not proved.
    KeyboardInterrupt
        At Ctrl-C, also where that has ended the search for the start.

    Guarantee
    ---------
    The pieces cover the path without gaps: each is a box of lengths around its set-points, the straight lines
    between them, and what is not known of the lengths, and the pose is proved for the whole box.
    """
    require_treated(robot, on_legs(robot, "winch move"))
    require_treated(robot, uncertain_data(robot, asker="winch move"))
    held = np.array(commanded, dtype=np.float64)
    here = _here(robot, ranges)
    way = _Way(robot, held, here, goal, settle)
    sketch = np.array([way.lengths(k / WAYPOINTS) for k in range(WAYPOINTS + 1)])
    _require_limits(robot, limits, sketch)
    cycle = float(robot.winches.cycle)
    seconds = _shortest(sketch, limits) if duration is None else duration
    steps = max(math.ceil(seconds / cycle), 1)
    times: Floats = cycle * np.arange(1, steps + 1, dtype=np.float64) + float(robot.winches.lookahead)
    lengths = np.array([way.lengths(smooth(k / steps)) for k in range(1, steps + 1)], dtype=np.float64)
    _require_limits(robot, limits, lengths)
    speeds, accelerations = _rates(np.vstack([held, held, lengths, lengths[-1:]]), cycle)
    _require_rates(robot, limits, speeds, accelerations)
    rows = np.vstack([held, lengths])
    # A platform's pose can be followed for a tenth of a millimetre only: the proof is for the set-points.
    widths = (
        _widths(rows, held, ranges, half_widths) if class_of(robot).solves_ranges else np.zeros_like(rows)
    )
    prover = _Prover(robot, here)
    pieces = _proved(prover, _Polyline(rows, widths), cycle, progress)
    ends = np.array([[float(x) for x in one.length] for one in limits])
    margins = np.minimum(lengths - ends[:, 0], ends[:, 1] - lengths).min(axis=0)
    return Path(
        times=times,
        lengths=lengths,
        taut=prover.taut,
        tight=here.tight,
        tensions=prover.tensions,
        uncertainty=widths.max(axis=0),
        margins=margins,
        speeds=speeds,
        accelerations=accelerations,
        pieces=pieces,
        goal=way.goal,
    )


def half_widths_of(references: Sequence[Reference]) -> HalfWidths:
    """Return how far each length may be from its set-point, by the references of the cables.

    A mark on the way only narrows that, and its correction lies in it.
    """

    def widths(lengths: Sequence[float]) -> list[float]:
        found = []
        for reference, length in zip(references, lengths, strict=True):
            counts = reference.model.counts(Fraction(length) - reference.offset)
            lo, hi = bounds(reference.length_range(counts))
            found.append(max(hi - length, length - lo))
        return found

    return widths


def _widths(rows: Floats, held: Floats, ranges: Ranges, half_widths: HalfWidths | None) -> Floats:
    """Return (K, N) half widths for all set-points, a little rounded up."""
    if half_widths is None:
        start = np.abs(np.array(ranges) - held[:, None]).max(axis=1)
        return np.broadcast_to(start, rows.shape) * ROUNDED_UP
    return np.array([half_widths(row) for row in rows.tolist()]) * ROUNDED_UP


def _here(robot: Robot, ranges: Ranges) -> MeasuredPose:
    """Return the pose from which the path starts.

    Where ranges of lengths are solved as a whole, the pose is proved for all of them, whichever of the tight
    cables are taut: no more is asked. A platform is followed from one set of taut cables: it must be known.
    """
    known = whereabouts(robot, ranges)
    if known.is_interrupted:
        # The search has taken the interrupt for its own.
        raise KeyboardInterrupt
    if len(known.poses) != 1:
        raise PathRefused(f"the start is not known: {known.message}")
    (here,) = known.poses
    if not here.solution.is_proved:
        raise PathRefused("the start is not proved to be the only pose")
    if not (class_of(robot).solves_ranges or here.is_decided):
        raise PathRefused(f"the start is not proved: {OPEN}")
    return here


class _Way:
    """Lengths along the way from where the platform is to the goal."""

    def __init__(self, robot: Robot, held: Floats, here: MeasuredPose, goal: Pose, settle: bool) -> None:
        self._robot, self._held = robot, held
        self._start = np.array(here.point)
        end = inverse_kinematics(
            robot,
            goal.position,
            goal.rotation,
            taut=list(here.tight),
            settle=settle and class_of(robot).turns,
        )
        if end.lengths is None or not end.is_static:
            raise PathRefused(f"the goal is no static pose: {end.message}")
        if end.settling is not None and not end.settling.succeeded:
            raise PathRefused(f"the goal could not be settled: {end.message}")
        self._end = np.array(end.position)
        self.goal = Pose(self._end, np.array(end.rotation))
        self._last = np.array(end.lengths)
        self._taut = list(here.tight)
        # What the winches hold differs from what inverse kinematics would choose; the difference fades out.
        self._offset = held - self._by_pose(0.0) if not class_of(robot).turns else None

    def _by_pose(self, share: float) -> Floats:
        place = self._start + share * (self._end - self._start)
        found = inverse_kinematics(self._robot, place, taut=self._taut).lengths
        if found is None:
            raise PathRefused(f"no tensions hold the load at {_shown(place)} m")
        return np.array(found)

    def lengths(self, share: float) -> Floats:
        """Return the lengths in m after a share of the way."""
        if self._offset is None:
            return self._held + share * (self._last - self._held)
        return self._by_pose(share) + (1 - share) * self._offset


def _shortest(rows: Floats, limits: Sequence[WinchLimits]) -> float:
    """Return a time in s in which every winch can do it, by the rates over the share of the way."""
    slopes = np.abs(np.diff(rows, axis=0)).max(axis=0) * WAYPOINTS
    bends = np.abs(np.diff(rows, n=2, axis=0)).max(axis=0) * WAYPOINTS**2
    seconds = 0.0
    for slope, bend, one in zip(slopes, bends, limits, strict=True):
        speed, acceleration = SHARE * float(one.velocity), SHARE * float(one.acceleration)
        by_speed = PEAK_SPEED * slope / speed
        by_acceleration = math.sqrt((PEAK_ACCELERATION * slope + PEAK_SPEED**2 * bend) / acceleration)
        seconds = max(seconds, by_speed, by_acceleration)
    return seconds


def _rates(rows: Floats, cycle: float) -> tuple[Floats, Floats]:
    steps = np.diff(rows, axis=0) / cycle
    return np.abs(steps).max(axis=0), np.abs(np.diff(steps, axis=0) / cycle).max(axis=0)


def _require_limits(robot: Robot, limits: Sequence[WinchLimits], rows: Floats) -> None:
    for i, one in enumerate(limits):
        low, high = (float(limit) for limit in one.length)
        worst = rows[:, i][np.argmax(np.maximum(low - rows[:, i], rows[:, i] - high))]
        if not low <= worst <= high:
            name = robot.cable_names[i]
            raise PathRefused(f"{name}: the path needs {worst:.4f} m, limits {low:g} to {high:g} m")


def _require_rates(
    robot: Robot, limits: Sequence[WinchLimits], speeds: Floats, accelerations: Floats
) -> None:
    for name, one, speed, acceleration in zip(robot.cable_names, limits, speeds, accelerations, strict=True):
        if speed > one.velocity or acceleration > one.acceleration:
            fastest, strongest = float(one.velocity), float(one.acceleration)
            got = f"{speed:.3f} m/s and {acceleration:.3f} m/s2"
            raise PathRefused(f"{name}: needs {got}, limits {fastest:g} and {strongest:g}: give it more time")


class _Polyline:
    """Lengths along a path, by travel in m: the sum over the cycles of what the fastest cable goes."""

    def __init__(self, rows: Floats, widths: Floats) -> None:
        self._rows, self._widths = rows, widths
        self._travel = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(rows, axis=0)).max(axis=1))])
        self.total = float(self._travel[-1])
        self.cycles = len(rows) - 1
        self.longest = float(rows.max())

    def piece(self, start: float, end: float) -> tuple[Floats, float]:
        """Return ranges (N, 2) in m around a piece of the path, and the largest half width in them."""
        inside = (start <= self._travel) & (self._travel <= end)
        rows = np.vstack([self.at(start), self._rows[inside], self.at(end)])
        first = int(np.searchsorted(self._travel, start, "left")) - 1
        last = int(np.searchsorted(self._travel, end, "right"))
        width = self._widths[max(first, 0) : last + 1].max(axis=0)
        return np.stack([rows.min(axis=0) - width, rows.max(axis=0) + width], axis=-1), float(width.max())

    def at(self, travel: float) -> Floats:
        """Return the lengths in m at a place of the path."""
        return np.array([np.interp(travel, self._travel, column) for column in self._rows.T])

    def cycle(self, travel: float) -> float:
        """Return at which cycle that is, with its fraction."""
        return float(np.interp(travel, self._travel, np.arange(self.cycles + 1)))


def _proved(prover: _Prover, path: _Polyline, cycle: float, progress: Callable[[Proved], None] | None) -> int:
    """Prove a pose for all lengths along the path; return how many proofs that took.

    Pieces are as long as can be: one that is refused is halved, the one after one that is proved is longer.
    """
    prover.refutes(np.stack([path.at(0.0)] * 2, axis=-1))
    longest, fine = LONGEST_PIECE * path.longest, FINE_PIECE * path.longest
    here, step, pieces, compared = 0.0, longest, 0, -1.0
    while not pieces or here < path.total:
        step = min(step, path.total - here)
        there = path.total if step == path.total - here else here + step
        ranges, width = path.piece(here, there)
        # Asked of the step itself: there - here is rounded, and may stay above the fine one for ever.
        reason = prover.refutes(ranges, sharply=step > fine)
        if reason == BLUNT and compared != here:
            compared = here
            prover.compare(path.piece(here, here)[0])
        elif reason == BLUNT:
            step = max(0.5 * step, fine)
        elif reason:
            step *= 0.5
            if step < max(0.5 * width, SHORTEST_PIECE * path.longest):
                raise PathRefused(f"near the lengths {_shown(path.at(here))} m: {reason}")
        else:
            here, step, pieces = there, min(GROWTH * step, longest), pieces + 1
            if progress is not None:
                share = here / path.total if path.total else 1.0
                progress(Proved(pieces, path.cycle(here) * cycle, path.cycles * cycle, share))
    return pieces


class _Prover:
    """What must hold for ranges of lengths: a certified pose, tight cables tight, tensions in limits.

    What is proved of a cable at the start stays so: taut or slack. Only where tight cables share the load in
    ways that are not known at the start, a tight one may be taut here and open there, never slack.
    """

    def __init__(self, robot: Robot, here: MeasuredPose) -> None:
        self._robot, self._here = robot, here
        self._follow = class_of(robot).follower(robot, here.solution)
        self._shared = not here.is_decided
        self.tensions: Floats = here.tensions.copy()
        self.taut = here.taut
        self._sharp = _enough(here.tensions)

    def refutes(self, ranges: Floats, sharply: bool = False) -> str:
        """Return why ranges of lengths are refused; empty when they are proved.

        With ``sharply`` also those are for which shorter pieces of the path would say more about tensions.
        """
        pose = self._follow(ranges)
        if not pose.proved:
            return pose.reason
        if sharply and self._is_blunt(pose.states, pose.tensions):
            return BLUNT
        return self._accept(pose.states, pose.tensions)

    def compare(self, ranges: Floats) -> None:
        """Take the bounds for a place of the path as those that pieces around it are compared with."""
        pose = self._follow(ranges)
        if pose.proved:
            self._sharp = _enough(pose.tensions)

    def _is_blunt(self, states: Sequence[CableState], tensions: Floats) -> bool:
        if any(states[i] is not CableState.TAUT for i in self.taut):
            return True
        return bool((tensions[:, 1] - tensions[:, 0] > self._sharp).any())

    def _accept(self, states: Sequence[CableState], tensions: Floats) -> str:
        """Return why a proved pose is refused; empty when it is accepted."""
        for i, (now, start) in enumerate(zip(states, self._here.states, strict=True)):
            name = self._robot.cable_names[i]
            either = CableState.SLACK in (now, start)
            if now is not start and (either or not self._shared):
                return f"{name} is {start.value} at the start, {now.value} here"
            limits = self._robot.cables[i].tension_limits
            lo, hi = tensions[i]
            if (
                now is not CableState.SLACK
                and limits is not None
                and not (limits[0] <= lo and hi <= limits[1])
            ):
                low, high = (float(limit) for limit in limits)
                return f"{name} may carry {lo:.6g} to {hi:.6g} N, limits {low:g} to {high:g} N"
        self.taut = tuple(i for i in self.taut if states[i] is CableState.TAUT)
        self.tensions[:, 0] = np.minimum(self.tensions[:, 0], tensions[:, 0])
        self.tensions[:, 1] = np.maximum(self.tensions[:, 1], tensions[:, 1])
        return ""


def _enough(tensions: Floats) -> Floats:
    """Return the widths of bounds of tensions that are sharp enough, by bounds (N, 2) for one place."""
    return WIDER * (tensions[:, 1] - tensions[:, 0]) + COARSER * tensions[:, 1].max()


def _shown(values: Floats) -> str:
    return "(" + ", ".join(f"{x:.4f}" for x in values) + ")"
