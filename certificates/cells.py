"""One cell of the pose space: where the platform can be over it, and the tests that exclude it.

Each test is an inequality between exact polynomials over the cell. A multiple of an equation may be added
to any form without changing its value at a solution; multipliers, directions y and their slopes are floats
that only make the inequality likely.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from flint import fmpq, fmpq_mpoly

from certificates import guess
from certificates.geometry import Turned
from certificates.polynomials import (
    ALONG,
    PLACE,
    SYMBOL,
    TURN,
    ZERO,
    Vector,
    centre,
    constant,
    cross,
    dot,
    has_no_zero,
    highest,
    lowest,
    number,
    rational,
    short,
    size,
    slopes,
    total,
    upto,
)

U = range(TURN, TURN + 3)
POSE = range(6)
ON_BRANCH = (TURN, TURN + 1, TURN + 2, ALONG)
"""Symbols that matter on a branch: u, and the distance from a guess along the normal of the centres."""


def middles(turned: Turned) -> tuple[list[float], list[float], list[float]]:
    """Return d_2, d_3 and (K_2, K_3) at the cell's centre."""
    (d2, k2), (d3, k3) = turned.lines()[:2]
    s = number(centre(turned.s))
    return (
        [number(centre(v)) / s for v in d2],
        [number(centre(v)) / s for v in d3],
        [number(centre(k)) / s for k in (k2, k3)],
    )


def near_branch(turned: Turned, side: int) -> Vector | None:
    """Return polynomials in u near the position on one side; a guess."""
    a, b, right = middles(turned)
    normal = guess.cross(a, b)
    foot = guess.solve([a, b, normal], [[right[0]], [right[1]], [0.0]])
    if foot is None:
        return None
    height = number(centre(turned.platform.squares[0])) - sum(v[0] * v[0] for v in foot)
    step = side * math.sqrt(max(0.0, height) / guess.inner(normal, normal))
    x0 = [v[0] + step * w for v, w in zip(foot, normal, strict=True)]
    s = number(centre(turned.s))
    across = [2.0 * v for v in x0] if height > 0.0 else normal
    inverse = guess.inverse([across, [s * v for v in a], [s * v for v in b]])
    if inverse is None:
        return None
    correct = [[rational(v) for v in row] for row in inverse]
    x = [constant(rational(v)) for v in x0]
    for k in (1, 2):
        wrong = turned.triple(x)
        if not height > 0.0:
            wrong[0] = constant(0)
        x = [v - upto(combine(row, wrong), k) for v, row in zip(x, correct, strict=True)]
    return x


def on_branch(turned: Turned, side: int) -> Vector | None:
    """Return polynomials that enclose every position on one side over the cell, or None.

    With d_2, d_3 and m = d_2 x d_3 every position is x = y + alpha d_2 + beta d_3 + tau m for any y. The
    linear equations bound alpha and beta: G (alpha, beta) = -(r_2, r_3) with G the scalar products of d_2
    and d_3 and r their residuals at y. With w = y + alpha d_2 + beta d_3 the sphere says tau (m . y + m .
    x) = l^2 - |w|^2, and on this side side (m . x) >= 0. Where side (m . y) >= h > 0 therefore |tau| <=
    |l^2 - |w|^2| / h. Where it is at least -g, |m . y + m . x| >= |tau| |m|^2 - 2 g, so |tau| <= q +
    sqrt(q^2 + |l^2 - |w|^2| / |m|^2) with q = g / |m|^2.
    """
    y = near_branch(turned, side)
    if y is None:
        return None
    (d2, k2), (d3, k3) = turned.lines()[:2]
    m = cross(d2, d3)
    straight = [upto(v, 1) for v in m]
    normal = [constant(centre(v)) for v in straight]
    # |m| >= m . n / |n| for any n.
    square = max(ZERO, lowest(dot(m, normal))) ** 2 / centre(dot(normal, normal))
    within = in_plane(d2, d3, [dot(d2, y) - k2, dot(d3, y) - k3]) if square > 0 else None
    if within is None:
        return None
    rest = [size(v) * within[0] + size(w) * within[1] for v, w in zip(d2, d3, strict=True)]
    w = [v + SYMBOL[PLACE + k] * r for k, (v, r) in enumerate(zip(y, rest, strict=True))]
    wrong, height = size(dot(w, w) - turned.platform.squares[0]), lowest(side * dot(m, y))
    below = max(ZERO, -height) / square
    tau = below + above_root(below * below + wrong / square)
    tau = min(tau, wrong / height) if height > 0 else tau
    rest = [r + tau * size(v - u) for r, v, u in zip(rest, m, straight, strict=True)]
    x = [
        v + SYMBOL[PLACE + k] * r + SYMBOL[ALONG] * tau * u
        for k, (v, r, u) in enumerate(zip(y, rest, straight, strict=True))
    ]
    return [x[0], constant(0), x[2]] if turned.platform.planar else x


def above_root(x: fmpq) -> fmpq:
    """Return a number not below the square root of x >= 0, close to it."""
    root = rational(math.sqrt(number(x)) * (1.0 + 2.0**-40))
    return root if root * root >= x else x + 1


