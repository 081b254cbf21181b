"""Platforms on pulleys, on elastic cables, or both: every static pose of every subset of taut cables."""

from __future__ import annotations

import time
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.engine.search import Report
from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.mechanics.cables.path import Balls, OffTheCable, Path
from cdpr_interval.mechanics.cables.pulley import OverPulley
from cdpr_interval.mechanics.energy import has_negative_direction, on_kernel, positive_definite, skew
from cdpr_interval.mechanics.six_dof.frame import Frame, Pose
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import Point
from solvers.answers.data import (
    Answer,
    CableState,
    Certainty,
    Outcome,
    Proof,
    Solution,
    StopReason,
    SubsetReport,
    Undecided,
)
from solvers.questions.problem import Options, Problem, Progress
from solvers.six_dof.cells.merge import distinct
from solvers.six_dof.cells.roots import Root, pose_of
from solvers.six_dof.cells.subset_search import RANGED_REASON
from solvers.six_dof.clusters import connected
from solvers.six_dof.forward import Found
from solvers.six_dof.real.build import model_for, within
from solvers.six_dof.real.columns import MOST_CARRYING, REAL_COLUMNS
from solvers.six_dof.real.follow import Known
from solvers.six_dof.real.hull import hull_of
from solvers.six_dof.real.strand_entry import alone, merged, problem_of
from solvers.six_dof.real.strands import strands_in
from solvers.six_dof.real.subset import FAMILY_REASON, SMALL_REASON, RealSearch, start_cells
from solvers.six_dof.scope import MOST_TAUT, most_taut
from solvers.six_dof.solution import height, length_ball, nominal, origin

Floats = NDArray[np.float64]

NO_POSE = "no static pose: every taut subset is excluded"
NONE_WITHIN = "no static pose within the tension limits: every taut subset is excluded"
ANY_ROTATION = np.tile(np.array([-1.0, 1.0]), (3, 3, 1))
ANYWHERE = np.tile(np.array([-np.inf, np.inf]), (3, 1))
CONTRADICTION = "the way of a taut cable in ball arithmetic is not as long as the cable"
OPEN_NOTE = "there are not two poses here; whether there is one is not proved"
OFF_REASON = "the pose is proved, but one of its other cables has no path there"
MANY_REASON = "more than eight taut cables, which share the load by their stretch, are not looked at"
LEAST_SPREAD = 1e-9
"""Ranges of lengths that are no rounding, over the platform's size."""
MOST_CELLS = 60_000
"""More cells than this are one region."""


def solve(problem: Problem, options: Options) -> Answer:
    """Find and prove every static pose of a platform some of whose cables run over pulleys or stretch.

    Guarantee
    ---------
    With outcome COMPLETE the static poses are exactly those listed, one in each box.
    """
    run = RealRun(problem, options)
    with run.budget.listening(), balls.precision():
        for taut in run.subsets:
            run.solve_subset(taut)
        return run.answer()


