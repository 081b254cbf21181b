"""One cell of the pose space: where the platform can be over it, and the tests that exclude it.

Each test is an inequality between forms over the cell. A multiple of an equation may be added to any form
without changing its value at a solution; multipliers, directions y and their slopes are floats that only
make the inequality likely.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from certificates.arithmetic import guess
from certificates.arithmetic.forms import (
    ALONG,
    BITS,
    UNIT,
    Form,
    Vector,
    between,
    combine,
    near,
    slopes,
    value,
)
from certificates.arithmetic.vectors import cross, dot
from certificates.geometry import Turned


def middles(turned: Turned) -> tuple[list[float], list[float], list[float]]:
    """Return d_2, d_3 and (K_2, K_3) at the cell's centre."""
    (d2, k2), (d3, k3) = turned.pair
    s = value(turned.s)
    return [value(v) / s for v in d2], [value(v) / s for v in d3], [value(k2) / s, value(k3) / s]


def near_branch(turned: Turned, side: int) -> Vector | None:
    """Return forms near the position on one side; a guess."""
    a, b, right = middles(turned)
    normal = guess.cross(a, b)
    foot = guess.solve([a, b, normal], [[right[0]], [right[1]], [0.0]])
    if foot is None:
        return None
    height = value(turned.platform.square) - sum(v[0] * v[0] for v in foot)
    step = side * math.sqrt(max(0.0, height) / guess.inner(normal, normal))
    x0 = [v[0] + step * w for v, w in zip(foot, normal, strict=True)]
    s = value(turned.s)
    across = [2.0 * v for v in x0] if height > 0.0 else normal
    inverse = guess.inverse([across, [s * v for v in a], [s * v for v in b]])
    if inverse is None:
        return None
    x = [near(v) for v in x0]
    for degree in (1, 2):
        wrong = turned.lengths(x, turned.pair)
        if not height > 0.0:
            wrong[0] = Form(0)
        x = [v - combine(row, wrong).upto(degree) for v, row in zip(x, inverse, strict=True)]
    return [v.upto(2) for v in x]


