"""``fk --certificate`` and the two commands that check what it writes."""

import json
import subprocess
import sys
from dataclasses import replace

import pytest
from click.testing import CliRunner

import certificates
from certificates.__main__ import main
from certificates.container import read, write
from certificates.tree import Node
from certificates.verdicts import Verdict
from solvers.answers.data import Outcome, StopReason
from solvers.cli import ExitCode, cli
from tests.support import hanging_mass
from tests.support.made_certificates import changed, leaf, platform


@pytest.fixture
def hanging(tmp_path):
    path = tmp_path / "hanging.yaml"
    path.write_text(hanging_mass.TEXT, encoding="utf-8")
    return str(path)


@pytest.fixture
def file(tmp_path):
    return tmp_path / "out.cert"


def run(*args):
    return CliRunner().invoke(cli, [str(arg) for arg in args])


@pytest.mark.parametrize(
    ("args", "code", "message"),
    [
        (["2,5"], 0, "PROVED: 1 static pose, and no other one"),
        (["2,3", "--ignore-slack"], 0, "PROVED: 3 static poses (slackness ignored), and no other one"),
        (["1.9..2.1,3", "-q"], 0, "PROVED: 1 static pose, and no other one"),
        (["1,1", "-q"], 4, "PROVED: no static pose"),
        (["2,3", "--taut", "c1"], 4, "PROVED: no static pose of subset c1"),
    ],
)
def test_what_fk_writes_is_proved(hanging, file, args, code, message):
    assert run("fk", hanging, "--lengths", *args, "--certificate", file).exit_code == code
    checked = run("check", file)
    assert checked.exit_code == ExitCode.COMPLETE and checked.stderr == ""
    assert checked.stdout.splitlines()[0] == message and len(checked.stdout.splitlines()) > 1
    assert run("check", "-q", file).stdout.splitlines() == [message]
    assert [p.name for p in file.parent.iterdir() if p.suffix == ".part"] == []


def test_json_and_certificate_together(hanging, file, tmp_path):
    result = tmp_path / "out.json"
    assert run("fk", hanging, "--lengths", "2,5", "--json", result, "--certificate", file).exit_code == 0
    assert json.loads(result.read_text())["format"] == "cdpr-result/1"
    document = read(file)
    assert document["claim"] == "hanging: 1 static pose, proved to be all"
    assert document["tool"]["name"] == "cdpr-interval" and document["not_certified"] == []


@pytest.mark.parametrize(
    ("stop", "code"),
    [(StopReason.TIME_LIMIT, ExitCode.INCOMPLETE), (StopReason.INTERRUPTED, ExitCode.INTERRUPTED)],
)
def test_a_search_that_was_stopped_has_a_certificate(hanging, file, monkeypatch, stop, code):
    answer = replace(hanging_mass.answer(), stop_reason=stop, pending=3)
    assert answer.outcome is Outcome.INCOMPLETE
    monkeypatch.setattr("solvers.point_mass.robot_class.CLASS.forward", lambda problem, options: answer)
    assert run("fk", hanging, "--lengths", "2,5", "--certificate", file).exit_code == code
    assert certificates.check(file).verdict in (Verdict.PROVED, Verdict.NOT_PROVED)


@pytest.fixture
def swinging(tmp_path):
    """The file of a platform on two cables."""
    path = tmp_path / "platform.yaml"
    path.write_text(
        hanging_mass.TEXT.replace("platform_anchor_m: [0, 0, 0]", "platform_anchor_m: [0, 0, 0.5]", 1)
    )
    return path


def test_a_platform_is_proved(swinging, file):
    assert run("fk", swinging, "--lengths", "2,3", "--certificate", file).exit_code == 0
    checked = run("check", file)
    assert checked.exit_code == 0 and checked.stdout.startswith("PROVED: 2 static poses (2 with a family)")
    assert read(file)["not_certified"] == []


