"""The route of a cable over a swivelling pulley, on one joint or on two.

In the plane of the cable, with the origin in A, the first axis u from the swivel axis towards the anchor X
and the second along the direction k in which the rope arrives: the rope starts in C = (0, -lead_in), the
pulley's centre H is an arm h away from A, and the rope runs clockwise over the pulley's outside, from the
tangent point K at the angle theta to T at the angle psi. With q = X - H and rho = |q|,

    sigma = sqrt(rho^2 - r^2),   psi = arg q + acos(r / rho),   n = (cos psi, sin psi),
    a = (sin psi, -cos psi),
    L = |CK| + r (theta - psi) + sigma,   dL/dX = a,   da/dX = n n^T / sigma + (a_u / x) w w^T,

w = k x u being normal to the plane and x the distance of X from the axis (one joint, H = (h, 0)). L is
convex where a_u >= 0: where the rope leaves outward.

Two joints: H = h (sin delta, -cos delta). The length l(delta, X) for an arm held at delta has the slope
dl/ddelta = -h f . (a + c) with f = (cos delta, sin delta) and c the unit vector from K to C. In exact
balance it vanishes: the arm points along the resultant of both legs, L is the least l, and still dL/dX = a.
The bisector of the angle at A is delta = arg(X - A) / 2 instead, measured from C; the direction is then not
quite a gradient.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.cables.path import (
    Floats,
    Numbers,
    Path,
    Triple,
    combined,
    dot,
    minus,
    norm,
    scaled,
)
from cdpr_interval.robots.cable_robot import Cable
from cdpr_interval.robots.numbers import exact, exact_point
from cdpr_interval.robots.pulley import BISECTOR

Flat = tuple[Any, Any]
"""A point or vector in the plane of the cable: along u, along k."""


class _Plane(NamedTuple):
    """The plane of the cable."""

    origin: Triple
    u: Triple
    k: Triple
    x: Any
    """Of the anchor: its distance from the axis."""
    y: Any

    def point(self, p: Flat) -> Triple:
        """Return a point of the plane in the base frame."""
        x, y, z = combined((p[0], self.u), (p[1], self.k))
        return self.origin[0] + x, self.origin[1] + y, self.origin[2] + z


class _Leg(NamedTuple):
    """A straight piece that touches the pulley."""

    free: Any
    normal: Flat
    """From the pulley's centre towards the tangent point, unit."""
    along: Flat
    """Unit vector from the tangent point outward."""
    angle: Any
    """Of the normal, rad."""


