"""The law of a drum: how much cable is paid out after so many turns, in straight pieces with bounds.

Every known drum is piecewise linear: each turn of a helical drum pays out the same length, each layer of a
multilayer drum has its own, and measured points are joined by straight lines. So one class does for all.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise

from cdpr_interval.driver.polyline import Polyline
from cdpr_interval.errors import CdprError
from cdpr_interval.exact.irrational import PI, outward, square_root
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.winch import Drum, HelicalDrum, LinearDrum, MultilayerDrum, TableDrum

ZERO = Fraction(0)
TWO_PI = PI + PI


class OffTheDrum(CdprError):
    """A place on the drum where there is no cable, or none was measured."""


@dataclass(frozen=True)
class DrumLaw:
    """Paid-out length against drum turns: continuous, ascending, straight between breakpoints.

    The length is that from the exit point A to the end of the cable, without tension; only where no mark
    or reference has moved it does it equal the nominal one.
    """

    slopes: tuple[Range, ...]
    """m a turn on each piece; the nominal slope is the middle."""
    breakpoints: tuple[Fraction, ...] = ()
    """Turns between the pieces, ascending."""
    ends: tuple[Fraction, Fraction] | None = None
    """Least and largest turns; None: no end."""
    anchor: tuple[Fraction, Fraction] = (ZERO, ZERO)
    """One nominal point (turns, m): a breakpoint or, with one piece, any point."""
    transition: Fraction = ZERO
    """Turns by which a breakpoint may lie elsewhere."""
    error: Fraction = ZERO
    """m by which the true law may differ from one whose slopes are in their ranges."""

    def length(self, turns: Fraction) -> Fraction:
        """Return the nominal length in m at a place on the drum; `OffTheDrum` beyond its ends."""
        self._require(turns)
        return self._nominal.value(turns)

    def turns(self, length: Fraction) -> Fraction:
        """Return where the nominal length is paid out; `OffTheDrum` when the drum cannot."""
        turns = self._nominal.place(length)
        self._require(turns)
        return turns

    def slope(self, turns: Fraction) -> Range:
        """Return bounds of dL/dturns in m a turn at a place on the drum, of either side at a breakpoint."""
        first = bisect_left(self.breakpoints, turns - self.transition)
        last = bisect_right(self.breakpoints, turns + self.transition)
        found = self.slopes[first]
        for piece in range(first + 1, last + 1):
            found = found.hull(self.slopes[piece])
        return found

    def span(self, start: Range, end: Range) -> Range:
        """Return bounds of the length paid out from one place on the drum to another, each known to a range.

        Guarantee
        ---------
        Encloses L(e) - L(s) for all s in ``start``, all e in ``end`` and every law L that differs by at most
        ``error`` from one with slopes in their ranges and breakpoints moved by at most ``transition``.
        """
        if start.lo == start.hi == end.lo == end.hi:
            return Range(ZERO, ZERO)
        return Range(self._least(start.hi, end.lo), self._most(start.lo, end.hi)).widened(2 * self.error)

    def _least(self, start: Fraction, end: Fraction) -> Fraction:
        """Return the least that can be paid out from one place to another; negative backwards."""
        lowest, highest = self._bounds
        way = lowest if start <= end else highest
        return way.value(end) - way.value(start)

    def _most(self, start: Fraction, end: Fraction) -> Fraction:
        return -self._least(end, start)

    def _require(self, turns: Fraction) -> None:
        if self.ends is not None and not self.ends[0] <= turns <= self.ends[1]:
            low, high = (float(end) for end in self.ends)
            raise OffTheDrum(f"{float(turns):.6g} drum turns: the drum goes from {low:.6g} to {high:.6g}")

    @cached_property
    def _nominal(self) -> Polyline:
        return Polyline([slope.mid for slope in self.slopes], self.breakpoints, self.anchor)

    @cached_property
    def _bounds(self) -> tuple[Polyline, Polyline]:
        """Integrals of the least and of the largest slope that is possible at each place."""
        edges = sorted({place + side * self.transition for place in self.breakpoints for side in (-1, 1)})
        outer = [edges[0] - 1, *edges, edges[-1] + 1] if edges else [ZERO, ZERO]
        slopes = [self.slope((a + b) / 2) for a, b in pairwise(outer)]
        return Polyline([s.lo for s in slopes], edges), Polyline([s.hi for s in slopes], edges)


def law_of(drum: Drum, counts_per_drum_turn: Fraction) -> DrumLaw:
    """Return the law of a drum; the counts matter only where the file lumps drum, gear and encoder."""
    if isinstance(drum, HelicalDrum):
        return DrumLaw((helix(drum.groove_radius + half(drum.cable_diameter), drum.pitch),))
    if isinstance(drum, MultilayerDrum):
        return multilayer(drum)
    if isinstance(drum, TableDrum):
        return table(drum)
    assert isinstance(drum, LinearDrum)
    per_turn = Range(counts_per_drum_turn, counts_per_drum_turn) * drum.metres_per_count
    return DrumLaw((per_turn,))


def half(value: Range) -> Range:
    """Return half of every number in a range."""
    return Range(value.lo / 2, value.hi / 2)


def helix(radius: Range, pitch: Range) -> Range:
    """Return bounds of the length of one turn, ``sqrt((2 pi r)^2 + pitch^2)``, in m."""
    around = TWO_PI * radius
    return square_root(around * around + pitch * pitch)


def multilayer(drum: MultilayerDrum) -> DrumLaw:
    """Return the law of a drum with layers: 0 turns is the bare drum; winding in counts down."""
    count = drum.layers
    slopes = []
    for layer in range(count):
        growth = Range(Fraction(layer), Fraction(layer)) * drum.packing * drum.cable_diameter
        slopes.append(outward(TWO_PI * (drum.core_radius + half(drum.cable_diameter) + growth)))
    places = tuple(-drum.turns_per_layer * layer for layer in range(count - 1, 0, -1))
    bare = (ZERO, drum.cable_length)
    ends = (-drum.turns_per_layer * count, ZERO)
    return DrumLaw(tuple(reversed(slopes)), places, ends, bare, drum.transition_turns)


def table(drum: TableDrum) -> DrumLaw:
    """Return the law through measured points."""
    slopes = []
    for (a, start), (b, end) in pairwise(drum.points):
        slope = (end - start) / (b - a)
        slopes.append(Range(slope, slope))
    places = tuple(place for place, _ in drum.points[1:-1])
    ends = (drum.points[0][0], drum.points[-1][0])
    return DrumLaw(tuple(slopes), places, ends, drum.points[0], error=drum.error)
