"""Follow one static pose of a platform from length to length, with a proof at each step, for controllers.

`forward_kinematics` finds every static pose anywhere and takes milliseconds to seconds. A controller knows
where the platform was a moment ago: here the last pose is carried on, and proved to be the only one
around there, whatever cables are taut, or where that cannot be, to be what the last one moves to.
"""

from __future__ import annotations

import math
import os
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.errors import CdprError, InputError, NotSupportedError
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.mechanics.rotation import HALF_TURNS, chart_of, quaternion_of
from cdpr_interval.mechanics.six_dof.arrays import platform_size
from cdpr_interval.mechanics.six_dof.fields import Cables, Fields, FrameBounds, fill_fields
from cdpr_interval.mechanics.six_dof.frame import Frame
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.given import require_robot
from cdpr_interval.robots.numbers import Point
from solvers.answers.data import Outcome, Solution
from solvers.answers.message import message_of
from solvers.questions.checked import on_legs, require_treated
from solvers.questions.force import ZERO, no_load, read_force_ranges
from solvers.questions.lengths import read_lengths
from solvers.questions.problem import Options, Problem
from solvers.questions.quick import checked, force_key, quick_bounds
from solvers.six_dof import scope
from solvers.six_dof.cells.roots import GENERAL, system_of
from solvers.six_dof.estimate import Body, Estimate, Guess, estimate
from solvers.six_dof.forward import solve
from solvers.six_dof.over_pulleys import solve as solve_real
from solvers.six_dof.over_pulleys import stability_at
from solvers.six_dof.place import Place, guess_of, is_single, known_at, place_of, single
from solvers.six_dof.prepared import cables_of
from solvers.six_dof.real.follow import Fault, warm_up_legs
from solvers.six_dof.real.leg import ENDS, LIFTS, SLACKENS, TIGHTENS
from solvers.six_dof.real.tracking import Tracking
from solvers.six_dof.solution import multiply_tensions
from solvers.six_dof.track import (
    BROAD,
    FORCED,
    GONE,
    LOOSE,
    MOVED,
    NO_ROOT,
    OTHER,
    SINGULAR,
    TIGHT,
    TRACKED,
    track,
)
from solvers.six_dof.tracked_pose import Region, TrackedPose, TrackStatus
from solvers.six_dof.way import Arrived, Known, Way, spread, warm_up_ways

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LARGEST_REGION = 0.125
"""Radius of the first region over the platform's size: larger ones are hardly ever proved."""
SMALLEST_REGION = 2.0**-15
"""Radius of the last region over the platform's size, some 10 micrometres for a platform of 0.5 m."""
LARGER_EVERY = 16
"""After so many updates the region twice as large is tried again."""
CHART_END = 1.2
"""Largest entry of u before another chart takes over; every rotation has a chart where it is at most 1."""


class Load(NamedTuple):
    """A constant force and what follows from it."""

    key: tuple[float, ...] | None
    bounds: Bounds
    """(3, 2) N: weight and external force."""
    cables: Cables
    force: Point
    """N: the external force."""
    factor: Range
    """Of the load and all tensions; it moves no pose, and ``bounds`` and ``cables`` are without it."""