@dataclass(frozen=True)
class OverPulley:
    """A cable over a pulley with a radius; base frame, m, exact."""

    point: Vector
    """A."""
    axis: Vector
    """k times any positive number."""
    radius: Fraction
    """Above 0."""
    arm: Fraction
    lead_in: Fraction
    joints: int
    bisector: bool
    fixed_exit = None

    @staticmethod
    def of(cable: Cable, up: Vector | None) -> OverPulley | None:
        """Return the route of a cable over a pulley that has a radius; ``up`` is the default axis."""
        pulley = cable.pulley
        if pulley is None or pulley.is_plain:
            return None
        axis = up if pulley.axis is None else exact_point(pulley.axis)
        assert axis is not None
        return OverPulley(
            exact_point(cable.frame_anchor),
            axis,
            exact(pulley.radius),
            exact(pulley.arm_length),
            exact(pulley.lead_in),
            pulley.joints,
            pulley.balance == BISECTOR,
        )

    def path(self, anchor: Triple, numbers: Numbers) -> Path:
        """Return where the cable runs to an anchor, m.

        Raises
        ------
        OffTheCable
            The anchor may lie inside the pulley or on the swivel axis.
        """
        plane = self._plane(anchor, numbers)
        centre = self._centre(plane, numbers)
        entry, leaving = self._legs(plane, centre, numbers)
        r = numbers.number(self.radius)
        wrap = entry.angle - leaving.angle
        if wrap < 0 and self.radius == self.arm and self.joints == 1:
            # Only by rounding: the rope arrives along the axis, and the anchor is on the pulley's side of it.
            wrap = _none(numbers)
        touching = [
            plane.point((centre[0] + r * leg.normal[0], centre[1] + r * leg.normal[1]))
            for leg in (leaving, entry)
        ]
        return Path(
            entry.free + r * wrap + leaving.free,
            leaving.free,
            entry.free,
            wrap,
            combined((leaving.along[0], plane.u), (leaving.along[1], plane.k)),
            touching[0],
            touching[1],
            plane.point(centre),
        )

    def turning(self, path: Path, anchor: Triple, numbers: Numbers) -> list[list[Any]]:
        """Return the derivative of the direction by the anchor, 1/m."""
        plane = self._plane(anchor, numbers)
        centre = self._centre(plane, numbers)
        entry, leaving = self._legs(plane, centre, numbers)
        slope = self._swing(plane, centre, (entry, leaving), numbers)
        n = combined((leaving.normal[0], plane.u), (leaving.normal[1], plane.k))
        g = combined((slope[0], plane.u), (slope[1], plane.k))
        w = _cross(plane.k, plane.u)
        sideways = leaving.along[0] / plane.x
        return [[n[i] * g[j] + sideways * w[i] * w[j] for j in range(3)] for i in range(3)]

    def _plane(self, anchor: Triple, numbers: Numbers) -> _Plane:
        k = numbers.point(self.axis)
        k = scaled(1 / norm(k, numbers), k)
        origin = numbers.point(self.point)
        g = minus(anchor, origin)
        y = dot(g, k)
        across = minus(g, scaled(y, k))
        x = norm(across, numbers)
        return _Plane(origin, scaled(1 / x, across), k, x, y)

    def _centre(self, plane: _Plane, numbers: Numbers) -> Flat:
        """Return H."""
        h = numbers.number(self.arm)
        if self.joints == 1:
            return h, _none(numbers)
        return self._hung(self._delta(plane, numbers), numbers)

    def _hung(self, delta: Any, numbers: Numbers) -> Flat:
        sine, cosine = numbers.sine_cosine(delta)
        h = numbers.number(self.arm)
        return h * sine, -h * cosine

    def _delta(self, plane: _Plane, numbers: Numbers) -> Any:
        """Return the angle of the arm with two joints, from the direction of C towards the anchor."""
        half = numbers.angle(plane.x, -plane.y) / 2
        if self.bisector:
            return half

        def balance(delta: Any) -> tuple[Any, Any]:
            legs = self._legs(plane, self._hung(delta, numbers), numbers)
            return self._slope(delta, legs, numbers), self._stiffness(delta, legs, numbers)

        start = half if isinstance(numbers, Floats) else self._guess(plane)
        return numbers.zero(balance, float(start))

    def _guess(self, plane: _Plane) -> float:
        """Return the arm's angle in floats."""
        x, y = float(plane.x.mid()), float(plane.y.mid())
        origin = (0.0, 0.0, 0.0)
        return float(self._delta(_Plane(origin, (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), x, y), Floats()))

    def _legs(self, plane: _Plane, centre: Flat, numbers: Numbers) -> tuple[_Leg, _Leg]:
        """Return the leg that arrives and the leg that leaves."""
        start = (_none(numbers), -numbers.number(self.lead_in))
        return (
            self._leg((start[0] - centre[0], start[1] - centre[1]), -1, numbers),
            self._leg((plane.x - centre[0], plane.y - centre[1]), 1, numbers),
        )

    def _leg(self, q: Flat, side: int, numbers: Numbers) -> _Leg:
        """Return the leg to a point at q from the centre; ``side`` 1 for the one that leaves, -1 arrives."""
        r = numbers.number(self.radius)
        square = q[0] * q[0] + q[1] * q[1]
        if self.lead_in == 0 and side == -1 and self.radius == self.arm and self.joints == 1:
            # The rope starts where it touches the pulley.
            free, normal = _none(numbers), (-numbers.number(Fraction(1)), _none(numbers))
        else:
            free = numbers.sqrt(square - r * r)
            normal = (
                (r * q[0] - side * free * q[1]) / square,
                (r * q[1] + side * free * q[0]) / square,
            )
        along = (side * normal[1], -side * normal[0])
        return _Leg(free, normal, along, self._angle(normal, numbers))

    def _angle(self, n: Flat, numbers: Numbers) -> Any:
        """Return the angle of a normal, with the cut where no rope leaves: at -3/4 pi."""
        return numbers.quarter() + numbers.angle(n[1] - n[0], n[1] + n[0])

    def _slope(self, delta: Any, legs: tuple[_Leg, _Leg], numbers: Numbers) -> Any:
        """Return dl/ddelta."""
        sine, cosine = numbers.sine_cosine(delta)
        pull = [legs[0].along[j] + legs[1].along[j] for j in range(2)]
        return -numbers.number(self.arm) * (cosine * pull[0] + sine * pull[1])

    def _stiffness(self, delta: Any, legs: tuple[_Leg, _Leg], numbers: Numbers) -> Any:
        """Return d2l/ddelta2, which is positive."""
        sine, cosine = numbers.sine_cosine(delta)
        h = numbers.number(self.arm)
        pull = [legs[0].along[j] + legs[1].along[j] for j in range(2)]
        total = h * (sine * pull[0] - cosine * pull[1])
        for leg in legs:
            across = h * (cosine * leg.normal[0] + sine * leg.normal[1])
            total += across * across / leg.free
        return total

    def _swing(self, plane: _Plane, centre: Flat, legs: tuple[_Leg, _Leg], numbers: Numbers) -> Flat:
        """Return the gradient of psi in the plane."""
        leaving = legs[1]
        n = leaving.normal
        if self.joints == 1:
            return n[0] / leaving.free, n[1] / leaving.free
        delta = self._delta(plane, numbers)
        sine, cosine = numbers.sine_cosine(delta)
        across = numbers.number(self.arm) * (cosine * n[0] + sine * n[1]) / leaving.free
        if self.bisector:
            square = plane.x * plane.x + plane.y * plane.y
            turn = (-plane.y / (2 * square), plane.x / (2 * square))
        else:
            share = across / self._stiffness(delta, legs, numbers)
            turn = (share * n[0], share * n[1])
        return n[0] / leaving.free - across * turn[0], n[1] / leaving.free - across * turn[1]


def _none(numbers: Numbers) -> Any:
    """Return zero."""
    return numbers.number(Fraction(0))


def _cross(a: Triple, b: Triple) -> Triple:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
