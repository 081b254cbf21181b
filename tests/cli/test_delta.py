"""`fk`, `ik`, `kinematics`, `validate` and `robots` of a Delta as a user calls them, and what refuses one."""

import json

import pytest
from click.testing import CliRunner

from solvers.cli import cli


def run(*args):
    return CliRunner().invoke(cli, [str(arg) for arg in args])


def test_poses_lower_first(tmp_path):
    target = tmp_path / "r.json"
    result = run("fk", "delta_580", "--angles", "10deg,20deg,30deg", "--json", target)
    assert (result.exit_code, result.stderr) == (0, "")
    assert "lower       0.033955, 0.020772, -0.281754 m" in result.stdout
    document = json.loads(target.read_text())
    assert document["format"] == "cdpr-delta-result/1" and document["model"] == "delta"
    heights = [pose["position_m"][2] for pose in document["solutions"]]
    assert heights[0][1] < heights[1][0] and document["question"]["positions_m"] is None


def test_drives_of_both_branches():
    document = json.loads(run("ik", "delta_580", "--pose", "0,0.15,-0.45", "--json", "-").stdout)
    assert document["angles_rad"][0][0] == pytest.approx(1.0880927210767548, abs=1e-12)
    assert document["other_branch_rad"][0][0] == pytest.approx(2.5953936331898797, abs=1e-12)


@pytest.mark.parametrize(
    ("code", "args"),
    [
        (4, ("ik", "delta_580", "--pose", "0,0,-4")),
        (4, ("fk", "clavel_r100_b175", "--angles", "0,0,0")),
        (0, ("kinematics", "delta_580", "--pose", "0,0,-0.4", "--box", "20mm,20mm,20mm")),
        (3, ("kinematics", "delta_580", "--pose", "0,0,-0.4", "--box", "1,1,1", "--time-limit", "0.1")),
        (2, ("kinematics", "delta_580", "--pose", "0,0,-4")),
        (2, ("kinematics", "uc2", "--pose", "0,0,-4")),
        (2, ("fk", "uc2", "--angles", "1deg,2deg,3deg")),
        (2, ("fk", "delta_580", "--lengths", "1,2,3")),
        (2, ("ik", "delta_580", "--pose", "0,0,-0.4", "--settle")),
        (0, ("validate", "delta_580")),
        (0, ("robots",)),
    ],
)
def test_exit_codes(code, args):
    result = run(*args)
    assert result.exit_code == code, result.output
    assert "Traceback" not in result.output and len(result.stderr.splitlines()) <= 1


@pytest.mark.parametrize(
    "args",
    [
        ("motion", "delta_580", "--lengths", "1,2"),
        ("polynomial", "delta_580"),
        ("winch", "where", "delta_580"),
        ("fk", "delta_580", "--tensions", "1,2,3"),
    ],
)
def test_what_needs_cables_says_so(args):
    result = run(*args)
    assert result.exit_code == 2 and "Traceback" not in result.output and result.stderr


def test_options_of_cables_are_named():
    result = run("fk", "delta_580", "--angles", "10deg,20,30deg", "--taut", "c1", "--threads", "2")
    assert result.exit_code == 2
    assert set(result.stderr.splitlines()) == {
        "--taut: not for a Delta",
        "--threads: not for a Delta",
        "--angles[1]: '20' has no unit: write 20deg or 20rad",
    }


def test_a_delta_without_drives_is_asked_for_these():
    result = run("fk", "delta_580")
    assert (result.exit_code, result.stderr) == (2, "--angles: missing\n")
