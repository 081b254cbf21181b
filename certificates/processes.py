"""Cells checked by several processes."""

from __future__ import annotations

import math
import multiprocessing
import signal
import threading
import time
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from itertools import chain

from certificates import clock
from certificates.certificate import Certificate
from certificates.lots import Lot, Worker, in_turn

AHEAD = 4
"""Lots that wait for each process."""
WORTH = 3000
"""Cells from which on a process is worth its start."""


def together(
    certificate: Certificate, content: bytes, limit: int | None, lots: Iterator[Lot], count: int
) -> Iterator[tuple[int, int]]:
    """Yield the size of each lot, and the number of parts, in any order, of so many processes."""
    first: list[Lot] = []
    while sum(len(lot[2]) for lot in first) < WORTH:
        lot = next(lots, None)
        if lot is None:
            yield from in_turn(certificate, iter(first))
            return
        first.append(lot)
    lots = chain(first, lots)
    left = clock.left()
    given = (content, limit, math.inf if left is None else time.time() + left)
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(count, context, initializer=start_worker, initargs=given)
    sizes: dict[Future[int], int] = {}
    try:
        for lot in lots:
            with undisturbed():
                sizes[pool.submit(work, lot)] = len(lot[2])
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


def work(lot: Lot) -> int:
    """Check a lot in a process of several."""
    return worker[0].check(lot)
