"""The question put to a solver: a robot, exact length ranges, the load and the options."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from typing import Any, Protocol

from cdpr_interval.engine.budget import Budget
from cdpr_interval.exact.range import LengthRange
from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.loaded import NO_FORCE, LoadedRobot, loaded
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import Point


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
    done: float | None = None
    """Share of all the work, 0..1, where it is known better than by subsets."""


class Record(Protocol):
    """Keeps what a certificate needs of the searches of a run."""

    budget: Budget
    """What the run may spend: the certificate has what is left of it."""

    @property
    def searches(self) -> Mapping[tuple[int, ...], Sequence[Any]]:
        """What was kept, by taut subset."""

    @property
    def roots(self) -> Mapping[tuple[int, ...], Sequence[Any]]:
        """Of cables over pulleys: the roots with each taut subset, ascending."""

    @property
    def is_interrupted(self) -> bool:
        """Whether the run, or the writing of its certificate, was interrupted."""

    def observer(self) -> Any:
        """Return what sees the cells of one search."""

    def keep(self, taut: tuple[int, ...], reduced: Any, subset: Any, notes: Any) -> None:
        """Remember the search of a taut subset that has ended, and what its observer noted."""

    def keep_roots(self, taut: tuple[int, ...], roots: Sequence[Any]) -> None:
        """Remember the roots of a taut subset of cables over pulleys."""


Parts = Mapping[tuple[tuple[int, ...], int], Sequence[Any]]
"""Searches done elsewhere, by taut subset and frame: what the parts of each found."""


@dataclass(frozen=True)
class Options:
    """Budgets and switches of one forward-kinematics run."""

    ignore_slack: bool = False
    ignore_tension_sign: bool = False
    method: Method = Method.AUTO
    precision: float = 1e-9
    """Target width of the position in m and the rotation entries of a solution, exact input."""
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


def asked_of(robot: Robot, options: Options) -> Options:
    """Return the options of a question about a robot: legs push and pull, whatever was asked for."""
    if not robot.has_legs or options.ignore_tension_sign:
        return options
    return replace(options, ignore_tension_sign=True)


@dataclass(frozen=True)
class Problem:
    """A robot with exact length ranges (m), in file order; elastic cables: unstretched lengths."""

    robot: Robot
    lengths: tuple[LengthRange, ...]
    external_force: Point = NO_FORCE
    """Constant force at the centre of mass, base axes, N; added to the weight. Entries may be ranges."""
    taut: tuple[int, ...] | None = None
    """One subset of cable indices (ascending) instead of all subsets."""
    tension: LengthRange | None = None
    """Limits in N: only poses whose taut cables all have a tension within them."""

    @cached_property
    def loaded(self) -> LoadedRobot:
        """The robot under its weight and the external force, kept between questions."""
        return loaded(self.robot, self.external_force)

    @property
    def load(self) -> Vector:
        """The force f = m g + F on the platform, N, base axes; exact numbers, or `NotSupportedError`."""
        return self.loaded.load

    @property
    def is_exact(self) -> bool:
        """True when robot and force are exact numbers; lengths may be ranges."""
        return self.loaded.is_exact
