"""``fk --tension``: which poses are listed, how the command ends, and what is refused in one line."""

import json

import pytest
from click.testing import CliRunner

from solvers.cli import cli
from solvers.questions.problem import Problem
from tests.support import hanging_mass

LENGTHS = ("--lengths", "2,5")


@pytest.fixture
def hanging(tmp_path):
    path = tmp_path / "hanging.yaml"
    path.write_text(hanging_mass.TEXT, encoding="utf-8")
    return str(path)


def run(*args):
    return CliRunner().invoke(cli, [str(arg) for arg in args])


@pytest.mark.parametrize("limits", ["0N..0.2kN", "98..99", "[0,200]", "98.1+-1", "98.1N +- 1N"])
def test_a_pose_within_the_limits_is_listed(hanging, limits):
    """The mass of 10 kg hangs on one cable with 98.1 N; the other one is slack and not judged."""
    done = run("fk", hanging, *LENGTHS, "--tension", limits)
    assert done.exit_code == 0, done.stderr
    assert " only: 1 static pose, proved to be all" in done.stdout


@pytest.mark.parametrize("limits", ["0..98.0999999", "98.1000001..200", "1N..0.05kN"])
def test_with_all_poses_outside_it_is_exit_4_with_its_message(hanging, limits):
    done = run("fk", hanging, *LENGTHS, "--tension", limits, "--json", "-")
    assert done.exit_code == 4
    assert done.stderr == "no static pose within the tension limits; 1 static pose found outside them\n"
    document = json.loads(done.stdout)
    assert document["solutions"] == [] and document["outcome"] == "complete"


@pytest.mark.parametrize("limits", ["0..98.1", "98.1..200"])
def test_a_limit_on_the_tension_itself_is_open(hanging, limits):
    done = run("fk", hanging, *LENGTHS, "--tension", limits, "--json", "-")
    assert done.exit_code == 3
    assert done.stderr.splitlines()[-1].endswith("whether one pose is within the tension limits is open")
    document = json.loads(done.stdout)
    (pose,) = document["solutions"]
    assert pose["tension_respected"] == "undecided" and pose["existence"] == "proved"
    assert document["question"]["tension_N"] == [float(x) for x in limits.split("..")]
    table = run("fk", hanging, *LENGTHS, "--tension", limits).stdout
    assert "within the tension limits undecided: c1" in table
    assert "what helps: other --tension limits" in table


def test_no_pose_at_all_says_so_as_without_limits(hanging):
    plain, limited = (run("fk", hanging, "--lengths", "1,1", *more) for more in ((), ("--tension", "1..2")))
    assert (plain.exit_code, limited.exit_code) == (4, 4)
    assert limited.stderr == plain.stderr


def test_units_and_spellings_are_one_question(hanging):
    plain = json.loads(run("fk", hanging, *LENGTHS, "--tension", "10..1000", "--json", "-").stdout)
    for limits in ("10N..1kN", "[10,1000]", "[10 N, 1 kN]", "10 .. 1000", "505+-495"):
        other = json.loads(run("fk", hanging, *LENGTHS, "--tension", limits, "--json", "-").stdout)
        assert other["question"] == plain["question"] and other["solutions"] == plain["solutions"]


def test_beside_a_problem_file(hanging, tmp_path):
    file = tmp_path / "problem.yaml"
    file.write_text("format: cdpr-problem/1\nlengths_m: [2, 5]\n", encoding="utf-8")
    assert run("fk", hanging, "--problem", file, "--tension", "1..2").exit_code == 4


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ("5..1", "--tension: the lower bound 5 is above the upper bound 1"),
        ("-5..-1", "--tension: a cable's tension is never negative, got the lower limit -5"),
        ("-5..1", "--tension: a cable's tension is never negative, got the lower limit -5"),
        ("5", "--tension: must be a range such as 10..1000, got '5'"),
        ("5..5", "--tension: must be a range such as 10..1000, got '5..5'"),
        ("much", "--tension: 'much' is not a number"),
        ("1..much", "--tension: 'much' is not a number"),
        ("..5", "--tension: '' is not a number"),
        ("5..", "--tension: '' is not a number"),
        ("1,2", "--tension: '1,2' is not a number"),
        ("1..inf", "--tension: 'inf' is not a finite number"),
        ("1..1e400", "--tension: '1e400' is out of range (0, or 1e-100 to 1e100 in size)"),
        ("1mm..2mm", "--tension: '1mm' is a length, not a force"),
        ("1N..2", "--tension: in '1N..2' one number has a unit: give both one, or none"),
        ("5+--1", "--tension: the tolerance of '5+--1' is negative"),
    ],
)
def test_what_is_no_range_of_tensions_is_one_line(hanging, limits, message):
    done = run("fk", hanging, *LENGTHS, "--tension", limits)
    assert (done.exit_code, done.stderr, done.stdout) == (2, f"{message}\n", "")


