"""The certificate's entries: for each subset of taut cables the proof that its poses are those listed."""

from __future__ import annotations

from typing import Any

from certificates.subsets import Kind, classify, examined
from solvers.certificate import document_solutions
from solvers.certificate_point import certificate_question, point_entry
from solvers.problem import Options, Problem
from solvers.result import Result

Json = dict[str, Any]
NOT_RECORDED = "not recorded"


def subset_entries(problem: Problem, options: Options, result: Result, record: Any) -> list[Json]:
    """Return one entry for each subset to be examined, in order."""
    question = certificate_question(problem, options)
    solutions = document_solutions(problem, result)
    entries = []
    for taut in examined(question):
        kind = None if question.is_point_mass else classify(question, taut)
        found: Json = {"pending": NOT_RECORDED}
        if kind in (None, Kind.FREE, Kind.ONE_POINT):
            found = point_entry(problem, options, taut, solutions)
            found = found if "pending" in found else {"point": found}
        elif kind is Kind.DEPENDENT and problem.taut is None:
            found = {}
        entries.append({"taut": list(taut), **found})
    return entries
