"""Families (c) and (d): all taut cables end in one platform point, which is a point-mass problem."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from flint import arb, arb_mat

from cdpr_interval.exact import balls
from cdpr_interval.exact.range import RangeVector
from cdpr_interval.mechanics.six_dof.frame import Pose, upward
from cdpr_interval.robots.cable_robot import Cable, Platform, Robot
from solvers.point_mass import forward as point_mass
from solvers.questions.problem import Method, Options, Problem


class Held(NamedTuple):
    """The common point of the taut cables where it rests, base frame in m, and their densities in N/m."""

    point: arb_mat
    densities: tuple[arb, ...]


def point_solution(problem: Problem, options: Options, taut: tuple[int, ...]) -> Held | str | None:
    """Return where the common point of the taut cables rests with all of them positive.

    None: proved that there is no such place. A string: why it could not be decided.
    """
    if len(taut) == 1:
        return below(problem, taut[0])
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
        if not np.isfinite(pose.tensions).all():
            return f"{pose.note} (as a point mass)"
        point = balls.vector([balls.from_bounds(lo, hi) for lo, hi in pose.position])
        tensions = [balls.from_bounds(lo, hi) for lo, hi in pose.tensions]
        return Held(point, tuple(t / length_of(problem, i) for t, i in zip(tensions, taut, strict=True)))
    return answer.undecided[0].reason if answer.undecided else None


def below(problem: Problem, cable: int) -> Held:
    """Return the point that hangs by one cable: l f / |f| from its exit point, with the density |f| / l.

    In closed form: no kernel of point masses need be compiled or loaded for it.
    """
    loaded, length = problem.loaded, length_of(problem, cable)
    down = upward(loaded.load_direction_ranges) * -1
    size = balls.norm(balls.ranges(loaded.load_ranges))
    return Held(balls.ranges(loaded.exit_ranges[cable]) + down * length, (size / length,))


def length_of(problem: Problem, cable: int) -> arb:
    """Return a cable's length in m."""
    lo, hi = problem.lengths[cable]
    return balls.from_fraction(lo).union(balls.from_fraction(hi))


def poses_at(problem: Problem, taut: tuple[int, ...], at: Held) -> list[Pose]:
    """Return the poses with the common point there: hanging, and balanced over it; (c): any rotation."""
    arm = problem.loaded.arm_ranges[taut[0]]
    if not any(map(any, arm)):
        return [Pose(balls.identity(), at.point, at.densities)]
    return [hung(problem, at.point, arm, sign, at.densities) for sign in (1, -1)]


def hung(problem: Problem, point: arb_mat, arm: RangeVector, sign: int, densities: tuple[arb, ...]) -> Pose:
    """Return the pose whose arm b points along sign * up at the given point."""
    up = upward(problem.loaded.load_direction_ranges)
    b = balls.ranges(arm)
    axis = b * (1 / balls.norm(b))
    target = up * sign
    rotation = balls.right_handed(target) * balls.right_handed(axis).transpose()
    return Pose(rotation, point - rotation * b, densities)
