"""A certificate counts for the very result it is of, and for no other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.robots.pulley import Pulley
from certificates.container import pack, unpack
from certificates.verdicts import Verdict
from solvers.answers.data import Answer, Outcome
from solvers.forward import answer_question, build_result, pose_problem
from solvers.proofs.check import Asked, difference, other_question, proof_of
from solvers.proofs.document import NO_BOX, certificate_bytes, certificate_document
from solvers.questions.force import ZERO
from solvers.questions.problem import Options
from solvers.six_dof.record import Record

QUESTIONS = {"uc2": ["4.5", "4.5"], "merlet_4_1": ["2.7", "3.9", "3.35", "4.4"], "uc3": ["3", "3", "3"]}


def solved(name, lengths, **asked):
    force, taut = asked.pop("external_force", None), asked.pop("taut", None)
    robot, options = load_robot(name), Options(record=Record(), **asked)
    problem = pose_problem(robot, lengths, taut, force, options)
    result = answer_question(problem, options)
    return robot, result, certificate_bytes(problem, options, result)


@pytest.fixture(scope="module")
def uc2():
    return solved("uc2", QUESTIONS["uc2"])


@pytest.mark.parametrize("name", QUESTIONS)
def test_own_certificate(name):
    proof = proof_of(*solved(name, QUESTIONS[name]))
    assert (proof.verdict, proof.is_complete, proof.name) == (Verdict.PROVED, True, "PROVED")


def test_lengths_that_are_no_doubles_and_ranges():
    for lengths in (["4.51", "4.49"], ["4.51+-0.0001", "4.49"], ["4.5", "4.49..4.52"]):
        assert difference(*solved("uc2", lengths)) == ""


@pytest.mark.parametrize(
    ("asked", "what"),
    [
        ({"lengths": ["4.5", "4.500000000000000000001"]}, "lengths differ"),
        ({"lengths": ["4.5..4.5000001", "4.5"]}, "lengths differ"),
        ({"taut": ["c1", "c2"]}, "subset differs"),
        ({"ignore_slack": True}, "--ignore-slack differs"),
        ({"external_force": ["0", "0", "2"]}, "external force differs"),
    ],
)
def test_another_question(uc2, asked, what):
    robot, result, _ = uc2
    _, _, content = solved("uc2", **{"lengths": QUESTIONS["uc2"], **asked})
    assert what in difference(robot, result, content)
    proof = proof_of(robot, result, content)
    assert proof.verdict is Verdict.NOT_PROVED and what in proof.message and proof.is_refused


def test_another_robot(uc2):
    robot, result, content = uc2
    heavier = replace(robot, platform=replace(robot.platform, mass=robot.platform.mass + 1))
    assert "robot differs" in difference(heavier, result, content)
    assert "robot differs" in difference(load_robot("uc3"), result, content)


@pytest.mark.parametrize("other", [{"joints": 2}, {"arm": "0.11"}, {"joints": 2, "balance": "bisector"}])
def test_pulleys_of_which_a_certificate_cannot_be(other):
    """What the format has no word for is not left out: the proof is of another robot."""
    robot, pulley = load_robot("uc3"), Pulley("0.1", axis=(0, 0, 1), lead_in="0.5")
    robots = [
        robot.replace(cables=[robot.cables[0].replace(pulley=p), *robot.cables[1:]])
        for p in (pulley, pulley.replace(**other))
    ]
    problem = pose_problem(robots[0], ["8", "8", "7"], "c1,c2,c3", None, Options())
    result = build_result(problem, Options(), Answer(()), 0.0)
    content = pack(
        certificate_document(problem, Options(), result, [{"taut": [0, 1, 2], "pending": "not searched"}])
    )
    found = [other_question(content, 10**6, r, Asked(None, ZERO)) for r in robots]
    assert found == ["", "its robot differs"]
    assert [difference(r, result, content) for r in robots] == ["", "its robot differs"]


def test_a_lead_in_without_a_pulley_is_of_another_robot():
    robot, result, content = solved("uc3", QUESTIONS["uc3"])
    first, *others = robot.cables
    with_lead_in = robot.replace(cables=[first.replace(pulley=Pulley(0, lead_in="0.5")), *others])
    assert [difference(r, result, content) for r in (robot, with_lead_in)] == ["", "its robot differs"]


def test_other_poses(uc2):
    robot, result, content = uc2
    first, *others = result.solutions
    assert "more pose" in difference(robot, replace(result, solutions=tuple(others)), content)
    twice = replace(result, solutions=(first, first, *others[1:]))
    assert "1 of its poses" in difference(robot, twice, content)
    moved = replace(first, position=np.nextafter(first.position, 1e9) + 1e-6)
    assert "1 of its poses" in difference(robot, replace(result, solutions=(moved, *others)), content)
    turned = replace(first, rotation=-first.rotation[..., ::-1])
    assert "1 of its poses" in difference(robot, replace(result, solutions=(turned, *others)), content)


def test_poses_that_could_not_be_certified_are_said():
    lengths = ["2.692582403567252", "3.905124837953327", "3.354101966249685", "4.387482193696061"]
    robot, result, content = solved("merlet_4_1", lengths)
    assert len(result.solutions) == 1
    proof = proof_of(robot, result, content)
    assert proof.name == "PROVED (partial)" and not proof.is_refused
    assert "1 not certified" in proof.message


@pytest.mark.parametrize("by", ["0.0001", "0.001"])
def test_ranges_of_a_platform_are_proved(by):
    robot, result, content = solved("uc2", [f"7.5+-{by}", f"8+-{by}"], taut=["c1", "c2"])
    assert result.outcome is Outcome.COMPLETE and len(result.solutions) == 8
    proof = proof_of(robot, result, content)
    assert proof.verdict is Verdict.PROVED and not proof.is_refused and proof.is_complete
    assert not unpack(content)["not_certified"]


def test_what_a_checker_cannot_prove_over_ranges_is_left_out_by_name():
    robot, result, content = solved("uc2", ["7.5+-0.1", "8+-0.1"], taut=["c1", "c2"])
    proof = proof_of(robot, result, content)
    assert proof.verdict is Verdict.PROVED and not proof.is_refused and not proof.is_complete
    left = unpack(content)["not_certified"]
    assert left and all(pose["taut"] == [0, 1] for pose in left)
    assert {pose["reason"] for pose in left} <= {NO_BOX, "it may be the same as another solution"}


def test_what_is_no_certificate(uc2):
    robot, result, content = uc2
    assert proof_of(robot, result, content[:-1]).verdict is Verdict.MALFORMED
    assert proof_of(robot, result, b"").is_refused
    late = proof_of(robot, result, content, time_limit=1e-9)
    assert late.verdict is Verdict.OUT_OF_TIME and not late.is_refused
