"""Gough platforms on the command line and in Python: what legs change, and what is refused of them."""

from __future__ import annotations

import csv
import json
from fractions import Fraction as F

import numpy as np
import pytest
from click.testing import CliRunner

from cdpr_interval import InputError, NotSupportedError, Robot, load_robot
from solvers import (
    IkResult,
    Outcome,
    PointMass,
    Result,
    Tracker,
    forward_kinematics,
    inverse_kinematics,
    motion,
    polynomial_report,
    pose_from_tensions,
)
from solvers.batch.campaign import result_of
from solvers.batch.ledger import Ledger
from solvers.cli import cli
from solvers.questions.strokes import beyond_limits
from solvers.winches.where import whereabouts

FORTY = "1,0.645275,1.086284,1.503439,1.281933,0.771071"
"""Dietmaier's lengths in m."""
TWO = FORTY.replace("1,", "0.1,", 1)
"""With these there are two poses."""
POSE = "0.1,0.2,0.5,5deg,3deg,1deg"


def run(*args):
    return CliRunner().invoke(cli, [str(arg) for arg in args])


def changed(**more):
    """Return the platform with other keys in its legs; None takes a key away."""
    data = load_robot("gough_40").to_dict()
    for cable in data["cables"]:
        cable.update(more)
    return data


@pytest.fixture
def limited(tmp_path):
    """All legs from 0.5 m to 1.2 m."""
    path = tmp_path / "limited.yaml"
    Robot.from_dict(changed(length_limits_m=["0.5", "1.2"])).save(path)
    return path


@pytest.fixture(scope="module")
def two():
    return forward_kinematics("gough_40", TWO.split(","))


def test_forty_poses_are_those_of_six_cables_with_tensions_of_any_sign():
    legs = forward_kinematics("gough_40", FORTY.split(","))
    cables = forward_kinematics("six_leg_40", FORTY.split(","), taut=range(6), ignore_tension_sign=True)
    assert legs.outcome is Outcome.COMPLETE and len(legs.solutions) == 40
    assert legs.question == cables.question and legs.question.ignore_tension_sign
    assert legs.question.taut == tuple(range(6))
    for one, other in zip(legs.solutions, cables.solutions, strict=True):
        assert np.array_equal(one.position, other.position) and np.array_equal(one.rotation, other.rotation)
        assert np.array_equal(one.tensions, other.tensions) and one.stability == other.stability


def test_legs_push_and_pull(two):
    assert len(two.solutions) == 2 and two.outcome is Outcome.COMPLETE
    for pose in two.solutions:
        assert (pose.tensions[:, 1] < 0).any() and (pose.tensions[:, 0] > 0).any()
        assert pose.taut == tuple(range(6))
    # As cables they could not: nothing of what is found may depend on the sign.
    assert not forward_kinematics("six_leg_40", TWO.split(","), taut=range(6)).solutions


def test_what_is_said_of_legs_changes_no_answer(two):
    lengths = TWO.split(",")
    for more in ({"ignore_tension_sign": True}, {"taut": range(6)}):
        same = forward_kinematics("gough_40", lengths, **more)
        assert same.question == two.question
        for one, other in zip(same.solutions, two.solutions, strict=True):
            assert np.array_equal(one.position, other.position)


def test_a_result_is_read_again_with_its_robot(two):
    again = Result.from_json(two.to_json())
    assert again.provenance.robot.has_legs and again.provenance.robot == load_robot("gough_40")


def test_certificate(tmp_path):
    file, json_file = tmp_path / "two.cert", tmp_path / "two.json"
    done = run("fk", "gough_40", "--lengths", TWO, "--certificate", file, "--json", json_file)
    assert done.exit_code == 0, done.stderr
    assert done.stderr.splitlines()[-1].endswith("and no other one; checked: PROVED")
    assert run("check", file, "--robot", "gough_40", "--lengths", TWO, "--sample", 50).exit_code != 5
    other = run("check", file, "--robot", "gough_40", "--lengths", FORTY)
    assert other.exit_code == 5 and "its lengths differ" in other.stdout