def test_a_search_that_was_stopped_is_pending(file):
    given = ("fk", "uc2", "--lengths", "7.5,8", "--cell-limit", "1", "--certificate", file)
    assert run(*given).exit_code == 3
    checked = run("check", file)
    assert checked.exit_code == ExitCode.INCOMPLETE == 3
    assert checked.stdout.startswith("PROVED (partial): 0 static poses; others may exist: 4 pending")


@pytest.mark.parametrize("name", ["", "-", "no/such/folder/x", "."])
def test_the_file_must_be_writable_before_the_run(hanging, monkeypatch, name):
    monkeypatch.setattr("solvers.point_mass.robot_class.CLASS.forward", lambda problem, options: 1 / 0)
    result = run("fk", hanging, "--lengths", "2,5", "--certificate", name)
    assert result.exit_code == ExitCode.INVALID
    assert [line.startswith("--certificate: ") for line in result.stderr.splitlines()] == [True]


def test_one_file_is_not_two(hanging, file):
    result = run("fk", hanging, "--lengths", "2,5", "--certificate", file, "--json", file)
    assert result.exit_code == ExitCode.INVALID and not file.exists()
    assert result.stderr == "--certificate: not the file of --json\n"


def test_exit_codes(hanging, file):
    run("fk", hanging, "--lengths", "2,5", "--certificate", file)
    write(file, changed(read(file), "solutions", 0, "stability", value="unstable"))
    result = run("check", file)
    assert result.exit_code == ExitCode.NOT_PROVED == 5 and result.stdout.startswith("NOT PROVED: ")
    file.write_bytes(file.read_bytes()[:-1])
    result = run("check", file)
    assert result.exit_code == ExitCode.INVALID and result.stdout.startswith("MALFORMED: ")
    file.unlink()
    assert run("check", file).exit_code == ExitCode.INVALID
    write(file, platform(*[leaf(Node.UNDECIDED, 2)] * 4))
    assert run("check", file).exit_code == ExitCode.INCOMPLETE
    result = run("check", file, "--sample", 1, "-q")
    assert result.exit_code == ExitCode.INCOMPLETE and result.stdout.startswith("SAMPLED: ")
    result = run("check", file, "--time-limit", 1e-9)
    assert result.exit_code == ExitCode.INCOMPLETE and result.stdout.startswith("OUT OF TIME: ")


@pytest.mark.parametrize(
    "args",
    [
        ["--sample", "0"],
        ["--threads", "0"],
        ["--time-limit", "0"],
        ["--time-limit", "x"],
        ["--seed", "x"],
        ["--size-limit", "0"],
        ["--jobs", "2"],
    ],
)
def test_wrong_options(file, args, monkeypatch):
    result = run("check", file, *args)
    assert result.exit_code == ExitCode.INVALID and len(result.stderr.splitlines()) == 1
    monkeypatch.setattr("sys.argv", ["certificates", str(file), *args])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2


def test_the_checker_runs_by_itself(hanging, file):
    run("fk", hanging, "--lengths", "2,5", "--certificate", file)
    alone = [sys.executable, "-m", "certificates", str(file), "-q", "--threads", "2", "--sample", "9"]
    done = subprocess.run(alone, capture_output=True, text=True, timeout=100)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "PROVED: 1 static pose, and no other one\n"
    file.write_bytes(b"")
    done = subprocess.run(alone, capture_output=True, text=True, timeout=100)
    assert done.returncode == 2 and done.stdout.startswith("MALFORMED: ")
    assert done.stderr == "MALFORMED: this is no certificate (exit code 2)\n"


UC2 = ("fk", "uc2", "--lengths", "7.5,8", "--certificate")


@pytest.fixture(scope="module")
def uc2(tmp_path_factory):
    """The certificate of the two taut cables of uc2."""
    path = tmp_path_factory.mktemp("uc2") / "uc2.cert"
    assert run(*UC2, path, "--taut", "c1,c2").exit_code == 0
    return path


