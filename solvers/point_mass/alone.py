"""Every subset of a point mass's cables as a robot of its own, the other cables ignored.

Each such robot has at most one pose with all its tensions positive. The other cables are compared with
their distances afterwards. Where the lengths of inextensible cables are exact, signs that intervals leave
open are decided in exact arithmetic, so that subsets with one common pose become one entry.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations

import numpy as np

from cdpr_interval.engine.budget import Budget
from cdpr_interval.exact.enclosure import Bounds
from solvers.answers.data import Answer, Outcome, Proof, Solution, StopReason, SubsetReport, Undecided
from solvers.point_mass.answer import MOST_ROWS, subset_count, subsets
from solvers.point_mass.arrays import RobotArrays, exact_lengths, select
from solvers.point_mass.balance import all_cables
from solvers.point_mass.convex import NoPose, Unproved, find_pose, part_of, scaled_cables
from solvers.point_mass.entry import IDENTITY, Fields, fields_of, hull, solution
from solvers.point_mass.fields import OPEN, SLACK, TAUT
from solvers.point_mass.guesses.lowest import lowest_of_subset
from solvers.point_mass.one_call import anywhere, middles, tension_bounds
from solvers.point_mass.rationals.surd import ExactPose, corners, exact_pose, is_pose_of
from solvers.point_mass.scope import most_taut
from solvers.point_mass.switching import dependent
from solvers.point_mass.system import krawczyk
from solvers.questions.problem import Options, Problem, Progress

PROGRESS_SECONDS = 0.1
"""Least time between two progress reports."""


@dataclass(frozen=True, eq=False)
class Claim:
    """A subset's own pose among all cables of the robot."""

    taut: tuple[int, ...]
    fields: Fields
    """Of all cables; those outside the subset are slack, or open where their distance is."""
    slack_respected: bool | None
    exact: ExactPose | None


def each_subset_alone(problem: Problem, options: Options, arrays: RobotArrays, lengths: Bounds) -> Answer:
    """Return the pose of every subset that can carry the load alone, or of the one asked for."""
    count, largest = len(problem.robot.cables), most_taut(problem.robot)
    total = subset_count(count, largest) if problem.taut is None else 1
    wanted = subsets(count, largest) if problem.taut is None else iter((problem.taut,))
    budget = Budget(options.time_limit, options.cell_limit)
    claims: list[Claim] = []
    undecided: list[Undecided] = []
    reports: list[SubsetReport] = []
    told = time.monotonic()
    done = 0
    with budget.listening():
        for taut in wanted:
            if budget.stop() is not None:
                break
            done += 1
            start = time.perf_counter()
            claim = subset_claim(problem, arrays, lengths, taut)
            if isinstance(claim, Claim):
                claims.append(claim)
            elif claim is not None:
                undecided.append(claim)
            is_open = isinstance(claim, Undecided) or (claim is not None and claim.fields.is_open)
            outcome = Outcome.INCOMPLETE if is_open else Outcome.COMPLETE
            if total <= MOST_ROWS or claim is not None:
                spent = time.perf_counter() - start
                reports.append(SubsetReport(taut, outcome, int(isinstance(claim, Claim)), 0, spent))
            if options.progress is not None and time.monotonic() - told > PROGRESS_SECONDS:
                told = time.monotonic()
                options.progress(Progress(0, total - done, 1.0 - done / total, len(claims), done, total))
    stop = StopReason.EXHAUSTED
    if done < total:
        stop = StopReason(budget.stop() or "interrupted")
    return Answer(
        tuple(merged_solutions(problem, claims, Proof.CONVEXITY)),
        tuple(undecided),
        pending=total - done,
        subsets=tuple(reports),
        stop_reason=stop,
    )


