"""Ascending functions made of straight lines, exact."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property


@dataclass(frozen=True)
class Polyline:
    """A continuous function through one point: straight between knots, and beyond the outer ones."""

    slopes: Sequence[Fraction]
    """One more than there are knots."""
    knots: Sequence[Fraction]
    """Ascending."""
    through: tuple[Fraction, Fraction] = (Fraction(0), Fraction(0))
    """Any point (x, y) of it."""

    def value(self, x: Fraction) -> Fraction:
        """Return y at x."""
        piece = bisect_right(self.knots, x)
        start, y = self._start(piece)
        return y + (x - start) * self.slopes[piece]

    def place(self, y: Fraction) -> Fraction:
        """Return the x of a y; all slopes must be positive."""
        piece = bisect_right(self._values, y)
        x, start = self._start(piece)
        return x + (y - start) / self.slopes[piece]

    def _start(self, piece: int) -> tuple[Fraction, Fraction]:
        """Return a point of a piece."""
        if not self.knots:
            return self.through
        known = max(piece - 1, 0)
        return self.knots[known], self._values[known]

    @cached_property
    def _values(self) -> list[Fraction]:
        """The y at the knots: from the given point, knot by knot in both directions."""
        (x, y), home = self.through, bisect_right(self.knots, self.through[0])
        found: dict[int, Fraction] = {}
        for k in range(home, len(self.knots)):
            y += (self.knots[k] - x) * self.slopes[k]
            found[k], x = y, self.knots[k]
        x, y = self.through
        for k in range(home - 1, -1, -1):
            y -= (x - self.knots[k]) * self.slopes[k + 1]
            found[k], x = y, self.knots[k]
        return [found[k] for k in range(len(self.knots))]
