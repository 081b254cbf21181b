"""Cells in which no tensions balance the load, whatever they are as long as no cable pushes.

Gordan: a direction y with y . w_i > 0 for all taut cables and y . w_0 > 0 at every solution in the cell. y
moves over the cell so that the slopes of these forms vanish where they can.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from certificates.arithmetic import guess
from certificates.arithmetic.forms import Array, Vector, stacked
from certificates.arithmetic.guess import usable
from certificates.arithmetic.vectors import dot
from certificates.cells import Place, slopes

TRIES = 3
"""Directions y tried on a cell: the one given, then such as suit the forms' radii."""


class Wrenches:
    """Wrenches over cells: multiples of the equations that take out their slopes, values and slopes then."""

    def __init__(self, place: Place, wrenches: Sequence[Vector]) -> None:
        self.place, self.wrenches = place, wrenches
        values = stacked([f.doubles() for f in place.equations])
        given = [slopes(w, place.count) for w in wrenches]
        self.multipliers = [stacked([place.multipliers(v) for v in rows]) for rows in given]
        """Of each wrench (6, equations, N)."""
        pairs = list(zip(wrenches, self.multipliers, strict=True))
        self.values = stacked(
            [stacked([v.doubles() for v in w]) + np.einsum("wec,ec->wc", m, values) for w, m in pairs]
        )
        """(wrenches, 6, N)."""
        self.slopes = stacked(
            [
                rows + np.einsum("wec,esc->wsc", m, place.slopes)
                for rows, m in zip(given, self.multipliers, strict=True)
            ]
        )
        """(wrenches, 6, symbols, N)."""

    def at(self, cells: Array) -> Wrenches:
        """Return the same over some of the cells."""
        return Wrenches(self.place.at(cells), [[v.at(cells) for v in w] for w in self.wrenches])

    def following(self, y: Array, active: Array) -> Vector:
        """Return y (6, N) with slopes that cancel those of its products with the active wrenches."""
        left = -np.einsum("wc,iwsc->isc", y, self.slopes)
        steps = usable(guess.least_norm(self.values, left, active))
        return [self.place.kind.near(v, s) for v, s in zip(usable(y), steps, strict=True)]

    def lowest(self, y: Array, moving: Vector) -> Array:
        """Return lower bounds of y . w at solutions, y moving, (wrenches, N)."""
        found = []
        for wrench, multipliers in zip(self.wrenches, self.multipliers, strict=True):
            weights = np.einsum("wc,wec->ec", usable(y), multipliers)
            product = dot(moving, wrench) + self.place.kind.combine(weights, self.place.equations)
            found.append(product.lowest())
        return stacked(found)


def unbalanced(place: Place, y: Array) -> Array:
    """Return where no non-negative tensions balance the load at any solution; y (6, N) is a first try."""
    wrenches = Wrenches(place, place.rotated.wrenches(place.x))
    active = np.ones((len(wrenches.values), y.shape[1]), dtype=bool)
    found, left = np.zeros(y.shape[1], dtype=bool), np.arange(y.shape[1])
    for attempt in range(TRIES):
        low = wrenches.lowest(y, wrenches.following(y, active))
        is_one = np.all(low > 0, axis=0)
        found[left[is_one]] = True
        if is_one.all() or attempt == TRIES - 1:
            break
        radii = np.einsum("wc,iwc->ic", y, wrenches.values) - place.kind.doubles_near(low)
        failing = np.flatnonzero(~is_one)
        left, wrenches = left[failing], wrenches.at(failing)
        y, active = guess.direction(wrenches.values, usable(radii[:, failing]))
    return found
