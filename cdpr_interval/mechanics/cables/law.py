"""What a cable model must say, and which model a cable of a robot has.

A model is a pair. Its **route** says where the cable runs to a point of the platform and how long it is on
the way; its **law** says how much longer it gets under a tension. Both are written once, in plain
arithmetic that takes floats, rationals, exact ranges and balls alike: numbers of the robot's data enter
through ``number``, which makes an exact rational one of the kind in hand. Compiled kernels have their own
copy in `cdpr_interval.mechanics.cables.compiled`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple, Protocol

from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.cables.path import Numbers, Path, Triple
from cdpr_interval.mechanics.cables.pulley import OverPulley
from cdpr_interval.mechanics.cables.spring import AxialSpring, Inextensible, Spring
from cdpr_interval.mechanics.cables.straight import FixedExit
from cdpr_interval.robots.cable_robot import Cable
from cdpr_interval.robots.numbers import Point, exact_point

Number = Callable[[Fraction], Any]
"""Makes an exact rational a number of the kind that is computed with (``float``, `Range.exact`, a ball)."""


class Route(Protocol):
    """Where a cable runs."""

    @property
    def fixed_exit(self) -> Vector | None:
        """The point (base frame, m) from which all of the cable runs straight; None without one."""

    def path(self, anchor: Triple, numbers: Numbers) -> Path:
        """Return where the cable runs to an anchor (base frame, m); `OffTheCable` where it cannot."""

    def turning(self, path: Path, anchor: Triple, numbers: Numbers) -> list[list[Any]]:
        """Return the derivative (3, 3) of the direction of a path by its anchor, 1/m."""


class Law(Protocol):
    """How far the free part of a cable reaches under a tension (N >= 0)."""

    @property
    def stretches(self) -> bool:
        """True when the reach depends on the tension."""

    def stretch(self, length: Any, tension: Any, number: Number) -> Any:
        """Return by how much a cable of an unstretched length (m) is longer under a tension, m."""

    def unstretched(self, distance: Any, tension: Any, number: Number) -> Any:
        """Return the unstretched length at which a cable has a tension over a distance (m), m."""

    def spring_constant(self, length: Fraction) -> Fraction | None:
        """Return k in N/m of a cable of an unstretched length (m); None where it does not stretch."""


class CableModel(NamedTuple):
    """The route and the law of one cable."""

    route: Route
    law: Law


LAWS: tuple[Callable[[Cable], Law | None], ...] = (Spring.of, AxialSpring.of, Inextensible.of)
"""Laws by what makes one of a cable's data, or None where the cable is not of that law; the first counts."""
ROUTES: tuple[Callable[[Cable, Vector | None], Route | None], ...] = (FixedExit.of, OverPulley.of)
"""Routes likewise; what makes one also takes the direction up, the default of swivel axes."""


def law_of(cable: Cable) -> Law:
    """Return the law of a cable of a robot."""
    return next(law for law in (of(cable) for of in LAWS) if law is not None)


def end_laws(cable: Cable) -> tuple[Law, ...]:
    """Return the laws at both ends of a range of stiffness, file order; one law where it is exact.

    Stretch, unstretched length and spring constant are monotone in the stiffness: those of every choice lie
    between those of the ends.
    """
    if cable.elasticity is None:
        return (law_of(cable),)
    return tuple(law_of(replace(cable, elasticity=end)) for end in cable.elasticity.ends())


def model_of(cable: Cable, gravity: Point) -> CableModel:
    """Return the model of a cable of a robot; swivel axes are against gravity (m/s2) where none is given."""
    up = None
    if cable.pulley is not None and cable.pulley.axis is None:
        x, y, z = exact_point(gravity)
        up = (-x, -y, -z)
    return CableModel(next(r for r in (of(cable, up) for of in ROUTES) if r is not None), law_of(cable))
