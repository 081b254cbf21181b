"""A certificate's entries: for every taut subset what proves that all its poses are listed."""

from __future__ import annotations

from typing import Any

from flint import ctx

from certificates.balls import BITS
from certificates.problem import Listed
from certificates.problem import Problem as Question
from certificates.subsets import Kind, classify, examined
from solvers.answers.result import Result, Solution
from solvers.proofs.document import document_solutions
from solvers.proofs.point import certificate_question, listed_solution, point_entry
from solvers.questions.problem import Options, Problem

Json = dict[str, Any]
NOT_SEARCHED = "not searched"


def subset_entries(problem: Problem, options: Options, result: Result) -> list[Json]:
    """Return the entries of all subsets to be examined, in order.

    Searches are those that ``options.record`` kept; places of solutions are those of `document_solutions`.
    What the checker would refuse is written as pending or undecided.
    """
    question = certificate_question(problem, options)
    solutions = document_solutions(problem, result)
    listed = [listed_solution(s) for s in solutions]
    with ctx.workprec(BITS):
        return [
            {"taut": list(taut), **entry(problem, options, question, taut, listed, solutions)}
            for taut in examined(question)
        ]


def entry(
    problem: Problem,
    options: Options,
    question: Question,
    taut: tuple[int, ...],
    listed: list[Listed],
    solutions: list[Solution],
) -> Json:
    """Return what proves one subset."""
    kind = None if question.is_point_mass else classify(question, taut)
    if kind in (None, Kind.FREE, Kind.ONE_POINT):
        found = point_entry(problem, options, taut, solutions)
        return found if "pending" in found else {"point": found}
    if kind is Kind.DEPENDENT:
        return {} if problem.taut is None else {"pending": "the wrenches are dependent in every pose"}
    if kind is Kind.BOTH:
        return {"pending": "families about two axes are not certified"}
    searched = () if options.record is None else options.record.searches.get(taut, ())
    from solvers.proofs.searches import search_entries

    assert kind is not None
    entries = search_entries(question, taut, kind, searched, listed, options.record.budget, options.threads)
    return {"pending": NOT_SEARCHED} if entries is None else {"searches": entries}