@pytest.mark.parametrize(
    "asked",
    [
        ["--robot", "uc2"],
        ["--robot", "uc2", "--lengths", "7.5,8"],
        ["--robot", "uc2", "--lengths", "c2=8.0,c1=75e-1"],
        ["--robot", "uc2", "--lengths", "7.5,8", "--taut", "c2,c1", "--external-force", "0,0,0"],
    ],
)
def test_a_certificate_is_of_the_robot_and_question_that_are_named(uc2, asked):
    checked = run("check", uc2, *asked)
    assert checked.exit_code == 0, checked.output
    assert checked.stdout.startswith("PROVED: 8 static poses of subset c1,c2, and no other one\n")
    assert checked.stdout.splitlines()[1].startswith('robot "uc2", sha256 "')


@pytest.mark.parametrize(
    ("asked", "what"),
    [
        (["--robot", "uc3"], "robot differs"),
        (["--robot", "uc2", "--lengths", "7.5,8.000000000000000000001"], "lengths differ"),
        (["--robot", "uc2", "--lengths", "7.5,8..8.1"], "lengths differ"),
        (["--robot", "uc2", "--lengths", "7.5,8", "--external-force", "0,0,1"], "external force differs"),
        (["--robot", "uc2", "--taut", "c1"], "subset differs"),
        (["--robot", "uc2", "--ignore-slack"], "--ignore-slack differs"),
    ],
)
def test_a_certificate_of_something_else_is_not_proved(uc2, asked, what):
    checked = run("check", uc2, *asked)
    assert checked.exit_code == ExitCode.NOT_PROVED == 5
    assert checked.stdout == f"NOT PROVED: the certificate is of another question: its {what}\n"


@pytest.mark.parametrize(
    "asked",
    [
        ["--lengths", "7.5,8"],
        ["--taut", "c1"],
        ["--robot", "uc2", "--lengths", "7.5"],
        ["--robot", "no_such"],
    ],
)
def test_a_wrong_question_for_a_check(uc2, asked):
    checked = run("check", uc2, *asked)
    assert checked.exit_code == ExitCode.INVALID and len(checked.stderr.splitlines()) == 1


def test_what_is_no_certificate_is_said_to_be_none_whatever_is_asked(uc2, tmp_path):
    path = tmp_path / "cut.cert"
    path.write_bytes(uc2.read_bytes()[:-1])
    checked = run("check", path, "--robot", "uc2")
    assert checked.exit_code == ExitCode.INVALID and checked.stdout.startswith("MALFORMED: ")


def test_a_size_limit(uc2):
    assert run("check", uc2, "--size-limit", "1", "-q").exit_code == 0
    assert run("check", uc2, "--sample", "5", "--seed", "3").stdout.splitlines()[5].endswith("--seed 3")


def test_progress_is_shown_on_a_terminal(file, monkeypatch, capsys):
    write(file, platform(*[leaf(Node.UNDECIDED, 2)] * 4))
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    monkeypatch.setattr("sys.argv", ["certificates", str(file)])
    assert main() == 3
    assert "16/16 cells" in capsys.readouterr().err


def test_what_the_checker_has_no_rule_for_ends_soon(tmp_path, file):
    """Ranges that reach the end of a family: the writer gives up after some thousand undecided cells."""
    robot = tmp_path / "swing.yaml"
    robot.write_text(
        "format: cdpr-robot/1\nname: swing\nplatform: {mass_kg: 1}\ncables:\n"
        "  - {name: a, frame_anchor_m: [0, 0, 0], platform_anchor_m: [0, 0, 1]}\n"
        "  - {name: o, frame_anchor_m: [4, 0, 0], platform_anchor_m: [1, 0, 0.5]}\n",
        encoding="utf-8",
    )
    run("fk", robot, "--lengths", "3,4.95..5.05", "-q", "--certificate", file)
    assert run("check", file).exit_code == 0
    run("fk", robot, "--lengths", "3,5.55..5.65", "-q", "--certificate", file)
    assert file.stat().st_size < 20_000
    checked = run("check", file)
    assert checked.exit_code == 3
    assert checked.stdout.startswith("PROVED (partial)") and "pending" in checked.stdout
