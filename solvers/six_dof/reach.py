"""Why a six-dof robot has no pose: which cables cannot reach, where that is proved."""

from __future__ import annotations

from itertools import combinations

from cdpr_interval.exact import balls
from solvers.questions.problem import Problem


def reach_message(problem: Problem, ignore_slack: bool = False) -> str:
    """Return one sentence for a complete answer without solutions.

    Parameters
    ----------
    problem : Problem
    ignore_slack : bool
        Cables outside the subset that was asked for need not reach.

    That the cables cannot reach the platform together is said of pairs for which it is proved. Else the
    platform may well be reached: at poses where no tensions >= 0 balance the load, or no finite ones.
    """
    names = problem.robot.cable_names
    needed = problem.taut or () if ignore_slack else range(len(names))
    apart = [f"{names[i]} and {names[j]}" for i, j in combinations(needed, 2) if too_far(problem, i, j)]
    if apart:
        return f"no pose: cables {', '.join(apart)} are too short to reach the platform together"
    if problem.taut is not None:
        listed = ", ".join(names[i] for i in problem.taut)
        return f"no static pose with exactly {listed} taut: the whole pose space is excluded"
    return "no static pose: every taut subset is excluded"


def too_far(problem: Problem, i: int, j: int) -> bool:
    """Return True when |A_i - A_j| > l_i + l_j + |B_i - B_j| is proved."""
    with balls.precision():
        exits, anchors = problem.loaded.exits, problem.loaded.anchors
        gap = balls.norm(balls.fractions(exits[i]) - balls.fractions(exits[j]))
        span = balls.norm(balls.fractions(anchors[i]) - balls.fractions(anchors[j]))
        reach = balls.from_fraction(problem.lengths[i][1] + problem.lengths[j][1])
        return bool(gap > reach + span)
