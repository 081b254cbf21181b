"""What the driver needs of a bus with drives: process data out, process data in, and how old they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from cdpr_interval.errors import CdprError

PROBE_OFF = 0x0000
PROBE_ARMED = 0x0011
"""Touch probe 1 (0x60B8): enabled, first event, rising edge."""
PROBE_ENABLED = 0x0001
PROBE_CAUGHT = 0x0002
"""Bits of 0x60B9: enabled; a rising edge is stored."""


class BusError(CdprError):
    """The bus, or a drive on it, cannot be used."""


@dataclass(frozen=True, slots=True)
class Command:
    """What one drive gets each cycle."""

    control: int
    """Controlword 0x6040."""
    mode: int
    """Mode of operation 0x6060."""
    target: int
    """Target position 0x607A, signed 32 bits, counts."""
    probe: int = PROBE_OFF
    """Touch probe function 0x60B8."""


@dataclass(frozen=True, slots=True)
class Feedback:
    """What one drive said last; the fields of one cycle come from one cycle."""

    status: int = 0
    """Statusword 0x6041."""
    mode: int = 0
    """Mode of operation display 0x6061."""
    position: int = 0
    """Position actual value 0x6064, signed 32 bits, counts: it wraps."""
    torque: int = 0
    """Torque actual value 0x6077, per mille of the rated torque."""
    probe: int = 0
    """Touch probe status 0x60B9."""
    probe_position: int = 0
    """Touch probe 1 positive edge 0x60BA, counts."""
    heard_at: float | None = None
    """Time of the process data on the bus's clock; None: nothing was heard, the fields above mean nothing."""
    heartbeat_at: float | None = None
    """Time of the last heartbeat; None: none yet."""
    operational: bool = False
    """The last heartbeat said OPERATIONAL."""
    emergency: int = 0
    """Error code of the last emergency message; 0: none, or the drive said that it is over."""
    boots: int = 0
    """Boot-up messages since `connect`: more than 0 means that the drive started anew."""


class DriveBus(Protocol):
    """Some drives that move in one cycle.

    One thread calls `write_all` and `read_all` in turn; `quick_stop_all` may be called by any thread
    at any time. Times are seconds of the bus's own monotonic clock, `now`.
    """

    @property
    def count(self) -> int:
        """The number of drives."""

    def now(self) -> float:
        """Return the time in s."""

    def connect(self) -> None:
        """Find the drives, configure them, read the configuration back, let process data flow.

        Raises
        ------
        BusError
            One line for each thing that is missing or refused; no drive is enabled then.
        InputError
            A library that the bus needs is not installed.
        """

    def write_all(self, commands: Sequence[Command]) -> None:
        """Send the commands of one cycle, in the order of the drives; they take effect together (SYNC).

        No commands at all: only SYNC, so that the drives say where they are.
        """

    def read_all(self) -> tuple[Feedback, ...]:
        """Wait for the answers of this cycle, no longer than its deadline, and return what was heard last."""

    def quick_stop_all(self) -> None:
        """Send quick stop to every drive at once; never raises, whatever the state of the bus."""

    def close(self) -> None:
        """Leave the bus; drives notice that the master's heartbeat ends."""