class Tracker:
    """The static pose near the last one, step by step.

    Parameters
    ----------
    robot : Robot, str or PathLike
        A platform, its file or name. Its numbers are enclosed here, once.
    start : Solution or Estimate, optional
        A pose of `forward_kinematics` to start from, or one in plain floats; without it the first `update`
        searches for one.
    radius : float, optional
        m: of the largest region tried around the last pose; by default an eighth of ``size``.
    least_radius : float, optional
        m: a smaller region is not tried; by default a 32768th of ``size``, at most ``radius``.
    follow : bool, optional
        Where no region is proved, follow the pose from the last lengths to these; else it is lost there.

    Raises
    ------
    InputError
        The robot is a point mass (see `PointMass`); the start is no single pose with every cable's state
        decided; a radius is not positive, or the largest above half of ``size``.
    NotSupportedError
        Ranges in the data of a robot over pulleys or on elastic cables; of such a robot without ``follow``.

    Notes
    -----
    An instance has a state and belongs to one thread: two calls at once raise `CdprError`. The constructor
    compiles nothing; see `warm_up`.

    Examples
    --------
    >>> from cdpr_interval import load_robot
    >>> from solvers import forward_kinematics
    >>> robot = load_robot("uc4")
    >>> poses = forward_kinematics(robot, [7.5, 8.0, 7.0, 9.0], taut=range(4)).solutions
    >>> tracker = Tracker(robot, poses[0])
    >>> pose = tracker.update([7.501, 8.0, 7.0, 9.0])
    >>> pose.tracked, pose.taut
    (True, (0, 1, 2, 3))
    >>> pose = tracker.update([7.55, 8.0, 7.0, 9.3])  # followed, through a cable that becomes slack
    >>> pose.tracked, pose.taut, pose.switching
    (True, (0, 1, 2), (3,))
    >>> lost = tracker.update([7.55, 8.0, 7.0, (8.9, 9.5)])  # no proof, but an estimate
    >>> str(lost.status), lost.estimate.status, lost.estimate.converged
    ('lost-track', 'estimate', True)
    >>> tracker.reset(lost.estimate)
    >>> tracker.update([7.55, 8.0, 7.0, 9.2]).tracked
    True
    """

    def __init__(
        self,
        robot: Robot | str | os.PathLike[str],
        start: Solution | Estimate | None = None,
        *,
        radius: float | None = None,
        least_radius: float | None = None,
        follow: bool = True,
    ) -> None:
        robot = require_robot(robot)
        if not scope.accepts(robot):
            raise InputError(f"robot '{robot.name}': is a point mass; use PointMass, it needs no start")
        require_treated(robot, on_legs(robot, "Tracker"))
        require_treated(robot, scope.refuses(robot))
        self._robot = robot
        self._is_real = scope.needs_real_cells(robot)
        self._real: Tracking | None = None
        if self._is_real:
            self._size = size_of(robot)
            if not follow:
                reason = "a pose over pulleys or on elastic cables is followed, no region is proved for it"
                raise NotSupportedError(f"follow: {reason}")
        else:
            self._body = Body(robot)
            self._size = self._body.size
        self._radius = metres("radius", radius, LARGEST_REGION * self._size, 0.5 * self._size)
        smallest = min(SMALLEST_REGION * self._size, self._radius)
        least = metres("least_radius", least_radius, smallest, self._radius)
        self._follows = follow
        self._last = int(math.log2(self._radius / least) + 1e-9)
        self._count = len(robot.cables)
        self._loaded: Load | None = None
        self._charts: Floats | None = None
        self._place: Place | None = None
        self._guess: Guess | None = None
        self._updates = 0
        self._start: Solution | None = None
        """Of a real platform, until its first update."""
        self._busy = threading.Lock()
        if start is not None:
            self.reset(start)

    @property
    def robot(self) -> Robot:
        """The robot this tracker was made for."""
        return self._robot

    @property
    def size(self) -> float:
        """A length of the platform in m; a region of radius r holds turns by up to r / size rad."""
        return self._size

    def reset(self, start: Solution | Estimate) -> None:
        """Go on from a pose of `forward_kinematics`, or from an `Estimate` of a lost pose.

        A start is only where the next proof begins: from an estimate, too, what `update` says is proved.

        Raises
        ------
        InputError
            It is not one pose of this robot with every cable's state decided, or an estimate that has
            not converged.
        """
        with self._alone():
            if self._is_real:
                wanted = "a Solution of forward_kinematics where cables run over pulleys or stretch"
                self._start, self._real = single(start, self._count, wanted), None
            else:
                self._place, self._guess = place_of(self._body, start), None

    def warm_up(self) -> None:
        """Compile or load the kernels now, so that no later call waits for them.

        Without it the first `update` does. Where nothing is compiled yet that takes the better part of a
        minute with a start to go on from, and more than one without: the search for a start needs the
        kernels of `forward_kinematics` too.
        """
        if self._is_real:
            warm_up_legs(self._robot)
            return
        try:
            load = self._under(None)
        except InputError:
            # A weightless platform: the force comes with the calls.
            load = self._under((0.0, 0.0, -1.0))
        assert self._charts is not None
        taut, lengths = np.zeros(1, dtype=np.int64), np.ones((self._count, 2))
        self._fields(load, 0, np.ones((7, 2)), taut, lengths)
        system = system_of(GENERAL, 1)
        radii = np.array((self._size, self._radius, 0.0, 0.0))
        # One cable, far away: its pose is one of a family, and never proved to be the only one.
        z = np.array([0.0, 0.0, 0.0, 1e3, 1e3, 1e3, 1.0])
        order = np.arange(self._count, dtype=np.int64)
        track(
            self._charts[0], load.bounds, lengths, order, system.rows, system.free[0].copy(), radii,
            z, np.empty(7), np.empty((7, 2)),
        )  # fmt: skip
        if self._follows:
            far = Place(0, z, order, taut, system.rows, system.free[0].copy(), densities=np.ones(1))
            known_at(self._body, far, self._charts[0], lengths, load.bounds)
            warm_up_ways(self._robot, self._charts[0], load.bounds)
        if self._place is None:
            from solvers.six_dof import warming

            warming.points()
            warming.searches()

    def update(
        self, lengths: str | Sequence[Any] | Any, external_force: Sequence[Any] | None = None
    ) -> TrackedPose:
        """Follow the pose to new lengths; prove that it is the only one near, or what the last one moves to.

        Parameters
        ----------
        lengths : sequence, mapping or str
            As in `forward_kinematics`: one per cable in m; a pair (lo, hi) is a range. Sequences of floats
            or of pairs of floats, and float64 arrays (N,) or (N, 2), are the quick way.
        external_force : sequence of 3 numbers, optional
            Constant force at the centre of mass in N, base axes, added to the weight.

        Returns
        -------
        TrackedPose
            A proof that fails is its status, never an exception. The pose tracked becomes the reference of
            the next call; where track is lost the reference stays.

        Raises
        ------
        InputError
            As `forward_kinematics`.

        Guarantee
        ---------
        That of `TrackedPose`.

        Notes
        -----
        The first call without a start searches everywhere, for seconds, and goes on from the one stable pose
        there is. The region is halved until the proof succeeds: it shrinks where a cable is nearly
        slack or taut, and near a singular pose.
        """
        with self._alone():
            return self._update(lengths, external_force)

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Refuse a call that comes while another one runs: their states would be mixed."""
        if not self._busy.acquire(blocking=False):
            raise CdprError("tracker: is in use by another thread; make one tracker for each")
        try:
            yield
        finally:
            self._busy.release()

    def _update(self, lengths: Any, external_force: Any) -> TrackedPose:
        """Return the pose for new lengths."""
        bounds, load = self._question(lengths, external_force)
        if self._is_real:
            return self._update_real(lengths, bounds, load.force)
        if self._place is None:
            reason = self._begin(lengths, load.force)
            if reason:
                return TrackedPose(TrackStatus.LOST, reason, None, (), None)
        place = self._place
        assert place is not None and self._charts is not None
        root, box = np.empty(len(place.z)), np.empty((len(place.z), 2))
        status, halvings, cable = track(
            self._charts[place.chart],
            load.bounds,
            bounds,
            place.order,
            place.rows,
            place.free,
            np.array((self._size, self._radius, self._first(place), self._last)),
            place.z,
            root,
            box,
        )
        region = self._region(place, halvings)
        taut = tuple(place.taut.tolist())
        if status == TRACKED:
            fields = self._fields(load, place.chart, box, place.taut, bounds)
            if np.isfinite(fields.tensions).all():
                self._move(place, root, halvings, bounds, load)
                return TrackedPose(TrackStatus.TRACKED, "", region, taut, fields)
            status = SINGULAR
        place.halvings = 0
        guess = cache(partial(self._estimate, place, bounds, load))
        if not self._follows:
            where = f"within {region.radius:.3g} m of the last pose"
            reason = reason_of(self._robot.cable_names, status, cable, where)
            return TrackedPose(TrackStatus.LOST, reason, region, taut, None, guess)
        way = self._way(place, bounds, load)
        arrived = way.go(place.chart, self._charts[place.chart], load.bounds, bounds)
        if arrived.status == TRACKED:
            found = self._arrived(place, way, arrived, load, bounds)
            if found is not None:
                return found
            arrived.status = GONE
        where = f"after {100.0 * arrived.share:.3g} % of the way to these lengths"
        reason = reason_of(self._robot.cable_names, arrived.status, arrived.cable, where)
        return TrackedPose(TrackStatus.LOST, reason, region, taut, None, guess)

    def _update_real(self, lengths: Any, bounds: Bounds, force: Point) -> TrackedPose:
        """Return the pose for new lengths where cables run over pulleys or stretch."""
        if self._real is not None and not self._real.has_begun and force != self._real.force:
            self._real = None
        if self._real is None:
            if self._start is None and (reason := self._begin(lengths, force)):
                return TrackedPose(TrackStatus.LOST, reason, None, (), None)
            assert self._start is not None
            judge = partial(stability_at, self._robot, force)
            self._real = Tracking(self._robot, force, self._start, judge)
        real = self._real
        if force != real.force:
            reason = reason_of(self._robot.cable_names, FORCED, -1, "")
            return TrackedPose(TrackStatus.LOST, reason, None, (), None)
        found = real.update(bounds)
        if found.here is None:
            where = f"after {100.0 * found.share:.3g} % of the way to these lengths"
            reason = why(self._robot.cable_names, found.fault, where)
            return TrackedPose(TrackStatus.LOST, reason, None, (), None)
        here = found.here
        return TrackedPose(
            TrackStatus.TRACKED,
            "",
            None,
            tuple(sorted(i for i in here.taut if i != here.open)),
            real.fields(here),
            pieces=len(found.legs),
            switching=tuple(sorted({leg.open for leg in found.legs if leg.open >= 0})),
        )

    def _estimate(self, place: Place, bounds: Bounds, load: Load) -> Estimate:
        """Return a pose in plain floats for lengths for which track was lost, from the last one known."""
        is_last = self._place is place
        start = self._guess if is_last and self._guess is not None else guess_of(place)
        found, guess = estimate(self._body, start, bounds.mean(axis=1), load.bounds.mean(axis=1))
        if is_last:
            # The next pose that is lost is nearer to this one than to the last that was tracked.
            self._guess = guess
        return found

    def _question(self, lengths: Any, external_force: Any) -> tuple[Bounds, Load]:
        """Return the bounds of the lengths in m, and what follows from the force; raise if they are wrong."""
        bounds, known = quick_bounds(lengths, self._count), self._loaded
        force = ZERO_FORCE if external_force is None else force_key(external_force)
        if bounds is None or known is None or force is None or force != known.key:
            return checked(lengths, bounds, self._robot.cable_names, self._under, external_force)
        return bounds, known

    def _first(self, place: Place) -> int:
        """Return how often the first region of this update is halved."""
        self._updates += 1
        return max(0, place.halvings - (self._updates % LARGER_EVERY == 0))

    def _way(self, place: Place, lengths: Bounds, load: Load) -> Way:
        """Return the way of the pose tracked last, or from a start."""
        if place.way is not None:
            return place.way
        assert self._charts is not None
        known = known_at(self._body, place, self._charts[place.chart], lengths, load.bounds)
        return Way(self._robot, known, self._size)

    def _move(self, place: Place, root: Floats, halvings: int, lengths: Bounds, load: Load) -> None:
        """Make the pose found, alone in its region, the reference of the next update."""
        taut = tuple(place.taut.tolist())
        z = spread(root[: 6 + place.known], taut, self._count)
        known = Known(taut, z, lengths, load.bounds, z, np.zeros(len(z)))
        place.way = self._way(place, lengths, load)
        place.way.alone_in(known, place.z[:6], self._radius * 0.5**halvings)
        place.z, place.halvings, self._guess = root, halvings, None
        self._turn_chart(place)

    def _arrived(
        self, place: Place, way: Way, arrived: Arrived, load: Load, lengths: Bounds
    ) -> TrackedPose | None:
        """Make the pose followed the reference of the next update; None where its bounds are not finite."""
        known = arrived.known
        assert known is not None
        taut = (
            known.taut if arrived.open < 0 else (*(i for i in known.taut if i != arrived.open), arrived.open)
        )
        loose = lengths.copy()
        # Where it is slack it is nearer than its length.
        loose[[arrived.open] if arrived.open >= 0 else [], 0] = 0.0
        each = [
            self._fields(load, place.chart, box, np.array(taut), own)
            for box, own in zip(arrived.boxes, (lengths, loose), strict=False)
        ]
        fields = hull_of(each, arrived.open)
        if not np.isfinite(fields.tensions).all():
            return None
        way.arrive(arrived)
        place.way = way
        place.take(known)
        self._guess = None
        self._turn_chart(place)
        steady = tuple(sorted(i for i in taut if i != arrived.open))
        return TrackedPose(
            TrackStatus.TRACKED, "", None, steady, fields, pieces=arrived.pieces, switching=arrived.switching
        )

    def _turn_chart(self, place: Place) -> None:
        """Take another chart where u is too large."""
        if max(map(abs, place.z[:3].tolist())) <= CHART_END:
            return
        assert place.way is not None
        before = place.chart
        place.chart, u = chart_of(quaternion_of(before, place.z))
        place.z[:3] = u
        place.way.turn_chart(before, place.chart)

    def _fields(self, load: Load, chart: int, box: Floats, taut: Ints, lengths: Bounds) -> Fields:
        """Return what a proved pose reports."""
        found = fields_of(load.cables, chart, box, taut, lengths)
        multiply_tensions(found, load.factor)
        return found

    def _region(self, place: Place, halvings: int) -> Region:
        """Return the region of one radius around the reference."""
        radius = self._radius * 0.5**halvings
        x, y, z = place.z[3:6].tolist()
        angle = math.nextafter(radius / self._size, 0.0)
        return Region((x, y, z), quaternion_of(place.chart, place.z), radius, angle)

    def _begin(self, lengths: Any, force: Point) -> str:
        """Search everywhere for a pose to start from; return why there is none."""
        ranges = read_lengths(lengths, self._robot.cable_names)
        search = solve_real if self._is_real else solve
        answer = search(Problem(self._robot, ranges, force), Options())
        stable = [s for s in answer.solutions if is_single(s) and s.stability is Stability.STABLE]
        if answer.outcome is not Outcome.COMPLETE:
            return f"there is no last pose, and the search for one is not complete: {message_of(answer)}"
        if len(stable) != 1:
            return (
                f"there is no last pose, and {len(stable)} stable ones for these lengths: choose one by reset"
            )
        if self._is_real:
            self._start = stable[0]
        else:
            self._place = place_of(self._body, stable[0])
        return ""

    def _under(self, external_force: Any) -> Load:
        """Return what follows from a force; that of the last one is kept."""
        force: Point = ZERO if external_force is None else read_force_ranges(external_force)
        require_treated(self._robot, scope.refuses(self._robot, force))
        under_load = loaded(self._robot, force)
        if (complaint := no_load(under_load)) is not None:
            raise InputError(complaint)
        key = force_key(ZERO_FORCE if external_force is None else external_force)
        cables = cables_of(under_load)
        bounds = np.ascontiguousarray(cables.load[:, 0])
        self._loaded = Load(key, bounds, cables, force, under_load.load_factor)
        if self._charts is None:
            self._charts = charts_of(cables)
        return self._loaded


ZERO_FORCE = (0.0, 0.0, 0.0)


def reason_of(names: Sequence[str], status: int, cable: int, where: str) -> str:
    """Say why a pose is lost, by the status of `track` and the cable at fault, and where."""
    name = names[cable] if cable >= 0 else ""
    reasons = {
        NO_ROOT: "no pose was found near the last one for these lengths",
        MOVED: f"the pose for these lengths does not lie {where}",
        TIGHT: f"cable {name}, slack in the last pose, may be taut {where}",
        LOOSE: f"cable {name}, taut in the last pose, may be slack {where}",
        SINGULAR: f"the tensions are not bounded {where}: the pose is singular, or one of a family",
        BROAD: f"the poses for all these lengths may not lie {where}",
        FORCED: "the force is not that of the last pose, and no pose is proved to be alone near it",
        GONE: f"no pose is proved to go on {where}: it may end there, or be singular",
        OTHER: f"what goes on from the last pose {where} may be another one",
    }
    return reasons.get(status, f"more than one pose may lie {where}")


STATUSES = {SLACKENS: LOOSE, TIGHTENS: TIGHT, ENDS: GONE}
"""Why a pose on real cables is lost, as a straight one would be."""


def why(names: Sequence[str], fault: Fault, where: str) -> str:
    """Say why a pose on real cables is lost, and where."""
    if fault.status == LIFTS:
        return (
            f"cable {names[fault.cable]} may lift off its pulley {where}, or come too near to it or its axis"
        )
    return reason_of(names, STATUSES[fault.status], fault.cable, where)


def size_of(robot: Robot) -> float:
    """Return a length of a platform in m, in floats."""
    return platform_size(np.array([[float(x) for x in arm] for arm in loaded(robot).arms]))


def hull_of(each: Sequence[Fields], loose: int) -> Fields:
    """Return what one pose reports that has several bounds, in some of them with a cable slack.

    The verdicts on stability look at the cable as if it held in all of them. That is right all the same: such
    poses are followed only where more tension draws the platform nearer (``crossing.one_way``), and there
    the motion that the cable leaves free when it is slack costs energy.
    """
    if len(each) == 1:
        return each[0]
    parts = [
        np.stack([np.minimum(*(x[..., 0] for x in pair)), np.maximum(*(x[..., 1] for x in pair))], axis=-1)
        for pair in zip(*(one[:-1] for one in each), strict=True)
    ]
    first, second = (one.verdicts for one in each)
    fields = Fields._make([*parts, np.where(first == second, first, 0)])
    fields.tensions[:, loose, 0] = 0.0
    return fields


@cache
def plain_frame() -> FrameBounds:
    """Return the robot's own frames in arrays."""
    return Frame.plain().bounds


