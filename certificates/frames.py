"""The frames in which a subset of taut cables is searched.

A frame's axes are rational vectors over their lengths; 1 over a length that is irrational is a middle plus
a radius times a symbol of its own, so that coordinates stay exact polynomials.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from flint import arb, arb_mat, fmpq, fmpz

from certificates.geometry import Platform
from certificates.polynomials import DATA, Vector, between, constant
from certificates.subsets import Exact, Kind, cross, dot, minus

if TYPE_CHECKING:
    from certificates.problem import Problem

UNIT = [[fmpq(int(i == j)) for j in range(3)] for i in range(3)]
FINE = fmpz(2) ** 100
"""Irrational inverses are enclosed to 1 / FINE of their size."""


class Axis:
    """The direction of a rational vector, and the same with polynomials for coordinates."""

    def __init__(self, along: Exact, symbol: int) -> None:
        self.along = along
        square = dot(along, along)
        # 1 / sqrt(p / q) = sqrt(q / p): integer roots of q / p times FINE^2, from below and above.
        root = fmpz(square.q * FINE * FINE // square.p).isqrt()
        exact = fmpq(root, FINE) ** 2 * square == 1
        self.inverse = (
            constant(fmpq(root, FINE)) if exact else between(fmpq(root, FINE), fmpq(root + 1, FINE), symbol)
        )

    def unit(self) -> list[arb]:
        """Return the unit vector in balls."""
        norm = arb(dot(self.along, self.along)).sqrt()
        return [arb(v) / norm for v in self.along]


@dataclass(frozen=True)
class Frame:
    """Three axes at right angles: two rational ones and their product, right-handed.

    ``given`` : two of x, y, z with their axes.
    """

    given: dict[int, Axis]

    @cached_property
    def third(self) -> int:
        """The axis that completes the others."""
        return 3 - sum(self.given)

    def ordered(self) -> tuple[Axis, Axis]:
        """Return the axes whose product is the third one."""
        return self.given[(self.third + 1) % 3], self.given[(self.third + 2) % 3]

    def coordinates(self, v: Exact) -> Vector:
        """Return the coordinates of a rational vector as polynomials."""
        found = [constant(0)] * 3
        for k, axis in self.given.items():
            found[k] = axis.inverse * dot(axis.along, v)
        a, b = self.ordered()
        found[self.third] = a.inverse * b.inverse * dot(cross(a.along, b.along), v)
        return found

    def rows(self) -> arb_mat:
        """Return the rotation to this frame."""
        found: list[list[arb]] = [[arb(0)] * 3] * 3
        for k, axis in self.given.items():
            found[k] = axis.unit()
        (ax, ay, az), (bx, by, bz) = (axis.unit() for axis in self.ordered())
        found[self.third] = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
        return arb_mat(found)


def across(v: Exact) -> Exact:
    """Return a rational vector at right angles to one that is not zero."""
    most = max(range(3), key=lambda k: abs(v[k]))
    return cross(v, UNIT[(most + 1) % 3])


@dataclass(frozen=True)
class Setting:
    """One search: the frames of base and platform, and what the subset's symmetry takes out."""

    taut: tuple[int, ...]
    base: Frame
    platform: Frame
    planar: bool
    """All happens in the plane y = 0 of both frames."""
    vertical: bool
    """The pose may be turned about the base's z axis."""
    rod: bool
    """The platform may be turned about its z axis (its x axis where planar)."""

    @property
    def family(self) -> bool:
        """Poses come in families."""
        return self.vertical or self.rod

    def frozen(self, chart: int) -> tuple[int, ...] | None:
        """Return the entries of u that are 0 in a chart, or None where the chart is not needed.

        Turning about y alone: quaternions (w, 0, y, 0). A turn about z before or after makes a quaternion's z
        entry 0. D_c moves the entries: u = (x, y, z) / w, (w, z, y) / x, (z, w, x) / y up to signs.
        """
        if self.planar:
            return (0, 2) if chart in (0, 2) else None
        if self.family:
            return (2, 1, 0)[chart : chart + 1] if chart < 3 else None
        return ()

    def cables(self, problem: Problem, order: tuple[int, ...]) -> Platform:
        """Return the platform with the taut cables in an order, then the others."""
        everyone = [*order, *(i for i in range(len(problem.names)) if i not in order)]
        squares = []
        for k, i in enumerate(everyone):
            lo, hi = (v * v for v in problem.lengths[i])
            squares.append(between(lo, hi, DATA + 4 + k) if k < len(order) and lo != hi else constant(hi))
        widest = max(sum((abs(v) for v in problem.points[i]), fmpq(0)) for i in order)
        return Platform(
            exits=[self.base.coordinates(minus(problem.exits[i], problem.exits[order[0]])) for i in everyone],
            points=[self.platform.coordinates(problem.points[i]) for i in everyone],
            squares=squares,
            load=self.base.coordinates(problem.load),
            taut=len(order),
            unit=widest,
            planar=self.planar,
        )


def settings(problem: Problem, taut: tuple[int, ...], kind: Kind) -> list[Setting]:
    """Return the searches that together find all poses of a subset, or one pose of each family."""
    exits, points = [problem.exits[i] for i in taut], [problem.points[i] for i in taut]
    vertical, rod = kind in (Kind.VERTICAL, Kind.BOTH), kind in (Kind.ROD, Kind.BOTH)
    planar = len(taut) == 2 or kind is Kind.BOTH
    plain = Frame({0: Axis(UNIT[0], DATA), 2: Axis(UNIT[2], DATA + 1)})
    base = platform = plain
    if planar or vertical:
        up = [-v for v in problem.load]
        step = cross(up, cross(minus(exits[-1], exits[0]), up))
        base = Frame({0: Axis(step if any(step) else across(up), DATA), 2: Axis(up, DATA + 1)})
    first = next((b for b in points if any(b)), UNIT[0])
    if rod:
        names = (0, 2) if planar else (2, 0)
        platform = Frame({names[0]: Axis(first, DATA + 2), names[1]: Axis(across(first), DATA + 3)})
    elif planar:
        third = cross(first, cross(points[0], points[1]))
        frames = [
            Frame({0: Axis(first, DATA + 2), 2: Axis(v, DATA + 3)}) for v in (third, [-x for x in third])
        ]
        return [Setting(taut, base, frame, True, vertical, False) for frame in frames[: 1 if vertical else 2]]
    return [Setting(taut, base, platform, planar, vertical, rod)]
