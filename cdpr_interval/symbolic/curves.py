"""Plane curves in (rho_1, rho_2) on which all static poses lie, evaluated in any ring.

What `Statics` leaves in rho_1..rho_n is brought to two unknowns:

- two cables: S and D_2 themselves;
- three: D_2 is linear in w_3, which is put into S and D_3;
- four: D_2 is linear in w_3 and w_4; with w_4 put into S, D_3 and D_4 these are three polynomials a_1, a_2,
  a_3 of degrees 2, 3, 3 in rho_3 alone. They share a root only where

      P_1 = det (a_1; rho_3 a_1; a_2; a_3) in the powers of rho_3, P_2 = Res(a_1, a_2), P_3 = Res(a_1, a_3)

  and Q = Res(a_2, a_3) vanish (Merlet 2012: P_1 and P_2 in IV.A, P_2 and Q lead to his degrees in IV.C).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from flint import fmpq

from cdpr_interval.symbolic.statics import Statics, dot

Ring = Any
Polynomial = list[Ring]
"""Coefficients from the constant on."""


@dataclass(frozen=True)
class Numbers:
    """The numbers of a system that its equations need, in some ring."""

    gram: list[list[Ring]]
    """a_i . a_j."""
    pulls: list[Ring]
    """a_i . f."""
    square: Ring
    """|f|^2."""
    u: list[Ring]
    v: list[Ring]

    @classmethod
    def of(cls, statics: Statics, convert: Callable[[fmpq], Ring]) -> Numbers:
        """Convert a system's numbers."""
        arms = statics.arms()
        return cls(
            [[convert(dot(a, b)) for b in arms] for a in arms],
            [convert(dot(a, statics.load)) for a in arms],
            convert(dot(statics.load, statics.load)),
            [convert(x) for x in statics.u],
            [convert(x) for x in statics.v],
        )


@dataclass(frozen=True)
class Line:
    """What D_2 makes of the w_i: all multiplied by ``scale``, polynomials in rho_3 (constants without it)."""

    scale: Polynomial
    w: list[Polynomial]
    """Of the cables from the second on."""
    total: Polynomial
    """T."""
    divisors: list[Ring]
    """Their powers divide the curves, besides powers of rho_1 and rho_2; the second is w_1 + w_2."""


def line(numbers: Numbers, r1: Ring, r2: Ring) -> Line:
    """Solve D_2 for the w of the last cable."""
    n, g, u, v = len(numbers.pulls), numbers.gram, numbers.u, numbers.v
    w1, w2 = r2 * (u[0] * r1 - v[0]), r1 * (u[1] * r2 - v[1])
    both, sides = w1 + w2, r1 * r2
    if n == 2:
        return Line([sides], [[w2]], [both], [sides, both])
    gap = r2 * r2 - r1 * r1 - g[1][1]
    known = both * gap + 2 * (sides * numbers.pulls[1] + w2 * g[1][1])
    factors = [gap + 2 * g[1][j] for j in range(2, n)]
    if n == 3:
        scale = sides * factors[0]
        total = both * factors[0] - known
        return Line([scale], [[w2 * factors[0]], [-known]], [total], [factors[0], both])
    scale, third = sides * factors[1], sides * factors[0]
    w3 = [-(scale * v[2]), scale * u[2]]
    w4 = [third * v[2], -(known + third * u[2])]
    total = [w3[0] + w4[0], w3[1] + w4[1] + both * factors[1]]
    return Line([0 * scale, scale], [[0 * scale, w2 * factors[1]], w3, w4], total, [factors[1], both])


def conditions(numbers: Numbers, found: Line, r1: Ring, r2: Ring) -> list[Polynomial]:
    """Return S and the D_i (i > 2; of two cables D_2) on a line, as polynomials in rho_3."""
    n, g = len(numbers.pulls), numbers.gram
    p, w, t = found.scale, found.w, found.total
    size = times(times(p, p), [numbers.square])
    for i in range(1, n):
        size = plus(size, times(times(p, w[i - 1]), [2 * numbers.pulls[i]]))
        for j in range(1, n):
            size = plus(size, times(times(w[i - 1], w[j - 1]), [g[i][j]]))
    conditions = [plus(times(times(t, t), [r1 * r1]), times(size, [-1]))]
    for i in range(1, n) if n == 2 else range(2, n):
        if n == 2:
            above, below = [r2 * r2], [1 + 0 * r2]
        elif i == 2 and n == 4:
            above, below = [0 * r2, 0 * r2, 1 + 0 * r2], [1 + 0 * r2]
        else:
            spring = plus(times(p, [numbers.u[i]]), times(w[i - 1], [-1]))
            above, below = times(times(p, p), [numbers.v[i] * numbers.v[i]]), times(spring, spring)
        moment = times(p, [numbers.pulls[i]])
        for j in range(1, n):
            moment = plus(moment, times(w[j - 1], [g[i][j]]))
        length = plus(above, times(below, [-(r1 * r1) - g[i][i]]))
        conditions.append(plus(times(t, length), times(times(below, moment), [2])))
    return conditions


def plus(a: Polynomial, b: Polynomial) -> Polynomial:
    """Return a + b."""
    longer, shorter = (a, b) if len(a) >= len(b) else (b, a)
    return [x + shorter[k] if k < len(shorter) else x for k, x in enumerate(longer)]


def times(a: Polynomial, b: Polynomial) -> Polynomial:
    """Return a b."""
    found: list[Ring] = [None] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            found[i + j] = x * y if found[i + j] is None else found[i + j] + x * y
    return found


def matrices(found: list[Polynomial]) -> list[list[Polynomial]]:
    """Return matrices whose determinants vanish on P_1, P_2, P_3, Q (of fewer than four cables: S and D)."""
    if len(found) == 2:
        return [[condition] for condition in found]
    a1, a2, a3 = found
    return [[[*a1, 0], [0, *a1], a2, a3], sylvester(a1, a2), sylvester(a1, a3), sylvester(a2, a3)]


def sylvester(a: Polynomial, b: Polynomial) -> list[Polynomial]:
    """Return the Sylvester matrix of two polynomials."""
    m, n = len(a) - 1, len(b) - 1
    upper = [[0] * i + a[::-1] + [0] * (n - 1 - i) for i in range(n)]
    return upper + [[0] * i + b[::-1] + [0] * (m - 1 - i) for i in range(m)]
