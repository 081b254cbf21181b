"""What holds at every pose in a cell: sets of equations, each with the wrenches of the taut cables.

A cell is looked at in one view after the other: what its leaf says must follow in one of them.
"""

from __future__ import annotations

from typing import Any

from certificates.arithmetic.forms import Vector
from certificates.arithmetic.series import half
from certificates.arithmetic.vectors import dot
from certificates.routed.ropes import Posed


class Lengths(Posed):
    """The taut cables have their lengths."""

    def equations(self, p: Vector, on_branch: bool = False) -> Vector:
        """Return numbers that are 0 at all poses."""
        return [self.excess(i, p) for i in range(self.ropes.taut)]

    def excess(self, i: int, p: Vector) -> Any:
        """Return a number with the sign of L - l."""
        rope, ropes = self.rope(i, p), self.ropes
        if ropes.axes[i]:
            return rope.length - ropes.lengths[i]
        straight = ropes.lengths[i] - ropes.before[i]
        return half(rope.square - straight * straight)


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
