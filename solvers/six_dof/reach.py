"""Why a six-dof robot has no pose: which cables cannot reach, and by how much, where that is proved."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from itertools import combinations

from cdpr_interval.exact import balls
from cdpr_interval.exact.decimals import rounded_down
from cdpr_interval.exact.vector import minus
from cdpr_interval.text.count import counted
from solvers.point_mass.rationals.emptiness import short_message, shortfall
from solvers.questions.problem import Problem

MOST_PAIRS = 5
"""Pairs of cables that are named; the rest is counted."""


def reach_message(problem: Problem, ignore_slack: bool = False) -> str:
    """Return one sentence for a complete answer without solutions.

    Parameters
    ----------
    problem : Problem
    ignore_slack : bool
        Cables outside the subset that was asked for need not reach.

    That the cables cannot reach the platform together is said where it is proved, of pairs or of all. Else
    the platform may well be reached: at poses where no tensions >= 0 balance the load, or no finite ones.
    """
    names = problem.robot.cable_names
    needed = tuple(problem.taut or () if ignore_slack else range(len(names)))
    short = [(pair, too_short(problem, *pair)) for pair in combinations(needed, 2)]
    apart = sorted(((pair, by) for pair, by in short if by is not None), key=lambda found: -found[1])
    if apart:
        said = [
            f"{names[i]} and {names[j]} (by at least {by.normalize():f} m)"
            for (i, j), by in apart[:MOST_PAIRS]
        ]
        more = f" and {counted(len(apart) - MOST_PAIRS, 'more pair')}" if len(apart) > MOST_PAIRS else ""
        return f"no pose: cables {', '.join(said)}{more} are too short to reach the platform together"
    if needed and (together := all_too_short(problem, needed)):
        more = short_message(together)
        return f"no pose: the cables are too short to reach the platform together{more}"
    if problem.taut is not None:
        listed = ", ".join(names[i] for i in problem.taut)
        return f"no static pose with exactly {listed} taut: the whole pose space is excluded"
    return "no static pose: every taut subset is excluded"


def too_short(problem: Problem, i: int, j: int) -> Decimal | None:
    """Return what is proved to be missing to |A_i - A_j| <= l_i + l_j + |B_i - B_j|, m; None: nothing is."""
    with balls.precision():
        exits, anchors = problem.loaded.exit_ranges, problem.loaded.anchor_ranges
        gap = balls.norm(balls.ranges(exits[i]) - balls.ranges(exits[j]))
        span = balls.norm(balls.ranges(anchors[i]) - balls.ranges(anchors[j]))
        reach = balls.from_fraction(problem.lengths[i][1] + problem.lengths[j][1])
        missing = balls.to_range(gap - reach - span).lo
    return rounded_down(missing) if missing > 0 else None


def all_too_short(problem: Problem, needed: tuple[int, ...]) -> Decimal:
    """Return by how much all lengths have to grow, alike, before cables can reach a platform; 0: not proved.

    The mean b of the anchors is within l_i + |B_i - b| of every exit point, whatever the pose.
    """
    if not problem.is_exact:
        return Decimal(0)
    anchors = [problem.loaded.anchors[i] for i in needed]
    mean = [sum(axis, Fraction(0)) / len(anchors) for axis in zip(*anchors, strict=True)]
    with balls.precision():
        arms = [balls.to_range(balls.norm(balls.fractions(minus(b, mean)))).hi for b in anchors]
    longest = [problem.lengths[i][1] + arm for i, arm in zip(needed, arms, strict=True)]
    return shortfall([problem.loaded.exits[i] for i in needed], longest)
