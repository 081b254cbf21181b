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
balance it vanishes with f' . (a + c) > 0, f' along the arm: the arm points along the resultant of both legs,
L is the least l, and still dL/dX = a. The bisector of the angle at A is delta = arg(X - A) / 2 instead,
measured from C; the direction is then not quite a gradient.

Where the wrap would be negative the rope does not touch the pulley and runs straight from C to X. In
exact balance that is so where no arm is in balance, and one can hang beside that line, which then passes A
at no more than h - r: lead_in x <= (h - r) |X - C|. Where X, beyond A, is 2 (h + r) or
farther from it, and C 3 (h + r), the one is so if and only if the other is: delta -> the direction of a + c,
of -a - c where the wrap is negative, is a contraction there, and the wrap at its only fixed point vanishes
where the line passes A at h - r.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.cables.path import (
    Floats,
    Numbers,
    OffTheCable,
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
ROUNDING = 1e-6
"""Rad: how far from zero rounding can bring an angle of wrap in floats, at the pulley itself."""
ROOM, LEAD_ROOM = 2, 3
"""Least distances of X and C from A, over arm and radius, at which two joints have one balance."""
GRID = 64
"""Angles of an arm that are tried where Newton's method from the bisector does not find its balance."""


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


class _Held(NamedTuple):
    """A rope that touches the pulley."""

    delta: Any
    """Of the arm, rad; None with one joint."""
    centre: Flat
    legs: tuple[_Leg, _Leg]
    """The one that arrives and the one that leaves."""
    wrap: Any


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
        held = self._held(plane, numbers)
        if held is None:
            return self._past(plane, numbers)
        _, centre, (entry, leaving), wrap = held
        r = numbers.number(self.radius)
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
        held = self._held(plane, numbers)
        if held is None:
            a = self._straight(plane, numbers).along
            normal: Flat = (-a[1], a[0])
            slope = (normal[0] / path.free, normal[1] / path.free)
            outward = a[0]
        else:
            normal, outward = held.legs[1].normal, held.legs[1].along[0]
            slope = self._swing(plane, held, numbers)
        n = combined((normal[0], plane.u), (normal[1], plane.k))
        g = combined((slope[0], plane.u), (slope[1], plane.k))
        w = _cross(plane.k, plane.u)
        sideways = outward / plane.x
        return [[n[i] * g[j] + sideways * w[i] * w[j] for j in range(3)] for i in range(3)]

    def _held(self, plane: _Plane, numbers: Numbers) -> _Held | None:
        """Return how the pulley holds the rope; None where the rope runs past it."""
        delta = None if self.joints == 1 else self._delta(plane, numbers)
        if self.joints == 2 and delta is None:
            return None
        centre = (numbers.number(self.arm), _none(numbers)) if delta is None else self._hung(delta, numbers)
        legs = self._legs(plane, centre, numbers)
        wrap = legs[0].angle - legs[1].angle
        if self.radius == self.arm and self.joints == 1:
            # The rope arrives along the axis, and the anchor is on the pulley's side of it: less than zero
            # is rounding, or the anchor lies where the rope would run around the whole pulley.
            if wrap < (-ROUNDING if isinstance(numbers, Floats) else 0):
                raise OffTheCable
            return _Held(delta, centre, legs, _none(numbers) if wrap < 0 else wrap)
        if wrap < 0:
            return None
        if not wrap >= 0:
            raise OffTheCable
        return _Held(delta, centre, legs, wrap)

    def _straight(self, plane: _Plane, numbers: Numbers) -> _Leg:
        """Return the straight line from C."""
        rise = plane.y + numbers.number(self.lead_in)
        free = numbers.sqrt(plane.x * plane.x + rise * rise)
        along = (plane.x / free, rise / free)
        return _Leg(free, (-along[1], along[0]), along, _none(numbers))

    def _past(self, plane: _Plane, numbers: Numbers) -> Path:
        """Return the path of a rope that does not touch the pulley."""
        line, none, h = self._straight(plane, numbers), _none(numbers), numbers.number(self.arm)
        start = plane.point((none, -numbers.number(self.lead_in)))
        aside = (h, none)
        if self.joints == 2:
            # Any place beside the rope will do in exact balance.
            half = numbers.angle(plane.x, -plane.y) / 2
            aside = self._hung(half, numbers) if self.bisector else (h * line.along[1], -h * line.along[0])
        direction = combined((line.along[0], plane.u), (line.along[1], plane.k))
        return Path(line.free, line.free, none, none, direction, start, start, plane.point(aside), True)

    def _plane(self, anchor: Triple, numbers: Numbers) -> _Plane:
        k = numbers.point(self.axis)
        k = scaled(1 / norm(k, numbers), k)
        origin = numbers.point(self.point)
        g = minus(anchor, origin)
        y = dot(g, k)
        across = minus(g, scaled(y, k))
        x = norm(across, numbers)
        return _Plane(origin, scaled(1 / x, across), k, x, y)

    def _hung(self, delta: Any, numbers: Numbers) -> Flat:
        sine, cosine = numbers.sine_cosine(delta)
        h = numbers.number(self.arm)
        return h * sine, -h * cosine

    def _delta(self, plane: _Plane, numbers: Numbers) -> Any:
        """Return the angle of the arm with two joints, from C to the anchor; None: the rope runs past."""
        if self.bisector:
            return numbers.angle(plane.x, -plane.y) / 2
        if isinstance(numbers, Floats):
            found = self._balanced(plane)
            if found is None and not self._room(plane):
                raise OffTheCable
            return found
        if self._runs_past(plane, numbers):
            return None
        x, y = float(plane.x.mid()), float(plane.y.mid())
        guess = self._balanced(_Plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), x, y))
        if guess is None:
            # That there is no balance is not proved here.
            raise OffTheCable
        delta = numbers.zero(lambda angle: self._forces(angle, plane, numbers)[:2], guess)
        if not self._forces(delta, plane, numbers)[2] > 0:
            raise OffTheCable
        return delta

    def _runs_past(self, plane: _Plane, numbers: Numbers) -> bool:
        """Return True where it is proved that no arm on two joints is in balance."""
        far, lead_in = self.arm + self.radius, numbers.number(self.lead_in)
        if not (self.arm > self.radius and self.lead_in > LEAD_ROOM * far and plane.y > 0):
            return False
        near = ROOM * far
        if not plane.x * plane.x + plane.y * plane.y > numbers.number(near * near):
            return False
        reach = numbers.number(self.arm - self.radius) * self._straight(plane, numbers).free
        return bool(lead_in * plane.x < reach)

    def arriving(self, numbers: Numbers) -> Any:
        """Return how much of a rope, m, arrives at the pulley where it lifts off."""
        if self.joints == 2:
            return numbers.sqrt(numbers.number(self.lead_in**2 - (self.arm - self.radius) ** 2))
        return numbers.sqrt(numbers.number(self.lead_in**2 + self.arm**2 - self.radius**2))

    def _room(self, plane: _Plane) -> bool:
        """Return True where the arm can hang beside the straight line from C, in floats."""
        free = self._straight(plane, Floats()).free
        return bool(float(self.arm - self.radius) * free >= float(self.lead_in) * plane.x)

    def _balanced(self, plane: _Plane) -> float | None:
        """Return the arm's angle in balance in floats; None where none is found."""
        numbers = Floats()
        across = self._straight(plane, numbers).along
        # The bisector is near the balance of a short arm; the arm of a rope that hardly touches points across
        # the line from C. Near the pulley those may be far from the balance: then the best of a grid.
        for start in (numbers.angle(plane.x, -plane.y) / 2, numbers.angle(across[1], across[0])):
            if (found := self._newton(start, plane)) is not None:
                return found
        lengths = []
        for i in range(GRID):
            delta = math.pi * (2 * i / GRID - 0.5)
            try:
                legs = self._legs(plane, self._hung(delta, numbers), numbers)
                pull = self._forces(delta, plane, numbers)[2]
            except OffTheCable:
                continue
            wrap = legs[0].angle - legs[1].angle
            if pull > 0 and wrap > 0:
                lengths.append((legs[0].free + float(self.radius) * wrap + legs[1].free, delta))
        return self._newton(min(lengths)[1], plane) if lengths else None

    def _newton(self, start: float, plane: _Plane) -> float | None:
        """Return the arm's angle in balance near a start in floats, or None."""
        try:
            delta = Floats().zero(lambda angle: self._forces(angle, plane, Floats())[:2], start)
            slope, stiffness, pull = self._forces(delta, plane, Floats())
            legs = self._legs(plane, self._hung(delta, Floats()), Floats())
        except (OffTheCable, ZeroDivisionError, OverflowError, ValueError):
            return None
        # A straight rope that just touches is in balance too, without a pull.
        touches = pull > (ROUNDING if self._room(plane) else 0) and legs[0].angle > legs[1].angle
        still = abs(slope) <= 1e-9 * stiffness + 1e-15 * float(self.arm)
        return delta if touches and still and abs(delta) < math.pi else None

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
        """Return the angle of a normal, with the cut where no rope leaves.

        That is at -3/4 pi for a pulley to the right of the axis, at -pi / 2 for one that hangs.
        """
        if self.joints == 2:
            return 2 * numbers.quarter() + numbers.angle(-n[0], n[1])
        return numbers.quarter() + numbers.angle(n[1] - n[0], n[1] + n[0])

    def _forces(self, delta: Any, plane: _Plane, numbers: Numbers) -> tuple[Any, Any, Any]:
        """Return dl/ddelta, d2l/ddelta2 (positive in balance) and the pull of the rope along the arm."""
        legs = self._legs(plane, self._hung(delta, numbers), numbers)
        sine, cosine = numbers.sine_cosine(delta)
        h = numbers.number(self.arm)
        pull = [legs[0].along[j] + legs[1].along[j] for j in range(2)]
        along = sine * pull[0] - cosine * pull[1]
        stiffness = h * along
        for leg in legs:
            across = h * (cosine * leg.normal[0] + sine * leg.normal[1])
            stiffness += across * across / leg.free
        return -h * (cosine * pull[0] + sine * pull[1]), stiffness, along

    def _swing(self, plane: _Plane, held: _Held, numbers: Numbers) -> Flat:
        """Return the gradient of psi in the plane."""
        leaving = held.legs[1]
        n = leaving.normal
        if held.delta is None:
            return n[0] / leaving.free, n[1] / leaving.free
        sine, cosine = numbers.sine_cosine(held.delta)
        across = numbers.number(self.arm) * (cosine * n[0] + sine * n[1]) / leaving.free
        if self.bisector:
            square = plane.x * plane.x + plane.y * plane.y
            turn = (-plane.y / (2 * square), plane.x / (2 * square))
        else:
            share = across / self._forces(held.delta, plane, numbers)[1]
            turn = (share * n[0], share * n[1])
        return n[0] / leaving.free - across * turn[0], n[1] / leaving.free - across * turn[1]


def _none(numbers: Numbers) -> Any:
    """Return zero."""
    return numbers.number(Fraction(0))


def _cross(a: Triple, b: Triple) -> Triple:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
