"""The route of a cable that leaves through a fixed point: all of it is free, and straight."""

from __future__ import annotations

from dataclasses import dataclass

from cdpr_interval.exact.vector import Vector
from cdpr_interval.robots.cable_robot import Cable, exact_point


@dataclass(frozen=True)
class FixedExit:
    """A cable from a fixed exit point (base frame, m)."""

    point: Vector

    @staticmethod
    def of(cable: Cable) -> FixedExit:
        """Return the route of a cable: all exit points are fixed."""
        return FixedExit(exact_point(cable.frame_anchor))

    def exit(self) -> Vector:
        """Return the exit point."""
        return self.point
