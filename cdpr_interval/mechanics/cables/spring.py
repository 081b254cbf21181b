"""Laws of straight cables without weight: inextensible, with a spring constant, with an axial stiffness."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from cdpr_interval.robots.cable_robot import Cable
from cdpr_interval.robots.numbers import exact


@dataclass(frozen=True)
class Inextensible:
    """A cable that reaches as far as it is long, whatever its tension."""

    stretches = False

    @staticmethod
    def of(cable: Cable) -> Inextensible | None:
        """Return the law of a cable without elasticity."""
        return Inextensible() if cable.elasticity is None else None

    def stretch(self, length: Any, tension: Any, number: Callable[[Fraction], Any]) -> Any:
        """Return zero."""
        return number(Fraction(0))

    def unstretched(self, distance: Any, tension: Any, number: Callable[[Fraction], Any]) -> Any:
        """Return the distance."""
        return distance

    def spring_constant(self, length: Fraction) -> Fraction | None:
        """Return None."""
        return None


@dataclass(frozen=True)
class Spring:
    """A cable with a spring constant k (N/m) that does not depend on its length: stretch = tension / k."""

    constant: Fraction
    stretches = True

    @staticmethod
    def of(cable: Cable) -> Spring | None:
        """Return the law of a cable whose spring constant is given."""
        given = None if cable.elasticity is None else cable.elasticity.stiffness
        return None if given is None else Spring(exact(given))

    def stretch(self, length: Any, tension: Any, number: Callable[[Fraction], Any]) -> Any:
        """Return tension / k."""
        return tension / number(self.constant)

    def unstretched(self, distance: Any, tension: Any, number: Callable[[Fraction], Any]) -> Any:
        """Return distance - tension / k."""
        return distance - tension / number(self.constant)

    def spring_constant(self, length: Fraction) -> Fraction | None:
        """Return k."""
        return self.constant


@dataclass(frozen=True)
class AxialSpring:
    """A cable with an axial stiffness EA (N): stretch = length tension / EA, so k = EA / length."""

    axial: Fraction
    stretches = True

    @staticmethod
    def of(cable: Cable) -> AxialSpring | None:
        """Return the law of a cable whose axial stiffness is given."""
        given = None if cable.elasticity is None else cable.elasticity.axial_stiffness
        return None if given is None else AxialSpring(exact(given))

    def stretch(self, length: Any, tension: Any, number: Callable[[Fraction], Any]) -> Any:
        """Return length tension / EA."""
        return length * (tension / number(self.axial))

    def unstretched(self, distance: Any, tension: Any, number: Callable[[Fraction], Any]) -> Any:
        """Return distance / (1 + tension / EA)."""
        return distance / (tension / number(self.axial) + number(Fraction(1)))

    def spring_constant(self, length: Fraction) -> Fraction | None:
        """Return EA / length."""
        return self.axial / length
