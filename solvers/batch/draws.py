"""Random deviations that are the same on every machine: from a seed, rounded to short decimals."""

from __future__ import annotations

import random
from dataclasses import dataclass
from decimal import Context, Decimal, Inexact
from fractions import Fraction
from statistics import NormalDist

from solvers.batch.job_schema import AXES, SpreadBlock

DIGITS = 9
"""Significant digits of a deviation: short decimals, and the last bits of a library function do not show."""
USUAL_CUT = 4.0
"""sigma."""
_NORMAL = NormalDist()
_EXACT = Context(prec=400, traps=[Inexact])
"""Numbers of a file have fewer digits: sums and products of two are exact, or an exception."""


@dataclass(frozen=True)
class Spread:
    """How a deviation is drawn."""

    is_normal: bool
    width: float
    """Half width or sigma."""
    is_relative: bool
    """True: the deviation is a share of the nominal value."""
    cut: float
    """A normal distribution ends at so many sigma."""
    axes: tuple[bool, bool, bool] = (True, True, True)
    """Which coordinates of an anchor are moved."""

    @classmethod
    def of(cls, block: SpreadBlock) -> Spread:
        """Return the spread of a block of the job file."""
        relative = block.relative_half_width or block.relative_sigma
        width = relative or block.half_width or block.sigma
        assert width is not None, "the model has checked that one is given"
        cut = USUAL_CUT if block.cut is None else float(block.cut)
        axes = getattr(block, "axes", None) or AXES
        x, y, z = (axis in axes for axis in AXES)
        return cls(block.distribution == "normal", float(width), relative is not None, cut, (x, y, z))

    @property
    def furthest(self) -> Fraction:
        """The largest deviation, in the unit of the number or as a share."""
        return Fraction(self.width * self.cut if self.is_normal else self.width)

    def reaches_zero(self, nominal: Fraction) -> bool:
        """Return whether a positive number could be moved to zero or below."""
        return (nominal * self.furthest if self.is_relative else self.furthest) >= nominal

    def draw(self, generator: random.Random) -> Decimal:
        """Return one deviation, an exact decimal."""
        share = generator.random()
        if self.is_normal:
            least = _NORMAL.cdf(-self.cut)
            # random() can return 0, where the inverse of a wide cut ends.
            share = max(least + share * (1.0 - 2.0 * least), 1e-300)
            deviation = self.width * _NORMAL.inv_cdf(share)
        else:
            deviation = self.width * (2.0 * share - 1.0)
        return Decimal(f"{deviation:.{DIGITS - 1}e}")

    def applied(self, nominal: Decimal, deviation: Decimal) -> Decimal:
        """Return a number moved by a deviation, exactly."""
        if self.is_relative:
            return _EXACT.multiply(nominal, _EXACT.add(deviation, Decimal(1)))
        return _EXACT.add(nominal, deviation)


def text_of(value: Decimal) -> str:
    """Return the canonical text of a number: no exponent, no zeros at the end."""
    return f"{_EXACT.normalize(value):f}"
