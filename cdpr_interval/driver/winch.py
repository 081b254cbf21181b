"""The model of one winch: encoder counts to paid-out length and back, exactly, and with bounds."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

from cdpr_interval.driver.drum import DrumLaw, law_of
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.winch import Winch


@dataclass(frozen=True)
class WinchModel:
    """Counts <-> drum turns <-> length, all exact rational.

    Lengths are **unstrained**, from the exit point A to the cable's end. A stretched cable under tension T is
    longer: its unstrained length is L / (1 + T / EA); convert outside, the drum knows nothing of tension.
    Fleet angles and exit pulleys belong to the robot's geometry.
    """

    winch: Winch
    zero: int = 0
    """Counts, unwrapped, at 0 turns of the drum law."""

    @cached_property
    def law(self) -> DrumLaw:
        """The drum's law."""
        return law_of(self.winch.drum, self.counts_per_drum_turn)

    @cached_property
    def counts_per_drum_turn(self) -> Fraction:
        """Exact: counts per motor turn times the gear ratio."""
        return self.winch.counts_per_turn * self.winch.gear_ratio

    def turns(self, counts: int | Fraction) -> Fraction:
        """Return the drum turns at an encoder reading, counted from the law's zero."""
        return self.winch.sign * (counts - self.zero) / self.counts_per_drum_turn

    def length(self, counts: int | Fraction) -> Fraction:
        """Return the nominal length in m; `OffTheDrum` where there is none."""
        return self.law.length(self.turns(counts))

    def counts(self, length: Fraction) -> int:
        """Return the reading nearest to a nominal length in m; `OffTheDrum` where there is none."""
        return self.zero + round(self.winch.sign * self.law.turns(length) * self.counts_per_drum_turn)

    def rate(self, counts: int) -> Range:
        """Return bounds of dL/dcounts in m, signed."""
        slope = self.law.slope(self.turns(counts))
        factor = self.winch.sign / self.counts_per_drum_turn
        return slope * Range(factor, factor)

    def nominal_rate(self, counts: int) -> float:
        """Return the nominal dL/dcounts in m, signed, as a float: for speeds and errors."""
        if self.law.breakpoints:
            return float(self.rate(counts).mid)
        return self._only_rate

    @cached_property
    def _only_rate(self) -> float:
        return float(self.rate(self.zero).mid)

    def turns_range(self, counts: int) -> Range:
        """Return bounds of the true drum turns at a reading, with the encoder's error."""
        middle, error = self.turns(counts), self.winch.encoder_error / self.counts_per_drum_turn
        return Range(middle - error, middle + error)

    def span(self, start: int, end: int) -> Range:
        """Return bounds of the length in m paid out between two readings."""
        if start == end:
            # The same reading twice: the true angle may still have moved within the encoder's error.
            slope = self.law.slope(self.turns(start)).hi
            return Range(Fraction(0), Fraction(0)).widened(
                2 * self.winch.encoder_error * slope / self.counts_per_drum_turn
            )
        return self.law.span(self.turns_range(start), self.turns_range(end))

    def placed(self, counts: int, length: Fraction) -> WinchModel:
        """Return the model whose nominal length at a reading is the given one to within half a count."""
        turns = self.law.turns(length)
        return replace(self, zero=counts - round(self.winch.sign * turns * self.counts_per_drum_turn))


def bounds(value: Range) -> tuple[float, float]:
    """Return doubles around a range: what the solver takes as a length."""
    lo, hi = float(value.lo), float(value.hi)
    lo = math.nextafter(lo, -math.inf) if Fraction(lo) > value.lo else lo
    hi = math.nextafter(hi, math.inf) if Fraction(hi) < value.hi else hi
    return lo, hi
