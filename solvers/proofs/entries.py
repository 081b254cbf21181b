"""A certificate's entries: for every taut subset what proves that all its poses are listed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flint import ctx

from cdpr_interval.engine.budget import Budget
from cdpr_interval.exact import balls
from certificates.arithmetic.balls import BITS
from certificates.problem import Listed
from certificates.problem import Problem as Question
from certificates.subsets import Kind, classify, examined
from solvers.answers.data import Solution
from solvers.answers.result import Result
from solvers.point_mass import scope as point_mass
from solvers.proofs.account import Account
from solvers.proofs.allowance import Allowance
from solvers.proofs.listed import certificate_question, document_solutions, listed_solution
from solvers.proofs.point import point_entry
from solvers.questions.problem import Options, Problem

if TYPE_CHECKING:
    from solvers.proofs.recorder import Recorder
    from solvers.proofs.routed import RoutedRecorder

Json = dict[str, Any]
Started = Json | list["Recorder"] | list["RoutedRecorder"]
"""A subset's entry, or the recorders that will make it."""
NOT_SEARCHED = "not searched"
NOT_WRITTEN = "the run ended before a proof was written"


def subset_entries(problem: Problem, options: Options, result: Result) -> list[Json]:
    """Return the entries of all subsets to be examined, in order.

    Searches are those that ``options.record`` kept; places of solutions are those of `document_solutions`.
    What the checker would refuse is written as pending or undecided, and so is what the run's budget does not
    suffice for: poses that were found come first, then the trees that prove that there are no others.
    """
    question = certificate_question(problem, options)
    solutions = document_solutions(problem, result)
    listed = [listed_solution(s) for s in solutions]
    allowance = Allowance(Budget() if options.record is None else options.record.budget)
    subsets = list(examined(question))
    cells = {subset.taut: subset.cells for subset in result.subsets}
    account = Account(options.progress, allowance.budget, [1 + cells.get(taut, 0) for taut in subsets])
    with ctx.workprec(BITS), balls.precision():
        found = []
        for taut in subsets:
            started: Started = {"pending": NOT_WRITTEN}
            if not allowance.is_spent:
                with allowance.spending():
                    account.step(0.0)
                    started = start(problem, options, question, taut, listed, solutions)
            if not isinstance(started, dict):
                for recorder in started:
                    recorder.claim_roots(allowance, account)
            found.append((taut, started))
        entries: list[Json] = []
        for taut, started in found:
            with allowance.spending():
                account.subset(len(entries))
            entries.append({"taut": list(taut), **ended(started, options, allowance, account)})
        return entries


def start(
    problem: Problem,
    options: Options,
    question: Question,
    taut: tuple[int, ...],
    listed: list[Listed],
    solutions: list[Solution],
) -> Started:
    """Return what proves one subset, or the recorders of its searches."""
    kind = None if point_mass.accepts(problem.robot) else classify(question, taut)
    if kind in (None, Kind.FREE, Kind.ONE_POINT):
        found = point_entry(problem, options, taut, solutions)
        return found if "pending" in found else {"point": found}
    if kind is Kind.DEPENDENT:
        return {} if problem.taut is None else {"pending": "the wrenches are dependent in every pose"}
    if kind is Kind.BOTH:
        return {"pending": "families about two axes are not certified"}
    if question.is_routed:
        if options.record is None or taut not in options.record.roots:
            return {"pending": NOT_SEARCHED}
        from solvers.proofs.routed import RoutedRecorder

        return [RoutedRecorder(question, taut, options.record.roots[taut], listed)]
    searched = () if options.record is None else options.record.searches.get(taut, ())
    if not searched:
        return {"pending": NOT_SEARCHED}
    from solvers.proofs.searches import recorders

    assert kind is not None
    return recorders(question, taut, kind, searched, listed) or {"pending": NOT_SEARCHED}


def ended(started: Started, options: Options, allowance: Allowance, account: Account) -> Json:
    """Return a subset's entry, its searches completed as far as the allowance goes."""
    if isinstance(started, dict):
        return started
    for recorder in started:
        recorder.complete(allowance, account, options.threads)
    return {"searches": [recorder.entry() for recorder in started]}
