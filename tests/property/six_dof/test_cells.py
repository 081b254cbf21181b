"""What becomes of a cell never depends on its neighbours; small kernels of one lane have exact answers."""

from __future__ import annotations

import math
import random
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest

from cdpr_interval.engine import contraction as platform_elimination
from cdpr_interval.engine import search as engine
from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.engine.rows import EMPTY, EQUATION, OPEN, PIVOT, SCRATCH, SMALLER
from cdpr_interval.kernels import second_order
from cdpr_interval.kernels.lanes import LANES
from cdpr_interval.kernels.second_order import (
    POSE_AND_DATA,
    ROTATION_AND_DATA,
    ROTATION_ONLY,
    WHOLE_POSE,
    Symbols,
    width,
)
from cdpr_interval.mechanics.rotation import HALF_TURNS
from cdpr_interval.mechanics.six_dof.rows import FORMS, WORK
from solvers.six_dof.cells.kinds import POSE_CELLS, ROTATION_CELLS
from solvers.six_dof.cells.roots import GENERAL, Prover
from tests.support import lane_platform as platform
from tests.support.exact_rows import Point, error_column, polynomial
from tests.support.kernel_callers import Callers
from tests.support.planted_platform import Planted, plant, plant_planar
from tests.support.platform_cells import Stepper, Verdict, around, pose, pose_cell, turn, turn_cell

kernels = Callers(second_order)
elimination = Callers(platform_elimination)


COUNTS = (2, 3, 4, 5, 6)
WORK_SHAPE = (WORK.height, WORK.columns, LANES)
NUMBERS = [*(0.0, -0.0, 1.0, -1.0, 5e-324, 1e-5, -1e-5, 1e308), math.inf, -math.inf, math.nan]

every_count = pytest.mark.parametrize("n", COUNTS)
every_search = pytest.mark.parametrize("search", [turn, pose], ids=["u", "u and x"])
every_size = pytest.mark.parametrize(
    "S",
    [ROTATION_ONLY, WHOLE_POSE, ROTATION_AND_DATA, POSE_AND_DATA],
    ids=lambda S: f"{len(S.noise)}+{len(S.data)}",
)


@cache
def planted(n: int) -> list[Planted]:
    rng = random.Random(300 + n)
    spreads = (Fraction(0), Fraction(1, 10**6))
    if n == 2:
        return [plant_planar(rng, slack=1, width=spread) for spread in spreads]
    return [plant(rng, n, slack=1, width=spread) for spread in spreads]


def start_cells(search: Any, robot: Planted) -> list[Any]:
    """Return the whole space, in every chart."""
    model = robot.model
    reach = float(model.lengths[robot.pivot, 1])
    flat = [model.planar and k != 1 for k in range(3)]
    u = [x for thin in flat for x in ((0.0, 0.0) if thin else (-1.0, 1.0))]
    x = [x for k in range(3) for x in ((0.0, 0.0) if model.planar and k == 1 else (-reach, reach))]
    charts = (0, 2) if model.planar else range(4)
    tail = [0.0, 1.0] if search is turn else [1.0]
    return [np.array([*u, *(x if search is pose else []), float(chart), *tail]) for chart in charts]


def uneven_cell(rng: random.Random, search: Any, robot: Planted) -> Any:
    """Return a cell with the equilibrium, of another width in every variable: also points in some of them."""
    cell = turn_cell(rng, robot, 0.0, robot.branch()) if search is turn else pose_cell(rng, robot, 0.0)
    if rng.random() < 0.2:
        return cell
    values = robot.u if search is turn else [*robot.u, *robot.way()]
    for k, x in enumerate(values):
        reach = rng.choice([0.0, 1e-7, 1e-4, 0.01, 0.1, 0.3])
        if cell[2 * k] < cell[2 * k + 1]:
            cell[2 * k : 2 * k + 2] = around(rng, x, reach) if reach else [float(x)] * 2
    return cell


