"""What a cable model must say, and which model a cable of a robot has.

A model is a pair. Its **route** says where the free part starts and how much of the cable lies before it; its
**law** says how far the free part reaches under a tension. Both are written once, in plain arithmetic that
takes floats, rationals, exact ranges and balls alike: numbers of the robot's data enter through ``number``,
which makes an exact rational one of the kind in hand. Compiled kernels have their own copy in
`cdpr_interval.mechanics.cables.compiled`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple, Protocol

from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.cables.spring import AxialSpring, Inextensible, Spring
from cdpr_interval.mechanics.cables.straight import FixedExit
from cdpr_interval.robots.cable_robot import Cable

Number = Callable[[Fraction], Any]
"""Makes an exact rational a number of the kind that is computed with (``float``, `Range.exact`, a ball)."""


class Route(Protocol):
    """Where the free part of a cable starts."""

    def exit(self) -> Vector:
        """Return the point, base frame, m, from which the free part leaves; exact."""


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
ROUTES: tuple[Callable[[Cable], Route | None], ...] = (FixedExit.of,)
"""Routes likewise."""


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


def model_of(cable: Cable) -> CableModel:
    """Return the model of a cable of a robot."""
    return CableModel(next(r for r in (of(cable) for of in ROUTES) if r is not None), law_of(cable))
