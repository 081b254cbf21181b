"""The loop over batches of cells: whatever stops it, every start cell ends as empty, a leaf or pending."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import njit

from cdpr_interval.engine import search as engine
from cdpr_interval.engine.batches import ADMITTED, CHILDREN, batches, gathered
from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.engine.search import Run, search
from cdpr_interval.kernels.lanes import LANES

WIDTH = 4
"""A cell is lo, hi, whether it was seen, share."""
ROOTS = np.array([-0.75, -1.0 / 3.0, 0.0, 0.3, 0.3001, 1.0])
SMALL, ODD = 1, 2
LEAST = CHILDREN * LANES + 1
"""Rows of the smallest stack with which the loop can go on."""
WIDE = 0.3
"""Wider cells of the gathered loop are bisected before any batch."""


class Arrays(NamedTuple):
    """What the loop asks of a problem's scratch."""

    cells: Any
    verdicts: Any


class Toy(NamedTuple):
    """The problem: roots on a line, and the size of leaves."""

    roots: Any
    size: float
    scratch: Arrays


def toy_context(roots: Any, size: float) -> Toy:
    return Toy(roots, size, Arrays(np.zeros((1, WIDTH, LANES)), np.zeros(LANES, dtype=np.int64)))


@njit(nogil=True)
def process(context: Any, count: int, children: Any) -> None:
    """Keep cells with a root (all if there are none); look twice at each before it is bisected.

    Writes nonsense wherever it may, and breaks when the lanes behind ``count`` do not repeat the last cell.
    """
    roots, size = context.roots, context.size
    C, verdicts = context.scratch.cells, context.scratch.verdicts
    children[:] = -7.0
    verdicts[:] = 2
    for lane in range(LANES):
        for k in range(C.shape[1]):
            if lane >= count and C[0, k, lane] != C[0, k, count - 1]:
                raise AssertionError
    for lane in range(count):
        lo, hi, seen, share = C[0, 0, lane], C[0, 1, lane], C[0, 2, lane], C[0, 3, lane]
        held = roots.shape[0] == 0
        for x in roots:
            held = held or lo <= x <= hi
        row = CHILDREN * lane
        if not held:
            verdicts[lane] = 0
        elif hi - lo <= size:
            verdicts[lane] = -ODD if lo < 0.0 else -SMALL
            children[row, 0], children[row, 1], children[row, 2], children[row, 3] = lo, hi, seen, share
        elif seen == 0.0:
            verdicts[lane] = 1
            children[row, 0], children[row, 1], children[row, 2], children[row, 3] = lo, hi, 1.0, share
        else:
            m = 0.5 * (lo + hi)
            verdicts[lane] = 2
            for i in range(2):
                children[row + i, 0], children[row + i, 1] = lo, hi
                children[row + i, 2], children[row + i, 3] = 0.0, 0.5 * share
            children[row, 1] = m
            children[row + 1, 0] = m
    C[:] = -7.0


@njit(nogil=True)
def run_batches(
    context: Any, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, limit: int
) -> tuple[int, int, int]:
    return batches(process, context, stack, count, leaves, kinds, children, limit)


@njit(nogil=True)
def admit(context: Any, lane: int, children: Any) -> int:
    """Bisect wide cells at once, and admit the others."""
    C, row = context.scratch.cells, CHILDREN * lane
    lo, hi, share = C[0, 0, lane], C[0, 1, lane], C[0, 3, lane]
    children[row : row + 2] = -7.0
    if hi - lo <= WIDE:
        return ADMITTED
    m = 0.5 * (lo + hi)
    for i in range(2):
        children[row + i, 2], children[row + i, 3] = 0.0, 0.5 * share
    children[row, 0], children[row, 1] = lo, m
    children[row + 1, 0], children[row + 1, 1] = m, hi
    return 2


@njit(nogil=True)
def run_gathered(
    context: Any, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, limit: int
) -> tuple[int, int, int]:
    return gathered(admit, process, context, stack, count, leaves, kinds, children, limit)


def toy(roots: Any, size: float, loop: Any = run_batches) -> Callable[[], Run]:
    def make_run() -> Run:
        context = toy_context(roots, size)

        def run(*stack: Any) -> tuple[int, int, int]:
            done: tuple[int, int, int] = loop(context, *stack)
            return done

        return run

    return make_run


def rooted(size: float = 1e-6) -> Callable[[], Run]:
    return toy(ROOTS, size)


