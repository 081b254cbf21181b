"""Workers of a Dask cluster; the extra ``cluster``.

The workers need this package; robots and settings travel with the jobs, the ledger stays with who asks.
"""

from __future__ import annotations

import queue
from typing import Any

from cdpr_interval.errors import InputError
from solvers.batch.executor import ExecutorError, Finished, Work
from solvers.batch.work import Chunk, solve_chunk

PATIENCE = 30.0
"""s to reach the scheduler, and for the first worker to come."""
ALIVE = ("running", "connecting")
"""States of a client that may still hear from its scheduler."""
AHEAD = 2
"""Chunks a thread of a worker has at a time: it need not wait for the next one."""


class DaskCluster:
    """An `Executor` over the workers of a scheduler.

    A worker that is lost is Dask's affair: its chunks go to others. A chunk that loses several workers is
    given up by Dask and counts as a crash.
    """

    def __init__(self, client: Any, work: Work = solve_chunk) -> None:
        self._client, self._work = client, work
        self._over: queue.SimpleQueue[tuple[Chunk, Any]] = queue.SimpleQueue()
        self._futures: set[Any] = set()

    @classmethod
    def connected(cls, address: str | None, file: str | None) -> DaskCluster:
        """Connect to the scheduler at an address, or to the one that wrote a file.

        Raises
        ------
        InputError
            Dask is not installed, or there is no scheduler or no worker.
        """
        try:
            from distributed import Client
        except ImportError:
            rule = "distributed is not installed: pip install '.[cluster]'"
            raise InputError(f"--scheduler: {rule}") from None
        if (address is None) == (file is None):
            raise InputError("--scheduler: not together with --scheduler-file")
        where = address or file
        try:
            client = Client(address=address, scheduler_file=file, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise InputError(f"--scheduler: {where}: {' '.join(str(error).split())}") from None
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            client.close()
            raise InputError(f"--scheduler: {where}: no worker in {PATIENCE:g} s") from None
        return cls(client)

    @property
    def workers(self) -> int:
        """Threads of all workers there are now."""
        return max(sum(self._client.nthreads().values()), 1)

    @property
    def free(self) -> int:
        """How many chunks may be submitted now."""
        return AHEAD * self.workers - len(self._futures)

    def grow(self) -> None:
        """All workers are there already."""

    def submit(self, chunk: Chunk) -> None:
        """Send a chunk."""
        future = self._client.submit(self._work, chunk, pure=False)
        self._futures.add(future)
        future.add_done_callback(lambda done: self._over.put((chunk, done)))

    def wait(self, seconds: float) -> list[Finished]:
        """Return what is over, at the latest after so many seconds."""
        found: list[Finished] = []
        try:
            found.append(self._finished(*self._over.get(timeout=seconds)))
            while True:
                found.append(self._finished(*self._over.get_nowait()))
        except queue.Empty:
            if not found and self._client.status not in ALIVE:
                raise ExecutorError(f"the scheduler is lost (client {self._client.status})") from None
            return found

    def _finished(self, chunk: Chunk, future: Any) -> Finished:
        self._futures.discard(future)
        if future.status == "finished":
            return Finished(chunk, future.result())
        # Only this one is the job's doing: it lost several workers.
        from distributed.scheduler import KilledWorker

        error = future.exception() if future.status == "error" else None
        if isinstance(error, KilledWorker):
            return Finished(chunk, None, f"KilledWorker: {' '.join(str(error).split())}")
        if error is None:
            raise ExecutorError(f"the scheduler gave up a task: {future.status}")
        raise ExecutorError(f"a worker cannot solve: {type(error).__name__}: {error}")

    def close(self) -> None:
        """Leave the cluster; it goes on for others."""
        for future in self._futures:
            future.cancel()
        self._client.close()
