"""Platforms on real cables - over pulleys, elastic, or both: every static pose of every subset of taut cables."""

from __future__ import annotations

import time

from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.engine.search import Report
from cdpr_interval.exact import balls
from solvers.answers.data import Answer, Outcome, StopReason, SubsetReport, Undecided
from solvers.questions.problem import Options, Problem, Progress
from solvers.six_dof.forward import Found, subsets
from solvers.six_dof.merge import distinct
from solvers.six_dof.real.build import model_for
from solvers.six_dof.real.entries import regions, solution_of
from solvers.six_dof.real.subset import RealSearch

NO_POSE = "no static pose: every taut subset is excluded"


def solve(problem: Problem, options: Options) -> Answer:
    """Find and prove every static pose of a platform some of whose cables run over pulleys or stretch.

    Guarantee
    ---------
    With outcome COMPLETE the static poses are exactly those listed, one in each box.
    """
    run = RealRun(problem, options)
    with run.budget.listening(), balls.precision():
        for taut in subsets(problem):
            run.solve_subset(taut)
        return run.answer()


class RealRun:
    """One forward-kinematics run; its subsets share a budget."""

    def __init__(self, problem: Problem, options: Options) -> None:
        self.problem = problem
        self.options = options
        self.budget = Budget(options.time_limit, options.cell_limit)
        self.total = len(subsets(problem))
        self.found: list[tuple[tuple[int, ...], Found, float]] = []
        self.stopped: Stop | None = None

    def solve_subset(self, taut: tuple[int, ...]) -> None:
        """Solve one subset and keep what it gives."""
        started = time.perf_counter()
        found = Found()
        if self.budget.stop() is not None:
            found.pending = 1
        else:
            self.search(taut, found)
        self.found.append((taut, found, time.perf_counter() - started))

    def search(self, taut: tuple[int, ...], found: Found) -> None:
        """Search one subset and turn its roots into solutions."""
        real = model_for(self.problem, taut, slack=not self.options.ignore_slack)
        search = RealSearch(real, self.budget, self.options.threads, self.reporter(found))
        search.solve()
        found.cells += search.cells
        found.pending += search.pending
        if search.stop is not Stop.EXHAUSTED:
            found.pending = max(found.pending, 1)
            self.stopped = search.stop
        for root in distinct(search.roots):
            solution = solution_of(self.problem, self.options, taut, root)
            if isinstance(solution, Undecided):
                found.undecided.append(solution)
            elif solution is not None:
                found.solutions.append(solution)
        if len(search.undecided):
            found.undecided += regions(self.problem, taut, search.undecided, search.reason)

    def reporter(self, found: Found) -> Report | None:
        """Return the callback that turns a search's state into a ``Progress``."""
        tell = self.options.progress
        if tell is None:
            return None
        done = sum(f.cells for _, f, _ in self.found)
        proved = sum(len(f.solutions) for _, f, _ in self.found)

        def report(cells: int, pending: int, volume: float) -> None:
            solutions = proved + len(found.solutions)
            tell(
                Progress(done + found.cells + cells, pending, volume, solutions, len(self.found), self.total)
            )

        return report

    def answer(self) -> Answer:
        """Assemble what all subsets gave."""
        stop = self.budget.stop() or self.stopped
        pending = sum(f.pending for _, f, _ in self.found)
        solutions = [s for _, f, _ in self.found for s in f.solutions]
        undecided = [u for _, f, _ in self.found for u in f.undecided]
        reason = StopReason(stop.value) if stop is not None and pending else StopReason.EXHAUSTED
        nothing = not (solutions or undecided or pending)
        return Answer(
            solutions=tuple(solutions),
            undecided=tuple(undecided),
            pending=pending,
            subsets=tuple(report_of(*entry) for entry in self.found),
            stop_reason=reason,
            cells=sum(f.cells for _, f, _ in self.found),
            message=NO_POSE if nothing else "",
        )


def report_of(taut: tuple[int, ...], found: Found, seconds: float) -> SubsetReport:
    """Return a subset's line in the result."""
    complete = not (found.pending or found.undecided) and all(s.is_decided for s in found.solutions)
    outcome = Outcome.COMPLETE if complete else Outcome.INCOMPLETE
    return SubsetReport(taut, outcome, len(found.solutions), found.cells, seconds)
