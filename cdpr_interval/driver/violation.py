"""A broken rule: which one, what was seen, and the error that ends the cycle in which it is found."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from cdpr_interval.errors import CdprError

OVERSPEED = 1.25
"""Share of a winch's speed limit that the measured speed may reach; the target's may reach 1."""


class Interlock(StrEnum):
    """Why the winches were stopped."""

    LENGTH = "length"
    VELOCITY = "velocity"
    ACCELERATION = "acceleration"
    FOLLOWING_ERROR = "following-error"
    COHERENCE = "coherence"
    TORQUE = "torque"
    DATA_AGE = "data-age"
    HEARTBEAT = "heartbeat"
    NOT_OPERATIONAL = "not-operational"
    EMERGENCY = "emergency"
    DRIVE_FAULT = "drive-fault"
    ENABLE_LOST = "enable-lost"
    NOT_ENABLED = "not-enabled"
    MODE = "mode"
    REBOOT = "reboot"
    MARK = "mark"
    CALLER = "caller"
    OPERATOR = "operator"
    BUS = "bus"
    INTERNAL = "internal"


@dataclass(frozen=True)
class Violation:
    """One rule that was broken."""

    interlock: Interlock
    text: str
    """What was seen, with its value and the limit."""
    cable: str | None = None
    """None: not one cable's."""
    time: float = 0.0
    """s on the bus's clock."""

    def __str__(self) -> str:
        who = "" if self.cable is None else f"{self.cable}: "
        return f"{who}{self.interlock.value}: {self.text}"


class Stopped(CdprError):
    """A rule is broken: raised where the cycle cannot go on."""

    def __init__(self, violation: Violation) -> None:
        super().__init__(str(violation))
        self.violation = violation
