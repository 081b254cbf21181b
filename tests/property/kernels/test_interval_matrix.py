"""Matrices of intervals against exact fractions: every real matrix inside must keep what is claimed."""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations, permutations
from typing import Any

import numpy as np
import pytest

from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.kernels import interval_matrix as im

Matrix = list[list[Fraction]]
WIDTHS = (0.0, 1e-12, 1e-6, 1e-3, 0.1, 1.0)


def product(a: Matrix, b: Matrix) -> Matrix:
    return [
        [sum((x * y for x, y in zip(row, c, strict=True)), Fraction(0)) for c in zip(*b, strict=True)]
        for row in a
    ]


def transposed(a: Matrix) -> Matrix:
    return [list(row) for row in zip(*a, strict=True)]


def determinant(a: Matrix) -> Fraction:
    if not a:
        return Fraction(1)
    rows, sign = [list(row) for row in a], 1
    for k in range(len(rows)):
        pivot = next((i for i in range(k, len(rows)) if rows[i][k]), None)
        if pivot is None:
            return Fraction(0)
        if pivot != k:
            rows[k], rows[pivot], sign = rows[pivot], rows[k], -sign
        for i in range(k + 1, len(rows)):
            f = rows[i][k] / rows[k][k]
            rows[i] = [x - f * y for x, y in zip(rows[i], rows[k], strict=True)]
    result = Fraction(sign)
    for k in range(len(rows)):
        result *= rows[k][k]
    return result


def solved(a: Matrix, b: Matrix) -> Matrix:
    """Return a^-1 b of a regular matrix (Gauss-Jordan)."""
    m = len(a)
    rows = [[*x, *y] for x, y in zip(a, b, strict=True)]
    for k in range(m):
        pivot = next(i for i in range(k, m) if rows[i][k])
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(m):
            if i != k:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [row[m:] for row in rows]


def random_matrix(rng: random.Random, m: int, n: int) -> Matrix:
    """Return fractions of mixed sizes; some are zero, some equal."""
    scale = rng.choice([1, 1, 1000])
    return [
        [Fraction(rng.choice([0, rng.randint(-9999, 9999)]) * scale, 7919) for _ in range(n)]
        if rng.random() < 0.3
        else [Fraction(rng.randint(-9999, 9999), 7919) for _ in range(n)]
        for _ in range(m)
    ]


def around(rng: random.Random, a: Matrix, width: float) -> Any:
    """Return intervals of about this width that hold a matrix anywhere, often at their border."""
    bounds = np.array([[enclose(x) for x in row] for row in a])
    for index in np.ndindex(*bounds.shape[:2]):
        bounds[index][0] -= width * rng.choice([0.0, 1.0, rng.random()])
        bounds[index][1] += width * rng.choice([0.0, 1.0, rng.random()])
    return bounds


def symmetric_around(rng: random.Random, a: Matrix, width: float) -> Any:
    """Return the same for a symmetric matrix; the intervals are symmetric too."""
    bounds = around(rng, a, width)
    for i in range(len(a)):
        bounds[:i, i] = bounds[i, :i]
    return bounds


def member(rng: random.Random, bounds: Any) -> Matrix:
    """Return an exact matrix inside, often a corner."""

    def value(lo: float, hi: float) -> Fraction:
        share = rng.choice([Fraction(0), Fraction(1), Fraction(rng.randint(0, 97), 97)])
        return Fraction(lo) + (Fraction(hi) - Fraction(lo)) * share

    return [[value(lo, hi) for lo, hi in row] for row in bounds.tolist()]


def symmetric_member(rng: random.Random, bounds: Any) -> Matrix:
    a = member(rng, bounds)
    return [[a[max(i, j)][min(i, j)] for j in range(len(a))] for i in range(len(a))]


def holds(bounds: Any, a: Matrix) -> bool:
    return all(
        lo <= x <= hi
        for row, exact in zip(bounds.tolist(), a, strict=True)
        for (lo, hi), x in zip(row, exact, strict=True)
    )


