"""One cell of the pose space: where the platform can be over it, and the tests that exclude it.

Each test is an inequality between exact polynomials over the cell. A multiple of an equation may be added to any
form without changing its value at a solution; multipliers, directions y and their slopes are floats that only
make the inequality likely.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from flint import fmpq, fmpq_mpoly

from certificates import guess
from certificates.geometry import Turned
from certificates.polynomials import (
    PLACE,
    SYMBOL,
    TURN,
    ZERO,
    Vector,
    centre,
    constant,
    cross,
    dot,
    highest,
    lowest,
    rational,
    size,
    slopes,
    total,
)

U = range(TURN, TURN + 3)
POSE = range(6)
X = range(PLACE, PLACE + 3)
TRIES = 8
"""Most boxes tried around the position on a branch."""
MARGIN = 1.25
"""What a try adds to the image of the one before."""
LARGEST = 1e3
"""A box this large (times the position) is given up."""


def numbers(values: Sequence[fmpq]) -> list[float]:
    """Return floats near exact numbers."""
    return [float(v.p) / float(v.q) if v.p.bit_length() < 1000 else 0.0 for v in values]


def number(value: fmpq) -> float:
    """Return a float near an exact number."""
    return int(value.p) / int(value.q)


def on_branch(turned: Turned, side: int) -> Vector | None:
    """Return the position of the triple on one side as polynomials, or None where that is not proved.

    Proved: over the whole cell the three equations have exactly one solution x with side . (x . (d_2 x d_3)) >= 0; it is
    x_0 + G u + e with e in a box, by the Krawczyk operator in e, and lies strictly on that side. There are at
    most two solutions, mirror images in the plane of the centres.
    """
    (d2, k2), (d3, k3) = turned.lines()[:2]
    s = number(centre(turned.s))
    a, b = ([number(centre(v)) / s for v in d] for d in (d2, d3))
    right = [number(centre(k)) / s for k in (k2, k3)]
    square = number(centre(turned.platform.squares[0]))
    normal = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    foot = guess.solve([a, b, normal], [[right[0]], [right[1]], [0.0]])
    if foot is None:
        return None
    height = square - sum(v[0] * v[0] for v in foot)
    if not height > 0.0:
        return None
    step = side * math.sqrt(height / guess.inner(normal, normal))
    x0 = [v[0] + step * w for v, w in zip(foot, normal, strict=True)]
    inverse = guess.inverse([[2.0 * v for v in x0], [s * v for v in a], [s * v for v in b]])
    if inverse is None:
        return None
    C = [[rational(v) for v in row] for row in inverse]
    start = [constant(rational(v)) for v in x0]
    change = [slopes(f, U) for f in equations(turned, start)]
    moved = [
        v - total([SYMBOL[k] * rational(number(total_of(row, change, k))) for k in U])
        for v, row in zip(start, C, strict=True)
    ]
    rest = [size(combine(row, equations(turned, moved))) for row in C]
    reach = [rational(MARGIN * number(r) + 1e-15 * (1.0 + abs(v))) for r, v in zip(rest, x0, strict=True)]
    for _ in range(TRIES):
        x = [v + SYMBOL[k] * r for v, k, r in zip(moved, X, reach, strict=True)]
        rows = [[2 * v for v in x], d2, d3]
        image = []
        for i in range(3):
            spread = rest[i]
            for j in range(3):
                entry = total([C[i][k] * rows[k][j] for k in range(3)]) - int(i == j)
                spread += size(entry) * reach[j]
            image.append(spread)
        if all(new < old for new, old in zip(image, reach, strict=True)):
            return x if lowest(side * dot(cross(d2, d3), x)) > 0 else None
        reach = [rational(MARGIN * number(new)) for new in image]
        if max(reach) > rational(LARGEST * (1.0 + math.sqrt(square))):
            return None
    return None


def total_of(row: Sequence[fmpq], change: Sequence[Sequence[fmpq]], k: int) -> fmpq:
    """Return entry k of a row times a matrix."""
    return sum((c * line[k] for c, line in zip(row, change, strict=True)), ZERO)


def equations(turned: Turned, x: Vector) -> list[fmpq_mpoly]:
    """Return the three equations of the triple."""
    return turned.lengths(x)[:3]


def combine(weights: Sequence[fmpq], forms: Sequence[fmpq_mpoly]) -> fmpq_mpoly:
    """Return a weighted sum of forms."""
    return total([form * weight for form, weight in zip(forms, weights, strict=True)])


def no_position(turned: Turned) -> bool:
    """Return True when the three spheres of the triple have no common point over the cell.

    With any weights g, h a common point has 0 <= |x + g d_2 + h d_3|^2 = l_1^2 + |g d_2 + h d_3|^2 + 2 (g K_2 + h K_3).
    """
    (d2, k2), (d3, k3) = turned.lines()[:2]
    s = number(centre(turned.s))
    a, b = ([number(centre(v)) / s for v in d] for d in (d2, d3))
    right = [-number(centre(k)) / s for k in (k2, k3)]
    gram = [[guess.inner(v, w) for w in (a, b)] for v in (a, b)]
    weights = guess.solve(gram, [[right[0]], [right[1]]])
    if weights is None:
        return False
    g, h = (rational(w[0]) for w in weights)
    mixed = [v * g + w * h for v, w in zip(d2, d3, strict=True)]
    gap = turned.s * turned.s * turned.platform.squares[0] + dot(mixed, mixed) + 2 * turned.s * (k2 * g + k3 * h)
    return lowest(-gap) > 0


class Place:
    """A cell with a position: the equations' slopes, by which they are added to other forms."""

    def __init__(self, turned: Turned, x: Vector) -> None:
        self.turned, self.x = turned, x
        self.equations = turned.lengths(x)
        self.slopes = [[number(v) for v in slopes(f, POSE)] for f in self.equations]

    def freed(self, form: fmpq_mpoly) -> fmpq_mpoly:
        """Return a form of the same value at solutions whose slopes are as small as equations can make them."""
        return form + self.combination([-number(v) for v in slopes(form, POSE)])

    def combination(self, wanted: Sequence[float]) -> fmpq_mpoly:
        """Return a combination of the equations with slopes near those wanted (least squares)."""
        rights = [[guess.inner(row, wanted)] for row in self.slopes]
        gram = guess.gram(self.slopes)
        found = guess.solve(gram, rights)
        return combine([rational(w[0]) for w in found], self.equations) if found else constant(0)

    def positive(self, form: fmpq_mpoly) -> bool:
        """Return True when a form is positive at every solution in the cell."""
        return lowest(form) > 0 or lowest(self.freed(form)) > 0

    def no_length(self) -> bool:
        """Return True when the taut cables cannot all have their lengths in the cell."""
        for f in self.equations:
            if not lowest(f) <= 0 <= highest(f):
                return True
        for k in POSE:
            wanted = [float(i == k) for i in POSE]
            form = self.combination(wanted)
            # form = c + a e_k + others vanishes at solutions, so e_k lies in -(c +- others) / a.
            c, a = centre(form), slopes(form, [k])[0]
            if abs(c) > size(form) - abs(c):
                return True
        return False

    def forms(self, wrenches: Sequence[Vector], y: Vector) -> list[fmpq_mpoly]:
        """Return y . w for all wrenches, positions taken out."""
        return [self.freed(dot(y, w)) for w in wrenches]

    def unbalanced(self, y: Sequence[fmpq]) -> bool:
        """Return True when no non-negative tensions balance the load at any solution in the cell.

        Gordan: y . w_i > 0 for all taut cables and y . w_0 > 0. Where a constant y does not do, it is given slopes in u
        that cancel the forms' own.
        """
        wrenches = self.turned.wrenches(self.x)
        fixed = [constant(v) for v in y]
        forms = self.forms(wrenches, fixed)
        if all(lowest(f) > 0 for f in forms):
            return True
        rows = [[number(centre(v)) for v in w] for w in wrenches]
        change = guess.least_norm(rows, [[-number(v) for v in column] for column in zip(*(slopes(f, U) for f in forms), strict=True)])
        if change is None:
            return False
        moving = [
            v + total([SYMBOL[k] * rational(slope[i]) for k, slope in zip(U, change, strict=True)])
            for i, v in enumerate(fixed)
        ]
        return all(lowest(f) > 0 for f in self.forms(wrenches, moving))
