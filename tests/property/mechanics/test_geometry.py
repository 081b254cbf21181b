"""A platform's forms enclose the exact geometry, and no test ever drops a planted equilibrium."""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest

from cdpr_interval.engine import contraction as platform_elimination
from cdpr_interval.engine import rows as engine_rows
from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.kernels.lanes import LANES
from cdpr_interval.kernels.second_order import ROTATION_ONLY, WHOLE_POSE, Symbols
from cdpr_interval.mechanics.six_dof import balance as platform_statics
from cdpr_interval.mechanics.six_dof import directions as platform_directions
from cdpr_interval.mechanics.six_dof import geometry as platform_polynomials
from cdpr_interval.mechanics.six_dof import rows as platform_rows
from solvers.six_dof.cells.columns import POSE_COLUMNS, ROTATION_COLUMNS
from solvers.six_dof.cells.kinds import (
    POSE_CELLS,
    RANGED_POSE_CELLS,
    RANGED_ROTATION_CELLS,
    ROTATION_CELLS,
)
from tests.support import lane_calls as calls
from tests.support import lane_platform as platform
from tests.support.kernel_callers import Callers
from tests.support.planted_platform import (
    HALF_TURN_SIGNS,
    UNCERTAIN,
    Planted,
    Vector,
    apply,
    cayley,
    cross,
    dot,
    minus,
    plant,
    plant_planar,
    shifted,
)
from tests.support.platform_cells import (
    Batch,
    Lane,
    Stepper,
    Trial,
    around,
    point_of,
    pose,
    pose_batches,
    pose_cell,
    pose_trial,
    turn,
    turn_batches,
    turn_cell,
    turn_trial,
)

elimination = Callers(platform_elimination, engine_rows)
forms = Callers(platform_polynomials, platform_rows, engine_rows)
statics = Callers(platform_statics, platform_directions, platform_rows)


COUNTS = (2, 3, 4, 5, 6)
"""Taut cables; two stand for the problem in a plane."""
SPREADS = (Fraction(0), Fraction(1, 10**7), Fraction(1, 5000))
"""Half widths of the data's ranges."""
CELLS = (0.8, 0.3, 0.05, 1e-3, 1e-7, 0.0)
"""Widths of the cells."""
KINDS = {False: (ROTATION_CELLS, POSE_CELLS), True: (RANGED_ROTATION_CELLS, RANGED_POSE_CELLS)}
"""The two kinds of cells, without and with symbols of data."""
ROUNDED = Fraction(1, 2**140)
"""What the position off the equilibrium, a square root, may be wrong by."""

every_count = pytest.mark.parametrize("n", COUNTS)
every_space = pytest.mark.parametrize("ranged", [False, True], ids=["errors", "symbols"])
"""Ranges of lengths as errors, and as symbols of data."""


@cache
def planted(n: int) -> list[Planted]:
    """Return a few robots with n taut cables, with exact and with uncertain data."""
    rng = random.Random(100 + n)
    if n == 2:
        return [plant_planar(rng, slack=2, width=spread) for spread in SPREADS for _ in range(3)]
    return [
        plant(rng, n, slack=2, width=spread, zero_tension=k == 2) for spread in SPREADS for k in range(3)
    ]  # fmt: skip


def mixed(
    rng: random.Random, robot: Planted, reaches: Sequence[float] = CELLS
) -> list[tuple[Planted, float]]:
    """Return the widths in random order, each with the robot as one of its charts sees it."""
    views = robot.views()
    return [(rng.choice(views), reach) for reach in rng.sample(reaches, len(reaches))]


def scaled(s: Fraction, v: Iterable[Fraction]) -> Vector:
    return [s * x for x in v]


def square_sum(u: Sequence[Fraction]) -> Fraction:
    return 1 + dot(u, u)


def check_block(lane: Lane, block: int, u: Vector, i: int) -> None:
    """Assert that s q_i, s d_i and s K_i are enclosed."""
    robot, s = lane.robot, square_sum(u)
    pivot = robot.pivot
    q = apply(robot.rotation(u), minus(robot.points[i], robot.points[pivot]))
    d = minus(minus(robot.anchors[i], robot.anchors[pivot]), q)
    offset = (dot(d, d) + robot.lengths_sq[pivot] - robot.lengths_sq[i]) / 2
    lane.enclose_all(block, scaled(s, [*q, *d, offset]))


def check_blocks(lane: Lane, u: Vector) -> None:
    """Assert that the blocks of the taut cables are right."""
    for j, i in enumerate(lane.robot.model.orders[0, 1:], start=1):
        check_block(lane, forms.CABLE + forms.BLOCK * j, u, i)


def check_wrenches(lane: Lane, u: Vector, x: Vector) -> None:
    """Assert that s w_i of the taut cables and s w_0 are enclosed: forces at B_i, moments about B_1."""
    robot = lane.robot
    s, size = square_sum(u), Fraction(robot.model.size)
    rotation = robot.rotation(u)
    pivot, *others = (int(c) for c in robot.model.orders[0])
    root = apply(rotation, robot.points[pivot])
    p = [a + b for a, b in zip(robot.centre(u, pivot), x, strict=True)]
    lane.enclose_all(forms.ROOT_ARM, scaled(s, root))
    for j, i in enumerate([pivot, *others]):
        arm = apply(rotation, robot.points[i])
        spoke = minus(minus(robot.anchors[i], p), arm)
        moment = [m / size for m in cross(minus(arm, root), spoke)]
        lane.enclose_all(forms.WRENCH + 6 * j, scaled(s, [*spoke, *moment]))
    moment = [-m / size for m in cross(root, robot.load)]
    lane.enclose_all(forms.LOAD, scaled(s, [*robot.load, *moment]))


