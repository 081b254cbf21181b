"""The question put to a solver: a robot, exact length ranges, the load and the options."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING

from cdpr_interval.robots.cable_robot import Robot, Vector

if TYPE_CHECKING:
    from solvers.six_dof.parts import Parts
    from solvers.six_dof.record import Record

LengthRange = tuple[Fraction, Fraction]


class Method(StrEnum):
    """How a point-mass problem is solved."""

    AUTO = "auto"
    SEARCH = "search"
    CONVEX = "convex"


@dataclass(frozen=True)
class Progress:
    """What a progress display may show while a search runs."""

    cells: int
    """Cells looked at so far, over all subsets."""
    pending: int
    """Cells waiting in the current subset."""
    volume_left: float
    """Share of the current subset's search volume not yet decided, 0..1."""
    solutions: int
    """Solutions proved so far."""
    subsets_done: int
    subsets_total: int


@dataclass(frozen=True)
class Options:
    """Budgets and switches of one forward-kinematics run."""

    ignore_slack: bool = False
    ignore_tension_sign: bool = False
    method: Method = Method.AUTO
    precision: float = 1e-9
    """Target width of position (m) and rotation entries of a reported solution, exact input."""
    time_limit: float | None = None
    """Seconds of wall time."""
    cell_limit: int | None = None
    threads: int = 1
    progress: Callable[[Progress], None] | None = None
    """Called a few times a second from the thread that asked."""
    record: Record | None = None
    """Keeps what a certificate needs of the searches."""
    parts: Parts | None = None
    """Searches of a platform's subsets that were done elsewhere; the others are done here."""


@dataclass(frozen=True)
class Problem:
    """A robot with exact length ranges (m), in file order; elastic cables: unstretched lengths."""

    robot: Robot
    lengths: tuple[LengthRange, ...]
    external_force: Vector = (Fraction(0), Fraction(0), Fraction(0))
    """Constant force at the centre of mass, base axes, N; added to the weight."""
    taut: tuple[int, ...] | None = None
    """One subset of cable indices (ascending) instead of all subsets."""

    @cached_property
    def load(self) -> Vector:
        """The force f = m g + F on the platform, N, base axes."""
        mass = self.robot.platform.mass
        g, extra = self.robot.gravity, self.external_force
        return (mass * g[0] + extra[0], mass * g[1] + extra[1], mass * g[2] + extra[2])

    @cached_property
    def anchors_from_centre(self) -> tuple[Vector, ...]:
        """B_i - G in the platform frame, m."""
        c = self.robot.platform.centre_of_mass
        return tuple(
            (b[0] - c[0], b[1] - c[1], b[2] - c[2])
            for b in (cable.platform_anchor for cable in self.robot.cables)
        )
