"""Roll, pitch and yaw for display: enclosures of those of a certified rotation, and plain ones as text."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cdpr_interval.exact.enclosure import Bounds

Range = tuple[float, float]

MARGIN = 1e-14
"""rad; the C library's atan2 errs by a few units in the last place of an angle up to 2 pi."""


def rpy_enclosures(rotation: Bounds) -> tuple[Range | None, Range | None, Range | None]:
    """Return ranges of roll, pitch and yaw in degrees, for R = Rz(yaw) Ry(pitch) Rx(roll).

    Parameters
    ----------
    rotation : (3, 3, 2) array

    Returns
    -------
    tuple of (lo, hi) or None
        None where the box does not determine the angle: roll and yaw at a pitch of a quarter turn.
    """
    entry = [[(float(lo), float(hi)) for lo, hi in row] for row in rotation.tolist()]
    roll = _atan2(entry[2][1], entry[2][2])
    yaw = _atan2(entry[1][0], entry[0][0])
    sine = entry[2][0]
    low, high = (math.asin(max(-1.0, min(1.0, -bound))) for bound in (sine[1], sine[0]))
    # Near a quarter turn asin magnifies the rounding of its argument: the margin grows with it.
    return roll, _degrees(low - 2 * MARGIN, high + 2 * MARGIN), yaw


def shown_angles(angles: Sequence[float]) -> str:
    """Return angles in rad as degrees for a person to read."""
    return ", ".join(f"{math.degrees(angle):z.4f}deg" for angle in angles)


def _atan2(y: Range, x: Range) -> Range | None:
    """Return the range of the angle of the points in a box that does not hold the origin."""
    if y[0] <= 0.0 <= y[1] and x[0] <= 0.0:
        if x[1] >= 0.0:
            return None
        # The box crosses the half line where atan2 jumps: measure from there.
        turned = _atan2((-y[1], -y[0]), (-x[1], -x[0]))
        assert turned is not None
        return turned[0] + 180.0, turned[1] + 180.0
    corners = [math.atan2(b, a) for a in x for b in y]
    return _degrees(min(corners) - MARGIN, max(corners) + MARGIN)


def _degrees(lo: float, hi: float) -> Range:
    return math.degrees(lo) * (1.0 - math.copysign(MARGIN, lo)), math.degrees(hi) * (
        1.0 + math.copysign(MARGIN, hi)
    )