def gap(robot: Planted, u: Vector, x: Vector, i: int) -> Fraction:
    """Return s (|e_i|^2 - l_i^2) / 2 where the pivot's length is right."""
    pivot = robot.pivot
    d = minus(robot.centre(u, i), robot.centre(u, pivot))
    offset = (dot(d, d) + robot.lengths_sq[pivot] - robot.lengths_sq[i]) / 2
    return square_sum(u) * (offset - dot(d, x))


def test_charts_show_the_same_equilibrium() -> None:
    seen = 0
    for n in COUNTS:
        for robot in planted(n):
            for view in robot.views():
                seen += 1
                assert view.rotation(view.u) == robot.rotation(robot.u)
                assert view.way() == robot.way() and view.branch() == robot.branch()
    assert seen > 2 * sum(len(planted(n)) for n in COUNTS)


@pytest.mark.parametrize("S", [ROTATION_ONLY, WHOLE_POSE], ids=["4", "6"])
def test_rotation_rows_enclose_every_rotation_of_the_cell(S: Symbols) -> None:
    rng = random.Random(1)
    for k in range(30):
        cells = np.zeros((LANES, ROTATION_COLUMNS.width))
        for cell in cells:
            reach = rng.choice(CELLS)
            for c in range(3):
                # Beyond the chart as well: uniqueness boxes reach out of it.
                middle = Fraction(rng.uniform(-3.0, 3.0))
                cell[2 * c : 2 * c + 2] = around(rng, middle, rng.choice([reach, reach, 0.0]))
            cell[turn.CHART] = rng.randrange(4)
        if k < 4:
            cells[k, :6] = [-1.0, 1.0] * 3
        batch = Batch(S, list(cells), [None] * LANES)
        forms.rotation_rows(batch.F, batch.C, turn.CHART, S)
        for lane in batch.lanes:
            signs = HALF_TURN_SIGNS[int(lane.cell[turn.CHART])]
            for _ in range(3):
                u = point_of(rng, lane.cell, 3)
                lane.point(u)
                s = square_sum(u)
                lane.encloses(forms.SCALE, s)
                lane.brackets(forms.SCALE, s)
                lane.enclose_all(
                    forms.ROTATION, [s * x * d for row in cayley(u) for x, d in zip(row, signs, strict=True)]
                )
        # Degree two is exact: only rounding remains.
        assert np.all(batch.F[forms.ROTATION : forms.SCALE + 1, -3] < 1e-13)


@every_space
@every_count
def test_rows_of_pose_cells_enclose_the_geometry(n: int, ranged: bool) -> None:
    rng = random.Random(2)
    for robot in planted(n):
        trials = [pose_trial(rng, view, reach) for view, reach in mixed(rng, robot)]
        for batch in pose_batches(trials, ranged):
            F, S = batch.F, batch.S
            assert pose.length_equations(F, batch.model, S) == n
            kept = F.copy()
            for second in (False, True):
                points = []
                for lane in batch.lanes:
                    view = lane.robot
                    unknowns = point_of(rng, lane.cell, 6) if second else [*view.u, *view.way()]
                    u, x = unknowns[:3], unknowns[3:]
                    points.append(u)
                    lane.point(unknowns)
                    lane.enclose_all(forms.POSITION, x)
                    check_blocks(lane, u)
                    for j, i in enumerate(view.model.orders[0, 1:], start=1):
                        lane.encloses(forms.EQUATION + j, gap(view, u, x, i))
                        lane.brackets(forms.EQUATION + j, gap(view, u, x, i))
                    lane.encloses(forms.EQUATION, dot(x, x) - view.lengths_sq[view.pivot])
                    check_wrenches(lane, u, x)
                for i in (n, n + 1):
                    forms.cable_rows(F, forms.SLACK_CABLE, batch.model, i, robot.pivot, S)
                    for lane, u in zip(batch.lanes, points, strict=True):
                        check_block(lane, forms.SLACK_CABLE, u, i)
            # The block of a slack cable is all that was written.
            kept[forms.SLACK_CABLE : forms.PLANE] = F[forms.SLACK_CABLE : forms.PLANE]
            assert np.array_equal(kept, F, equal_nan=True)


@every_space
@every_count
def test_smooth_branches_enclose_the_position(n: int, ranged: bool) -> None:
    """Both branches, at the equilibrium and all over the cell."""
    rng = random.Random(3)
    smooth = points = 0
    for k, start in enumerate(planted(n)):
        orders = start.ordered()
        robot = orders[k % len(orders)]
        trials = [
            turn_trial(rng, view, reach, branch) for branch in (1, -1) for view, reach in mixed(rng, robot)
        ]
        rng.shuffle(trials)
        for lane in (lane for batch in turn_batches(trials, ranged) for lane in batch.lanes if lane.found):
            smooth += 1
            lane.room = ROUNDED
            view, branch = lane.robot, int(lane.cell[turn.BRANCH])
            for u in [view.u, *(point_of(rng, lane.cell, 3) for _ in range(4))]:
                x = view.position(u, branch)
                if x is None:
                    continue
                if u is view.u and branch == view.branch():
                    assert max(abs(a - b) for a, b in zip(x, view.way(), strict=True)) < ROUNDED
                lane.point(u)
                lane.place(x)
                points += 1
                if points % 5 not in (1, 2):
                    continue
                check_blocks(lane, u)
                check_wrenches(lane, u, x)
                normal = view.frame(u)[2]
                lane.enclose_all(forms.NORMAL, scaled(square_sum(u) ** 2, normal))
    assert smooth >= 4 * len(planted(n))
    assert points >= 4 * smooth


