"""Drives on a CANopen bus: configured and read back by SDO, then moved by SYNC and process data only.

Everything that arrives is stored as bytes with the time by a small callback; nothing is decided there, since
the library swallows exceptions of callbacks. The master's heartbeat is sent by the cycle itself: when the
cycle hangs, the drives stop.
"""

from __future__ import annotations

import struct
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from cdpr_interval.driver import canopen_objects as objects
from cdpr_interval.driver import cia402
from cdpr_interval.driver.bus import BusError, Command, Feedback
from cdpr_interval.driver.canopen_library import canopen_library
from cdpr_interval.driver.canopen_objects import RPDOS, TPDOS
from cdpr_interval.driver.canopen_settings import DriveSettings, configure, settings_of
from cdpr_interval.robots.cable_robot import Robot

ANSWER_SHARE = 0.6
"""Of a cycle, for which answers to SYNC are waited for."""
PATIENCE = 2.0
"""s to wait for a heartbeat of every node."""
LISTENED_HEARTBEATS = 3
"""Heartbeat periods for which another master is listened for."""
STOP_REPEATS = 3
"""How often `stop_from_outside` sends its messages: a bus may be busy."""
LISTENING_CYCLE = 0.05
"""s after which the receiving thread looks whether it should end."""


@dataclass
class Heard:
    """Raw messages of one node: the callback writes, the cycle reads, a lock between them."""

    pdos: list[bytes | None] = field(default_factory=lambda: [None] * len(TPDOS))
    syncs: list[int] = field(default_factory=lambda: [-1] * len(TPDOS))
    """The SYNC after which each PDO came."""
    whole: tuple[bytes, ...] | None = None
    """The last PDOs that came after one and the same SYNC."""
    whole_at: float | None = None
    whole_sync: int = -1
    heartbeat_at: float | None = None
    nmt_state: int | None = None
    emergency: int = 0
    boots: int = 0