class RealRun:
    """One forward-kinematics run; its subsets share a budget."""

    def __init__(self, problem: Problem, options: Options) -> None:
        self.problem = problem
        self.options = options
        self.budget = Budget(options.time_limit, options.cell_limit)
        self.subsets = subsets(problem)
        self.found: list[tuple[tuple[int, ...], Found, float]] = []
        self.stopped: Stop | None = None
        self.roots: dict[tuple[int, ...], list[Root]] = {}
        self.strands: dict[tuple[int, ...], list[Solution | Undecided]] = {}
        """What is proved of a subset by parts of the ranges."""

    def solve_subset(self, taut: tuple[int, ...]) -> None:
        """Solve one subset and keep what it gives."""
        started = time.perf_counter()
        found = Found()
        if self.budget.stop() is not None:
            found.pending = 1
        else:
            self.search(taut, found)
            self.report_roots(taut, found)
        self.found.append((taut, found, time.perf_counter() - started))

    def search(self, taut: tuple[int, ...], found: Found) -> None:
        """Search one subset and turn its roots into solutions.

        With tension limits poses with a higher tension of an elastic cable are no answer.
        """
        real = model_for(self.problem, taut, slack=not self.options.ignore_slack)
        if self.problem.tension is not None:
            real = within(real, enclose(self.problem.tension[1])[1])
        search = RealSearch(real, self.budget, self.options.threads, report=self.reporter(found))
        search.solve()
        found.cells += search.cells
        found.pending += search.pending
        if search.stop is not Stop.EXHAUSTED:
            found.pending = max(found.pending, 1)
            self.stopped = search.stop
        known = [*self.roots.get(taut, []), *(Root(r.chart, r.box, r.unique, r.core) for r in search.roots)]
        self.roots[taut] = distinct(known)
        if self.options.record is not None:
            self.options.record.keep_roots(taut, self.roots[taut])
        if len(search.undecided):
            cells, reason = search.undecided, search.reason
            if search.spread > LEAST_SPREAD and reason == SMALL_REASON:
                cells, reason = self.by_parts(taut, search, found), RANGED_REASON
            # What was not ended is no neighbourhood of anything.
            entries = everywhere if reason == FAMILY_REASON else regions
            found.undecided += entries(self.problem, taut, cells, reason)

    def by_parts(self, taut: tuple[int, ...], search: RealSearch, found: Found) -> Floats:
        """Find the poses of clusters of cells by parts of the ranges; return the cells of the others."""
        left = [search.undecided[:0]]
        for group in connected(search.undecided, REAL_COLUMNS.chart):
            cells = search.undecided[group]
            strands, looked_at = strands_in(
                search.real, cells, search.roots, self.budget, self.options.threads
            )
            found.cells += looked_at
            if strands is None:
                left.append(cells)
            for strand in strands or []:
                roots = [Root(p.root.chart, p.root.box, p.root.unique, p.root.core) for p in strand]
                each = [
                    solution_of(problem_of(self.problem, taut, piece), self.options, taut, root)
                    for piece, root in zip(strand, roots, strict=True)
                ]
                entry = merged(tuple(sorted(taut)), each, RANGED_REASON)
                if entry is not None:
                    self.strands.setdefault(taut, []).append(entry)
        if (stop := self.budget.stop()) is not None:
            self.stopped, found.pending = stop, max(found.pending, 1)
        return np.concatenate(left)

    def report_roots(self, taut: tuple[int, ...], found: Found) -> None:
        """Add the solutions of the roots of one subset, each once."""
        for root in self.roots.get(taut, []):
            solution = solution_of(self.problem, self.options, taut, root)
            if isinstance(solution, Undecided):
                found.undecided.append(solution)
            elif solution is not None:
                found.solutions.append(solution)
        for entry in alone(
            tuple(sorted(taut)),
            self.strands.get(taut, []),
            [*found.solutions, *found.undecided],
            RANGED_REASON,
        ):
            if isinstance(entry, Solution):
                found.solutions.append(entry)
            else:
                found.undecided.append(entry)

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
                Progress(
                    done + found.cells + cells, pending, volume, solutions, len(self.found), len(self.subsets)
                )
            )

        return report

    def answer(self) -> Answer:
        """Assemble what all subsets gave."""
        stop = self.budget.stop() or self.stopped
        pending = sum(f.pending for _, f, _ in self.found)
        solutions = [s for _, f, _ in self.found for s in f.solutions]
        undecided = [u for _, f, _ in self.found for u in f.undecided]
        count = len(self.problem.robot.cables)
        if self.problem.taut is None and self.problem.robot.is_elastic and count > MOST_CARRYING:
            # Elastic cables share the load whatever their number.
            undecided += self.many()
        reason = StopReason(stop.value) if stop is not None and pending else StopReason.EXHAUSTED
        nothing = not (solutions or undecided or pending)
        return Answer(
            solutions=tuple(solutions),
            undecided=tuple(undecided),
            pending=pending,
            subsets=tuple(report_of(*entry) for entry in self.found),
            stop_reason=reason,
            cells=sum(f.cells for _, f, _ in self.found),
            message="" if not nothing else NO_POSE if self.problem.tension is None else NONE_WITHIN,
        )

    def many(self) -> list[Undecided]:
        """Return the entry of poses with more than eight taut cables; none where these are excluded."""
        everything = tuple(range(len(self.problem.robot.cables)))
        if self.options.ignore_slack:
            # Cables that are in no way bound nothing.
            return [Undecided(everything, 1, MANY_REASON, ANYWHERE, ANY_ROTATION)]
        cells = start_cells(model_for(self.problem, everything, slack=False))
        return everywhere(self.problem, everything, cells, MANY_REASON) if len(cells) else []