@every_space
@every_count
def test_the_error_of_a_smooth_branch_is_small(n: int, ranged: bool) -> None:
    """Third order in the width of u, so that the enclosure is worth its name."""
    compared = 0
    for robot in planted(n)[:3]:
        trials = []
        for reach in (0.02, 0.01):
            cell = np.zeros(ROTATION_COLUMNS.width)
            for k, x in enumerate(robot.u):
                thin = robot.model.planar and k != 1
                cell[2 * k : 2 * k + 2] = [float(x) - reach * (not thin), float(x) + reach * (not thin)]
            cell[turn.CHART] = robot.chart
            trials.append(Trial(robot, cell, robot.branch(), reach))
        (batch,) = turn_batches(trials, ranged)
        wide, narrow = (
            lane.F[forms.POSITION, lane.error] + abs(lane.F[forms.POSITION, 1 + turn.ERROR_SYMBOL])
            for lane in batch.lanes
        )
        if batch.lanes[0].found:
            compared += 1
            assert batch.lanes[1].found
            assert narrow < 0.25 * wide + 1e-12
    assert compared >= 2


def exact_unknowns(robot: Planted) -> Vector:
    """Return (u, p, t); the tensions of six cables stand as 0."""
    return [*robot.u, *robot.p, *(robot.t if robot.n < 6 else [Fraction(0)] * 6)]


def between(lo: Any, hi: Any, values: Sequence[Fraction]) -> bool:
    return all(a <= x <= b for a, b, x in zip(lo, hi, values, strict=True))


def same(a: Any, b: Any) -> bool:
    """Return True when two pairs of arrays hold the same bounds."""
    return all(np.array_equal(x, y, equal_nan=True) for x, y in zip(a, b, strict=True))


@every_space
@every_count
def test_pose_and_tensions_of_the_equilibrium_are_enclosed(n: int, ranged: bool) -> None:
    """In every lane of a batch, and just the same for a cell on its own."""
    rng = random.Random(5)
    bounded = 0
    turns, poses = KINDS[ranged]
    for start in planted(n):
        for robot in start.ordered():
            trials = [turn_trial(rng, view, reach) for view, reach in mixed(rng, robot)]
            for batch in turn_batches(trials, ranged):
                flags = platform.solution_bounds(batch.F, batch.W, batch.model, batch.S)
                for lane in batch.lanes:
                    exact, known = exact_unknowns(lane.robot), lane.found and flags[lane.lane] > 0.0
                    found = batch.read(lane.lane, 6 + n)
                    assert not lane.found or between(found[0][:6], found[1][:6], exact[:6])
                    bounded += known
                    assert not known or between(*found, exact)
                    lo, hi = np.zeros((2, 6 + n))
                    assert turns.enclose(robot.model, lane.cell, lo, hi) == known
                    assert not known or same(found, (lo, hi))
                    assert turns.enclose(robot.model, lane.cell, lo[:6], hi[:6]) == lane.found
                    assert not lane.found or same((found[0][:6], found[1][:6]), (lo[:6], hi[:6]))
                    unknown = lane.cell.copy()
                    unknown[turn.BRANCH] = 0.0
                    assert not turns.enclose(robot.model, unknown, lo, hi)
        trials = [pose_trial(rng, view, reach) for view, reach in mixed(rng, start)]
        for batch in pose_batches(trials, ranged):
            flags = platform.solution_bounds(batch.F, batch.W, batch.model, batch.S)
            for lane in batch.lanes:
                exact = exact_unknowns(lane.robot)
                found = batch.read(lane.lane, 6 + n)
                assert between(found[0][:6], found[1][:6], exact[:6])
                lo, hi = np.zeros((2, 6 + n))
                known = poses.enclose(start.model, lane.cell, lo, hi)
                assert known == (flags[lane.lane] > 0.0)
                if known:
                    bounded += 1
                    assert between(lo, hi, exact) and same(found, (lo, hi))
                assert poses.enclose(start.model, lane.cell, lo[:6], hi[:6])
                assert same((found[0][:6], found[1][:6]), (lo[:6], hi[:6]))
    assert bounded >= 4 * len(planted(n))


@every_space
@every_count
def test_position_bounds_hold_every_position_of_the_cell(n: int, ranged: bool) -> None:
    rng = random.Random(6)
    for robot in planted(n):
        trials = [pose_trial(rng, view, reach) for view, reach in mixed(rng, robot)]
        for batch in pose_batches(trials, ranged):
            turn.position_bounds(batch.F, batch.W, batch.model, batch.S)
            for lane in batch.lanes:
                lo, hi = batch.read(lane.lane, 6)
                view = lane.robot
                for _ in range(4):
                    u, x = point_of(rng, lane.cell, 3), point_of(rng, lane.cell[6:], 3)
                    p = [a + b for a, b in zip(view.centre(u, view.pivot), x, strict=True)]
                    if robot.model.planar:
                        # Only the plane matters, and u and x lie in it up to rounding.
                        u[0] = u[2] = x[1] = p[1] = Fraction(0)
                        p = [a + b for a, b in zip(view.centre(u, view.pivot), x, strict=True)]
                    assert between(lo, hi, [*u, *p])
                assert lane.trial is not None
                if lane.trial.reach < 1e-6 and robot is planted(n)[0]:
                    assert np.all(hi - lo < 1e-5)


