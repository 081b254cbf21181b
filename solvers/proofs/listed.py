"""What a certificate lists: the question and the solutions, as the checker reads them from it."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
from flint import fmpq

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.cables.law import Route
from cdpr_interval.mechanics.cables.pulley import OverPulley
from cdpr_interval.robots.numbers import exact, exact_point
from certificates.apart import meeting
from certificates.problem import Listed, Pulley, Turning
from certificates.problem import Problem as Question
from solvers.answers.data import CableState, Solution
from solvers.answers.result import Result
from solvers.questions.problem import Options, Problem

Json = dict[str, Any]
WIDENED = 1e-12
"""How much bounds of a family grow, in m and rad: the checker does not find its angle to the last bit."""
WIDENED_POSE = 2.0**-50
"""The same of a single pose: a zero of the solver may be a tiny ball of the checker."""
RANGE_SHARE = 0.05
"""The same where lengths are ranges, as a share of the bounds' width."""
SECOND_ORDER = 16.0
"""The same of a platform, in squares of the widest bounds of its rotation."""
FIELDS = ("position", "rotation", "height", "tensions", "distances")


def document_solutions(problem: Problem, result: Result) -> list[Solution]:
    """Return what a certificate may list, `widened`, in its order: entries refer to these places."""
    return [s for s, reason in document_candidates(problem, result) if reason is None]


def document_candidates(problem: Problem, result: Result) -> list[tuple[Solution, str | None]]:
    """Return all solutions, `widened`, each with the reason why it cannot be listed."""
    ranges = any(lo < hi for lo, hi in problem.lengths)
    found = [(widened(s, ranges), hindrance(s)) for s in result.solutions]
    places = [k for k, (_, reason) in enumerate(found) if reason is None]
    asked = result.question
    options = Options(ignore_slack=asked.ignore_slack, ignore_tension_sign=asked.ignore_tension_sign)
    question = certificate_question(problem, options)
    for j, k in meeting(question, [listed_solution(found[place][0]) for place in places]):
        later = places[max(j, k)]
        found[later] = found[later][0], "it may be the same as another solution"
    return found


def hindrance(solution: Solution) -> str | None:
    """Return why a solution cannot be listed at all; None when it can."""
    if solution.family is not None and solution.family.kind == "torus":
        return "families about two axes are not certified"
    if not all(np.isfinite(getattr(solution, name)).all() for name in FIELDS):
        return "its bounds are not finite"
    if getattr(solution, "existence", "proved") != "proved" and "undecided" not in written_states(solution):
        return "its existence is not proved"  # an entry of decided cables would be counted
    return None


def widened(solution: Solution, ranges: bool = False) -> Solution:
    """Return a solution with bounds that are a little wider, so that the checker's own enclosure fits in.

    Needed of families, whose angle the checker does not find to the last bit, and where lengths are
    ``ranges``: there the width of an enclosure depends on how it is computed.
    """
    family = solution.family
    share, least = RANGE_SHARE if ranges else 0.0, WIDENED if family or ranges else WIDENED_POSE
    if ranges:
        least += SECOND_ORDER * float(np.ptp(solution.rotation, axis=-1).max()) ** 2
    names = ("position", "height", "tensions", "distances", "rotation")
    fields: Json = {name: wider(getattr(solution, name), share, least) for name in names}
    if family is not None:
        given = {n: getattr(family, n) for n in ("axis_point", "axis_direction", "angle_ranges")}
        parts: Json = {n: wider(v, share, least) for n, v in given.items() if v is not None}
        family = replace(family, **parts)
    return replace(solution, **fields, family=family)


def wider(bounds: Bounds, share: float, least: float) -> Bounds:
    """Return bounds (..., 2) that have grown on both sides, by a share of their width and a little more."""
    size = np.where(np.isfinite(bounds), np.abs(bounds), 0.0).max(axis=-1)
    width = np.where(np.isfinite(bounds).all(axis=-1), bounds[..., 1] - bounds[..., 0], 0.0)
    by = least * (1.0 + size) + share * width
    return np.stack([bounds[..., 0] - by, bounds[..., 1] + by], axis=-1)


