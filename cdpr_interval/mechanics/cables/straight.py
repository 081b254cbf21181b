"""The route of a cable that leaves through a fixed point: what lies behind it is free, and straight."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.cables.path import Numbers, Path, Triple, minus, norm, scaled
from cdpr_interval.robots.cable_robot import Cable
from cdpr_interval.robots.numbers import exact, exact_point


@dataclass(frozen=True)
class FixedExit:
    """A cable from a fixed exit point (base frame, m)."""

    point: Vector
    before: Fraction = Fraction(0)
    """How much of the cable lies before the exit point, m."""

    @staticmethod
    def of(cable: Cable, up: Vector | None) -> FixedExit | None:
        """Return the route of a cable without a pulley, or over one without a radius."""
        if cable.pulley is None:
            return FixedExit(exact_point(cable.frame_anchor))
        if not cable.pulley.is_plain:
            return None
        return FixedExit(exact_point(cable.frame_anchor), exact(cable.pulley.lead_in))

    @property
    def fixed_exit(self) -> Vector | None:
        """The exit point, where nothing of the cable lies before it."""
        return None if self.before else self.point

    def path(self, anchor: Triple, numbers: Numbers) -> Path:
        """Return the straight line from the exit point."""
        start = numbers.point(self.point)
        spoke = minus(anchor, start)
        free = norm(spoke, numbers)
        before, none = numbers.number(self.before), numbers.number(Fraction(0))
        return Path(before + free, free, before, none, scaled(1 / free, spoke), start, start, start)

    def turning(self, path: Path, anchor: Triple, numbers: Numbers) -> list[list[Any]]:
        """Return the derivative of the direction by the anchor."""
        a = path.direction
        return [
            [(numbers.number(Fraction(int(i == j))) - a[i] * a[j]) / path.free for j in range(3)]
            for i in range(3)
        ]
