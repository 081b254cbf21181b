"""What a result says of a point mass: its pose, or that there is none, and a row for every taut subset."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from itertools import combinations
from math import comb

import numpy as np

from solvers.answers.data import Answer, Outcome, SubsetReport, Undecided
from solvers.point_mass.arrays import RobotArrays
from solvers.point_mass.convex import NoPose, Unproved
from solvers.point_mass.entry import IDENTITY, Fields, solution, with_states
from solvers.point_mass.fields import OPEN, SWITCHING
from solvers.point_mass.rationals.emptiness import short_message, shortfall
from solvers.point_mass.scope import most_taut
from solvers.questions.problem import Problem

MOST_ROWS = 1024
"""Most subsets a result lists one by one; beyond that only those that carry an entry (ten elastic cables
have 1023 subsets, and a list of millions helps nobody)."""


def subsets(count: int, largest: int) -> Iterator[tuple[int, ...]]:
    """Yield all sets of 1 .. ``largest`` of ``count`` cables, small ones first."""
    for size in range(1, largest + 1):
        yield from combinations(range(count), size)


def subset_count(count: int, largest: int) -> int:
    """Return how many subsets `subsets` yields."""
    return sum(comb(count, size) for size in range(1, largest + 1))


@lru_cache(maxsize=64)
def rows(
    count: int,
    largest: int,
    surely: tuple[int, ...],
    possibly: tuple[int, ...],
    found: bool,
    decided: bool,
) -> tuple[SubsetReport, ...]:
    """Return one row per subset for a claim made at once for all of them.

    Parameters
    ----------
    count, largest
        Number of cables and the size of the largest subset.
    surely, possibly
        Cables proved taut, and those that may be (ascending; the second contains the first).
    found
        Whether there is a pose.
    decided
        Whether nothing is open; else subsets between ``surely`` and ``possibly`` are incomplete.
    """
    if subset_count(count, largest) <= MOST_ROWS:
        listed = list(subsets(count, largest))
    else:
        listed = [possibly] if possibly else []
    sure, candidates = set(surely), set(possibly)
    result = []
    given = False
    for taut in listed:
        concerned = bool(candidates) and sure <= set(taut) <= candidates
        has = concerned and found and not given
        given = given or has
        outcome = Outcome.INCOMPLETE if concerned and not decided else Outcome.COMPLETE
        result.append(SubsetReport(taut, outcome, int(has), 0, 0.0))
    return tuple(result)


def answer_pose(problem: Problem, arrays: RobotArrays, fields: Fields) -> Answer:
    """Return the answer for a proved pose."""
    taut, tight, asked = fields.taut, fields.not_slack, problem.taut
    if asked is not None and taut != tight:
        # For some lengths, or on one side of the switch, other cables are taut than those asked for.
        fields = with_states(fields, np.where(fields.states == SWITCHING, OPEN, fields.states))
    decided = not fields.is_open
    if asked is not None and not set(taut) <= set(asked) <= set(tight):
        names = problem.robot.cable_names
        carry = " and ".join(", ".join(names[i] for i in tight).rsplit(", ", 1))
        kind = "has taut" if taut == tight else "can have taut only"
        message = f"the only pose of the robot {kind} {carry}"
        return Answer((), subsets=(SubsetReport(asked, Outcome.COMPLETE, 0, 0, 0.0),), message=message)
    entry = solution(fields, True if decided else None)
    return Answer((entry,), subsets=_claims(problem, arrays, taut, tight, True, decided))


def answer_without_pose(problem: Problem, arrays: RobotArrays, finding: NoPose | Unproved) -> Answer:
    """Return the answer when there is no pose, or none is proved."""
    count = len(problem.robot.cables)
    if isinstance(finding, NoPose):
        message = finding.reason(problem.robot.cable_names)
        if problem.is_exact and not (finding.touching or finding.gap):
            message += short_message(shortfall(arrays.exits, [hi for _, hi in problem.lengths]))
        return Answer((), subsets=_claims(problem, arrays, (), (), False, True), message=message)
    asked = tuple(range(count)) if problem.taut is None else problem.taut
    # Convex: there are never two.
    region = Undecided(asked, 1, finding.reason, finding.position, IDENTITY, (0, 1))
    return Answer((), (region,), subsets=_claims(problem, arrays, (), tuple(range(count)), False, False))


def _claims(
    problem: Problem,
    arrays: RobotArrays,
    taut: tuple[int, ...],
    tight: tuple[int, ...],
    found: bool,
    decided: bool,
) -> tuple[SubsetReport, ...]:
    asked, count = problem.taut, len(problem.robot.cables)
    if asked is None:
        return rows(count, most_taut(problem.robot), taut, tight, found, decided)
    outcome = Outcome.COMPLETE if decided else Outcome.INCOMPLETE
    return (SubsetReport(asked, outcome, int(found), 0, 0.0),)