@pytest.mark.parametrize("name", UNCERTAIN)
@pytest.mark.parametrize("n", [3, 5])
def test_the_error_of_every_datum_is_counted(n: int, name: str) -> None:
    """In tiny cells nothing else makes room for a datum at the border of its enclosure."""
    rng = random.Random(7)
    enclosed = 0
    for robot in (shifted(robot, name, 1e-5) for robot in planted(n)[:3]):
        views = robot.views()[:LANES]
        (near,) = turn_batches([turn_trial(rng, view, 1e-9) for view in views])
        assert not platform.no_position(near.F, robot.model, near.S)[: len(views)].any()
        known = platform.solution_bounds(near.F, near.W, robot.model, near.S)
        for lane in near.lanes:
            lane.point(lane.robot.u)
            if lane.found:
                enclosed += 1
                lane.place(lane.robot.way())
                check_wrenches(lane, lane.robot.u, lane.robot.way())
                assert known[lane.lane]
                assert between(*near.read(lane.lane, 6 + n), exact_unknowns(lane.robot))
        (whole,) = pose_batches([pose_trial(rng, view, 1e-9) for view in views])
        count = pose.length_equations(whole.F, robot.model, whole.S)
        known = platform.solution_bounds(whole.F, whole.W, robot.model, whole.S)
        for lane in whole.lanes:
            u, x = lane.robot.u, lane.robot.way()
            lane.point([*u, *x])
            check_blocks(lane, u)
            check_wrenches(lane, u, x)
            lane.enclose_all(forms.EQUATION, [Fraction(0)] * count)
            if known[lane.lane]:
                enclosed += 1
                assert between(*whole.read(lane.lane, 6 + n), exact_unknowns(lane.robot))
    assert enclosed >= 10


def tensions(batch: Batch, lane: Lane, n: int) -> tuple[Any, Any]:
    """Return the bounds that ``tension_bounds`` left for a lane."""
    return batch.W[turn.TENSIONS, :n, lane.lane], batch.W[turn.TENSIONS + 1, :n, lane.lane]


def rows_at(rng: random.Random, robot: Planted, reaches: Sequence[float]) -> Iterator[Batch]:
    """Yield the rows of cells of both kinds around the equilibrium."""
    views = mixed(rng, robot, reaches)
    yield from turn_batches([turn_trial(rng, view, reach) for view, reach in views])
    yield from pose_batches([pose_trial(rng, view, reach) for view, reach in views])


def test_tension_bounds_of_six_cables() -> None:
    """The search does not use them for six cables, but they hold as well."""
    rng = random.Random(8)
    bounded = 0
    for robot in planted(6):
        t = [robot.t[i] for i in robot.model.orders[0]]
        for batch in rows_at(rng, robot, (1e-3, 1e-5, 1e-8, 0.0)):
            known = platform.tension_bounds(batch.F, batch.W, 6, batch.S)
            for lane in batch.lanes:
                if lane.found and known[lane.lane]:
                    bounded += 1
                    assert between(*tensions(batch, lane, 6), t)
    assert bounded >= 30


@every_count
def test_tension_bounds_are_tight_at_a_point(n: int) -> None:
    rng = random.Random(9)
    for robot in [planted(n)[0], planted(n)[1]]:
        t = [robot.t[i] for i in robot.model.orders[0]]
        for batch in rows_at(rng, robot, (0.0, 0.3)):
            known = platform.tension_bounds(batch.F, batch.W, n, batch.S)
            for lane in batch.lanes:
                assert lane.trial is not None
                if lane.trial.reach == 0.0:
                    assert lane.found and known[lane.lane]
                    lo, hi = tensions(batch, lane, n)
                    assert between(lo, hi, t)
                    assert np.all(hi - lo < 1e-7)


def at_equilibrium(
    rng: random.Random, robot: Planted, reaches: Sequence[float], ranged: bool = False
) -> Iterator[Batch]:
    """Yield the rows of cells with the equilibrium as their point, for all orders.

    The solved lengths stand in PIVOT.., as in both searches.
    """
    n = robot.n
    solve = elimination.solve_for_pivots
    for turned in robot.ordered():
        trials = [turn_trial(rng, *trial) for trial in mixed(rng, turned, reaches)]
        for batch in turn_batches(trials, ranged):
            lengths = 0
            for j in range(2 if robot.model.planar else 3, n):
                block = forms.CABLE + forms.BLOCK * j
                forms.length_row(batch.F, forms.EQUATION + lengths, block, batch.S)
                lengths += 1
            batch.rank = solve(batch.F, batch.W, 0, lengths, forms.U_SYMBOLS, batch.S)
            batch.lanes = [lane for lane in batch.lanes if lane.found]
            for lane in batch.lanes:
                lane.point(lane.robot.u)
                lane.place(lane.robot.way())
            if batch.lanes:
                yield batch
    trials = [pose_trial(rng, *trial) for trial in mixed(rng, robot, reaches)]
    for batch in pose_batches(trials, ranged):
        count = pose.length_equations(batch.F, batch.model, batch.S)
        batch.rank = solve(batch.F, batch.W, 0, count, pose.VARIABLES, batch.S)
        for lane in batch.lanes:
            lane.point([*lane.robot.u, *lane.robot.way()])
        yield batch


def pivots_of(lane: Lane) -> list[int]:
    """Return the symbols a lane's lengths were solved for."""
    return [int(k) for k in lane.W[elimination.PIVOTS, : elimination.MOST_PIVOTS] if k >= 0]