def certificate_question(problem: Problem, options: Options) -> Question:
    """Return the problem as the checker reads it from a certificate."""
    robot = problem.robot
    stiffness: list[tuple[fmpq, bool] | None] = []
    for cable in robot.cables:
        elasticity = cable.elasticity
        if elasticity is None:
            stiffness.append(None)
        elif elasticity.stiffness is not None:
            stiffness.append((ratio(exact(elasticity.stiffness)), False))
        else:
            assert elasticity.axial_stiffness is not None
            stiffness.append((ratio(exact(elasticity.axial_stiffness)), True))
    pulleys = tuple(pulley_of(route) for route, _ in problem.loaded.models)
    return Question(
        names=robot.cable_names,
        exits=[[ratio(x) for x in exact_point(c.frame_anchor)] for c in robot.cables],
        points=[[ratio(x) for x in b] for b in problem.loaded.arms],
        centre=[ratio(x) for x in problem.loaded.centre],
        lengths=[(ratio(lo), ratio(hi)) for lo, hi in problem.lengths],
        stiffness=stiffness,
        mass=ratio(exact(robot.platform.mass)),
        gravity=[ratio(x) for x in problem.loaded.gravity],
        load=[ratio(x) for x in problem.load],
        taut=problem.taut,
        ignore_slack=options.ignore_slack,
        ignore_tension_sign=options.ignore_tension_sign,
        pulleys=pulleys if any(pulleys) else (),
    )


def pulley_of(route: Route) -> Pulley | None:
    """Return a cable's pulley as the checker reads it; None for a straight cable."""
    if not isinstance(route, OverPulley):
        return None
    return Pulley(ratio(route.radius), [ratio(x) for x in route.axis], ratio(route.lead_in))


def ratio(x: Fraction) -> fmpq:
    """Return the same number."""
    return fmpq(x.numerator, x.denominator)


def fraction(x: fmpq) -> Fraction:
    """Return the same number."""
    return Fraction(int(x.p), int(x.q))


def certified(solution: Solution) -> Solution:
    """Return what a certificate claims of a solution.

    That one pose is proved on either side of a switch is no claim of a certificate: there such a cable, and
    whether it is near enough to be slack, is undecided.
    """
    if CableState.SWITCHING not in solution.cable_states:
        return solution
    states = [CableState.UNDECIDED if s is CableState.SWITCHING else s for s in solution.cable_states]
    respected = None if solution.slack_respected else solution.slack_respected
    return replace(solution, cable_states=tuple(states), slack_respected=respected)


def written_states(solution: Solution) -> tuple[str, ...]:
    """Return the states of a solution's cables as a certificate has them."""
    return tuple(map(str, certified(solution).cable_states))


def listed_solution(solution: Solution) -> Listed:
    """Return a solution as the checker reads it from a certificate."""
    solution = certified(solution)
    family = None
    if solution.family is not None:
        f = solution.family
        family = Turning(
            kind=f.kind,
            axis_point=None if f.axis_point is None else pairs(f.axis_point),
            axis_direction=None if f.axis_direction is None else pairs(f.axis_direction),
            angle_ranges=[((a, b), (c, d)) for (a, b), (c, d) in f.angle_ranges.tolist()],
        )
    return Listed(
        taut=solution.taut,
        states=written_states(solution),
        position=pairs(solution.position),
        rotation=[pairs(row) for row in solution.rotation],
        height=pairs(solution.height[None])[0],
        tensions=pairs(solution.tensions),
        distances=pairs(solution.distances),
        slack_respected=solution.slack_respected,
        stability=str(solution.stability),
        family=family,
    )


def pairs(bounds: Bounds) -> list[tuple[float, float]]:
    """Return bounds (n, 2) as pairs."""
    return [(lo, hi) for lo, hi in bounds.tolist()]
