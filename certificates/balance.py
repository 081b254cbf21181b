"""Cells in which no tensions balance the load, whatever they are as long as no cable pushes.

Gordan: a direction y with y . w_i > 0 for all taut cables and y . w_0 > 0 at every solution in the cell. y
moves over the cell so that the slopes of these forms vanish where they can.
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import fmpq

from certificates import guess
from certificates.cells import Place, combine
from certificates.polynomials import (
    SYMBOL,
    Vector,
    centre,
    constant,
    dot,
    lowest,
    number,
    rational,
    short,
    slopes,
    total,
)

TRIES = 3
"""Directions y tried on a cell: the one given, then such as suit the forms' radii."""


class Wrench:
    """One wrench over a cell: multiples of the equations that take out its slopes, value and slopes then."""

    def __init__(self, place: Place, wrench: Vector) -> None:
        self.place, self.wrench = place, wrench
        values = [number(centre(f)) for f in place.equations]
        columns = list(zip(*place.slopes, strict=True))
        given = [[number(c) for c in slopes(v, place.symbols)] for v in wrench]
        self.multipliers = [place.multipliers(v) for v in given]
        pairs = list(zip(wrench, given, self.multipliers, strict=True))
        self.value = [number(centre(v)) + guess.inner(m, values) for v, _, m in pairs]
        self.slopes = [
            [c + guess.inner(m, column) for c, column in zip(g, columns, strict=True)] for _, g, m in pairs
        ]

    def slope(self, y: Sequence[float]) -> list[float]:
        """Return the slopes of y . w for a constant y."""
        return [guess.inner(y, column) for column in zip(*self.slopes, strict=True)]

    def lowest(self, y: Sequence[float], moving: Vector) -> fmpq:
        """Return a lower bound of y . w at solutions, y moving."""
        weights = [short(guess.inner(y, m)) for m in zip(*self.multipliers, strict=True)]
        return lowest(dot(moving, self.wrench) + combine(weights, self.place.equations))


def unbalanced(place: Place, y: Sequence[float]) -> bool:
    """Return True when no non-negative tensions balance the load at any solution; y is a first try."""
    wrenches = [Wrench(place, w) for w in place.turned.wrenches(place.x)]
    rows = [w.value for w in wrenches]
    active = list(range(len(rows)))
    for _ in range(TRIES):
        moving = following(place, [wrenches[i] for i in active], y)
        if moving is None:
            return False
        low = [w.lowest(y, moving) for w in wrenches]
        if all(v > 0 for v in low):
            return True
        radii = [guess.inner(y, row) - number(v) for v, row in zip(low, rows, strict=True)]
        again = guess.direction(rows, radii)
        if again is None:
            return False
        y, active = again
    return False


def following(place: Place, wrenches: Sequence[Wrench], y: Sequence[float]) -> Vector | None:
    """Return y with slopes that cancel those of its products with some wrenches."""
    left = [[-v for v in w.slope(y)] for w in wrenches]
    steps = guess.least_norm([w.value for w in wrenches], list(zip(*left, strict=True)))
    if steps is None:
        return None
    return [
        constant(rational(v))
        + total([SYMBOL[k] * short(s[i]) for k, s in zip(place.symbols, steps, strict=True)])
        for i, v in enumerate(y)
    ]
