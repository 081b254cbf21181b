"""Families (c) and (d): all taut cables end in one platform point, which is a point-mass problem."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
from flint import arb, arb_mat

from cdpr_interval.exact import balls
from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.six_dof.frame import Pose, upward
from cdpr_interval.robots.cable_robot import Cable, Platform, Robot
from solvers.answers.data import Solution
from solvers.point_mass import forward as point_mass
from solvers.questions.problem import Method, Options, Problem


def point_solution(problem: Problem, options: Options, taut: tuple[int, ...]) -> Solution | str | None:
    """Return where the common point of the taut cables rests with all of them positive.

    None: proved that there is no such place. A string: why it could not be decided.
    """
    origin = (Fraction(0), Fraction(0), Fraction(0))
    cables = tuple(
        Cable(problem.robot.cables[i].name, problem.robot.cables[i].frame_anchor, origin) for i in taut
    )
    robot = Robot(
        name=problem.robot.name,
        platform=Platform(problem.robot.platform.mass),
        cables=cables,
        gravity=problem.robot.gravity,
    )
    part = Problem(
        robot,
        tuple(problem.lengths[i] for i in taut),
        problem.external_force,
        taut=tuple(range(len(taut))),
    )
    convex = replace(
        options, method=Method.CONVEX, time_limit=None, cell_limit=None, progress=None, ignore_slack=False
    )
    answer = point_mass.solve(part, convex)
    if answer.solutions:
        (pose,) = answer.solutions
        return pose if np.isfinite(pose.tensions).all() else f"{pose.note} (as a point mass)"
    return answer.undecided[0].reason if answer.undecided else None


def poses_at(problem: Problem, taut: tuple[int, ...], at: Solution) -> list[Pose]:
    """Return the poses with the common point there: hanging, and balanced over it; (c): any rotation."""
    point = balls.vector([balls.from_bounds(lo, hi) for lo, hi in at.position])
    densities = []
    for k, i in enumerate(taut):
        lo, hi = problem.lengths[i]
        length = balls.from_fraction(lo).union(balls.from_fraction(hi))
        densities.append(balls.from_bounds(*at.tensions[k]) / length)
    arm = problem.loaded.arms[taut[0]]
    if not any(arm):
        return [Pose(balls.identity(), point, tuple(densities))]
    return [hung(problem, point, arm, sign, tuple(densities)) for sign in (1, -1)]


def hung(problem: Problem, point: arb_mat, arm: Vector, sign: int, densities: tuple[arb, ...]) -> Pose:
    """Return the pose whose arm b points along sign * up at the given point."""
    up = upward(problem.load)
    b = balls.fractions(arm)
    axis = b * (1 / balls.norm(b))
    target = up * sign
    rotation = balls.right_handed(target) * balls.right_handed(axis).transpose()
    return Pose(rotation, point - rotation * b, densities)
