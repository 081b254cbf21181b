"""Branch and prune over a store of cells, with threads, budgets and partial results."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.batches import CHILDREN
from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.engine.depth_first import MAX_CHILDREN
from cdpr_interval.engine.per_thread import per_thread
from cdpr_interval.kernels.lanes import LANES

Cells = NDArray[np.float64]

CHUNK_CELLS = 20_000
"""Cells a thread that works alone looks at before it reports: about 50 ms, the reaction time to Ctrl-C."""
SHARED_CHUNK_CELLS = 1_500
"""The same with several threads: about 4 ms, the longest that one waits for another at the end."""
HUNGRY_CHUNK_CELLS = 200
"""The same while another thread has nothing to do: it waits no longer than that for a share."""
STACK_ROWS = 4_096
"""Rows of a thread's stack: depth-first search holds a few rows a level, beside its start cells."""
LEAF_ROWS = 4_096
"""Leaves a chunk may return before it reports."""
BLOCK_ROWS = 256
"""Most cells handed to one chunk."""
REPORT_SECONDS = 0.1
"""Least time between two progress reports."""


@dataclass(frozen=True)
class Exploration:
    """What ``depth_first`` did to one stack."""

    pending: Cells
    leaves: Cells
    kinds: NDArray[np.int64]
    cells: int


@dataclass(frozen=True)
class SearchResult:
    """Leaves in lexicographic order, and the cells that were not looked at."""

    leaves: Cells
    kinds: NDArray[np.int64]
    pending: Cells
    cells: int
    stop: Stop


class Frame:
    """The arrays one thread works in; ``run`` is a compiled caller of ``depth_first`` or ``batches``."""

    def __init__(self, width: int) -> None:
        self.stack = np.empty((STACK_ROWS, width))
        self.leaves = np.empty((LEAF_ROWS, width))
        self.kinds = np.empty(LEAF_ROWS, dtype=np.int64)
        self.children = np.empty((max(MAX_CHILDREN, CHILDREN * LANES), width))


own_frame = per_thread(Frame)

Run = Callable[[Cells, int, Cells, NDArray[np.int64], Cells, int], tuple[int, int, int]]
"""``run(stack, count, leaves, kinds, children, cell_limit) -> (count, n_leaves, cells)``: a closure over
the compiled problem and its context that calls ``depth_first`` or ``batches``. One call runs in one
thread."""


def explore(run: Run, frame: Frame, cells: Cells, cell_limit: int) -> Exploration:
    """Run the problem on at most ``cell_limit`` cells, starting from ``cells``."""
    count = len(cells)
    frame.stack[:count] = cells
    count, n, done = run(frame.stack, count, frame.leaves, frame.kinds, frame.children, cell_limit)
    return Exploration(frame.stack[:count].copy(), frame.leaves[:n].copy(), frame.kinds[:n].copy(), done)


