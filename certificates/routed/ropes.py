"""A platform on cables that run over pulleys, in numbers of any kind (balls, forms, jets).

A rope arrives at A along the unit vector k, over a length ``before``, and runs over a pulley of radius r that
turns about the line through A along k; its centre H is r away from A. In the plane of the rope an anchor X is
at A + x u + y k, x > 0. With q = X - H, rho^2 = |q|^2 and sigma^2 = rho^2 - r^2

    n = (r q_u - sigma q_k, r q_k + sigma q_u) / rho^2 = (cos psi, sin psi)

points from H to T, where the rope leaves; sigma is its free length, L = before + r (pi - psi) + sigma the
length of its path, and dL/dX = (n_k, -n_u), the direction from T to X. Without a pulley T = A.

The pull on the platform is t e, e = T - X, t >= 0. A taut rope has L = l. X = p + R b, p the centre of
mass, and the balance is

    sum t_i w_i + w_0 = 0,    w_i = (e_i, R b_i x e_i / unit),    w_0 = (f, 0).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

from certificates.arithmetic.rotations import scaled_rotation
from certificates.arithmetic.series import angle, inverse_root
from certificates.arithmetic.vectors import cross, dot

Vector = list[Any]


@dataclass(frozen=True)
class Ropes:
    """A robot under a load, cables in an order of which the first ``taut`` are taut."""

    exits: list[Vector]
    """A."""
    points: list[Vector]
    """b, from the centre of mass."""
    lengths: Vector
    axes: list[Vector]
    """k; empty for a straight cable."""
    radii: Vector
    """r."""
    before: Vector
    shells: Vector
    """|X - A|^2 of a taut cable, whatever its pulley does."""
    load: Vector
    per_unit: Any
    half_turn: Any
    """pi."""
    taut: int

    @property
    def swings(self) -> list[int]:
        """Lengths have no ranges."""
        return [0] * self.taut

    def ranging(self, changes: dict[int, Any]) -> Ropes:
        """Return itself: there is nothing to be changed."""
        return self

    def mapped(self, convert: Callable[[Any], Any]) -> Ropes:
        """Return the robot in numbers of another kind."""

        def changed(value: Any) -> Any:
            return [changed(v) for v in value] if isinstance(value, list) else convert(value)

        names = [f.name for f in fields(self) if f.name != "taut"]
        return replace(self, **{name: changed(getattr(self, name)) for name in names})


class Rope:
    """A cable from where it leaves its pulley to an anchor."""

    def __init__(self, pull: Vector, square: Any, wrapped: Any, free: Any = None) -> None:
        self.pull, self.square, self.wrapped = pull, square, wrapped
        """e, sigma^2, L - sigma."""
        if free is not None:
            self.free = free

    @cached_property
    def free(self) -> Any:
        """Sigma."""
        return self.square * inverse_root(self.square)

    @property
    def length(self) -> Any:
        """L."""
        return self.wrapped + self.free


class Posed:
    """The robot in poses of one rotation, or of one in each cell, and of one position."""

    def __init__(self, ropes: Ropes, chart: Any, u: Sequence[Any]) -> None:
        self.ropes = ropes
        self.s, self.rotation = scaled_rotation(chart, u)
        root = inverse_root(self.s)
        matrix = [[v * (root * root) for v in row] for row in self.rotation]
        self.arms = [[dot(row, b) for row in matrix] for b in ropes.points]
        """R b."""
        self.seen: dict[int, Rope] = {}

    def way(self, i: int, p: Vector) -> Vector:
        """Return X - A."""
        return [a + b - c for a, b, c in zip(p, self.arms[i], self.ropes.exits[i], strict=True)]

    def rope(self, i: int, p: Vector) -> Rope:
        """Return a cable's way to its anchor; ``p`` is the same in all calls."""
        if i not in self.seen:
            g, ropes = self.way(i, p), self.ropes
            if ropes.axes[i]:
                rope = over_pulley(g, ropes.axes[i], ropes.radii[i], ropes.half_turn)
            else:
                rope = Rope([-v for v in g], dot(g, g), 0 * self.s)
            rope.wrapped = rope.wrapped + ropes.before[i]
            self.seen[i] = rope
        return self.seen[i]

    def wrench(self, i: int, pull: Vector) -> Vector:
        """Return w_i."""
        return [*pull, *(v * self.ropes.per_unit for v in cross(self.arms[i], pull))]

    def wrenches(self, p: Vector) -> list[Vector]:
        """Return the w_i of the taut cables, and w_0."""
        zero = 0 * self.s
        load = [*(f + zero for f in self.ropes.load), zero, zero, zero]
        return [*(self.wrench(i, self.rope(i, p).pull) for i in range(self.ropes.taut)), load]


def over_pulley(g: Vector, k: Vector, r: Any, pi: Any) -> Rope:
    """Return the rope from a pulley to an anchor at ``g`` from A."""
    y = dot(g, k)
    across = [a - y * b for a, b in zip(g, k, strict=True)]
    x_square = dot(across, across)
    root = inverse_root(x_square)
    x, u = x_square * root, [v * root for v in across]
    square = x_square + y * y - 2 * r * x
    free, inverse = square * inverse_root(square), inverse_root(square + r * r)
    inverse = inverse * inverse
    n, m = (r * (x - r) - free * y) * inverse, (r * y + free * (x - r)) * inverse
    pull = [free * (n * c - m * v) for v, c in zip(u, k, strict=True)]
    return Rope(pull, square, r * (pi - angle(n, m)), free)
