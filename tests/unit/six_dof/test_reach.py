"""What is said where a platform has no pose: out of reach only where that is proved."""

from fractions import Fraction

import pytest

from cdpr_interval.robots.cable_robot import Cable, Platform, Robot
from solvers import forward_kinematics
from solvers.answers.data import Outcome
from solvers.questions.problem import Problem
from solvers.six_dof.reach import reach_message


def vector(*numbers):
    x, y, z = (Fraction(n) for n in numbers)
    return x, y, z


def robot(*exits):
    platform = [vector(-1, 0, 1), vector(1, 0, 1), vector(0, 1, 1)]
    cables = tuple(
        Cable(f"c{k}", vector(*e), b) for k, (e, b) in enumerate(zip(exits, platform, strict=False))
    )
    return Robot("test", Platform(Fraction(1)), cables)


def problem(model, *lengths, taut=None):
    return Problem(model, tuple((Fraction(x), Fraction(x)) for x in lengths), taut=taut)


APART = "no pose: cables c0 and c1 (by at least 1 m) are too short to reach the platform together"
EXCLUDED = "no static pose: every taut subset is excluded"


@pytest.mark.parametrize(
    ("gap", "taut", "ignore_slack", "message"),
    [
        (9, None, False, APART),
        (9, (2,), False, APART),
        (9, (0, 1), True, APART),
        (9, (2,), True, "no static pose with exactly c2 taut: the whole pose space is excluded"),
        (8, None, False, EXCLUDED),
        (8, (0, 1), False, "no static pose with exactly c0, c1 taut: the whole pose space is excluded"),
        (4, None, True, EXCLUDED),
    ],
)
def test_out_of_reach_is_said_where_it_is_proved(gap, taut, ignore_slack, message):
    """Two cables of 3 m on a platform 2 m wide reach 8 m: there they only just touch."""
    model = robot((0, 0, 0), (gap, 0, 0), (0, 0, 9))
    assert reach_message(problem(model, 3, 3, 99, taut=taut), ignore_slack) == message


def test_the_answer_says_so():
    model = robot((0, 0, 0), (9, 0, 0))
    result = forward_kinematics(model, [3, 3])
    assert result.outcome is Outcome.COMPLETE and result.message == APART
