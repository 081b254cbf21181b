"""The way of a cable from its winch to a point of the platform, in whatever numbers are computed with.

A cable is its length as a function of the platform point X. Where it balances itself - straight, over a
pulley on one joint, or on two with the arm along the resultant - the gradient of that length is the unit
vector along the last straight piece, and the wrench of the cable is its tension times minus that gradient.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any, NamedTuple, Protocol

from flint import arb

from cdpr_interval.exact import balls
from cdpr_interval.exact.vector import Vector

Triple = tuple[Any, Any, Any]
"""A point or vector in the numbers in hand."""


class Path(NamedTuple):
    """Where a cable runs; base frame, m."""

    length: Any
    """From the start of the cable to the anchor: lead-in, wrap and free part."""
    free: Any
    """sigma: the last straight piece."""
    before: Any
    """The straight piece that arrives at the pulley."""
    wrap: Any
    """Angle on the pulley, rad."""
    direction: Triple
    """Unit vector along the free part, towards the anchor."""
    exit: Triple
    """Where the free part begins: the tangent point T."""
    entry: Triple
    """Where the rope meets the pulley."""
    centre: Triple
    """Of the pulley."""
    is_past: bool = False
    """The rope does not touch its pulley: all of it is the last straight piece."""


class OffTheCable(ValueError):
    """There is no path to a point: it lies inside the pulley, on the swivel axis, or in the exit point.

    Also where none is known: the arm finds no balance, or balls do not tell if the rope touches the pulley.
    """


class Numbers(Protocol):
    """The numbers a path is computed in."""

    def number(self, x: Fraction) -> Any:
        """Return an exact rational as one of them."""

    def point(self, p: Vector) -> Triple:
        """Return an exact point."""

    def sqrt(self, x: Any) -> Any:
        """Return a square root; `OffTheCable` where x may not be positive."""

    def angle(self, y: Any, x: Any) -> Any:
        """Return the angle of (x, y) in rad, between -pi and pi."""

    def sine_cosine(self, x: Any) -> tuple[Any, Any]:
        """Return sin x and cos x."""

    def quarter(self) -> Any:
        """Return pi / 4."""

    def zero(self, function: Callable[[Any], tuple[Any, Any]], start: float) -> Any:
        """Return the zero near ``start`` of a function that returns value and derivative."""


class Floats:
    """Plain floats; nothing is certified."""

    STEPS = 50
    """Newton steps at most; each is quadratic, five are usual."""

    def number(self, x: Fraction) -> float:
        """Return the nearest double."""
        return float(x)

    def point(self, p: Vector) -> Triple:
        """Return the nearest doubles."""
        return float(p[0]), float(p[1]), float(p[2])

    def sqrt(self, x: float) -> float:
        """Return a square root; `OffTheCable` where x is not positive."""
        if not x > 0.0:
            raise OffTheCable
        return math.sqrt(x)

    def angle(self, y: float, x: float) -> float:
        """Return atan2(y, x)."""
        return math.atan2(y, x)

    def sine_cosine(self, x: float) -> tuple[float, float]:
        """Return sin x and cos x."""
        return math.sin(x), math.cos(x)

    def quarter(self) -> float:
        """Return pi / 4."""
        return math.pi / 4

    def zero(self, function: Callable[[float], tuple[float, float]], start: float) -> float:
        """Return the zero by Newton's method."""
        x = start
        for _ in range(self.STEPS):
            value, slope = function(x)
            step = value / slope
            x -= step
            if abs(step) <= 1e-16 * abs(x):
                break
        return x


class Balls:
    """Real balls, which enclose; work under `cdpr_interval.exact.balls.precision`."""

    REACHES = (1e-6, 1e-4, 1e-2)
    """Radii of the balls in which a zero is looked for."""
    STEPS = 8
    """Newton steps; each doubles the digits."""

    def number(self, x: Fraction) -> arb:
        """Enclose a rational."""
        return balls.from_fraction(x)

    def point(self, p: Vector) -> Triple:
        """Enclose a point."""
        return balls.from_fraction(p[0]), balls.from_fraction(p[1]), balls.from_fraction(p[2])

    def sqrt(self, x: arb) -> arb:
        """Enclose a square root; `OffTheCable` where x may not be positive."""
        if not x > 0:
            raise OffTheCable
        return x.sqrt()

    def angle(self, y: arb, x: arb) -> arb:
        """Enclose atan2(y, x)."""
        return arb.atan2(y, x)

    def sine_cosine(self, x: arb) -> tuple[arb, arb]:
        """Enclose sin x and cos x."""
        return x.sin(), x.cos()

    def quarter(self) -> arb:
        """Enclose pi / 4."""
        return arb.pi() / 4

    def zero(self, function: Callable[[arb], tuple[arb, arb]], start: float) -> arb:
        """Enclose the only zero of a function near ``start`` by interval Newton steps.

        Raises
        ------
        OffTheCable
            None is proved there.
        """
        for reach in self.REACHES:
            found = self._zero(function, arb(start, reach))
            if found is not None:
                return found
        raise OffTheCable

    def _zero(self, function: Callable[[arb], tuple[arb, arb]], within: arb) -> arb | None:
        """Enclose the only zero in a ball; None where none is proved."""
        proved = False
        for _ in range(self.STEPS):
            middle = arb(within.mid())
            value, _ = function(middle)
            _, slope = function(within)
            if slope.contains(0) or not slope.is_finite():
                return None
            image = middle - value / slope
            proved = proved or within.contains_interior(image)
            if not within.overlaps(image):
                return None
            within = within.intersection(image)
        return within if proved else None


def minus(a: Sequence[Any], b: Sequence[Any]) -> Triple:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scaled(factor: Any, a: Sequence[Any]) -> Triple:
    """Return factor a."""
    return factor * a[0], factor * a[1], factor * a[2]


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def norm(a: Sequence[Any], numbers: Numbers) -> Any:
    """Return |a|; `OffTheCable` where it may be zero."""
    return numbers.sqrt(dot(a, a))


def combined(*terms: tuple[Any, Sequence[Any]]) -> Triple:
    """Return the sum of factors times vectors."""
    x, y, z = (sum((f * v[j] for f, v in terms[1:]), terms[0][0] * terms[0][1][j]) for j in range(3))
    return x, y, z