def widest(bounds: Any) -> float:
    return float(np.max(bounds[..., 1] - bounds[..., 0]))


@pytest.mark.parametrize("width", WIDTHS)
def test_products_enclose_the_exact_ones(width: float) -> None:
    rng = random.Random(1)
    for m, k, n in [(1, 3, 1), (3, 3, 3), (6, 6, 2), (2, 6, 6)] * 5:
        a, b = random_matrix(rng, m, k), random_matrix(rng, k, n)
        A, B, out = around(rng, a, width), around(rng, b, width), np.empty((m, n, 2))
        im.multiply(A, B, out)
        assert holds(out, product(a, b)) and holds(out, product(member(rng, A), member(rng, B)))
        assert width or widest(out) < 1e-8


@pytest.mark.parametrize("width", WIDTHS)
def test_congruences_enclose_the_exact_ones(width: float) -> None:
    rng = random.Random(2)
    for n, d in [(6, 4), (6, 1), (3, 3), (4, 2)] * 5:
        w = random_matrix(rng, n, d)
        half = random_matrix(rng, n, n)
        q = [[half[i][j] + half[j][i] for j in range(n)] for i in range(n)]
        W, Q, out = around(rng, w, width), symmetric_around(rng, q, width), np.empty((d, d, 2))
        im.congruence(W, Q, out)
        for x, y in ((w, q), (member(rng, W), symmetric_member(rng, Q))):
            assert holds(out, product(transposed(x), product(y, x)))


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("m", [1, 2, 3, 5, 6])
def test_solutions_of_linear_systems_are_enclosed(m: int, width: float) -> None:
    rng = random.Random(3)
    answers = 0
    for _ in range(20):
        c = rng.randint(1, 4)
        a = random_matrix(rng, m, m + c)
        if determinant([row[:m] for row in a]) == 0:
            continue
        A, X = around(rng, a, width), np.empty((m, c, 2))
        if not im.solve(A, X):
            assert width > 1e-12
            continue
        answers += 1
        for x in (a, *(member(rng, A) for _ in range(4))):
            assert holds(X, solved([row[:m] for row in x], [row[m:] for row in x]))
        assert width or widest(X) < 1e-8 * (1.0 + np.abs(X).max())
    assert answers or width > 0.01


@pytest.mark.parametrize("m", [2, 3, 6])
def test_intervals_that_hold_a_singular_matrix_are_not_solved(m: int) -> None:
    rng = random.Random(4)
    for width in WIDTHS:
        for _ in range(20):
            a = random_matrix(rng, m, m + 1)
            weights = [Fraction(rng.randint(-3, 3)) for _ in range(m - 1)]
            for row in a:
                row[m - 1] = sum((x * w for x, w in zip(row, weights, strict=False)), Fraction(0))
            assert not im.solve(around(rng, a, width), np.empty((m, 1, 2)))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e200])
def test_entries_that_are_not_finite_prove_nothing(bad: float) -> None:
    rng = random.Random(5)
    for place in np.ndindex(3, 4, 2):
        A = around(rng, [[Fraction(int(i == j)) for j in range(4)] for i in range(3)], 1e-3)
        A[place] = bad
        if abs(bad) != 1e200:
            assert not im.solve(A, np.empty((3, 1, 2)))
            assert not im.kernel_basis(A, np.empty((4, 1, 2))) or place[1] == 3
        Q = symmetric_around(rng, [[Fraction(int(i == j)) for j in range(3)] for i in range(3)], 1e-3)
        if place[1] < 3:
            Q[place] = bad
            Q[place[1], place[0], place[2]] = bad
            assert im.definiteness(Q) == im.OPEN