def subset_claim(
    problem: Problem, arrays: RobotArrays, lengths: Bounds, taut: tuple[int, ...]
) -> Claim | Undecided | None:
    """Return the pose the cables ``taut`` alone have with all tensions positive; None when there is none."""
    if not problem.robot.is_elastic and dependent(arrays.exits, taut, problem.load):
        # Such poses are those of smaller subsets, where these are looked at.
        return None if problem.taut is None else dependent_claim(problem, arrays, lengths, taut)
    exact = exact_pose_of(problem, taut)
    if _is_exact(problem) and (exact is None or not exact.carried()):
        # Spheres that do not cross, or only touch, carry no load at one point with independent directions.
        return None
    finding = own_pose(problem, arrays, lengths, taut)
    if not isinstance(finding, Fields):
        return finding
    if (finding.states != TAUT).any() and exact is not None:
        # The float guess left out a cable with a tiny tension: prove the whole subset directly.
        finding = whole_subset(arrays, lengths, taut) or finding
    if (finding.states == SLACK).any():
        return None
    if (finding.states != TAUT).any():
        names = problem.robot.cable_names
        zero = ", ".join(names[taut[i]] for i in np.flatnonzero(finding.states != TAUT))
        return Undecided(taut, 1, f"the tension of {zero} may be zero", finding.position, IDENTITY, (0, 1))
    return complete_claim(problem, arrays, lengths, taut, finding, exact)


def own_pose(
    problem: Problem, arrays: RobotArrays, lengths: Bounds, taut: tuple[int, ...]
) -> Fields | Undecided | None:
    """Return the pose of the cables ``taut`` alone, whichever of them carry; None when there is none."""
    part = np.ascontiguousarray(lengths[list(taut)])
    finding = find_pose(part_of(arrays, taut), part, exact_lengths(problem, taut))
    if isinstance(finding, NoPose):
        return None
    if isinstance(finding, Unproved):
        return Undecided(taut, 1, finding.reason, finding.position, IDENTITY, (0, 1))
    return finding


def dependent_claim(
    problem: Problem, arrays: RobotArrays, lengths: Bounds, taut: tuple[int, ...]
) -> Claim | Undecided | None:
    """Return the pose of cables whose directions are dependent at every equilibrium.

    Their tensions are a mean of those of smaller subsets: all can be positive where each is in one of these.
    """
    finding = own_pose(problem, arrays, lengths, taut)
    if not isinstance(finding, Fields):
        return finding
    if (finding.states == SLACK).any():
        return None
    if not np.isfinite(finding.tensions).all():
        # Balls that only touch: there an open tension is proved to be positive for some balance.
        return complete_claim(problem, arrays, lengths, taut, finding, None)
    carrying = exact_corners(problem, taut)
    if not carrying:
        zero = ", ".join(problem.robot.cable_names[i] for i in taut)
        reason = f"the tensions of {zero} are not unique, and whether all can be positive is not decided"
        return Undecided(taut, 1, reason, finding.position, IDENTITY, (0, 1))
    if {i for few in carrying for i in few} != set(taut):
        return None
    return complete_claim(problem, arrays, lengths, taut, finding, next(iter(carrying.values())))


def exact_corners(problem: Problem, taut: tuple[int, ...]) -> dict[tuple[int, ...], ExactPose]:
    """Return the subsets of the cables ``taut`` that alone carry the load at the lowest point of all these.

    Empty where lengths are no exact ones of inextensible cables, or the cables have no common inner point.
    """
    lengths = exact_lengths(problem, taut)
    if lengths is None or problem.robot.is_elastic:
        return {}
    exits = [problem.loaded.exits[i] for i in taut]
    fewer = (few for size in range(1, len(taut)) for few in combinations(range(len(taut)), size))
    found = corners(exits, lengths, problem.load, fewer)
    return {tuple(taut[k] for k in few): pose for few, pose in found}


def whole_subset(arrays: RobotArrays, lengths: Bounds, taut: tuple[int, ...]) -> Fields | None:
    """Prove the pose at which all of one to three inextensible cables carry the load; None where it fails."""
    cables = select(scaled_cables(arrays, lengths), taut)
    m = len(taut)
    A, L, _, f = middles(cables, arrays.load)
    p, t = np.empty(3), np.empty(4)
    if not lowest_of_subset(A, L, f, all_cables(m), m, p, t):
        return None
    zero, domain = np.empty((3 + m, 2)), np.empty((3 + m, 2))
    x = np.concatenate([p, t[:m]])
    if not krawczyk(cables, arrays.load, all_cables(m), m, x, anywhere(3 + m), zero, domain):
        return None
    if not (zero[3:, 0] > 0.0).all():
        return None
    tension = np.zeros((m, 2))
    tension_bounds(cables, all_cables(m), m, zero, tension)
    states = np.full(m, TAUT, dtype=np.int64)
    return fields_of(cables, arrays.frame, np.ascontiguousarray(zero[:3]), tension, states)


