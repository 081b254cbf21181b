"""``cdpr-solve ik`` as a user calls it."""

import json

import pytest
from click.testing import CliRunner

from solvers import IkResult, inverse_kinematics
from solvers.cli import cli


def run(*args):
    return CliRunner().invoke(cli, ["ik", *(str(arg) for arg in args)])


def test_the_table_ends_with_lengths_to_paste():
    result = run("merlet_4_1", "--pose", "1,1.5,-2")
    assert (result.exit_code, result.stderr) == (0, "")
    *_, last = result.stdout.splitlines()
    assert last == "--lengths 2.692582403567252,3.905124837953327,3.3541019662496847,4.387482193696061"


def test_angles_in_degrees_and_quaternions_agree():
    by_angle = run("uc3", "--pose", "5,3,-7,0,0,90deg", "--json", "-")
    by_quaternion = run("uc3", "--pose", "5,3,-7", "--quaternion", "1,0,0,1", "--json", "-")
    one, other = (json.loads(result.stdout) for result in (by_angle, by_quaternion))
    assert one["distances_m"] == pytest.approx(other["distances_m"], rel=1e-14)
    assert one["pose"]["rpy_rad"][2] == pytest.approx(1.5707963267948966)


def test_json_alone_and_in_a_file(tmp_path):
    alone = run("uc3", "--pose", "5,3,-7", "--json", "-")
    assert IkResult.from_json(alone.stdout).to_json() == alone.stdout
    quiet = run("uc3", "--pose", "5,3,-7", "--json", tmp_path / "r.json", "-q")
    # Their dates may differ by a second.
    assert quiet.stdout == ""
    assert IkResult.from_json((tmp_path / "r.json").read_text()) == IkResult.from_json(alone.stdout)


def test_static_is_exit_6_off_balance(tmp_path):
    target = tmp_path / "r.json"
    assert run("uc3", "--pose", "5,3,-6").exit_code == 0
    result = run("uc3", "--pose", "5,3,-6", "--static", "--json", target)
    assert result.exit_code == 6 and "not static" in result.stdout and target.is_file()
    assert result.stderr.startswith("none found, nothing proved: the pose is not static")
    settled = run("uc3", "--pose", "5,3,-6", "--static", "--settle")
    assert settled.exit_code == 0 and "moved by" in settled.stdout


def test_elastic_cables_need_a_static_pose():
    result = run("merlet_4_1_k100", "--pose", "1,1.5,2", "--json", "-")
    assert result.exit_code == 6 and json.loads(result.stdout)["lengths_m"] is None
    assert result.stderr.startswith("none found, nothing proved: the pose is not static")
    assert run("merlet_4_1_k100", "--pose", "1,1.5,-2").exit_code == 0


def test_settling_that_fails_is_exit_6():
    result = run("merlet_4_1", "--pose", "2,2,30", "--settle")
    assert result.exit_code == 6 and "no static pose of these cables was found within 3.01 m" in result.stdout
    assert "--lengths" not in result.stdout


def test_a_large_turn_is_refused_and_warned_of():
    question = ["cogiro", "--pose", "0,0,2", "--taut", "c1,c3,c5,c7", "--settle"]
    refused = run(*question)
    assert refused.exit_code == 6 and "--lengths" not in refused.stdout
    assert "the nearest found is 1.2 m away, moved by 0.163 m and 95.6 deg" in refused.stderr
    further = run(*question, "--settle-within", "1500mm")
    assert further.exit_code == 0 and "moved by 0.163 m and 95.6 deg" in further.stdout
    assert further.stderr == "warning: --settle turned the platform by 95.6 deg\n"


def test_what_was_understood_is_printed_back_and_the_settled_pose_can_be_pasted():
    settled = run("uc3", "--pose", "5 3 -6 1 deg 0 -0.1rad", "--settle")
    _, asked, _, *_, pose, _ = settled.stdout.splitlines()
    assert asked == (
        "pose asked for (5.000000, 3.000000, -6.000000) m, roll pitch yaw (1.0000deg, 0.0000deg, -5.7296deg)"
    )
    option, value = pose.split(" ")
    assert option == "--pose"
    again = run("uc3", option, value, "--static")
    assert again.exit_code == 0 and again.stderr == ""


