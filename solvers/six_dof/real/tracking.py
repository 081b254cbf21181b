"""A pose on real cables from call to call of a tracker: begun at a solution, followed, and reported."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.kernels import interval
from cdpr_interval.mechanics.loaded import LoadedRobot
from cdpr_interval.mechanics.six_dof.fields import OPEN, STABLE, UNSTABLE, Fields
from cdpr_interval.mechanics.six_dof.frame import centred_cayley, half_turn
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import Point
from solvers.answers.data import Solution
from solvers.six_dof.real.follow import Fault, Follower, Known, Leg
from solvers.six_dof.real.leg import ENDS, HELD

MOST_LEGS = 256
"""Tried on one way: a bound of the time a call takes."""
SLACK_AT_START = 1.0 + 1e-6
"""Least length of a slack cable at a start, over its distance there."""
VERDICTS = {Stability.STABLE: STABLE, Stability.UNSTABLE: UNSTABLE, Stability.UNDECIDED: OPEN}


@dataclass(frozen=True, eq=False)
class Followed:
    """What came of a call."""

    fault: Fault
    share: float = 0.0
    """Of the way that is proved."""
    legs: Sequence[Leg] = ()
    here: Leg | None = None
    """Where the pose is now, with ``fault`` HELD."""


class Tracking:
    """One pose of a robot under one force."""

    def __init__(
        self, robot: Robot, force: Point, start: Solution, judge: Callable[[Known], Stability]
    ) -> None:
        """Keep what it needs; ``judge`` says whether a pose of this robot under this force is stable."""
        self.force, self._judge = force, judge
        self.verdict = OPEN
        """Where no proof fails the statics are regular, and the energy's inertia stays what it was."""
        self._follower = Follower(robot, force)
        self._start: Solution | None = start

    @property
    def has_begun(self) -> bool:
        """Whether the pose has been found at all."""
        return self._start is None

    @property
    def loaded(self) -> LoadedRobot:
        """The robot under the force."""
        return self._follower.cables.loaded

    def update(self, lengths: Bounds) -> Followed:
        """Follow the pose to new lengths (N, 2), m; where that is not proved it stays where it was."""
        follower = self._follower
        if self._start is not None:
            fault = self._begin(self._start, lengths)
            if fault.status != HELD:
                return Followed(fault)
            assert follower.known is not None
            # Whatever robot and force the start was solved for.
            self._start, self.verdict = None, VERDICTS[self._judge(follower.known)]
        before = follower.known, follower.lengths
        try:
            share, legs, fault = follower.go(lengths, most=MOST_LEGS)
            here = follower.rest() if share == 1.0 else None
        except BaseException:
            # Interrupted on the way: the pose is not where any lengths say.
            follower.known, follower.lengths = before
            raise
        if here is None:
            follower.known, follower.lengths = before
            return Followed(fault if fault.status != HELD else Fault(ENDS), share, legs)
        return Followed(Fault(HELD), 1.0, legs, here)

    def fields(self, leg: Leg) -> Fields:
        """Return what a leg reports."""
        return fields_of(self.loaded, leg, self.verdict)

    def _begin(self, start: Solution, lengths: Bounds) -> Fault:
        """Start where the taut cables are as long as they are at the start, slack ones as they are to be."""
        view = self.loaded
        own = np.maximum(lengths, SLACK_AT_START * start.distances)
        with balls.precision():
            for i in start.taut:
                reach, tension = (
                    balls.from_bounds(*x[i].tolist()) for x in (start.distances, start.tensions)
                )
                own[i] = balls.to_bounds(view.models[i].law.unstretched(reach, tension, balls.from_fraction))
        return self._follower.begin(start, own)


def fields_of(view: LoadedRobot, leg: Leg, verdict: int = OPEN) -> Fields:
    """Return what a leg reports: bounds of pose, distances and tensions for all its lengths."""
    count, n = len(view.models), len(leg.taut)
    tensions, distances = np.zeros((1, count, 2)), np.empty((1, count, 2))
    order = (*leg.taut, *(i for i in range(count) if i not in leg.taut))
    for j, i in enumerate(order):
        distances[0, i] = leg.spans[j, 2:]
        if j < n:
            lo, hi = leg.box[6 + j].tolist()
            tensions[0, i] = interval.mul(max(lo, 0.0), max(hi, 0.0), *leg.spans[j, :2].tolist())
    if leg.open >= 0:
        tensions[0, leg.open, 0] = 0.0
    with balls.precision():
        u = [balls.from_bounds(*pair) for pair in leg.box[:3].tolist()]
        rotation, centre = centred_cayley(u) * half_turn(leg.chart), balls.column(leg.box[3:6])
        origin = centre - rotation * balls.ranges(view.centre_ranges)
        g = balls.ranges(view.gravity_ranges)
        height = balls.to_bounds(balls.dot(centre, g) * (-1 / balls.norm(g)))
        turn = np.clip(balls.bounds_array(rotation), -1.0, 1.0).reshape(1, 3, 3, 2)
        position = balls.bounds_array(origin)[None]
    return Fields(
        turn,
        position,
        np.array([height]),
        distances,
        leg.box[None, 6:],
        np.maximum(tensions, 0.0),
        np.array([verdict]),
    )
