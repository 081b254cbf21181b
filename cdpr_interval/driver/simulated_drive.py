"""A simulated CiA 402 drive with motor, drum, cable and mark sensor; it knows the truth."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from fractions import Fraction

from cdpr_interval.driver import cia402
from cdpr_interval.driver.bus import PROBE_CAUGHT, PROBE_ENABLED, Command
from cdpr_interval.driver.cia402 import DriveState, Mode
from cdpr_interval.driver.counter import nearest, wrapped
from cdpr_interval.driver.drum import DrumLaw
from cdpr_interval.driver.marks import length_at
from cdpr_interval.driver.winch import WinchModel
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.winch import Winch

SPARE_SPEED = 2
"""The motor can turn this much faster than the winch's limit."""
RATED_TORQUE_SHARE = 300
"""Torque reported while holding, per mille of the rated torque."""
BOOT_TIME = 0.2
"""s from a reboot to SWITCH ON DISABLED."""
REACTION_TIME = 0.05
"""s that a drive takes for its fault reaction."""
DOUBLED_BY = Fraction(1, 50)
"""m after a mark at which a doubled one is seen again."""


class FaultKind(StrEnum):
    """What can go wrong in the simulation."""

    FREEZE = "freeze"
    """No process data any more."""
    HEARTBEAT = "heartbeat"
    """No heartbeat any more."""
    EMERGENCY = "emergency"
    """The drive goes to FAULT and says so."""
    STUCK_ENCODER = "stuck-encoder"
    """The reported position stands still while the motor turns."""
    SLIP = "slip"
    """The cable slips on the drum by ``amount`` m."""
    WRONG_LAYER = "wrong-layer"
    """The cable winds ``amount`` (a share) wider or narrower than the tolerances allow."""
    MISSED_MARK = "missed-mark"
    """The next marks pass unseen."""
    DOUBLED_MARK = "doubled-mark"
    """The next mark is seen a second time, a little later."""
    LATENCY = "latency"
    """Process data arrive ``amount`` s late."""
    REBOOT = "reboot"
    """The drive starts anew."""
    REFUSED_MODE = "refused-mode"
    """The mode of operation cannot be set."""


@dataclass(frozen=True)
class SimulatedFault:
    """One fault of one drive."""

    drive: int
    kind: FaultKind
    amount: float = 0.0


def true_law(law: DrumLaw, share: Fraction) -> DrumLaw:
    """Return one of the laws a file allows: each slope at the same share (0 to 1) of its range."""
    slopes = tuple(Range(*(2 * (s.lo + share * s.width,))) for s in law.slopes)
    return DrumLaw(slopes, law.breakpoints, law.ends, law.anchor)


