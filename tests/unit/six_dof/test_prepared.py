"""What is kept between runs: the same answers, bounded, one entry for a robot object and a load."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.mechanics import loaded as loaded_module
from cdpr_interval.mechanics.loaded import MOST_KEPT
from cdpr_interval.mechanics.six_dof.arrays import nearest
from solvers import forward_kinematics
from solvers.answers.result import Result
from solvers.questions.problem import Options, Problem
from solvers.six_dof import reduction as platform_reduction
from solvers.six_dof.prepared import cables_of, kind_of, lengths_of
from solvers.six_dof.reduction import reduced_problems

ZERO = (Fraction(0),) * 3


def question(robot, lengths, force=ZERO) -> Problem:
    return Problem(robot, tuple((Fraction(x), Fraction(x)) for x in lengths), force)


def solutions(result: Result):
    return result.to_dict()["solutions"]


def test_a_robot_is_known_again_as_the_same_object_under_the_same_load() -> None:
    robot, twin = load_robot("uc2"), load_robot("uc2")
    first = question(robot, ["7.5", "8"]).loaded
    assert question(robot, ["7", "7"]).loaded is first
    assert question(twin, ["7.5", "8"]).loaded is not first
    assert question(robot, ["7", "7"], (Fraction(1), Fraction(0), Fraction(0))).loaded is not first


def test_what_is_kept_is_bounded() -> None:
    for _ in range(3 * MOST_KEPT):
        robot = question(load_robot("uc2"), ["7", "7"]).loaded
        kind_of(robot, (0, 1))
    assert loaded_module._loaded.cache_info().currsize <= MOST_KEPT
    for cache in (loaded_module._loaded, cables_of, kind_of, platform_reduction.templates):
        assert cache.cache_info().maxsize is not None


def test_lengths_and_loads_of_one_robot_do_not_mix() -> None:
    """Answers of one robot object in turns are those of fresh robots."""
    robot = load_robot("uc2")
    questions = [
        (["7.5", "8"], None),
        (["7", "7.5"], None),
        (["7.5", "8"], ["100", 0, 0]),
        (["8", "7.5"], None),
    ]
    for lengths, force in [*questions, *questions]:
        kept = forward_kinematics(robot, lengths, taut=range(2), external_force=force)
        fresh = forward_kinematics(load_robot("uc2"), lengths, taut=range(2), external_force=force)
        assert solutions(kept) == solutions(fresh)


def test_options_that_change_the_search_are_told_apart() -> None:
    robot = load_robot("uc4")
    problem = question(robot, ["7.5", "8", "7", "9"])
    known, lengths = problem.loaded, lengths_of(problem)
    for ignore_slack in (False, True):
        (reduced,) = reduced_problems(known, lengths, Options(ignore_slack=ignore_slack), (0, 1, 2))
        assert reduced.model.slack is not ignore_slack
    other = replace(problem, lengths=((Fraction(1, 3), Fraction(1, 2)),) * 4)
    (reduced,) = reduced_problems(known, lengths_of(other), Options(), (0, 1, 2))
    assert np.all(reduced.model.lengths[:, 0] == 1 / 3) and np.all(reduced.model.lengths[:, 1] == 0.5)
    (again,) = reduced_problems(known, lengths, Options(), (0, 1, 2))
    assert np.array_equal(again.model.lengths[:, 0], [7.5, 8.0, 7.0, 9.0])


@pytest.mark.parametrize(
    "x",
    [
        Fraction(0),
        Fraction(1, 3),
        Fraction(-1, 10),
        Fraction(7, 2),
        Fraction(10**40, 3),
        Fraction(1, 10**320),
        Fraction(1, 10**400),
        Fraction(-(10**300) - 1),
        Fraction(2**60 + 1),
        Fraction(3 * 2**53 + 1, 2**54),
    ],
)
def test_the_nearest_double_and_its_error(x: Fraction) -> None:
    m, error = nearest(x)
    assert abs(Fraction(m) - x) <= Fraction(error)
    assert error <= max(2.0**-52 * abs(m), 5e-324)
    assert (error == 0.0) == (Fraction(m) == x)