class CanOpenBus:
    """A `DriveBus` over python-can and canopen (the extra ``driver``).

    Parameters
    ----------
    drives : sequence of DriveSettings
        In the order of the cables.
    interface, channel : str
        As python-can takes them: ``socketcan`` and ``can0``, ``virtual`` and a name,
        ``udp_multicast`` and an address.
    cycle, heartbeat : float
        s.
    options
        For python-can, for example ``bitrate``.
    """

    def __init__(
        self,
        drives: Sequence[DriveSettings],
        interface: str,
        channel: str,
        cycle: float = 0.01,
        heartbeat: float = 0.05,
        **options: Any,
    ) -> None:
        self._drives = list(drives)
        self._options = {"interface": interface, "channel": channel, **options}
        self._cycle, self._heartbeat = cycle, heartbeat
        self._network: Any = None
        self._heard = [Heard() for _ in self._drives]
        self._news = threading.Condition()
        self._sending = threading.Lock()
        self._sync = 0
        self._sync_at = 0.0
        self._beat_at = 0.0
        self._last: list[Command] = []

    @classmethod
    def of(cls, robot: Robot, interface: str, channel: str, **options: Any) -> CanOpenBus:
        """Return the bus of a robot's winches; ramps and windows follow from their limits."""
        drives = []
        for cable in robot.cables:
            winch = cable.winch
            if winch is None:
                raise BusError(f"{cable.name}: no winch")
            drives.append(settings_of(winch))
        group = robot.winches
        return cls(drives, interface, channel, float(group.cycle), float(group.heartbeat), **options)

    @property
    def count(self) -> int:
        """The number of drives."""
        return len(self._drives)

    def now(self) -> float:
        """Return the time in s of this computer's monotonic clock."""
        return time.monotonic()

    def connect(self) -> None:
        """Open the bus, configure every drive, read everything back, let data flow; see `DriveBus`."""
        self.close()
        canopen = canopen_library()
        self._heard = [Heard() for _ in self._drives]
        self._last = []
        network = canopen.Network()
        network.NOTIFIER_CYCLE = LISTENING_CYCLE
        # Before any node is added: the first subscriber cannot be skipped because another one raised.
        self._subscribe(network)
        try:
            network.connect(**self._options)
        except Exception as error:
            raise BusError(f"no bus {self._options}: {error}") from error
        self._network = network
        try:
            self._require_alone()
            self._configure(canopen)
        except BaseException:
            self.close()
            raise

    def _require_alone(self) -> None:
        """Raise `BusError` when another master is heard: to configure would stop what it moves."""
        other = threading.Event()
        self._network.subscribe(objects.HEARTBEAT_COB + objects.MASTER, lambda *message: other.set())
        if other.wait(LISTENED_HEARTBEATS * self._heartbeat):
            raise BusError("another master is on the bus: nothing was sent")

    def _subscribe(self, network: Any) -> None:
        for heard, drive in zip(self._heard, self._drives, strict=True):
            for number, cob in enumerate(objects.TPDO_COBS):
                network.subscribe(cob + drive.node, self._pdo_listener(heard, number))
            network.subscribe(objects.HEARTBEAT_COB + drive.node, self._heartbeat_listener(heard))
            network.subscribe(objects.EMCY_COB + drive.node, self._emergency_listener(heard))

    def _pdo_listener(self, heard: Heard, number: int) -> Callable[[int, bytearray, float], None]:
        def listen(cob: int, data: bytearray, stamp: float) -> None:
            # The bus's stamps are wall-clock times on some interfaces: take our own.
            now = time.monotonic()
            with self._news:
                heard.pdos[number], heard.syncs[number] = bytes(data), self._sync
                if all(sync == self._sync for sync in heard.syncs):
                    heard.whole = tuple(pdo for pdo in heard.pdos if pdo is not None)
                    heard.whole_at, heard.whole_sync = now, self._sync
                    self._news.notify_all()

        return listen

    def _heartbeat_listener(self, heard: Heard) -> Callable[[int, bytearray, float], None]:
        def listen(cob: int, data: bytearray, stamp: float) -> None:
            now = time.monotonic()
            if not data:
                return
            with self._news:
                state = data[0] & 0x7F
                heard.boots += state == 0
                heard.heartbeat_at, heard.nmt_state = now, state
                self._news.notify_all()

        return listen

    def _emergency_listener(self, heard: Heard) -> Callable[[int, bytearray, float], None]:
        def listen(cob: int, data: bytearray, stamp: float) -> None:
            with self._news:
                # A message too short to hold a code is an emergency all the same.
                heard.emergency = struct.unpack_from("<H", data)[0] if len(data) >= 2 else 0xFFFF

        return listen

    def _configure(self, canopen: Any) -> None:
        """Bring all nodes to OPERATIONAL, or raise with everything that is wrong."""
        self._command_all(objects.PRE_OPERATIONAL)
        faults: list[str] = []
        for drive in self._drives:
            node = self._network.add_node(drive.node, canopen.ObjectDictionary())
            faults += configure(canopen, node, drive, self._cycle, self._heartbeat)
        if not faults:
            faults = self._wait_for_state(objects.STATE_PRE_OPERATIONAL)
        if not faults:
            with self._news:
                for heard in self._heard:
                    # What happened until here is over; from now on a boot-up is a drive that was lost.
                    heard.boots, heard.emergency = 0, 0
            self._beat()
            self._command_all(objects.START)
            faults = self._wait_for_state(objects.STATE_OPERATIONAL)
        if faults:
            raise BusError("\n".join(faults))

    def _wait_for_state(self, state: int) -> list[str]:
        """Wait until a heartbeat of every node shows an NMT state; return what is wrong."""
        asked = time.monotonic()

        def late() -> list[Heard]:
            return [
                heard
                for heard in self._heard
                if heard.heartbeat_at is None or heard.heartbeat_at < asked or heard.nmt_state != state
            ]

        with self._news:
            self._news.wait_for(lambda: not late(), PATIENCE)
            missing = late()
        return [
            f"node {drive.node}: no heartbeat with NMT state {state} (last: {heard.nmt_state})"
            for drive, heard in zip(self._drives, self._heard, strict=True)
            if any(heard is one for one in missing)
        ]

    def write_all(self, commands: Sequence[Command]) -> None:
        """Send the commands of one cycle and SYNC, and the master's heartbeat when it is due."""
        if self._network is None:
            raise BusError("the bus is not connected")
        self._network.check()
        now = time.monotonic()
        if now - self._beat_at >= self._heartbeat:
            self._beat()
        with self._sending:
            self._last = list(commands)
            for drive, command in zip(self._drives, commands, strict=bool(commands)):
                self._send_command(drive.node, command)
            with self._news:
                self._sync, self._sync_at = self._sync + 1, now
            self._network.send_message(objects.SYNC_COB, b"")

    def _send_command(self, node: int, command: Command) -> None:
        values = ((command.control, command.mode, command.target), (command.probe,))
        for cob, entries, value in zip(objects.RPDO_COBS, RPDOS, values, strict=True):
            self._network.send_message(cob + node, objects.packed(entries, value))

    def _beat(self) -> None:
        self._beat_at = time.monotonic()
        self._network.send_message(objects.HEARTBEAT_COB + objects.MASTER, [objects.STATE_OPERATIONAL])

    def read_all(self) -> tuple[Feedback, ...]:
        """Wait for the answers to the last SYNC, at most a share of the cycle; return what was heard."""
        end = self._sync_at + ANSWER_SHARE * self._cycle
        with self._news:
            while any(heard.whole_sync != self._sync for heard in self._heard):
                left = end - time.monotonic()
                if left <= 0 or not self._news.wait(left):
                    break
            return tuple(_feedback(heard) for heard in self._heard)

    def quick_stop_all(self) -> None:
        """Send quick stop to every drive at once; never raises."""
        network = self._network
        if network is None:
            return
        # A stop must reach the next drive whatever became of the last message.
        with self._sending:
            for i, drive in enumerate(self._drives):
                last = self._last[i] if i < len(self._last) else self._where(i)
                stop = Command(cia402.QUICK_STOP, last.mode, last.target, last.probe)
                with suppress(Exception):
                    self._send_command(drive.node, stop)
            with suppress(Exception):
                network.send_message(objects.SYNC_COB, b"")

    def _where(self, i: int) -> Command:
        """Return a command that leaves a drive where it said it is."""
        with self._news:
            return Command(0, 0, _feedback(self._heard[i]).position)

    def close(self) -> None:
        """Stop process data, leave the bus; may be called again."""
        network, self._network = self._network, None
        if network is not None:
            for drive in self._drives:
                with suppress(Exception):
                    network.send_message(objects.NMT_COB, [objects.PRE_OPERATIONAL, drive.node])
            network.disconnect()

    def _command_all(self, command: int) -> None:
        for drive in self._drives:
            self._network.send_message(objects.NMT_COB, [command, drive.node])


