"""A platform's pose that goes along with its lengths, through cables that become slack or taut."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from cdpr_interval.engine.budget import Budget
from cdpr_interval.errors import CdprError
from cdpr_interval.exact.enclosure import Bounds, length_bounds
from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.mechanics.rotation import chart_of, quaternion_of
from cdpr_interval.robots.cable_robot import Robot
from solvers.answers.data import Solution
from solvers.motions.stretch import Moved, Stretch, lengths_on
from solvers.six_dof.estimate import Body
from solvers.six_dof.place import is_single, known_at, place_of
from solvers.six_dof.prepared import cables_of
from solvers.six_dof.track import GONE, TRACKED
from solvers.six_dof.tracker import CHART_END, charts_of, fields_of, reason_of
from solvers.six_dof.way import Known, Noted, Way


class Lost(CdprError):
    """The pose cannot be followed from its start."""


class PlatformMover:
    """See `solvers.motions.stretch.Mover`; the pose begins as a solution for lengths (N, 2), m.

    Raises
    ------
    Lost
        The start is not one pose with every cable proved taut or slack, or is not proved for all the lengths.
    """

    finest = 1.0

    def __init__(self, robot: Robot, start: Solution, lengths: Bounds) -> None:
        if not is_single(start):
            raise Lost("it is one of a family, or a cable is only just taut or slack")
        view, body = loaded(robot), Body(robot)
        place = place_of(body, start)
        self._names, self._chart = robot.cable_names, place.chart
        self._cables, self._factor = cables_of(view), length_bounds([view.load_factor])[0]
        self._charts = charts_of(self._cables)
        self._load = np.ascontiguousarray(self._cables.load[:, 0])
        self._way = Way(
            robot, known_at(body, place, self._charts[self._chart], lengths, self._load), body.size
        )
        self._here: Stretch | None = None
        if reason := self.go(lengths).reason:
            raise Lost(reason)

    @property
    def here(self) -> Stretch:
        """Where it is now, for the last lengths."""
        assert self._here is not None
        return self._here

    def mark(self) -> object:
        """Return what `back_to` takes."""
        return replace(self._way.known), self._chart, self._here

    def back_to(self, place: Any) -> None:
        """Be again where and how the pose was at a mark."""
        self._way.known, self._chart, self._here = place

    def go(self, lengths: Bounds, budget: Budget | None = None) -> Moved:
        """Follow the pose to new lengths (N, 2), m; that takes milliseconds, whatever the ``budget``."""
        notes: list[Noted] = []
        before = self._way.known.lengths
        arrived = self._way.go(self._chart, self._charts[self._chart], self._load, lengths, notes)
        if arrived.status != TRACKED:
            return Moved(0.0, (), reason_of(self._names, arrived.status, arrived.cable, "there"))
        assert arrived.known is not None
        taut = arrived.known.taut
        if arrived.open >= 0:
            taut = (*(i for i in taut if i != arrived.open), arrived.open)
        notes.append(Noted(1.0, 1.0, taut, arrived.boxes, arrived.open))
        *stretches, here = (self._stretch(note, before, lengths) for note in notes)
        if not np.isfinite(here.position).all():
            return Moved(0.0, (), reason_of(self._names, GONE, -1, "there"))
        self._way.arrive(arrived)
        if arrived.open < 0:
            _pin(arrived.known, arrived.boxes[0])
        self._turn_chart()
        self._here = here
        return Moved(1.0, tuple(stretches), "")

    def _stretch(self, note: Noted, before: Bounds, after: Bounds) -> Stretch:
        """Return what a part of a way proves of the pose."""
        lengths = lengths_on(before, after, note.first, note.last)
        found = [self._of_box(note, box, lengths) for box in note.boxes]
        return found[0] if len(found) == 1 else found[0].joined(found[1])

    def _of_box(self, note: Noted, box: Bounds, lengths: Bounds) -> Stretch:
        fields = fields_of(self._cables, self._chart, box, np.array(note.taut), lengths)
        tensions = np.zeros((len(lengths), 2))
        for i, density in zip(note.taut, box[6:], strict=False):
            # Its own bounds of the densities: those of six cables were computed from the pose.
            low, high = np.maximum(density, 0.0) * lengths[i] * self._factor
            # Rounded twice above.
            tensions[i] = _next(_next(low, 0.0), 0.0), _next(_next(high, np.inf), np.inf)
        taut = tuple(sorted(i for i in note.taut if i != note.open))
        switching = (note.open,) if note.open >= 0 else ()
        return Stretch(
            note.first, note.last, taut, switching, fields.position[0], fields.rotation[0], tensions
        )

    def _turn_chart(self) -> None:
        """Take another chart where u is too large."""
        z = self._way.known.z
        if max(map(abs, z[:3].tolist())) <= CHART_END:
            return
        before = self._chart
        self._chart, _ = chart_of(quaternion_of(before, z))
        self._way.turn_chart(before, self._chart)


_next = np.nextafter


def _pin(known: Known, box: Bounds) -> None:
    """Let a pose be known as well as its box (6 + n, 2) says, each unknown where that is better.

    The zero for the middles of the lengths lies in the box, too. What is known better goes nearer to a fold.
    """
    chosen = np.array([*range(6), *(6 + i for i in known.taut)])
    middle = 0.5 * box[:, 0] + 0.5 * box[:, 1]
    radii = np.nextafter(np.maximum(box[:, 1] - middle, middle - box[:, 0]), np.inf)
    better = radii < known.radii[chosen]
    known.zero[chosen[better]], known.radii[chosen[better]] = middle[better], radii[better]
