"""The class of point masses, as `solvers.classes` lists it."""

from __future__ import annotations

from typing import Any

from cdpr_interval.robots.cable_robot import POINT_MASS, Robot
from solvers.answers.data import Answer, Solution
from solvers.point_mass import scope
from solvers.questions.problem import Options, Problem


class PointMassClass:
    """Robots all of whose cables end at the centre of mass: one pose at most, anywhere."""

    name = POINT_MASS
    title = "point mass"
    turns = False
    solves_ranges = True
    accepts = staticmethod(scope.accepts)
    refuses = staticmethod(scope.refuses)
    complaints = staticmethod(scope.complaints)

    def forward(self, problem: Problem, options: Options) -> Answer:
        """Return every static pose."""
        from solvers.point_mass.forward import solve

        return solve(problem, options)

    def follower(self, robot: Robot, start: Solution) -> Any:
        """Return what proves the pose for ranges of lengths; it needs no start."""
        from solvers.point_mass.controller import PointMass

        solver = PointMass(robot)
        return lambda ranges: solver.solve(ranges.tolist())


CLASS = PointMassClass()