@every_space
@every_count
def test_solved_rows_vanish_and_reduced_rows_keep_their_values(n: int, ranged: bool) -> None:
    rng = random.Random(10)
    solved = 0
    for robot in planted(n):
        for batch in at_equilibrium(rng, robot, CELLS[1:5], ranged):
            F, W, S = batch.F, batch.W, batch.S
            ranks = [len(pivots_of(lane)) for lane in batch.lanes]
            assert max(ranks) <= batch.rank
            for lane, rank in zip(batch.lanes, ranks, strict=True):
                pivots = pivots_of(lane)
                assert len(set(pivots)) == rank
                solved += rank
                lane.enclose_all(forms.PIVOT, [Fraction(0)] * rank)
                assert not lane.F[forms.PIVOT + rank : forms.PIVOT + batch.rank].any()
                for k in range(rank):
                    lane.brackets(forms.PIVOT + k, Fraction(0))
                    slopes = lane.F[forms.PIVOT + k, 1:][pivots]
                    assert np.allclose(slopes, np.eye(rank)[k], atol=1e-9)
            for k in range(3):
                calls.scale(F, forms.SCRATCH, forms.WRENCH + k, np.ones(LANES), S)
                elimination.reduce_row(F, forms.SCRATCH, W, batch.rank, S)
                for lane in batch.lanes:
                    # The pivot's wrench is -s x.
                    value = -square_sum(lane.robot.u) * lane.robot.way()[k]
                    lane.encloses(forms.SCRATCH, value)
                    lane.brackets(forms.SCRATCH, value)
                    size = abs(lane.F[forms.WRENCH + k, 1 : lane.error]).sum()
                    assert np.all(abs(lane.F[forms.SCRATCH, 1:][pivots_of(lane)]) <= 1e-9 * size)
    assert solved >= (2 if n == 2 else n) * 10


def test_pivots_are_not_taken_from_rows_drowned_in_noise() -> None:
    """In the lanes of the noise; their rows stay as they are, bit by bit, when others are reduced."""
    rng = random.Random(11)
    robot = planted(4)[0]
    for noisy in ([0], [1, 2], [3], range(LANES)):
        (batch,) = pose_batches([pose_trial(rng, robot, 1e-3) for _ in range(LANES)])
        F, W, S = batch.F, batch.W, batch.S
        assert pose.length_equations(F, batch.model, S) == 4
        for lane in noisy:
            F[forms.EQUATION : forms.EQUATION + 4, -3, lane] = rng.choice([1e3, np.inf, np.nan])
        rank = elimination.solve_for_pivots(F, W, 0, 4, pose.VARIABLES, S)
        assert rank == (0 if len(noisy) == LANES else 4)
        for row in range(forms.WRENCH, forms.WRENCH + 24):
            before = F[row].copy()
            elimination.reduce_row(F, row, W, rank, S)
            for lane in batch.lanes:
                untouched = np.array_equal(F[row, :, lane.lane], before[:, lane.lane])
                assert len(pivots_of(lane)) == (0 if lane.lane in noisy else 4)
                assert untouched if lane.lane in noisy else not untouched or not before[1:-3].any()


@every_space
@every_count
def test_statics_keeps_cells_with_an_equilibrium(n: int, ranged: bool) -> None:
    rng = random.Random(12)
    limited = written = 0
    needed = np.ones(LANES)
    for robot in planted(n):
        for batch in at_equilibrium(rng, robot, CELLS, ranged):
            F, W, S = batch.F, batch.W, batch.S
            t = [robot.t[i] for i in batch.model.orders[0]]
            for used in (batch.rank, 0):
                statics.centre_columns(F, W, n)
                free = platform.balance_free(F, W, n, used, needed, S)
                assert not free[[lane.lane for lane in batch.lanes]].any()
                statics.centre_columns(F, W, n)
                flags = platform.limit_tensions(F, W, n, used, S)
                lanes = [lane for lane in batch.lanes if flags[lane.lane] > 0.0]
                limited += len(lanes)
                for lane in lanes:
                    most = lane.W[statics.MOST_TENSION]
                    assert all(x <= limit for x, limit in zip(t, most, strict=False))
                for chosen in range(3 if n < 6 else 0):
                    for lane in lanes if chosen else []:
                        # As far from the middle as the tensions may be.
                        lane.W[statics.MOST_TENSION, :n] = [enclose(x)[1] for x in t]
                        some = 0.0 if chosen == 1 + lane.lane % 2 else 2.0 * np.array(t, dtype=float)
                        lane.W[statics.SOME_TENSION, :n] = some
                    statics.statics_equations(F, W, n, n, used, S)
                    for lane in lanes:
                        written += 6 - n
                        first = forms.EQUATION + n
                        assert np.isfinite(F[first : first + 6 - n, :, lane.lane]).all()
                        lane.enclose_all(first, [Fraction(0)] * (6 - n))
                        for row in range(first, first + 6 - n):
                            lane.brackets(row, Fraction(0))
    assert limited >= 5 * len(planted(n))
    assert written >= (6 - n) * 12 * len(planted(n))


def excluded_by_statics(batch: Batch, n: int, rank: int) -> int:
    """Return in how many lanes no equilibrium is left."""
    statics.centre_columns(batch.F, batch.W, n)
    free = platform.balance_free(batch.F, batch.W, n, rank, np.ones(LANES), batch.S)
    return sum(free[lane.lane] > 0.0 for lane in batch.lanes)


