"""Forward kinematics of a point mass: one pose at most, found and proved by convexity or by search.

The reported states, tensions and boxes hold for all lengths in their ranges.
"""

from __future__ import annotations

from cdpr_interval.exact.enclosure import Bounds, length_bounds
from solvers.answers.data import Answer
from solvers.point_mass.answer import answer_pose, answer_without_pose
from solvers.point_mass.arrays import RobotArrays, exact_lengths, is_range, robot_arrays
from solvers.point_mass.convex import Finding, after_quick, quick_pose
from solvers.point_mass.entry import Fields, unpacked
from solvers.point_mass.one_call import DECIDED
from solvers.questions.checked import require_treated, uncertain_data
from solvers.questions.problem import Method, Options, Problem


def solve(problem: Problem, options: Options) -> Answer:
    """Return every static pose of a point-mass robot.

    Parameters
    ----------
    problem : Problem
        A robot all of whose platform anchors are the centre of mass.
    options : Options
        ``method`` CONVEX (the same as AUTO) or SEARCH.

    Raises
    ------
    InputError
        The load is zero.
    NotSupportedError
        The method is not for such a robot.

    Guarantee
    ---------
    With outcome COMPLETE the solutions are all static poses of what was asked, each box holds exactly one,
    for every choice of lengths in their ranges.
    """
    if not problem.is_exact:
        if options.ignore_slack or options.method is Method.SEARCH:
            asker = "--ignore-slack" if options.ignore_slack else "--method search"
            require_treated(problem.robot, uncertain_data(problem.robot, problem.external_force, asker))
        return _over_choices(problem)
    arrays = robot_arrays(problem.loaded)
    lengths = length_bounds(problem.lengths)
    if options.method is Method.SEARCH:
        from solvers.point_mass.search import search_subsets

        return search_subsets(problem, options, arrays, lengths)
    if options.ignore_slack:
        from solvers.point_mass.alone import each_subset_alone

        return each_subset_alone(problem, options, arrays, lengths)
    return _only_pose(problem, arrays, lengths)


def _over_choices(problem: Problem) -> Answer:
    """Return the robot's pose for every choice of its data."""
    from solvers.point_mass.over_choices import find_over_choices

    return _answer(problem, robot_arrays(problem.loaded.middle), find_over_choices(problem))


def _only_pose(problem: Problem, arrays: RobotArrays, lengths: Bounds) -> Answer:
    """Return the robot's pose, where its taut set is what was asked for."""
    status, bounds, states = quick_pose(arrays, lengths)
    if status == DECIDED:
        return answer_pose(problem, arrays, unpacked(bounds, states))
    finding = after_quick(arrays, lengths, exact_lengths(problem))
    if is_range(lengths):
        from solvers.point_mass.over_choices import sharpened

        finding = sharpened(problem, arrays, finding)
    return _answer(problem, arrays, finding)


def _answer(problem: Problem, arrays: RobotArrays, finding: Finding) -> Answer:
    if isinstance(finding, Fields):
        return answer_pose(problem, arrays, finding)
    return answer_without_pose(problem, arrays, finding)
