"""Cells checked one after the other, or by several processes."""

from __future__ import annotations

import math
import multiprocessing
import signal
import threading
import time
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from itertools import chain, islice

from certificates import clock
from certificates.arithmetic.forms import Array
from certificates.certificate import Certificate, about
from certificates.leaves import Cells
from certificates.searches import Searches

Chunk = tuple[int, int, Cells, Array]
"""A subset, its search, some cells of one kind, and which of them are looked at twice."""
AHEAD = 4
"""Chunks that wait for each process."""


class Worker:
    """Checks cells; the searches of the subset at hand are kept."""

    def __init__(self, certificate: Certificate) -> None:
        self.certificate = certificate
        self.at: tuple[int, Searches] | None = None

    def check(self, chunk: Chunk) -> int:
        """Check some cells; return the number of parts it took."""
        k, place, cells, twice = chunk
        with about(self.certificate.name(k)):
            if self.at is None or self.at[0] != k:
                self.at = k, self.certificate.searches(k)
            return self.at[1].check(place, cells, twice)


def in_turn(certificate: Certificate, chunks: Iterator[Chunk]) -> Iterator[tuple[int, int]]:
    """Yield the size of each chunk, and the number of parts, once it is checked."""
    one = Worker(certificate)
    for chunk in chunks:
        yield len(chunk[2]), one.check(chunk)


def together(
    certificate: Certificate, content: bytes, limit: int | None, chunks: Iterator[Chunk], count: int
) -> Iterator[tuple[int, int]]:
    """Yield the same, in any order, of so many processes; what is one chunk is not worth one."""
    first = list(islice(chunks, 2))
    if len(first) < 2:
        yield from in_turn(certificate, iter(first))
        return
    chunks = chain(first, chunks)
    left = clock.left()
    given = (content, limit, math.inf if left is None else time.time() + left)
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(count, context, initializer=start_worker, initargs=given)
    sizes: dict[Future[int], int] = {}
    try:
        for chunk in chunks:
            with undisturbed():
                sizes[pool.submit(work, chunk)] = len(chunk[2])
            while len(sizes) >= AHEAD * count:
                yield from ended(sizes)
        while sizes:
            yield from ended(sizes)
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def ended(sizes: dict[Future[int], int]) -> Iterator[tuple[int, int]]:
    """Wait, and yield what has ended."""
    done, _ = wait(sizes, clock.left(), FIRST_COMPLETED)
    clock.in_time()
    yield from ((sizes.pop(future), future.result()) for future in done)


@contextmanager
def undisturbed() -> Iterator[None]:
    """Let Ctrl-C and SIGTERM wait: a process just being started would be left with half of its orders."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = {n: signal.signal(n, lambda number, frame: came.append(number)) for n in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if came:
        signal.raise_signal(came[0])


worker: list[Worker] = []
"""Of this process, if it is one of several."""


def start_worker(content: bytes, limit: int | None, end: float) -> None:
    """Read the certificate in a process, which leaves interrupts to its parent; ``end`` is a `time.time`."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    clock.END.set(time.monotonic() + end - time.time())
    worker.append(Worker(Certificate(content, limit)))


def work(chunk: Chunk) -> int:
    """Check a chunk in a process of several."""
    return worker[0].check(chunk)