@every_space
@every_count
def test_statics_excludes_cells_far_from_balance(n: int, ranged: bool) -> None:
    """The test above would pass for a kernel that never excludes anything."""
    rng = random.Random(13)
    excluded = 0
    for robot in planted(n):
        trials = []
        for _ in range(10):
            trial = pose_trial(rng, robot, 1e-3)
            trial.cell[6:12] += np.repeat([rng.uniform(-2.0, 2.0) for _ in range(3)], 2)
            if robot.model.planar:
                trial.cell[8:10] = 0.0
            trials.append(trial)
        excluded += sum(excluded_by_statics(batch, n, 0) for batch in pose_batches(trials, ranged))
    assert excluded >= 30


@every_space
@every_count
def test_statics_excludes_an_equilibrium_of_pushing_cables(n: int, ranged: bool) -> None:
    rng = random.Random(14)
    excluded = tried = 0
    for robot in planted(n)[:2]:
        turned = replace(robot, model=robot.model._replace(load=-robot.model.load))
        for batch in at_equilibrium(rng, turned, (1e-4, 1e-7), ranged):
            tried += len(batch.lanes)
            excluded += excluded_by_statics(batch, n, batch.rank)
    assert excluded >= 0.5 * tried


@every_space
@every_count
def test_no_position_is_claimed_only_where_the_spheres_do_not_meet(n: int, ranged: bool) -> None:
    rng = random.Random(15)
    claimed = 0
    for robot in (turned for start in planted(n) for turned in start.ordered()):
        for batch in turn_batches([turn_trial(rng, *trial) for trial in mixed(rng, robot)], ranged):
            none = platform.no_position(batch.F, robot.model, batch.S)
            assert not none[[lane.lane for lane in batch.lanes]].any()
        # Half the pivot's length: the spheres meet less often.
        lengths_sq, exact = robot.model.lengths_sq.copy(), list(robot.lengths_sq)
        lengths_sq[robot.pivot] *= 0.25
        exact[robot.pivot] /= 4
        short = replace(robot, model=robot.model._replace(lengths_sq=lengths_sq), lengths_sq=exact)
        trials = []
        for view, reach in mixed(rng, short, (0.3, 0.05, 1e-3)):
            trial = turn_trial(rng, view, reach, 1)
            for k in range(3):
                if not robot.model.planar or k == 1:
                    trial.cell[2 * k : 2 * k + 2] += rng.uniform(-2.0, 2.0)
            trials.append(trial)
        (batch,) = turn_batches(trials, ranged)
        none = platform.no_position(batch.F, short.model, batch.S)
        for lane in batch.lanes:
            if none[lane.lane]:
                claimed += 1
                for _ in range(5):
                    assert lane.robot.position(point_of(rng, lane.cell, 3), 1) is None
    assert claimed >= 5


@every_count
def test_spheres_that_just_touch_have_a_position(n: int) -> None:
    """The lengths are such that the two branches meet at the planted u; the pivot's is at its border."""
    rng = random.Random(22)
    apart = 0
    for start in planted(n)[:6]:
        robot = rng.choice(start.ordered())
        pivot = robot.pivot
        m = robot.frame(robot.u)[2]
        height = dot(m, robot.way())
        foot = [a - height / dot(m, m) * b for a, b in zip(robot.way(), m, strict=True)]
        lengths_sq = [x - height**2 / dot(m, m) for x in robot.lengths_sq]
        values = np.array([float(x) for x in lengths_sq])
        errors = np.spacing(abs(values))
        values[pivot] -= 1e-5
        errors[pivot] += 1e-5 * (1.0 + 1e-6)
        for shift in (0.0, 1e-3, 0.1):
            model = robot.model._replace(lengths_sq=values, lengths_sq_err=errors.copy())
            model.lengths_sq_err[pivot] -= 1e-5 if shift else 0.0
            # All spheres shrink, their planes stay: they no longer meet.
            model = model._replace(lengths_sq=values - shift)
            changed = replace(robot, model=model)
            reaches = rng.sample([1e-5, 1e-9, 0.0], 3)
            (batch,) = turn_batches([turn_trial(rng, changed, reach, 1) for reach in reaches])
            claimed = platform.no_position(batch.F, model, batch.S)
            for lane in batch.lanes:
                if lane.found and not shift:
                    lane.point(robot.u)
                    lane.place(foot)
                assert shift or not claimed[lane.lane]
                apart += claimed[lane.lane] > 0.0
    assert apart >= 5


@every_space
@every_count
def test_slack_is_excluded_only_by_a_cable_that_is_too_long(n: int, ranged: bool) -> None:
    rng = random.Random(16)
    excluded = 0
    needed = np.ones(LANES)
    for robot in planted(n):
        short = robot.model.lengths_sq.copy()
        cable = rng.choice([n, n + 1])
        short[cable] = float(robot.lengths_sq[cable]) * rng.choice([0.3, 0.9])
        cut = robot.model._replace(lengths_sq=short)
        views = mixed(rng, robot)
        for batch in turn_batches([turn_trial(rng, *trial) for trial in views], ranged):
            flags = platform.slack_excluded(batch.F, batch.W, robot.model, needed, batch.S)
            assert not any(lane.found and flags[lane.lane] for lane in batch.lanes)
        for batch in pose_batches([pose_trial(rng, *trial) for trial in views], ranged):
            F, W, S = batch.F, batch.W, batch.S
            flags = platform.slack_excluded(F, W, robot.model, needed, S)
            assert not any(flags[lane.lane] for lane in batch.lanes)
            flags = platform.slack_excluded(F, W, cut, needed, S)
            for lane in (lane for lane in batch.lanes if flags[lane.lane]):
                excluded += 1
                view = lane.robot
                limit = Fraction(short[cable]) - Fraction(robot.model.lengths_sq_err[cable])
                for _ in range(5):
                    u, x = point_of(rng, lane.cell, 3), point_of(rng, lane.cell[6:], 3)
                    e = minus(minus(view.centre(u, cable), view.centre(u, view.pivot)), x)
                    # Up to what the pivot's sphere is missed by.
                    assert dot(e, e) - (dot(x, x) - robot.lengths_sq[view.pivot]) > limit
            # Lanes that do not matter may be answered or not, the others just the same.
            some = np.array([rng.choice([0.0, 1.0]) for _ in range(LANES)])
            again = platform.slack_excluded(F, W, cut, some, S)
            assert np.array_equal(again[some > 0.0], flags[some > 0.0])
    assert excluded >= 10


