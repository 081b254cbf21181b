"""Branch and prune on toy problems: every start cell ends as empty, a leaf or pending, whatever stops it."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numba import njit

from cdpr_interval.engine import search as engine
from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.engine.depth_first import MAX_CHILDREN, depth_first
from cdpr_interval.engine.search import Run, Search, SearchResult, search

WIDTH = 3
"""A cell is lo, hi, share."""
ROOTS = np.array([-0.75, -1.0 / 3.0, 0.0, 0.3, 0.3001, 1.0])
SMALL, ODD = 1, 2


@njit(nogil=True)
def process_roots(context: Any, cell: Any, children: Any) -> int:
    """Keep cells that hold a root, cut them into four, and call small ones leaves of two kinds."""
    roots, size = context
    held = False
    for x in roots:
        held = held or cell[0] <= x <= cell[1]
    if not held:
        return 0
    if cell[1] - cell[0] <= size:
        children[0] = cell
        return -ODD if cell[0] < 0.0 else -SMALL
    for k in range(4):
        children[k, 0] = cell[0] + 0.25 * k * (cell[1] - cell[0])
        children[k, 1] = cell[0] + 0.25 * (k + 1) * (cell[1] - cell[0])
        children[k, 2] = 0.25 * cell[2]
    children[3, 1] = cell[1]
    return 4


@njit(nogil=True)
def process_all(context: Any, cell: Any, children: Any) -> int:
    """Bisect down to a size and keep everything: leaves tile the start cells."""
    if cell[1] - cell[0] <= context:
        children[0] = cell
        return -SMALL
    m = 0.5 * (cell[0] + cell[1])
    children[0, 0], children[0, 1], children[0, 2] = cell[0], m, 0.5 * cell[2]
    children[1, 0], children[1, 1], children[1, 2] = m, cell[1], 0.5 * cell[2]
    return 2


@njit(nogil=True)
def run_roots(
    roots: Any, size: float, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, limit: int
) -> tuple[int, int, int]:
    return depth_first(process_roots, (roots, size), stack, count, leaves, kinds, children, limit)


@njit(nogil=True)
def run_all(
    size: float, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, limit: int
) -> tuple[int, int, int]:
    return depth_first(process_all, size, stack, count, leaves, kinds, children, limit)


def rooted(size: float = 1e-7) -> Callable[[], Run]:
    return lambda: lambda *stack: run_roots(ROOTS, size, *stack)


def tiled(size: float) -> Callable[[], Run]:
    return lambda: lambda *stack: run_all(size, *stack)


def start(count: int = 1, lo: float = -1.0, hi: float = 1.0) -> Any:
    """Return ``count`` cells that tile [lo, hi]."""
    ends = np.linspace(lo, hi, count + 1)
    return np.column_stack([ends[:-1], ends[1:], np.full(count, 1.0 / count)])


def assert_tiles(cells: Any, lo: float, hi: float) -> None:
    """Assert that cells cover [lo, hi] without gap, overlap or repetition."""
    cells = cells[np.argsort(cells[:, 0])]
    assert cells[0, 0] == lo and cells[-1, 1] == hi
    assert np.array_equal(cells[1:, 0], cells[:-1, 1])
    assert np.isclose(cells[:, 2].sum(), 1.0)


def assert_covers_roots(result: SearchResult) -> None:
    cells = np.concatenate([result.leaves, result.pending])
    for x in ROOTS:
        assert np.any((cells[:, 0] <= x) & (x <= cells[:, 1]))


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_leaves_cover_all_roots(threads: int) -> None:
    result = search(rooted(), start(3), Budget(), threads=threads)
    assert result.stop is Stop.EXHAUSTED
    assert len(result.pending) == 0
    assert_covers_roots(result)
    assert np.all(result.leaves[:, 1] - result.leaves[:, 0] <= 1e-7)
    # Nothing but cells at the roots; a root on a common face has two.
    assert len(ROOTS) <= len(result.leaves) <= 2 * len(ROOTS)
    assert np.array_equal(result.kinds, np.where(result.leaves[:, 0] < 0.0, ODD, SMALL))


def test_leaves_do_not_depend_on_threads_or_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    reference = search(rooted(), start(5), Budget())
    monkeypatch.setattr(engine, "CHUNK_CELLS", 7)
    for threads in (1, 2, 4):
        for blocks in (1, 3, 256):
            monkeypatch.setattr(engine, "BLOCK_ROWS", blocks)
            result = search(rooted(), start(5), Budget(), threads=threads)
            assert np.array_equal(result.leaves, reference.leaves)
            assert np.array_equal(result.kinds, reference.kinds)
            assert result.cells == reference.cells


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_leaves_tile_the_start_cells(threads: int) -> None:
    result = search(tiled(2.0**-13), start(1), Budget(), threads=threads)
    assert result.stop is Stop.EXHAUSTED
    assert len(result.leaves) == 2**14
    assert result.cells == 2**15 - 1
    assert_tiles(result.leaves, -1.0, 1.0)
    assert np.array_equal(result.leaves, result.leaves[np.lexsort(result.leaves.T[::-1])])


@pytest.mark.parametrize("threads", [1, 2, 4])
@pytest.mark.parametrize("limit", [0, 1, 2, 37, 1000, 5000])
def test_a_cell_limit_leaves_the_rest_pending(
    monkeypatch: pytest.MonkeyPatch, threads: int, limit: int
) -> None:
    monkeypatch.setattr(engine, "CHUNK_CELLS", 50)
    budget = Budget(cell_limit=limit)
    result = search(tiled(2.0**-12), start(1), budget, threads=threads)
    assert result.stop is Stop.CELL_LIMIT
    assert result.cells == budget.cells == limit
    assert len(result.pending)
    assert_tiles(np.concatenate([result.leaves, result.pending]), -1.0, 1.0)


def test_a_limit_that_just_suffices_is_not_a_stop() -> None:
    needed = search(tiled(2.0**-5), start(1), Budget()).cells
    assert search(tiled(2.0**-5), start(1), Budget(cell_limit=needed)).stop is Stop.EXHAUSTED
    assert search(tiled(2.0**-5), start(1), Budget(cell_limit=needed - 1)).stop is Stop.CELL_LIMIT


def test_a_stopped_search_can_go_on_from_its_pending_cells() -> None:
    whole = search(rooted(), start(1), Budget())
    first = search(rooted(), start(1), Budget(cell_limit=60))
    rest = search(rooted(), first.pending, Budget())
    leaves = np.concatenate([first.leaves, rest.leaves])
    assert np.array_equal(leaves[np.lexsort(leaves.T[::-1])], whole.leaves)
    assert first.cells + rest.cells == whole.cells


def test_searches_share_one_budget() -> None:
    budget = Budget(cell_limit=100)
    first = search(tiled(2.0**-4), start(1), budget)
    second = search(tiled(2.0**-12), start(1), budget)
    assert first.stop is Stop.EXHAUSTED and second.stop is Stop.CELL_LIMIT
    assert first.cells + second.cells == budget.cells == 100


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_a_spent_time_limit_leaves_everything_pending(threads: int) -> None:
    result = search(tiled(2.0**-12), start(9), Budget(time_limit=0.0), threads=threads)
    assert result.stop is Stop.TIME_LIMIT
    assert result.cells == 0 and len(result.leaves) == 0
    assert_tiles(result.pending, -1.0, 1.0)


@pytest.mark.parametrize("threads", [1, 3])
def test_the_time_limit_is_seen_between_chunks(monkeypatch: pytest.MonkeyPatch, threads: int) -> None:
    monkeypatch.setattr(engine, "CHUNK_CELLS", 20)
    now = [0.0]
    monkeypatch.setattr("cdpr_interval.engine.budget.time.monotonic", lambda: now[0])
    budget = Budget(time_limit=10.0)

    def make_run() -> Run:
        def run(*stack: Any) -> tuple[int, int, int]:
            now[0] += 1.0
            done: tuple[int, int, int] = run_all(2.0**-12, *stack)
            return done

        return run

    result = search(make_run, start(1), budget, threads=threads)
    assert result.stop is Stop.TIME_LIMIT
    assert 0 < result.cells < 2**13
    assert_tiles(np.concatenate([result.leaves, result.pending]), -1.0, 1.0)


@pytest.mark.parametrize("threads", [1, 2, 4])
@pytest.mark.parametrize("chunks", [0, 1, 5, 40])
def test_an_interrupt_keeps_leaves_and_pending_cells(
    monkeypatch: pytest.MonkeyPatch, threads: int, chunks: int
) -> None:
    monkeypatch.setattr(engine, "CHUNK_CELLS", 30)
    budget = Budget()
    lock, seen = threading.Lock(), [0]

    def make_run() -> Run:
        def run(*stack: Any) -> tuple[int, int, int]:
            with lock:
                seen[0] += 1
                if seen[0] > chunks:
                    budget.interrupt()
            done: tuple[int, int, int] = run_all(2.0**-12, *stack)
            return done

        return run

    result = search(make_run, start(2), budget, threads=threads)
    assert result.stop is Stop.INTERRUPTED
    assert 0 < result.cells < 2**13
    assert_tiles(np.concatenate([result.leaves, result.pending]), -1.0, 1.0)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_full_leaf_buffer_only_ends_the_chunk(monkeypatch: pytest.MonkeyPatch, threads: int) -> None:
    monkeypatch.setattr(engine, "LEAF_ROWS", 3)
    result = search(tiled(2.0**-8), start(1), Budget(), threads=threads)
    assert result.stop is Stop.EXHAUSTED
    assert_tiles(result.leaves, -1.0, 1.0)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("rows", [MAX_CHILDREN + 1, MAX_CHILDREN + 2, MAX_CHILDREN + 7])
def test_a_full_stack_only_ends_the_chunk(monkeypatch: pytest.MonkeyPatch, threads: int, rows: int) -> None:
    monkeypatch.setattr(engine, "STACK_ROWS", rows)
    monkeypatch.setattr(engine, "BLOCK_ROWS", 1)
    result = search(rooted(), start(6), Budget(), threads=threads)
    reference_leaves = search(rooted(), start(6), Budget(), threads=1).leaves
    assert result.stop is Stop.EXHAUSTED
    assert np.array_equal(result.leaves, reference_leaves)
    assert_covers_roots(result)


def test_buffers_are_never_written_beyond_their_end() -> None:
    """Guard rows behind stack, leaves and children stay as they were."""
    rows, room = MAX_CHILDREN + 6, 4
    stack, leaves = np.full((rows + 2, WIDTH), 7.0), np.full((room + 2, WIDTH), 7.0)
    kinds, children = np.full(room + 2, 7), np.full((MAX_CHILDREN + 2, WIDTH), 7.0)
    cells = start(1)
    total = 0
    for _ in range(1000):
        count = min(len(cells), 2)
        stack[:count], rest = cells[:count], cells[count:]
        count, n, done = run_roots(
            ROOTS, 1e-7, stack[:rows], count, leaves[:room], kinds[:room], children[:MAX_CHILDREN], 10**9
        )
        assert done > 0
        total += n
        cells = np.concatenate([rest, stack[:count]])
        if len(cells) == 0:
            break
    assert total == len(search(rooted(), start(1), Budget()).leaves)
    assert np.all(stack[rows:] == 7.0) and np.all(leaves[room:] == 7.0)
    assert np.all(kinds[room:] == 7) and np.all(children[MAX_CHILDREN:] == 7.0)


def test_compiled_and_plain_python_agree() -> None:
    def run(*stack: Any) -> tuple[int, int, int]:
        plain = depth_first.py_func
        done: tuple[int, int, int] = plain(process_roots.py_func, (ROOTS, 1e-4), *stack)
        return done

    slow = search(lambda: run, start(2), Budget())
    fast = search(rooted(1e-4), start(2), Budget())
    assert np.array_equal(slow.leaves, fast.leaves) and slow.cells == fast.cells


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_an_error_in_a_run_reaches_the_caller(threads: int) -> None:
    def run(*stack: Any) -> tuple[int, int, int]:
        raise FloatingPointError("broken kernel")

    with pytest.raises(FloatingPointError, match="broken kernel"):
        search(lambda: run, start(4), Budget(), threads=threads)


def test_an_error_keeps_the_cells_in_the_store() -> None:
    def run(*stack: Any) -> tuple[int, int, int]:
        raise FloatingPointError("broken kernel")

    one = Search(lambda: run, start(4), Budget(), 1, None)
    with pytest.raises(FloatingPointError):
        one.solve()
    assert_tiles(one.result().pending, -1.0, 1.0)


@pytest.mark.parametrize("threads", [1, 2])
def test_no_start_cells_is_an_exhausted_search(threads: int) -> None:
    result = search(rooted(), np.empty((0, WIDTH)), Budget(cell_limit=0), threads=threads)
    assert result.stop is Stop.EXHAUSTED
    assert result.leaves.shape == result.pending.shape == (0, WIDTH)


@pytest.mark.parametrize("threads", [1, 2])
def test_progress_is_reported(monkeypatch: pytest.MonkeyPatch, threads: int) -> None:
    monkeypatch.setattr(engine, "REPORT_SECONDS", 0.0)
    monkeypatch.setattr(engine, "CHUNK_CELLS", 100)
    told: list[tuple[int, int, float]] = []
    search(tiled(2.0**-10), start(1), Budget(), threads=threads, report=lambda *state: told.append(state))
    cells = [c for c, _, _ in told]
    # With more threads the search may end before the calling thread looks.
    assert told or threads > 1
    assert cells == sorted(cells)
    assert all(0.0 <= volume <= 1.0 for _, _, volume in told)


def test_a_signal_interrupts_and_a_second_one_raises() -> None:
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    budget = Budget()
    with budget.listening():
        assert budget.stop() is None
        os.kill(os.getpid(), signal.SIGINT)
        assert budget.stop() is Stop.INTERRUPTED
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before


def test_listening_outside_the_main_thread_does_nothing() -> None:
    budget, states = Budget(), []

    def listen() -> None:
        with budget.listening():
            states.append(budget.stop())

    thread = threading.Thread(target=listen)
    thread.start()
    thread.join()
    assert states == [None]


def test_reservations_never_exceed_the_cell_limit() -> None:
    budget = Budget(cell_limit=10)
    assert budget.reserve(6) == 6
    assert budget.reserve(6) == 4
    assert budget.reserve(6) == 0
    assert budget.stop() is None
    budget.settle(6, 1)
    assert budget.reserve(6) == 5
    budget.settle(4, 4)
    budget.settle(5, 5)
    assert budget.cells == 10
    assert budget.stop() is Stop.CELL_LIMIT
    assert budget.reserve(1) == 0
