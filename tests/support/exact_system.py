"""The square system of a planted platform in exact numbers, with exact derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from tests.support.planted_platform import HALF_TURN_SIGNS, Planted


class Dual:
    """An exact number with its exact derivative: forward differentiation without a formula to get wrong."""

    def __init__(self, value: Fraction | int, slope: Fraction | int = 0) -> None:
        self.value, self.slope = Fraction(value), Fraction(slope)

    def __add__(self, other: Dual) -> Dual:
        return Dual(self.value + other.value, self.slope + other.slope)

    def __sub__(self, other: Dual) -> Dual:
        return Dual(self.value - other.value, self.slope - other.slope)

    def __mul__(self, other: Dual) -> Dual:
        return Dual(self.value * other.value, self.value * other.slope + self.slope * other.value)

    def __truediv__(self, other: Dual) -> Dual:
        quotient = self.value / other.value
        return Dual(quotient, (self.slope - quotient * other.slope) / other.value)


def dual_vector(v: Sequence[Fraction | int]) -> list[Dual]:
    return [Dual(x) for x in v]


def total(values: Sequence[Dual]) -> Dual:
    result = Dual(0)
    for value in values:
        result = result + value
    return result


def dual_cross(a: Sequence[Dual], b: Sequence[Dual]) -> list[Dual]:
    return [a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3] for k in range(3)]


def rotated(u: Sequence[Dual], v: Sequence[Dual]) -> list[Dual]:
    """Return q v q* / |q|^2 for q = (1, u): v + 2 (u x v + u x (u x v)) / (1 + |u|^2)."""
    first = dual_cross(u, v)
    second = dual_cross(u, first)
    scale = Dual(2) / (Dual(1) + total([x * x for x in u]))
    return [a + scale * (b + c) for a, b, c in zip(v, first, second, strict=True)]


def equations(robot: Planted, chart: int, z: Sequence[Dual]) -> list[Dual]:
    """Return lengths, forces and moments (arm x spoke) at z = (u, p, t)."""
    u, p, t = z[:3], z[3:6], z[6:]
    lengths: list[Dual] = []
    force = dual_vector(robot.load)
    moment = dual_vector([0, 0, 0])
    for i in range(robot.n):
        b = [x * s for x, s in zip(robot.points[i], HALF_TURN_SIGNS[chart], strict=True)]
        r = rotated(u, dual_vector(b))
        e = [a - x - y for a, x, y in zip(dual_vector(robot.anchors[i]), p, r, strict=True)]
        lengths.append(total([x * x for x in e]) - Dual(robot.lengths_sq[i]))
        force = [f + t[i] * x for f, x in zip(force, e, strict=True)]
        moment = [m + t[i] * x for m, x in zip(moment, dual_cross(r, e), strict=True)]
    return [*lengths, *force, *moment]
