"""The dispatcher: what it refuses, what it passes on, and the result it builds."""

import json
import math
from dataclasses import replace
from fractions import Fraction as F

import pytest

from cdpr_interval import InputError, NotSupportedError, load_robot
from cdpr_interval.exact.enclosure import length_bounds
from cdpr_interval.robots.pulley import BISECTOR, Pulley
from solvers import forward_kinematics
from solvers.answers.data import Outcome, StopReason
from solvers.questions.problem import Method
from tests.support import hanging_mass

FORWARD = "solvers.point_mass.robot_class.CLASS.forward"


@pytest.fixture
def asked(monkeypatch):
    """Answer every question with the hanging mass, and keep what was asked."""
    questions = []

    def solve(problem, options):
        questions.append((problem, options))
        return hanging_mass.answer()

    monkeypatch.setattr(FORWARD, solve)
    monkeypatch.setattr("solvers.six_dof.robot_class.CLASS.forward", solve)
    return questions


def refused(robot, lengths, **options):
    with pytest.raises(InputError) as caught:
        forward_kinematics(robot, lengths, **options)
    return caught.value.messages


def test_the_question_reaches_the_solver(asked):
    robot = hanging_mass.robot()
    forward_kinematics(
        robot,
        {"c2": "5", "c1": (1, 2)},
        taut=["c2", 0],
        ignore_slack=True,
        method="search",
        precision=1e-6,
        external_force=["0.1", 0, F(1, 3)],
        time_limit=3.0,
        cell_limit=9,
        threads=2,
    )
    ((problem, options),) = asked
    assert problem.lengths == ((F(1), F(2)), (F(5), F(5))) and problem.taut == (0, 1)
    assert problem.external_force == (F(1, 10), F(0), F(1, 3))
    assert (options.ignore_slack, options.method, options.precision) == (True, Method.SEARCH, 1e-6)
    assert (options.time_limit, options.cell_limit, options.threads) == (3.0, 9, 2)


def test_the_result_has_the_keys_of_the_format_in_order(asked):
    document = json.loads(forward_kinematics(hanging_mass.robot(), ["0.1", 5]).to_json())
    assert list(document) == [
        "format", "tool", "robot", "model", "cables", "lengths_m", "question", "outcome", "stop_reason",
        "message", "solutions", "undecided", "pending", "subsets", "statistics",
        "provenance",
    ]  # fmt: skip
    assert list(document["solutions"][0]) == [
        "taut", "cable_states", "position_m", "rotation", "height_m", "tensions_N", "distances_m",
        "slack_respected", "existence", "uniqueness", "proof", "stability", "nominal", "family",
    ]  # fmt: skip
    assert document["question"] == {
        "command": "fk", "taut": None, "ignore_slack": False, "ignore_tension_sign": False,
        "method": "auto", "precision": 1e-9, "external_force_N": [0.0, 0.0, 0.0],
        "tension_N": None,
    }  # fmt: skip
    assert document["cables"] == ["c1", "c2"] and document["solutions"][0]["taut"] == ["c1"]
    assert [subset["taut"] for subset in document["subsets"]] == [["c1"], ["c2"], ["c1", "c2"]]
    lo, hi = document["lengths_m"][0]
    assert F(lo) < F(1, 10) < F(hi) and document["lengths_m"][1] == [5.0, 5.0]
    assert document["message"] == "1 static pose, proved to be all"


def test_enclosing_doubles_are_neighbours():
    lo, hi = length_bounds([(F(1, 10), F(1, 10))])[0].tolist()
    assert F(lo) < F(1, 10) < F(hi) and hi == math.nextafter(lo, 1.0)
    assert length_bounds([(F(1, 2), F(3, 4))]).tolist() == [[0.5, 0.75]]


def test_message_without_a_pose(monkeypatch):
    monkeypatch.setattr(FORWARD, lambda p, o: hanging_mass.no_answer())
    result = forward_kinematics(hanging_mass.robot(), [1, 1])
    assert result.outcome is Outcome.COMPLETE and result.message == "cables c1 and c2 are too short to meet"


def test_message_of_an_open_answer(monkeypatch):
    monkeypatch.setattr(FORWARD, lambda p, o: hanging_mass.open_answer())
    result = forward_kinematics(hanging_mass.robot(), [2, 5])
    assert result.outcome is Outcome.INCOMPLETE
    assert result.message == (
        "stopped at the time limit: 1 static pose proved, with an undecided cable; besides,"
        " 1 region undecided, 12 cells not looked at"
    )


