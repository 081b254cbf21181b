"""The pose of a platform on pulleys or elastic cables that goes along with its lengths."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from cdpr_interval.engine.budget import Budget
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.robots.cable_robot import Robot
from solvers.answers.data import Solution
from solvers.motions.platform import Lost
from solvers.motions.stretch import Moved, Stretch
from solvers.six_dof.place import is_single
from solvers.six_dof.real.follow import FINEST, Fault, Follower, Leg
from solvers.six_dof.real.leg import HELD
from solvers.six_dof.real.tracking import fields_of
from solvers.six_dof.tracker import why


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
        self._names, self._view, self._follower = robot.cable_names, loaded(robot), Follower(robot)
        fault = self._follower.begin(start, lengths)
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
        stretches = tuple(map(self._stretch, legs))
        if stretches:
            self._here = self._here_now() or replace(stretches[-1], first=1.0)
        return Moved(share, stretches, "" if share == 1.0 else self._reason(fault))

    def _here_now(self) -> Stretch | None:
        """Return where it is for the last lengths, if that is proved apart."""
        leg = self._follower.rest()
        return None if leg is None else self._stretch(leg)

    def _stretch(self, leg: Leg) -> Stretch:
        """Return what a leg says of a part of the way."""
        found = fields_of(self._view, leg)
        taut = tuple(sorted(i for i in leg.taut if i != leg.open))
        switching = (leg.open,) if leg.open >= 0 else ()
        place = found.position[0], found.rotation[0], found.tensions[0]
        return Stretch(leg.first, leg.last, taut, switching, *place)

    def _reason(self, fault: Fault) -> str:
        """Return why the pose goes no further, one sentence."""
        return "the budget is over" if fault.status == HELD else why(self._names, fault, "there")
