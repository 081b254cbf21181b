"""One winch while it runs: its reading, its reference, its target, and the gate every target must pass."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise

from cdpr_interval.driver.bus import PROBE_ARMED, PROBE_CAUGHT, PROBE_ENABLED, PROBE_OFF, Feedback
from cdpr_interval.driver.counter import nearest, wrapped
from cdpr_interval.driver.drum import OffTheDrum
from cdpr_interval.driver.marks import MarkEvent, MarkWatch
from cdpr_interval.driver.reference import Known, Reference, ReferenceState, home
from cdpr_interval.driver.violation import OVERSPEED, Interlock, Stopped, Violation
from cdpr_interval.driver.winch import WinchModel
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.winch import Winch, WinchLimits

ZERO = Fraction(0)
SPEED_CYCLES = 5
"""Cycles over which the speed is measured, so that a late answer is no jump."""
CORRECTION_SHARE = Fraction(1, 10)
"""Of the acceleration limit, for working off the correction of a mark: a caller must leave as much."""


@dataclass
class Axis:
    """The winch of one cable.

    ``counts`` and ``target`` are unwrapped readings. While the target moves, ``applied`` is the offset
    between the lengths asked for and the model's; a mark changes the reference's offset at once, ``applied``
    follows slowly, so that no target jumps.
    """

    name: str
    winch: Winch
    cycle: Fraction
    """s."""
    correction_rate: Fraction
    """m/s."""
    model: WinchModel = field(init=False)
    reference: Reference | None = None
    state: ReferenceState = ReferenceState.UNREFERENCED
    counts: int = 0
    target: int = 0
    applied: Fraction = ZERO
    window: tuple[Fraction, Fraction] | None = None
    """m: the way of a jog without reference; None: the limits of the file hold."""
    last_step: Fraction = ZERO
    """m that the target moved in the last cycle."""
    watch: MarkWatch | None = field(init=False, default=None)
    _history: deque[int] = field(init=False)
    _probe: int = PROBE_OFF
    _correction: Fraction = ZERO
    _known: tuple[tuple[Reference, int], Fraction | None] | None = None
    """The last reading whose length was asked for, and the length."""

    def __post_init__(self) -> None:
        """Take the file's data; without a reference, the model's zero is anywhere on the drum."""
        self.model = WinchModel(self.winch)
        self._history = deque(maxlen=SPEED_CYCLES + 1)
        if self.winch.sensor is not None:
            self.watch = MarkWatch(self.winch.sensor, Fraction(OVERSPEED) * self.winch.limits.velocity)

    @property
    def limits(self) -> WinchLimits:
        """What the winch may do."""
        return self.winch.limits

    def start(self, heard: Feedback) -> None:
        """Take the first reading after connecting: the nearest to the last one that is known.

        A drive that has lost its position, or was moved without anybody watching, degrades its cable.
        """
        before, self.counts = self.counts, nearest(heard.position, self.counts)
        moved = abs((self.counts - before) * self._rate)
        if self.state is ReferenceState.REFERENCED and moved > self.limits.following_error:
            self.state = ReferenceState.DEGRADED
        self.target = self.counts
        self._history.clear()
        if self.reference is None:
            low, high = self.limits.length
            self.model = self.model.placed(self.counts, (low + high) / 2)

    def take(self, heard: Feedback) -> list[MarkEvent]:
        """Take the reading of a cycle; return what marks said."""
        self.counts = nearest(heard.position, self.counts)
        self._history.append(self.counts)
        if self.watch is None or self.reference is None or self.state is not ReferenceState.REFERENCED:
            self._probe = PROBE_OFF
            return []
        events = self._caught(heard)
        missed = self.watch.missed(self.reference, self.counts)
        return [*events, *([self._degraded(missed)] if missed is not None else [])]

    def _caught(self, heard: Feedback) -> list[MarkEvent]:
        """Read the touch probe: armed until it caught something, then off until the drive saw that."""
        assert self.watch is not None and self.reference is not None
        if self._probe == PROBE_OFF:
            self._probe = PROBE_OFF if heard.probe & PROBE_ENABLED else PROBE_ARMED
            return []
        if not heard.probe & PROBE_CAUGHT:
            return []
        self._probe = PROBE_OFF
        event = self.watch.seen(self.reference, nearest(heard.probe_position, self.counts), self._direction)
        if not event.accepted:
            return [self._degraded(event)]
        self.reference = event.reference
        return [event]

    def _degraded(self, event: MarkEvent) -> MarkEvent:
        assert self.watch is not None
        self.state = ReferenceState.DEGRADED
        self.watch.forget()
        return event

    @property
    def probe(self) -> int:
        """The touch probe function to send."""
        return self._probe

    @property
    def _direction(self) -> int:
        """+1 paying out, -1 winding in, 0 unknown: the cable turned back, or rested, in the last cycles."""
        signs = {(b > a) - (b < a) for a, b in pairwise(self._history)}
        return self.winch.sign * signs.pop() if len(signs) == 1 else 0

    @property
    def speed(self) -> float:
        """m/s, measured over the last cycles; positive paying out."""
        if len(self._history) < self._history.maxlen:  # type: ignore[operator]
            return 0.0
        seconds = (len(self._history) - 1) * float(self.cycle)
        return (self._history[-1] - self._history[0]) * self._rate / seconds

    @property
    def _rate(self) -> float:
        """M a count, signed, here."""
        return self.model.nominal_rate(self.counts)

    @property
    def following_error(self) -> float:
        """M from the reading to the target."""
        return (self.target - self.counts) * self._rate

    def set_home(self, length: Range) -> None:
        """Let the present reading be a length that was measured."""
        self.reference = home(self.model, self.counts, length)
        self.model = self.reference.model
        self.state = ReferenceState.REFERENCED
        if self.watch is not None:
            self.watch.forget()

    def adopt(self, known: Known) -> None:
        """Take over what was known before."""
        self.reference, self.model, self.state = known.reference, known.reference.model, known.state
        self.counts = known.reading

    @property
    def length(self) -> Fraction | None:
        """The most likely length in m at the reading; None without a reference or off the drum."""
        return self.length_at(self.counts)

    def length_at(self, counts: int) -> Fraction | None:
        """Return the most likely length in m at a reading; None without a reference or off the drum."""
        if self.reference is None:
            return None
        key = (self.reference, counts)
        if self._known is None or self._known[0][1] != counts or self._known[0][0] is not self.reference:
            try:
                self._known = (key, self.reference.nominal(counts))
            except OffTheDrum:
                self._known = (key, None)
        return self._known[1]

    @property
    def has_left_the_drum(self) -> bool:
        """True when the reading is a place where the drum's law has no length."""
        return self.reference is not None and self.length is None

    def within_limits(self, length: Fraction, margin: Fraction = ZERO) -> bool:
        """Return whether a length in m is within the file's limits, widened by a margin."""
        low, high = self.limits.length
        return low - margin <= length <= high + margin

    @property
    def commanded(self) -> Fraction:
        """m: the length that the target stands for; without a reference only differences mean anything."""
        offset = ZERO if self.reference is None else self.reference.offset
        return self.model.length(self.target) + offset

    def follow_reading(self) -> None:
        """Let the target be the reading, or the nearest place within the limits: drives have no torque."""
        self.target = self.counts
        length = self.length
        if length is not None and not self.within_limits(length):
            low, high = self.limits.length
            nearest_length = low if length < low else high
            assert self.reference is not None
            self.target = self.model.counts(nearest_length - self.reference.offset)
        self.last_step = ZERO

    def begin(self) -> None:
        """Begin to move: the length asked for is the commanded one."""
        self.applied = ZERO if self.reference is None else self.reference.offset
        self._correction = ZERO
        self.last_step = ZERO

    def correct(self) -> bool:
        """Let ``applied`` follow the reference's offset by one cycle; return whether it has arrived."""
        if self.reference is None or self.applied == self.reference.offset:
            self._correction = ZERO
            return True
        left = self.reference.offset - self.applied
        gain = CORRECTION_SHARE * self.limits.acceleration * self.cycle
        # Slower at the end: v^2 / 2a is the way it takes to come to rest.
        braking = Fraction((2 * float(gain / self.cycle) * abs(float(left))) ** 0.5)
        speed = min(abs(self._correction) + gain, self.correction_rate, braking)
        step = speed * self.cycle
        quantum = abs(Fraction(self._rate))
        if abs(left) <= max(step, quantum):
            self.applied, self._correction = self.reference.offset, ZERO
            return True
        self._correction = speed
        # Short numbers: a correction is a float's worth of a metre.
        self.applied += Fraction(float(step if left > 0 else -step))
        return False

    def aim(self, length: float) -> None:
        """Let the target be a length in m, asked for before corrections; `Stopped` when the gate is shut."""
        try:
            target = self.model.counts(Fraction(length) - self.applied)
            step = self.model.length(target) - self.model.length(self.target)
            asked = self.model.length(target) + (ZERO if self.reference is None else self.reference.offset)
        except OffTheDrum as error:
            raise Stopped(Violation(Interlock.LENGTH, f"target {error}", self.name)) from None
        self._gate(asked, step)
        self.target, self.last_step = target, step

    def _gate(self, length: Fraction, step: Fraction) -> None:
        """Raise `Stopped` when a target must not leave: beyond a limit, too far, or too abruptly."""
        cycle, limits = self.cycle, self.limits
        quantum = abs(Fraction(self.model.nominal_rate(self.target)))
        low, high = self.window or limits.length
        if not low <= length <= high:
            text = f"target {float(length):.5f} m, limits {float(low):.5f} to {float(high):.5f} m"
            raise Stopped(Violation(Interlock.LENGTH, text, self.name))
        if abs(step) > limits.velocity * cycle + quantum:
            text = f"target moves at {float(step / cycle):+.4f} m/s, limit {float(limits.velocity):.4f} m/s"
            raise Stopped(Violation(Interlock.VELOCITY, text, self.name))
        change = step - self.last_step
        most = limits.acceleration * cycle**2 + 2 * quantum
        if abs(change) > most:
            got, limit = float(change / cycle**2), float(limits.acceleration)
            text = f"target accelerates by {got:+.3f} m/s2, limit {limit:.3f} m/s2"
            raise Stopped(Violation(Interlock.ACCELERATION, text, self.name))
        speed = (step + change / 2) / cycle
        rest = length + speed * abs(speed) / (2 * limits.acceleration)
        slack = 4 * quantum + limits.acceleration * cycle**2 / 10
        if not low - slack <= rest <= high + slack:
            text = f"cannot stop before {float(rest):.5f} m, limits {float(low):.5f} to {float(high):.5f} m"
            raise Stopped(Violation(Interlock.LENGTH, text, self.name))

    @property
    def wire_target(self) -> int:
        """The target as sent."""
        return wrapped(self.target)
