"""Cells in which no tensions balance the load, whatever they are as long as no cable pushes.

Gordan: a direction y with y . w_i > 0 for all taut cables and y . w_0 > 0 at every solution in the cell. y
moves over the cell so that the slopes of these forms vanish where they can.
"""

from __future__ import annotations

from collections.abc import Sequence

from certificates.arithmetic import guess
from certificates.arithmetic.forms import Form, Vector, combine, near, slopes, value
from certificates.arithmetic.vectors import dot
from certificates.cells import Place

TRIES = 3
"""Directions y tried on a cell: the one given, then such as suit the forms' radii."""


class Wrench:
    """One wrench over a cell: multiples of the equations that take out its slopes, value and slopes then."""

    def __init__(self, place: Place, wrench: Vector) -> None:
        self.place, self.wrench = place, wrench
        values = [value(f) for f in place.equations]
        columns = list(zip(*place.slopes, strict=True))
        given = [slopes(v, place.count) for v in wrench]
        self.multipliers = [place.multipliers(v) for v in given]
        pairs = list(zip(wrench, given, self.multipliers, strict=True))
        self.value = [value(v) + guess.inner(m, values) for v, _, m in pairs]
        self.slopes = [
            [c + guess.inner(m, column) for c, column in zip(g, columns, strict=True)] for _, g, m in pairs
        ]

    def slope(self, y: Sequence[float]) -> list[float]:
        """Return the slopes of y . w for a constant y."""
        return [guess.inner(y, column) for column in zip(*self.slopes, strict=True)]

    def lowest(self, y: Sequence[float], moving: Vector) -> int:
        """Return a lower bound of y . w at solutions, y moving."""
        weights = [guess.inner(y, m) for m in zip(*self.multipliers, strict=True)]
        found: Form = dot(moving, self.wrench) + combine(weights, self.place.equations)
        return found.lowest()


def unbalanced(place: Place, y: Sequence[float]) -> bool:
    """Return True when no non-negative tensions balance the load at any solution; y is a first try."""
    wrenches = [Wrench(place, w) for w in place.turned.wrenches(place.x)]
    rows = [w.value for w in wrenches]
    active = list(range(len(rows)))
    for _ in range(TRIES):
        moving = following([wrenches[i] for i in active], y)
        if moving is None:
            return False
        low = [w.lowest(y, moving) for w in wrenches]
        if min(low) > 0:
            return True
        radii = [guess.inner(y, row) - value(Form(v)) for v, row in zip(low, rows, strict=True)]
        again = guess.direction(rows, radii)
        if again is None:
            return False
        y, active = again
    return False


def following(wrenches: Sequence[Wrench], y: Sequence[float]) -> Vector | None:
    """Return y with slopes that cancel those of its products with some wrenches."""
    left = [[-v for v in w.slope(y)] for w in wrenches]
    steps = guess.least_norm([w.value for w in wrenches], list(zip(*left, strict=True)))
    return None if steps is None else [near(v, s) for v, s in zip(y, zip(*steps, strict=True), strict=True)]
