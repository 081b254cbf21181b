"""Angles known exactly, or between exact bounds: so many degrees, or so many radians."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import NamedTuple

from cdpr_interval.exact.decimals import exact_text
from cdpr_interval.exact.range import Range

LONGEST = 1000
"""Digits of a decimal that stands for an angle."""
WITH_UNIT = re.compile(r"(.*?[0-9.])\s*(deg|°|rad)", re.DOTALL)
"""A number and the unit of an angle."""


class Angle(NamedTuple):
    """Bounds of an angle; 120 degrees are exactly two thirds of pi, which no number of radians is."""

    bounds: Range
    in_degrees: bool

    @staticmethod
    def degrees(value: Fraction | int) -> Angle:
        """Return the angle of so many degrees."""
        return Angle(Range.exact(value), True)

    @property
    def is_exact(self) -> bool:
        """True where the bounds are equal."""
        return self.bounds.lo == self.bounds.hi

    def __str__(self) -> str:
        """Return the angle as it is typed: 30deg, 0.5rad, 29..31deg."""
        unit = "deg" if self.in_degrees else "rad"
        lo, hi = (exact_text(end, LONGEST) for end in self.bounds)
        return f"{lo}{unit}" if self.is_exact else f"{lo}{unit}..{hi}{unit}"
