"""A certificate counts for the very result it is of, and for no other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cdpr_interval import load_robot
from certificates.container import unpack
from certificates.verdicts import Verdict
from solvers.answers.data import Outcome
from solvers.forward import answer_question, pose_problem
from solvers.proofs.check import difference, proof_of
from solvers.proofs.document import NO_BOX, certificate_bytes
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
