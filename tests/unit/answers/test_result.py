"""Results: exact round trip, order, and the contradictions `verify` finds."""

import json
from dataclasses import replace

import numpy as np
import pytest

from cdpr_interval import InputError, load_robot
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Elasticity
from solvers import Result, inverse_kinematics
from solvers.answers.data import Answer, CableState, Certainty, Family, Nominal, Outcome, Proof, Solution
from solvers.forward import build_result
from solvers.questions.problem import Options, Problem
from tests.support import hanging_mass
from tests.support.hanging_mass import around


def result_of(answer, robot=None, lengths=("2", "5")):
    robot = robot or hanging_mass.robot()
    return build_result(Problem(robot, tuple(hanging_mass.exact(*lengths))), Options(), answer, 0.5)


def family(kind):
    shape = (2, 3) if kind == "torus" else (3,)
    axis = None if kind == "all-rotations" else around(np.full(shape, 1 / 3))
    return Family(kind, axis, axis, around(np.array([[-1.0, 1.0], [2.0, 2.5]])))


@pytest.mark.parametrize(
    "answer",
    [
        hanging_mass.answer(),
        hanging_mass.no_answer(),
        hanging_mass.open_answer(),
        *(Answer((replace(hanging_mass.solution(), family=family(kind)),)) for kind in ("rotation", "torus")),
        Answer((replace(hanging_mass.solution(), family=family("all-rotations"), slack_respected=False),)),
    ],
)
def test_round_trip_restores_every_double(answer):
    result = result_of(answer)
    text = result.to_json()
    again = Result.from_json(text)
    assert again.to_json() == text
    assert Result.from_json(json.loads(text)).to_json() == text
    for one, other in zip(result.solutions, again.solutions, strict=True):
        for name in ("position", "rotation", "height", "tensions", "distances"):
            assert (getattr(one, name) == getattr(other, name)).all()
    assert again.verify(hanging_mass.robot()) == result.verify(hanging_mass.robot())


def test_the_note_and_unbounded_tensions():
    document = json.loads(result_of(hanging_mass.open_answer()).to_json())
    (solution,) = document["solutions"]
    assert solution["note"] == "c2 is just taut" and solution["slack_respected"] == "undecided"
    assert solution["tensions_N"][1] == [0.0, None]
    assert document["undecided"][0]["taut"] == ["c2", "c1"]


def test_unknown_keys_are_ignored():
    text = result_of(hanging_mass.answer()).to_json()
    document = json.loads(text)
    document["later"] = document["solutions"][0]["later"] = document["provenance"]["later"] = {"a": 1}
    assert Result.from_json(document).to_json() == text


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("format",), "cdpr-result/2", "result.format: must be 'cdpr-result/1', is 'cdpr-result/2'"),
        (("pending",), "3", "result.pending: must be a whole number"),
        (("outcome",), "done", "result.outcome: must be one of complete, incomplete"),
        (("lengths_m",), [[1, 2]], "result.lengths_m: must be numbers in the shape (2, 2)"),
        (("solutions",), {}, "result.solutions: must be a list"),
        (("solutions", 0, "taut"), ["c7"], "result.solutions[0].taut: must be a list of cable names"),
        (
            ("solutions", 0, "height_m"),
            [1],
            "result.solutions[0].height_m: must be numbers in the shape (2,)",
        ),
    ],
)
def test_a_broken_document_is_named(path, value, message):
    document = json.loads(result_of(hanging_mass.answer()).to_json())
    place = document
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = value
    with pytest.raises(InputError) as caught:
        Result.from_json(document)
    assert caught.value.messages == (message,)


@pytest.mark.parametrize("text", ["", "[]", "{}", "nonsense", '{"format": "cdpr-result/1"}'])
def test_not_a_result(text):
    with pytest.raises(InputError):
        Result.from_json(text)


def test_nan_is_never_written():
    bad = replace(hanging_mass.solution(), height=np.array([np.nan, 1.0]))
    with pytest.raises(ValueError, match="NaN"):
        result_of(Answer((bad,))).to_json()


def test_order_is_stability_then_height_then_taut_then_position():
    base = hanging_mass.solution()

    def entry(stability, height, taut, x):
        return replace(
            base, stability=stability, height=around(height), taut=taut, position=around([x, 0.0, height])
        )

    expected = [
        entry(Stability.STABLE, 1.0, (1,), 0.0),
        entry(Stability.UNDECIDED, 0.0, (0, 2), 5.0),
        entry(Stability.UNDECIDED, 0.0, (1,), 0.0),
        entry(Stability.UNDECIDED, 0.0, (1,), 1.0),
        entry(Stability.UNSTABLE, -2.0, (0,), 0.0),
        entry(Stability.UNSTABLE, -1.0, (0,), 0.0),
    ]
    for shift in range(6):
        shuffled = expected[shift:] + expected[:shift]
        assert list(result_of(Answer(tuple(shuffled[::-1]))).solutions) == expected


