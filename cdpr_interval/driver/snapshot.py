"""What is known after a cycle: immutable, so that any thread may read it at leisure."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from cdpr_interval.driver.axis import Axis
from cdpr_interval.driver.bus import Feedback
from cdpr_interval.driver.cia402 import DriveState, NoTransition, state_of
from cdpr_interval.driver.marks import MarkEvent
from cdpr_interval.driver.reference import Reference, ReferenceState
from cdpr_interval.driver.violation import Violation
from cdpr_interval.driver.winch import bounds


class GroupState(StrEnum):
    """States of all winches together."""

    OFF = "off"
    """Not connected."""
    DISABLED = "disabled"
    """Brakes hold."""
    ENABLING = "enabling"
    HOLDING = "holding"
    """The drives hold their targets, which stand still."""
    MOVING = "moving"
    STOPPED = "stopped"
    """Quick stop, latched until `acknowledge`."""
    RESETTING = "resetting"
    """Acknowledged: faults of drives are reset."""


@dataclass(frozen=True, slots=True)
class CableSnapshot:
    """One cable after a cycle."""

    name: str
    state: ReferenceState
    reference: Reference | None
    counts: int
    """Unwrapped."""
    target: int
    """Unwrapped; what was sent."""
    length: float | None
    """m, most likely; None without a reference."""
    commanded: float | None
    """m: the length the target stands for."""
    speed: float
    """m/s, measured."""
    following_error: float
    """m."""
    drive: DriveState | None
    """None: not heard yet."""
    torque: int
    """Per mille of the rated torque."""

    def length_range(self) -> tuple[float, float] | None:
        """Return proved bounds of the unstrained length in m, or None unless REFERENCED.

        Guarantee
        ---------
        As `Reference.length_range`, and the doubles enclose its bounds.
        """
        if self.reference is None or self.state is not ReferenceState.REFERENCED:
            return None
        return bounds(self.reference.length_range(self.counts))

    def to_json(self) -> dict[str, Any]:
        """Return plain data for a log."""
        return {
            "cable": self.name,
            "reference": self.state.value,
            "counts": self.counts,
            "target": self.target,
            "length_m": self.length,
            "commanded_m": self.commanded,
            "speed_m_s": self.speed,
            "drive": None if self.drive is None else self.drive.value,
            "torque_per_mille": self.torque,
        }


@dataclass(frozen=True, slots=True)
class Snapshot:
    """All winches after a cycle."""

    time: float
    """s on the bus's clock."""
    cycle: int
    state: GroupState
    causes: tuple[Violation, ...]
    """Why the winches were stopped; empty when nothing is latched."""
    cables: tuple[CableSnapshot, ...]
    marks: tuple[MarkEvent, ...] = ()
    """What marks said in this cycle."""

    @property
    def latched(self) -> bool:
        """True until a violation is acknowledged."""
        return bool(self.causes)

    def to_json(self) -> dict[str, Any]:
        """Return plain data for a log."""
        return {
            "time_s": self.time,
            "cycle": self.cycle,
            "state": self.state.value,
            "causes": [str(cause) for cause in self.causes],
            "cables": [cable.to_json() for cable in self.cables],
        }


def pictured(axis: Axis, heard: Feedback) -> CableSnapshot:
    """Return what is known of one winch."""
    length = axis.length
    known = axis.reference is not None and length is not None
    return CableSnapshot(
        axis.name,
        axis.state,
        axis.reference,
        axis.counts,
        axis.target,
        None if length is None else float(length),
        float(axis.commanded) if known else None,
        axis.speed,
        axis.following_error,
        shown_state(heard),
        heard.torque,
    )


def shown_state(heard: Feedback) -> DriveState | None:
    """Return the state a drive shows; None when it was not heard, or shows none."""
    if heard.heard_at is None:
        return None
    try:
        return state_of(heard.status)
    except NoTransition:
        return None
