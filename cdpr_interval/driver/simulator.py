"""A bus of simulated drives in memory with its own clock: nothing waits, nothing depends on the machine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from cdpr_interval.driver import cia402
from cdpr_interval.driver.bus import BusError, Command, Feedback
from cdpr_interval.driver.cia402 import DriveState
from cdpr_interval.driver.simulated_drive import FaultKind, SimulatedDrive, SimulatedFault

STARTED = 0.3
"""s that a real bus takes to come up."""


@dataclass
class SimulatedBus:
    """Drives that move when the clock does: `read_all` lets one cycle pass."""

    drives: Sequence[SimulatedDrive]
    cycle: float = 0.01
    """s between two SYNC messages."""
    heartbeat: float = 0.05
    """s between two heartbeats."""
    observer: Callable[[float, tuple[Command, ...]], None] | None = None
    """Called with the time and what is sent, each time something is sent."""
    time: float = 0.0
    connected: bool = False
    _late: list[list[tuple[float, Feedback]]] = field(default_factory=list)
    _heard: list[Feedback] = field(default_factory=list)
    _beats: list[float | None] = field(default_factory=list)
    _last: tuple[Command, ...] = ()

    @property
    def count(self) -> int:
        """The number of drives."""
        return len(self.drives)

    def now(self) -> float:
        """Return the simulated time in s."""
        return self.time

    def connect(self) -> None:
        """Let process data flow; drives that are frozen or silent are refused."""
        self.time += STARTED
        faults = (FaultKind.FREEZE, FaultKind.HEARTBEAT)
        silent = [i for i, drive in enumerate(self.drives) if any(kind in drive.faults for kind in faults)]
        if silent:
            raise BusError("\n".join(f"drive {i}: no heartbeat" for i in silent))
        for drive in self.drives:
            drive.advance(STARTED)
            drive.boots = 0
        self._late = [[] for _ in self.drives]
        self._heard = [Feedback() for _ in self.drives]
        self._beats = [self.time for _ in self.drives]
        self.connected = True

    def inject(self, fault: SimulatedFault) -> None:
        """Let something go wrong from now on."""
        self.drives[fault.drive].inject(fault.kind, fault.amount)

    def write_all(self, commands: Sequence[Command]) -> None:
        """Give every drive its command."""
        self._require_connected()
        if commands:
            self._send(tuple(commands))

    def read_all(self) -> tuple[Feedback, ...]:
        """Let one cycle pass and return what the drives say at its end."""
        self._require_connected()
        self.time += self.cycle
        for i, drive in enumerate(self.drives):
            drive.advance(self.cycle)
            self._listen(i, drive)
        return tuple(self._heard)

    def quick_stop_all(self) -> None:
        """Send quick stop to every drive, with its last target."""
        if self.connected:
            rest = self._last or tuple(Command(0, 0, drive.position) for drive in self.drives)
            self._send(tuple(Command(cia402.QUICK_STOP, c.mode, c.target, c.probe) for c in rest))

    def close(self) -> None:
        """Leave: the drives notice that the master is silent, and fail when they are enabled."""
        for drive in self.drives:
            if drive.state is DriveState.ENABLED:
                drive.fail(0x8130)
        self.connected = False

    def _require_connected(self) -> None:
        if not self.connected:
            raise BusError("the bus is not connected")

    def _send(self, commands: tuple[Command, ...]) -> None:
        self._last = commands
        if self.observer is not None:
            self.observer(self.time, commands)
        for drive, command in zip(self.drives, commands, strict=True):
            if FaultKind.FREEZE not in drive.faults and drive.state is not DriveState.NOT_READY:
                drive.receive(command)

    def _listen(self, i: int, drive: SimulatedDrive) -> None:
        """Hear what one drive says now, or what it said a while ago."""
        running = drive.state is not DriveState.NOT_READY
        beats = running and FaultKind.HEARTBEAT not in drive.faults and FaultKind.FREEZE not in drive.faults
        last = self._beats[i]
        if beats and (last is None or self.time - last >= self.heartbeat - 1e-9):
            self._beats[i] = self.time
        if running and FaultKind.FREEZE not in drive.faults:
            self._late[i].append((self.time, self._said(drive)))
        delay = drive.faults.get(FaultKind.LATENCY, 0.0)
        old = self._heard[i]
        while self._late[i] and self._late[i][0][0] <= self.time - delay + 1e-9:
            _, old = self._late[i].pop(0)
        self._heard[i] = Feedback(
            old.status, old.mode, old.position, old.torque, old.probe, old.probe_position, old.heard_at,
            self._beats[i], running and drive.boots == 0, drive.emergency, drive.boots,
        )  # fmt: skip

    def _said(self, drive: SimulatedDrive) -> Feedback:
        return Feedback(
            drive.status, drive.mode, drive.position, drive.torque, drive.probe_status, drive.probe_position,
            self.time,
        )  # fmt: skip