def subsets(problem: Problem) -> list[tuple[int, ...]]:
    """Return the taut subsets to examine, smallest first; cables that do not stretch come first in each."""
    if problem.taut is not None:
        return [rigid_first(problem, problem.taut)]
    cables, sizes = range(len(problem.robot.cables)), range(1, most_taut(problem.robot) + 1)
    found = [rigid_first(problem, taut) for size in sizes for taut in combinations(cables, size)]
    return [taut for taut in found if rigid(problem, taut) <= MOST_TAUT]


def rigid(problem: Problem, taut: tuple[int, ...]) -> int:
    """Return how many cables of a subset do not stretch."""
    return sum(not problem.loaded.models[i].law.stretches for i in taut)


def rigid_first(problem: Problem, taut: tuple[int, ...]) -> tuple[int, ...]:
    """Return a subset with the cables that do not stretch in front, each kind in file order."""
    return tuple(sorted(taut, key=lambda i: (problem.loaded.models[i].law.stretches, i)))


def report_of(taut: tuple[int, ...], found: Found, seconds: float) -> SubsetReport:
    """Return a subset's line in the result."""
    complete = not (found.pending or found.undecided) and all(s.is_decided for s in found.solutions)
    outcome = Outcome.COMPLETE if complete else Outcome.INCOMPLETE
    return SubsetReport(tuple(sorted(taut)), outcome, len(found.solutions), found.cells, seconds)


@dataclass(frozen=True)
class Seen:
    """A pose as one cable sees it."""

    arm: arb_mat
    """r = R b."""
    path: Path
    turning: arb_mat
    """The derivative (3, 3) of the direction by the anchor."""
    free: arb
    """What a density is multiplied by: the free part, of a rope that has lifted off what is beyond the place
    where it does, as ``real.path`` has it."""

    @property
    def direction(self) -> arb_mat:
        """Unit vector towards the anchor."""
        return balls.vector(list(self.path.direction))


def views(problem: Problem, pose: Pose) -> list[Seen] | None:
    """Return what each cable sees of a pose; None where some cable has no path to it."""
    found = []
    numbers = Balls()
    for arm, model in zip(problem.loaded.arm_ranges, problem.loaded.models, strict=True):
        r = pose.rotation * balls.ranges(arm)
        x, y, z = balls.entries(pose.centre + r)
        try:
            path = model.route.path((x, y, z), numbers)
        except OffTheCable:
            return None
        free = path.free
        if path.is_past and isinstance(model.route, OverPulley):
            free -= model.route.arriving(numbers)
        found.append(Seen(r, path, arb_mat(model.route.turning(path, (x, y, z), numbers)), free))
    return found


