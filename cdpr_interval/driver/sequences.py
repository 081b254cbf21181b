"""From brakes to torque and from faults to brakes: all drives together, a step a cycle, in bounded time."""

from __future__ import annotations

from collections.abc import Sequence

from cdpr_interval.driver import cia402
from cdpr_interval.driver.axis import Axis
from cdpr_interval.driver.bus import Feedback
from cdpr_interval.driver.cia402 import DriveState, Goal, Mode, NoTransition
from cdpr_interval.driver.snapshot import shown_state
from cdpr_interval.driver.violation import Interlock, Stopped, Violation

ENABLE_TIME = 2.0
"""s that the drives have to reach OPERATION ENABLED."""
RESET_TIME = 2.0
"""s that the drives have to leave their faults."""
RESET_CYCLES = 4
"""A fault reset is a rising edge: half of so many cycles low, half high."""


def enabling(
    axes: Sequence[Axis], heard: Sequence[Feedback], now: float, deadline: float, cycle: int
) -> tuple[list[int], bool]:
    """Return controlwords that lead every drive one step nearer to OPERATION ENABLED; whether all are there.

    Until a drive is enabled its target is where it is. No drive is enabled before it shows the wanted mode.

    Raises
    ------
    Stopped
        At the deadline, or when a drive is in a state from which there is no way.
    """
    states = [shown_state(one) for one in heard]
    if all(state is DriveState.ENABLED for state in states):
        return [cia402.ENABLE_OPERATION] * len(axes), True
    controls = []
    for axis, one, state in zip(axes, heard, states, strict=True):
        if state is not DriveState.ENABLED:
            axis.follow_reading()
            if now > deadline:
                raise Stopped(Violation(Interlock.NOT_ENABLED, _why_late(one, state), axis.name))
        controls.append(_step(axis, one, state))
    return controls, False


def _step(axis: Axis, heard: Feedback, state: DriveState | None) -> int:
    if state is None:
        return cia402.DISABLE_VOLTAGE
    if state is DriveState.SWITCHED_ON and heard.mode != Mode.CYCLIC_POSITION:
        return cia402.SWITCH_ON
    try:
        return cia402.controlword(state, Goal.ENABLED)
    except NoTransition as error:
        raise Stopped(Violation(Interlock.NOT_ENABLED, str(error), axis.name)) from None


def _why_late(heard: Feedback, state: DriveState | None) -> str:
    shown = "unknown" if state is None else state.value
    mode = (
        ""
        if heard.mode == Mode.CYCLIC_POSITION
        else f", mode {heard.mode} instead of {Mode.CYCLIC_POSITION:d}"
    )
    return f"not enabled within {ENABLE_TIME:g} s: the drive is in '{shown}'{mode}"


def resetting(
    axes: Sequence[Axis], heard: Sequence[Feedback], now: float, deadline: float, cycle: int
) -> tuple[list[int], bool]:
    """Return controlwords that lead every drive from its fault to SWITCH ON DISABLED; whether all are there.

    Raises
    ------
    Stopped
        At the deadline.
    """
    states = [shown_state(one) for one in heard]
    high = cycle % RESET_CYCLES >= RESET_CYCLES // 2
    controls = []
    for axis, one, state in zip(axes, heard, states, strict=True):
        axis.follow_reading()
        if now > deadline and (state is not DriveState.DISABLED or one.emergency):
            text = f"the fault could not be reset within {RESET_TIME:g} s"
            raise Stopped(Violation(Interlock.DRIVE_FAULT, text, axis.name))
        controls.append(cia402.FAULT_RESET if high and state is DriveState.FAULT else cia402.DISABLE_VOLTAGE)
    well = all(state is DriveState.DISABLED for state in states) and not any(one.emergency for one in heard)
    return controls, well
