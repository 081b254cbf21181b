"""Marks on a cable: which one was seen, whether that can be, and what it says about length and drum.

A mark is identified by the predicted length only where no other could be meant; and it must then lie in the
range that follows from the last reference. Everything else (slip, a wrong layer, a mark seen twice or not at
all) contradicts the data and makes the cable DEGRADED: nothing is guessed.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

from cdpr_interval.driver.reference import Reference
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.winch import Mark, MarkSensor

ZERO = Fraction(0)
GRACE_CYCLES = 3
"""Cycles after a mark must have passed before it counts as missed: drives answer a cycle later."""


@dataclass(frozen=True)
class MarkEvent:
    """What became of one sighting, or of one mark that was not seen."""

    mark: str | None
    """The mark identified; None: none could be."""
    counts: int
    """The latched reading, unwrapped."""
    predicted: Range
    """The length in m expected at that reading."""
    reference: Reference | None
    """The new reference; None: refused."""
    reason: str
    """Why it was refused; empty when accepted."""
    metres_per_turn: Range | None = None
    """Of the drum between this mark and the last; None where there is no last one."""

    @property
    def accepted(self) -> bool:
        """True when the cable's length now rests on this mark."""
        return self.reference is not None

    @property
    def correction(self) -> Fraction | None:
        """Return by how much the nominal length changed, in m; None when refused."""
        return None if self.reference is None else self.reference.length.mid - self.predicted.mid

    def to_json(self) -> dict[str, Any]:
        """Return plain data for a log."""
        correction, turn = self.correction, self.metres_per_turn
        return {
            "mark": self.mark,
            "counts": self.counts,
            "predicted_m": [float(self.predicted.lo), float(self.predicted.hi)],
            "accepted": self.accepted,
            "reason": self.reason,
            "correction_m": None if correction is None else float(correction),
            "metres_per_turn": None if turn is None else [float(turn.lo), float(turn.hi)],
        }


def length_at(sensor: MarkSensor, mark: Mark, direction: int, speed: Fraction) -> Range:
    """Return bounds of the length in m at the reading latched when a mark passes the sensor.

    Parameters
    ----------
    sensor, mark
        As in the robot file.
    direction : int
        +1 paying out, -1 winding in, 0 unknown.
    speed : Fraction
        m/s, bound of the cable's speed.
    """
    late = speed * sensor.latency
    sides = [side for side in (-1, 1) if direction in (0, side)]
    places = [side * sensor.hysteresis / 2 for side in sides]
    early = min(places) - (late if -1 in sides else ZERO)
    last = max(places) + (late if 1 in sides else ZERO)
    return Range(mark.distance.lo - sensor.offset + early, mark.distance.hi - sensor.offset + last)


