"""The class of six-dof platforms, as `solvers.classes` lists it."""

from __future__ import annotations

from typing import Any

from cdpr_interval.robots.cable_robot import SIX_DOF, Robot
from solvers.answers.data import Answer, Solution
from solvers.questions.problem import Options, Problem
from solvers.six_dof import scope


class SixDofClass:
    """Rigid platforms: several poses, for every subset of taut cables."""

    name = SIX_DOF
    title = "six-dof platform"
    turns = True
    solves_ranges = False
    accepts = staticmethod(scope.accepts)
    refuses = staticmethod(scope.refuses)
    complaints = staticmethod(scope.complaints)

    def forward(self, problem: Problem, options: Options) -> Answer:
        """Return every static pose."""
        if scope.needs_real_cells(problem.robot):
            from solvers.six_dof.over_pulleys import solve as solve_real

            return solve_real(problem, options)
        from solvers.six_dof.forward import solve

        return solve(problem, options)

    def follower(self, robot: Robot, start: Solution) -> Any:
        """Return what proves for ranges of lengths the pose that goes on from a given one."""
        from solvers.six_dof.tracker import Tracker

        return Tracker(robot, start).update


CLASS = SixDofClass()
