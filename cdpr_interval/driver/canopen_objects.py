"""The objects of a CiA 402 drive that the driver uses: where they are, how long, and what they must hold.

References: CiA 301 (communication, 0x1000 to 0x1FFF), CiA 402-2 (drive, 0x6000 to 0x9FFF).
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass

from cdpr_interval.driver.cia402 import Mode

MASTER = 127
"""Node id under which the master's heartbeat is sent."""
NMT_COB, SYNC_COB, EMCY_COB, HEARTBEAT_COB = 0x000, 0x080, 0x080, 0x700
"""COB-IDs of CiA 301; the last two are added to the node id."""
RPDO_COBS, TPDO_COBS = (0x200, 0x300), (0x180, 0x280)
START, PRE_OPERATIONAL, RESET_NODE = 1, 128, 129
"""NMT commands."""
STATE_OPERATIONAL, STATE_PRE_OPERATIONAL = 5, 127
"""NMT states in heartbeats; 0 is the boot-up message."""
EVERY_SYNC = 1
"""Transmission type of a PDO: with each SYNC."""
PDO_OFF = 1 << 31
"""Bit of a PDO's COB-ID: not valid."""
QUICK_STOP_BY_RAMP = 2
"""0x605A and 0x605E: slow down on the quick stop ramp, then disable; the brake holds."""
QUICK_STOP_WHEN_ALONE = 3
"""0x6007: quick stop when the master is lost."""


@dataclass(frozen=True)
class Entry:
    """One object."""

    index: int
    sub: int
    layout: str
    """Of the struct module, little endian."""
    name: str

    @property
    def size(self) -> int:
        """Bytes."""
        return struct.calcsize(self.layout)

    def __str__(self) -> str:
        place = f"0x{self.index:04x}" + (f":{self.sub}" if self.sub else "")
        return f"{place} {self.name}"

    def pack(self, value: int) -> bytes:
        """Return the bytes of a value."""
        return struct.pack(self.layout, value)

    def unpack(self, data: bytes) -> int:
        """Return the value of some bytes; `struct.error` for a wrong number of them."""
        (value,) = struct.unpack(self.layout, data)
        return int(value)


CONTROLWORD = Entry(0x6040, 0, "<H", "controlword")
STATUSWORD = Entry(0x6041, 0, "<H", "statusword")
MODE = Entry(0x6060, 0, "<b", "modes of operation")
MODE_SHOWN = Entry(0x6061, 0, "<b", "modes of operation display")
POSITION = Entry(0x6064, 0, "<i", "position actual value")
WINDOW = Entry(0x6065, 0, "<I", "following error window")
WINDOW_TIME = Entry(0x6066, 0, "<H", "following error time out")
TORQUE = Entry(0x6077, 0, "<h", "torque actual value")
TARGET = Entry(0x607A, 0, "<i", "target position")
BRAKING = Entry(0x6085, 0, "<I", "quick stop deceleration")
ABORT_OPTION = Entry(0x6007, 0, "<h", "abort connection option code")
QUICK_STOP_OPTION = Entry(0x605A, 0, "<h", "quick stop option code")
FAULT_OPTION = Entry(0x605E, 0, "<h", "fault reaction option code")
PROBE_FUNCTION = Entry(0x60B8, 0, "<H", "touch probe function")
PROBE_STATUS = Entry(0x60B9, 0, "<H", "touch probe status")
PROBE_POSITION = Entry(0x60BA, 0, "<i", "touch probe 1 positive edge")
CYCLE = Entry(0x60C2, 1, "<B", "interpolation time period value")
CYCLE_UNIT = Entry(0x60C2, 2, "<b", "interpolation time index")
HEARTBEAT = Entry(0x1017, 0, "<H", "producer heartbeat time")
CONSUMER = Entry(0x1016, 1, "<I", "consumer heartbeat time")

RPDOS = ((CONTROLWORD, MODE, TARGET), (PROBE_FUNCTION,))
TPDOS = ((STATUSWORD, MODE_SHOWN, POSITION), (PROBE_STATUS, PROBE_POSITION, TORQUE))
"""What is sent with each SYNC, in this order, at most 8 bytes each."""


@dataclass(frozen=True)
class Setting:
    """A value that an object must hold before a drive may be enabled."""

    entry: Entry
    value: int
    shown_by: Entry | None = None
    """The object that shows whether it was taken; None: the same one."""
    is_read_back: bool = True
    """False: an intermediate value, for example of a PDO that is being changed."""


def packed(entries: Sequence[Entry], values: Sequence[int]) -> bytes:
    """Return the bytes of a PDO."""
    return b"".join(entry.pack(value) for entry, value in zip(entries, values, strict=True))


def unpacked(entries: Sequence[Entry], data: bytes) -> list[int] | None:
    """Return the values of a PDO; None when its length is wrong."""
    if len(data) != sum(entry.size for entry in entries):
        return None
    values, start = [], 0
    for entry in entries:
        values.append(entry.unpack(data[start : start + entry.size]))
        start += entry.size
    return values


def pdo_settings(node: int) -> list[Setting]:
    """Return what maps the process data, PDO by PDO: off, mapped, on."""
    found = []
    for base, mapping, cobs, pdos in ((0x1400, 0x1600, RPDO_COBS, RPDOS), (0x1800, 0x1A00, TPDO_COBS, TPDOS)):
        for number, (cob, entries) in enumerate(zip(cobs, pdos, strict=True)):
            what = "RPDO" if base == 0x1400 else "TPDO"
            cob_entry = Entry(base + number, 1, "<I", f"{what} {number + 1} COB-ID")
            kind = Entry(base + number, 2, "<B", f"{what} {number + 1} transmission type")
            count = Entry(mapping + number, 0, "<B", f"{what} {number + 1} mapping")
            found += [
                Setting(cob_entry, PDO_OFF | (cob + node), is_read_back=False),
                Setting(kind, EVERY_SYNC),
                Setting(count, 0, is_read_back=False),
            ]
            for place, entry in enumerate(entries, 1):
                mapped = Entry(mapping + number, place, "<I", f"{what} {number + 1} mapping")
                found.append(Setting(mapped, entry.index << 16 | entry.sub << 8 | 8 * entry.size))
            found += [Setting(count, len(entries)), Setting(cob_entry, cob + node)]
    return found


def drive_settings(cycle: float, heartbeat: float, braking: int, window: int) -> list[Setting]:
    """Return what else must hold: watchdogs both ways, reactions, mode.

    Parameters
    ----------
    cycle, heartbeat : float
        s.
    braking : int
        Quick stop deceleration, counts/s^2.
    window : int
        The drive's own limit of the following error, counts.
    """
    milliseconds = round(1000 * heartbeat)
    return [
        Setting(HEARTBEAT, milliseconds),
        Setting(CONSUMER, MASTER << 16 | 3 * milliseconds),
        Setting(ABORT_OPTION, QUICK_STOP_WHEN_ALONE),
        Setting(QUICK_STOP_OPTION, QUICK_STOP_BY_RAMP),
        Setting(FAULT_OPTION, QUICK_STOP_BY_RAMP),
        Setting(BRAKING, braking),
        Setting(WINDOW, window),
        Setting(WINDOW_TIME, milliseconds),
        Setting(CYCLE, round(1000 * cycle)),
        Setting(CYCLE_UNIT, -3),
        Setting(MODE, Mode.CYCLIC_POSITION, shown_by=MODE_SHOWN),
    ]