@dataclass
class MarkWatch:
    """Watches the marks of one cable while it moves."""

    sensor: MarkSensor
    speed: Fraction
    """m/s, bound of the cable's speed."""
    last: tuple[Range, Reference] | None = None
    """The last accepted mark: its length, and the reference made of it."""
    _sides: dict[int, int] = field(default_factory=dict)
    """-1, +1: the cable was last known to be shorter, longer than at the mark."""
    _overdue: dict[int, int] = field(default_factory=dict)
    """Cycles since a mark must have passed unseen."""
    _place: tuple[int, int] = (-1, -1)
    """How many marks have been passed certainly, and possibly, in the last cycle."""

    def seen(self, reference: Reference, counts: int, direction: int) -> MarkEvent:
        """Return what a sighting at a latched reading means."""
        predicted = reference.length_range(counts)
        mark, reason = self._identified(predicted, direction)
        if mark is None:
            return MarkEvent(None, counts, predicted, None, reason)
        length = length_at(self.sensor, mark, direction, self.speed)
        if not length.meets(predicted):
            away = float(max(length.lo - predicted.hi, predicted.lo - length.hi))
            reason = f"mark {mark.name} is {away:.6f} m outside the range predicted for it"
            return MarkEvent(mark.name, counts, predicted, None, reason)
        # A mark that is known less well than the cable confirms it, and that is all.
        known = predicted.width <= length.width
        found = Reference(reference.model, counts, predicted if known else length, f"mark {mark.name}")
        event = MarkEvent(mark.name, counts, predicted, found, "", self._metres_per_turn(found))
        self.last = (length, found)
        number = self.sensor.marks.index(mark)
        self._sides.pop(number, None)
        self._overdue.pop(number, None)
        self._place = (-1, -1)
        return event

    def missed(self, reference: Reference, counts: int) -> MarkEvent | None:
        """Return the mark that must have passed unseen until this reading; call it once a cycle."""
        predicted = reference.length_range(counts)
        passed = bisect_left(self._latest, predicted.lo)
        reached = bisect_right(self._earliest, predicted.hi)
        if (passed, reached) != self._place:
            self._place = (passed, reached)
            self._take_sides(passed, reached)
        for mark in sorted(self._overdue):
            self._overdue[mark] += 1
            if self._overdue[mark] > GRACE_CYCLES:
                name = self.sensor.marks[mark].name
                self.forget()
                return MarkEvent(name, counts, predicted, None, f"mark {name} passed unseen")
        return None

    def _take_sides(self, passed: int, reached: int) -> None:
        """Note which marks the cable has certainly passed (the first) or not reached (the last)."""
        for mark in range(len(self.sensor.marks)):
            side = 1 if mark < passed else -1 if mark >= reached else 0
            before = self._sides.get(mark, 0)
            if side == 0:
                continue
            if before == -side:
                self._overdue.setdefault(mark, 0)
            else:
                self._overdue.pop(mark, None)
                self._sides[mark] = side

    def forget(self) -> None:
        """Start anew: after a new home, or when the cable is degraded."""
        self.last = None
        self._sides.clear()
        self._overdue.clear()
        self._place = (-1, -1)

    @cached_property
    def _earliest(self) -> list[Fraction]:
        """Least lengths at which each mark may be seen, ascending."""
        return [length_at(self.sensor, mark, 0, self.speed).lo for mark in self.sensor.marks]

    @cached_property
    def _latest(self) -> list[Fraction]:
        """Largest lengths at which each mark may be seen, ascending."""
        return [length_at(self.sensor, mark, 0, self.speed).hi for mark in self.sensor.marks]

    def _identified(self, predicted: Range, direction: int) -> tuple[Mark | None, str]:
        """Return the only mark that can be meant, or why there is none.

        A mark may be meant when the length expected for it is nearer to the predicted one than half the way
        to its neighbours, whatever the true length in the predicted range.
        """
        near = sorted(
            self.sensor.marks,
            key=lambda mark: abs(length_at(self.sensor, mark, direction, self.speed).mid - predicted.mid),
        )
        best = length_at(self.sensor, near[0], direction, self.speed)
        innovation = abs(best.mid - predicted.mid)
        error = (predicted.width + best.width) / 2
        spacing = min(
            (abs(length_at(self.sensor, other, direction, self.speed).mid - best.mid) for other in near[1:]),
            default=None,
        )
        if spacing is not None and innovation >= spacing / 2 - error:
            text = ", ".join(
                f"{name} {float(value):.6f} m"
                for name, value in (("innovation", innovation), ("error", error), ("spacing", spacing))
            )
            return None, f"cannot say which mark was seen ({text})"
        return near[0], ""

    def _metres_per_turn(self, found: Reference) -> Range | None:
        """Return what the drum paid out a turn since the last mark; None without one, or too near."""
        if self.last is None:
            return None
        length, before = self.last
        model = found.model
        turns = model.turns_range(found.counts) - model.turns_range(before.counts)
        if 0 in turns or found.source == before.source:
            return None
        inverse = Range(1 / turns.hi, 1 / turns.lo)
        return (found.length - length) * inverse