def exact_pose_of(problem: Problem, taut: tuple[int, ...]) -> ExactPose | None:
    """Return the subset's pose in exact arithmetic, for exact lengths of inextensible cables."""
    if not _is_exact(problem):
        return None
    exits = [problem.loaded.exits[i] for i in taut]
    return exact_pose(exits, [problem.lengths[i][0] for i in taut], problem.load)


def _is_exact(problem: Problem) -> bool:
    return not problem.robot.is_elastic and all(lo == hi for lo, hi in problem.lengths)


def complete_claim(
    problem: Problem,
    arrays: RobotArrays,
    lengths: Bounds,
    taut: tuple[int, ...],
    own: Fields,
    exact: ExactPose | None,
) -> Claim:
    """Add the cables outside the subset: their distances at its pose decide whether they are slack there."""
    count = len(lengths)
    index = list(taut)
    tensions, distances = np.zeros((count, 2)), np.empty((count, 2))
    tensions[index] = own.tensions
    distances[:] = all_distances(arrays, own.position)
    distances[index] = own.distances
    states = np.full(count, SLACK, dtype=np.int64)
    states[index] = own.states
    respected: bool | None = True
    for i in range(count):
        if i in taut:
            continue
        excess = 1 if distances[i, 0] > lengths[i, 1] else -1 if distances[i, 1] < lengths[i, 0] else None
        if excess is None and exact is not None:
            excess = exact.excess(problem.loaded.exits[i], problem.lengths[i][0])
        if excess is None:
            states[i] = OPEN
            respected = None if respected else respected
        elif excess > 0:
            respected = False
    return Claim(taut, replace(own, tensions=tensions, distances=distances, states=states), respected, exact)


def all_distances(arrays: RobotArrays, position: Bounds) -> Bounds:
    """Enclose the distances (N, 2) in m from all exit points to a platform in a box, exactly rounded up."""
    from cdpr_interval.exact.enclosure import enclose
    from cdpr_interval.kernels.interval import add, sqr, sqrt, sub

    rows = []
    for exit_point in arrays.exits:
        total = (0.0, 0.0)
        for j in range(3):
            total = add(*total, *sqr(*sub(*position[j], *enclose(exit_point[j] - arrays.centre[j]))))
        rows.append(sqrt(*total))
    return np.array(rows)


def merged_solutions(problem: Problem, claims: list[Claim], proof: Proof) -> Iterator[Solution]:
    """Yield one solution per pose: subsets whose poses are proved equal share an entry."""
    left = list(claims)
    while left:
        first = left.pop(0)
        same = [first]
        if first.exact is not None:
            for other in list(left):
                exits = [problem.loaded.exits[i] for i in other.taut]
                sizes: list[Fraction] = [problem.lengths[i][0] for i in other.taut]
                if _meet(first.fields.position, other.fields.position) and is_pose_of(
                    first.exact, exits, sizes, problem.load
                ):
                    same.append(other)
                    left.remove(other)
        if len(same) == 1:
            yield solution(first.fields, first.slack_respected, proof)
            continue
        together = hull([claim.fields for claim in same])
        names = problem.robot.cable_names
        tight = ", ".join(names[i] for i in sorted({i for claim in same for i in claim.taut}))
        note = f"cables {{{tight}}} tight, tensions not unique"
        yield solution(replace(together, note=note), first.slack_respected, proof)


def _meet(a: Bounds, b: Bounds) -> bool:
    return bool((a[:, 0] <= b[:, 1]).all() and (b[:, 0] <= a[:, 1]).all())