def test_an_interrupt_outside_the_search_is_a_result(monkeypatch):
    def interrupted(problem, options):
        raise KeyboardInterrupt

    monkeypatch.setattr(FORWARD, interrupted)
    result = forward_kinematics(hanging_mass.robot(), [2, 5])
    assert (result.outcome, result.stop_reason) == (Outcome.INCOMPLETE, StopReason.INTERRUPTED)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"taut": ["c9"]}, "taut[0]: unknown cable 'c9'"),
        ({"taut": [0, 5]}, "taut[1]: 5 is not an index from 0 to 1"),
        ({"taut": [0, -1]}, "taut[1]: -1 is not an index from 0 to 1"),
        ({"taut": ["c1", "c1"]}, "taut[1]: cable 'c1' is given twice"),
        ({"taut": []}, "taut: names no cable"),
        ({"taut": [1.5]}, "taut[0]: 1.5 is neither a cable name nor an index"),
        ({"method": "newton"}, "method: must be one of auto, search, convex, got 'newton'"),
        ({"precision": 0.0}, "precision: must be a positive number, got 0.0"),
        ({"precision": float("nan")}, "precision: must be a positive number, got nan"),
        ({"time_limit": -1.0}, "time_limit: must be a positive number, got -1.0"),
        ({"cell_limit": 0}, "cell_limit: must be at least 1, got 0"),
        ({"threads": 0}, "threads: must be at least 1, got 0"),
        ({"external_force": [0, 0]}, "external_force: must hold 3 numbers, got 2"),
        ({"external_force": [0, 0, "x"]}, "external_force[2]: 'x' is not a number"),
        (
            {"external_force": [0, 0, "98.1"]},
            "the weight and the external force cancel; without a load there are no statics",
        ),
        (
            {"ignore_tension_sign": True},
            "ignore_tension_sign: needs exactly six taut cables of a platform, got a point mass",
        ),
    ],
)
def test_refused_options(asked, options, message):
    (found,) = refused(hanging_mass.robot(), [2, 5], **options)
    assert found.startswith(message) and not asked


def test_all_errors_at_once():
    assert len(refused(hanging_mass.robot(), [2, "x"], taut=["c9"], precision=-1.0, threads=0)) == 4


@pytest.mark.parametrize(
    ("name", "count", "most"),
    [("merlet_4_1", 4, 3), ("merlet_4_1_k100", 4, 4), ("cogiro", 8, 6), ("uc4", 4, 4)],
)
def test_the_size_of_a_subset(asked, name, count, most):
    robot = load_robot(name)
    assert len(robot.cables) == count
    forward_kinematics(robot, [1] * count, taut=range(most))
    if most < count:
        (message,) = refused(robot, [1] * count, taut=range(most + 1))
        assert message.endswith(f"has at most {most}")


def test_rigid_legs_need_six_cables(asked):
    six, eight = load_robot("six_leg_40"), load_robot("cogiro")
    forward_kinematics(six, [1] * 6, ignore_tension_sign=True)
    assert asked[0][0].taut == (0, 1, 2, 3, 4, 5)
    forward_kinematics(eight, [1] * 8, ignore_tension_sign=True, taut=range(2, 8))
    for robot, taut, got in ((eight, None, 8), (six, range(5), 5)):
        (message,) = refused(robot, [1] * len(robot.cables), ignore_tension_sign=True, taut=taut)
        assert (
            message == f"ignore_tension_sign: needs exactly six taut cables of a platform, got {got} cables"
        )


def test_the_convex_method_needs_a_point_mass():
    assert refused(load_robot("uc2"), [1, 1], method="convex") == (
        "method: 'convex' is for point-mass robots, this is a platform",
    )


def test_what_is_not_supported_yet(asked):
    platform, pulley = load_robot("uc2"), Pulley(F(1, 50), joints=2, lead_in=F(1), balance=BISECTOR)
    swinging = replace(platform, cables=tuple(replace(c, pulley=pulley) for c in platform.cables))
    with pytest.raises(NotSupportedError, match="a platform needs balance: exact"):
        forward_kinematics(swinging, [1, 1])
    assert not asked
