"""What may be asked of the winches: every request is checked before anything changes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from cdpr_interval.driver.axis import Axis
from cdpr_interval.driver.setpoints import Lengths, Stream, sampled, smooth_time
from cdpr_interval.errors import CdprError, InputError
from cdpr_interval.exact.range import Range

FURTHEST_SETPOINT = 10.0
"""s ahead of now."""
LONGEST_JOG = Fraction(1, 10)
"""m in one jog: without a reference nothing else protects the cable."""
JOG_SHARE = 0.2
"""Of the speed and acceleration limits, for jogs."""


class Refused(CdprError):
    """The winches are not in a state in which that may be asked for; nothing was changed."""


def limits_text(axis: Axis) -> str:
    """Return the length limits for a message."""
    low, high = (float(limit) for limit in axis.limits.length)
    return f"limits {low:g} to {high:g} m"


def require_inside(axis: Axis) -> None:
    """Raise `Refused` when a cable is beyond its limits: it would be enabled with a target there."""
    length = axis.length
    if axis.has_left_the_drum or (length is not None and not axis.within_limits(length)):
        shown = "off the drum" if length is None else f"{float(length):.4f} m"
        raise Refused(f"{axis.name} is {shown}, {limits_text(axis)}: bring it back by hand")


def require_possible(axis: Axis, length: Range) -> None:
    """Raise `InputError` for a home length that is partly beyond the limits."""
    if not (axis.within_limits(length.lo) and axis.within_limits(length.hi)):
        got = f"[{float(length.lo):.6g}, {float(length.hi):.6g}] m"
        raise InputError(f"{axis.name}: home length {got}, {limits_text(axis)}")


def lengths_within(axes: Sequence[Axis], lengths: Sequence[float]) -> Lengths:
    """Return a set-point as floats; `InputError` for what is no number or beyond a limit."""
    for axis, length in zip(axes, lengths, strict=True):
        if not math.isfinite(length) or not axis.within_limits(Fraction(length)):
            raise InputError(f"{axis.name}: set-point {length!r} m, {limits_text(axis)}")
    return tuple(float(length) for length in lengths)


def require_time(time: float, last: float, now: float) -> None:
    """Raise `InputError` for a set-point that is not later than the last one and now, or too far ahead."""
    if not math.isfinite(time) or time <= max(last, now):
        raise InputError(f"at: must be later than {max(last, now):.4f} s, got {time!r}")
    if time > now + FURTHEST_SETPOINT:
        raise InputError(f"at: at most {FURTHEST_SETPOINT:g} s ahead, got {time - now:.3f} s")


def require_speed(axes: Sequence[Axis], goal: Lengths, time: float, stream: Stream) -> None:
    """Raise `InputError` for a set-point that cannot be reached in time."""
    seconds = time - stream.times[-1]
    for axis, end, start in zip(axes, goal, stream.points[-1], strict=True):
        # Where marks correct the cable, the correction must have room beside the set-points.
        room = 0.0 if axis.watch is None else float(axis.correction_rate)
        speed, limit = (end - start) / seconds, float(axis.limits.velocity) - room
        # The limit itself is allowed, and rounding of times and lengths is no fault.
        if abs(speed) > limit * (1 + 1e-9):
            raise InputError(f"{axis.name}: {speed:+.4f} m/s to this set-point, limit {limit:.4f} m/s")


def jog(axes: Sequence[Axis], cable: int, way: float, now: float, cycle: float) -> Stream:
    """Return the slow motion of one winch by a way in m; `InputError`: too long, or beyond a limit."""
    if not (math.isfinite(way) and abs(way) <= LONGEST_JOG):
        raise InputError(f"jog: at most {float(LONGEST_JOG):g} m at a time, got {way!r}")
    axis = axes[cable]
    ways = [(float(one.commanded), float(one.commanded)) for one in axes]
    start, end = ways[cable][0], ways[cable][0] + way
    if axis.reference is not None and not axis.within_limits(Fraction(end)):
        raise InputError(f"jog: {axis.name} would be {end:.4f} m, {limits_text(axis)}")
    ways[cable] = (start, end)
    speed, acceleration = float(axis.limits.velocity), float(axis.limits.acceleration)
    return sampled(now, smooth_time(way, JOG_SHARE * speed, JOG_SHARE * acceleration), cycle, ways)
