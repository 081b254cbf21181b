"""Worker processes on this machine; one that dies is noticed, named and replaced.

The pools of the standard library give up all of their work when one worker dies.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess

from solvers.batch.executor import ExecutorError, Finished, Work
from solvers.batch.work import Chunk, JobOutcome, solve_chunk

_SPAWN = multiprocessing.get_context("spawn")
"""Threads of numba and forked processes do not go together."""
PATIENCE = 5.0
"""s for a worker to end by itself."""


@dataclass
class _Worker:
    process: SpawnProcess
    pipe: Connection
    chunk: Chunk | None = None
    has_begun: bool = False
    """It has said so: what kills it from now on are its jobs."""


class ProcessPool:
    """An `Executor` of processes. The first one starts alone; `grow` lets the others come.

    Parameters
    ----------
    workers : int
        Number of processes.
    work : callable
        What they do with a chunk; a function that new processes can import.
    """

    def __init__(self, workers: int, work: Work = solve_chunk) -> None:
        self._count, self._most, self._work = 1, workers, work
        self._workers: list[_Worker] = []

    @property
    def workers(self) -> int:
        """Number of processes, once all are there."""
        return self._most

    @property
    def free(self) -> int:
        """How many chunks may be submitted now."""
        return self._count - sum(worker.chunk is not None for worker in self._workers)

    def grow(self) -> None:
        """Let all processes come."""
        self._count = self._most

    def submit(self, chunk: Chunk) -> None:
        """Give a chunk to a process that has none, or to a new one."""
        # One that died while it had nothing to do is no job's crash.
        self._workers = [one for one in self._workers if one.chunk is not None or one.process.is_alive()]
        worker = next((worker for worker in self._workers if worker.chunk is None), None)
        if worker is None:
            worker = _started(self._work)
            self._workers.append(worker)
        worker.chunk = chunk
        try:
            worker.pipe.send(chunk)
        except OSError:
            # It died meanwhile; `wait` finds that out.
            return

    def wait(self, seconds: float) -> list[Finished]:
        """Return what is over, at the latest after so many seconds."""
        busy = {worker.pipe: worker for worker in self._workers if worker.chunk is not None}
        found = []
        for pipe in wait(list(busy), seconds):
            worker = busy[pipe]  # type: ignore[index]
            assert worker.chunk is not None
            try:
                outcomes: list[JobOutcome] | None = worker.pipe.recv()
            except (EOFError, OSError):
                message = self._bury(worker)
                if not worker.has_begun:
                    raise ExecutorError(f"no worker process can start: {message}") from None
                found.append(Finished(worker.chunk, None, message))
                continue
            if outcomes is None:
                worker.has_begun = True
            else:
                found.append(Finished(worker.chunk, outcomes))
                worker.chunk = None
        return found

    def _bury(self, worker: _Worker) -> str:
        """Forget a process that died, and return how."""
        self._workers.remove(worker)
        worker.process.join(PATIENCE)
        worker.pipe.close()
        code = worker.process.exitcode
        if code is None:
            worker.process.kill()
            return "the worker closed its pipe"
        if code < 0:
            return f"the worker was killed by {signal.Signals(-code).name}"
        return f"the worker ended with code {code}"

    def close(self) -> None:
        """End all processes, also those that are at work."""
        for worker in self._workers:
            if worker.chunk is not None:
                worker.process.terminate()
            worker.pipe.close()
        for worker in self._workers:
            worker.process.join(PATIENCE)
            if worker.process.is_alive():
                worker.process.kill()
                worker.process.join(PATIENCE)
        self._workers.clear()


def _started(work: Work) -> _Worker:
    ours, theirs = _SPAWN.Pipe()
    process = _SPAWN.Process(target=_serve, args=(theirs, work), name="batch worker", daemon=True)
    process.start()
    # Only the worker holds its end: when it dies, ours is at its end of file.
    theirs.close()
    return _Worker(process, ours)


def _serve(pipe: Connection, work: Work) -> None:
    """Solve chunks until there are no more, or until whoever asks is gone."""
    # Ctrl-C is for the process that asks; it ends the others.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_watch_parent, daemon=True).start()
    pipe.send(None)
    while True:
        try:
            chunk = pipe.recv()
        except (EOFError, OSError):
            return
        pipe.send(work(chunk))


def _watch_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
