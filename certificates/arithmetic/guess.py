"""Small linear algebra in plain floats: guesses, untrusted. Whatever they are, nothing false can be proved.

Everything here is tried by those who ask for it: a wrong guess makes a proof fail.
"""

from __future__ import annotations

from collections.abc import Sequence

Row = list[float]
RIDGE = 1e-12
"""Added to the diagonal of normal equations, relative to unit rows: they may be dependent."""


def solve(matrix: Sequence[Sequence[float]], right: Sequence[Sequence[float]]) -> list[Row] | None:
    """Return X with matrix X = right by elimination with pivoting, or None where that fails."""
    n = len(matrix)
    a = [[*row, *extra] for row, extra in zip(matrix, right, strict=True)]
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(a[i][k]))
        a[k], a[pivot] = a[pivot], a[k]
        if not 1e-280 < abs(a[k][k]) < 1e280:
            return None
        for i in range(n):
            if i != k:
                factor = a[i][k] / a[k][k]
                a[i] = [x - factor * y for x, y in zip(a[i], a[k], strict=True)]
    return [[x / a[k][k] for x in a[k][n:]] for k in range(n)]


def inverse(matrix: Sequence[Sequence[float]]) -> list[Row] | None:
    """Return an approximate inverse, or None."""
    n = len(matrix)
    return solve(matrix, [[float(i == j) for j in range(n)] for i in range(n)])


def inner(a: Sequence[float], b: Sequence[float]) -> float:
    """Return the scalar product."""
    return sum(x * y for x, y in zip(a, b, strict=True))


def gram(rows: Sequence[Row]) -> list[Row]:
    """Return the scalar products of rows, slightly raised on the diagonal."""
    return [
        [inner(a, b) + (RIDGE * inner(a, a) if i == j else 0.0) for j, b in enumerate(rows)]
        for i, a in enumerate(rows)
    ]


def least_norm(rows: Sequence[Row], rights: Sequence[Sequence[float]]) -> list[Row] | None:
    """Return for each list of right sides the shortest y with row . y = right for all rows."""
    weights = solve(gram(rows), [list(column) for column in zip(*rights, strict=True)])
    if weights is None:
        return None
    columns = list(zip(*rows, strict=True))
    return [[inner(column, weight) for column in columns] for weight in zip(*weights, strict=True)]


def direction(rows: Sequence[Row], wanted: Sequence[float]) -> tuple[Row, list[int]] | None:
    """Return a short y with row . y at least as wanted, and the rows where it is just that.

    The shortest such y has no negative multipliers: rows with negative ones are dropped, the worst first.
    """
    active = list(range(len(rows)))
    while active:
        chosen = [rows[i] for i in active]
        weights = solve(gram(chosen), [[wanted[i]] for i in active])
        if weights is None:
            return None
        worst = min(range(len(active)), key=lambda k: weights[k][0])
        if weights[worst][0] >= 0.0:
            columns = zip(*chosen, strict=True)
            return [inner(column, [w[0] for w in weights]) for column in columns], active
        active.pop(worst)
    return None


def cross(a: Sequence[float], b: Sequence[float]) -> Row:
    """Return the vector product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def pivots(rows: Sequence[Row]) -> list[int]:
    """Return the columns that elimination with complete pivoting chooses, one a row of full rank."""
    left = [list(row) for row in rows]
    found: list[int] = []
    while left:
        size, i, k = max((abs(v), i, k) for i, row in enumerate(left) for k, v in enumerate(row))
        if not size > 0.0:
            break
        row = left.pop(i)
        left = [[v - other[k] / row[k] * w for v, w in zip(other, row, strict=True)] for other in left]
        found.append(k)
    return found
