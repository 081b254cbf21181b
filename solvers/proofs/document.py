"""The certificate of a result as a document: the question in exact numbers, solutions and proofs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.robots.cable_robot import Robot, exact, exact_point
from certificates.apart import meeting
from certificates.problem import FORMAT
from solvers.answers.data import Family, Solution
from solvers.answers.result import Result
from solvers.answers.tool import this_tool
from solvers.proofs.point import certificate_question, certified, listed_solution, widened, written_states
from solvers.questions.problem import Options, Problem

Json = dict[str, Any]
LONGEST_DECIMAL = 40
"""Numbers with more digits are written as p/q."""
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


def certificate_document(
    problem: Problem,
    options: Options,
    result: Result,
    entries: Sequence[Json],
    not_certified: Iterable[Json] = (),
) -> Json:
    """Return the document of a certificate.

    Parameters
    ----------
    problem, options, result
        The question and its answer.
    entries
        One for each subset to be examined; solutions are named by their places in `document_solutions`.
        Those that no entry names are left out, and said to be not certified.
    not_certified
        What else is to be listed there.
    """
    robot = problem.robot
    solutions = document_solutions(problem, result)
    backed = sorted({k for entry in entries for k in named(entry)})
    left = [(s.taut, reason) for s, reason in document_candidates(problem, result)]
    out = [{"taut": list(taut), "reason": reason} for taut, reason in left if reason is not None]
    missing = [s for k, s in enumerate(solutions) if k not in backed]
    out += [{"taut": list(s.taut), "reason": "not recorded"} for s in missing]
    tool = this_tool()
    return {
        "format": FORMAT,
        "tool": {"name": tool.name, "version": tool.version},
        "claim": f"{robot.name}: {result.message}",
        "robot": robot_document(robot),
        "lengths_m": [[exact_text(lo), exact_text(hi)] for lo, hi in problem.lengths],
        "external_force_N": vector(problem.external_force),
        "question": {
            "taut": None if problem.taut is None else list(problem.taut),
            "ignore_slack": options.ignore_slack,
            "ignore_tension_sign": options.ignore_tension_sign,
        },
        "solutions": [solution_document(solutions[k]) for k in backed],
        "subsets": [renumbered(entry, {k: i for i, k in enumerate(backed)}) for entry in entries],
        "not_certified": [*out, *not_certified],
    }


def certificate_bytes(problem: Problem, options: Options, result: Result) -> bytes:
    """Return a result's certificate as it is written to a file; ``options.record`` holds its searches."""
    from certificates.container import pack
    from solvers.proofs.entries import subset_entries

    entries = subset_entries(problem, options, result)
    return pack(certificate_document(problem, options, result, entries, []))


def named(entry: Json) -> set[int]:
    """Return the solutions that an entry names."""
    poses = list(entry.get("point", {}).get("poses", []))
    poses += [root["pose"] for search in entry.get("searches", []) for root in search["roots"]]
    return {k for k in poses if k is not None}


def renumbered(entry: Json, places: dict[int | None, int]) -> Json:
    """Return an entry with other numbers of solutions."""
    changed = dict(entry)
    if "point" in entry:
        changed["point"] = {**entry["point"], "poses": [places.get(k) for k in entry["point"]["poses"]]}
    if "searches" in entry:
        changed["searches"] = [
            {**search, "roots": [{**root, "pose": places.get(root["pose"])} for root in search["roots"]]}
            for search in entry["searches"]
        ]
    return changed


def robot_document(robot: Robot) -> Json:
    """Return the robot in exact numbers."""
    cables = []
    for cable in robot.cables:
        document: Json = {
            "name": cable.name,
            "frame_anchor_m": vector(exact_point(cable.frame_anchor)),
            "platform_anchor_m": vector(exact_point(cable.platform_anchor)),
        }
        if cable.elasticity is not None:
            for key, value in (
                ("stiffness_N_per_m", cable.elasticity.stiffness),
                ("axial_stiffness_N", cable.elasticity.axial_stiffness),
            ):
                if value is not None:
                    document[key] = exact_text(exact(value))
        cables.append(document)
    return {
        "name": robot.name,
        "sha256": robot.sha256,
        "gravity_m_s2": vector(exact_point(robot.gravity)),
        "mass_kg": exact_text(exact(robot.platform.mass)),
        "centre_of_mass_m": vector(exact_point(robot.platform.centre_of_mass)),
        "cables": cables,
    }


def solution_document(solution: Solution) -> Json:
    """Return a solution with its bounds as exact doubles."""
    solution = certified(solution)
    return {
        "taut": list(solution.taut),
        "states": list(written_states(solution)),
        "position_m": doubles(solution.position),
        "rotation": doubles(solution.rotation),
        "height_m": doubles(solution.height),
        "tensions_N": doubles(solution.tensions),
        "distances_m": doubles(solution.distances),
        "slack_respected": solution.slack_respected,
        "stability": str(solution.stability),
        "family": None if solution.family is None else family_document(solution.family),
    }


def family_document(family: Family) -> Json:
    """Return a family with its bounds as exact doubles."""
    return {
        "kind": family.kind,
        "axis_point_m": None if family.axis_point is None else doubles(family.axis_point),
        "axis_direction": None if family.axis_direction is None else doubles(family.axis_direction),
        "angle_ranges_rad": doubles(family.angle_ranges),
    }


def doubles(bounds: Bounds) -> Any:
    """Return nested lists of hexadecimal numbers."""
    return hexadecimal(np.asarray(bounds, dtype=np.float64).tolist())


def hexadecimal(value: Any) -> Any:
    """Return floats in nested lists as text."""
    return [hexadecimal(v) for v in value] if isinstance(value, list) else value.hex()


def vector(values: Iterable[Fraction]) -> list[str]:
    """Return exact numbers as text."""
    return [exact_text(x) for x in values]


def exact_text(x: Fraction) -> str:
    """Return a finite decimal where it is a short one, else p/q."""
    twos, rest = 0, x.denominator
    while rest % 2 == 0:
        twos, rest = twos + 1, rest // 2
    fives = 0
    while rest % 5 == 0:
        fives, rest = fives + 1, rest // 5
    places = max(twos, fives)
    digits = str(abs(x.numerator) * 10**places // x.denominator).rjust(places + 1, "0") if rest == 1 else ""
    if rest != 1 or len(digits) > LONGEST_DECIMAL:
        return str(x)
    sign = "-" if x < 0 else ""
    return sign + (f"{digits[:-places]}.{digits[-places:]}" if places else digits)