def on_branch(turned: Turned, side: int) -> Vector | None:
    """Return forms that enclose every position on one side over the cell, or None.

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
    (d2, k2), (d3, k3) = turned.pair
    m = cross(d2, d3)
    straight = [v.upto(1) for v in m]
    normal = [Form(v.value) for v in straight]
    # |m| >= m . n / |n| for any n.
    square = max(0, dot(m, normal).lowest()) ** 2 // dot(normal, normal).highest()
    within = in_plane(d2, d3, [dot(d2, y) - k2, dot(d3, y) - k3]) if square > 0 else None
    if within is None:
        return None
    rest = [product(v.size(), within[0]) + product(w.size(), within[1]) for v, w in zip(d2, d3, strict=True)]
    w = [v + Form(0, rest=r) for v, r in zip(y, rest, strict=True)]
    wrong, height = (dot(w, w) - turned.platform.square).size(), (side * dot(m, y)).lowest()
    below = quotient(max(0, -height), square)
    tau = below + math.isqrt(below * below + quotient(wrong, square) * UNIT) + 1
    tau = min(tau, quotient(wrong, height)) if height > 0 else tau
    along = Form(0, [0] * ALONG + [tau])
    bent = [product(tau, (v - u).size()) for v, u in zip(m, straight, strict=True)]
    x = [v + along * u + Form(0, rest=r) for v, u, r in zip(w, straight, bent, strict=True)]
    return [x[0], Form(0), x[2]] if turned.platform.planar else x


def product(a: int, b: int) -> int:
    """Return a bound of the product of two bounds, in units."""
    return (a * b >> BITS) + 1


def quotient(a: int, b: int) -> int:
    """Return a bound of a / b, in units, of a bound a >= 0 and a lower bound b > 0."""
    return (a << BITS) // b + 1


def in_plane(d2: Vector, d3: Vector, wrong: Sequence[Form]) -> list[int] | None:
    """Return bounds of |alpha| and |beta| with G (alpha, beta) = -wrong, or None.

    With C near the inverse of G: v bounds the solution when |C wrong| + |I - C G| v <= v.
    """
    mixed = dot(d2, d3)
    gram = [[dot(d2, d2), mixed], [mixed, dot(d3, d3)]]
    inverse = guess.inverse([[value(g) for g in row] for row in gram])
    if inverse is None:
        return None
    return contained([combine(row, wrong).size() for row in inverse], deviation(inverse, gram))


def deviation(inverse: Sequence[Sequence[float]], matrix: Sequence[Sequence[Form]]) -> list[list[int]]:
    """Return bounds of the entries of |C J - I|."""
    return [
        [(combine(row, column) - int(i == j)).size() for j, column in enumerate(zip(*matrix, strict=True))]
        for i, row in enumerate(inverse)
    ]


def contained(first: Sequence[int], error: Sequence[Sequence[int]]) -> list[int] | None:
    """Return v > 0 with first + error v < v, or None.

    Then the spectral radius of error is below 1, and z <= first + error z implies z <= v.
    """
    n = len(first)
    matrix = [[float(i == j) - error[i][j] / UNIT for j in range(n)] for i in range(n)]
    found = guess.solve(matrix, [[(1.01 * f + 4 * n) / UNIT] for f in first])
    if found is None:
        return None
    v = [int(f[0] * UNIT) + 1 for f in found]
    image = [f + sum(map(product, row, v)) for f, row in zip(first, error, strict=True)]
    return v if all(x > 0 and new < x for x, new in zip(v, image, strict=True)) else None


RIDGES = (0.0, 1e-12, 1e-8, 1e-5)
"""Added to the products of two centres, over their sum: of parallel ones the best weights are large."""


def no_position(turned: Turned) -> bool:
    """Return True when the first three spheres have no common point over the cell.

    A common point has K = d . x <= l_1 |d|, and with any weights g, h 0 <= |x + g d_2 + h d_3|^2 = l_1^2 +
    |g d_2 + h d_3|^2 + 2 (g K_2 + h K_3).
    """
    (d2, k2), (d3, k3) = turned.pair
    square = turned.platform.square
    if any((k * k - dot(d, d) * square).lowest() > 0 for d, k in turned.pair):
        return True
    a, b, right = middles(turned)
    products = [[guess.inner(v, w) for w in (a, b)] for v in (a, b)]
    s = turned.s
    for ridge in RIDGES:
        more = ridge * (products[0][0] + products[1][1])
        (aa, ab), (_, bb) = products
        raised = [[aa + more, ab], [ab, bb + more]]
        weights = guess.solve(raised, [[-k] for k in right])
        if weights is None:
            continue
        gh = [w[0] for w in weights]
        mixed = [combine(gh, pair) for pair in zip(d2, d3, strict=True)]
        gap = s * s * square + dot(mixed, mixed) + 2 * s * combine(gh, [k2, k3])
        if gap.highest() < 0:
            return True
    return False


class Place:
    """A cell with an enclosure of the position: what the equations can take out of other forms."""

    def __init__(self, turned: Turned, x: Vector, on_branch: bool) -> None:
        self.turned, self.x = turned, x
        self.count = ALONG + 1 if on_branch else 6
        """Symbols: u, then the distance along the normal of the centres from a guess, or x."""
        # On a branch the second and third length only say again how the position follows u.
        self.equations = turned.lengths(x, turned.lines[2 if on_branch else 0 :])
        self.slopes = [slopes(f, self.count) for f in self.equations]
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

    def freed(self, form: Form) -> Form:
        """Return a form of the same value at solutions without slopes in the pivots."""
        return form + combine(self.multipliers(slopes(form, self.count)), self.equations)

    def positive(self, form: Form) -> bool:
        """Return True when a form is positive at every solution in the cell."""
        return form.lowest() > 0 or self.freed(form).lowest() > 0

    def no_length(self) -> bool:
        """Return True when the taut cables cannot all have their lengths in the cell."""
        if any(f.has_no_zero() for f in self.equations):
            return True
        combined = zip(*(self.inverse or ()), strict=True)
        return any(combine(weights, self.equations).has_no_zero() for weights in combined)

    def kept(self, k: int, lo: float, hi: float) -> tuple[Fraction, Fraction] | None:
        """Return bounds of the entry k of (u, x) at all solutions, its bounds being lo, hi; None: no others.

        A combination c + a e_k + rest of the equations that vanishes there puts the symbol e_k within (-c
        +- |rest|) / a.
        """
        if k not in self.columns or self.inverse is None:
            return None
        pivot = self.columns.index(k)
        form = combine([row[pivot] for row in self.inverse], self.equations)
        c, a = form.value, form.slopes[k]
        rest = form.change() - abs(a)
        if not a > 0:
            return None
        entry = between(lo, hi, k)
        middle, radius = Fraction(entry.value, UNIT), Fraction(entry.slopes[k], UNIT * a)
        return middle - radius * (c + rest), middle - radius * (c - rest)

    def cut_to(self, k: int, old: tuple[float, float], new: tuple[float, float]) -> bool:
        """Return True when the entry k of (u, x), with old bounds, lies within new ones at all solutions."""
        found = self.kept(k, *old)
        if found is None:
            return new == old
        return all(
            o == n or (Fraction(n) - f) * side <= 0
            for o, n, f, side in zip(old, new, found, (1, -1), strict=True)
        )
