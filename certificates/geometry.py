"""A platform over a cell: rotation, spheres and wrenches as exact polynomials.

Rotations are R(u) D_c with the Cayley rotation R(u) and D_c the identity or a half turn; s = 1 + |u|^2 makes
s R(u) polynomial. x is the way from the first cable's exit point to its platform point. With
q_i = R (b_i - b_1), a_i = A_i - A_1 and d_i = a_i - q_i, the taut cables' lengths say

    |x|^2 = l_1^2,    d_i . x = K_i = (|d_i|^2 + l_1^2 - l_i^2) / 2,

and the balance sum t_i w_i + w_0 = 0 has, about the first platform point and with moments divided by a
length,

    w_1 = (-x, 0),    w_i = (d_i - x, q_i x (a_i - x)),    w_0 = (f, -r_1 x f).

Everything below is multiplied by s, but for |x|^2 - l_1^2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import fmpq, fmpq_mpoly

from certificates.polynomials import RING, Vector, constant, cross, dot

HALF_TURNS = ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))
"""Diagonals of D_c."""


@dataclass(frozen=True)
class Platform:
    """A robot under a load, cables in an order of which the first n are taut."""

    exits: list[Vector]
    """A_i."""
    points: list[Vector]
    """b_i from the centre of mass."""
    squares: list[fmpq_mpoly]
    """l_i^2."""
    load: Vector
    taut: int
    unit: fmpq
    """The length that divides moments."""
    planar: bool = False
    """Everything lies in the plane y = 0."""


class Turned:
    """What depends on the rotation alone."""

    def __init__(self, platform: Platform, chart: int, u: Sequence[fmpq_mpoly]) -> None:
        self.platform = platform
        squares = [x * x for x in u]
        self.s = squares[0] + squares[1] + squares[2] + 1
        self.rotation: list[Vector] = []
        for i in range(3):
            row = []
            for j in range(3):
                k = 3 - i - j
                odd = 2 if (j - i) % 3 == 2 else -2
                entry = 2 - self.s + 2 * squares[i] if i == j else 2 * u[i] * u[j] + odd * u[k]
                row.append(HALF_TURNS[chart][j] * entry)
            self.rotation.append(row)
        self.cables = [self.cable(i) for i in range(len(platform.exits))]

    def turn(self, b: Vector) -> Vector:
        """Return s R b."""
        return [dot(row, b) for row in self.rotation]

    def cable(self, i: int) -> tuple[Vector, Vector, Vector, fmpq_mpoly]:
        """Return a_i, s q_i, s d_i and s K_i."""
        p = self.platform
        a = [x - y for x, y in zip(p.exits[i], p.exits[0], strict=True)]
        b = [x - y for x, y in zip(p.points[i], p.points[0], strict=True)]
        q = self.turn(b)
        half = (dot(a, a) + dot(b, b) + p.squares[0] - p.squares[i]) * fmpq(1, 2)
        return a, q, [self.s * x - y for x, y in zip(a, q, strict=True)], self.s * half - dot(a, q)

    def lines(self) -> list[tuple[Vector, fmpq_mpoly]]:
        """Return (s d_i, s K_i) of the linear equations of lengths; in a plane y . x = 0 is second."""
        found = [(d, k) for _, _, d, k in self.cables[1 : self.platform.taut]]
        zero = RING.constant(0)
        return [found[0], ([zero, self.s, zero], zero), *found[1:]] if self.platform.planar else found

    def triple(self, x: Vector) -> list[fmpq_mpoly]:
        """Return three polynomials that vanish where the first cables have their lengths."""
        return [dot(x, x) - self.platform.squares[0], *(dot(d, x) - k for d, k in self.lines()[:2])]

    def lengths(self, x: Vector) -> list[fmpq_mpoly]:
        """Return polynomials that vanish where all taut cables have their lengths."""
        first = dot(x, x) - self.platform.squares[0]
        return [first, *(dot(d, x) - k for _, _, d, k in self.cables[1 : self.platform.taut])]

    def excess(self, i: int, x: Vector) -> fmpq_mpoly:
        """Return s (|e_i|^2 - l_i^2) / 2, given that the first length is right."""
        _, _, d, k = self.cables[i]
        return k - dot(d, x)

    def wrenches(self, x: Vector) -> list[Vector]:
        """Return s w_i of the taut cables, and s w_0."""
        p, per = self.platform, 1 / self.platform.unit
        sx = [self.s * v for v in x]
        found = [[-v for v in sx] + [constant(0)] * 3]
        for a, q, d, _ in self.cables[1 : p.taut]:
            moment = cross(q, [(v - w) * per for v, w in zip(a, x, strict=True)])
            found.append([v - w for v, w in zip(d, sx, strict=True)] + moment)
        moment = cross(self.turn(p.points[0]), [-f * per for f in p.load])
        return [*found, [self.s * f for f in p.load] + moment]