def test_a_certificate_of_cables_is_none_of_legs(tmp_path):
    file = tmp_path / "cables.cert"
    asked = ("--lengths", TWO, "--taut", "c1,c2,c3,c4,c5,c6")
    assert run("fk", "six_leg_40", *asked, "--certificate", file, "-q").exit_code == 4
    assert run("check", file, "--robot", "six_leg_40", *asked, "--sample", 50).exit_code != 5
    other = run("check", file, "--robot", "gough_40", *asked)
    assert other.exit_code == 5 and "--ignore-tension-sign differs" in other.stdout


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("fk", "--lengths", FORTY, "--taut", "c1,c2"), "--taut: all 6 legs carry, got 2"),
        (("fk", "--lengths", FORTY, "--ignore-slack"), "--ignore-slack: is for cables, legs are never slack"),
        (("fk", "--lengths", FORTY, "--tension", "0..9"), "--tension: not of legs, which push, too"),
        (
            ("fk", "--lengths", FORTY, "--method", "convex"),
            "--method: 'convex' is for point-mass robots, this is a platform",
        ),
        (("ik", "--pose", POSE, "--taut", "c1"), "--taut: all 6 legs carry, got 1"),
        (
            ("ik", "--pose", POSE, "--settle"),
            "--settle: is for cables, legs hold the pose that is asked for",
        ),
        (
            ("ik", "--pose", POSE, "--slack-margin", "0.1"),
            "--slack-margin: is for cables, legs are never slack",
        ),
        (("fk", "--tensions", "1,1,1,1,1,1"), "legs are not supported by given tensions: for cables only"),
        (("polynomial", "--lengths", FORTY), "legs are not supported by polynomial: for cables only"),
        (("winch", "where"), "legs are not supported by winch: for cables only"),
        (("winch", "move", "--pose", POSE), "legs are not supported by winch: for cables only"),
    ],
)
def test_what_has_no_meaning_is_refused_in_one_line(args, message):
    words = 2 if args[0] == "winch" else 1
    done = run(*args[:words], "gough_40", *args[words:])
    assert done.exit_code == 2 and done.stdout == ""
    assert done.stderr.removeprefix("robot 'gough-40': ") == f"{message}\n"


def test_motion_is_refused(tmp_path):
    path = tmp_path / "lengths.csv"
    path.write_text("t_s,c1,c2,c3,c4,c5,c6\n0," + FORTY + "\n1," + FORTY + "\n", encoding="utf-8")
    done = run("motion", "gough_40", "--lengths", path)
    assert done.exit_code == 2
    assert done.stderr == "robot 'gough-40': legs are not supported by motion: for cables only\n"


@pytest.mark.parametrize(
    "call",
    [
        lambda: Tracker("gough_40"),
        lambda: motion("gough_40", [(0, [1] * 6), (1, [1] * 6)]),
        lambda: polynomial_report("gough_40", FORTY.split(",")),
        lambda: pose_from_tensions("gough_40", [1] * 6),
        lambda: whereabouts(load_robot("gough_40"), [(1.0, 1.0)] * 6),
    ],
)
def test_python_refuses_legs_too(call):
    with pytest.raises(NotSupportedError, match=r"legs are not supported by .*: for cables only"):
        call()


def test_legs_on_a_point_mass_and_not_six():
    data = changed(platform_anchor_m=[0, 0, 0])
    mass = Robot.from_dict(data)
    for call in (
        lambda: forward_kinematics(mass, FORTY.split(",")),
        lambda: inverse_kinematics(mass, (1, 1, 1)),
        lambda: PointMass(mass),
    ):
        with pytest.raises(NotSupportedError, match="legs carry a platform, this is a point mass"):
            call()
    for count in (5, 7):
        data = changed()
        extra = {**data["cables"][0], "name": "c7", "platform_anchor_m": [1, 2, 3]}
        five = Robot.from_dict({**data, "cables": [*data["cables"], extra][: 5 if count == 5 else None]})
        for call in (
            lambda robot=five: forward_kinematics(robot, [1] * len(robot.cables)),
            lambda robot=five: inverse_kinematics(robot, (1, 1, 1)),
        ):
            with pytest.raises(NotSupportedError, match=f"needs exactly six, got {count}"):
                call()


def test_validate(limited):
    done = run("validate", limited)
    assert done.exit_code == 0 and done.stderr == ""
    assert done.stdout.startswith("gough-40: valid, six-dof platform on 6 legs\n")
    assert "length 0.5 to 1.2 m" in done.stdout


def test_lengths_beyond_the_limits_are_said_and_poses_kept(limited, two):
    done = run("fk", limited, "--lengths", TWO, "--json", "-")
    assert done.exit_code == 0
    said = [
        "c1 is 0.1 m long, its limits are 0.5 and 1.2 m",
        "c4 is 1.503439 m long, its limits are 0.5 and 1.2 m",
        "c5 is 1.281933 m long, its limits are 0.5 and 1.2 m",
    ]
    assert [line for line in done.stderr.splitlines() if line.startswith("warning")] == [
        f"warning: --lengths: {text}" for text in said
    ]
    result = Result.from_json(done.stdout)
    assert result.message == "; ".join(["2 static poses, proved to be all", *said])
    for one, other in zip(result.solutions, two.solutions, strict=True):
        assert np.array_equal(one.position, other.position)


def test_limits_count_exactly_and_for_every_choice():
    robot = Robot.from_dict(changed(length_limits_m=["0.1", "1.503439"]))
    exact = [(F(text), F(text)) for text in TWO.split(",")]
    assert beyond_limits(robot, exact) == [] == beyond_limits(load_robot("gough_40"), exact)
    assert beyond_limits(robot, [(F(1, 10), F(3, 2)), *exact[1:]]) == []
    assert beyond_limits(robot, [(F("0.09999999999"), F(1, 10)), *exact[1:]]) == [
        "c1 is 0.09999999999 to 0.1 m long, its limits are 0.1 and 1.503439 m"
    ]


