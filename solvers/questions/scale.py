"""Lengths that cannot be meant: hundreds of times the size of the robot, as millimetres taken for metres."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from cdpr_interval.exact.range import Range
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import Point, Scalar

ABSURD = 100
"""Times the size of the robot. Cables are a third of it or longer, so that millimetres taken for metres make
them 300 times as long or more; a long pendulum on a small frame is some ten times."""


def absurd_lengths(robot: Robot, lengths: Sequence[tuple[float | Fraction, float | Fraction]]) -> str | None:
    """Return a sentence about lengths in m far beyond the size of the robot, None where there are none.

    The size is the diagonal of a box around the exit points, and that of one around the platform anchors.
    """
    size = _diagonal([cable.frame_anchor for cable in robot.cables]) + _diagonal(
        [cable.platform_anchor for cable in robot.cables]
    )
    long = [
        (name, lo) for name, (lo, _) in zip(robot.cable_names, lengths, strict=True) if lo > ABSURD * size
    ]
    if not size or not long:
        return None
    name, length = long[0]
    others = f" (and {len(long) - 1} more)" if len(long) > 1 else ""
    shown, times = f"{float(length):.6g}", f"{float(length) / size:.3g}"
    text = f"{name}{others} is {shown} m long, {times} times the size of the robot ({size:.3g} m)"
    return f"{text}: millimetres are written with their unit, as in 7500mm"


def _diagonal(points: Sequence[Point]) -> float:
    return math.hypot(*(float(_extent([point[axis] for point in points])) for axis in range(3)))


def _extent(values: Sequence[Scalar]) -> Fraction:
    lows = [value.lo if isinstance(value, Range) else value for value in values]
    highs = [value.hi if isinstance(value, Range) else value for value in values]
    return max(highs) - min(lows)
