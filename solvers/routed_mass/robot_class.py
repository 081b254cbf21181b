"""The class of point masses on routed cables, as `solvers.classes` lists it."""

from __future__ import annotations

from typing import Any

from cdpr_interval.robots.cable_robot import Robot
from solvers.answers.data import Answer, Solution
from solvers.point_mass import scope
from solvers.questions.problem import Options, Problem


class RoutedMassClass:
    """Point masses with pulleys, or with elastic and inextensible cables together."""

    name = "routed point-mass"
    title = "point mass"
    turns = False
    solves_ranges = True
    refuses = staticmethod(scope.refuses)
    complaints = staticmethod(scope.complaints)

    def accepts(self, robot: Robot) -> bool:
        """Return True for a point mass on routed cables."""
        return scope.accepts(robot) and scope.is_routed(robot)

    def forward(self, problem: Problem, options: Options) -> Answer:
        """Return every static pose."""
        from solvers.routed_mass.forward import solve_routed

        return solve_routed(problem, options)

    def follower(self, robot: Robot, start: Solution) -> Any:
        """Return what proves the pose for ranges of lengths; it needs no start."""
        from solvers.routed_mass.controller import PointMass

        solver = PointMass(robot)
        return lambda ranges: solver.solve(ranges.tolist())


CLASS = RoutedMassClass()