def holds(cell: Any, values: Sequence[Fraction]) -> bool:
    return all(cell[2 * k] <= x <= cell[2 * k + 1] for k, x in enumerate(values))


def check_family(parent: Any, verdict: int, family: Any, values: int) -> None:
    """Assert that children lie in their parent and share its volume."""
    lo, hi = slice(0, 2 * values, 2), slice(1, 2 * values, 2)
    for child in family:
        assert np.all(parent[lo] <= child[lo]) and np.all(child[hi] <= parent[hi])
        assert np.all(child[lo] <= child[hi])
    assert verdict <= 0 or np.isclose(family[:, -1].sum(), parent[-1])


def descend(rng: random.Random, stepper: Stepper, trials: Sequence[Trial]) -> list[int]:
    """Follow the equilibria down to leaves, as many as there are lanes at a time, in changing company.

    A child that holds one must keep it, also one of several that share it at a face. Returns the leaves'
    kinds, 0 where the cell was dropped.
    """
    searches_u = stepper.search is turn
    kinds = [-1] * len(trials)
    waiting = list(range(len(trials)))
    active: list[tuple[int, Any]] = []
    for _ in range(600 * len(trials)):
        while waiting and len(active) < LANES:
            active.append((waiting[0], trials[waiting.pop(0)].cell))
        if not active:
            return kinds
        rng.shuffle(active)
        # Not always as many as could be.
        count = len(active) if rng.random() < 0.7 else rng.randint(1, len(active))
        going = active[count:]
        for (k, cell), (verdict, family) in zip(
            active, stepper.step([c for _, c in active[:count]]), strict=False
        ):
            robot = trials[k].robot
            values = robot.u if searches_u else [*robot.u, *robot.way()]
            check_family(cell, verdict, family, len(values))
            if verdict <= 0:
                assert verdict == 0 or holds(family[0], values)
                kinds[k] = -verdict
                continue
            keep = [child for child in family if holds(child, values)]
            if searches_u:
                keep = [child for child in keep if child[turn.BRANCH] in (0.0, trials[k].branch)]
            assert keep
            going.append((k, rng.choice(keep)))
        active = going
    raise AssertionError("no leaf after 600 steps")


def whole_space(robot: Planted) -> Any:
    """Return a (u, x) cell that holds everything within the pivot's length."""
    reach = robot.model.lengths[robot.model.orders[0, 0], 1]
    cell = np.zeros(POSE_COLUMNS.width)
    for k in range(3):
        flat = robot.model.planar and k != 1
        cell[2 * k : 2 * k + 2] = [0.0, 0.0] if flat else [-1.0, 1.0]
        cell[6 + 2 * k : 8 + 2 * k] = [0.0, 0.0] if robot.model.planar and k == 1 else [-reach, reach]
    cell[POSE_COLUMNS.chart], cell[POSE_COLUMNS.share] = robot.chart, 1.0
    return cell


def variants(rng: random.Random, robot: Planted) -> list[Planted]:
    """Return the robot with the tests of statics and slack cables on and off."""
    found = []
    for signs, slack in ((True, True), (False, True), (True, False)):
        changed = robot.model._replace(statics=signs, slack=slack)
        if not signs and robot.n == 6:
            # Six lengths alone: nothing needs to balance any more.
            changed = changed._replace(load=np.array([rng.uniform(-50.0, 50.0) for _ in range(3)]))
        found.append(replace(robot, model=changed))
    return found


@every_space
@every_count
def test_the_search_in_u_keeps_the_equilibrium_from_the_whole_chart(n: int, ranged: bool) -> None:
    """In every chart that holds it, together."""
    rng = random.Random(17)
    kinds = []
    for start in planted(n):
        for robot in (turned for changed in variants(rng, start) for turned in changed.ordered()):
            trials = [
                Trial(view, np.array([*whole_space(view)[:6], view.chart, 0.0, 1.0]), view.branch(), 2.0)
                for view in robot.views(1)
            ]
            kinds += descend(rng, Stepper(turn, robot.model, ranged=ranged), trials)
    assert set(kinds) <= {turn.SMALL, turn.FOLDED}
    assert kinds.count(turn.SMALL) >= 0.2 * len(kinds)


@every_space
@every_count
def test_the_search_in_u_keeps_the_equilibrium_of_any_cell(n: int, ranged: bool) -> None:
    rng = random.Random(18)
    kinds = []
    for start in planted(n):
        for changed in variants(rng, start):
            robot = rng.choice(changed.ordered())
            trials = []
            for view, reach in mixed(rng, robot):
                branch = view.branch()
                cell = turn_cell(rng, view, reach, rng.choice([0, branch]))
                trials.append(Trial(view, cell, branch, reach))
            kinds += descend(rng, Stepper(turn, robot.model, ranged=ranged), trials)
    assert set(kinds) <= {turn.SMALL, turn.FOLDED}
    assert kinds.count(turn.SMALL) >= 0.2 * len(kinds)


