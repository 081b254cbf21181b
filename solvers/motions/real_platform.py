"""The pose of a platform on pulleys or elastic cables that goes along with its lengths."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from cdpr_interval.engine.budget import Budget
from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.kernels import interval
from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.mechanics.six_dof.frame import Frame
from cdpr_interval.robots.cable_robot import Robot
from solvers.answers.data import Solution
from solvers.motions.platform import Lost
from solvers.motions.stretch import Moved, Stretch
from solvers.six_dof.cells.roots import Root, pose_of
from solvers.six_dof.place import is_single
from solvers.six_dof.real.follow import FINEST, Fault, Follower, Leg
from solvers.six_dof.real.leg import ENDS, HELD, LIFTS, SLACKENS, TIGHTENS
from solvers.six_dof.solution import origin
from solvers.six_dof.track import GONE, LOOSE, TIGHT
from solvers.six_dof.tracker import reason_of

STATUSES = {SLACKENS: LOOSE, TIGHTENS: TIGHT, ENDS: GONE}


class RealPlatformMover:
    """See `solvers.motions.stretch.Mover`; the pose begins as a solution for lengths (N, 2), m.

    That it is the solution, not another one near by, is proved here.

    Raises
    ------
    Lost
        The start is not one pose with every cable proved taut or slack, or is not proved for all the lengths.
    """

    finest = FINEST

    def __init__(self, robot: Robot, start: Solution, lengths: Bounds) -> None:
        if not is_single(start):
            raise Lost("it is one of a family, or a cable is only just taut or slack")
        self._robot, self._follower = robot, Follower(robot)
        with balls.precision():
            turn = balls.matrix(start.rotation)
            centre = balls.column(start.position) + turn * balls.ranges(loaded(robot).centre_ranges)
        fault = self._follower.begin(start.rotation, centre, start.tensions, start.taut, lengths)
        if fault.status != HELD:
            raise Lost(self._reason(fault))
        here = self._here_now()
        assert here is not None
        self._here = here

    @property
    def here(self) -> Stretch:
        """Where it is now, for the last lengths."""
        return self._here

    def mark(self) -> object:
        """Return None: a shorter way would not help."""
        return None

    def back_to(self, place: Any) -> None:
        """Do nothing: there are no marks."""

    def go(self, lengths: Bounds, budget: Budget | None = None) -> Moved:
        """Follow the pose while the lengths go straight to new ones (N, 2), m, as far as that is proved."""
        share, legs, fault = self._follower.go(lengths, budget)
        with balls.precision():
            stretches = tuple(self._stretch(leg) for leg in legs)
        if stretches:
            self._here = self._here_now() or replace(stretches[-1], first=1.0)
        return Moved(share, stretches, "" if share == 1.0 else self._reason(fault))

    def _here_now(self) -> Stretch | None:
        """Return where it is for the last lengths, if that is proved apart."""
        leg = self._follower.rest()
        if leg is None:
            return None
        with balls.precision():
            return self._stretch(leg)

    def _stretch(self, leg: Leg) -> Stretch:
        """Return what a leg says of a part of the way."""
        pose = pose_of(Root(leg.chart, leg.box, leg.box, leg.box), Frame.plain())
        tensions = np.zeros((len(self._robot.cables), 2))
        for j, i in enumerate(leg.taut):
            lo, hi = leg.box[6 + j].tolist()
            tensions[i] = interval.mul(max(lo, 0.0), max(hi, 0.0), *leg.free[j].tolist())
        tensions[:, 0] = np.maximum(tensions[:, 0], 0.0)
        return Stretch(
            leg.first,
            leg.last,
            tuple(sorted(i for i in leg.taut if i != leg.open)),
            (leg.open,) if leg.open >= 0 else (),
            balls.bounds_array(origin(self._robot, pose)),
            np.clip(balls.bounds_array(pose.rotation), -1.0, 1.0).reshape(3, 3, 2),
            tensions,
        )

    def _reason(self, fault: Fault) -> str:
        """Return why the pose goes no further, one sentence."""
        if fault.status == HELD:
            return "the budget is over"
        name = self._robot.cable_names[fault.cable] if fault.cable >= 0 else ""
        if fault.status == LIFTS:
            return f"cable {name} may lift off its pulley there, or come too near to it or its axis"
        return reason_of(self._robot.cable_names, STATUSES[fault.status], fault.cable, "there")