def _wrench(robot, pose):
    """Return forces and moments about the origin of unit pulls, (6, 6), and of the weight."""
    rotation, position = np.array(pose.rotation), np.array(pose.position)
    columns = []
    for cable in robot.cables:
        exit_point, anchor = (
            np.array(list(map(float, p))) for p in (cable.frame_anchor, cable.platform_anchor)
        )
        anchor = position + rotation @ anchor
        unit = (exit_point - anchor) / np.linalg.norm(exit_point - anchor)
        columns.append(np.concatenate([unit, np.cross(anchor, unit)]))
    weight = float(robot.platform.mass) * np.array(list(map(float, robot.gravity)))
    centre = position + rotation @ np.array(list(map(float, robot.platform.centre_of_mass)))
    return np.array(columns).T, np.concatenate([weight, np.cross(centre, weight)])


def test_ik_forces_balance_the_weight():
    robot = load_robot("gough_40")
    result = inverse_kinematics(robot, (0.1, 0.2, 0.5), rpy=("5deg", "3deg", "1deg"))
    columns, weight = _wrench(robot, result)
    assert result.is_static and np.allclose(result.tensions, np.linalg.solve(columns, -weight), rtol=1e-9)
    assert min(result.tensions) < 0 < max(result.tensions)
    assert result.lengths == result.distances and result.outside_length_limits == ()
    assert "outside_length_limits" not in json.loads(result.to_json())


def test_ik_and_fk_agree(two):
    pose = two.solutions[0]
    found = inverse_kinematics(
        "gough_40", pose.nominal.position, quaternion=pose.nominal.quaternion_wxyz, taut=range(6)
    )
    assert found.lengths == pytest.approx([float(x) for x in TWO.split(",")], abs=1e-9)
    assert found.tensions == pytest.approx(pose.tensions.mean(axis=1).tolist(), abs=1e-5)


def test_ik_beyond_the_limits(limited):
    done = run("ik", limited, "--pose", POSE, "--json", "-")
    assert done.exit_code == 0
    result = IkResult.from_json(done.stdout)
    assert result.outside_length_limits == ("c3", "c4", "c5", "c6")
    assert "warning: --pose: c5 is 2.15413623620964 m long, its limits are 0.5 and 1.2 m" in done.stderr
    assert IkResult.from_json(result.to_json()) == result
    table = run("ik", limited, "--pose", POSE).stdout
    assert [line.split()[0] for line in table.splitlines() if line.endswith("outside its limits")] == [
        "c3", "c4", "c5", "c6",
    ]  # fmt: skip


def test_a_singular_pose_is_not_static():
    """All legs in one plane hold no load across it."""
    data = load_robot("gough_40").to_dict()
    for k, cable in enumerate(data["cables"]):
        cable["frame_anchor_m"] = [k, k * k, 0]
        cable["platform_anchor_m"] = [k, -1 - k, 0]
    flat = Robot.from_dict(data)
    result = inverse_kinematics(flat, (0.3, 0, 0))
    assert not result.is_static and result.residual_force[2] == pytest.approx(-9.81)
    assert result.message == (
        "the pose is not static: 9.81 N and 0 N m are not balanced; "
        "the legs are singular there: they hold it no more"
    )
    assert result.lengths is not None and np.allclose(result.tensions, 0)


def test_a_batch_says_the_same(tmp_path, two):
    jobs, out = tmp_path / "jobs.yaml", tmp_path / "out"
    jobs.write_text(
        f"format: cdpr-batch/1\nrobots: [gough_40]\noptions: {{certificates: true}}\n"
        f"problems:\n  - type: lengths\n    lengths_m: [[{TWO}]]\noutputs: {{csv: true}}\n",
        encoding="utf-8",
    )
    done = run("batch", "run", jobs, "--out", out, "--threads", 1)
    assert done.exit_code == 0, done.stderr
    with (out / "solutions.csv").open() as stream:
        assert len(list(csv.DictReader(stream))) == 2
    with Ledger.peek(out) as ledger:
        found = Result.from_json(result_of(ledger, 1))
    assert found.question == two.question
    for one, other in zip(found.solutions, two.solutions, strict=True):
        assert np.array_equal(one.position, other.position)


def test_a_batch_does_not_settle_legs(tmp_path):
    jobs = tmp_path / "jobs.yaml"
    jobs.write_text(
        "format: cdpr-batch/1\nrobots: [gough_40]\nproblems:\n"
        "  - type: poses\n    position_m: {x: 0.1, y: 0.2, z: 0.5}\n    settle: true\n",
        encoding="utf-8",
    )
    done = run("batch", "run", jobs, "--out", tmp_path / "out")
    assert done.exit_code == 2 and "settle: is for cables, legs hold the pose" in done.stderr


def test_messages_of_python_name_parameters():
    with pytest.raises(InputError, match=r"^taut: all 6 legs carry, got 1$"):
        forward_kinematics("gough_40", TWO.split(","), taut=[0])
    with pytest.raises(InputError, match=r"^settle: is for cables"):
        inverse_kinematics("gough_40", (0.1, 0.2, 0.5), settle=True)
