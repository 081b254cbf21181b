"""Cells of the pose space, many at once: where the platform can be over them, and tests that exclude them.

Each test is an inequality between forms over the cells, and says where it holds. A multiple of an equation
may be added to any form without changing its value at a solution; multipliers, directions y and their slopes
are doubles that only make the inequality likely.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy

import numpy as np

from certificates.arithmetic import guess
from certificates.arithmetic.forms import ALONG, Array, Form, Vector, stacked
from certificates.arithmetic.guess import usable
from certificates.arithmetic.vectors import cross, dot
from certificates.geometry import Rotated

Lines = tuple[Vector, Form, Vector, Form]
"""d_2, K_2, d_3 and K_3, or others that say the same of x: d . x = K."""


def upright(rotated: Rotated) -> Lines:
    """Return combinations of the two lines whose directions are about at right angles, of length one.

    They are d_2 and d_3 times a triangular matrix of doubles with positive diagonal: they hold for the same
    x, and d_2 x d_3 points the same way. Where centres are nearly parallel all that follows is sharper.
    """
    kind, ((d2, k2), (d3, k3)) = type(rotated.s), rotated.pair
    a, b = (stacked([v.doubles() for v in d]) for d in (d2, d3))
    first = np.sqrt(sum(a * a))
    along = sum(a * b) / first
    second = np.sqrt(sum((b - along / first * a) ** 2))
    usual = (first > 1e-100) & (second > 1e-100) & (first < 1e100) & (second < 1e100)
    p, r = np.where(usual, 1.0 / first, 1.0), np.where(usual, 1.0 / second, 1.0)
    q = np.where(usual, -along / (first * second), 0.0)
    e2, e3 = (
        [kind.combine([p], [v]) for v in d2],
        [kind.combine([q, r], pair) for pair in zip(d2, d3, strict=True)],
    )
    return e2, kind.combine([p], [k2]), e3, kind.combine([q, r], [k2, k3])


def near_branch(rotated: Rotated, lines: Lines, side: int) -> Vector:
    """Return forms near the position on one side; a guess."""
    kind, (d2, k2, d3, k3) = type(rotated.s), lines
    a, b = (stacked([v.doubles() for v in d]) for d in (d2, d3))
    normal = guess.cross(a, b)
    right = stacked([k2.doubles(), k3.doubles(), 0.0 * a[0]])
    foot = guess.solve(np.stack([a, b, normal]), right[:, None])[:, 0]
    height = rotated.platform.square.doubles() - sum(foot * foot)
    meets = height > 0.0
    x0 = foot + side * np.sqrt(np.maximum(0.0, height) / sum(normal * normal)) * normal
    inverse = guess.inverse(np.stack([np.where(meets, 2.0 * x0, normal), a, b]))
    x0, inverse = usable(x0), usable(inverse)
    x = [kind.near(v) for v in x0]
    for degree in (1, 2):
        sphere = (dot(x, x) - rotated.platform.square) * kind.near(meets.astype(float))
        wrong = [sphere, dot(d2, x) - k2, dot(d3, x) - k3]
        x = [v - kind.combine(row, wrong).upto(degree) for v, row in zip(x, inverse, strict=True)]
    return [v.upto(2) for v in x]


def on_branch(rotated: Rotated, side: int) -> tuple[Vector, Array]:
    """Return forms that enclose every position on one side over the cells, and where they do.

    With d_2 and d_3 those of `upright` and m = d_2 x d_3 every position is x = y + alpha d_2 + beta d_3 + tau
    m for any y. The linear equations bound alpha and beta: G (alpha, beta) = -(r_2, r_3) with G the scalar
    products of d_2 and d_3 and r their residuals at y. With w = y + alpha d_2 + beta d_3 the sphere says tau
    (m . y + m . x) = l^2 - |w|^2, and on this side side (m . x) >= 0. Where side (m . y) >= h > 0 therefore
    |tau| <= |l^2 - |w|^2| / h. Where it is at least -g, |m . y + m . x| >= |tau| |m|^2 - 2 g, so |tau| <= q +
    sqrt(q^2 + |l^2 - |w|^2| / |m|^2) with q = g / |m|^2.
    """
    kind, lines = type(rotated.s), upright(rotated)
    y, (d2, k2, d3, k3) = near_branch(rotated, lines, side), lines
    m = cross(d2, d3)
    straight = [v.upto(1) for v in m]
    normal = [v.upto(0) for v in m]
    # |m| >= m . n / |n| for any n.
    square = kind.square_quotient(np.maximum(0, dot(m, normal).lowest()), dot(normal, normal).highest())
    alpha, beta, holds = in_plane(d2, d3, [dot(d2, y) - k2, dot(d3, y) - k3])
    rest = [kind.bound([(v.size(), alpha), (w.size(), beta)]) for v, w in zip(d2, d3, strict=True)]
    w = [v + kind.unknown(r) for v, r in zip(y, rest, strict=True)]
    wrong, height = (dot(w, w) - rotated.platform.square).size(), (side * dot(m, y)).lowest()
    below, share = kind.quotient(np.maximum(0, -height), square), kind.quotient(wrong, square)
    tau = below + kind.root(kind.bound([(below, below)], share))
    tau = kind.bound([], np.where(height > 0, np.minimum(tau, kind.quotient(wrong, height)), tau))
    along = kind.unknown(tau, ALONG)
    bent = [kind.bound([(tau, (v - u).size())]) for v, u in zip(m, straight, strict=True)]
    x = [v + along * u + kind.unknown(r) for v, u, r in zip(w, straight, bent, strict=True)]
    return ([x[0], kind.constant(0), x[2]] if rotated.platform.planar else x), holds & (square > 0)


def in_plane(d2: Vector, d3: Vector, wrong: Sequence[Form]) -> tuple[Array, Array, Array]:
    """Return bounds of |alpha| and |beta| with G (alpha, beta) = -wrong, and where they hold.

    With C near the inverse of G: v bounds the solution when |C wrong| + |I - C G| v <= v.
    """
    mixed = dot(d2, d3)
    gram = [[dot(d2, d2), mixed], [mixed, dot(d3, d3)]]
    inverse = usable(guess.inverse(doubles(gram)))
    first = [type(mixed).combine(row, wrong).size() for row in inverse]
    (alpha, beta), holds = contained(type(mixed), first, deviation(inverse, gram))
    return alpha, beta, holds


def doubles(matrix: Sequence[Sequence[Form]]) -> Array:
    """Return doubles near the values of a matrix of forms, (n, m, N)."""
    flat = np.broadcast_arrays(*(v.doubles() for row in matrix for v in row))
    return np.stack(flat).reshape(len(matrix), -1, len(flat[0]))


def deviation(inverse: Array, matrix: Sequence[Sequence[Form]]) -> list[list[Array]]:
    """Return bounds of the entries of |C J - I|."""
    columns = list(zip(*matrix, strict=True))
    combine = type(matrix[0][0]).combine
    return [
        [(combine(row, column) - int(i == j)).size() for j, column in enumerate(columns)]
        for i, row in enumerate(inverse)
    ]


def contained(kind: type[Form], first: Sequence[Array], error: list[list[Array]]) -> tuple[Array, Array]:
    """Return v > 0 with first + error v < v, and where it is one.

    Then the spectral radius of error is below 1, and z <= first + error z implies z <= v.
    """
    n, flat = len(first), np.broadcast_arrays(*first, *(e for row in error for e in row))
    found = kind.doubles_near(np.stack(flat))
    matrix = np.eye(n)[:, :, None] - found[n:].reshape(n, n, -1)
    v = guess.solve(matrix, 1.01 * found[:n, None] + 1e-17)[:, 0]
    is_one = np.all((v > 0.0) & (v < 1e100), axis=0)
    v = kind.numbers(np.where(is_one, v, 1.0))
    for f, row, x in zip(first, error, v, strict=True):
        is_one = is_one & (kind.bound(list(zip(row, v, strict=True)), f) < x)
    return v, is_one


def no_position(rotated: Rotated) -> Array:
    """Return where the first three spheres have no common point over the cells.

    A common point has K = d . x <= l_1 |d|; and with m = d_2 x d_3 it has m x x = K_2 d_3 - K_3 d_2, which is
    not longer than l_1 |m|.
    """
    (d2, k2), (d3, k3) = rotated.pair
    square, m = rotated.platform.square, cross(d2, d3)
    across = [k2 * v - k3 * w for v, w in zip(d3, d2, strict=True)]
    found = (dot(across, across) - dot(m, m) * square).lowest() > 0
    for d, k in rotated.pair:
        found = found | ((k * k - dot(d, d) * square).lowest() > 0)
    return found


class Place:
    """Cells with an enclosure of the position: what the equations can take out of other forms."""

    def __init__(self, rotated: Rotated, x: Vector, on_branch: bool) -> None:
        self.rotated, self.x, self.kind = rotated, x, type(rotated.s)
        self.count = ALONG + 1 if on_branch else 6
        """Symbols: u, then the distance along the normal of the centres from a guess, or x."""
        self.equations = rotated.equations(x, on_branch)
        self.slopes = slopes(self.equations, self.count)
        """(equations, symbols, N)."""
        self.columns = guess.pivots(self.slopes)
        """(equations, N)."""
        at = np.maximum(self.columns, 0)[None]
        at = np.broadcast_to(at, (len(self.equations), *self.columns.shape))
        found = guess.inverse(np.swapaxes(np.take_along_axis(self.slopes, at, axis=1), 0, 1))
        is_one = np.all(self.columns >= 0, axis=0) & np.all(np.isfinite(found), axis=(0, 1))
        self.inverse = np.where(is_one, found, 0.0)
        """(equations, pivots, N), of the slopes in the pivots; 0 where there is none."""

    def at(self, cells: Array) -> Place:
        """Return the same over some of the cells."""
        found = copy(self)
        found.equations = [f.at(cells) for f in self.equations]
        found.slopes, found.columns, found.inverse = (
            v[..., cells] for v in (self.slopes, self.columns, self.inverse)
        )
        return found

    def multipliers(self, slope: Array) -> Array:
        """Return multiples (equations, N) of the equations that cancel slopes (symbols, N) in the pivots."""
        wide = np.broadcast_to(slope, (self.count, self.columns.shape[1]))
        wanted = np.take_along_axis(wide, np.maximum(self.columns, 0), axis=0)
        return -np.einsum("ekc,kc->ec", self.inverse, wanted)

    def positive(self, form: Form) -> Array:
        """Return where a form is positive at every solution in the cells."""
        freed = form + self.kind.combine(self.multipliers(form.slope_doubles(self.count)), self.equations)
        return (form.lowest() > 0) | (freed.lowest() > 0)

    def no_length(self) -> Array:
        """Return where the taut cables cannot all have their lengths in the cells."""
        rows = [self.kind.combine(weights, self.equations) for weights in np.swapaxes(self.inverse, 0, 1)]
        found = [f.has_no_zero() for f in [*self.equations, *rows]]
        return np.any(stacked(found), axis=0)

    def cut_to(self, k: int, old: Array, new: Array) -> Array:
        """Return where the entry k of (u, x), with old bounds (2, N), lies within new ones at all solutions.

        A combination c + a e_k + rest of the equations that vanishes there puts the symbol e_k within (-c
        +- |rest|) / a.
        """
        is_pivot = self.columns == k
        weights = np.einsum("kc,ekc->ec", is_pivot.astype(float), self.inverse)
        form, entry = self.kind.combine(weights, self.equations), self.kind.between(*old, k)
        a, radius = form.slopes[k], entry.slopes[k]
        rest, low, high = form.change() - abs(a), self.kind.numbers_up(new[0]), self.kind.numbers(new[1])
        # The entry is at least middle - radius (c + rest) / a and at most middle + radius (rest - c) / a.
        above = self.kind.exceeds(a, entry.value - low, radius, rest + form.value)
        below = self.kind.exceeds(a, high - entry.value, radius, rest - form.value)
        found = (is_pivot.any(axis=0)) & (a > 0)
        return (found & above | (new[0] == old[0])) & (found & below | (new[1] == old[1]))


def slopes(forms: Sequence[Form], count: int) -> Array:
    """Return doubles near the slopes of forms by ``count`` symbols, (forms, symbols, N)."""
    return stacked([f.slope_doubles(count) for f in forms])