@pytest.mark.parametrize(
    ("robot", "more", "message"),
    [
        (
            "merlet_4_1",
            ("--lengths", "3,3,3,3", "--certificate", "x.cert"),
            "--tension: not together with --certificate, which is about poses with any tensions",
        ),
        ("merlet_4_1", ("--tensions", "1,1,1,1"), "--tension: not together with --tensions"),
        (
            "six_leg_40",
            ("--lengths", "1,1,1,1,1,1", "--ignore-tension-sign"),
            "--tension: not together with --ignore-tension-sign: such legs push, too",
        ),
    ],
)
def test_what_does_not_go_together_is_one_line(tmp_path, monkeypatch, robot, more, message):
    monkeypatch.chdir(tmp_path)
    done = run("fk", robot, *more, "--tension", "1..2")
    assert (done.exit_code, done.stderr, done.stdout) == (2, f"{message}\n", "")
    assert not (tmp_path / "x.cert").exists()


def test_the_limits_reach_the_solver_exactly(hanging, monkeypatch):
    asked: list[Problem] = []

    def solve(problem, options):
        asked.append(problem)
        return hanging_mass.answer()

    monkeypatch.setattr("solvers.point_mass.robot_class.CLASS.forward", solve)
    run("fk", hanging, *LENGTHS, "--tension", "0.1..0.3kN")
    run("fk", hanging, *LENGTHS, "--tension", "0.1N..0.3kN")
    (problem,) = asked
    assert problem.tension is not None
    assert [str(x) for x in problem.tension] == ["1/10", "300"]


JOBS = """format: cdpr-batch/1
robots: [hanging.yaml]
problems:
  - type: lengths
    tension_N: [LIMITS]
    lengths_m: [[2, 5]]
"""


@pytest.mark.parametrize(
    ("limits", "status", "code"), [("1, 2", "no-pose", 0), ("0, 98.1", "done", 3), ("98, 99", "done", 0)]
)
def test_a_batch_asks_the_same(hanging, tmp_path, limits, status, code):
    jobs, out = tmp_path / "jobs.yaml", tmp_path / "out"
    jobs.write_text(JOBS.replace("LIMITS", limits), encoding="utf-8")
    done = run("batch", jobs, "--out", out, "--threads", 1, "-q")
    assert done.exit_code == code, done.stderr
    listed = json.loads((out / "results.jsonl").read_text(encoding="utf-8"))
    assert listed["status"] == status
    shown = json.loads(run("batch", "show", out, 1, "--json").stdout)
    single = run("fk", hanging, *LENGTHS, "--tension", "..".join(limits.split(", ")), "--json", "-")
    alone = json.loads(single.stdout)
    assert shown["question"] == alone["question"] and shown["solutions"] == alone["solutions"]
    assert shown["message"] == alone["message"] and shown["outcome"] == alone["outcome"]


@pytest.mark.parametrize(
    ("limits", "more", "message"),
    [
        ("2, 1", "", "problems[0].tension_N"),
        ("-1, 1", "", "tension: a cable's tension is never negative"),
        ("1, 2", "options: {certificates: true}\n", "tension limits are not supported by certificates yet"),
        ("1, 2", "options: {ignore_tension_sign: true}\n", "tension: not together with ignore_tension_sign"),
    ],
)
def test_a_wrong_batch_is_told(hanging, tmp_path, limits, more, message):
    jobs, out = tmp_path / "jobs.yaml", tmp_path / "out"
    jobs.write_text(JOBS.replace("LIMITS", limits) + more, encoding="utf-8")
    done = run("batch", jobs, "--out", out, "--threads", 1, "-q")
    assert done.exit_code == 2 and message in done.stderr, done.stderr


def test_a_certificate_of_all_poses_is_not_of_those_within_limits(hanging, tmp_path):
    cert, file = tmp_path / "all.cert", tmp_path / "some.json"
    assert run("fk", hanging, *LENGTHS, "--certificate", cert, "-q").exit_code == 0
    assert run("fk", hanging, *LENGTHS, "--tension", "98..99", "--json", file, "-q").exit_code == 0
    done = run("report", file, "--certificate", cert, "--out", tmp_path / "r.html")
    assert done.exit_code == 5
    assert "its tension limits differ" in (tmp_path / "r.html").read_text(encoding="utf-8")
