"""Simulated CiA 402 nodes on a CAN bus: what the driver meets when no real drive is there.

The library's local node answers SDO requests only. Everything else a device does is added here: process data
into the drive and out of it with SYNC, NMT states with boot-up, heartbeats, emergency messages, and the watch
over the master's heartbeat.
"""

from __future__ import annotations

import struct
import threading
import time
from collections.abc import Callable, Sequence
from importlib import resources
from typing import Any

from cdpr_interval.driver import canopen_objects as objects
from cdpr_interval.driver.bus import BusError, Command
from cdpr_interval.driver.canopen_library import canopen_library
from cdpr_interval.driver.canopen_objects import RPDOS, TPDOS
from cdpr_interval.driver.cia402 import DriveState
from cdpr_interval.driver.simulated_drive import FaultKind, SimulatedDrive

TICK = 0.005
"""s between two looks at heartbeats, watchdogs and motors."""
LOST_MASTER = 0x8130
"""Error code of a lost heartbeat (CiA 301)."""


class CanOpenDrive:
    """One simulated drive as a node of a network."""

    def __init__(self, drive: SimulatedDrive, network: Any, canopen: Any) -> None:
        self.drive, self._network = drive, network
        self.node = drive.winch.node
        self.nmt_state = objects.STATE_PRE_OPERATIONAL
        self._lock = threading.RLock()
        self._local = canopen.LocalNode(self.node, eds_of(canopen))
        self._commands = [[0, 0, drive.position], [0]]
        self._beat_at = self._advanced_at = time.monotonic()
        self._master_at: float | None = None
        self._emergency = 0
        self._boots = drive.boots
        self._late: list[tuple[float, list[bytes]]] = []
        network[self.node] = self._local
        self._local.add_read_callback(self._read)
        # The library would send heartbeats from a thread of its own, which no fault could silence.
        self._local.nmt.send_command(objects.PRE_OPERATIONAL)
        self._local.add_write_callback(lambda **written: self._local.nmt.stop_heartbeat())
        for cob, listen in (
            (objects.RPDO_COBS[0] + self.node, lambda data: self._take(0, data)),
            (objects.RPDO_COBS[1] + self.node, lambda data: self._take(1, data)),
            (objects.SYNC_COB, lambda data: self._on_sync()),
            (objects.NMT_COB, self._on_nmt),
            (objects.HEARTBEAT_COB + objects.MASTER, lambda data: self._on_master()),
        ):
            network.subscribe(cob, self._listener(listen))
        self._send(objects.HEARTBEAT_COB + self.node, b"\x00")

    def _listener(self, listen: Callable[[bytes], None]) -> Callable[[int, bytearray, float], None]:
        def receive(cob: int, data: bytearray, stamp: float) -> None:
            with self._lock:
                if self.drive.state is not DriveState.NOT_READY and FaultKind.FREEZE not in self.drive.faults:
                    listen(bytes(data))

        return receive

    def _value(self, index: int, sub: int, default: int = 0) -> int:
        try:
            data = self._local.get_data(index, sub)
        except Exception:
            return default
        return int.from_bytes(data, "little")

    def _read(self, index: int, subindex: int, od: Any, **rest: Any) -> int | None:
        """Return the value of an object that shows something; None: what was stored."""
        drive = self.drive
        live = {
            objects.STATUSWORD.index: drive.status,
            objects.MODE_SHOWN.index: self._mode(),
            objects.POSITION.index: drive.position,
            objects.TORQUE.index: drive.torque,
            objects.PROBE_STATUS.index: drive.probe_status,
            objects.PROBE_POSITION.index: drive.probe_position,
        }
        return live.get(index)

    def _mode(self) -> int:
        """Mode shown: what was asked for last, by SDO or by process data."""
        if FaultKind.REFUSED_MODE in self.drive.faults:
            return 0
        return self.drive.mode or self._value(objects.MODE.index, 0)

    def _send(self, cob: int, data: bytes) -> None:
        self._network.send_message(cob, data)

    def _take(self, number: int, data: bytes) -> None:
        values = objects.unpacked(RPDOS[number], data)
        if self.nmt_state == objects.STATE_OPERATIONAL and values is not None:
            self._commands[number] = values

    def _on_sync(self) -> None:
        """Let the commands take effect, let time pass, and answer."""
        if self.nmt_state != objects.STATE_OPERATIONAL:
            return
        self._advance()
        (control, mode, target), (probe,) = self._commands
        self.drive.receive(Command(control, mode, target, probe))
        self._answer()

    def _answer(self) -> None:
        drive = self.drive
        first = objects.packed(TPDOS[0], (drive.status, self._mode(), drive.position))
        second = objects.packed(TPDOS[1], (drive.probe_status, drive.probe_position, drive.torque))
        self._late.append((time.monotonic(), [first, second]))
        self._send_due()

    def _send_due(self) -> None:
        delay = self.drive.faults.get(FaultKind.LATENCY, 0.0)
        while self._late and self._late[0][0] <= time.monotonic() - delay:
            _, pdos = self._late.pop(0)
            for cob, data in zip(objects.TPDO_COBS, pdos, strict=True):
                self._send(cob + self.node, data)

    def _on_nmt(self, data: bytes) -> None:
        if len(data) < 2 or data[1] not in (0, self.node):
            return
        if data[0] == objects.START:
            self.nmt_state = objects.STATE_OPERATIONAL
            self._commands = [[0, self._value(objects.MODE.index, 0), self.drive.position], [0]]
        elif data[0] == objects.PRE_OPERATIONAL:
            if self.nmt_state == objects.STATE_OPERATIONAL:
                self._lose_master()
            self.nmt_state = objects.STATE_PRE_OPERATIONAL
        elif data[0] == objects.RESET_NODE:
            self.drive.reboot()

    def _on_master(self) -> None:
        self._master_at = time.monotonic()

    def tick(self) -> None:
        """Do what is due: motor, heartbeat, emergency message, watch over the master."""
        with self._lock:
            self._advance()
            if self.drive.boots != self._boots:
                self._boot()
            if self.drive.state is DriveState.NOT_READY or FaultKind.FREEZE in self.drive.faults:
                return
            self._send_due()
            self._tell_emergency()
            self._beat()
            self._watch_master()

    def kill(self) -> None:
        """Fall silent, as when the supply fails: no data, no heartbeat, no answer."""
        with self._lock:
            self.drive.inject(FaultKind.FREEZE)
            self._local.remove_network()

    def _advance(self) -> None:
        now = time.monotonic()
        if now > self._advanced_at:
            self.drive.advance(now - self._advanced_at)
            self._advanced_at = now

    def _boot(self) -> None:
        """Start anew: settings are lost, the boot-up message is sent."""
        self._boots = self.drive.boots
        self._local.data_store.clear()
        self.nmt_state, self._master_at = objects.STATE_PRE_OPERATIONAL, None
        self._late.clear()
        self._send(objects.HEARTBEAT_COB + self.node, b"\x00")

    def _tell_emergency(self) -> None:
        if self.drive.emergency != self._emergency:
            self._emergency = self.drive.emergency
            self._send(
                objects.EMCY_COB + self.node, struct.pack("<HB5x", self._emergency, bool(self._emergency))
            )

    def _beat(self) -> None:
        period = self._value(objects.HEARTBEAT.index, 0) / 1000
        now = time.monotonic()
        if period and now - self._beat_at >= period and FaultKind.HEARTBEAT not in self.drive.faults:
            self._beat_at = now
            self._send(objects.HEARTBEAT_COB + self.node, bytes([self.nmt_state]))

    def _watch_master(self) -> None:
        """React as 0x6007 says when the master's heartbeat is missing."""
        allowed = (self._value(objects.CONSUMER.index, 1) & 0xFFFF) / 1000
        if self._master_at is not None and allowed and time.monotonic() - self._master_at > allowed:
            self._lose_master()

    def _lose_master(self) -> None:
        self._master_at = None
        if self.drive.state is DriveState.ENABLED:
            if self._value(objects.ABORT_OPTION.index, 0) == objects.QUICK_STOP_WHEN_ALONE:
                self.drive.state = DriveState.QUICK_STOP
            else:
                self.drive.fail(LOST_MASTER)