@every_space
@every_count
def test_the_search_in_u_and_x_keeps_the_equilibrium(n: int, ranged: bool) -> None:
    rng = random.Random(19)
    for start in planted(n):
        for robot in variants(rng, start):
            views = robot.views()
            trials = [pose_trial(rng, rng.choice(views), reach) for reach in rng.sample(CELLS, 2)]
            trials += [Trial(view, whole_space(view), 0, 2.0) for view in robot.views(1)[:2]]
            assert set(descend(rng, Stepper(pose, robot.model, ranged=ranged), trials)) == {turn.SMALL}


@every_space
@every_count
def test_the_searches_drop_most_cells(n: int, ranged: bool) -> None:
    """The tests above would pass for a search that keeps everything."""
    rng = random.Random(20)
    dropped = 0
    for robot in planted(n)[:3]:
        near, whole = (Stepper(search, robot.model, ranged=ranged) for search in (turn, pose))
        for _ in range(5):
            cells, far = [], []
            for _ in range(LANES):
                cell = turn_cell(rng, robot, 1e-3, rng.choice([-1, 1]))
                other = pose_cell(rng, robot, 1e-3)
                for k in range(3):
                    if not robot.model.planar or k == 1:
                        cell[2 * k : 2 * k + 2] += rng.choice([-1, 1]) * rng.uniform(0.1, 0.5)
                    if not robot.model.planar or k != 1:
                        other[6 + 2 * k : 8 + 2 * k] += rng.choice([-1, 1]) * rng.uniform(0.1, 0.5)
                cells.append(cell)
                far.append(other)
            dropped += sum(verdict == 0 for verdict, _ in near.step(cells))
            dropped += sum(verdict == 0 for verdict, _ in whole.step(far))
    assert dropped >= 80


def box_row(robot: Planted, lo: Any, hi: Any) -> Any:
    return np.concatenate([[robot.chart], lo, hi])[None, :]


def run_search(rng: random.Random, robot: Planted, search: str, roots: Any) -> int:
    """Return what becomes of a small cell with the planted equilibrium, given settled boxes.

    Beside it, cells of other charts, where the boxes mean nothing.
    """
    views = robot.views()[:LANES]
    if search == "u":
        stepper = Stepper(turn, robot.model, roots, 1e-8)
        trials = [turn_trial(rng, view, 1e-3) for view in views]
    else:
        stepper = Stepper(pose, robot.model, roots, 1e-8)
        trials = [pose_trial(rng, view, 1e-3) for view in views]
    first, *others = descend(rng, stepper, trials)
    assert roots[0, 0] != robot.chart or 0 not in others
    return first


@every_count
@pytest.mark.parametrize("search", ["u", "u and x"])
def test_a_cell_is_settled_only_inside_a_box_in_all_unknowns(n: int, search: str) -> None:
    """A box around the equilibrium settles it; one that misses it in any single unknown never does."""
    rng = random.Random(21)
    for robot in [r for r in planted(n) if n == 6 or 0 not in r.t][:3]:
        exact = np.array([float(x) for x in exact_unknowns(robot)])
        reach = np.array([0.3] * 3 + [1.0] * 3 + [20.0] * n)
        lo, hi = exact - reach, exact + reach
        assert run_search(rng, robot, search, box_row(robot, lo, hi)) == 0
        wrong = box_row(robot, lo, hi)
        wrong[0, 0] = (robot.chart + 1) % 4
        assert run_search(rng, robot, search, wrong) != 0
        for k in range(6 + n):
            for side in (-1, 1):
                a, b = lo.copy(), hi.copy()
                if side > 0:
                    a[k] = exact[k] + 1e-6
                else:
                    b[k] = exact[k] - 1e-6
                missed = box_row(robot, a, b)
                assert run_search(rng, robot, search, missed) != 0
        # The right box may stand anywhere in the list.
        rows = np.concatenate([missed, wrong, box_row(robot, lo, hi)])
        assert run_search(rng, robot, search, rows) == 0


@pytest.mark.parametrize("n", (3, 4, 6))
def test_no_cell_is_its_own_child(n: int) -> None:
    """Cells of a few doubles: a search would look at such a child for ever."""
    rng = random.Random(31 + n)
    for robot in planted(n):
        stepper = Stepper(pose, robot.model)
        for _ in range(10):
            cells = [pose_cell(rng, robot, 0.0) for _ in range(LANES)]
            for cell in cells:
                for k in range(6):
                    cell[2 * k + 1] += rng.choice([0, 1, 5, 300, 5000]) * np.spacing(abs(cell[2 * k]))
            for _ in range(60):
                done = stepper.step(cells)
                single = [k for k, (verdict, _) in enumerate(done) if verdict == 1]
                for k in single:
                    assert not np.array_equal(done[k][1][0], cells[k])
                cells = [done[k][1][0] for k in single]
                if not cells:
                    break


@pytest.mark.parametrize(("low", "high"), [(0.0, 5e-324), (1.0, 1.0), (0.0, 0.0)])
def test_a_cut_without_progress_is_not_worth_another_look(low: float, high: float) -> None:
    for lane in range(LANES):
        cells = np.full((1, 4, LANES), 7.0)
        cells[0, :2, lane] = low, high
        before = cells.copy()
        assert not elimination.cut(cells, lane, 0, -0.1, 0.1)
        assert np.array_equal(cells, before)


def test_a_width_is_worth_another_look_at_the_same_share_everywhere() -> None:
    assert elimination.shrunk(0.6, 1.0) and elimination.shrunk(1716.0, 2860.0)
    assert not elimination.shrunk(0.7, 1.0) and not elimination.shrunk(0.0, 0.0)