def tiled(size: float, loop: Any = run_batches) -> Callable[[], Run]:
    return toy(np.empty(0), size, loop)


def start(count: int = 1) -> Any:
    """Return ``count`` cells that tile [-1, 1]."""
    ends = np.linspace(-1.0, 1.0, count + 1)
    return np.column_stack([ends[:-1], ends[1:], np.zeros(count), np.full(count, 1.0 / count)])


def assert_tiles(cells: Any) -> None:
    """Assert that cells cover [-1, 1] without gap, overlap or repetition."""
    cells = cells[np.argsort(cells[:, 0])]
    assert cells[0, 0] == -1.0 and cells[-1, 1] == 1.0
    assert np.array_equal(cells[1:, 0], cells[:-1, 1])
    assert np.isclose(cells[:, -1].sum(), 1.0)


def ordered(cells: Any) -> Any:
    return cells[np.lexsort(cells.T[::-1])]


@pytest.mark.parametrize("limit", [*range(1, 10), 10**6])
@pytest.mark.parametrize("room", [LANES, LANES + 1, 2 * LANES, 300])
@pytest.mark.parametrize("extra", [0, 1, LANES - 1, 50])
def test_any_limits_lead_to_the_same_leaves(limit: int, room: int, extra: int) -> None:
    """Few cells a call, few leaves, a small stack: only more calls. Nothing is written beyond the arrays."""
    rows = LEAST + extra
    run = tiled(2.0**-5)()
    stack, leaves = np.full((rows + 2, WIDTH), 7.0), np.full((room + 2, WIDTH), 7.0)
    kinds, children = np.full(room + 2, 7), np.full((CHILDREN * LANES + 2, WIDTH), 7.0)
    cells, found, codes = start(3), [], []
    total = calls = 0
    while len(cells):
        count = min(len(cells), 1 + calls % (rows - CHILDREN * LANES))
        stack[:count], rest = cells[:count], cells[count:]
        count, n, done = run(
            stack[:rows], count, leaves[:room], kinds[:room], children[: CHILDREN * LANES], limit
        )
        assert 0 < done <= limit and 0 <= n <= room and 0 <= count <= rows
        total += done
        calls += 1
        found.append(leaves[:n].copy())
        codes.append(kinds[:n].copy())
        cells = np.concatenate([rest, stack[:count]])
        assert_tiles(np.concatenate([*found, cells]))
        assert np.all(stack[rows:] == 7.0) and np.all(leaves[room:] == 7.0)
        assert np.all(kinds[room:] == 7) and np.all(children[CHILDREN * LANES :] == 7.0)
    whole = search(tiled(2.0**-5), start(3), Budget())
    everything, codes = np.concatenate(found), np.concatenate(codes)
    assert np.array_equal(ordered(everything), whole.leaves)
    assert np.array_equal(codes, np.where(everything[:, 0] < 0.0, ODD, SMALL))
    # A cell above the leaf size is looked at twice.
    assert total == whole.cells == 2 * (len(everything) - 3) + len(everything)


@pytest.mark.parametrize("limit", [1, 2, 3, 5, 9, 10**6])
@pytest.mark.parametrize("room", [LANES + 1, LANES + 2, 300])
@pytest.mark.parametrize("extra", [1, 2, 50])
def test_gathered_cells_lead_to_the_same_leaves(limit: int, room: int, extra: int) -> None:
    """With cells that are bisected, or admitted, alone; whatever limit ends a call no cell is lost."""
    rows, run = LEAST + extra, tiled(2.0**-5, run_gathered)()
    stack, leaves = np.full((rows + 2, WIDTH), 7.0), np.full((room + 2, WIDTH), 7.0)
    kinds, children = np.full(room + 2, 7), np.full((CHILDREN * LANES + 2, WIDTH), 7.0)
    cells, found = start(3), []
    while len(cells):
        count = min(len(cells), rows - CHILDREN * LANES - 1)
        stack[:count], rest = cells[:count], cells[count:]
        count, n, done = run(
            stack[:rows], count, leaves[:room], kinds[:room], children[: CHILDREN * LANES], limit
        )
        assert 0 < done <= limit and 0 <= n <= room and 0 <= count <= rows
        found.append(leaves[:n].copy())
        cells = np.concatenate([rest, stack[:count]])
        assert_tiles(np.concatenate([*found, cells]))
        assert np.all(stack[rows:] == 7.0) and np.all(leaves[room:] == 7.0)
        assert np.all(kinds[room:] == 7) and np.all(children[CHILDREN * LANES :] == 7.0)
    whole = search(tiled(2.0**-5), start(3), Budget())
    assert np.array_equal(ordered(np.concatenate(found)), whole.leaves)


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("limit", [1, 2, 5, 37, 1000])
def test_a_cell_limit_of_gathered_cells_leaves_the_rest_pending(threads: int, limit: int) -> None:
    budget = Budget(cell_limit=limit)
    result = search(tiled(2.0**-12, run_gathered), start(1), budget, threads=threads)
    assert result.cells == budget.cells == limit and result.stop is Stop.CELL_LIMIT
    assert_tiles(np.concatenate([result.leaves, result.pending]))