def solution_of(
    problem: Problem, options: Options, taut: tuple[int, ...], root: Root
) -> Solution | Undecided | None:
    """Return the solution of a proved root, or None where it is proved to be no static pose.

    Undecided where some other cable has no path to it: within its pulley, or on its axis.

    Distances are those along the cables, from where each starts to its anchor.
    """
    pose = pose_of(root, Frame.plain())
    if any(t < 0 for t in pose.densities):
        return None
    view = views(problem, pose)
    if view is None:
        return _region(problem, taut, pose, 1, OFF_REASON)
    densities = dict(zip(taut, pose.densities, strict=True))
    states: list[CableState] = []
    respected: bool | None = True
    for i, seen in enumerate(view):
        if i in densities:
            if not problem.loaded.models[i].law.stretches and not seen.path.length.overlaps(
                length_ball(problem, i)
            ):
                # Two models of one cable that contradict each other: nothing is claimed.
                return _region(problem, taut, pose, 1, CONTRADICTION)
            states.append(CableState.TAUT if densities[i] > 0 else CableState.UNDECIDED)
            continue
        length = length_ball(problem, i)
        is_slack = True if seen.path.length < length else False if seen.path.length > length else None
        states.append(CableState.UNDECIDED if is_slack is None else CableState.SLACK)
        if is_slack is False:
            respected = False
        elif is_slack is None and respected:
            respected = None
    if respected is False and not options.ignore_slack:
        return None
    # Over ranges an open cable may be the one that takes the pose away for some choices.
    is_open = CableState.UNDECIDED in states and any(lo < hi for lo, hi in problem.lengths)
    tensions, distances = _numbers(problem, view, densities)
    return Solution(
        taut=tuple(i for i, state in enumerate(states) if state is CableState.TAUT),
        cable_states=tuple(states),
        position=balls.bounds_array(origin(problem.robot, pose)),
        rotation=np.clip(balls.bounds_array(pose.rotation), -1.0, 1.0).reshape(3, 3, 2),
        height=height(problem.robot, pose.centre),
        tensions=tensions,
        distances=distances,
        slack_respected=respected,
        existence=Certainty.UNDECIDED if is_open else Certainty.PROVED,
        uniqueness=Certainty.PROVED,
        proof=Proof.INTERVAL_NEWTON,
        stability=stability_of(problem, view, densities, CableState.UNDECIDED in states),
        nominal=nominal(problem.robot, pose),
        family=None,
        note=OPEN_NOTE if is_open else "",
    )


def stability_at(robot: Robot, force: Point, known: Known) -> Stability:
    """Return whether a pose of a robot under a force is stable, for the choice of lengths it is known at."""
    lengths = tuple((Fraction(x), Fraction(x)) for x in known.middle.tolist())
    problem = Problem(robot, lengths, external_force=force)
    with balls.precision():
        root = Root(known.chart, known.core, known.core, known.core)
        found = solution_of(problem, Options(), known.taut, root)
    return found.stability if isinstance(found, Solution) else Stability.UNDECIDED


def _numbers(problem: Problem, view: list[Seen], densities: dict[int, arb]) -> tuple[Floats, Floats]:
    """Return bounds (N, 2) of tensions and of lengths along the cables."""
    tensions = np.zeros((len(view), 2))
    distances = np.array([balls.to_bounds(seen.path.length) for seen in view])
    for i, t in densities.items():
        lo, hi = balls.to_bounds(t * view[i].free)
        tensions[i] = max(lo, 0.0), hi
        if not problem.loaded.models[i].law.stretches:
            lo, hi = balls.to_bounds(length_ball(problem, i))
            distances[i] = max(distances[i, 0], lo), min(distances[i, 1], hi)
    return tensions, distances