class Store:
    """The pending cells, as a stack of blocks small enough that all threads find one."""

    def __init__(self, cells: Cells, threads: int) -> None:
        self.blocks: list[Cells] = []
        self.threads = threads
        self.push(cells)

    def push(self, cells: Cells) -> None:
        """Add cells, cut into a few blocks for each thread."""
        share = len(cells) if self.threads == 1 else -(-len(cells) // (2 * self.threads))
        rows = max(1, min(BLOCK_ROWS, share))
        self.blocks.extend(cells[i : i + rows] for i in range(0, len(cells), rows))

    def pop(self) -> Cells:
        """Take the newest block."""
        return self.blocks.pop()

    def rows(self, width: int) -> Cells:
        """Return all pending cells."""
        return np.concatenate([*self.blocks, np.empty((0, width))])

    @property
    def count(self) -> int:
        """Number of pending cells."""
        return sum(map(len, self.blocks))

    @property
    def volume(self) -> float:
        """Share of the search volume that is pending."""
        return float(sum(block[:, -1].sum() for block in self.blocks))


Report = Callable[[int, int, float], None]
"""``report(cells of this search, pending cells, volume left)``."""


class Search:
    """One search: threads take blocks from the store until it is empty or the budget is spent."""

    def __init__(
        self, make_run: Callable[[], Run], cells: Cells, budget: Budget, threads: int, report: Report | None
    ) -> None:
        self.make_run = make_run
        self.width = cells.shape[1]
        self.store = Store(cells, threads)
        self.budget = budget
        self.threads = threads
        self.chunk_cells = CHUNK_CELLS if threads == 1 else min(CHUNK_CELLS, SHARED_CHUNK_CELLS)
        self.report = report
        self.lock = threading.Condition()
        self.busy = 0
        self.cells = 0
        self.leaves: list[Cells] = [np.empty((0, self.width))]
        self.kinds: list[NDArray[np.int64]] = [np.empty(0, dtype=np.int64)]
        self.last_report = time.monotonic()

    def solve(self) -> SearchResult:
        """Run to the end or until the budget is spent."""
        if self.threads == 1:
            self.work()
        else:
            self.solve_in_threads()
        return self.result()

    def solve_in_threads(self) -> None:
        """Run ``threads`` workers; the calling thread waits and reports."""
        with ThreadPoolExecutor(self.threads) as pool:
            workers: list[Future[None]] = [pool.submit(self.work) for _ in range(self.threads)]
            while not all(worker.done() for worker in workers):
                wait(workers, timeout=REPORT_SECONDS)
                self.tell()
            for worker in workers:
                worker.result()

    def work(self) -> None:
        """Take blocks until none is left anywhere or the budget is spent."""
        run = self.make_run()
        frame = own_frame(self.width)
        while True:
            block = self.take()
            if block is None:
                return
            done: Exploration | None = None
            allowed = self.budget.reserve(self.chunk())
            try:
                if allowed:
                    done = explore(run, frame, block, allowed)
            finally:
                self.give_back(block, done, allowed)
            if not allowed:
                return
            if self.threads == 1:
                self.tell()

    def chunk(self) -> int:
        """Return how many cells to look at before the pending ones are shared again."""
        hungry = self.busy < self.threads and not self.store.blocks
        return min(self.chunk_cells, HUNGRY_CHUNK_CELLS) if hungry else self.chunk_cells

    def take(self) -> Cells | None:
        """Return a block, or None when all work is done; waits while others may still add cells."""
        with self.lock:
            while not self.store.blocks:
                if self.busy == 0:
                    return None
                self.lock.wait()
            self.busy += 1
            return self.store.pop()

    def give_back(self, block: Cells, done: Exploration | None, allowed: int) -> None:
        """Store what a chunk left; an unexplored block goes back whole."""
        with self.lock:
            self.busy -= 1
            if done is None:
                self.store.push(block)
                self.budget.settle(allowed, 0)
            else:
                self.store.push(done.pending)
                self.leaves.append(done.leaves)
                self.kinds.append(done.kinds)
                self.cells += done.cells
                self.budget.settle(allowed, done.cells)
            self.lock.notify_all()

    def tell(self) -> None:
        """Report progress, not too often."""
        now = time.monotonic()
        if self.report is None or now - self.last_report < REPORT_SECONDS:
            return
        self.last_report = now
        with self.lock:
            state = self.cells, self.store.count, self.store.volume
        self.report(*state)

    def result(self) -> SearchResult:
        """Collect leaves in an order that does not depend on threads."""
        leaves = np.concatenate(self.leaves)
        kinds = np.concatenate(self.kinds)
        if len(leaves) > 1:
            order = np.lexsort((kinds, *leaves.T[::-1]))
            leaves, kinds = leaves[order], kinds[order]
        pending = self.store.rows(self.width)
        stop = Stop.EXHAUSTED
        if len(pending):
            stop = self.budget.stop() or Stop.INTERRUPTED
        return SearchResult(leaves, kinds, pending, self.cells, stop)


def search(
    make_run: Callable[[], Run],
    cells: Cells,
    budget: Budget,
    *,
    threads: int = 1,
    report: Report | None = None,
) -> SearchResult:
    """Explore ``cells`` with a compiled problem until every cell is empty or a leaf.

    Parameters
    ----------
    make_run
        Makes the ``Run`` of one thread (its own scratch arrays).
    cells : (n, width)
        Start cells.
    budget
        Time and cells that may be spent; shared with other searches.
    threads
        Number of threads; the leaves do not depend on it.
    report
        Progress callback, called from the calling thread.

    Guarantee
    ---------
    Every start cell is covered by cells proved empty, ``leaves`` and ``pending``; nothing is
    dropped on an interrupt or a spent budget. When ``stop`` is EXHAUSTED, ``pending`` is empty.
    """
    return Search(make_run, cells, budget, threads, report).solve()