class SimulatedNetwork:
    """Simulated drives on a CAN bus of their own process or thread; a context manager.

    Parameters
    ----------
    drives : sequence of SimulatedDrive
    interface, channel : str
        As python-can takes them.
    """

    def __init__(
        self, drives: Sequence[SimulatedDrive], interface: str, channel: str, **options: Any
    ) -> None:
        self._drives = list(drives)
        self._options = {"interface": interface, "channel": channel, **options}
        self._network: Any = None
        self._over = threading.Event()
        self._thread: threading.Thread | None = None
        self.nodes: list[CanOpenDrive] = []

    def start(self) -> None:
        """Open the bus and let the drives live."""
        canopen = canopen_library()
        self._network = canopen.Network()
        self._network.NOTIFIER_CYCLE = 10 * TICK
        try:
            self._network.connect(**self._options)
        except Exception as error:
            raise BusError(f"no bus {self._options}: {error}") from error
        self.nodes = [CanOpenDrive(drive, self._network, canopen) for drive in self._drives]
        self._over.clear()
        self._thread = threading.Thread(target=self._run, name="simulated drives", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._over.wait(TICK):
            for node in self.nodes:
                node.tick()

    def kill(self, node: int) -> None:
        """Let one node fall silent."""
        (dead,) = [one for one in self.nodes if one.node == node]
        dead.kill()

    def stop(self) -> None:
        """End the drives and leave the bus."""
        self._over.set()
        if self._thread is not None:
            self._thread.join(timeout=5.0)
            self._thread = None
        if self._network is not None:
            self._network.disconnect()
            self._network = None

    def __enter__(self) -> SimulatedNetwork:
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.stop()


def eds_of(canopen: Any) -> Any:
    """Return the object dictionary of the simulated drive, from the file that ships."""
    text = resources.files(__package__).joinpath("cdpr_winch.eds")
    with resources.as_file(text) as path:
        return canopen.import_od(str(path))
