"""Forward kinematics of a point mass on routed cables: every pose, and what a result says of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from cdpr_interval.engine.budget import Budget
from cdpr_interval.engine.search import Report
from cdpr_interval.exact.enclosure import length_bounds
from cdpr_interval.mechanics.stability import Stability
from solvers.answers.data import Answer, Family, Outcome, Proof, Solution, StopReason, SubsetReport, Undecided
from solvers.point_mass.answer import MOST_ROWS, subset_count, subsets
from solvers.point_mass.entry import IDENTITY, Fields, solution
from solvers.point_mass.scope import most_taut
from solvers.questions.checked import require_treated
from solvers.questions.problem import Method, Options, Problem, Progress
from solvers.routed_mass.data import routed_mass
from solvers.routed_mass.over_ranges import find_all
from solvers.routed_mass.pose import Effort, Found

NO_POSE = "no position is in reach of all cables at which they balance the load"
NOT_ASKED = "the robot has other cables taut than those asked for at every pose"


def solve_routed(problem: Problem, options: Options) -> Answer:
    """Return every static pose of a point mass on routed cables.

    Raises
    ------
    NotSupportedError
        With ``ignore_slack``, and for the method of search for straight cables.

    Guarantee
    ---------
    That of `solvers.classes.RobotClass.forward`.
    """
    require_treated(problem.robot, _refused(options))
    effort = Effort.of(options.time_limit, options.cell_limit)
    effort = replace(effort, threads=options.threads, report=_report(options, effort.budget))
    with effort.budget.listening():
        found = find_all(routed_mass(problem.loaded), length_bounds(problem.lengths), effort)
    return _answer(problem, found)


def _refused(options: Options) -> str | None:
    if options.ignore_slack:
        return "--ignore-slack is not supported with pulleys or with cables of two kinds yet"
    if options.method is Method.SEARCH:
        return "--method search is for straight cables that all stretch or all do not"
    return None


def _report(options: Options, budget: Budget) -> Report | None:
    tell: Callable[[Progress], None] | None = options.progress
    if tell is None:
        return None

    def report(cells: int, pending: int, volume: float) -> None:
        tell(Progress(budget.cells, pending, volume, 0, 0, 1))

    return report


def _answer(problem: Problem, found: Found) -> Answer:
    asked = problem.taut
    families = found.families + (None,) * (len(found.poses) - len(found.families))
    kept = [
        (fields, stability, family)
        for fields, stability, family in zip(found.poses, found.stability, families, strict=True)
        if asked is None or set(fields.taut) <= set(asked) <= set(fields.not_slack)
    ]
    entries = tuple(_entry(*one, found.by_convexity) for one in kept)
    everything = tuple(range(len(problem.robot.cables)))
    regions = tuple(
        Undecided(asked or everything, 1, region.reason, region.position, IDENTITY, (0, 1))
        for region in found.regions
    )
    message = ""
    if not entries and found.complete:
        message = NOT_ASKED if found.poses else NO_POSE
    return Answer(
        entries,
        regions,
        pending=found.pending,
        subsets=_rows(problem, found, [fields for fields, _, _ in kept]),
        stop_reason=StopReason(found.stop.value) if found.pending else StopReason.EXHAUSTED,
        cells=found.cells,
        message=message,
    )


def _entry(fields: Fields, stability: Stability, family: Family | None, by_convexity: bool) -> Solution:
    proof = Proof.CONVEXITY if by_convexity else Proof.INTERVAL_NEWTON if family is None else Proof.FAMILY
    entry = solution(fields, None if fields.is_open else True, proof)
    return replace(entry, stability=stability, family=family)


def _rows(problem: Problem, found: Found, kept: list[Fields]) -> tuple[SubsetReport, ...]:
    """Return one row per subset of cables: a claim made for all of them at once."""
    count, largest = len(problem.robot.cables), most_taut(problem.robot)
    if problem.taut is not None:
        listed = [problem.taut]
    elif subset_count(count, largest) <= MOST_ROWS:
        listed = list(subsets(count, largest))
    else:
        listed = sorted({fields.not_slack for fields in kept}, key=lambda taut: (len(taut), taut))
    rows, given = [], set[int]()
    for taut in listed:
        own = [i for i, f in enumerate(kept) if set(f.taut) <= set(taut) <= set(f.not_slack)]
        fresh = [i for i in own if i not in given]
        given.update(fresh)
        is_open = not found.complete or any(kept[i].is_open for i in own)
        rows.append(
            SubsetReport(taut, Outcome.INCOMPLETE if is_open else Outcome.COMPLETE, len(fresh), 0, 0.0)
        )
    return tuple(rows)
