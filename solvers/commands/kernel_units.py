"""What is compiled beforehand: units that share few kernels, each a question or two in a process of its own.

Run as ``python -m solvers.commands.kernel_units UNIT``; prints the number of kernels that had to be compiled.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass

POINT, PLATFORM = "point", "platform"


@dataclass(frozen=True)
class Unit:
    """Kernels that are compiled in one process."""

    kind: str
    """POINT or PLATFORM."""
    words: str
    """What they are for."""
    compile: Callable[[], None]
    after: str | None = None
    """The unit whose kernels these call: it comes before, so that no two processes compile the same."""


def points() -> None:
    """Point masses, with inextensible and with elastic cables."""
    from cdpr_interval import load_robot
    from solvers.forward import forward_kinematics
    from solvers.routed_mass.controller import PointMass

    for name, lengths in POINT_QUESTIONS:
        robot = load_robot(name)
        PointMass(robot).warm_up()
        forward_kinematics(robot, lengths, taut=(0, 1, 2))
        if name == "merlet_4_1":
            forward_kinematics(robot, lengths, method="search")


def searches() -> None:
    """Platforms: the searches in rotations and in poses, the proofs of roots, what is reported of them."""
    from solvers.six_dof import warming

    # Subsets of one cable are point masses, which have their own unit.
    warming.searches()


def trackers() -> None:
    """Platforms whose pose is followed."""
    from cdpr_interval import load_robot
    from solvers.forward import forward_kinematics
    from solvers.six_dof.tracker import Tracker

    robot = load_robot("uc3")
    start = forward_kinematics(robot, ["7.5", "8", "7"], taut=(0, 1, 2)).solutions[0]
    Tracker(robot, start).warm_up()
    Tracker(load_robot("irma4u")).warm_up()


def certificates() -> None:
    """Platforms: the searches that a certificate records."""
    from cdpr_interval import load_robot
    from solvers.forward import answer_question, pose_problem
    from solvers.proofs.document import certificate_bytes
    from solvers.questions.problem import Options
    from solvers.six_dof.record import Record
    from solvers.six_dof.warming import QUESTIONS

    for name, lengths, taut in QUESTIONS:
        options = Options(record=Record())
        problem = pose_problem(load_robot(name), lengths, taut, None, options)
        certificate_bytes(problem, options, answer_question(problem, options))


POINT_QUESTIONS = (
    ("merlet_4_1", ("2.6925824", "3.9051248", "3.3541019", "4.385")),
    ("merlet_4_1_k100", ("2.955855", "2.955855", "4.10288", "4.10288")),
    ("paty_cdpr4", ("9.6545", "9.098", "9.9137", "10.9276")),
)
"""Robots of each kind of cable, with lengths."""
UNITS = {
    "searches": Unit(PLATFORM, "six-dof platforms", searches),
    "points": Unit(POINT, "point masses", points),
    "certificates": Unit(PLATFORM, "certificates of platforms", certificates, "searches"),
    "trackers": Unit(PLATFORM, "trackers of platforms", trackers, "searches"),
}
"""Units by name, the longest first."""


def main() -> None:
    """Compile a unit."""
    from numba.core import event

    count = 0

    class Compiled(event.Listener):  # type: ignore[misc]
        def on_start(self, event: object) -> None:
            nonlocal count
            count += 1

        def on_end(self, event: object) -> None:
            pass

    with event.install_listener("numba:compile", Compiled()):
        UNITS[sys.argv[1]].compile()
    print(count)


if __name__ == "__main__":
    main()
