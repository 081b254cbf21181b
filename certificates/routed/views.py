"""What holds at every pose in a cell: sets of equations, each with the wrenches of the taut cables.

A cell is looked at in one view after the other: what its leaf says must follow in one of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from certificates.arithmetic import guess
from certificates.arithmetic.forms import Array, Form, Vector, stacked
from certificates.arithmetic.guess import usable
from certificates.arithmetic.series import half
from certificates.arithmetic.vectors import dot
from certificates.routed.ropes import Posed


class Lengths(Posed):
    """The taut cables have their lengths, stretched by no more than the balance of forces allows."""

    def equations(self, p: Vector, on_branch: bool = False) -> Vector:
        """Return numbers that are 0 at all poses."""
        found = [self.excess(i, p) for i in range(self.ropes.taut)]
        if not self.ropes.stiffnesses:
            return found
        return [f - s for f, s in zip(found, self.stretches(p), strict=True)]

    def excess(self, i: int, p: Vector) -> Any:
        """Return a number with the sign of L - l; L - l itself of a cable that is taut and stretches."""
        rope, ropes = self.rope(i, p), self.ropes
        if ropes.axes[i] or (ropes.stiffnesses and i < ropes.taut):
            return rope.length - ropes.lengths[i]
        straight = ropes.lengths[i] - ropes.before[i]
        return half(rope.square - straight * straight)

    def stretches(self, p: Vector) -> Vector:
        """Return what the taut cables stretch by: between 0 and a bound, any number where there is none.

        With y . w_i > 0 for all of them and y . w_0 >= -c the balance says that t_i (y . w_i) <= c.
        """
        *wrenches, load = self.wrenches(p)
        kind, ropes = type(self.s), self.ropes
        y = usable(guess.direction(*suited(wrenches))[0])
        direction = [kind.near(v) for v in y]
        lows = stacked([dot(direction, w).lowest() for w in wrenches])
        most = np.maximum(0, -dot(direction, load).lowest())
        found = []
        for i, low in enumerate(lows):
            bound = np.where(np.all(lows > 0, axis=0), kind.quotient(most, np.maximum(low, 0)), kind.INFINITE)
            softness = kind.quotient(bound, np.maximum(0, ropes.stiffnesses[i].lowest()))
            size = kind.bound([(softness, self.rope(i, p).free.size())])
            found.append(between_zero_and(kind, size))
        return found


def between_zero_and(kind: type[Form], most: Array) -> Form:
    """Return any number between 0 and a bound."""
    none = kind.constant(0)
    middle: Form = half(kind(most, none.slopes, none.curves, 0 * most))
    return middle + kind.unknown(middle.size())


def suited(wrenches: Sequence[Vector]) -> tuple[Array, Array]:
    """Return wrenches as doubles (n, 6, N), and lengths of them: what `guess.direction` takes."""
    values = stacked([stacked([v.doubles() for v in w]) for w in wrenches])
    return values, np.sqrt(np.sum(values * values, axis=1))


class Shells(Lengths):
    """The same whatever a pulley does: the rope leaves within 2 r of A, and is not shorter than |X - A|."""

    def equations(self, p: Vector, on_branch: bool = False) -> Vector:
        """Return numbers that are 0 at all poses."""
        return [
            dot(g, g) - s for g, s in ((self.way(i, p), self.ropes.shells[i]) for i in range(self.ropes.taut))
        ]

    def excess(self, i: int, p: Vector) -> Any:
        """Return a number that is not positive where L <= l."""
        g, straight = self.way(i, p), self.ropes.lengths[i] - self.ropes.before[i]
        return half(dot(g, g) - straight * straight)

    def wrenches(self, p: Vector) -> list[Vector]:
        """Return the w_i of the taut cables, and w_0."""
        found, zero = [], 0 * self.s
        for i in range(self.ropes.taut):
            near = self.ropes.radii[i].size()
            off = type(self.s).unknown(near + near)
            found.append(self.wrench(i, [off - v for v in self.way(i, p)]))
        return [*found, [*(f + zero for f in self.ropes.load), zero, zero, zero]]


class Pulls(Lengths):
    """Cables that stretch pull by what they are longer than unstretched: the six rows of the balance."""

    def equations(self, p: Vector, on_branch: bool = False) -> Vector:
        """Return numbers that are 0 at all poses."""
        *wrenches, load = self.wrenches(p)
        t: list[Any] = [self.density(i, p) for i in range(self.ropes.taut)]
        return [load[k] + dot(t, [w[k] for w in wrenches]) for k in range(6)]
