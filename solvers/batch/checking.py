"""The certificates of a batch, every one given to the independent checker."""

from __future__ import annotations

import multiprocessing
import signal
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from cdpr_interval.text.count import counted
from certificates.verdicts import Conclusion
from solvers.answers.result import Result
from solvers.batch.campaign import result_of, robot_of
from solvers.batch.ledger import CheckRow, Ledger
from solvers.batch.run import RECORD_SECONDS, BatchProgress
from solvers.proofs.check import REFUSED, proof_of


def check_batch(
    ledger: Ledger, processes: int, time_limit: float | None, report: Callable[[BatchProgress], None]
) -> Counter[str]:
    """Check all certificates of a ledger, record what comes out, and return how many have each verdict.

    Parameters
    ----------
    ledger : Ledger
        Opened for writing.
    processes : int
    time_limit : float, optional
        s for each certificate.
    report : callable
        Called with a `BatchProgress` now and then.

    Raises
    ------
    KeyboardInterrupt
        Ctrl-C, with a text that says how many were checked: these are recorded.

    Guarantee
    ---------
    A verdict is about the job as it stands in the ledger: a certificate of another robot, of other lengths
    or of other poses is NOT PROVED.
    """
    numbers = ledger.certified()
    verdicts: Counter[str] = Counter()
    rows: list[CheckRow] = []
    begun = recorded_at = time.monotonic()
    others = set(multiprocessing.active_children())
    report(BatchProgress(0, len(numbers), 0.0, None, 0))
    pool = ProcessPoolExecutor(processes, multiprocessing.get_context("spawn"), initializer=_leave_interrupts)
    try:
        for row in pool.map(partial(check_job, ledger.folder, time_limit), numbers):
            rows.append(row)
            verdicts[row.verdict] += 1
            done, now = verdicts.total(), time.monotonic()
            if now - recorded_at > RECORD_SECONDS or done == len(numbers):
                ledger.record_checks(rows)
                rows, recorded_at = [], now
                rate = done / max(now - begun, 1e-9)
                bad = sum(verdicts[conclusion] for conclusion in REFUSED)
                report(BatchProgress(done, len(numbers), rate, (len(numbers) - done) / rate, bad))
    except KeyboardInterrupt:
        ledger.record_checks(rows)
        for process in set(multiprocessing.active_children()) - others:
            process.terminate()
        said = f"{verdicts.total()} of {counted(len(numbers), 'certificate')} checked"
        raise KeyboardInterrupt(said) from None
    finally:
        pool.shutdown(cancel_futures=True)
    return verdicts


def _leave_interrupts() -> None:
    """Let a process leave Ctrl-C to its parent, which ends it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def check_job(folder: Path, time_limit: float | None, number: int) -> CheckRow:
    """Check the certificate of one job."""
    with Ledger.peek(folder) as ledger:
        content = ledger.certificate(number)
        assert content is not None
        job = ledger.job(number)
        if job is None or job.answer is None:
            return CheckRow(number, Conclusion.NOT_PROVED.value, "the job has no answer")
        robot, result = robot_of(ledger, number), Result.from_json(result_of(ledger, number))
    proof = proof_of(robot, result, content, time_limit)
    return CheckRow(number, proof.conclusion.value, proof.message)
