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
"""Values over a box of unknowns and symbols, and slopes for any two of its points along the columns of a
matrix."""


@dataclass(frozen=True)
class Zero:
    """A zero for all d in a box of data: (zero, d) is at middle + axes (y, d - middle of d), y in a box."""

    middle: arb_mat
    """(n + k, 1)."""
    axes: arb_mat
    """(n + k, n + k)."""
    offsets: arb_mat
    """(n + k, 1)."""

    def entries(self) -> Vector:
        """Enclose the zero, and d."""
        return list((self.middle + self.axes * self.offsets).entries())

    def image(self, function: Callable[[Vector], Sequence[Jet]]) -> Vector:
        """Enclose the values of a function at the zero by the mean value theorem."""
        here = function(self.middle.entries())
        slopes = [[f.slopes.get(k, 0) for k in range(self.axes.ncols())] for f in function(self.entries())]
        steps = arb_mat(slopes) * self.axes * self.offsets
        return [f.value + step for f, step in zip(here, steps.entries(), strict=True)]


def zero(equations: Equations, start: Sequence[arb], data: Sequence[arb] = ()) -> Zero:
    """Enclose a zero of n equations for all data in balls d, and for what else is in ranges.

    With C near the inverse of the slopes in the middle and S near -C times those by the data, y -> y - F(x +
    C y + S d, d) maps a box into itself for every d (from its middle). It is y - F(x, 0) - M (y, d), M being
    slopes along C and S.
    """
    n, count = len(start), len(start) + len(data)
    x, fixed = column([*start, *(d.mid() for d in data)]), [arb(0) for _ in data]
    spread = [d - d.mid() for d in data]
    unity = arb_mat([[int(i == j) for j in range(count)] for i in range(count)])
    for _ in range(NEWTON_STEPS):
        in_time()
        value, slope = equations(x.entries(), unity)
        step = [*part(slope, n, 0, n).mid().solve(value.mid()).entries(), *fixed]
        x = (x - column(step)).mid()
        if all(abs(v) * LAST < 1 + abs(w) for v, w in zip(step, x.entries(), strict=True)):
            break
    value, slope = equations(x.entries(), unity)
    inverse = part(slope, n, 0, n).mid().inv().mid()
    sway = (-inverse * part(slope, n, n, count)).mid().tolist() if data else [[]] * n
    axes = arb_mat([*(a + b for a, b in zip(inverse.tolist(), sway, strict=True)), *unity.tolist()[n:]])

    def image(radii: Vector) -> Vector:
        """Return how far from 0 the map takes y, |y| <= radii, as new radii."""
        y = column([*(hull(-r, r) for r in radii), *spread])
        along = equations((x + axes * y).entries(), axes)[1]
        moved = (part(unity, n, 0, count) - along) * y - value
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
            return Zero(x, axes, column([*(hull(-m, m) for m in moved), *spread]))
        radii = [(fmpq(5, 4) * m + e).mid() for m, e in zip(moved, tiny, strict=True)]
    raise NotProved("no zero is proved: no box is mapped into itself")


def part(matrix: arb_mat, rows: int, first: int, last: int) -> arb_mat:
    """Return the first rows of a matrix, from one column to before another."""
    return arb_mat([row[first:last] for row in matrix.tolist()[:rows]])
