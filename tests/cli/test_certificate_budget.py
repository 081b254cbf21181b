"""``fk --certificate`` under its budget: what time, cells and interrupts leave of it, and that this holds."""

import signal
import subprocess
import sys
import threading
import time

import pytest

import certificates
from cdpr_interval import load_robot
from certificates.verdicts import Verdict
from solvers.answers.data import Outcome
from solvers.cli import ExitCode
from solvers.forward import answer_question, pose_problem
from solvers.proofs.document import certificate_bytes
from solvers.proofs.recorder import Recorder
from solvers.questions.problem import Options
from solvers.six_dof.record import Record

PATIENCE = 30.0
"""Seconds for a process that was interrupted to end, on a machine that does other things."""


def asked(robot, lengths, **options):
    """Return a question, its options with a record, and the answer."""
    options = Options(record=Record(), **options)
    problem = pose_problem(load_robot(robot), lengths, None, None, options)
    return problem, options, answer_question(problem, options)


def held(content):
    """Return the checker's report of what must not be wrong: every claim, and a sample of the cells."""
    report = certificates.check(content, sample=40, seed=1)
    assert report.verdict in (Verdict.PROVED, Verdict.SAMPLED), report
    return report


def entries(result):
    """Return what was found, without times."""
    document = result.to_dict()
    return document["solutions"], document["undecided"], document["message"]


@pytest.mark.parametrize(("robot", "lengths"), [("uc2", "7.5,8"), ("uc3", "7.5,8,7")])
@pytest.mark.parametrize("threads", [1, 2])
def test_the_answer_is_the_same_bit_by_bit_when_it_is_recorded(robot, lengths, threads):
    options = Options(threads=threads)
    problem = pose_problem(load_robot(robot), lengths, None, None, options)
    plain, (*_, seen) = answer_question(problem, options), asked(robot, lengths, threads=threads)
    assert entries(seen) == entries(plain) and seen.outcome is Outcome.COMPLETE
    assert [s.cells for s in seen.subsets] == [s.cells for s in plain.subsets]


def test_kernels_of_certificates_are_loaded_for_certificates_only():
    code = (
        "import sys\n"
        "from solvers.commands import fk\n"
        "from solvers.six_dof.record import Record\n"
        "assert 'solvers.six_dof.cells.noted' not in sys.modules and 'numba' not in sys.modules\n"
        "Record().observer()\n"
        "assert 'solvers.six_dof.cells.noted' in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=PATIENCE * 10)


def test_one_certificate_whatever_the_threads():
    one, two = (certificate_bytes(*asked("uc3", "7.5,8,7", threads=n)) for n in (1, 2))
    assert one == two


@pytest.mark.parametrize("more", [0, 1, 500, 5_000, 12_000])
def test_cells_of_the_record_count_and_what_is_left_is_pending(more):
    cells = sum(s.cells for s in asked("uc3", "7.5,8,7")[2].subsets)
    problem, options, result = asked("uc3", "7.5,8,7", cell_limit=cells + more)
    assert result.outcome is Outcome.COMPLETE or more == 0
    report = held(certificate_bytes(problem, options, result))
    assert options.record.budget.cells <= cells + more
    assert report.solutions == 15 and not report.complete


def test_a_time_limit_that_ends_while_the_record_is_made():
    problem, options, result = asked("uc3", "7.5,8,7", time_limit=3600.0)
    assert result.outcome is Outcome.COMPLETE
    budget = options.record.budget
    budget._deadline = time.monotonic() + 0.05
    started = time.process_time()
    report = held(certificate_bytes(problem, options, result))
    assert not report.complete and time.process_time() - started < 60.0


def test_an_interrupt_while_roots_are_claimed(monkeypatch):
    problem, options, result = asked("uc3", "7.5,8,7")
    claim_roots = Recorder.claim_roots

    def interrupted(self, allowance, account):
        with allowance.spending():
            if len(self.found) > 5:
                raise KeyboardInterrupt
        claim_roots(self, allowance, account)

    monkeypatch.setattr(Recorder, "claim_roots", interrupted)
    report = held(certificate_bytes(problem, options, result))
    assert options.record.is_interrupted and not report.complete and report.solutions == 1


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_while_cells_are_recorded(monkeypatch, name):
    problem, options, result = asked("uc3", "7.5,8,7")
    look, calls = Recorder.look, []

    def signalled(self, *given):
        calls.append(self)
        if len(calls) == 2:
            signal.raise_signal(getattr(signal, name))
        look(self, *given)

    monkeypatch.setattr(Recorder, "look", signalled)
    before = signal.getsignal(signal.SIGTERM)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        report = held(certificate_bytes(problem, options, result))
    finally:
        signal.signal(signal.SIGTERM, before)
    assert options.record.is_interrupted and len(calls) == 2
    assert not report.complete and report.solutions == 15 and report.pending > 0


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_an_interrupted_process_ends_and_leaves_no_wrong_file(tmp_path, name):
    """A question whose record takes minutes, interrupted as soon as the poses are printed."""
    file = tmp_path / "out.cert"
    command = [sys.executable, "-m", "solvers", "fk", "uc4", "--lengths", "7.5,8,7,9", "--certificate", file]
    running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    timer = threading.Timer(600.0, running.kill)
    timer.start()
    lines = [running.stdout.readline() for _ in range(3)]
    assert lines[0].startswith("uc4"), lines
    running.send_signal(getattr(signal, name))
    _, errors = running.communicate(timeout=PATIENCE)
    timer.cancel()
    assert running.returncode == ExitCode.INTERRUPTED == 130, errors
    assert "Traceback" not in errors
    assert ": partial: " in errors and not held(file.read_bytes()).complete
    assert list(tmp_path.glob("*.part")) == []
