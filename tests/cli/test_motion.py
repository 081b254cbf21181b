"""``cdpr-solve motion`` as a user calls it."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from solvers import Motion
from solvers.cli import cli

UC4 = "t_s,c1,c2,c3,c4\n0,7.5,8,7,9\n10,7.5,8,7,9.3\n"


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "uc4.csv").write_text(UC4)
    (tmp_path / "end.csv").write_text("t_s,c1,c2\n0,7.5,8\n5,2,2\n")
    (tmp_path / "none.csv").write_text("t_s,c1,c2\n0,1,1\n5,2,2\n")
    (tmp_path / "bad.csv").write_text("t_s,c1,c2\n0,1,x\n0,2,2\n")

    def call(*arguments):
        return CliRunner().invoke(cli, ["motion", *map(str, arguments)])

    return call


def test_a_motion_is_proved(run, tmp_path):
    done = run("uc4", "--lengths", "uc4.csv", "--step", 5, "--json", "m.json", "--csv", "m.csv")
    assert done.exit_code == 0
    assert "c4 becomes slack" in done.stdout and "7.21679..7.21894  c1,c2,c3     c4" in done.stdout
    result = Motion.from_json((tmp_path / "m.json").read_text())
    assert result.question.file == "uc4.csv" and result.question.step == 5.0
    assert (tmp_path / "m.csv").read_text() == result.to_csv()


def test_a_tolerance_and_a_start(run):
    done = run(
        "uc4", "--lengths", "uc4.csv", "--tolerance", "0.1mm", "--start", "5,3,-7", "--json", "-", "-q"
    )
    document = json.loads(done.stdout)
    assert done.exit_code == 0
    assert document["question"]["tolerance_m"] == 0.0001 and document["question"]["near_m"] == [5, 3, -7]


def test_a_motion_that_ends(run):
    done = run("uc2", "--lengths", "end.csv", "-q")
    assert done.exit_code == 3 and done.stdout == ""
    assert (
        done.stderr.startswith("proved from 0 to 3.81")
        and "fold: the pose ends, there is none afterwards: cables c1 and c2" in done.stderr
    )


def test_no_pose_at_the_start(run):
    done = run("uc2", "--lengths", "none.csv", "--json", "-")
    assert done.exit_code == 4 and json.loads(done.stdout)["start"] is None
    assert "no stable pose at the start" in done.stderr


def test_errors_of_files_and_options_come_together(run, tmp_path):
    given = ["--tolerance", "x", "--step", "1m", "--start", "1,2", "--plot", "m.txt", "--json", "m.json"]
    done = run("uc2", "--lengths", "bad.csv", *given)
    assert done.exit_code == 2
    assert done.stderr.splitlines() == [
        "--tolerance: 'x' is not a number",
        "--start: must hold x,y,z or x,y,z,roll,pitch,yaw, got 2 entries",
        "--step: '1m' is a length, not a time",
        "--plot: must end in .png, .svg, .pdf, got m.txt",
        "file 'bad.csv' line 2[c2]: 'x' is not a number",
        "file 'bad.csv' line 3: t_s: must be later than 0 s, got 0",
    ]
    assert not (tmp_path / "m.json").exists()
    assert run("uc2", "--lengths", "uc4.csv", "--json", "-", "--csv", "-").exit_code == 2
    assert run("uc2").exit_code == 2


def test_a_picture(run, tmp_path):
    pytest.importorskip("matplotlib")
    done = run("uc4", "--lengths", "uc4.csv", "--plot", "m.png", "-q")
    assert done.exit_code == 0 and (tmp_path / "m.png").read_bytes().startswith(b"\x89PNG")
