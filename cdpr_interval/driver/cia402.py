"""The state machine of a CiA 402 drive as pure functions: statusword to state, state and goal to controlword.

References: CiA 402-2 (IEC 61800-7-201), statusword 0x6041, controlword 0x6040.
"""

from __future__ import annotations

from enum import Enum, IntEnum, IntFlag

from cdpr_interval.errors import CdprError


class Mode(IntEnum):
    """Modes of operation (0x6060); the driver uses the cyclic position mode only."""

    NONE = 0
    CYCLIC_POSITION = 8


class Control(IntFlag):
    """Bits of the controlword the driver uses. Bits 4 to 6 depend on the mode and stay 0."""

    SWITCH_ON = 1
    ENABLE_VOLTAGE = 2
    NO_QUICK_STOP = 4
    ENABLE_OPERATION = 8
    FAULT_RESET = 128


DISABLE_VOLTAGE = 0
QUICK_STOP = int(Control.ENABLE_VOLTAGE)
SHUTDOWN = int(Control.ENABLE_VOLTAGE | Control.NO_QUICK_STOP)
SWITCH_ON = int(SHUTDOWN | Control.SWITCH_ON)
ENABLE_OPERATION = int(SWITCH_ON | Control.ENABLE_OPERATION)
FAULT_RESET = int(Control.FAULT_RESET)


class DriveState(Enum):
    """States of a drive."""

    NOT_READY = "not ready to switch on"
    DISABLED = "switch on disabled"
    READY = "ready to switch on"
    SWITCHED_ON = "switched on"
    ENABLED = "operation enabled"
    QUICK_STOP = "quick stop active"
    FAULT_REACTION = "fault reaction active"
    FAULT = "fault"


class Goal(Enum):
    """What the driver wants of a drive."""

    DISABLED = "disabled"
    ENABLED = "enabled"
    STOPPED = "stopped"


class NoTransition(CdprError):
    """There is no controlword that leads from a state to a goal."""


_CODES = {
    (0x4F, 0x00): DriveState.NOT_READY,
    (0x4F, 0x40): DriveState.DISABLED,
    (0x6F, 0x21): DriveState.READY,
    (0x6F, 0x23): DriveState.SWITCHED_ON,
    (0x6F, 0x27): DriveState.ENABLED,
    (0x6F, 0x07): DriveState.QUICK_STOP,
    (0x4F, 0x0F): DriveState.FAULT_REACTION,
    (0x4F, 0x08): DriveState.FAULT,
}
_FAULTS = frozenset({DriveState.FAULT_REACTION, DriveState.FAULT})
_TO_ENABLED = {
    DriveState.NOT_READY: DISABLE_VOLTAGE,
    DriveState.DISABLED: SHUTDOWN,
    DriveState.READY: SWITCH_ON,
    DriveState.SWITCHED_ON: ENABLE_OPERATION,
    DriveState.ENABLED: ENABLE_OPERATION,
}


def state_of(statusword: int) -> DriveState:
    """Return the state that a statusword shows.

    Raises
    ------
    NoTransition
        When the word is none of the standard's.
    """
    for (mask, code), state in _CODES.items():
        if statusword & mask == code:
            return state
    raise NoTransition(f"statusword 0x{statusword:04x} is no state of CiA 402")


def statusword_of(state: DriveState) -> int:
    """Return the bits of a statusword that show a state."""
    return next(code for (_, code), known in _CODES.items() if known is state)


def controlword(state: DriveState, goal: Goal) -> int:
    """Return the next controlword on the way from a state to a goal.

    One step a call: the drive must answer before the next. A fault is never reset here, and from
    quick stop or fault there is no way to ENABLED: that takes `FAULT_RESET` and DISABLED first.

    Raises
    ------
    NoTransition
        For the goal ENABLED in a fault or in quick stop.
    """
    if goal is Goal.STOPPED:
        return QUICK_STOP
    if goal is Goal.DISABLED:
        return DISABLE_VOLTAGE
    if state not in _TO_ENABLED:
        raise NoTransition(f"no way from '{state.value}' to 'operation enabled' without an acknowledgement")
    return _TO_ENABLED[state]


def answer(state: DriveState, control: int, previous: int) -> DriveState:
    """Return the state of a drive after a controlword: the drive's side of the machine.

    Parameters
    ----------
    state : DriveState
        Where the drive is; reactions that end by themselves (quick stop, fault reaction) are the drive's own.
    control : int
        The controlword now.
    previous : int
        The controlword before: a fault is reset by a rising edge only.
    """
    if state in _FAULTS or state is DriveState.NOT_READY:
        edge = control & ~previous & Control.FAULT_RESET
        return DriveState.DISABLED if state is DriveState.FAULT and edge else state
    if not control & Control.ENABLE_VOLTAGE:
        return DriveState.DISABLED
    if not control & Control.NO_QUICK_STOP:
        return (
            DriveState.QUICK_STOP
            if state in (DriveState.ENABLED, DriveState.QUICK_STOP)
            else DriveState.DISABLED
        )
    if state is DriveState.QUICK_STOP:
        return state
    wanted = control & (Control.SWITCH_ON | Control.ENABLE_OPERATION)
    if state is DriveState.DISABLED:
        return DriveState.READY if not wanted & Control.SWITCH_ON else state
    if not wanted & Control.SWITCH_ON:
        return DriveState.READY
    if state is DriveState.READY:
        return DriveState.SWITCHED_ON
    return DriveState.ENABLED if wanted & Control.ENABLE_OPERATION else DriveState.SWITCHED_ON
