"""A platform in some pose: rotation, spheres and wrenches, in numbers of any kind (balls, forms, jets).

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

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from certificates.arithmetic.rotations import scaled_rotation
from certificates.arithmetic.vectors import cross, dot, minus

Vector = list[Any]


@dataclass(frozen=True)
class Platform:
    """A robot under a load, cables in an order of which the first n are taut."""

    exits: list[Vector]
    """a_i."""
    points: list[Vector]
    """b_i - b_1."""
    halves: Vector
    """h_i = (|a_i|^2 + |b_i - b_1|^2 - l_i^2) / 2; of taut cables for the middle of the range of l_i^2."""
    swings: Vector
    """By how much h_i of the taut cables with a range changes to the end of it; 0 of the others."""
    arm: Vector
    """b_1 from the centre of mass."""
    load: Vector
    per_unit: Any
    """What moments are multiplied by: 1 over a length."""
    taut: int
    planar: bool
    """Everything lies in the plane y = 0."""

    @property
    def square(self) -> Any:
        """l_1^2."""
        return -2 * self.halves[0]

    def length_square(self, i: int) -> Any:
        """Return l_i^2."""
        a, b = self.exits[i], self.points[i]
        return dot(a, a) + dot(b, b) - 2 * self.halves[i]

    def ranging(self, changes: dict[int, Any]) -> Platform:
        """Return the platform with other h_i of some cables: by so much more."""
        return replace(self, halves=[h + changes.get(i, 0) for i, h in enumerate(self.halves)])

    def mapped(self, convert: Callable[[Any], Any]) -> Platform:
        """Return the platform in numbers of another kind."""
        return replace(
            self,
            exits=[[convert(v) for v in a] for a in self.exits],
            points=[[convert(v) for v in b] for b in self.points],
            halves=[convert(v) for v in self.halves],
            arm=[convert(v) for v in self.arm],
            swings=[convert(v) for v in self.swings],
            load=[convert(v) for v in self.load],
            per_unit=convert(self.per_unit),
        )


class Rotated:
    """What depends on the rotation alone; ``u`` are numbers of the platform's kind, or jets of these.

    ``chart`` is one, or an array: of each cell of the forms.
    """

    def __init__(self, platform: Platform, chart: Any, u: Sequence[Any]) -> None:
        self.platform = platform
        self.s, self.rotation = scaled_rotation(chart, u)
        self.found: dict[int, tuple[Vector, Vector, Any]] = {}

    def turn(self, b: Vector) -> Vector:
        """Return s R b."""
        return [dot(row, b) for row in self.rotation]

    def cable(self, i: int) -> tuple[Vector, Vector, Any]:
        """Return s q_i, s d_i and s a_i . q_i."""
        if i not in self.found:
            a, q = self.platform.exits[i], self.turn(self.platform.points[i])
            self.found[i] = q, [self.s * v - w for v, w in zip(a, q, strict=True)], dot(a, q)
        return self.found[i]

    def line(self, i: int) -> tuple[Vector, Any]:
        """Return s d_i and s K_i."""
        _, d, inner = self.cable(i)
        return d, self.s * (self.platform.halves[i] - self.platform.halves[0]) - inner

    @cached_property
    def lines(self) -> list[tuple[Vector, Any]]:
        """The (s d_i, s K_i) of the taut cables but the first."""
        return [self.line(i) for i in range(1, self.platform.taut)]

    @cached_property
    def pair(self) -> list[tuple[Vector, Any]]:
        """Two of them, which leave two positions; in a plane y . x = 0 is the second."""
        zero = 0 * self.s
        return [self.lines[0], ([zero, self.s, zero], zero)] if self.platform.planar else self.lines[:2]

    def lengths(self, x: Vector, lines: Sequence[tuple[Vector, Any]]) -> Vector:
        """Return numbers that are 0 where the first cable and others have their lengths."""
        return [dot(x, x) - self.platform.square, *(dot(d, x) - k for d, k in lines)]

    def equations(self, x: Vector, on_branch: bool) -> Vector:
        """Return numbers that are 0 at all poses.

        On a branch the second and third length only say again how the position follows u.
        """
        return self.lengths(x, self.lines[2 if on_branch else 0 :])

    def spheres(self, x: Vector) -> Vector:
        """Return |x|^2 - l_1^2 and s (|e_i|^2 - l_i^2) of the other taut cables: one length in each."""
        square, halves = dot(x, x), self.platform.halves
        found = [square + 2 * halves[0]]
        for i in range(1, self.platform.taut):
            _, d, inner = self.cable(i)
            found.append(self.s * (square + 2 * halves[i]) - 2 * (inner + dot(d, x)))
        return found

    def excess(self, i: int, x: Vector) -> Any:
        """Return s (|e_i|^2 - l_i^2) / 2, given that the first length is right."""
        d, k = self.line(i)
        return k - dot(d, x)

    def wrenches(self, x: Vector) -> list[Vector]:
        """Return s w_i of the taut cables, and s w_0."""
        p = self.platform
        sx = [self.s * v for v in x]
        found = [[-v for v in sx] + [0 * self.s] * 3]
        scaled = [v * p.per_unit for v in x]
        for i in range(1, p.taut):
            q, d, _ = self.cable(i)
            reach = [v * p.per_unit - w for v, w in zip(p.exits[i], scaled, strict=True)]
            found.append(minus(d, sx) + cross(q, reach))
        moment = cross([f * p.per_unit for f in p.load], self.turn(p.arm))
        return [*found, [self.s * f for f in p.load] + moment]