@dataclass
class SimulatedDrive:
    """One drive: `receive` takes a command as SYNC does, `advance` lets time pass.

    The motor follows its target within a cycle unless that asks for more than its speed; quick stop and fault
    reaction brake it; a drive without voltage is held by its brake.
    """

    winch: Winch
    length: Fraction
    """m of cable that is truly paid out at the start."""
    share: Fraction = Fraction(1, 2)
    """Where in the file's tolerances the true drum and marks lie, 0 to 1."""
    state: DriveState = DriveState.DISABLED
    mode: int = 0
    emergency: int = 0
    boots: int = 0
    faults: dict[FaultKind, float] = field(default_factory=dict)
    motor: float = 0.0
    """True position in counts, from the start."""
    velocity: float = 0.0
    """Counts per second."""
    first_reading: int = 0
    """What the encoder showed at the start, unwrapped."""

    def __post_init__(self) -> None:
        """Put the motor where the cable has its length."""
        model = WinchModel(self.winch)
        law = model.law
        self._model = WinchModel(self.winch)
        self._law = true_law(law, self.share)
        self._start_turns = self._law.turns(self.length)
        self._slip = Fraction(0)
        self._control = 0
        self._target = self.first_reading
        self._wait = 0.0
        self._since = 0.0
        self._motor_before = self.motor
        self._stuck_at: int | None = None
        self._probe_function = 0
        self.probe_status = 0
        self.probe_position = 0
        self._echo: Fraction | None = None
        self._mark_places = {side: self._places(side) for side in (-1, 1)}
        per_count = float(abs(model.rate(model.counts(self.length)).mid))
        self._count_speed = SPARE_SPEED * float(self.winch.limits.velocity) / per_count
        self._count_braking = float(self.winch.limits.acceleration) * SPARE_SPEED / per_count

    def _places(self, direction: int) -> list[Fraction]:
        """Return the true lengths at which marks are seen."""
        sensor = self.winch.sensor
        if sensor is None:
            return []
        expected = [length_at(sensor, mark, direction, Fraction(0)) for mark in sensor.marks]
        return [one.lo + self.share * one.width for one in expected]

    @property
    def reading(self) -> int:
        """The encoder's reading, unwrapped."""
        return self._stuck_at if self._stuck_at is not None else self._true_reading

    @property
    def _true_reading(self) -> int:
        return self.first_reading + round(self.motor)

    @property
    def position(self) -> int:
        """Position actual value: signed 32 bits."""
        return wrapped(self.reading)

    @property
    def status(self) -> int:
        """Statusword; bit 4, voltage, is on outside of DISABLED."""
        return cia402.statusword_of(self.state) | (0x10 if self.state is not DriveState.DISABLED else 0)

    @property
    def torque(self) -> int:
        """Per mille of the rated torque."""
        return RATED_TORQUE_SHARE if self.state is DriveState.ENABLED else 0

    @property
    def true_length(self) -> Fraction:
        """M of cable that is truly paid out."""
        return self._length_at(self.motor)

    def _length_at(self, motor: float) -> Fraction:
        turns = self._start_turns + self.winch.sign * Fraction(motor) / self._model.counts_per_drum_turn
        if self._law.ends is not None:
            turns = min(max(turns, self._law.ends[0]), self._law.ends[1])
        grown = 1 + Fraction(self.faults.get(FaultKind.WRONG_LAYER, 0.0))
        return self.length + (self._law.length(turns) - self.length) * grown + self._slip

    def receive(self, command: Command) -> None:
        """Take the process data of a cycle."""
        if self._since > 0.0:
            # The motor jumps to each target; how fast it goes is what it does from one to the next.
            self.velocity = (self.motor - self._motor_before) / self._since
            self._since, self._motor_before = 0.0, self.motor
        self.mode = 0 if FaultKind.REFUSED_MODE in self.faults else command.mode
        state = cia402.answer(self.state, command.control, self._control)
        if self.state is DriveState.FAULT and state is DriveState.DISABLED:
            self.emergency = 0
        self._control = command.control
        if state is DriveState.ENABLED and self.mode != Mode.CYCLIC_POSITION:
            state = DriveState.SWITCHED_ON
        self.state = state
        self._target = nearest(command.target, self.first_reading + round(self.motor))
        rising = command.probe & 1 and not self._probe_function & 1
        self._probe_function = command.probe
        if not command.probe & 1:
            self.probe_status = 0
        elif rising:
            self.probe_status = PROBE_ENABLED

    def inject(self, kind: FaultKind, amount: float = 0.0) -> None:
        """Let something go wrong from now on."""
        if kind is FaultKind.SLIP:
            self._slip += Fraction(amount)
            return
        if kind is FaultKind.EMERGENCY:
            self.fail(0x2310)
            return
        if kind is FaultKind.REBOOT:
            self.reboot()
            return
        if kind is FaultKind.STUCK_ENCODER:
            self._stuck_at = self._true_reading
        self.faults[kind] = amount

    def repair(self) -> None:
        """End every fault that lasts."""
        self.faults.clear()
        self._stuck_at = None

    def fail(self, code: int) -> None:
        """Go to the fault reaction with an error code, as on overcurrent or when the master is silent."""
        if self.state not in (DriveState.FAULT, DriveState.FAULT_REACTION):
            self.emergency, self.state, self._wait = code, DriveState.FAULT_REACTION, REACTION_TIME

    def reboot(self) -> None:
        """Start anew, as after a loss of supply."""
        self.boots += 1
        self.state, self._wait, self.velocity, self.mode, self.emergency = (
            DriveState.NOT_READY,
            BOOT_TIME,
            0.0,
            0,
            0,
        )

    def advance(self, seconds: float) -> None:
        """Let time pass."""
        before = self.motor
        if self.state is DriveState.ENABLED:
            goal = self._target - self.first_reading
            reach = self._count_speed * seconds
            self.motor += min(max(goal - self.motor, -reach), reach)
            self._since += seconds
        elif self.state in (DriveState.QUICK_STOP, DriveState.FAULT_REACTION):
            self._brake(seconds)
        else:
            self._stand()
        self._wait -= seconds
        self._leave_passing_states()
        self._look_for_marks(before)

    def _stand(self) -> None:
        self.velocity, self._since, self._motor_before = 0.0, 0.0, self.motor

    def _brake(self, seconds: float) -> None:
        slower = max(abs(self.velocity) - self._count_braking * seconds, 0.0)
        self.velocity = slower if self.velocity > 0 else -slower
        self.motor += self.velocity * seconds

    def _leave_passing_states(self) -> None:
        if self.state is DriveState.QUICK_STOP and self.velocity == 0.0:
            self.state = DriveState.DISABLED
        elif self.state is DriveState.FAULT_REACTION and self._wait <= 0.0 and self.velocity == 0.0:
            self.state = DriveState.FAULT
        elif self.state is DriveState.NOT_READY and self._wait <= 0.0:
            self.state = DriveState.DISABLED

    def _look_for_marks(self, before: float) -> None:
        sensor = self.winch.sensor
        if sensor is None or before == self.motor:
            return
        start, end = self._length_at(before), self._length_at(self.motor)
        direction = 1 if end > start else -1
        for place in self._mark_places[direction]:
            self._pass(place, start, end, before, is_mark=True)
        if self._echo is not None:
            self._pass(self._echo, start, end, before, is_mark=False)

    def _pass(self, place: Fraction, start: Fraction, end: Fraction, before: float, is_mark: bool) -> None:
        """Latch the reading where the length passes a place."""
        if not min(start, end) < place <= max(start, end):
            return
        if is_mark and FaultKind.MISSED_MARK in self.faults:
            return
        if is_mark and self.faults.pop(FaultKind.DOUBLED_MARK, None) is not None:
            self._echo = place + (DOUBLED_BY if end > start else -DOUBLED_BY)
        elif not is_mark:
            self._echo = None
        if self.probe_status & PROBE_ENABLED and not self.probe_status & PROBE_CAUGHT:
            part = float((place - start) / (end - start))
            self.probe_status |= PROBE_CAUGHT
            self.probe_position = wrapped(self.first_reading + round(before + part * (self.motor - before)))
