"""Forward kinematics of a point mass: one pose at most, found and proved by convexity or by search.

The reported states, tensions and boxes hold for all lengths in their ranges.
"""

from __future__ import annotations

import numpy as np

from solvers.answers.result import Answer, Bounds, Outcome, SubsetReport, Undecided
from solvers.point_mass.arrays import RobotArrays, exact_lengths, length_bounds, robot_arrays
from solvers.point_mass.convex import NoPose, Unproved, find_pose
from solvers.point_mass.entry import IDENTITY, Fields, solution, with_states
from solvers.point_mass.fields import OPEN, SWITCHING
from solvers.point_mass.subsets import rows
from solvers.questions.problem import Method, Options, Problem


def solve(problem: Problem, options: Options) -> Answer:
    """Return every static pose of a point-mass robot.

    Parameters
    ----------
    problem : Problem
        A robot all of whose platform anchors are the centre of mass; all cables elastic or none.
    options : Options
        ``method`` CONVEX (the same as AUTO) or SEARCH.

    Raises
    ------
    InputError
        The load is zero.
    NotSupportedError
        Some cables stretch and others do not.

    Guarantee
    ---------
    With outcome COMPLETE the solutions are all static poses of what was asked, each box holds exactly one,
    for every choice of lengths in their ranges.
    """
    arrays = robot_arrays(problem)
    lengths = length_bounds(problem.lengths)
    if options.method is Method.SEARCH:
        from solvers.point_mass.search import search_subsets

        return search_subsets(problem, options, arrays, lengths)
    if options.ignore_slack:
        from solvers.point_mass.alone import each_subset_alone

        return each_subset_alone(problem, options, arrays, lengths)
    return _only_pose(problem, arrays, lengths)


def _only_pose(problem: Problem, arrays: RobotArrays, lengths: Bounds) -> Answer:
    """Return the robot's pose, where its taut set is what was asked for."""
    finding = find_pose(arrays, lengths, exact_lengths(problem))
    if isinstance(finding, Fields):
        return answer_pose(problem, arrays, finding)
    return answer_without_pose(problem, arrays, finding)


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
        return Answer((), subsets=_claims(problem, arrays, (), (), False, True), message=message)
    asked = tuple(range(count)) if problem.taut is None else problem.taut
    region = Undecided(asked, 1, finding.reason, finding.position, IDENTITY)
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
        return rows(count, count if arrays.is_elastic else min(3, count), taut, tight, found, decided)
    outcome = Outcome.COMPLETE if decided else Outcome.INCOMPLETE
    return (SubsetReport(asked, outcome, int(found), 0, 0.0),)