def stability_of(problem: Problem, view: list[Seen], densities: dict[int, arb], is_open: bool) -> Stability:
    """Return whether a pose is a strict minimum of the energy of load and springs.

    The second derivative along a motion (v, omega), dX = v + omega x r, is the sum over the taut cables of
    tension (dX . da/dX dX + a . (omega x (omega x r))), and k (a . dX)^2 of one that stretches; inextensible
    ones leave the motions with a . dX = 0.
    """
    form, rows = arb_mat(6, 6), []
    for i, t in densities.items():
        seen = view[i]
        a, r = seen.direction, seen.arm
        move = _beside(balls.identity(), skew(r) * arb(-1))
        tension = t * seen.free
        outer = (a * r.transpose() + r * a.transpose()) * arb(0.5)
        turned = (outer - balls.identity() * balls.dot(a, r)) * tension
        form += move.transpose() * seen.turning * move * tension + _corner(turned)
        pulled = move.transpose() * a
        constant = _spring(problem, i)
        if not t > 0:
            # A cable that may be just slack holds nothing back on one side.
            continue
        if constant is not None:
            form += pulled * pulled.transpose() * constant
        else:
            rows.append(balls.entries(pulled))
    if not all(x.is_finite() for x in form.entries()):
        return Stability.UNDECIDED
    form = (form + form.transpose()) * arb(0.5)
    try:
        reduced = on_kernel(form, arb_mat(rows)) if rows else form
    except ZeroDivisionError:
        return Stability.UNDECIDED
    if reduced is None or positive_definite(reduced):
        return Stability.STABLE
    return Stability.UNSTABLE if not is_open and has_negative_direction(reduced) else Stability.UNDECIDED


def _spring(problem: Problem, i: int) -> arb | None:
    """Enclose k of a cable of its length; None where it does not stretch."""
    law = problem.loaded.models[i].law
    ends = [law.spring_constant(end) for end in problem.lengths[i]]
    if ends[0] is None or ends[1] is None:
        return None
    return balls.from_fraction(ends[0]).union(balls.from_fraction(ends[1]))


def _beside(left: arb_mat, right: arb_mat) -> arb_mat:
    return arb_mat([[left[i, j] for j in range(3)] + [right[i, j] for j in range(3)] for i in range(3)])


def _corner(block: arb_mat) -> arb_mat:
    """Return the (6, 6) matrix with a block in its lower right corner."""
    zero = arb(0)
    rows = [[zero] * 6 for _ in range(3)]
    rows += [[zero] * 3 + [block[i, j] for j in range(3)] for i in range(3)]
    return arb_mat(rows)


def regions(problem: Problem, taut: tuple[int, ...], cells: Floats, reason: str) -> list[Undecided]:
    """Return one entry for each connected cluster of undecided cells."""
    if len(cells) > MOST_CELLS:
        return everywhere(problem, taut, cells, reason)
    centre = balls.bounds_array(balls.ranges(problem.loaded.centre_ranges))
    found = []
    for group in connected(cells, REAL_COLUMNS.chart):
        position, rotation = hull_of(cells[group], centre)
        found.append(Undecided(tuple(sorted(taut)), len(group), reason, position, rotation))
    return found


def _region(problem: Problem, taut: tuple[int, ...], pose: Pose, cells: int, reason: str) -> Undecided:
    """Return the entry of all rotations and positions that a pose encloses."""
    rotation = np.clip(balls.bounds_array(pose.rotation), -1.0, 1.0).reshape(3, 3, 2)
    return Undecided(
        tuple(sorted(taut)), cells, reason, balls.bounds_array(origin(problem.robot, pose)), rotation
    )


def everywhere(problem: Problem, taut: tuple[int, ...], cells: Floats, reason: str) -> list[Undecided]:
    """Return one entry for all cells, whatever the rotation."""
    centre = balls.norm(balls.ranges(problem.loaded.centre_ranges))
    lo, hi = cells[:, 6:12:2].min(axis=0), cells[:, 7:12:2].max(axis=0)
    far = balls.to_bounds(centre)[1]
    position = np.stack([np.nextafter(lo - far, -np.inf), np.nextafter(hi + far, np.inf)], axis=1)
    return [Undecided(tuple(sorted(taut)), len(cells), reason, position, ANY_ROTATION)]