def visited(rng: random.Random, stepper: Stepper, robot: Planted, count: int) -> list[Any]:
    """Return cells that a search meets, wide and narrow, and uneven ones at the equilibrium."""
    views = robot.views()
    cells = [uneven_cell(rng, stepper.search, rng.choice(views)) for _ in range(count // 3)]
    todo = start_cells(stepper.search, robot)
    while len(cells) < count:
        if not todo:
            todo = [uneven_cell(rng, stepper.search, rng.choice(views))]
        cell = todo.pop(rng.choice([-1, rng.randrange(len(todo))]))
        cells.append(cell)
        verdict, family = stepper.step([cell])[0]
        todo += list(family) if verdict > 0 else []
    return cells


def broken_cell(rng: random.Random, like: Any) -> Any:
    """Return a cell of nonsense."""
    cell = like.copy()
    cell[:-1] = [rng.choice(NUMBERS) for _ in cell[:-1]]
    return cell


def same(a: Verdict, b: Verdict) -> bool:
    return a[0] == b[0] and a[1].tobytes() == b[1].tobytes()


def some_roots(robot: Planted) -> Any:
    """Return boxes of (u, p, t): around the equilibrium in each of its charts, and beside it."""
    rows = []
    for view in robot.views():
        t = view.t if view.n < 6 else [Fraction(0)] * 6
        exact = np.array([float(x) for x in [*view.u, *view.p, *t]])
        reach = np.array([1e-3] * 3 + [1e-2] * 3 + [10.0] * view.n)
        rows.append([view.chart, *(exact - reach), *(exact + reach)])
        rows.append([view.chart, *(exact + reach), *(exact + 2.0 * reach)])
    return np.array(rows)


@every_count
@every_search
def test_a_cell_does_not_depend_on_its_neighbours(n: int, search: Any) -> None:
    """Verdict and children, bit by bit, in any lane, for any number of cells, on any scratch."""
    rng = random.Random(1)
    seen: set[int] = set()
    for robot, roots in zip(planted(n), (None, some_roots(planted(n)[1])), strict=True):
        one, many = (Stepper(search, robot.model, roots, 0.01) for _ in range(2))
        cells = visited(rng, one, robot, 150)
        alone = [one.step([cell], broken_cell(rng, cell))[0] for cell in cells]
        seen |= {verdict for verdict, _ in alone}
        for _ in range(150):
            chosen = [rng.randrange(len(cells)) for _ in range(rng.randint(1, LANES))]
            batch = [cells[k] for k in chosen]
            # Cells of nonsense among them.
            for _ in range(rng.choice([0, 0, 1, 2])):
                chosen.insert(rng.randint(0, len(chosen)), -1)
                batch = [cells[k] if k >= 0 else broken_cell(rng, cells[0]) for k in chosen][:LANES]
            if rng.random() < 0.3:
                many.F[:], many.W[:] = rng.choice(NUMBERS), rng.choice(NUMBERS)
                many.children[:], many.states[:], many.verdicts[:] = 7.0, 7, 7
            done = many.step(batch, rng.choice([None, broken_cell(rng, cells[0])]))
            for k, verdict in zip(chosen, done, strict=False):
                assert k < 0 or same(verdict, alone[k])
        # The same cells in another order.
        order = rng.sample(range(LANES), LANES)
        first = many.step(cells[:LANES])
        second = many.step([cells[k] for k in order])
        assert all(same(second[j], first[k]) for j, k in enumerate(order))
    # Dropped, contracted, split, small.
    assert {0, 1, 2} <= seen
    assert min(seen) < 0


@every_search
@pytest.mark.parametrize("n", [2, 3, 6])
def test_the_leaves_do_not_depend_on_the_size_of_batches(
    monkeypatch: pytest.MonkeyPatch, n: int, search: Any
) -> None:
    robot = planted(n)[0]
    kind = ROTATION_CELLS if search is turn else POSE_CELLS
    start = np.array(start_cells(search, robot))

    def leaves(chunk: int, threads: int = 1) -> Any:
        monkeypatch.setattr(engine, "CHUNK_CELLS", chunk)
        budget = Budget(cell_limit=100_000)
        leaf_size = 0.2 if n == 2 else 0.9
        result = engine.search(
            lambda: kind.run(robot.model, Prover(robot.model, GENERAL).seen_by_cells([]), leaf_size),
            start,
            budget,
            threads=threads,
        )
        assert result.stop is Stop.EXHAUSTED
        return result.leaves, result.kinds, result.cells

    whole = leaves(10**6)
    assert len(whole[0])
    for chunk, threads in ((1, 1), (3, 1), (7, 2)):
        again = leaves(chunk, threads)
        assert all(np.array_equal(a, b) for a, b in zip(again, whole, strict=True))


def test_middle_and_radius_hold_the_interval() -> None:
    rng = random.Random(2)
    for _ in range(300):
        lo, hi = np.zeros((2, LANES))
        for lane in range(LANES):
            scale = math.ldexp(1.0, rng.choice([-1074, -1070, -60, 0, 0, 0, 500]))
            ends = sorted(rng.uniform(-3.0, 3.0) * scale for _ in range(2))
            kind = rng.random()
            if kind < 0.2:
                ends[1] = ends[0]
            elif kind < 0.4:
                ends[1] = math.nextafter(ends[0], math.inf)
            lo[lane], hi[lane] = ends
        for a, b, m, r in zip(lo, hi, *platform.middle_and_radius(lo, hi), strict=True):
            a, b, m, r = (Fraction(x) for x in (a, b, m, r))
            assert a <= m <= b
            most = max(b - m, m - a)
            assert most <= r <= most * (1 + Fraction(1, 2**50)) + Fraction(8, 2**1074)
            if a == b:
                assert m == a and r == 0


def test_half_turns_of_lanes_in_different_charts() -> None:
    rng = random.Random(3)
    for _ in range(30):
        charts = [rng.randrange(4) for _ in range(LANES)]
        found = np.array(platform.half_turn(np.array(charts, dtype=float)))
        assert np.array_equal(found.T, HALF_TURNS[charts])


def numbers(rng: random.Random) -> Any:
    return np.array([rng.choice(NUMBERS) for _ in range(LANES)])


def test_maximum_gives_the_second_where_one_is_not_a_number() -> None:
    rng = random.Random(4)
    for _ in range(300):
        a, b = numbers(rng), numbers(rng)
        expected = [x if y < x else y for x, y in zip(a, b, strict=True)]
        assert np.array_equal(platform.maximum(a, b), expected, equal_nan=True)


def test_covers_asks_only_the_lanes_that_matter() -> None:
    rng = random.Random(5)
    answers = set()
    for _ in range(300):
        W = np.full(WORK_SHAPE, np.nan)
        flags = np.array(
            [rng.choice([0.0, -0.0, 1.0, 1.0, 1.0, 1e-300, -1.0, math.nan]) for _ in range(LANES)]
        )
        needed = np.array([rng.choice([0.0, 1.0, 1.0, -1.0]) for _ in range(LANES)])
        expected = all(f > 0.0 for f, want in zip(flags, needed, strict=True) if want > 0.0)
        assert platform.covers(W, flags, needed) == expected
        answers.add(expected)
    assert answers == {True, False}


def random_rows(rng: random.Random, S: Symbols) -> Any:
    """Return empty rows, garbage everywhere."""
    F = np.full((FORMS.height, width(S), LANES), rng.choice([math.nan, math.inf, 3.0]))
    return F


@every_size
def test_a_blank_row_is_zero_where_it_is_not_kept(S: Symbols) -> None:
    rng = random.Random(6)
    for _ in range(100):
        F = np.array([[numbers(rng) for _ in range(width(S))] for _ in range(3)])
        before = F.copy()
        keep = numbers(rng)
        platform.blank(F, 1, keep, S)
        for lane in range(LANES):
            if keep[lane] > 0.0:
                assert np.array_equal(F[1, :, lane], before[1, :, lane], equal_nan=True)
            else:
                assert not F[1, :, lane].any()
        assert np.array_equal(F[[0, 2]], before[[0, 2]], equal_nan=True)


@every_size
def test_a_row_is_useful_where_a_slope_stands_out_of_the_noise(S: Symbols) -> None:
    rng = random.Random(7)
    K, e = len(S.noise), error_column(S)
    useful = 0
    for _ in range(100):
        F = np.zeros((1, width(S), LANES))
        for lane in range(LANES):
            size = 10.0 ** rng.choice([-110, -3, 0, 0, 0, 3, 110])
            F[0, 1 : 1 + K, lane] = [rng.choice([0.0, rng.uniform(-size, size)]) for _ in range(K)]
            F[0, 1 + K : e, lane] = rng.choice([0.0, 0.1, 0.3]) * size / K
            F[0, e, lane] = rng.choice([0.0, 1e-3, 0.3, math.inf, math.nan]) * size
        kernels.close(F, 0, S)
        found = platform.usefulness(F, 0, S)
        for lane in range(LANES):
            row = F[0, :, lane]
            most = abs(row[1 : 1 + K]).max()
            good = 1e-100 < most < 1e100 and row[e] + row[e + 2] < most
            useful += good
            assert found[lane] == (1.0 / most if good else 0.0)
    assert useful > 50


def test_pivots_of_a_lane_solve_its_equations() -> None:
    rng = np.random.default_rng(8)
    ranks = set()
    for trial in range(300):
        lane, symbols = trial % LANES, int(rng.choice([4, 6]))
        variables = 3 if symbols == 4 else 6
        count = int(rng.integers(0, 7 if symbols == 6 else 4))
        W = np.full(WORK_SHAPE, 7.0)
        slopes = rng.uniform(-1.0, 1.0, (count, symbols)) * rng.choice([1.0, 1.0, 0.0], (count, 1))
        # Some equations follow from others, some say next to nothing.
        rank = min(count, variables)
        if trial % 3 == 0 and count > 1:
            slopes[-1] = 0.5 * slopes[0]
        if trial % 5 == 0 and count:
            slopes[0] *= 5e-4
        W[elimination.TABLEAU : elimination.TABLEAU + count, :symbols, lane] = slopes
        W[elimination.TABLEAU : elimination.TABLEAU + count, symbols : symbols + count, lane] = np.eye(count)
        before = W.copy()
        rank = elimination.pivot_lane(W, lane, count, variables, symbols)
        ranks.add(rank)
        pivots = W[elimination.PIVOTS, : elimination.MOST_PIVOTS, lane]
        chosen = [int(k) for k in pivots[:rank]]
        assert np.all(pivots[rank:] == -1.0) and len(set(chosen)) == rank
        assert all(0 <= k < variables for k in chosen)
        multipliers = W[elimination.TABLEAU : elimination.TABLEAU + count, symbols : symbols + count, lane]
        assert not multipliers[rank:].any()
        solved = multipliers[:rank] @ slopes
        assert np.allclose(solved[:, chosen], np.eye(rank), atol=1e-9)
        assert np.allclose(solved, W[elimination.TABLEAU : elimination.TABLEAU + rank, :symbols, lane])
        if count:
            largest = abs(slopes[:, :variables])
            if rank:
                # Full pivoting.
                assert largest[:, chosen[0]].max() == largest.max()
            assert (rank > 0) == (largest.max() > elimination.LEAST_PIVOT)
            # What is left has no pivot any more.
            _, s, _ = np.linalg.svd(slopes[:, :variables])
            assert rank >= np.sum(s > 0.3) and rank <= np.sum(s > 1e-9)
        for symbol in range(symbols):
            assert elimination.is_pivot(W, lane, symbol) == (symbol in chosen)
        W[:, :, lane] = before[:, :, lane]
        assert np.array_equal(W, before)
    assert ranks >= set(range(5))


@every_size
def test_slopes_in_the_pivots_are_picked_lane_by_lane(S: Symbols) -> None:
    rng = random.Random(9)
    for _ in range(50):
        F = np.array([[rng.uniform(-1.0, 1.0) for _ in range(LANES)] for _ in range(2 * width(S))])
        F = F.reshape(2, width(S), LANES)
        W = np.full(WORK_SHAPE, 7.0)
        pivots = [rng.randrange(-1, len(S.noise)) for _ in range(LANES)]
        W[elimination.PIVOTS, 2] = pivots
        found = platform.pivot_slope(F, 1, W, 2, S)
        assert list(found) == [F[1, 1 + k, lane] if k >= 0 else 0.0 for lane, k in enumerate(pivots)]


def vanishing_row(rng: random.Random, S: Symbols, row: Any, eps: list[Fraction], noise: float) -> None:
    """Fill one lane's row with a form that holds 0 at a point, often just so."""
    K, e, P = len(S.noise), error_column(S), len(S.data)
    row[1 : 1 + K] = [rng.uniform(-1.0, 1.0) for _ in range(K)]
    row[1 + K : e] = [noise * rng.choice([0.0, rng.uniform(-1.0, 1.0)]) for _ in row[1 + K : e]]
    row[e + 3 : e + 3 + P] = [noise * rng.choice([0.0, rng.uniform(-1.0, 1.0)]) for _ in S.data]
    row[e] = noise * rng.choice([0.0, rng.random()])
    row[0] = 0.0
    at = point_at(eps, S)
    share = Fraction(row[e]) * rng.choice([-1, 1, Fraction(rng.randint(-99, 99), 99)])
    row[0] = float(-polynomial(row, at) - share)
    rest = abs(polynomial(row, at))
    if rest > Fraction(row[e]):
        row[e] = math.nextafter(float(rest), math.inf)


def unit_point(rng: random.Random, S: Symbols) -> list[Fraction]:
    """Return values of all symbols, those of data last."""
    count = len(S.noise) + len(S.data)
    kinds = [Fraction(-1), Fraction(1)]
    return [rng.choice([*kinds, Fraction(rng.randint(-(3**20), 3**20), 3**20)]) for _ in range(count)]


def point_at(eps: list[Fraction], S: Symbols) -> Point:
    """Return the point with these values."""
    return Point(eps[: len(S.noise)], eps[len(S.noise) :])


@every_size
def test_a_vanishing_row_bounds_its_symbol(S: Symbols) -> None:
    """Another symbol in every lane, or none."""
    rng = random.Random(10)
    K, e = len(S.noise), error_column(S)
    tight = 0
    for _ in range(150):
        F = random_rows(rng, S)
        points, symbols = [], [rng.randrange(-1, K) for _ in range(LANES)]
        for lane in range(LANES):
            eps = unit_point(rng, S)
            noise = rng.choice([0.0, 1e-12, 1e-3, 0.3])
            vanishing_row(rng, S, F[SCRATCH, :, lane], eps, noise)
            slope = 1.0 + rng.choice([0.0, 1e-16, 1e-9, 0.2]) * rng.uniform(-1.0, 1.0)
            if symbols[lane] >= 0:
                k = 1 + symbols[lane]
                change = slope - F[SCRATCH, k, lane]
                F[SCRATCH, k, lane] = slope
                F[SCRATCH, 0, lane] -= change * float(eps[symbols[lane]])
                rest = abs(polynomial(F[SCRATCH, :, lane], point_at(eps, S)))
                if rest > Fraction(F[SCRATCH, e, lane]):
                    F[SCRATCH, e, lane] = math.nextafter(float(rest), math.inf)
                if rng.random() < 0.3:
                    # Nothing else in it.
                    others = [j for j in range(1, 1 + K) if j != k]
                    centre = sum(Fraction(F[SCRATCH, j, lane]) * eps[j - 1] for j in others)
                    F[SCRATCH, 0, lane] += float(centre)
                    F[SCRATCH, others, lane] = 0.0
                    F[SCRATCH, e + 3 :, lane] = 0.0
                    rest = abs(polynomial(F[SCRATCH, :, lane], point_at(eps, S)))
                    if rest > Fraction(F[SCRATCH, e, lane]):
                        F[SCRATCH, e, lane] = math.nextafter(float(rest), math.inf)
            points.append(eps)
        kernels.close(F, SCRATCH, S)
        spread = abs(F[SCRATCH, 1:e]).sum(axis=0) + F[SCRATCH, e] + data_of(F[SCRATCH], S)
        low, high = platform.rest_bounds(F, np.array(symbols, dtype=float), S)
        for lane, k in enumerate(symbols):
            if k < 0:
                continue
            assert low[lane] <= points[lane][k] <= high[lane]
            rest = spread[lane] - 1.0 + 2.0 * abs(F[SCRATCH, 1 + k, lane])
            assert high[lane] - low[lane] <= 2.0 * rest + 1e-12
            tight += high[lane] - low[lane] < 1e-9
    assert tight >= 10


def data_of(row: Any, S: Symbols) -> Any:
    """Return the sum of the slopes in the symbols of data, lane by lane."""
    return abs(row[error_column(S) + 3 :][: len(S.data)]).sum(axis=0)


@every_size
def test_a_row_that_is_not_finite_bounds_nothing(S: Symbols) -> None:
    for bad in (math.inf, -math.inf, math.nan):
        e = error_column(S)
        for column in [*range(e + 1), *range(e + 3, e + 3 + len(S.data))]:
            F = np.zeros((FORMS.height, width(S), LANES))
            F[SCRATCH, 1] = 1.0
            F[SCRATCH, column, column % LANES] = abs(bad)
            kernels.close(F, SCRATCH, S)
            low, high = platform.rest_bounds(F, np.zeros(LANES), S)
            for lane in range(LANES):
                if lane == column % LANES:
                    assert (low[lane], high[lane]) == (-math.inf, math.inf)
                else:
                    assert abs(low[lane]) < 1e-14 and abs(high[lane]) < 1e-14


def exact_symbols(lo: float, hi: float) -> tuple[Fraction, Fraction]:
    """Return the middle and radius that the symbol of a variable means."""
    m, r = platform.middle_and_radius(np.full(LANES, lo), np.full(LANES, hi))
    return Fraction(m[0]), Fraction(r[0])


def test_a_cut_keeps_what_the_symbol_allows() -> None:
    rng = random.Random(12)
    worth = set()
    for trial in range(400):
        lane, j = trial % LANES, 2 * rng.randrange(3)
        C = np.full((1, 8, LANES), 7.0)
        scale = rng.choice([1.0, 1.0, 1e-6, 1e-300, 1e200])
        lo, hi = sorted(rng.uniform(-3.0, 3.0) * scale for _ in range(2))
        if rng.random() < 0.2:
            hi = lo + rng.choice([1, 2, 9]) * np.spacing(abs(lo))
        low, high = sorted(rng.choice([-1.0, 1.0, 0.0, rng.uniform(-1.0, 1.0)]) for _ in range(2))
        if rng.random() < 0.2:
            high = low
        C[0, j : j + 2, lane] = lo, hi
        m, r = exact_symbols(lo, hi)
        answer = elimination.cut(C, lane, j, low, high)
        a, b = C[0, j : j + 2, lane]
        # All of m + r [low, high] that lies in the variable's bounds.
        least, most = max(Fraction(lo), m + r * Fraction(low)), min(Fraction(hi), m + r * Fraction(high))
        assert lo <= a <= b
        assert least > most or (a <= least and most <= b <= hi)
        room = 8 * max(np.spacing(abs(lo)), np.spacing(abs(hi)))
        assert least > most or (a >= float(least) - room and b <= float(most) + room)
        assert answer == (b - a < hi - lo and b - a <= elimination.WORTH * (hi - lo))
        worth.add(answer)
        C[0, j : j + 2, lane] = 7.0
        assert np.all(C == 7.0)
    assert worth == {True, False}


def test_a_symbol_is_cut_only_where_something_is_left_to_cut() -> None:
    E, T, L = EMPTY, OPEN, SMALLER
    cases = [
        # low, high, before, after, cut
        (-2.0, 2.0, T, T, False),
        (-1.0, 1.0, T, T, False),
        (-math.inf, math.inf, T, T, False),
        (math.nan, math.nan, T, T, False),
        (1.0 + 1e-15, 2.0, T, E, False),
        (-2.0, -1.0 - 1e-15, T, E, False),
        (-math.inf, -2.0, T, E, False),
        (2.0, math.inf, L, E, False),
        (-0.1, 0.1, T, L, True),
        (-0.1, 5.0, T, L, True),
        (-5.0, 0.1, T, L, True),
        (-0.9, 1.0, T, T, True),
        (-1.0, 0.9, L, L, True),
        (1.0, 1.0, T, L, True),
        (-1.0, -1.0, T, L, True),
        (-0.1, 0.1, E, E, False),
        (2.0, 3.0, E, E, False),
    ]
    for low, high, before, after, changed in cases:
        for lane in range(LANES):
            for symbol in range(3):
                C, W = np.full((1, 8, LANES), 7.0), np.full(WORK_SHAPE, 7.0)
                C[0, 2 * symbol : 2 * symbol + 2, lane] = -1.0, 3.0
                W[elimination.VERDICTS, 0, lane] = before
                elimination.cut_symbol(W, C, lane, symbol, low, high)
                assert W[elimination.VERDICTS, 0, lane] == after
                lo, hi = C[0, 2 * symbol : 2 * symbol + 2, lane]
                assert ((lo, hi) != (-1.0, 3.0)) == changed
                if changed:
                    assert lo == pytest.approx(1.0 + 2.0 * max(low, -1.0), abs=1e-14)
                    assert hi == pytest.approx(1.0 + 2.0 * min(high, 1.0), abs=1e-14)
                # A variable without width is nobody's business.
                C[0, 2 * symbol : 2 * symbol + 2, lane] = 1.0
                W[elimination.VERDICTS, 0, lane] = before
                elimination.cut_symbol(W, C, lane, symbol, low, high)
                assert W[elimination.VERDICTS, 0, lane] == before
                assert np.all(C[0, 2 * symbol : 2 * symbol + 2, lane] == 1.0)
                C[0, 2 * symbol : 2 * symbol + 2, lane] = 7.0
                W[elimination.VERDICTS, 0, lane] = 7.0
                assert np.all(C == 7.0) and np.all(W == 7.0)


class System:
    """Equations that hold at one point of the cell, other ones in every lane."""

    def __init__(self, rng: random.Random, S: Symbols, variables: int, count: int) -> None:
        self.F = random_rows(rng, S)
        self.W = np.full(WORK_SHAPE, rng.choice([math.nan, 7.0]))
        self.C = np.zeros((1, 2 * variables + 2, LANES))
        self.values: list[list[Fraction]] = []
        self.noise = [rng.choice([0.0, 1e-6, 1e-2, 0.1, 3.0]) for _ in range(LANES)]
        for lane in range(LANES):
            eps = unit_point(rng, S)
            exact = []
            for k in range(variables):
                middle, reach = rng.uniform(-1.0, 1.0), rng.choice([0.0, 1e-6, 0.3])
                lo, hi = middle - reach, middle + reach
                self.C[0, 2 * k : 2 * k + 2, lane] = lo, hi
                m, r = exact_symbols(lo, hi)
                # Just inside, also where the radius is rounded up.
                value = min(max(m + r * eps[k], Fraction(lo)), Fraction(hi))
                eps[k] = (value - m) / r if r else Fraction(0)
                exact.append(value)
            self.values.append(exact)
            for e in range(count):
                row = self.F[EQUATION + e, :, lane]
                vanishing_row(rng, S, row, eps, self.noise[lane])
                for k in range(variables):
                    if self.C[0, 2 * k, lane] == self.C[0, 2 * k + 1, lane]:
                        row[[1 + k, 1 + len(S.noise) + k]] = 0.0
        for e in range(count):
            kernels.close(self.F, EQUATION + e, S)
        self.W[elimination.VERDICTS, 0] = OPEN

    def holds(self) -> bool:
        """Return True when every cell still has its point."""
        return all(
            self.C[0, 2 * k, lane] <= x <= self.C[0, 2 * k + 1, lane]
            for lane, exact in enumerate(self.values)
            for k, x in enumerate(exact)
        )


@every_size
def test_contracted_cells_keep_their_solutions(S: Symbols) -> None:
    """By all equations at once, and by those solved for pivots; lanes that are EMPTY stay as they are."""
    rng = random.Random(13)
    variables = 3 if len(S.noise) == 4 else 6
    smaller = [0, 0]
    for trial in range(120):
        count = rng.randint(0, variables)
        system = System(rng, S, variables, count)
        F, W, C = system.F, system.W, system.C
        before = C.copy()
        dead = rng.choice([-1, rng.randrange(LANES)])
        if dead >= 0:
            W[elimination.VERDICTS, 0, dead] = EMPTY
        if trial % 2:
            elimination.contract(F, W, C, count, (0,) * variables, S)
        else:
            rank = elimination.solve_for_pivots(F, W, 0, count, variables, S)
            elimination.cut_pivots(F, W, C, rank, S)
        assert system.holds()
        assert np.all(before[0, ::2] <= C[0, ::2]) and np.all(C[0, 1::2] <= before[0, 1::2])
        for lane in range(LANES):
            verdict = W[elimination.VERDICTS, 0, lane]
            if lane == dead:
                assert verdict == EMPTY and np.array_equal(C[..., lane], before[..., lane])
                continue
            widths = (
                (C[0, 1::2] - C[0, ::2])[:variables, lane],
                (before[0, 1::2] - before[0, ::2])[:variables, lane],
            )
            much = any(now <= elimination.WORTH * was and now < was for now, was in zip(*widths, strict=True))
            # Several small cuts of one variable may add up.
            assert verdict == (SMALLER if much else OPEN) or (much and trial % 2 == 0)
            smaller[trial % 2] += much
    assert min(smaller) >= 20


@every_size
def test_contraction_finds_that_equations_cannot_hold(S: Symbols) -> None:
    """Only in the lane whose equation is moved away."""
    rng = random.Random(14)
    variables = 3 if len(S.noise) == 4 else 6
    found = tried = 0
    for trial in range(60):
        count = variables
        system = System(rng, S, variables, count)
        lane = rng.randrange(LANES)
        system.F[EQUATION, 0, lane] += rng.choice([-1, 1]) * rng.uniform(10.0, 20.0)
        system.C[0, ::2, lane], system.C[0, 1::2, lane] = -1.0, 1.0
        F, W, C = system.F, system.W, system.C
        if trial % 2:
            elimination.contract(F, W, C, count, (0,) * variables, S)
        else:
            rank = elimination.solve_for_pivots(F, W, 0, count, variables, S)
            elimination.cut_pivots(F, W, C, rank, S)
        verdicts = W[elimination.VERDICTS, 0]
        assert not any(v == EMPTY for k, v in enumerate(verdicts) if k != lane)
        if system.noise[lane] < 1e-3:
            tried += 1
            found += verdicts[lane] == EMPTY
    assert found >= 0.4 * tried > 5


@every_size
def test_an_equation_without_slopes_that_cannot_hold_empties_its_cell(S: Symbols) -> None:
    """As between two poses near a fold: it would fix no variable."""
    rng = random.Random(16)
    variables = 3 if len(S.noise) == 4 else 6
    for _ in range(20):
        system = System(rng, S, variables, 1)
        F, W = system.F, system.W
        away = rng.randrange(LANES)
        for lane in range(LANES):
            # Curved, and in one lane away from zero.
            F[EQUATION, :, lane] = 0.0
            F[EQUATION, 1 + len(S.noise), lane] = 1e-7
            F[EQUATION, 0, lane] = 1e-6 if lane == away else -0.5e-7
        kernels.close(F, EQUATION, S)
        elimination.contract(F, W, system.C, 1, (0,) * variables, S)
        for lane in range(LANES):
            verdict = EMPTY if lane == away else OPEN
            assert W[elimination.VERDICTS, 0, lane] == verdict


@every_size
def test_solved_rows_hold_zero_at_the_solution(S: Symbols) -> None:
    """Lane by lane, with other pivots and another number of them."""
    rng = random.Random(15)
    variables = 3 if len(S.noise) == 4 else 6
    different = 0
    for _ in range(60):
        count = rng.randint(1, variables)
        system = System(rng, S, variables, count)
        F, W = system.F, system.W
        rank = elimination.solve_for_pivots(F, W, 0, count, variables, S)
        ranks = []
        for lane, exact in enumerate(system.values):
            pivots = W[elimination.PIVOTS, : elimination.MOST_PIVOTS, lane]
            ranks.append(int(np.sum(pivots >= 0)))
            eps = [Fraction(0)] * len(S.noise)
            for k, x in enumerate(exact):
                m, r = exact_symbols(*system.C[0, 2 * k : 2 * k + 2, lane])
                eps[k] = (x - m) / r if r else Fraction(0)
            for s in range(rank):
                row = F[PIVOT + s, :, lane]
                if s >= ranks[-1]:
                    assert not row.any()
                elif variables == 6 and not S.data:
                    assert abs(polynomial(row, Point(eps))) <= Fraction(row[error_column(S)])
        assert rank == max(ranks)
        different += len(set(ranks)) > 1
    assert different >= 10
