"""Every class of robots in the same battery: its own robots only, refusals, budgets, an interrupt."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from cdpr_interval import load_robot
from cdpr_interval.errors import NotSupportedError
from cdpr_interval.exact.range import Range
from solvers import Outcome, StopReason, forward_kinematics
from solvers.classes import CLASSES, RobotClass, class_of, require_supported

ROBOTS = {
    "point-mass": ("merlet_4_1", [3.1, 3.2, 3.3, 3.4]),
    "routed point-mass": ("paty_cdpr4", [9.6545, 9.098, 9.9137, 10.9276]),
    "six-dof": ("uc3", [7.5, 8.0, 7.0]),
}
"""A robot that ships and lengths with poses, of every class."""


def test_every_class_has_a_robot_here() -> None:
    assert [kind.name for kind in CLASSES] == list(ROBOTS)


@pytest.mark.parametrize("kind", CLASSES, ids=lambda kind: kind.name)
class TestClass:
    def test_its_robots_are_its_own(self, kind: RobotClass) -> None:
        robot = load_robot(ROBOTS[kind.name][0])
        assert [other.name for other in CLASSES if other.accepts(robot)] == [kind.name]
        assert class_of(robot) is kind and kind.refuses(robot) is None
        require_supported(robot)

    def test_it_solves_or_refuses_a_range_in_the_data(self, kind: RobotClass) -> None:
        name, lengths = ROBOTS[kind.name]
        robot = load_robot(name)
        vague = replace(robot, platform=replace(robot.platform, mass=Range(Fraction(1), Fraction(2))))
        assert kind.accepts(vague)
        if kind.refuses(vague) is None:
            assert forward_kinematics(vague, lengths).solutions
            return
        with pytest.raises(NotSupportedError, match=r"uncertain scalars .* platform\.mass_kg$"):
            require_supported(vague)

    def test_a_budget_that_ends_is_no_proof(self, kind: RobotClass) -> None:
        name, lengths = ROBOTS[kind.name]
        full = forward_kinematics(load_robot(name), lengths)
        small = forward_kinematics(load_robot(name), lengths, cell_limit=1)
        assert full.outcome is Outcome.COMPLETE and full.solutions
        if small.outcome is Outcome.COMPLETE:
            assert len(small.solutions) == len(full.solutions)
        else:
            assert small.pending or small.undecided

    def test_an_interrupt_ends_with_what_was_found(self, kind: RobotClass) -> None:
        name, lengths = ROBOTS[kind.name]

        def stop(progress: object) -> None:
            raise KeyboardInterrupt

        result = forward_kinematics(load_robot(name), lengths, progress=stop)
        if result.stop_reason is StopReason.INTERRUPTED:
            assert result.outcome is Outcome.INCOMPLETE and result.pending
        else:
            assert result.outcome is Outcome.COMPLETE
