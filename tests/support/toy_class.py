"""A class of robots as small as can be: a plumb bob, one cable with a weight at its end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np

from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.files.document import Document
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Cable, Platform, Robot
from solvers.answers.data import Answer, CableState, Certainty, Nominal, Proof, Solution, SubsetReport
from solvers.questions.arguments import Label
from solvers.questions.problem import Options, Problem

FORMAT = "plumb-robot/1"
ORIGIN = (Fraction(0), Fraction(0), Fraction(0))
FILE = f"""\
format: {FORMAT}
name: bob
mass_kg: 3
hook_m: [1, 2, 5/2]
"""


@dataclass(frozen=True)
class Plumb(Robot):
    """Step 1, data: the hook is the exit point of the one cable."""

    @property
    def model(self) -> str:
        """The word of results."""
        return "plumb"


def read(document: Document) -> Plumb:
    """Step 2, the file."""
    given = document.root.mapping
    hook = tuple(Fraction(item.literal) for item in given["hook_m"].items)
    cable = Cable("rope", (hook[0], hook[1], hook[2]), ORIGIN)
    platform = Platform(Fraction(given["mass_kg"].literal))
    return Plumb(str(given["name"].value), platform, (cable,)).read_from(document.data)


def below(hook: tuple[Fraction, ...], length: Fraction) -> tuple[Fraction, ...]:
    """Step 3, the equations: the bob hangs one length below the hook."""
    return (hook[0], hook[1], hook[2] - length)


class PlumbClass:
    """Step 4, the class."""

    name = "plumb"
    title = "plumb bob"
    turns = False
    solves_ranges = True

    def accepts(self, robot: Any) -> bool:
        """Return True for a plumb bob."""
        return isinstance(robot, Plumb)

    def refuses(self, robot: Plumb, force: Any = None) -> str | None:
        """Return why an elastic one is not treated."""
        return "a stretching rope is not supported" if robot.is_elastic else None

    def complaints(
        self, robot: Plumb, taut: tuple[int, ...] | None, options: Options, label: Label
    ) -> Iterator[str]:
        """Yield the rule that only ropes of searches have a method."""
        if options.method != "auto":
            yield f"{label('method')}: a plumb bob has none"

    def forward(self, problem: Problem, options: Options) -> Answer:
        """Return the one pose."""
        (cable,), ((lo, hi),) = problem.robot.cables, problem.lengths
        low, high = below(cable.frame_anchor, hi), below(cable.frame_anchor, lo)
        bounds = [(enclose(a)[0], enclose(b)[1]) for a, b in zip(low, high, strict=True)]
        weight = enclose(-problem.load[2])
        position = np.array(bounds)
        x, y, z = position.mean(axis=1).tolist()
        solution = Solution(
            taut=(0,),
            cable_states=(CableState.TAUT,),
            position=position,
            rotation=np.repeat(np.eye(3)[:, :, None], 2, axis=2),
            height=position[2],
            tensions=np.array([weight]),
            distances=np.array([[enclose(lo)[0], enclose(hi)[1]]]),
            slack_respected=True,
            existence=Certainty.PROVED,
            uniqueness=Certainty.PROVED,
            proof=Proof.CONVEXITY,
            stability=Stability.STABLE,
            nominal=Nominal((x, y, z), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
            family=None,
        )
        answer = Answer((solution,))
        report = SubsetReport((0,), answer.outcome, 1, 0, 0.0)
        return Answer((solution,), subsets=(report,))

    def follower(self, robot: Plumb, start: Solution) -> Callable[[Any], Any]:
        """Step 4 goes on: the one pose for any lengths, so the start does not matter."""

        def follow(ranges: Any) -> Any:
            lengths = tuple((Fraction(lo), Fraction(hi)) for lo, hi in ranges.tolist())
            (pose,) = self.forward(Problem(robot, lengths), Options()).solutions
            known = {"position": pose.position, "tensions": pose.tensions}
            return SimpleNamespace(proved=True, reason="", states=pose.cable_states, **known)

        return follow