def stop_from_outside(robot: Robot, interface: str, channel: str, **options: Any) -> None:
    """Stop the winches of a robot that another program moves.

    Every drive is sent to PRE-OPERATIONAL, to which it reacts as to a lost master (0x6007: quick stop); the
    other program sees that and latches. No target is sent.

    Raises
    ------
    BusError
        When the bus cannot be used.
    InputError
        The extra ``driver`` is not installed.
    """
    canopen = canopen_library()
    network = canopen.Network()
    network.NOTIFIER_CYCLE = LISTENING_CYCLE
    try:
        network.connect(interface=interface, channel=channel, **options)
        for _ in range(STOP_REPEATS):
            for cable in robot.cables:
                if cable.winch is not None:
                    network.send_message(objects.NMT_COB, [objects.PRE_OPERATIONAL, cable.winch.node])
    except Exception as error:
        raise BusError(f"stop could not be sent: {error}") from error
    finally:
        network.disconnect()


def _feedback(heard: Heard) -> Feedback:
    """Return what a node said last; process data of a wrong length are none."""
    whole = heard.whole or (b"",) * len(TPDOS)
    first, second = (objects.unpacked(entries, data) for entries, data in zip(TPDOS, whole, strict=True))
    operational = heard.nmt_state == objects.STATE_OPERATIONAL
    rest = (heard.heartbeat_at, operational, heard.emergency, heard.boots)
    if first is None or second is None:
        return Feedback(0, 0, 0, 0, 0, 0, None, *rest)
    (status, mode, position), (probe, caught, torque) = first, second
    return Feedback(status, mode, position, torque, probe, caught, heard.whole_at, *rest)
