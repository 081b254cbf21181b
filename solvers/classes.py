"""The classes of robots: the one list of them, and what each of them must say."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.errors import NotSupportedError
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.loaded import NO_FORCE
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import Point
from solvers.answers.data import Answer, CableState, Solution
from solvers.point_mass.robot_class import CLASS as POINT_MASS
from solvers.questions.arguments import Label
from solvers.questions.checked import require_treated
from solvers.questions.problem import Options, Problem
from solvers.routed_mass.robot_class import CLASS as ROUTED_MASS
from solvers.six_dof.robot_class import CLASS as SIX_DOF


class Followed(Protocol):
    """A pose proved for ranges of lengths, or why none is."""

    @property
    def proved(self) -> bool:
        """True when there is exactly one pose for every choice of the lengths, and the bounds enclose it."""

    @property
    def reason(self) -> str:
        """Why not, one sentence."""

    @property
    def states(self) -> Sequence[CableState]:
        """What is proved about each cable, file order."""

    @property
    def position(self) -> Bounds:
        """(3, 2) m: platform origin in the base frame."""

    @property
    def tensions(self) -> Bounds:
        """(N, 2) N, file order."""


class RobotClass(Protocol):
    """A class of robots: it says which robots are its own, and answers the questions about them.

    A class is one package under ``solvers``, filled in in its ``robot_class.py``; it knows neither this list
    nor another class.
    """

    name: str
    """The word of results and files (``six-dof``)."""
    title: str
    """What messages call it (``six-dof platform``)."""
    turns: bool
    """The platform has an orientation: to be asked for, settled, reported and varied."""
    solves_ranges: bool
    """`forward` treats ranges of lengths as wide as what winches do not know."""

    def accepts(self, robot: Any) -> bool:
        """Return True for a robot of this class; exactly one class accepts a robot."""

    def refuses(self, robot: Any, force: Point = NO_FORCE) -> str | None:
        """Return why this version cannot treat a robot of the class under a force (N), as a sentence.

        None where it can. Ranges in the data of robot and force count.
        """

    def complaints(
        self, robot: Any, taut: tuple[int, ...] | None, options: Options, label: Label
    ) -> Iterator[str]:
        """Yield the rules of the class that a question breaks; ``label`` names a parameter in messages."""

    def forward(self, problem: Problem, options: Options) -> Answer:
        """Return every static pose of a question that breaks no rule.

        Guarantee
        ---------
        With outcome COMPLETE no static pose of what was asked is missing. The budgets of ``options`` are
        kept; an interrupt ends the search with what was proved until then.
        """

    def follower(self, robot: Any, start: Solution) -> Callable[[NDArray[np.float64]], Followed]:
        """Return what proves a pose, call by call, for ranges (N, 2) of lengths, going on from a start."""


CLASSES: tuple[RobotClass, ...] = (POINT_MASS, ROUTED_MASS, SIX_DOF)


def class_of(robot: Any) -> RobotClass:
    """Return the class of a robot.

    Raises
    ------
    NotSupportedError
        When none accepts it.
    """
    for kind in CLASSES:
        if kind.accepts(robot):
            return kind
    raise NotSupportedError(f"robot '{robot.name}': no class of robots of this version is its own")


def require_supported(robot: Robot) -> None:
    """Raise `NotSupportedError` for a robot that no solver of this version can treat."""
    require_treated(robot, class_of(robot).refuses(robot))
