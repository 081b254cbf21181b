"""What must hold in every cycle: a broken rule is a violation, and any violation stops all winches."""

from __future__ import annotations

from cdpr_interval.driver.axis import Axis
from cdpr_interval.driver.bus import Feedback
from cdpr_interval.driver.cia402 import DriveState, Mode, NoTransition, state_of
from cdpr_interval.driver.violation import OVERSPEED, Interlock, Violation

MISSED_CYCLES = 3
"""Cycles without process data after which a drive counts as lost (30 ms at 100 Hz)."""
MISSED_HEARTBEATS = 3
"""Heartbeat periods after which a drive counts as dead."""


def communication(axis: Axis, heard: Feedback, now: float, cycle: float, heartbeat: float) -> list[Violation]:
    """Return what is wrong with the connection to one drive."""
    found = []
    name = axis.name
    age = None if heard.heard_at is None else now - heard.heard_at
    if heard.boots:
        found.append(Violation(Interlock.REBOOT, "the drive started anew: connect again", name, now))
    if age is None or age > MISSED_CYCLES * cycle:
        text = "no process data yet" if age is None else f"process data are {1e3 * age:.0f} ms old"
        found.append(Violation(Interlock.DATA_AGE, text, name, now))
    silence = None if heard.heartbeat_at is None else now - heard.heartbeat_at
    if silence is None or silence > MISSED_HEARTBEATS * heartbeat:
        text = "no heartbeat yet" if silence is None else f"last heartbeat {1e3 * silence:.0f} ms ago"
        found.append(Violation(Interlock.HEARTBEAT, text, name, now))
    if not heard.operational:
        found.append(Violation(Interlock.NOT_OPERATIONAL, "the node is not OPERATIONAL", name, now))
    return found


def drive_health(axis: Axis, heard: Feedback, now: float) -> list[Violation]:
    """Return what a drive says is wrong with itself."""
    found = []
    if heard.emergency:
        text = f"the drive sent error code 0x{heard.emergency:04x}"
        found.append(Violation(Interlock.EMERGENCY, text, axis.name, now))
    try:
        state = state_of(heard.status)
    except NoTransition as error:
        return [*found, Violation(Interlock.DRIVE_FAULT, str(error), axis.name, now)]
    if state in (DriveState.FAULT, DriveState.FAULT_REACTION):
        found.append(Violation(Interlock.DRIVE_FAULT, f"the drive is in '{state.value}'", axis.name, now))
    limit = axis.limits.torque
    if limit is not None and abs(heard.torque) > 1000 * limit:
        text = f"{abs(heard.torque) / 1000:.3f} of the rated torque, limit {float(limit):.3f}"
        found.append(Violation(Interlock.TORQUE, text, axis.name, now))
    return found


def motion(axis: Axis, now: float) -> list[Violation]:
    """Return what is wrong with how a cable moves, enabled or not."""
    found = []
    fastest = float(axis.limits.velocity)
    if abs(axis.speed) > OVERSPEED * fastest:
        text = f"{abs(axis.speed):.4f} m/s measured, limit {fastest:.4f} m/s"
        found.append(Violation(Interlock.VELOCITY, text, axis.name, now))
    length = axis.length
    if axis.has_left_the_drum or (
        length is not None and not axis.within_limits(length, axis.limits.following_error)
    ):
        low, high = (float(end) for end in axis.limits.length)
        text = (
            "off the drum" if length is None else f"{float(length):.4f} m, limits {low:.4f} to {high:.4f} m"
        )
        found.append(Violation(Interlock.LENGTH, text, axis.name, now))
    return found


def following(axis: Axis, heard: Feedback, now: float) -> list[Violation]:
    """Return what is wrong with an enabled drive that follows its target."""
    found = []
    state = state_of(heard.status)
    if state is not DriveState.ENABLED:
        found.append(Violation(Interlock.ENABLE_LOST, f"the drive is in '{state.value}'", axis.name, now))
    if heard.mode != Mode.CYCLIC_POSITION:
        found.append(
            Violation(Interlock.MODE, f"the drive shows mode {heard.mode}, wanted 8", axis.name, now)
        )
    error, limit = axis.following_error, float(axis.limits.following_error)
    if abs(error) > limit:
        text = f"{error:+.4f} m behind its target, limit {limit:.4f} m"
        found.append(Violation(Interlock.FOLLOWING_ERROR, text, axis.name, now))
    return found


def coherence(axes: list[Axis], limit: float, now: float) -> list[Violation]:
    """Return whether one cable lags behind the others more than allowed: it would load them."""
    errors = [axis.following_error for axis in axes]
    spread = max(errors) - min(errors)
    if spread <= limit:
        return []
    text = f"following errors differ by {spread:.4f} m, limit {limit:.4f} m"
    return [Violation(Interlock.COHERENCE, text, None, now)]