def test_a_limit_of_no_cells_or_no_room_changes_nothing() -> None:
    run = tiled(2.0**-5)()
    children = np.zeros((CHILDREN * LANES, WIDTH))
    for rows, room, limit in ((50, 50, 0), (50, LANES - 1, 9), (LEAST - 1, 50, 9)):
        stack, leaves = np.full((rows, WIDTH), 7.0), np.full((room, WIDTH), 7.0)
        stack[:1] = start(1)
        before = stack.copy()
        done = run(stack, 1, leaves, np.zeros(room, dtype=np.int64), children, limit)
        assert done == (1, 0, 0)
        assert np.array_equal(stack, before) and np.all(leaves == 7.0)


@pytest.mark.parametrize("threads", [1, 2, 4])
@pytest.mark.parametrize("chunk", [1, 2, 3, 5, 50, 10**6])
def test_leaves_do_not_depend_on_threads_or_batches(
    monkeypatch: pytest.MonkeyPatch, threads: int, chunk: int
) -> None:
    monkeypatch.setattr(engine, "CHUNK_CELLS", 10**6)
    reference = search(rooted(), start(5), Budget())
    for x in ROOTS:
        assert np.any((reference.leaves[:, 0] <= x) & (x <= reference.leaves[:, 1]))
    assert len(ROOTS) <= len(reference.leaves) <= 2 * len(ROOTS)
    monkeypatch.setattr(engine, "CHUNK_CELLS", chunk)
    monkeypatch.setattr(engine, "BLOCK_ROWS", 1 if chunk % 2 else 256)
    result = search(rooted(), start(5), Budget(), threads=threads)
    assert result.stop is Stop.EXHAUSTED
    assert np.array_equal(result.leaves, reference.leaves)
    assert np.array_equal(result.kinds, reference.kinds)
    assert result.cells == reference.cells


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("limit", [0, 1, 2, 3, 4, 5, 6, 7, 37, 1000, 5000])
def test_a_cell_limit_leaves_the_rest_pending(
    monkeypatch: pytest.MonkeyPatch, threads: int, limit: int
) -> None:
    monkeypatch.setattr(engine, "CHUNK_CELLS", 50)
    budget = Budget(cell_limit=limit)
    result = search(tiled(2.0**-12), start(1), budget, threads=threads)
    assert result.stop is Stop.CELL_LIMIT
    assert result.cells == budget.cells == limit
    assert len(result.pending)
    assert_tiles(np.concatenate([result.leaves, result.pending]))


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("rows", [LEAST, LEAST + 1, LEAST + 7])
def test_small_buffers_only_end_the_chunk(monkeypatch: pytest.MonkeyPatch, threads: int, rows: int) -> None:
    reference = search(tiled(2.0**-7), start(6), Budget())
    monkeypatch.setattr(engine, "STACK_ROWS", rows)
    monkeypatch.setattr(engine, "LEAF_ROWS", LANES)
    monkeypatch.setattr(engine, "BLOCK_ROWS", 1)
    result = search(tiled(2.0**-7), start(6), Budget(), threads=threads)
    assert result.stop is Stop.EXHAUSTED
    assert np.array_equal(result.leaves, reference.leaves)
    assert_tiles(result.leaves)


def test_compiled_and_plain_python_agree() -> None:
    """Cells are looked at in the same order."""

    def run(*stack: Any) -> tuple[int, int, int]:
        plain = batches.py_func
        done: tuple[int, int, int] = plain(process.py_func, toy_context(ROOTS, 1e-3), *stack)
        return done

    slow = search(lambda: run, start(2), Budget())
    fast = search(rooted(1e-3), start(2), Budget())
    assert np.array_equal(slow.leaves, fast.leaves) and slow.cells == fast.cells
