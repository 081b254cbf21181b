"""Branch and prune over the positions of a point mass, one search for every subset of taut cables.

Every cell is excluded (a cable too short or too long, no tensions >= 0 in balance, a gradient that does not
vanish), settled by a proved root whose domain of uniqueness holds all that can balance in the cell, or
left small. What is left open by rounding (a cable just taut or just slack) is decided, or reported as
undecided, by the convexity argument.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.engine.search import Report, Run, search
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.kernels.box import contains
from solvers.answers.data import Answer, Outcome, Proof, Solution, StopReason, SubsetReport, Undecided
from solvers.point_mass.alone import Claim, complete_claim, exact_pose_of, merged_solutions, subset_claim
from solvers.point_mass.answer import answer_pose, answer_without_pose, subset_count, subsets
from solvers.point_mass.arrays import Cables, RobotArrays, exact_lengths, select
from solvers.point_mass.balance import all_cables
from solvers.point_mass.cell_rows import WIDTH
from solvers.point_mass.cells import PROVED, run_cells, settle
from solvers.point_mass.convex import find_pose, scaled_cables
from solvers.point_mass.entry import Fields, fields_of
from solvers.point_mass.fields import TAUT
from solvers.point_mass.one_call import anywhere, tension_bounds
from solvers.point_mass.scope import most_taut
from solvers.point_mass.switching import dependent
from solvers.point_mass.system import krawczyk
from solvers.point_mass.trap import low_point, start_box
from solvers.questions.problem import Options, Problem, Progress

ATTEMPT = 1.0 / 16.0
"""Existence is tried in cells below this fraction of the start box: a Newton test costs ten cells."""
SMALLEST = 1e-7
"""Smallest cell as a fraction of the start box: measured on two balls that overlap by g, the cells grow like
g^-1/2, 28 000 at 1e-7 and 680 000 at 1e-9; what stays small is settled by convexity."""


@dataclass(frozen=True, eq=False)
class Root:
    """A proved zero of the square system of a subset."""

    zero: Bounds
    """(3 + m, 2) enclosure of pose and multipliers."""
    domain: Bounds
    """The box in which it is the only zero."""


@dataclass(frozen=True, eq=False)
class SubsetSearch:
    """What the search of one subset left."""

    taut: tuple[int, ...]
    roots: list[Root]
    small: int
    pending: int
    cells: int
    seconds: float
    stop: Stop


def search_subsets(problem: Problem, options: Options, arrays: RobotArrays, lengths: Bounds) -> Answer:
    """Return every static pose of what was asked by searching all subsets of taut cables."""
    count, largest = len(problem.robot.cables), most_taut(problem.robot)
    total = subset_count(count, largest) if problem.taut is None else 1
    wanted = subsets(count, largest) if problem.taut is None else iter((problem.taut,))
    budget = Budget(options.time_limit, options.cell_limit)
    searched: list[SubsetSearch] = []
    solutions = 0
    with budget.listening():
        for taut in wanted:
            if budget.stop() is not None:
                break
            report = _progress(options, budget, len(searched), total, solutions)
            one = _search_one(problem, options, arrays, lengths, taut, budget, report)
            searched.append(one)
            solutions += len(one.roots)
    return _collect(problem, options, arrays, lengths, searched, total, budget)


def _progress(options: Options, budget: Budget, done: int, total: int, solutions: int) -> Report | None:
    tell: Callable[[Progress], None] | None = options.progress
    if tell is None:
        return None

    def report(cells: int, pending: int, volume: float) -> None:
        tell(Progress(budget.cells, pending, volume, solutions, done, total))

    return report


def _search_one(
    problem: Problem,
    options: Options,
    arrays: RobotArrays,
    lengths: Bounds,
    taut: tuple[int, ...],
    budget: Budget,
    report: Report | None,
) -> SubsetSearch:
    """Search the positions at which exactly the cables ``taut`` carry the load."""
    start = time.perf_counter()
    everything = scaled_cables(arrays, lengths)
    cables = select(everything, taut)
    rest = () if options.ignore_slack else tuple(i for i in range(len(lengths)) if i not in taut)
    others = select(everything, rest)
    if not arrays.is_elastic and dependent(arrays.exits, taut, arrays.load_exact):
        # No independent multipliers: such poses are those of smaller subsets, or convexity finds them.
        left = 0 if problem.taut is None else 1
        return SubsetSearch(taut, [], left, 0, 0, time.perf_counter() - start, Stop.EXHAUSTED)
    box = start_box(cables, arrays.load) if arrays.is_elastic else _reach(cables)
    width = float((box[:, 1] - box[:, 0]).max())
    if not (box[:, 0] <= box[:, 1]).all():
        return SubsetSearch(taut, [], 0, 0, 0, time.perf_counter() - start, Stop.EXHAUSTED)
    spread = float((cables[2][:, 1] - cables[2][:, 0]).max())
    limits = np.array([ATTEMPT * width, max(SMALLEST * width, 0.25 * spread)])
    context = (cables, others, arrays.load, limits, True, *low_point(cables, arrays.load))

    def make_run() -> Run:
        return lambda stack, count, leaves, kinds, children, limit: run_cells(
            context, stack, count, leaves, kinds, children, limit
        )

    first = np.array([[*box.ravel(), 1.0]])
    found = search(make_run, first, budget, threads=options.threads, report=report)
    roots: list[Root] = []
    small = 0
    for leaf, kind in zip(found.leaves, found.kinds, strict=True):
        root = _root_of(cables, arrays.load, leaf) if kind == PROVED else None
        if root is None:
            small += 1
        elif not any(_same(root, known) for known in roots):
            roots.append(root)
    seconds = time.perf_counter() - start
    return SubsetSearch(taut, roots, small, len(found.pending), found.cells, seconds, found.stop)


def _reach(cables: Cables) -> Bounds:
    """Intersect the boxes around the balls of inextensible cables."""
    _, exits, lengths, _, _ = cables
    longest = lengths[:, 1:]
    low = np.nextafter(exits[:, :, 0] - longest, -np.inf).max(axis=0)
    high = np.nextafter(exits[:, :, 1] + longest, np.inf).min(axis=0)
    return np.column_stack([low, high])


def _root_of(cables: Cables, load: Bounds, leaf: Bounds) -> Root | None:
    """Repeat the proof of a leaf and enclose its root to the float limit."""
    box = np.ascontiguousarray(leaf[: WIDTH - 1].reshape(3, 2))
    m = len(cables[2])
    n = 3 + m
    x, zero, domain = np.empty(n), np.empty((n, 2)), np.empty((n, 2))
    if not settle(cables, load, box, x, zero, domain):
        return None
    narrow, inner = np.empty((n, 2)), np.empty((n, 2))
    x = zero.mean(axis=1)
    if krawczyk(cables, load, all_cables(m), m, x, anywhere(n), narrow, inner) and contains(
        domain, narrow, n
    ):
        zero = np.column_stack([np.maximum(zero[:, 0], narrow[:, 0]), np.minimum(zero[:, 1], narrow[:, 1])])
    return Root(zero, domain)


def _same(a: Root, b: Root) -> bool:
    """Return True when one root lies where the other is unique."""
    n = len(a.zero)
    return bool(contains(a.domain, b.zero, n) or contains(b.domain, a.zero, n))


def _claim(
    problem: Problem, arrays: RobotArrays, lengths: Bounds, taut: tuple[int, ...], root: Root, alone: bool
) -> Claim | bool:
    """Return the claim of a root; False when it is no pose (a tension is not positive), True when open.

    Signs are decided exactly only where subsets are looked at ``alone``: a pose of the whole robot at which
    a cable is just taut is reported as such, as the convexity path does.
    """
    everything = scaled_cables(arrays, lengths)
    cables = select(everything, taut)
    m = len(taut)
    zero = root.zero
    tension = np.zeros((m, 2))
    if (zero[3:, 1] <= 0.0).any():
        return False
    if not (zero[3:, 0] > 0.0).all():
        return True
    tension_bounds(cables, all_cables(m), m, zero, tension)
    states = np.full(m, TAUT, dtype=np.int64)
    own = fields_of(cables, arrays.frame, np.ascontiguousarray(zero[:3]), tension, states)
    return complete_claim(
        problem, arrays, lengths, taut, own, exact_pose_of(problem, taut) if alone else None
    )


def _collect(
    problem: Problem,
    options: Options,
    arrays: RobotArrays,
    lengths: Bounds,
    searched: Sequence[SubsetSearch],
    total: int,
    budget: Budget,
) -> Answer:
    """Turn the roots of all subsets into the answer."""
    claims: list[Claim] = []
    undecided: list[Undecided] = []
    reports: list[SubsetReport] = []
    doubtful = False
    for one in searched:
        own: list[Claim] = []
        is_open = one.small > 0
        for root in one.roots:
            claim = _claim(problem, arrays, lengths, one.taut, root, options.ignore_slack)
            if isinstance(claim, Claim):
                if options.ignore_slack or claim.slack_respected is True:
                    own.append(claim)
                elif claim.slack_respected is None:
                    is_open = True
            elif claim:
                is_open = True
        outcome = Outcome.COMPLETE
        if len(own) > 1 or (is_open and options.ignore_slack):
            settled = subset_claim(problem, arrays, lengths, one.taut)
            own = [settled] if isinstance(settled, Claim) else []
            if isinstance(settled, Undecided):
                undecided.append(settled)
            if isinstance(settled, Undecided) or any(claim.fields.is_open for claim in own):
                outcome = Outcome.INCOMPLETE
        elif is_open:
            doubtful = True
            outcome = Outcome.INCOMPLETE
        if one.pending:
            outcome = Outcome.INCOMPLETE
        claims += own
        reports.append(SubsetReport(one.taut, outcome, len(own), one.cells, one.seconds))
    stop = budget.stop() or Stop.INTERRUPTED
    pending = sum(one.pending for one in searched) + total - len(searched)
    answer = Answer(
        tuple(merged_solutions(problem, claims, Proof.INTERVAL_NEWTON)),
        tuple(undecided),
        pending=pending,
        subsets=tuple(reports),
        stop_reason=StopReason(stop.value) if pending else StopReason.EXHAUSTED,
        cells=sum(one.cells for one in searched),
    )
    if options.ignore_slack or (claims and not doubtful):
        return answer
    return _by_convexity(problem, arrays, lengths, answer, doubtful)


def _by_convexity(
    problem: Problem, arrays: RobotArrays, lengths: Bounds, answer: Answer, doubtful: bool
) -> Answer:
    """Settle what the search left open (or say why there is nothing) with the only pose of the robot."""
    finding = find_pose(arrays, lengths, exact_lengths(problem))
    if isinstance(finding, Fields):
        settled = answer_pose(problem, arrays, finding)
    else:
        settled = answer_without_pose(problem, arrays, finding)
    if not doubtful:
        if settled.solutions and not answer.pending:
            # The two proofs contradict each other: report the region instead of either.
            taut = settled.solutions[0].taut
            region = Undecided(
                taut,
                1,
                "search and convexity disagree",
                settled.solutions[0].position,
                settled.solutions[0].rotation,
            )
            return _with(answer, (), (region,), "")
        return _with(answer, answer.solutions, answer.undecided, settled.message)
    return _with(answer, settled.solutions, settled.undecided, settled.message)


def _with(
    answer: Answer, solutions: tuple[Solution, ...], undecided: tuple[Undecided, ...], message: str
) -> Answer:
    """Return the answer with other entries; a subset is open only where an entry is."""
    reports = answer.subsets
    closed = not undecided and all(s.slack_respected is not None for s in solutions)
    if closed and not answer.pending:
        found = {s.taut for s in solutions}
        reports = tuple(
            replace(row, outcome=Outcome.COMPLETE, solutions=int(row.taut in found)) for row in reports
        )
    return replace(answer, solutions=solutions, undecided=undecided, message=message, subsets=reports)
