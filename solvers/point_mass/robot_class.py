"""The class of point masses, as `solvers.classes` lists it."""

from __future__ import annotations

from typing import Any

from cdpr_interval.robots.cable_robot import POINT_MASS, Robot
from solvers.answers.data import Answer, Solution
from solvers.point_mass import scope
from solvers.questions.problem import Options, Problem


class PointMassClass:
    """Loads on straight cables that end at the centre of mass: one pose at most, anywhere."""

    name = POINT_MASS
    title = "point mass"
    turns = False
    solves_ranges = True
    refuses = staticmethod(scope.refuses)
    complaints = staticmethod(scope.complaints)

    def accepts(self, robot: Robot) -> bool:
        """Return True for a point mass on straight cables that all stretch or all do not."""
        return scope.accepts(robot) and not scope.is_routed(robot)

    def forward(self, problem: Problem, options: Options) -> Answer:
        """Return every static pose."""
        from solvers.point_mass.forward import solve

        return solve(problem, options)

    def follower(self, robot: Robot, start: Solution) -> Any:
        """Return what proves the pose for ranges of lengths; it needs no start."""
        from solvers.point_mass.controller import StraightPointMass

        solver = StraightPointMass(robot)
        return lambda ranges: solver.solve(ranges.tolist())


CLASS = PointMassClass()
