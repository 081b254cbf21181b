"""The certificate of a result as a document: the question in exact numbers, solutions and proofs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from cdpr_interval.engine.budget import Budget
from cdpr_interval.exact.decimals import exact_text
from cdpr_interval.robots.numbers import exact_point
from certificates.problem import FORMAT
from solvers.answers.result import Result
from solvers.answers.tool import this_tool
from solvers.proofs.listed import (
    document_candidates,
    document_solutions,
)
from solvers.proofs.text import robot_document, solution_document, vector
from solvers.questions.problem import Options, Problem

if TYPE_CHECKING:
    from solvers.proofs.claimed import Claimed

Json = dict[str, Any]
NOT_RECORDED = "not recorded"
NO_BOX = "not recorded: no box was proved to hold the pose for all lengths in their ranges"


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
    why = NO_BOX if any(lo < hi for lo, hi in problem.lengths) else NOT_RECORDED
    out += [{"taut": list(s.taut), "reason": why} for s in missing]
    tool = this_tool()
    return {
        "format": FORMAT,
        "tool": {"name": tool.name, "version": tool.version},
        "claim": f"{robot.name}: {result.message}",
        "robot": robot_document(robot),
        "lengths_m": [[exact_text(lo), exact_text(hi)] for lo, hi in problem.lengths],
        "external_force_N": vector(exact_point(problem.external_force)),
        "question": {
            "taut": None if problem.taut is None else list(problem.taut),
            "ignore_slack": options.ignore_slack,
            "ignore_tension_sign": options.ignore_tension_sign,
        },
        "solutions": [solution_document(solutions[k]) for k in backed],
        "subsets": [renumbered(entry, {k: i for i, k in enumerate(backed)}) for entry in entries],
        "not_certified": [*out, *not_certified],
    }


def certificate_of(problem: Problem, options: Options, result: Result) -> tuple[bytes, Claimed]:
    """Return a result's certificate as it is written to a file, and what it claims.

    ``options.record`` holds the searches of the run.
    """
    from certificates.container import pack
    from solvers.proofs.claimed import claimed
    from solvers.proofs.entries import subset_entries

    budget = Budget() if options.record is None else options.record.budget
    # What is proved is written down even when an interrupt comes while it is.
    with budget.listening():
        entries = subset_entries(problem, options, result)
        document = certificate_document(problem, options, result, entries, [])
        return pack(document), claimed(document)


def certificate_bytes(problem: Problem, options: Options, result: Result) -> bytes:
    """Return the first of `certificate_of`."""
    return certificate_of(problem, options, result)[0]


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