def test_the_hanging_mass_contradicts_nothing():
    robot = hanging_mass.robot()
    assert result_of(hanging_mass.answer()).verify(robot) == []
    assert result_of(hanging_mass.open_answer()).verify(robot) == []
    assert result_of(hanging_mass.no_answer()).verify(robot) == []


def test_a_stretched_cable():
    robot = hanging_mass.robot()
    for elasticity in (Elasticity(stiffness=981), Elasticity(axial_stiffness=1864)):
        # 98.1 N stretch 1.9 m by 0.1 m in both cases (1863.9 N, rounded).
        cables = tuple(replace(cable, elasticity=elasticity) for cable in robot.cables)
        elastic = replace(robot, cables=cables)
        wide = replace(hanging_mass.solution(), distances=around([2.0, 20.0**0.5], 1e-4))
        assert result_of(Answer((wide,)), elastic, ("1.9", "5")).verify(elastic) == []
        assert result_of(Answer((wide,)), elastic, ("1.8", "5")).verify(elastic) == [
            "solutions[0]: distances_m[0]: not the length of the taut cable"
        ]


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"taut": (1,)}, "taut: not the cables whose state is 'taut'"),
        ({"position": around([0.0, 0.0, -2.1])}, "nominal: position outside position_m"),
        ({"height": around(-2.5)}, "height_m: not the height of the centre of mass"),
        (
            {"tensions": np.array([[99.0, 100.0], [0.0, 0.0]])},
            "tensions_N: no equilibrium over the box (force z)",
        ),
        (
            {"tensions": np.array([[-2.0, -1.0], [0.0, 0.0]])},
            "tensions_N[0]: not positive although the cable is taut",
        ),
        ({"tensions": around([98.1, 0.0])}, "tensions_N[1]: not zero although the cable is slack"),
        ({"tensions": np.array([[2.0, 1.0], [0.0, 0.0]])}, "tensions_N: not ranges lo <= hi of numbers"),
        ({"distances": around([2.0, 4.4])}, "distances_m[1]: not the distance from the exit point"),
        (
            {"distances": around([2.0, 5.1])},
            "distances_m[1]: longer than the cable although slackness is respected",
        ),
        ({"rotation": around(2.0 * np.eye(3))}, "rotation: rows 0 and 0 are not orthonormal"),
        ({"rotation": around(np.diag([1.0, 1.0, -1.0]))}, "rotation: the determinant is not 1"),
        (
            {"nominal": Nominal((0.0, 0.0, -2.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 0.0))},
            "nominal: quaternion_wxyz outside rotation",
        ),
        (
            {"nominal": Nominal((0.0, 0.0, -2.0), (1.0, 0.0, 0.0, 0.0), (0.1, 0.0, 0.0))},
            "nominal: rpy_rad outside rotation",
        ),
    ],
)
def test_verify_finds_what_is_wrong(change, complaint):
    result = result_of(Answer((replace(hanging_mass.solution(), **change),)))
    assert f"solutions[0]: {complaint}" in result.verify(hanging_mass.robot())


def test_verify_checks_the_bookkeeping():
    good = result_of(hanging_mass.answer())
    lower = replace(hanging_mass.solution(), height=around(-3.0))
    assert replace(good, pending=1).verify() == [
        "outcome: 'complete' contradicts what is undecided, pending or cut short"
    ]
    assert replace(good, outcome=Outcome.INCOMPLETE).verify() != []
    assert "solutions: not in the order" in replace(good, solutions=(*good.solutions, lower)).verify()[0]
    assert replace(good, cables=("c1", "x")).verify(hanging_mass.robot()) == [
        "cables: not the cables of this robot"
    ]
    assert "robot: the result is about another file" in good.verify(load_robot("uc2"))[0]


def test_verify_recomputes_a_platform():
    robot = load_robot("uc3")
    pose = inverse_kinematics(robot, (5, 3.2, -7), settle=True)
    assert pose.settling is not None and pose.settling.succeeded and pose.lengths is not None
    centre = np.array(pose.position) + np.array(pose.rotation) @ np.array(
        [float(x) for x in robot.platform.centre_of_mass]
    )
    solution = Solution(
        taut=(0, 1, 2),
        cable_states=(CableState.TAUT,) * 3,
        position=around(pose.position),
        rotation=around(pose.rotation),
        height=around(centre[2]),
        tensions=around(pose.tensions),
        distances=around(pose.distances),
        slack_respected=True,
        existence=Certainty.PROVED,
        uniqueness=Certainty.PROVED,
        proof=Proof.INTERVAL_NEWTON,
        stability=Stability.STABLE,
        nominal=Nominal(pose.position, pose.quaternion, pose.rpy),
        family=None,
    )
    lengths = [repr(length) for length in pose.lengths]
    assert result_of(Answer((solution,)), robot, lengths).verify(robot) == []
    tilted = replace(solution, tensions=around(np.add(pose.tensions, [1e-3, 0.0, 0.0])))
    assert any(
        "no equilibrium" in text for text in result_of(Answer((tilted,)), robot, lengths).verify(robot)
    )