def kernel_member(basis: Any, g: Matrix) -> bool:
    """Return whether the kernel vectors of g that are unit vectors in the free entries lie in the basis."""
    n, d = basis.shape[:2]
    exact = [i for i in range(n) if np.all(basis[i, :, 0] == basis[i, :, 1])]
    for free in permutations(exact, d):
        if not np.array_equal(basis[list(free), :, 0], np.eye(d)):
            continue
        pivots = [i for i in range(n) if i not in free]
        left = [[row[i] for i in pivots] for row in g]
        if determinant(left) == 0:
            return False
        x = solved(left, [[-row[i] for i in free] for row in g])
        return holds(basis[pivots], x)
    raise AssertionError("no identity in the basis")


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("m", [1, 2, 3, 4, 5])
def test_kernels_are_enclosed(m: int, width: float) -> None:
    rng = random.Random(6)
    answers = 0
    for _ in range(12):
        g = random_matrix(rng, m, 6)
        G, basis = around(rng, g, width), np.empty((6, 6 - m, 2))
        if not im.kernel_basis(G, basis):
            continue
        answers += 1
        assert kernel_member(basis, g) and all(kernel_member(basis, member(rng, G)) for _ in range(3))
        assert width or widest(basis) < 1e-8 * (1.0 + np.abs(basis).max())
    assert answers > 6 or width > 1e-6


@pytest.mark.parametrize("m", [2, 3, 5])
def test_rows_that_may_be_dependent_have_no_proved_kernel(m: int) -> None:
    rng = random.Random(7)
    for width in WIDTHS:
        for _ in range(10):
            g = random_matrix(rng, m, 6)
            g[-1] = [3 * x - y for x, y in zip(g[0], g[-2], strict=True)]
            assert not im.kernel_basis(around(rng, g, width), np.empty((6, 6 - m, 2)))


def is_positive(q: Matrix) -> bool:
    """Return True for a positive definite matrix (Sylvester)."""
    return all(determinant([row[:k] for row in q[:k]]) > 0 for k in range(1, len(q) + 1))


def is_semidefinite(q: Matrix) -> bool:
    """Return True when no principal minor is negative."""
    count = len(q)
    subsets: Sequence[tuple[int, ...]] = [
        s for k in range(1, count + 1) for s in combinations(range(count), k)
    ]
    return all(determinant([[q[i][j] for j in s] for i in s]) >= 0 for s in subsets)


def with_eigenvalues(rng: random.Random, values: Sequence[Fraction]) -> Matrix:
    """Return S^T diag(values) S: as many positive, zero and negative directions as the values have."""
    d = len(values)
    while True:
        s = random_matrix(rng, d, d)
        if determinant(s):
            return product(transposed(s), [[v * x for x in row] for v, row in zip(values, s, strict=True)])


@pytest.mark.parametrize("d", [1, 2, 3, 4, 5])
def test_definiteness_is_proved_for_every_member(d: int) -> None:
    rng = random.Random(8)
    seen = set()
    for width in WIDTHS:
        for _ in range(15):
            values = [Fraction(rng.randint(1, 50), 10) for _ in range(d)]
            negative = rng.random() < 0.5
            if negative:
                values[rng.randrange(d)] *= -1
            q = with_eigenvalues(rng, values)
            Q = symmetric_around(rng, q, width)
            verdict = im.definiteness(Q)
            if width == 0.0:
                assert verdict != (im.POSITIVE if negative else im.NEGATIVE)
                seen.add(verdict)
            for x in (q, *(symmetric_member(rng, Q) for _ in range(4))):
                assert verdict != im.POSITIVE or is_positive(x)
                assert verdict != im.NEGATIVE or not is_semidefinite(x)
    assert {im.POSITIVE, im.NEGATIVE} <= seen


@pytest.mark.parametrize("d", [1, 2, 3, 5])
def test_a_singular_semidefinite_member_leaves_it_open(d: int) -> None:
    rng = random.Random(9)
    for width in WIDTHS:
        for _ in range(15):
            values = [Fraction(rng.randint(1, 50), 10) for _ in range(d)]
            values[rng.randrange(d)] = Fraction(0)
            assert im.definiteness(symmetric_around(rng, with_eigenvalues(rng, values), width)) == im.OPEN
