"""Published and independently computed poses of point-mass robots."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import pytest

from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Robot
from solvers.answers.data import Answer, CableState, Outcome, Solution
from solvers.point_mass.forward import solve
from solvers.questions.problem import Method, Options, Problem

DATA = json.loads((Path(__file__).parents[1] / "data" / "point_mass.json").read_text())
CASES = {case["id"]: case for case in DATA["inextensible"] + DATA["elastic"]}
ORIGIN = (Fraction(0), Fraction(0), Fraction(0))
DIGITS = Fraction(1, 10**15)
"""The reference values carry 18 digits or more of numbers below 1000 cm."""


def problem(case: dict, taut: tuple[int, ...] | None = None) -> Problem:
    cables = []
    for i, anchor in enumerate(case["anchors"]):
        elasticity = Elasticity(stiffness=100 * Fraction(case["k"][i])) if "k" in case else None
        x, y, z = (Fraction(value) / 100 for value in anchor)
        cables.append(Cable(f"c{i + 1}", (x, y, z), ORIGIN, elasticity))
    gravity = (Fraction(0), Fraction(0), -Fraction(str(case["g"])))
    robot = Robot(case["id"], Platform(Fraction(case["mass"])), tuple(cables), gravity)
    lengths = tuple((Fraction(x) / 100,) * 2 for x in case["lengths"])
    return Problem(robot, lengths, taut=taut)


def holds(bounds, value: Fraction, slack: Fraction) -> bool:
    lo, hi = (Fraction(float(x)) for x in bounds)
    return lo - slack <= value <= hi + slack


def matches(solution: Solution, pose: dict, slack: Fraction = DIGITS) -> bool:
    return solution.taut == tuple(i - 1 for i in pose["taut"]) and all(
        holds(b, Fraction(x) / 100, slack) for b, x in zip(solution.position, pose["C"], strict=True)
    )


def check_only(answer: Answer, pose: dict) -> None:
    assert answer.outcome is Outcome.COMPLETE and not answer.undecided and answer.pending == 0
    (solution,) = answer.solutions
    assert matches(solution, pose), (solution.taut, solution.position)
    assert (solution.position[:, 1] - solution.position[:, 0]).max() < 1e-8
    # The tensions are listed for the taut cables or for all.
    listed = pose["taut"] if len(pose["tau"]) == len(pose["taut"]) else range(1, len(pose["tau"]) + 1)
    for i, tension in zip(listed, pose["tau"], strict=True):
        assert holds(solution.tensions[i - 1], Fraction(tension), DIGITS * 1000)
    assert CableState.UNDECIDED not in solution.cable_states
    assert solution.slack_respected is True and solution.stability is Stability.STABLE


@pytest.mark.parametrize("method", [Method.CONVEX, Method.SEARCH])
@pytest.mark.parametrize("name", sorted(CASES))
def test_exactly_the_known_pose(name: str, method: Method) -> None:
    case = CASES[name]
    poses = [case["pose"]] if "pose" in case else case["poses"]
    answer = solve(problem(case), Options(method=method))
    if poses:
        check_only(answer, poses[0])
    else:
        assert name == "NE10_N4_infeasible"
        assert answer.outcome is Outcome.COMPLETE and answer.solutions == ()
        assert answer.message.startswith("cables c1 and c4 cannot reach a common point")


@pytest.mark.parametrize("name", [case["id"] for case in DATA["elastic"]])
def test_every_elastic_subset_alone(name: str) -> None:
    case = CASES[name]
    answer = solve(problem(case), Options(ignore_slack=True))
    assert answer.outcome is Outcome.COMPLETE
    respected = [s for s in answer.solutions if s.slack_respected]
    violated = [s for s in answer.solutions if not s.slack_respected]
    assert len(respected) == 1 and matches(respected[0], case["pose"])
    assert len(violated) == len(case["slack_violated"])
    for pose in case["slack_violated"]:
        # These were computed to 16 digits only.
        assert sum(matches(s, pose, Fraction(1, 10**12)) for s in violated) == 1, pose["taut"]


@pytest.mark.parametrize("name", [case["id"] for case in DATA["inextensible"]])
def test_every_inextensible_subset_alone(name: str) -> None:
    case = CASES[name]
    answer = solve(problem(case), Options(ignore_slack=True))
    assert answer.outcome is Outcome.COMPLETE
    assert len(answer.solutions) == case["positive_tension_subsets"]
    assert sum(s.slack_respected is True for s in answer.solutions) == len(case["poses"])


@pytest.mark.parametrize("name", ["NE07_N6_spatial", "EL21_spatial_N5_soft", "EL07_k1000_3taut_123"])
def test_search_lists_the_same_subsets_alone(name: str) -> None:
    convex = solve(problem(CASES[name]), Options(ignore_slack=True))
    found = solve(problem(CASES[name]), Options(ignore_slack=True, method=Method.SEARCH))
    key = {s.taut: s for s in convex.solutions}
    assert found.outcome is Outcome.COMPLETE and {s.taut for s in found.solutions} == set(key)
    for s in found.solutions:
        other = key[s.taut]
        assert s.slack_respected == other.slack_respected
        assert (s.position[:, 0] <= other.position[:, 1]).all() and (
            other.position[:, 0] <= s.position[:, 1]
        ).all()


def test_merlet_section_3() -> None:
    squares = ("7.25", "15.25", "11.25")
    roots = [
        Fraction(x) for x in ("2.69258240356725201563", "3.90512483795332719706", "3.35410196624968454461")
    ]
    assert all(abs(r * r - Fraction(s)) < Fraction(1, 10**18) for r, s in zip(roots, squares, strict=True))
    anchors = ((0, 0, 0), (4, 0, 0), (0, 4, 0), (4, 4, 0))
    cables = tuple(
        Cable(f"c{i + 1}", (Fraction(x), Fraction(y), Fraction(z)), ORIGIN)
        for i, (x, y, z) in enumerate(anchors)
    )
    robot = Robot("merlet", Platform(Fraction(80)), cables)
    lengths = tuple((x, x) for x in (*roots, Fraction("4.385")))
    for method in (Method.CONVEX, Method.SEARCH):
        answer = solve(Problem(robot, lengths), Options(method=method))
        (solution,) = answer.solutions
        assert answer.outcome is Outcome.COMPLETE and solution.taut == (0, 2, 3)
        expected = (1.002721875, 1.5, -1.998636745733572)
        assert abs(solution.position - [[x] for x in expected]).max() < 1e-9


@pytest.mark.parametrize("method", [Method.CONVEX, Method.SEARCH])
def test_another_taut_set_is_no_solution(method: Method) -> None:
    case = CASES["NE00c_paper_exact_438.5"]
    answer = solve(problem(case, taut=(0, 1, 2)), Options(method=method))
    assert answer.outcome is Outcome.COMPLETE and answer.solutions == ()
    assert answer.message == "the only pose of the robot has taut c1, c3 and c4"
    check_only(solve(problem(case, taut=(0, 2, 3)), Options(method=method)), case["poses"][0])