def test_a_row_with_tolerances_is_pasted():
    """Tables show bounds that are visibly wide as ``5.2964 +- 0.0010``."""
    row = "5.02 +- 0.10  3.00 +- 0.02  -7.0 +- 0.1  0.0 +- 1.0deg  5 +- 1deg -0.1rad"
    result = run("uc3", "--pose", row)
    assert result.exit_code == 0
    middles = "5.02  3.00  -7.0  0.0deg  5deg -0.1rad"
    assert result.stderr == f"--pose: without its tolerances, read as {middles}\n"
    assert result.stdout == run("uc3", "--pose", middles).stdout
    for mark in ("+/-", "±", " ± "):
        assert run("uc3", "--pose", f"5.02{mark}0.1,3,-7").stdout == run("uc3", "--pose", "5.02,3,-7").stdout


def test_the_command_prints_what_python_prints():
    result = inverse_kinematics("merlet_4_1", (1, 1.5, -2))
    assert run("merlet_4_1", "--pose", "1,1.5,-2").stdout == f"{result}\n"


def test_slack_margin():
    text = run("merlet_4_1", "--pose", "1,1.5,-2", "--taut", "c1,c2,c3", "--json", "-").stdout
    document = json.loads(text)
    assert document["lengths_m"][3] == pytest.approx(1.05 * document["distances_m"][3])


@pytest.mark.parametrize(
    ("args", "messages"),
    [
        (["merlet_4_1"], ["--pose: missing"]),
        (
            ["uc3", "--pose", "5 +- 0.1mm,3,-6"],
            ["--pose: in '5 +- 0.1mm' one number has a unit: give both one, or none"],
        ),
        (["uc3", "--pose", "5+-x,3,-6"], ["--pose[0]: '5+-x' is not a number (units are m, cm, mm)"]),
        (["merlet_4_1", "--pose", "1,2"], ["--pose: must hold x,y,z or x,y,z,roll,pitch,yaw, got 2 entries"]),
        (
            [
                "merlet_4_1",
                "--pose",
                "1,x,3",
                "--taut",
                "c9",
                "--slack-margin",
                "-1",
                "--wrench-tolerance",
                "y",
            ],
            [
                "--pose[1]: 'x' is not a number",
                "--wrench-tolerance: 'y' is not a number",
                "--taut[0]: unknown cable 'c9'",
                "--slack-margin: must not be negative, got -1.0",
            ],
        ),
        (
            ["merlet_4_1", "--pose", "1,1,-1,0,0,1deg"],
            ["--pose: this robot is a point mass, which has no orientation"],
        ),
        (
            ["uc3", "--pose", "5,3,-6,1,0.2,0"],
            [
                "--pose[3]: '1' has no unit: write 1deg or 1rad",
                "--pose[4]: '0.2' has no unit: write 0.2deg or 0.2rad",
            ],
        ),
        (["uc3", "--pose", "5,3,-6", "--settle-within", "1"], ["--settle-within: only with --settle"]),
        (
            ["uc3", "--pose", "5,3,-6", "--settle", "--settle-within", "x"],
            ["--settle-within: 'x' is not a number"],
        ),
        (["merlet_4_1", "--pose", "0,0,0"], ["pose: the length of cable 'c1' is zero at this pose"]),
        (["merlet_4_1", "--pose", "1,1,-1", "--json", "/"], ["--json: '/' is not a file name"]),
    ],
)
def test_bad_input_is_exit_2(args, messages):
    result = run(*args)
    assert (result.exit_code, result.stdout) == (2, "")
    assert [line.split(" (did you mean")[0] for line in result.stderr.splitlines()] == messages
