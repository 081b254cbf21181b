"""What is written as a certificate is checked at once: `fk --certificate`, and the jobs of a batch."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

import certificates
from certificates.verdicts import Report, Verdict
from solvers.batch.ledger import Ledger
from solvers.cli import ExitCode, cli
from solvers.proofs import check as proof_check

UC2 = ("fk", "uc2", "--lengths", "7.5,8")
CLAIM = "complete: 8 static poses, and no other one"


def run(*args):
    return CliRunner().invoke(cli, [str(arg) for arg in args])


def saying(verdict: Verdict, message: str):
    """Return a check that ends with a verdict, whatever it is given."""

    def check(content: bytes, **options: object) -> Report:
        return replace(certificates.check(content), verdict=verdict, message=message, complete=False)

    return check


def test_what_is_written_is_checked(tmp_path):
    file = tmp_path / "uc2.cert"
    done = run(*UC2, "--certificate", file)
    assert done.exit_code == 0 and done.stderr.splitlines()[-1] == f"{file}: {CLAIM}; checked: PROVED"
    done = run(*UC2, "--certificate", file, "--no-check")
    assert done.exit_code == 0 and done.stderr.splitlines()[-1] == f"{file}: {CLAIM}"
    assert run("check", file).exit_code == 0
    done = run(*UC2, "-q", "--certificate", file)
    assert (done.exit_code, done.stderr, done.stdout) == (0, "", "")


def test_no_check_is_about_a_certificate():
    done = run(*UC2, "--no-check")
    assert done.exit_code == ExitCode.INVALID and "--no-check: only with --certificate" in done.stderr


@pytest.mark.parametrize("quiet", [[], ["-q"]])
@pytest.mark.parametrize(
    ("verdict", "code", "said"),
    [
        (Verdict.NOT_PROVED, 5, "NOT PROVED: a leaf; this is a defect of the program"),
        (Verdict.OUT_OF_TIME, 3, f"{CLAIM}; not checked: OUT OF TIME"),
    ],
)
def test_a_check_that_does_not_confirm_decides_the_exit_code(
    tmp_path, monkeypatch, verdict, code, said, quiet
):
    monkeypatch.setattr(proof_check, "check", saying(verdict, "a leaf"))
    done = run(*UC2, *quiet, "--certificate", tmp_path / "c")
    assert done.exit_code == code and said in done.stderr and len(done.stderr.splitlines()) == 1


def test_an_interrupted_check_says_how_far_it_was(tmp_path, monkeypatch):
    def interrupted(content: bytes, **options: object) -> Report:
        raise KeyboardInterrupt("48 of 101 cells checked")

    monkeypatch.setattr(proof_check, "check", interrupted)
    file = tmp_path / "c"
    done = run(*UC2, "-q", "--certificate", file)
    assert done.exit_code == 130 and "not checked: interrupted: 48 of 101 cells checked" in done.stderr
    monkeypatch.undo()
    assert run("check", file).exit_code == 0


def batch(folder: Path) -> tuple[int, dict[str, object]]:
    jobs = folder / "jobs.yaml"
    jobs.write_text(
        "format: cdpr-batch/1\nrobots: [uc2]\nproblems:\n  - {type: lengths, lengths_m: [[7.5, 8]]}\n"
        "options: {certificates: true}\n"
    )
    done = run("batch", jobs, "--out", folder / "out", "--threads", 1)
    return done.exit_code, json.loads((folder / "out" / "summary.json").read_text())


def test_jobs_are_checked_when_they_are_done(tmp_path):
    code, summary = batch(tmp_path)
    assert code == 0 and summary["certificates"] == {"PROVED": 1}
    with Ledger.peek(tmp_path / "out") as ledger:
        (row,) = ledger.checks()
        assert (row.verdict, row.message) == ("PROVED", "8 static poses, and no other one")