def fields_of(cables: Cables, chart: int, box: Floats, taut: Ints, lengths: Bounds) -> Fields:
    """Return what a proved pose reports.

    Parameters
    ----------
    cables : Cables
    chart : int
    box : (6 + n, 2)
        u, p, and t of the taut cables; u and p are in the plain frame.
    taut : (n,)
    lengths : (N, 2)
        m.
    """
    count = len(cables.exits)
    fields = Fields(
        np.empty((1, 3, 3, 2)),
        np.empty((1, 3, 2)),
        np.empty((1, 2)),
        np.empty((1, count, 2)),
        np.empty((1, len(taut), 2)),
        np.zeros((1, count, 2)),
        np.empty(1, dtype=np.int64),
    )
    fill_fields(cables, plain_frame(), box[None], np.array([chart]), taut, lengths, fields)
    # Proved positive; wide bounds of six tensions may still reach below zero.
    np.maximum(fields.tensions, 0.0, out=fields.tensions)
    return fields


def metres(name: str, given: float | None, default: float, most: float) -> float:
    """Return a radius in (0, most] m, or the default where None is given."""
    if given is None:
        return default
    if isinstance(given, int | float | np.number) and 0.0 < given <= most:
        return float(given)
    raise InputError(f"{name}: must be positive and at most {most:g} m, got {given!r}")


def charts_of(cables: Cables) -> Floats:
    """Return the bounds of A_i and D_c b_i in every chart, (4, N, 6, 2)."""
    charts = np.empty((4, len(cables.exits), 6, 2))
    charts[:, :, :3] = cables.exits[:, :, 0]
    for c in range(4):
        for k in range(3):
            b = cables.arms[:, k, 0]
            charts[c, :, 3 + k] = b if HALF_TURNS[c, k] > 0.0 else -b[:, ::-1]
    return charts
