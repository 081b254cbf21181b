"""All winches of a robot as one: the only object a user of the driver needs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any, TypeVar

from cdpr_interval.driver.audit import AuditLog
from cdpr_interval.driver.bus import DriveBus
from cdpr_interval.driver.cyclic import Clockwork, RealTime, Stepped
from cdpr_interval.driver.reference import Known
from cdpr_interval.driver.requests import Refused
from cdpr_interval.driver.simulator import SimulatedBus
from cdpr_interval.driver.snapshot import GroupState, Snapshot
from cdpr_interval.driver.supervisor import Supervisor
from cdpr_interval.driver.violation import Violation
from cdpr_interval.errors import CdprError, InputError
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.cable_robot import Robot

PATIENCE = 5.0
"""s to wait for the drives; they have less themselves."""
AHEAD = 1.0
"""s by which `follow` sends set-points ahead of their time."""

Answer = TypeVar("Answer")
LengthGiven = float | Fraction | tuple[float | Fraction, float | Fraction] | Range


class WinchesStopped(CdprError):
    """The winches were stopped, or the caller was late; ``causes`` say why."""

    def __init__(self, causes: Sequence[Violation]) -> None:
        super().__init__("; ".join(map(str, causes)))
        self.causes = tuple(causes)


class WinchGroup:
    """The winches of a robot, moved together or not at all.

    Lengths are unstrained, in m, in file order, from the exit points. Use it as a context manager: leaving it
    stops and disables. With a `SimulatedBus` time passes only while a method waits (``wait``, ``follow``,
    ``enable``); with any other bus a thread runs the cycle.

    Parameters
    ----------
    robot : Robot
        Every cable with a winch block.
    bus : DriveBus
        Its drives in the order of the cables.
    log : Path, optional
        Audit log, JSON Lines; lines are added.

    Raises
    ------
    InputError
        When robot and bus do not fit.
    """

    def __init__(self, robot: Robot, bus: DriveBus, log: Path | None = None) -> None:
        self.robot, self.bus = robot, bus
        self.supervisor = Supervisor(robot, bus, self._event)
        self._log = AuditLog(log, self.supervisor.period)
        self._works: Clockwork | None = None

    def _event(self, kind: str, data: dict[str, Any]) -> None:
        self._log.event(self.bus.now(), kind, data)

    def _overran(self, late: float) -> None:
        self._event("overrun", {"late_s": late})

    def _cycle(self) -> None:
        self.supervisor.cycle()
        self._log.keep(self.supervisor.snapshot)

    def connect(self) -> None:
        """Connect all drives and start the cycle; they stay disabled. Also after a drive has started anew.

        Raises
        ------
        BusError
            One line for each thing that is missing. The group is off then, even if it was connected before:
            every drive was configured anew, and no cycle runs. References and causes of a stop are kept, and
            `connect` may be tried again.
        Refused
            While drives are enabled (nothing is changed), or no process data came (off, as above).
        """
        self.supervisor.require_connectable()
        self._end_cycle()
        self.supervisor.connect()
        if isinstance(self.bus, SimulatedBus):
            self._works = Stepped(self._cycle, self.supervisor.period)
        else:
            self._works = RealTime(
                self._cycle, self.supervisor.period, self.supervisor.abandon, self._overran
            )
        self._works.start()

    def _end_cycle(self) -> None:
        if self._works is not None:
            self._works.close()
            self._works = None

    def close(self) -> None:
        """Stop if anything moves, disable, leave the bus."""
        try:
            if self.state is GroupState.HOLDING:
                self._tell_to_disable()
            elif self.state not in (GroupState.OFF, GroupState.DISABLED, GroupState.STOPPED):
                self.supervisor.stop("the driver was closed while the winches moved")
                self.pass_cycles(2)
        finally:
            self._end_cycle()
            self.bus.close()
            self._log.close()

    def __enter__(self) -> WinchGroup:
        self.connect()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def snapshot(self) -> Snapshot:
        """All winches after the last cycle."""
        return self.supervisor.snapshot

    @property
    def state(self) -> GroupState:
        """State of the group."""
        return self.supervisor.snapshot.state

    def length_ranges(self) -> list[tuple[float, float]]:
        """Return proved bounds (lo, hi) of every length in m, as the solvers take them.

        Guarantee
        ---------
        As `Reference.length_range`: true while no cable slips and drums and marks keep to their tolerances.

        Raises
        ------
        Refused
            When a cable is not REFERENCED.
        """
        return ranges_of(self.snapshot)

    def where(self, forward: Callable[[list[tuple[float, float]]], Answer]) -> Answer:
        """Return what a solver says about the measured lengths, for example certified poses.

        ``forward`` takes (lo, hi) for each cable, in m; for elastic cables too these are unstretched lengths.
        """
        return forward(self.length_ranges())

    def home(self, lengths: Sequence[LengthGiven | None] | Mapping[str, LengthGiven]) -> None:
        """Let the present readings be measured lengths (m, numbers or bounds); None: leave as it is."""
        names = self.robot.cable_names
        if isinstance(lengths, Mapping):
            unknown = [name for name in lengths if name not in names]
            if unknown:
                raise InputError(f"home: no cable {', '.join(map(repr, unknown))}")
            lengths = [lengths.get(name) for name in names]
        self.supervisor.home([None if length is None else as_range(length) for length in lengths])

    def known(self) -> list[Known | None]:
        """Return what `adopt` of a later run takes, when the drives keep their readings."""
        return [
            None if cable.reference is None else Known(cable.reference, cable.state, cable.counts)
            for cable in self.snapshot.cables
        ]

    def adopt(self, known: Sequence[Known | None]) -> None:
        """Take over what an earlier run knew; before `connect`."""
        self.supervisor.adopt(known)

    def enable(self) -> None:
        """Enable all drives and wait until they hold; `WinchesStopped` when one does not come along."""
        self.supervisor.enable()
        self._until(lambda snapshot: snapshot.state is GroupState.HOLDING, PATIENCE)

    def disable(self) -> None:
        """Let the brakes hold; the drives were told when it returns."""
        self._tell_to_disable()
        self._until(lambda snapshot: snapshot.state is GroupState.DISABLED, PATIENCE)

    def _tell_to_disable(self) -> None:
        """Disable, and let it be sent and answered: who leaves the bus before makes the drives fail."""
        self.supervisor.disable()
        self.pass_cycles(2)

    def stop(self, reason: str = "stop was asked for") -> None:
        """Stop all winches now; never raises."""
        self.supervisor.stop(reason)

    def acknowledge(self) -> None:
        """Acknowledge a stop and wait until the drives are disabled and well; they are not enabled again."""
        self.supervisor.acknowledge()
        ended = (GroupState.DISABLED, GroupState.HOLDING, GroupState.STOPPED)
        self.wait(lambda snapshot: snapshot.state in ended, PATIENCE)
        if self.snapshot.latched:
            raise WinchesStopped(self.snapshot.causes)

    def command(self, lengths: Sequence[float], at: float | None = None, at_rest: bool = False) -> None:
        """Add a set-point; see `Supervisor.command`."""
        self.supervisor.command(lengths, at, at_rest)

    def jog(self, cable: str, way: float) -> None:
        """Move one winch slowly by a way in m (positive: pay out), and wait for it."""
        names = self.robot.cable_names
        if cable not in names:
            raise InputError(f"jog: no cable {cable!r}")
        self.supervisor.jog(names.index(cable), way)
        self._until_rest(10 * PATIENCE)

    def follow(self, path: Iterable[tuple[float, Sequence[float]]]) -> None:
        """Follow set-points (s from now, lengths in m), and wait for the end; times ascending and positive.

        Raises
        ------
        WinchesStopped
            When anything stops the winches.
        InputError, Refused
            As `command`, for the first set-point that is wrong; the winches then slow down and hold, latched.
        """
        points = list(path)
        start = self.bus.now()
        for number, (time, lengths) in enumerate(points):
            near = start + time - AHEAD
            self._until(lambda snapshot, near=near: self.bus.now() >= near, time + PATIENCE)  # type: ignore[misc]
            if self.bus.now() >= start + time:
                # Nothing can be added any more: the winches slow down by themselves, which is latched.
                self._until(lambda snapshot: False, PATIENCE)
            self.command(lengths, start + time, number == len(points) - 1)
        self._until_rest(AHEAD + 10 * PATIENCE)

    def wait(self, condition: Callable[[Snapshot], bool], timeout: float) -> bool:
        """Let cycles pass until a condition holds; return whether it does within so many seconds."""
        if self._works is None:
            raise Refused("not connected")
        return self._works.wait(lambda: condition(self.snapshot), timeout)

    def pass_cycles(self, count: int) -> None:
        """Let some cycles pass."""
        end = self.snapshot.cycle + count
        self.wait(lambda snapshot: snapshot.cycle >= end, max(count * self.supervisor.period * 4, 0.1))

    def _until_rest(self, timeout: float) -> None:
        """Wait until the targets rest, and the drives, which get a target one cycle later, are there."""
        self._until(lambda snapshot: snapshot.state is GroupState.HOLDING, timeout)
        last = self.snapshot.cycle + 2
        self._until(lambda snapshot: snapshot.cycle >= last, PATIENCE)

    def _until(self, condition: Callable[[Snapshot], bool], timeout: float) -> None:
        """Wait for a condition; `WinchesStopped` when something is latched meanwhile or time is over."""
        reached = self.wait(lambda snapshot: snapshot.latched or condition(snapshot), timeout)
        snapshot = self.snapshot
        if snapshot.latched:
            raise WinchesStopped(snapshot.causes)
        if not reached:
            raise Refused(f"the winches are still {snapshot.state.value} after {timeout:g} s")


def ranges_of(snapshot: Snapshot) -> list[tuple[float, float]]:
    """Return the bounds of every length in m; `Refused` when a cable is not REFERENCED."""
    found = [cable.length_range() for cable in snapshot.cables]
    bad = [
        f"{c.name} is {c.state.value}"
        for c, bounds in zip(snapshot.cables, found, strict=True)
        if bounds is None
    ]
    if bad:
        raise Refused(f"no length is known: {', '.join(bad)}")
    return [bounds for bounds in found if bounds is not None]


def as_range(length: LengthGiven) -> Range:
    """Return a length as exact bounds; a float is that double."""
    if isinstance(length, Range):
        return length
    lo, hi = length if isinstance(length, tuple) else (length, length)
    if not Fraction(0) < Fraction(lo) <= Fraction(hi):
        raise InputError(f"length: must be positive and ascending, got {length!r}")
    return Range(Fraction(lo), Fraction(hi))
