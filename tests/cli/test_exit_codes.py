"""One class of verdict, one exit code, one line: whichever command says it."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

import certificates
from certificates import verdicts
from certificates.container import read, write
from certificates.tree import Node
from certificates.verdicts import Conclusion, Verdict
from solvers.answers.data import StopReason
from solvers.cli import COMMANDS, Ending, ExitCode, cli
from solvers.proofs.claimed import claimed, unclaimed
from tests.support import hanging_mass
from tests.support.made_certificates import changed, leaf, platform

PAGE = Path(__file__).parents[2] / "docs" / "exit-codes.md"
PATIENCE = 60.0
"""Seconds for a process to end, on a machine that does other things."""


def run(*args):
    return CliRunner().invoke(cli, [str(arg) for arg in args])


def process(*args, **options):
    return subprocess.run(
        [sys.executable, "-m", *map(str, args)], capture_output=True, text=True, timeout=PATIENCE, **options
    )


def rows():
    found = re.findall(r"^\| (\d+) \| ([^|]+) \| (.+) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    return [(int(code), re.findall(r"`([a-z -]+)`", who) or [who], text) for code, who, text in found]


def test_the_page_has_every_code_and_every_command():
    assert {code for code, _, _ in rows()} == set(ExitCode)
    named = {name for _, names, _ in rows() for name in names} - {"every command"}
    assert {name.split()[0] for name in named} == set(COMMANDS) - {"robots"}
    assert len({(code, *names) for code, names, _ in rows()}) == len(rows()), "a row for each, once"
    assert [code for code, _, _ in rows()] == sorted(code for code, _, _ in rows())


def test_the_page_has_the_verdicts_of_the_checker():
    for conclusion in Conclusion:
        codes = {code for code, names, text in rows() if names == ["check"] and str(conclusion) in text}
        assert conclusion.exit_code in codes, conclusion
    assert {Conclusion.of(v, c).exit_code for v in Verdict for c in (True, False)} <= set(ExitCode)
    assert set(verdicts.EXIT_CODES) == set(verdicts.REMARKS) == set(Conclusion)


def test_every_code_has_a_line_of_its_own(monkeypatch):
    assert len({code.meaning for code in ExitCode}) == len(ExitCode)
    for code in ExitCode:
        monkeypatch.setattr(
            "solvers.commands.validate.command.callback", lambda robot, code=code, **_: int(code)
        )
        result = run("validate", "uc2")
        assert result.exit_code == code and result.stdout == ""
        assert result.stderr == (f"{code.meaning}\n" if code else "")
    ending = Ending(ExitCode.INCOMPLETE, "why")
    monkeypatch.setattr("solvers.commands.validate.command.callback", lambda robot, **_: ending)
    result = run("validate", "uc2")
    assert (result.exit_code, result.stderr) == (3, "why\n")


@pytest.fixture
def hanging(tmp_path):
    path = tmp_path / "hanging.yaml"
    path.write_text(hanging_mass.TEXT, encoding="utf-8")
    return path


@pytest.fixture
def answered(hanging, tmp_path):
    """Return a result with its certificate, proved."""
    result, file = tmp_path / "r.json", tmp_path / "r.cert"
    done = run("fk", hanging, "--lengths", "2,5", "--json", result, "--certificate", file)
    assert done.exit_code == 0
    # Before it, where kernels are compiled, that is said.
    assert (
        done.stderr.splitlines()[-1] == f"{file}: complete: 1 static pose, and no other one; checked: PROVED"
    )
    return hanging, result, file


def partial(file):
    """Let the certificate claim less: true, but not that there is no other pose."""
    document = read(file)
    document["subsets"] = [{"taut": entry["taut"], "pending": "forgotten"} for entry in document["subsets"]]
    return {**document, "solutions": [], "not_certified": [{"taut": [0], "reason": "forgotten"}]}


BREAK = {
    Conclusion.PROVED: lambda file: None,
    Conclusion.PARTIAL: lambda file: write(file, partial(file)),
    Conclusion.NOT_PROVED: lambda file: write(
        file, changed(read(file), "solutions", 0, "stability", value="unstable")
    ),
    Conclusion.MALFORMED: lambda file: file.write_bytes(file.read_bytes()[:-1]),
}


@pytest.mark.parametrize("conclusion", BREAK)
def test_every_command_says_the_same_of_a_certificate(answered, tmp_path, conclusion):
    hanging, result, file = answered
    BREAK[conclusion](file)
    code = conclusion.exit_code
    page = tmp_path / "page.html"
    report = run("report", result, "--robot", hanging, "--certificate", file, "--out", page)
    ways = [run("check", file), run("check", "-q", file), run("check", file, "--robot", hanging), report]
    assert [way.exit_code for way in ways] == [code] * 4
    assert [len(way.stderr.splitlines()) for way in ways] == [1 if code else 0] * 4
    for way in ways[:3]:
        assert way.stdout.startswith(f"{conclusion}: ") and way.stdout.count(str(conclusion)) == 1
    alone = process("certificates", file, "-q")
    assert (alone.returncode, alone.stdout, alone.stderr) == (code, ways[1].stdout, ways[1].stderr)
    text = page.read_text(encoding="utf-8")
    assert str(conclusion) in text and ("judgement good" in text or 'class="good"' in text) == (code == 0)


def test_what_a_certificate_claims_is_counted_as_the_checker_does(answered, tmp_path):
    _, _, file = answered
    documents = [read(file), partial(file)]
    documents.append(platform(*[leaf(Node.UNDECIDED, 2)] * 4))
    documents.append(platform(*[leaf(Node.PENDING, 2)] * 4))
    uc2 = tmp_path / "uc2.cert"
    for limits in ([], ["--cell-limit", "1"], ["--cell-limit", "60"]):
        run("fk", "uc2", "--lengths", "7.5,8", "-q", "--certificate", uc2, *limits)
        documents.append(read(uc2))
    for document in documents:
        write(file, document)
        report = certificates.check(file)
        claim = claimed(document)
        assert report.verdict is Verdict.PROVED, report
        assert (claim.conclusion, claim.message) == (report.conclusion, report.message)


def test_nodes_of_a_tree_follow_each_other():
    cut = bytes([Node.CUT, 0b101]) + bytes([Node.PENDING]) * 32
    others = bytes([Node.TOO_LONG, Node.PENDING, Node.UNBALANCED, *[Node.UNDECIDED] * 24, Node.ROOT, 0])
    assert unclaimed(cut + others + bytes([Node.PENDING, Node.UNDECIDED, Node.PENDING])) == (2, 1)


@pytest.mark.parametrize("quiet", [[], ["-q"]])
def test_a_complete_answer_with_a_partial_certificate_is_not_complete(hanging, tmp_path, monkeypatch, quiet):
    monkeypatch.setattr("solvers.proofs.entries.point_entry", lambda *given: {"pending": "hopeless"})
    given = ("--lengths", "2,5", "--certificate", tmp_path / "c", *quiet)
    done = run("fk", hanging, *given)
    line = "partial: 0 static poses; others may exist: 1 pending, 0 undecided, 1 not certified"
    why = [] if quiet else ["1 pose not certified: not recorded", "1 subset pending: hopeless"]
    said = [f"{tmp_path / 'c'}: {line}; checked: PROVED (partial)", *why]
    assert (done.exit_code, done.stderr.splitlines()) == (3, said)
    done = run("check", tmp_path / "c", *quiet)
    assert done.exit_code == 3 and done.stdout.splitlines()[1:][-2:] == why
    # Proved that there is none, but not in the file.
    done = run("fk", hanging, "--lengths", "1,1", "--certificate", tmp_path / "c", *quiet)
    assert done.exit_code == 3 and ": partial: 0 static poses; others may exist" in done.stderr


def test_an_interrupted_answer_stays_interrupted(hanging, tmp_path, monkeypatch):
    """Whatever its certificate claims."""
    answer = replace(hanging_mass.answer(), stop_reason=StopReason.INTERRUPTED, pending=3)
    monkeypatch.setattr("solvers.point_mass.robot_class.CLASS.forward", lambda problem, options: answer)
    monkeypatch.setattr("solvers.proofs.entries.point_entry", lambda *given: {"pending": "hopeless"})
    done = run("fk", hanging, "--lengths", "2,5", "-q", "--certificate", tmp_path / "c")
    said = done.stderr.splitlines()
    assert done.exit_code == 130 and ": partial: " in said[0] and said[1].startswith("interrupted: ")


def test_a_cut_off_certificate_is_said_to_be_partial(tmp_path, monkeypatch):
    """The answer is there in time, the certificate is not."""
    from solvers.proofs import entries

    allowance = entries.Allowance

    def spent(budget):
        budget._deadline = time.monotonic()
        return allowance(budget)

    monkeypatch.setattr(entries, "Allowance", spent)
    file = tmp_path / "c"
    done = run("fk", "uc2", "--lengths", "7.5,8", "--time-limit", "600", "-q", "--certificate", file)
    assert done.exit_code == 3 and ": partial: " in done.stderr and len(done.stderr.splitlines()) == 1
    assert run("check", file).exit_code == 3


def test_no_pose_is_proved_and_none_found_is_not(hanging, tmp_path):
    def batch(name, robot, problem):
        jobs = tmp_path / f"{name}.yaml"
        jobs.write_text(f"format: cdpr-batch/1\nrobots: [{robot}]\nproblems:\n  - {problem}\n")
        done = run("batch", jobs, "--out", tmp_path / name, "--threads", 1)
        assert done.exit_code != 2, done.stderr
        return done, json.loads((tmp_path / name / "summary.json").read_text())["jobs"]

    done, jobs = batch("none", hanging.name, "{type: lengths, lengths_m: [[1, 1], [2, 5]]}")
    assert (done.exit_code, done.stderr) == (0, "") and (jobs["no-pose"], jobs["done"]) == (1, 1)
    # Above its exit points a mass cannot hang.
    grid = "{type: poses, position_m: {x: 1, y: 1.5, z: {from: -2, to: 5, count: 2}}}"
    done, jobs = batch("found", "merlet_4_1_k100", grid)
    assert done.exit_code == 6 and jobs["none-found"] >= 1 and jobs["no-pose"] == 0
    (first, *_) = done.stdout.splitlines()
    assert "none-found; " in first and "nothing is proved" in first
    assert len(done.stderr.splitlines()) == 1 and "nothing is proved" in done.stderr


@pytest.fixture(scope="module")
def long(tmp_path_factory):
    """A certificate whose check takes a quarter of a minute in one process."""
    file = tmp_path_factory.mktemp("long") / "long.cert"
    question = ("fk", "uc4", "--lengths", "7.5,8,7,9", "-q", "--no-check", "--certificate", file)
    assert run(*question).exit_code == 0
    return file


@pytest.mark.slow
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
@pytest.mark.parametrize("program", [["solvers", "check"], ["certificates"]])
def test_a_check_is_interrupted(long, name, program):
    interrupted([*program, long, "--threads", 1], name)


def interrupted(arguments, name):
    """Send a signal to a process that has been at work for a moment; it says so, with code 130."""
    command = [sys.executable, "-m", *map(str, arguments)]
    running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        time.sleep(3.0)
        assert running.poll() is None, running.communicate()
        running.send_signal(getattr(signal, name))
        output, errors = running.communicate(timeout=PATIENCE)
    finally:
        running.kill()
    assert (running.returncode, output) == (130, "")
    assert re.fullmatch(r"interrupted(: \d+ of \d+ (subsets examined, no cell|cells) checked)?\n", errors)


def test_an_interrupted_report_leaves_the_old_one(answered, tmp_path, monkeypatch):
    hanging, result, file = answered
    page = tmp_path / "page.html"
    page.write_text("old")

    def stopped(*given):
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(PATIENCE)

    monkeypatch.setattr("solvers.report.page.result_page", stopped)
    done = run("report", result, "--robot", hanging, "--certificate", file, "--out", page)
    assert (done.exit_code, done.stderr) == (130, "interrupted\n")
    assert page.read_text() == "old" and not list(tmp_path.glob(".*"))


def test_time_limits_of_report_and_polynomial(answered, tmp_path, monkeypatch):
    hanging, result, file = answered
    page = tmp_path / "page.html"
    given = ("--robot", hanging, "--certificate", file, "--out", page, "--time-limit", 1e-9)
    done = run("report", result, *given)
    assert done.exit_code == 3 and done.stderr.startswith("certificate: OUT OF TIME")
    assert "OUT OF TIME" in page.read_text(encoding="utf-8")

    def working(*given, **more):
        # Many short waits: the end of the time is seen between two of them.
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            time.sleep(0.01)

    monkeypatch.setattr("solvers.polynomial.polynomial_report", working)
    done = run("polynomial", "merlet_4_1", "--lengths", "2.7,3.9,3.4,4.4", "--time-limit", "50ms")
    assert (done.exit_code, done.stdout) == (3, "")
    assert done.stderr == "stopped at the time limit: there is no eliminant yet\n"