def in_plane(d2: Vector, d3: Vector, wrong: Sequence[fmpq_mpoly]) -> list[fmpq] | None:
    """Return bounds of |alpha| and |beta| with G (alpha, beta) = -wrong, or None.

    With C near the inverse of G: v bounds the solution when |C wrong| + |I - C G| v <= v.
    """
    gram = [[dot(v, w) for w in (d2, d3)] for v in (d2, d3)]
    inverse = guess.inverse([[number(centre(g)) for g in row] for row in gram])
    if inverse is None:
        return None
    correct = [[rational(c) for c in row] for row in inverse]
    first = [size(combine(row, wrong)) for row in correct]
    error = [
        [size(combine(row, column) - int(i == j)) for j, column in enumerate(zip(*gram, strict=True))]
        for i, row in enumerate(correct)
    ]
    return contained(first, error)


def contained(first: Sequence[fmpq], error: Sequence[Sequence[fmpq]]) -> list[fmpq] | None:
    """Return v > 0 with first + error v < v, or None.

    Then the spectral radius of error is below 1, and z <= first + error z implies z <= v.
    """
    n = len(first)
    matrix = [[float(i == j) - number(error[i][j]) for j in range(n)] for i in range(n)]
    found = guess.solve(matrix, [[1.01 * number(f) + 1e-30] for f in first])
    if found is None:
        return None
    v = [rational(f[0]) for f in found]
    image = [
        f + sum((e * x for e, x in zip(row, v, strict=True)), fmpq(0))
        for f, row in zip(first, error, strict=True)
    ]
    return v if all(x > 0 and new < x for x, new in zip(v, image, strict=True)) else None


def combine(weights: Sequence[fmpq], forms: Sequence[fmpq_mpoly]) -> fmpq_mpoly:
    """Return a weighted sum of forms."""
    return total([form * weight for form, weight in zip(forms, weights, strict=True)])


def no_position(turned: Turned) -> bool:
    """Return True when the three spheres of the triple have no common point over the cell.

    With any weights g, h a common point has 0 <= |x + g d_2 + h d_3|^2 = l_1^2 + |g d_2 + h d_3|^2 + 2 (g
    K_2 + h K_3).
    """
    (d2, k2), (d3, k3) = turned.lines()[:2]
    a, b, right = middles(turned)
    weights = guess.solve([[guess.inner(v, w) for w in (a, b)] for v in (a, b)], [[-k] for k in right])
    if weights is None:
        return False
    g, h = (rational(w[0]) for w in weights)
    mixed = [v * g + w * h for v, w in zip(d2, d3, strict=True)]
    gap = (
        turned.s * turned.s * turned.platform.squares[0]
        + dot(mixed, mixed)
        + 2 * turned.s * (k2 * g + k3 * h)
    )
    return bool(highest(gap) < 0)


class Place:
    """A cell with an enclosure of the position: what the equations can take out of other forms."""

    def __init__(self, turned: Turned, x: Vector, on_branch: bool) -> None:
        self.turned, self.x = turned, x
        self.symbols = ON_BRANCH if on_branch else POSE
        lengths = turned.lengths(x)
        # On a branch the second and third length only say again how the position follows u.
        self.equations = (
            [lengths[0], *lengths[2 if turned.platform.planar else 3 :]] if on_branch else lengths
        )
        self.slopes = [[number(v) for v in slopes(f, self.symbols)] for f in self.equations]
        self.columns = guess.pivots(self.slopes)
        full = len(self.columns) == len(self.equations)
        self.inverse = (
            guess.inverse([[row[k] for row in self.slopes] for k in self.columns]) if full else None
        )

    def multipliers(self, slope: Sequence[float]) -> list[float]:
        """Return multiples of the equations that cancel slopes in the pivots."""
        if self.inverse is None:
            return [0.0] * len(self.equations)
        return [-guess.inner(row, [slope[k] for k in self.columns]) for row in self.inverse]

    def freed(self, form: fmpq_mpoly) -> fmpq_mpoly:
        """Return a form of the same value at solutions without slopes in the pivots."""
        weights = self.multipliers([number(v) for v in slopes(form, self.symbols)])
        return form + combine([short(w) for w in weights], self.equations)

    def positive(self, form: fmpq_mpoly) -> bool:
        """Return True when a form is positive at every solution in the cell."""
        return bool(lowest(form) > 0 or lowest(self.freed(form)) > 0)

    def no_length(self) -> bool:
        """Return True when the taut cables cannot all have their lengths in the cell."""
        if any(map(has_no_zero, self.equations)):
            return True
        combined = zip(*(self.inverse or ()), strict=True)
        return any(has_no_zero(combine([short(w) for w in weights], self.equations)) for weights in combined)

    def kept(self, k: int, lo: float, hi: float) -> tuple[fmpq, fmpq] | None:
        """Return bounds of the entry k of (u, x) at all solutions, its bounds being lo, hi; None: no others.

        A combination c + a e_k + rest of the equations that vanishes there puts the symbol e_k within (-c
        +- |rest|) / a.
        """
        if k not in self.columns or self.inverse is None:
            return None
        pivot = self.columns.index(k)
        form = combine([short(row[pivot]) for row in self.inverse], self.equations)
        c, a = centre(form), slopes(form, [k])[0]
        rest = size(form) - abs(c) - abs(a)
        if not a > 0:
            return None
        middle, radius = (rational(lo) + rational(hi)) / 2, (rational(hi) - rational(lo)) / 2
        return middle - radius * (c + rest) / a, middle - radius * (c - rest) / a

    def cut_to(self, k: int, old: tuple[float, float], new: tuple[float, float]) -> bool:
        """Return True when the entry k of (u, x), with old bounds, lies within new ones at all solutions."""
        found = self.kept(k, *old)
        if found is None:
            return new == old
        return all(
            o == n or (rational(n) - f) * side <= 0
            for o, n, f, side in zip(old, new, found, (1, -1), strict=True)
        )
