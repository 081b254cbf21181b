"""Six-dof platforms on inextensible cables: every static pose of every subset of taut cables."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations

from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.engine.search import Report
from cdpr_interval.exact import balls
from cdpr_interval.mechanics.six_dof.families import Classification, Kind
from cdpr_interval.mechanics.six_dof.frame import Pose
from solvers.answers.data import Answer, CableState, Outcome, Solution, StopReason, SubsetReport, Undecided
from solvers.questions.problem import Options, Problem, Progress
from solvers.six_dof.cells.halves import cut_lengths
from solvers.six_dof.cells.merge import distinct, one_of_each_torus
from solvers.six_dof.cells.own_tubes import add_own_tubes
from solvers.six_dof.cells.roots import Root, lies_in, pose_of
from solvers.six_dof.cells.subset_search import SubsetSearch
from solvers.six_dof.clusters import anywhere, clusters
from solvers.six_dof.families_point import point_solution, poses_at
from solvers.six_dof.hanging import hangs_by_centre
from solvers.six_dof.open_entries import open_cables, settle
from solvers.six_dof.parts import put_together
from solvers.six_dof.prepared import cables_of, kind_of, lengths_of
from solvers.six_dof.reach import reach_message
from solvers.six_dof.reduction import Reduced, reduced_problems
from solvers.six_dof.solution import (
    decided_solutions,
    fields_of,
    multiply_tensions,
    origin,
    pose_solution,
    solve_densities,
)
from solvers.six_dof.switching import Searched, with_switching
from solvers.six_dof.tube_report import tube_fields
from solvers.six_dof.turning import (
    Axis,
    FamilyEnd,
    axes_of,
    free_turning_solution,
    torus_solutions,
    turning_solutions,
)

MOST_TAUT = 6
"""Any equilibrium is one of a subset with independent wrenches (Caratheodory); R^6 has at most six."""

UNCERTAIN_REASON = "these cables have a family of poses for some choices of the data, and none for others"
DEPENDENT_REASON = "the wrenches of these cables are dependent in every pose: ask for fewer taut cables"


def solve(problem: Problem, options: Options) -> Answer:
    """Find and prove every static pose of a six-dof platform.

    Returns
    -------
    Answer
        Solutions of all subsets (or of ``problem.taut``); what could be neither proved nor
        excluded is in ``undecided``, what was not looked at in ``pending``.

    Guarantee
    ---------
    With outcome COMPLETE, for every choice of lengths in their ranges the static poses are
    exactly those listed, one in each box (a family counts as one entry).
    """
    run = Run(problem, options)
    with run.budget.listening(), balls.precision():
        for taut in subsets(problem):
            run.solve_subset(taut)
    return run.answer()


def subsets(problem: Problem) -> list[tuple[int, ...]]:
    """Return the taut subsets to examine, smallest first: families must be known before their ends."""
    if problem.taut is not None:
        return [problem.taut]
    count = len(problem.robot.cables)
    sizes = range(1, min(MOST_TAUT, count) + 1)
    return [taut for size in sizes for taut in combinations(range(count), size)]


@dataclass
class Found:
    """What one subset contributed."""

    solutions: list[Solution] = field(default_factory=list)
    undecided: list[Undecided] = field(default_factory=list)
    pending: int = 0
    cells: int = 0


class Run:
    """One forward-kinematics run: the subsets share a budget, and families are remembered by their ends."""

    def __init__(self, problem: Problem, options: Options) -> None:
        self.problem = problem
        self.options = options
        self.budget = Budget(options.time_limit, options.cell_limit)
        if options.record is not None:
            options.record.budget = self.budget
        self.total = len(subsets(problem))
        self.found: list[tuple[tuple[int, ...], Found, float]] = []
        self.stopped: Stop | None = None
        """Why a search ended early, here or elsewhere."""
        self.ends: list[FamilyEnd] = []
        self.ends_known = problem.taut is None
        """Smaller subsets come first; of one subset alone the parts are solved when they are needed."""
        self.robot = problem.loaded
        self.lengths = lengths_of(problem)
        self.searched: list[Searched] = []
        """What was searched over ranges of lengths."""

    def solve_subset(self, taut: tuple[int, ...]) -> None:
        """Solve one subset and keep what it gives."""
        started = time.perf_counter()
        found = Found()
        if self.budget.stop() is not None:
            found.pending = 1
        else:
            self.examine(taut, found)
        self.found.append((taut, found, time.perf_counter() - started))

    def remember_ends(self, taut: tuple[int, ...]) -> None:
        """Solve the families one cable smaller, when only one subset is asked for.

        Their ends are its roots with a tension of exactly zero.
        """
        self.ends_known = True
        for missing in taut:
            part = tuple(i for i in taut if i != missing)
            if not part:
                continue
            kind = kind_of(self.robot, part)
            if kind.kind is Kind.ONE_POINT or (kind.kind is Kind.PLANE and (kind.vertical or kind.rod)):
                self.examine(part, Found())

    def examine(self, taut: tuple[int, ...], found: Found) -> None:
        """Dispatch on the kind of the subset."""
        kind = kind_of(self.robot, taut)
        if kind.kind is Kind.UNCERTAIN:
            found.undecided.append(anywhere(self.problem, taut, UNCERTAIN_REASON))
            return
        if kind.kind is Kind.DEPENDENT:
            # Smaller subsets hold all its poses; asked for alone, it has no isolated tensions to prove.
            if self.problem.taut is not None:
                found.undecided.append(anywhere(self.problem, taut, DEPENDENT_REASON))
            return
        if kind.kind in (Kind.ONE_POINT, Kind.FREE_TURNING):
            self.examine_point(taut, kind, found)
            return
        for frame, reduced in enumerate(reduced_problems(self.robot, self.lengths, self.options, taut)):
            self.search(taut, kind, frame, reduced, found)

    def examine_point(self, taut: tuple[int, ...], kind: Classification, found: Found) -> None:
        """Families (c) and (d)."""
        at = point_solution(self.problem, self.options, taut)
        if at is None:
            return
        if isinstance(at, str):
            found.undecided.append(anywhere(self.problem, taut, at))
            return
        for pose in poses_at(self.problem, taut, at):
            if kind.kind is Kind.FREE_TURNING:
                free = free_turning_solution(self.problem, self.options, taut, pose)
                found.solutions += [] if free is None else [free]
            else:
                self.add_turning(taut, pose, axes_of(self.problem, taut, kind, pose)[0], found)

    def add_turning(self, taut: tuple[int, ...], pose: Pose, axis: Axis, found: Found) -> None:
        """Add a one-axis family and remember its ends."""
        solutions, ends = turning_solutions(self.problem, self.options, taut, pose, axis)
        found.solutions += solutions
        self.ends += ends

    def search(
        self, taut: tuple[int, ...], kind: Classification, frame: int, reduced: Reduced, found: Found
    ) -> None:
        """Search one reduced problem, or take what was found elsewhere, and turn its roots into solutions."""
        record = self.options.record
        observer = None if record is None else record.observer()
        subset = SubsetSearch(
            reduced.model,
            reduced.reduction,
            self.budget,
            self.options.threads,
            self.reporter(found),
            observer,
        )
        coarse = subset.undecided
        parts = None if self.options.parts is None else self.options.parts.get((taut, frame))
        if parts is None:
            subset.solve()
            coarse = subset.undecided
            cut_lengths(subset)
            if reduced.own is not None:
                add_own_tubes(subset, reduced.own)
        else:
            put_together(subset, reduced, parts)
        reduced = reduced.in_metres(subset)
        if record is not None and observer is not None:
            record.keep(taut, reduced, subset, observer)
        found.cells += subset.cells
        found.pending += subset.pending
        if subset.stop is not Stop.EXHAUSTED:
            found.pending = max(found.pending, 1)
            self.stopped = subset.stop
        roots = distinct(subset.roots, reduced.reduction)
        if kind.vertical and kind.rod:
            roots = one_of_each_torus(roots)
        own = Searched(taut, reduced, subset, coarse, self.add_roots(taut, kind, reduced, roots, found))
        own.regions = clusters(self.problem, taut, reduced, subset, kind.vertical or kind.rod)
        found.undecided += own.regions
        if any(lo < hi for lo, hi in self.problem.lengths) and not (kind.vertical or kind.rod):
            self.searched.append(own)

    def add_roots(
        self, taut: tuple[int, ...], kind: Classification, reduced: Reduced, roots: list[Root], found: Found
    ) -> list[tuple[Root, Solution]]:
        """Add the solutions or families of proved roots; return which root is which solution."""
        pairs: list[tuple[Root, Solution]] = []
        if kind.vertical or kind.rod:
            for root in roots:
                self.add_root(taut, kind, reduced, root, found)
            return pairs
        if any(root.parts for root in roots):
            fields = tube_fields(self.robot, self.lengths, taut, reduced, roots)
        else:
            fields = fields_of(cables_of(self.robot), self.lengths, taut, reduced.frame, roots)
        multiply_tensions(fields, self.robot.load_factor)
        solutions = decided_solutions(self.options, self.lengths, taut, fields)
        for root, (decided, solution) in zip(roots, solutions, strict=True):
            before = len(found.solutions)
            if not decided:
                self.add_root(taut, kind, reduced, root, found)
            elif solution is not None:
                found.solutions.append(solution)
            pairs += [(root, one) for one in found.solutions[before:]]
        return pairs

    def add_root(
        self, taut: tuple[int, ...], kind: Classification, reduced: Reduced, root: Root, found: Found
    ) -> None:
        """Add the solution or family of one proved root, in ball arithmetic."""
        pose = pose_of(root, reduced.frame)
        factor = balls.from_range(self.robot.load_factor)
        pose = replace(pose, densities=tuple(t * factor for t in pose.densities))
        if len(taut) == MOST_TAUT:
            solved = solve_densities(self.problem, taut, pose)
            if solved is None:
                reason = "the pose is proved, its six wrenches may be dependent"
                found.undecided.append(undecided_pose(self.problem, taut, pose, reason))
                return
            pose = solved
        if not self.options.ignore_tension_sign and hangs_by_centre(self.problem, taut, pose):
            # A pose of the smaller subset, in its family of all rotations.
            return
        axes = axes_of(self.problem, taut, kind, pose)
        if not axes:
            solution = pose_solution(self.problem, self.options, taut, pose)
            if solution is not None and not (open_cables(solution) and self.is_end(taut, reduced, root)):
                found.solutions.append(solution)
        elif any(t < 0 for t in pose.densities):
            return
        elif len(axes) == 1:
            self.add_turning(taut, pose, axes[0], found)
        else:
            found.solutions += torus_solutions(self.problem, self.options, taut, pose, axes)

    def is_end(self, taut: tuple[int, ...], reduced: Reduced, root: Root) -> bool:
        """Return True when the root is the end of a smaller subset's family: a pose already covered.

        The end solves the larger subset's equations, and the root's box holds one solution at most. Of two
        cables that box is flat: near its plane is not in it. Such a pose is listed, its cable undecided.
        """
        if len(taut) == 2:
            return False
        if not self.ends_known:
            self.remember_ends(taut)
        for end in self.ends:
            if {*end.taut, end.cable} != set(taut):
                continue
            known = dict(zip(end.taut, end.pose.densities, strict=True))
            densities = tuple(known[i] if i in known else 0 * end.pose.densities[0] for i in taut)
            if lies_in(Pose(end.pose.rotation, end.pose.centre, densities), reduced.frame, root):
                return True
        return False

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

    @property
    def asks_for_poses(self) -> bool:
        """Whether static poses of all subsets are asked for: then one that changes its taut cables is one."""
        options = self.options
        return self.problem.taut is None and not (options.ignore_slack or options.ignore_tension_sign)

    def answer(self) -> Answer:
        """Assemble what all subsets gave."""
        stop = self.budget.stop() or self.stopped
        pending = sum(f.pending for _, f, _ in self.found)
        found = [s for _, f, _ in self.found for s in f.solutions]
        regions = [u for _, f, _ in self.found for u in f.undecided]
        with balls.precision():
            if self.asks_for_poses and self.searched and not pending:
                found, regions = with_switching(
                    self.problem, self.searched, found, regions, self.budget, self.options.threads
                )
            solutions, undecided = settle(self.problem, self.options, found, regions, complete=not pending)
        reason = StopReason(stop.value) if stop is not None and pending else StopReason.EXHAUSTED
        nothing = not (solutions or undecided or pending)
        return Answer(
            solutions=tuple(solutions),
            undecided=tuple(undecided),
            pending=pending,
            subsets=tuple(report_of(*entry, solutions, undecided) for entry in self.found),
            stop_reason=reason,
            cells=sum(f.cells for _, f, _ in self.found),
            message=reach_message(self.problem, self.options.ignore_slack) if nothing else "",
        )


def report_of(
    taut: tuple[int, ...],
    found: Found,
    seconds: float,
    solutions: Sequence[Solution],
    undecided: Sequence[Undecided],
) -> SubsetReport:
    """Return a subset's line in the result: incomplete where something that is open may be a pose of it."""
    complete = not found.pending and all(region.taut != taut for region in undecided)
    if found.undecided or any(open_cables(own) for own in found.solutions):
        for entry in solutions:
            slack = {i for i, state in enumerate(entry.cable_states) if state is CableState.SLACK}
            may_be_own = set(entry.taut) <= set(taut) and not slack & set(taut)
            complete = complete and (entry.is_decided or not may_be_own)
    outcome = Outcome.COMPLETE if complete else Outcome.INCOMPLETE
    return SubsetReport(taut, outcome, len(found.solutions), found.cells, seconds)


def undecided_pose(problem: Problem, taut: tuple[int, ...], pose: Pose, reason: str) -> Undecided:
    """Return an undecided entry at one proved pose."""
    return Undecided(
        taut,
        1,
        reason,
        balls.bounds_array(origin(problem.robot, pose)),
        balls.bounds_array(pose.rotation).reshape(3, 3, 2),
    )
