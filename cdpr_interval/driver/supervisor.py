"""The supervisor: one cycle for all winches - send, listen, check, decide - and the latch that stops them.

Whatever goes wrong, an exception included, ends the same way: quick stop to every drive in the same
cycle, the cause latched, and no way back to motion but `acknowledge`. Nothing here waits and nothing needs
a thread; the cycle is called by one (`cyclic`), or by a test with a simulated clock.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from cdpr_interval.driver import cia402, interlocks, requests, sequences
from cdpr_interval.driver.axis import Axis
from cdpr_interval.driver.bus import Command, DriveBus, Feedback
from cdpr_interval.driver.cia402 import Mode
from cdpr_interval.driver.marks import MarkEvent
from cdpr_interval.driver.reference import Known, ReferenceState
from cdpr_interval.driver.requests import Refused
from cdpr_interval.driver.setpoints import Slowing, Stream
from cdpr_interval.driver.snapshot import GroupState, Snapshot, pictured
from cdpr_interval.driver.violation import Interlock, Stopped, Violation
from cdpr_interval.errors import InputError
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.text.count import counted

SLEW = 1e-3
"""Share of a cycle by which the clock of the path may differ from the one of the bus, to meet it."""
_ENABLED = (GroupState.HOLDING, GroupState.MOVING)
_AUTOMATIC = (ReferenceState.REFERENCED,)

Listener = Callable[[str, dict[str, Any]], None]
"""Called with the kind of an event and its data."""


class Supervisor:
    """All winches of one robot, all or nothing.

    `cycle` and `abandon` belong to one thread; everything else may be called from any.

    Parameters
    ----------
    robot : Robot
        Every cable with a winch.
    bus : DriveBus
        Drives in the order of the cables.
    listener : callable, optional
        Told of every event: state changes, stops, marks, homes. Called in the cycle: it must be quick.

    Raises
    ------
    InputError
        When a cable has no winch, or the bus another number of drives.
    """

    def __init__(self, robot: Robot, bus: DriveBus, listener: Listener | None = None) -> None:
        without = [cable.name for cable in robot.cables if cable.winch is None]
        if without:
            raise InputError(f"robot '{robot.name}': no winch for {', '.join(without)}")
        if bus.count != len(robot.cables):
            cables, drives = counted(len(robot.cables), "cable"), counted(bus.count, "drive")
            raise InputError(f"robot '{robot.name}' has {cables}, the bus {drives}")
        self.robot, self.bus, self.settings = robot, bus, robot.winches
        self.axes = [
            Axis(cable.name, cable.winch, self.settings.cycle, self.settings.correction_rate)
            for cable in robot.cables
            if cable.winch is not None
        ]
        self._tell: Listener = listener or (lambda kind, data: None)
        self._lock = threading.Lock()
        self._state = GroupState.OFF
        self._causes: list[Violation] = []
        self._heard: tuple[Feedback, ...] = tuple(Feedback() for _ in self.axes)
        self._path: Stream | Slowing | None = None
        self._manual = False
        self._deadline = 0.0
        self._decided_at = 0.0
        self._path_time = 0.0
        self._cycle = 0
        self._marks: list[MarkEvent] = []
        self._next: list[Command] = []
        self._snapshot = self._picture()

    @property
    def snapshot(self) -> Snapshot:
        """What is known after the last cycle."""
        return self._snapshot

    @property
    def period(self) -> float:
        """S between two cycles."""
        return float(self.settings.cycle)

    def require_connectable(self) -> None:
        """Raise `Refused` while drives are enabled: `connect` takes time in which nobody would watch them."""
        with self._lock:
            self._require(GroupState.OFF, GroupState.DISABLED, GroupState.STOPPED)

    def connect(self) -> None:
        """Connect the bus; the drives stay disabled. `BusError` lists what is missing, and all is off then.

        A bus that is connected already is configured anew: what it was cannot be kept when that fails.
        References and causes of a stop are kept in any case.
        """
        with self._lock:
            self._require(GroupState.OFF, GroupState.DISABLED, GroupState.STOPPED)
            try:
                self.bus.connect()
                first = self._first_feedback()
            except BaseException:
                self._leave()
                raise
            for axis, heard in zip(self.axes, first, strict=True):
                axis.start(heard)
            self._heard = first
            self._set(GroupState.STOPPED if self._causes else GroupState.DISABLED)
            self._decided_at = self.bus.now()
            self._next = self._idle(cia402.QUICK_STOP if self._causes else cia402.DISABLE_VOLTAGE)
            self._snapshot = self._picture()

    def _leave(self) -> None:
        """Leave the bus: nothing is heard any more, and no cycle does anything until `connect` succeeds."""
        self.bus.close()
        self._heard = tuple(Feedback() for _ in self.axes)
        self._set(GroupState.OFF)
        self._snapshot = self._picture()

    def _first_feedback(self) -> tuple[Feedback, ...]:
        """Let drives answer before anything is sent: their targets must be where they are."""
        start = self.bus.now()
        while True:
            self.bus.write_all(())
            heard = self.bus.read_all()
            missing = [axis.name for axis, one in zip(self.axes, heard, strict=True) if one.heard_at is None]
            if not missing:
                return heard
            if self.bus.now() - start > sequences.ENABLE_TIME:
                raise Refused(f"no process data from {', '.join(missing)}")

    def enable(self) -> None:
        """Let the drives hold where they are; all of them, or none."""
        with self._lock:
            self._require_free()
            self._require(GroupState.DISABLED)
            for axis in self.axes:
                requests.require_inside(axis)
            self._deadline = self.bus.now() + sequences.ENABLE_TIME
            self._set(GroupState.ENABLING)

    def disable(self) -> None:
        """Let the brakes hold; not while moving."""
        with self._lock:
            self._require(GroupState.HOLDING, GroupState.ENABLING, GroupState.DISABLED)
            self._set(GroupState.DISABLED)

    def stop(self, reason: str = "stop was asked for") -> None:
        """Stop all winches now; never raises."""
        self.bus.quick_stop_all()
        with self._lock:
            self._latch([Violation(Interlock.OPERATOR, reason, None, self.bus.now())])

    def acknowledge(self) -> None:
        """Say that the cause of a stop was seen and dealt with: faults are reset, the drives stay disabled.

        While a cause persists, the winches stop again at once. `Refused` when nothing is latched, or when
        a drive has started anew and must be connected first.
        """
        with self._lock:
            if not self._causes:
                raise Refused("nothing is latched")
            if any(heard.boots for heard in self._heard):
                raise Refused("a drive started anew: connect again first")
            if self._state is GroupState.MOVING:
                raise Refused("the winches are still slowing down")
            self._require(GroupState.STOPPED, GroupState.HOLDING, GroupState.DISABLED)
            self._tell("acknowledge", {"causes": [str(cause) for cause in self._causes]})
            if self._state is not GroupState.STOPPED:
                # The caller was late, nothing else: the drives hold, or their brakes do since.
                self._causes.clear()
                self._snapshot = self._picture()
                return
            self._deadline = self.bus.now() + sequences.RESET_TIME
            self._set(GroupState.RESETTING)

    def home(self, lengths: Sequence[Range | None]) -> None:
        """Let the present readings be measured lengths (m, unstrained); None leaves a cable as it is."""
        with self._lock:
            self._require(GroupState.DISABLED, GroupState.HOLDING)
            self._require_count(lengths)
            for axis, length in zip(self.axes, lengths, strict=True):
                if length is not None:
                    requests.require_possible(axis, length)
            for axis, length in zip(self.axes, lengths, strict=True):
                if length is not None:
                    axis.set_home(length)
            self._tell(
                "home", {"lengths_m": [None if x is None else [float(x.lo), float(x.hi)] for x in lengths]}
            )
            self._snapshot = self._picture()

    def adopt(self, known: Sequence[Known | None]) -> None:
        """Take over what an earlier run knew; before `connect`, which degrades cables that read otherwise."""
        with self._lock:
            self._require(GroupState.OFF)
            self._require_count(known)
            for axis, one in zip(self.axes, known, strict=True):
                if one is not None:
                    axis.adopt(one)

    def command(self, lengths: Sequence[float], at: float | None = None, at_rest: bool = False) -> None:
        """Add a set-point.

        Parameters
        ----------
        lengths : sequence of N floats
            m, unstrained, file order.
        at : float, optional
            Time on the bus's clock at which they hold; straight lines in between. Default: now and the
            ``lookahead`` of the robot file.
        at_rest : bool
            True: the way ends here. Without it, a caller who lets the time of the last set-point pass is a
            fault: the winches slow down, hold, and wait for `acknowledge`.

        Raises
        ------
        InputError
            For wrong numbers, beyond a limit, or faster than a limit; nothing was changed.
        Refused
            Not enabled, latched, a cable not REFERENCED, or a jog under way.
        """
        with self._lock:
            self._require_free()
            self._require(*_ENABLED)
            now = self.bus.now()
            time = now + float(self.settings.lookahead) if at is None else at
            self._require_count(lengths)
            goal = requests.lengths_within(self.axes, lengths)
            self._require_referenced()
            stream = self._stream()
            requests.require_time(time, stream.times[-1], now)
            requests.require_speed(self.axes, goal, time, stream)
            stream.add(time, goal, at_rest)
            if self._state is GroupState.HOLDING:
                self._begin(stream)

    def jog(self, cable: int, way: float) -> None:
        """Move one winch by a length in m, slowly; the only motion without a reference.

        Raises
        ------
        InputError
            For a way that is too long, or that ends beyond the limits.
        Refused
            Not holding, or latched.
        """
        with self._lock:
            self._require_free()
            self._require(GroupState.HOLDING)
            stream = requests.jog(self.axes, cable, way, self._target_time, self.period)
            self._begin(stream, manual=True)

    def cycle(self) -> None:
        """Send, listen, check, decide. Never raises: an exception stops all winches and is latched."""
        if self._state is GroupState.OFF:
            return
        try:
            self.bus.write_all(self._next)
            heard = self.bus.read_all()
            with self._lock:
                self._decide(heard)
        except Exception as error:
            self._fail(f"{type(error).__name__}: {error}")

    def abandon(self, reason: str) -> None:
        """Stop all winches because the cycle ends: nobody would watch them any more."""
        if self._state not in (GroupState.OFF, GroupState.DISABLED, GroupState.STOPPED):
            self._fail(reason)

    def _fail(self, text: str) -> None:
        self.bus.quick_stop_all()
        with self._lock:
            self._latch([Violation(Interlock.INTERNAL, text, None, self.bus.now())])

    def _decide(self, heard: tuple[Feedback, ...]) -> None:
        """Take what was heard, stop if a rule is broken, prepare the next commands."""
        now = self.bus.now()
        self._heard, self._cycle, self._marks, self._decided_at = heard, self._cycle + 1, [], now
        found = self._violations(heard, now)
        if found:
            self._latch(found)
        try:
            self._next = self._commands(now)
        except Stopped as stopped:
            self._latch([replace(stopped.violation, time=now)])
        self._snapshot = self._picture()

    def _violations(self, heard: tuple[Feedback, ...], now: float) -> list[Violation]:
        """Return every rule that is broken."""
        found = []
        enabled = self._state in _ENABLED
        for axis, one in zip(self.axes, heard, strict=True):
            found += interlocks.communication(axis, one, now, self.period, float(self.settings.heartbeat))
            if one.heard_at is None:
                continue
            found += self._read(axis, one, now)
            if self._state is not GroupState.RESETTING:
                found += interlocks.drive_health(axis, one, now)
            found += interlocks.motion(axis, now)
            if enabled and not found:
                found += interlocks.following(axis, one, now)
        limit = self.settings.coherence
        if enabled and limit is not None:
            found += interlocks.coherence(self.axes, float(limit), now)
        return found

    def _read(self, axis: Axis, heard: Feedback, now: float) -> list[Violation]:
        """Take one reading; a mark that contradicts it stops automatic motion."""
        found = []
        for event in axis.take(heard):
            self._marks.append(event)
            self._tell("mark", {"cable": axis.name, **event.to_json()})
            if not event.accepted and self._state in _ENABLED and not self._manual:
                found.append(Violation(Interlock.MARK, event.reason, axis.name, now))
        return found

    def _latch(self, found: list[Violation]) -> None:
        """Stop everything now, and remember why; a later cause is kept too, once."""
        known = {(cause.interlock, cause.cable) for cause in self._causes}
        new = [cause for cause in found if (cause.interlock, cause.cable) not in known]
        self._causes += new
        stopped = self._state in (GroupState.STOPPED, GroupState.OFF)
        if not stopped:
            self.bus.quick_stop_all()
            self._path = None
            self._set(GroupState.STOPPED)
        for axis in self.axes:
            axis.window = None
            axis.follow_reading()
        self._next = self._idle(cia402.QUICK_STOP)
        if new:
            self._tell("stop", {"causes": [str(cause) for cause in new]})
        self._snapshot = self._picture()

    def _commands(self, now: float) -> list[Command]:
        """Return what the drives get next; `Stopped` when a target must not leave."""
        if self._state in (GroupState.ENABLING, GroupState.RESETTING):
            return self._sequence(now)
        if self._state is GroupState.MOVING:
            self._move(now)
        if self._state in _ENABLED:
            return [self._command(axis, cia402.ENABLE_OPERATION) for axis in self.axes]
        for axis in self.axes:
            axis.follow_reading()
        stopped = self._state is GroupState.STOPPED
        return self._idle(cia402.QUICK_STOP if stopped else cia402.DISABLE_VOLTAGE)

    def _command(self, axis: Axis, control: int) -> Command:
        return Command(control, Mode.CYCLIC_POSITION, axis.wire_target, axis.probe)

    def _idle(self, control: int) -> list[Command]:
        return [self._command(axis, control) for axis in self.axes]

    def _sequence(self, now: float) -> list[Command]:
        """Go one step on the way to HOLDING or DISABLED; `Stopped` when the drives do not come along."""
        enabling = self._state is GroupState.ENABLING
        step = sequences.enabling if enabling else sequences.resetting
        controls, arrived = step(self.axes, self._heard, now, self._deadline, self._cycle)
        if arrived and enabling:
            for axis in self.axes:
                axis.begin()
            self._set(GroupState.HOLDING)
        elif arrived:
            self._causes.clear()
            self._set(GroupState.DISABLED)
        return [self._command(axis, control) for axis, control in zip(self.axes, controls, strict=True)]

    def _move(self, now: float) -> None:
        """Aim at where the path is at the end of the next cycle."""
        path = self._path
        assert path is not None
        time = self._next_path_time(now)
        lengths = path.lengths(time)
        if lengths is None:
            lengths = self._slow_down(time)
        at_rest = True
        for axis, length in zip(self.axes, lengths, strict=True):
            at_rest &= axis.correct()
            axis.aim(length)
        if at_rest and self._path is not None and self._path.is_over(time):
            self._path, self._manual = None, False
            for axis in self.axes:
                axis.window = None
                axis.begin()
            self._set(GroupState.HOLDING)

    def _next_path_time(self, now: float) -> float:
        """Return the time on the path that the next target stands for.

        It goes on by one period a cycle whatever the machine does: a late cycle must be no jump of the
        target. What is lost or gained that way is made up slowly.
        """
        drift = now - self._path_time
        most = SLEW * self.period
        self._path_time += self.period + min(max(drift, -most), most)
        return self._path_time

    def _slow_down(self, time: float) -> tuple[float, ...]:
        """Begin to rest because the caller is late; latched, but the drives stay enabled."""
        speeds = tuple(float(axis.last_step) / self.period for axis in self.axes)
        asked = tuple(float(axis.commanded - self._offset(axis) + axis.applied) for axis in self.axes)
        slowing = Slowing.of(
            time - self.period,
            asked,
            speeds,
            [float(axis.limits.acceleration) for axis in self.axes],
            [(float(axis.limits.length[0]), float(axis.limits.length[1])) for axis in self.axes],
        )
        self._path = slowing
        late = Violation(Interlock.CALLER, "no set-point came in time: slowing down to hold", None, time)
        self._causes.append(late)
        self._tell("stop", {"causes": [str(late)]})
        return slowing.lengths(time)

    def _offset(self, axis: Axis) -> Fraction:
        return Fraction(0) if axis.reference is None else axis.reference.offset

    def _begin(self, path: Stream, manual: bool = False) -> None:
        self._path, self._manual, self._path_time = path, manual, self._target_time
        for axis, start, end in zip(self.axes, path.points[0], path.points[-1], strict=True):
            axis.begin()
            if axis.reference is None:
                quantum = abs(axis.model.rate(axis.target).mid)
                axis.window = (Fraction(min(start, end)) - quantum, Fraction(max(start, end)) + quantum)
        self._set(GroupState.MOVING)

    @property
    def _target_time(self) -> float:
        """The time for which the target stands that was sent last or is sent next."""
        return self._decided_at + self.period

    def _stream(self) -> Stream:
        """Return the stream to which a set-point is added."""
        if self._state is GroupState.HOLDING:
            return Stream([self._target_time], [tuple(float(axis.commanded) for axis in self.axes)])
        if self._manual or not isinstance(self._path, Stream):
            raise Refused("a jog is under way")
        return self._path

    def _set(self, state: GroupState) -> None:
        if state is not self._state:
            self._tell("state", {"from": self._state.value, "to": state.value})
            self._state = state
            # Who waits for the end of this state must not see the one before it.
            self._snapshot = self._picture()

    def _require(self, *states: GroupState) -> None:
        if self._state not in states:
            wanted = " or ".join(state.value for state in states)
            raise Refused(f"the winches are {self._state.value}, not {wanted}")

    def _require_free(self) -> None:
        if self._causes:
            raise Refused(f"stopped: {'; '.join(map(str, self._causes))}: acknowledge first")

    def _require_count(self, values: Sequence[object]) -> None:
        if len(values) != len(self.axes):
            given = counted(len(values), "entry", "entries")
            raise InputError(f"lengths: {counted(len(self.axes), 'cable')}, got {given}")

    def _require_referenced(self) -> None:
        bad = [f"{axis.name} is {axis.state.value}" for axis in self.axes if axis.state not in _AUTOMATIC]
        if bad:
            raise Refused(f"automatic motion needs every cable referenced: {', '.join(bad)}")

    def _picture(self) -> Snapshot:
        cables = tuple(pictured(axis, heard) for axis, heard in zip(self.axes, self._heard, strict=True))
        now = self.bus.now()
        return Snapshot(now, self._cycle, self._state, tuple(self._causes), cables, tuple(self._marks))
