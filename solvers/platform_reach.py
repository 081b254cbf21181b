"""Why a six-dof robot has no pose: which cables cannot reach."""

from __future__ import annotations

from itertools import combinations

from solvers import balls
from solvers.problem import Problem


def reach_message(problem: Problem) -> str:
    """Return one sentence for a complete answer without solutions."""
    names = problem.robot.cable_names
    apart = [
        f"{names[i]} and {names[j]}" for i, j in combinations(range(len(names)), 2) if too_far(problem, i, j)
    ]
    if apart:
        return f"no pose: cables {', '.join(apart)} are too short to reach the platform together"
    if problem.taut is not None:
        chosen = ", ".join(names[i] for i in problem.taut)
        return f"no static pose with exactly {chosen} taut: the whole pose space is excluded"
    return "no pose: the cables cannot reach the platform together; every taut subset is excluded"


def too_far(problem: Problem, i: int, j: int) -> bool:
    """Return True when |A_i - A_j| > l_i + l_j + |B_i - B_j| is proved."""
    with balls.precision():
        a, b = problem.robot.cables[i], problem.robot.cables[j]
        gap = balls.norm(balls.fractions(a.frame_anchor) - balls.fractions(b.frame_anchor))
        span = balls.norm(balls.fractions(a.platform_anchor) - balls.fractions(b.platform_anchor))
        reach = balls.from_fraction(problem.lengths[i][1] + problem.lengths[j][1])
        return bool(gap > reach + span)
