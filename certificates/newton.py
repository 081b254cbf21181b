"""Zeros of equations, proved by a Krawczyk operator in balls."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from flint import arb, arb_mat, fmpq

from certificates.arithmetic.balls import Vector, column, hull
from certificates.arithmetic.jets import Jet
from certificates.clock import in_time
from certificates.verdicts import NotProved

NEWTON_STEPS = 40
"""Most steps from a start; each but the first ones doubles the digits."""
LAST = 2**100
"""A step smaller by this than the numbers is the last one."""
INFLATIONS = 40
CONTRACTIONS = 6
Equations = Callable[[Vector, arb_mat], tuple[arb_mat, arb_mat]]
"""Values over a box, and slopes for any two of its points along the columns of a matrix."""


@dataclass(frozen=True)
class Zero:
    """A zero at middle + axes y for some y in a box, whatever the data in their ranges."""

    middle: arb_mat
    """(n, 1)."""
    axes: arb_mat
    """(n, n)."""
    offsets: arb_mat
    """(n, 1): all y."""

    def entries(self) -> Vector:
        """Enclose the zero."""
        return list((self.middle + self.axes * self.offsets).entries())

    def image(self, function: Callable[[Vector], Sequence[Jet]]) -> Vector:
        """Enclose the values of a function at the zero by the mean value theorem."""
        here = function(self.middle.entries())
        slopes = [[f.slopes.get(k, 0) for k in range(self.axes.ncols())] for f in function(self.entries())]
        steps = arb_mat(slopes) * self.axes * self.offsets
        return [f.value + step for f, step in zip(here, steps.entries(), strict=True)]


def zero(equations: Equations, start: Sequence[arb]) -> Zero:
    """Enclose a zero: the operator maps a box into itself, for all data in their ranges."""
    x, n = column(start), len(start)
    unity = arb_mat([[int(i == j) for j in range(n)] for i in range(n)])
    for _ in range(NEWTON_STEPS):
        in_time()
        value, slope = equations(x.entries(), unity)
        step = slope.mid().solve(value.mid())
        x = (x - step).mid()
        if all(abs(v) * LAST < 1 + abs(w) for v, w in zip(step.entries(), x.entries(), strict=True)):
            break
    value, slope = equations(x.entries(), unity)
    inverse = slope.mid().inv().mid()

    def image(radii: Vector) -> Vector:
        """Return how far from x the operator takes x + inverse y, |y| <= radii, as new radii."""
        y = column([hull(-r, r) for r in radii])
        moved = (unity - equations((x + inverse * y).entries(), inverse)[1]) * y - value
        return [m.abs_upper() for m in moved.entries()]

    sizes = [sum((abs(slope[i, j] * x[j, 0]).mid() for j in range(n)), arb(1)) for i in range(n)]
    tiny = [size * fmpq(1, 2**120) for size in sizes]
    radii = [(2 * v.abs_upper() + e).mid() for v, e in zip(value.entries(), tiny, strict=True)]
    for _ in range(INFLATIONS):
        in_time()
        moved = image(radii)
        if all(m < r for m, r in zip(moved, radii, strict=True)):
            for _ in range(CONTRACTIONS):
                moved = image(moved)
            return Zero(x, inverse, column([hull(-m, m) for m in moved]))
        radii = [(fmpq(5, 4) * m + e).mid() for m, e in zip(moved, tiny, strict=True)]
    raise NotProved("no zero is proved: no box is mapped into itself")
