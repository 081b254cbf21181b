"""The loop of a batch: pending jobs to an executor in chunks, outcomes to the ledger, crashes one by one."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from solvers.batch.executor import Executor, Finished
from solvers.batch.ledger import Ledger, Pending
from solvers.batch.work import Chunk, JobOutcome, Status

CHUNK_SECONDS = 0.5
"""Work of a chunk: long beside the cost of sending it, short for whoever looks at the progress."""
LARGEST_CHUNK = 500
SHARE_OF_REST = 4
"""A chunk is at most the rest of the jobs divided by this and by the workers, so that all end together."""
RECORD_SECONDS = 0.5
"""Outcomes are recorded at the latest after so long: this is what a kill of everything can cost."""
FIRST_CELLS = 200
"""After which a job that is only begun to have kernels compiled ends."""
TICK = 0.2
"""s between two looks when nothing happens."""


@dataclass(frozen=True)
class BatchProgress:
    """How far a batch is."""

    done: int
    total: int
    rate: float
    """Jobs per second of this run."""
    remaining: float | None
    """s; None: not known yet."""
    bad: int
    """Jobs that failed or crashed."""


class BatchRun:
    """One run over the pending jobs of a ledger.

    Parameters
    ----------
    ledger : Ledger
        Opened for writing.
    executor : Executor
    report : callable
        Called with a `BatchProgress` after every record.
    """

    def __init__(self, ledger: Ledger, executor: Executor, report: Callable[[BatchProgress], None]) -> None:
        self._ledger, self._executor, self._report = ledger, executor, report
        self._settings = ledger.settings().to_json()
        self._files = {digest: data for digest, (_, _, data) in ledger.robots().items()}
        counts = ledger.counts(with_parts=True)
        self._total = sum(counts.values())
        self._left = counts[Status.PENDING]
        self._bad = counts[Status.FAILED] + counts[Status.CRASHED]
        self._queue: deque[Pending] = deque()
        self._alone: deque[Chunk] = deque()
        self._unrecorded: list[JobOutcome] = []
        self._recorded_at = self._begun = time.monotonic()
        self._ended = 0
        self._seconds = 0.0
        self._under_way = 0
        self._grown = False
        self._has_parts = ledger.settings().split is not None

    def run(self) -> None:
        """Solve every pending job; whatever ends this, outcomes that came in are recorded."""
        try:
            # Jobs with parts come when these are done.
            while self._fill():
                if self._executor.workers > 1 and not self._grown:
                    self._compile()
                while self._submit():
                    self._collect()
                self._record()
        finally:
            self._record()

    def _fill(self) -> bool:
        """Queue what can be done now; return whether there is anything."""
        for pending in self._ledger.pending():
            parts = self._ledger.parts(pending.task.number) if self._has_parts else []
            bad = next((part for part in parts if part.answer is None), None)
            if bad is None:
                inputs = tuple((part.input, part.answer or "") for part in parts)
                self._queue.append(replace(pending, task=replace(pending.task, parts=inputs)))
            else:
                message, now = f"part {bad.number} {bad.status.value}: {bad.message}", time.time()
                self._take([JobOutcome(pending.task.number, bad.status, None, message, now, 0.0, "")])
        return bool(self._queue)

    def _compile(self) -> None:
        """Let one worker begin a job of each robot and drop what comes out: others find kernels compiled."""
        settings = replace(self._ledger.settings(), cell_limit=FIRST_CELLS).to_json()
        first = {pending.robot: pending for pending in reversed(self._queue)}
        for pending in first.values():
            self._executor.submit(replace(self._chunk([pending]), settings=settings))
            while not self._executor.wait(TICK):
                pass
        self._executor.grow()
        self._grown = True

    def _submit(self) -> bool:
        """Start as many chunks as there is room for; return whether there is work under way."""
        while self._executor.free > 0 and (chunk := self._next_chunk()) is not None:
            self._executor.submit(chunk)
            self._under_way += 1
        return self._under_way > 0

    def _next_chunk(self) -> Chunk | None:
        if self._alone:
            return self._alone.popleft()
        if not self._queue:
            return None
        robot, taken = self._queue[0].robot, []
        for _ in range(self._chunk_size()):
            if not self._queue or self._queue[0].robot != robot:
                break
            taken.append(self._queue.popleft())
        return self._chunk(taken)

    def _chunk_size(self) -> int:
        each = self._seconds / max(self._ended, 1)
        by_time = CHUNK_SECONDS / max(each, 1e-9)
        by_rest = len(self._queue) / (SHARE_OF_REST * self._executor.workers)
        return max(1, min(int(by_time), int(by_rest), LARGEST_CHUNK))

    def _chunk(self, jobs: list[Pending]) -> Chunk:
        tasks = tuple(job.task for job in jobs)
        return Chunk(self._files[jobs[0].robot], self._settings, tasks)

    def _collect(self) -> None:
        """Take what is over, and record it when it is time."""
        for finished in self._executor.wait(TICK):
            self._under_way -= 1
            if finished.outcomes is None:
                self._after_crash(finished)
            else:
                self._take(finished.outcomes)
        if time.monotonic() - self._recorded_at > RECORD_SECONDS:
            self._record()

    def _take(self, outcomes: Sequence[JobOutcome]) -> None:
        self._unrecorded += outcomes
        self._ended += len(outcomes)
        self._seconds += sum(outcome.seconds for outcome in outcomes)

    def _after_crash(self, finished: Finished) -> None:
        """Let the jobs of a dead worker run alone; one that was alone already is marked."""
        chunk = finished.chunk
        if chunk.is_retry:
            (task,) = chunk.tasks
            now = time.time()
            self._take([JobOutcome(task.number, Status.CRASHED, None, finished.message, now, 0.0, "")])
            return
        self._ledger.count_attempts(task.number for task in chunk.tasks)
        self._alone.extend(replace(chunk, tasks=(task,), is_retry=True) for task in chunk.tasks)

    def _record(self) -> None:
        rows, self._unrecorded = self._unrecorded, []
        self._ledger.record(rows)
        self._recorded_at = time.monotonic()
        self._left -= len(rows)
        self._bad += sum(row.status in (Status.FAILED, Status.CRASHED) for row in rows)
        elapsed = time.monotonic() - self._begun
        rate = self._ended / max(elapsed, 1e-9)
        remaining = self._left / rate if self._ended else None
        self._report(BatchProgress(self._total - self._left, self._total, rate, remaining, self._bad))
