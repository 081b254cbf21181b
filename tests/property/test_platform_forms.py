"""A platform's forms enclose the exact geometry, and no test ever drops a planted equilibrium."""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest

from cdpr_interval.kernels.enclosure import enclose
from cdpr_interval.kernels.second_order import ROTATION_ONLY, WHOLE_POSE, Symbols, bounds, scale, width
from solvers import platform_elimination as elimination
from solvers import platform_polynomials as forms
from solvers import platform_pose as pose
from solvers import platform_statics as statics
from solvers import platform_turn as turn
from tests.exact_rows import Point, polynomial
from tests.planted_platform import (
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

COUNTS = (2, 3, 4, 5, 6)
"""Taut cables; two stand for the problem in a plane."""
SPREADS = (Fraction(0), Fraction(1, 10**7), Fraction(1, 5000))
"""Half widths of the data's ranges."""
CELLS = (0.8, 0.3, 0.05, 1e-3, 1e-7, 0.0)
"""Widths of the cells."""
ROUNDED = Fraction(1, 2**140)
"""What the position off the equilibrium, a square root, may be wrong by."""

every_count = pytest.mark.parametrize("n", COUNTS)


@cache
def planted(n: int) -> list[Planted]:
    """Return a few robots with n taut cables, with exact and with uncertain data."""
    rng = random.Random(100 + n)
    if n == 2:
        return [plant_planar(rng, slack=2, width=spread) for spread in SPREADS for _ in range(3)]
    return [
        plant(rng, n, slack=2, width=spread, zero_tension=k == 2) for spread in SPREADS for k in range(3)
    ]  # fmt: skip


def around(rng: random.Random, x: Fraction, reach: float) -> tuple[float, float]:
    """Return bounds that hold x, often just so at one end."""
    lo, hi = enclose(x)
    side = rng.choice([0.0, 1.0, rng.random()])
    return lo - side * reach, hi + (1.0 - side) * reach


def u_box(rng: random.Random, robot: Planted, reach: float) -> list[float]:
    """Return bounds of u; some entries are fixed where u is a double."""
    box: list[float] = []
    for k, x in enumerate(robot.u):
        thin = robot.model.planar and k != 1
        thin = thin or (Fraction(float(x)) == x and rng.random() < 0.3)
        box += around(rng, x, 0.0 if thin else reach)
    return box


def turn_cell(rng: random.Random, robot: Planted, reach: float, order: int = 0, branch: int = 0) -> Any:
    """Return a cell in u that holds the planted equilibrium."""
    cell = np.zeros(turn.WIDTH)
    cell[:6] = u_box(rng, robot, reach)
    cell[turn.CHART], cell[turn.BRANCH], cell[turn.ORDER] = robot.chart, branch, order
    cell[turn.SHARE] = 1.0
    return cell


def pose_cell(rng: random.Random, robot: Planted, reach: float) -> Any:
    """Return a (u, x) cell that holds the planted equilibrium."""
    cell = np.zeros(pose.P_WIDTH)
    cell[:6] = u_box(rng, robot, reach)
    for k, x in enumerate(way(robot, 0)):
        thin = robot.model.planar and k == 1
        cell[6 + 2 * k : 8 + 2 * k] = around(rng, x, 0.0 if thin else reach)
    cell[pose.P_CHART], cell[pose.P_SHARE] = robot.chart, 1.0
    return cell


def way(robot: Planted, order: int) -> Vector:
    """Return x of the planted equilibrium."""
    return minus(robot.p, robot.centre(robot.u, int(robot.model.orders[order, 0])))


def branch_of(robot: Planted, order: int) -> int:
    return 1 if robot.sigma(order) >= 0 else -1


def inside(rng: random.Random, lo: float, hi: float) -> Fraction:
    """Return an exact number in [lo, hi], often an end."""
    return Fraction(lo) + (Fraction(hi) - Fraction(lo)) * rng.choice(
        [0, 1, Fraction(rng.randint(0, 999), 999)]
    )


def point_of(rng: random.Random, cell: Any, variables: int) -> Vector:
    return [inside(rng, cell[2 * k], cell[2 * k + 1]) for k in range(variables)]


class Checker:
    """Rows of a cell, and a point of it in exact numbers."""

    def __init__(self, S: Symbols) -> None:
        self.S = S
        self.F = np.zeros((forms.FORM_ROWS, width(S)))
        self.W = np.zeros(forms.WORK_SHAPE)
        self.at = Point([Fraction(0)] * len(S))
        self.room = Fraction(0)

    def context(self, robot: Planted, roots: Any, leaf_size: float) -> tuple[Any, ...]:
        lo, hi = np.zeros((2, 6 + robot.n))
        return robot.model, roots, leaf_size, self.S, self.F, self.W, lo, hi

    def point(self, cell: Any, values: Sequence[Fraction]) -> None:
        """Set the point by the values of the first symbols' variables."""
        eps = [Fraction(0)] * len(self.S)
        for k, value in enumerate(values):
            m, r = forms.middle_and_radius(cell[2 * k], cell[2 * k + 1])
            rest = value - Fraction(m)
            eps[k] = rest / Fraction(r) if r else rest
            assert abs(eps[k]) <= 1
        self.at = Point(eps)

    def encloses(self, row: int, value: Fraction) -> None:
        """Assert that a row encloses the value at the point."""
        form = self.F[row]
        assert np.all(np.isfinite(form))
        assert abs(value - polynomial(form, self.at)) <= Fraction(form[-3]) + self.room

    def enclose_all(self, first: int, values: Iterable[Fraction]) -> None:
        for k, value in enumerate(values):
            self.encloses(first + k, value)

    def brackets(self, row: int, value: Fraction) -> None:
        """Assert that the bounds of a row hold the value."""
        lo, hi = bounds(self.F, row, self.S)
        assert lo <= value + self.room and value - self.room <= hi

    def place(self, x: Vector) -> None:
        """Assert that one value of the error symbol encloses all of x; take it for the point."""
        low, high = Fraction(-1), Fraction(1)
        column = 1 + turn.ERROR_SYMBOL
        assert self.at.eps[turn.ERROR_SYMBOL] == 0
        for k in range(3):
            form = self.F[forms.POSITION + k]
            assert np.all(np.isfinite(form))
            error, slope = Fraction(form[-3]) + self.room, Fraction(form[column])
            rest = x[k] - polynomial(form, self.at)
            if slope == 0:
                assert abs(rest) <= error
                continue
            ends = sorted([(rest - error) / slope, (rest + error) / slope])
            low, high = max(low, ends[0]), min(high, ends[1])
        assert low <= high
        eps = list(self.at.eps)
        eps[turn.ERROR_SYMBOL] = (low + high) / 2
        self.at = Point(eps)


def turn_checker(robot: Planted, cell: Any, branch: int) -> tuple[Checker, bool]:
    """Write the rows of a cell in u; say whether its position is a smooth branch."""
    checker = Checker(ROTATION_ONLY)
    F, W, S, model = checker.F, checker.W, checker.S, robot.model
    order = int(cell[turn.ORDER])
    turn.prepare(F, model, cell, robot.chart, order, S)
    found = turn.on_branch(F, W, model, order, branch, S)
    if found:
        forms.wrench_rows(F, model, robot.chart, order, S)
    return checker, found


def pose_checker(robot: Planted, cell: Any) -> Checker:
    """Write the rows of a (u, x) cell."""
    checker = Checker(WHOLE_POSE)
    F, S = checker.F, checker.S
    forms.rotation_rows(F, cell, S)
    forms.triple_rows(F, robot.model, robot.chart, 0, S)
    pose.position_variables(F, cell, S)
    forms.wrench_rows(F, robot.model, robot.chart, 0, S)
    return checker


def scaled(s: Fraction, v: Iterable[Fraction]) -> Vector:
    return [s * x for x in v]


def square_sum(u: Sequence[Fraction]) -> Fraction:
    return 1 + dot(u, u)


def check_block(checker: Checker, block: int, robot: Planted, u: Vector, i: int, pivot: int) -> None:
    """Assert that s q_i, s d_i and s K_i are enclosed."""
    s = square_sum(u)
    q = apply(robot.rotation(u), minus(robot.points[i], robot.points[pivot]))
    d = minus(minus(robot.anchors[i], robot.anchors[pivot]), q)
    offset = (dot(d, d) + robot.lengths_sq[pivot] - robot.lengths_sq[i]) / 2
    checker.enclose_all(block, scaled(s, [*q, *d, offset]))


def check_wrenches(checker: Checker, robot: Planted, u: Vector, x: Vector, order: int) -> None:
    """Assert that s w_i of the taut cables and s w_0 are enclosed: forces at B_i, moments about B_1."""
    s, size = square_sum(u), Fraction(robot.model.size)
    rotation = robot.rotation(u)
    pivot, *others = (int(c) for c in robot.model.orders[order])
    root = apply(rotation, robot.points[pivot])
    p = [a + b for a, b in zip(robot.centre(u, pivot), x, strict=True)]
    checker.enclose_all(forms.ROOT_ARM, scaled(s, root))
    for j, i in enumerate([pivot, *others]):
        arm = apply(rotation, robot.points[i])
        spoke = minus(minus(robot.anchors[i], p), arm)
        moment = [m / size for m in cross(minus(arm, root), spoke)]
        checker.enclose_all(forms.WRENCH + 6 * j, scaled(s, [*spoke, *moment]))
    moment = [-m / size for m in cross(root, robot.load)]
    checker.enclose_all(forms.LOAD, scaled(s, [*robot.load, *moment]))


def gap(robot: Planted, u: Vector, x: Vector, i: int, pivot: int) -> Fraction:
    """Return s (|e_i|^2 - l_i^2) / 2 where the pivot's length is right."""
    d = minus(robot.centre(u, i), robot.centre(u, pivot))
    offset = (dot(d, d) + robot.lengths_sq[pivot] - robot.lengths_sq[i]) / 2
    return square_sum(u) * (offset - dot(d, x))


@pytest.mark.parametrize("S", [ROTATION_ONLY, WHOLE_POSE], ids=["4", "6"])
def test_rotation_rows_enclose_every_rotation_of_the_cell(S: Symbols) -> None:
    rng = random.Random(1)
    for k in range(120):
        reach = CELLS[k % len(CELLS)]
        cell = np.zeros(turn.WIDTH)
        for c in range(3):
            # Beyond the chart as well: uniqueness boxes reach out of it.
            middle = Fraction(rng.uniform(-3.0, 3.0))
            cell[2 * c : 2 * c + 2] = around(rng, middle, rng.choice([reach, reach, 0.0]))
        if k < 5:
            cell[:6] = [-1.0, 1.0] * 3
        checker = Checker(S)
        forms.rotation_rows(checker.F, cell, S)
        for _ in range(3):
            u = point_of(rng, cell, 3)
            checker.point(cell, u)
            s = square_sum(u)
            checker.encloses(forms.SCALE, s)
            checker.brackets(forms.SCALE, s)
            # The rows hold R(u) without the chart's half turn.
            checker.enclose_all(forms.ROTATION, [s * x for row in cayley(u) for x in row])
        # Degree two is exact: only rounding remains.
        assert np.all(checker.F[: forms.SCALE + 1, -3] < 1e-13)


@every_count
def test_rows_of_pose_cells_enclose_the_geometry(n: int) -> None:
    rng = random.Random(2)
    for robot in planted(n):
        pivot = int(robot.model.orders[0, 0])
        for reach in CELLS:
            cell = pose_cell(rng, robot, reach)
            checker = pose_checker(robot, cell)
            F, S = checker.F, checker.S
            count = pose.length_equations(F, robot.model, S)
            assert count == n
            unknowns = [*robot.u, *way(robot, 0)]
            for _ in range(2):
                u, x = unknowns[:3], unknowns[3:]
                checker.point(cell, unknowns)
                checker.enclose_all(forms.POSITION, x)
                for j, i in enumerate(robot.model.orders[0, 1:], start=1):
                    check_block(checker, forms.CABLE + forms.BLOCK * j, robot, u, i, pivot)
                    checker.encloses(forms.EQUATION + j, gap(robot, u, x, i, pivot))
                    checker.brackets(forms.EQUATION + j, gap(robot, u, x, i, pivot))
                checker.encloses(forms.EQUATION, dot(x, x) - robot.lengths_sq[pivot])
                check_wrenches(checker, robot, u, x, 0)
                for i in (n, n + 1):
                    forms.cable_rows(F, forms.SLACK_CABLE, robot.model, robot.chart, i, pivot, S)
                    check_block(checker, forms.SLACK_CABLE, robot, u, i, pivot)
                unknowns = point_of(rng, cell, 6)


@every_count
def test_smooth_branches_enclose_the_position(n: int) -> None:
    """Both branches, at the equilibrium and all over the cell."""
    rng = random.Random(3)
    smooth = points = 0
    for k, robot in enumerate(planted(n)):
        order = k % len(robot.model.orders)
        pivot = int(robot.model.orders[order, 0])
        for reach in CELLS:
            cell = turn_cell(rng, robot, reach, order)
            for branch in (1, -1):
                checker, found = turn_checker(robot, cell, branch)
                if not found:
                    continue
                smooth += 1
                checker.room = ROUNDED
                for u in [robot.u, *(point_of(rng, cell, 3) for _ in range(4))]:
                    x = robot.position(u, order, branch)
                    if x is None:
                        continue
                    if u is robot.u and branch == branch_of(robot, order):
                        exact = way(robot, order)
                        assert max(abs(a - b) for a, b in zip(x, exact, strict=True)) < ROUNDED
                    checker.point(cell, u)
                    checker.place(x)
                    points += 1
                    if points % 5 not in (1, 2):
                        continue
                    for j, i in enumerate(robot.model.orders[order, 1:], start=1):
                        check_block(checker, forms.CABLE + forms.BLOCK * j, robot, u, i, pivot)
                    check_wrenches(checker, robot, u, x, order)
                    normal = robot.frame(u, order)[2]
                    checker.enclose_all(forms.NORMAL, scaled(square_sum(u) ** 2, normal))
    assert smooth >= 4 * len(planted(n))
    assert points >= 4 * smooth


@every_count
def test_the_error_of_a_smooth_branch_is_small(n: int) -> None:
    """Third order in the width of u, so that the enclosure is worth its name."""
    compared = 0
    for robot in planted(n)[:3]:
        errors = []
        for reach in (0.02, 0.01):
            cell = np.zeros(turn.WIDTH)
            for k, x in enumerate(robot.u):
                thin = robot.model.planar and k != 1
                cell[2 * k : 2 * k + 2] = [float(x) - reach * (not thin), float(x) + reach * (not thin)]
            checker, found = turn_checker(robot, cell, branch_of(robot, 0))
            form = checker.F[forms.POSITION]
            errors.append(form[-3] + abs(form[1 + turn.ERROR_SYMBOL]) if found else np.inf)
        if errors[0] < np.inf:
            compared += 1
            assert errors[1] < 0.25 * errors[0] + 1e-12
    assert compared >= 2


def exact_unknowns(robot: Planted) -> Vector:
    """Return (u, p, t); the tensions of six cables stand as 0."""
    return [*robot.u, *robot.p, *(robot.t if robot.n < 6 else [Fraction(0)] * 6)]


def between(lo: Any, hi: Any, values: Sequence[Fraction]) -> bool:
    return all(a <= x <= b for a, b, x in zip(lo, hi, values, strict=True))


@every_count
def test_pose_and_tensions_of_the_equilibrium_are_enclosed(n: int) -> None:
    rng = random.Random(5)
    bounded = 0
    for robot in planted(n):
        lo, hi = np.zeros((2, 6 + n))
        exact = exact_unknowns(robot)
        for reach in CELLS:
            for order in range(len(robot.model.orders)):
                cell = turn_cell(rng, robot, reach, order, branch_of(robot, order))
                near = Checker(ROTATION_ONLY)
                if turn.enclose_cell(near.F, near.W, robot.model, cell, near.S, lo, hi):
                    bounded += 1
                    assert between(lo, hi, exact)
                if turn.enclose_cell(near.F, near.W, robot.model, cell, near.S, lo[:6], hi[:6]):
                    assert between(lo[:6], hi[:6], exact[:6])
            cell = pose_cell(rng, robot, reach)
            whole = Checker(WHOLE_POSE)
            if pose.enclose_cell(whole.F, whole.W, robot.model, cell, whole.S, lo, hi):
                bounded += 1
                assert between(lo, hi, exact)
            assert pose.enclose_cell(whole.F, whole.W, robot.model, cell, whole.S, lo[:6], hi[:6])
            assert between(lo[:6], hi[:6], exact[:6])
    assert bounded >= 4 * len(planted(n))


@every_count
def test_position_bounds_hold_every_position_of_the_cell(n: int) -> None:
    rng = random.Random(6)
    for robot in planted(n):
        lo, hi = np.zeros((2, 6))
        pivot = int(robot.model.orders[0, 0])
        for reach in CELLS:
            cell = pose_cell(rng, robot, reach)
            checker = Checker(WHOLE_POSE)
            assert pose.enclose_cell(checker.F, checker.W, robot.model, cell, checker.S, lo, hi)
            for _ in range(4):
                u, x = point_of(rng, cell, 3), point_of(rng, cell[6:], 3)
                p = [a + b for a, b in zip(robot.centre(u, pivot), x, strict=True)]
                if robot.model.planar:
                    # Only the plane matters, and u and x lie in it up to rounding.
                    u[0] = u[2] = x[1] = p[1] = Fraction(0)
                    p = [a + b for a, b in zip(robot.centre(u, pivot), x, strict=True)]
                assert between(lo, hi, [*u, *p])
            if reach < 1e-6 and robot is planted(n)[0]:
                assert np.all(hi - lo < 1e-5)


@pytest.mark.parametrize("name", UNCERTAIN)
@pytest.mark.parametrize("n", [3, 5])
def test_the_error_of_every_datum_is_counted(n: int, name: str) -> None:
    """In tiny cells nothing else makes room for a datum at the border of its enclosure."""
    rng = random.Random(7)
    enclosed = 0
    for robot in (shifted(robot, name, 1e-5) for robot in planted(n)[:3]):
        pivot = int(robot.model.orders[0, 0])
        lo, hi = np.zeros((2, 6 + n))
        branch = branch_of(robot, 0)
        cell = turn_cell(rng, robot, 1e-9, 0, branch)
        near, found = turn_checker(robot, cell, branch)
        near.point(cell, robot.u)
        assert not turn.no_position(near.F, robot.model, 0, near.S)
        if found:
            enclosed += 1
            near.place(way(robot, 0))
            check_wrenches(near, robot, robot.u, way(robot, 0), 0)
            assert turn.enclose_cell(near.F, near.W, robot.model, cell, near.S, lo, hi)
            assert between(lo, hi, exact_unknowns(robot))
        cell = pose_cell(rng, robot, 1e-9)
        whole = pose_checker(robot, cell)
        whole.point(cell, [*robot.u, *way(robot, 0)])
        for j, i in enumerate(robot.model.orders[0, 1:], start=1):
            check_block(whole, forms.CABLE + forms.BLOCK * j, robot, robot.u, i, pivot)
        check_wrenches(whole, robot, robot.u, way(robot, 0), 0)
        whole.enclose_all(
            forms.EQUATION, [Fraction(0)] * pose.length_equations(whole.F, robot.model, whole.S)
        )
        if pose.enclose_cell(whole.F, whole.W, robot.model, cell, whole.S, lo, hi):
            enclosed += 1
            assert between(lo, hi, exact_unknowns(robot))
    assert enclosed >= 5


def test_tension_bounds_of_six_cables() -> None:
    """The search does not use them for six cables, but they hold as well."""
    rng = random.Random(8)
    lo, hi = np.zeros((2, 6))
    bounded = 0
    for robot in planted(6):
        t = [robot.t[i] for i in robot.model.orders[0]]
        for reach in (1e-3, 1e-5, 1e-8, 0.0):
            checker, found = turn_checker(robot, turn_cell(rng, robot, reach), branch_of(robot, 0))
            for rows in [checker] * found + [pose_checker(robot, pose_cell(rng, robot, reach))]:
                if statics.tension_bounds(rows.F, rows.W, 6, rows.S, lo, hi):
                    bounded += 1
                    assert between(lo, hi, t)
    assert bounded >= 30


@every_count
def test_tension_bounds_are_tight_at_a_point(n: int) -> None:
    rng = random.Random(9)
    for robot in [planted(n)[0], planted(n)[1]]:
        lo, hi = np.zeros((2, n))
        t = [robot.t[i] for i in robot.model.orders[0]]
        checker, found = turn_checker(robot, turn_cell(rng, robot, 0.0), branch_of(robot, 0))
        assert found
        for rows in (checker, pose_checker(robot, pose_cell(rng, robot, 0.0))):
            assert statics.tension_bounds(rows.F, rows.W, n, rows.S, lo, hi)
            assert between(lo, hi, t)
            assert np.all(hi - lo < 1e-7)


def at_equilibrium(rng: random.Random, robot: Planted, reach: float) -> list[tuple[Checker, int, int]]:
    """Return the rows of cells with the equilibrium as their point, the order, the number of pivots.

    The solved lengths stand in PIVOT.., as in both searches.
    """
    n, model = robot.n, robot.model
    found: list[tuple[Checker, int, int]] = []
    for order in range(len(model.orders)):
        branch = branch_of(robot, order)
        cell = turn_cell(rng, robot, reach, order, branch)
        checker, smooth = turn_checker(robot, cell, branch)
        if smooth:
            checker.point(cell, robot.u)
            checker.place(way(robot, order))
            lengths = 0
            for j in range(2 if model.planar else 3, n):
                block = forms.CABLE + forms.BLOCK * j
                forms.length_row(checker.F, forms.EQUATION + lengths, block, checker.S)
                lengths += 1
            solve = elimination.solve_for_pivots
            rank = solve(checker.F, checker.W, 0, lengths, forms.U_SYMBOLS, checker.S)
            found.append((checker, order, rank))
    cell = pose_cell(rng, robot, reach)
    checker = pose_checker(robot, cell)
    checker.point(cell, [*robot.u, *way(robot, 0)])
    count = pose.length_equations(checker.F, model, checker.S)
    rank = elimination.solve_for_pivots(checker.F, checker.W, 0, count, pose.VARIABLES, checker.S)
    return [*found, (checker, 0, rank)]


@every_count
def test_solved_rows_vanish_and_reduced_rows_keep_their_values(n: int) -> None:
    rng = random.Random(10)
    solved = 0
    for robot in planted(n):
        for reach in CELLS[1:5]:
            for checker, order, rank in at_equilibrium(rng, robot, reach):
                F, W, S = checker.F, checker.W, checker.S
                pivots = [int(W[elimination.PIVOTS, k]) for k in range(rank)]
                assert len(set(pivots)) == rank
                solved += rank
                checker.enclose_all(forms.PIVOT, [Fraction(0)] * rank)
                for k in range(rank):
                    checker.brackets(forms.PIVOT + k, Fraction(0))
                    slopes = F[forms.PIVOT + k, 1:][pivots]
                    assert np.allclose(slopes, np.eye(rank)[k], atol=1e-9)
                x, s = way(robot, order), square_sum(robot.u)
                for k in range(3):
                    scale(F, forms.SCRATCH, forms.WRENCH + k, 1.0, S)
                    elimination.reduce_row(F, forms.SCRATCH, W, rank, S)
                    # The pivot's wrench is -s x.
                    checker.encloses(forms.SCRATCH, -s * x[k])
                    checker.brackets(forms.SCRATCH, -s * x[k])
                    size = abs(F[forms.WRENCH + k, 1:-3]).sum()
                    assert np.all(abs(F[forms.SCRATCH, 1:][pivots]) <= 1e-9 * size)
    assert solved >= (2 if n == 2 else n) * 10


def test_pivots_are_not_taken_from_rows_drowned_in_noise() -> None:
    rng = random.Random(11)
    checker, _, rank = at_equilibrium(rng, planted(4)[0], 1e-3)[-1]
    assert rank == 4
    checker.F[forms.EQUATION : forms.EQUATION + 4, -3] = 1e3
    solve = elimination.solve_for_pivots
    assert solve(checker.F, checker.W, 0, 4, pose.VARIABLES, checker.S) == 0


@every_count
def test_statics_keeps_cells_with_an_equilibrium(n: int) -> None:
    rng = random.Random(12)
    limited = written = 0
    for robot in planted(n):
        for reach in CELLS:
            for checker, order, rank in at_equilibrium(rng, robot, reach):
                F, W, S = checker.F, checker.W, checker.S
                t = [robot.t[i] for i in robot.model.orders[order]]
                for used in (rank, 0):
                    assert statics.centre_columns(F, W, n)
                    assert not statics.balance_free(F, W, n, used, S)
                    assert statics.centre_columns(F, W, n)
                    if not statics.limit_tensions(F, W, n, used, S):
                        continue
                    limited += 1
                    assert all(x <= most for x, most in zip(t, W[statics.MOST_TENSION], strict=False))
                    for chosen in range(3 if n < 6 else 0):
                        if chosen:
                            # As far from the middle as the tensions may be.
                            W[statics.MOST_TENSION, :n] = [enclose(x)[1] for x in t]
                            W[statics.SOME_TENSION, :n] = (
                                0.0 if chosen == 1 else 2.0 * np.array(t, dtype=float)
                            )
                        count = statics.statics_equations(F, W, n, n, used, S)
                        assert count == 6 - n
                        written += count
                        rows = range(forms.EQUATION + n, forms.EQUATION + n + count)
                        checker.enclose_all(rows[0], [Fraction(0)] * count)
                        for row in rows:
                            checker.brackets(row, Fraction(0))
    assert limited >= 5 * len(planted(n))
    assert written >= (6 - n) * 12 * len(planted(n))


@every_count
def test_statics_excludes_cells_far_from_balance(n: int) -> None:
    """The test above would pass for a kernel that never excludes anything."""
    rng = random.Random(13)
    excluded = 0
    for robot in planted(n):
        for _ in range(10):
            cell = pose_cell(rng, robot, 1e-3)
            cell[6:12] += np.repeat([rng.uniform(-2.0, 2.0) for _ in range(3)], 2)
            if robot.model.planar:
                cell[8:10] = 0.0
            checker = pose_checker(robot, cell)
            F, W, S = checker.F, checker.W, checker.S
            excluded += statics.centre_columns(F, W, n) and statics.balance_free(F, W, n, 0, S)
    assert excluded >= 30


@every_count
def test_statics_excludes_an_equilibrium_of_pushing_cables(n: int) -> None:
    rng = random.Random(14)
    excluded = tried = 0
    for robot in planted(n)[:2]:
        turned = replace(robot, model=robot.model._replace(load=-robot.model.load))
        for reach in (1e-4, 1e-7):
            for checker, _, rank in at_equilibrium(rng, turned, reach):
                F, W, S = checker.F, checker.W, checker.S
                tried += 1
                excluded += statics.centre_columns(F, W, n) and statics.balance_free(F, W, n, rank, S)
    assert excluded >= 0.5 * tried


@every_count
def test_no_position_is_claimed_only_where_the_spheres_do_not_meet(n: int) -> None:
    rng = random.Random(15)
    claimed = 0
    for robot in planted(n):
        for order in range(len(robot.model.orders)):
            for reach in CELLS:
                cell = turn_cell(rng, robot, reach, order)
                checker, _ = turn_checker(robot, cell, branch_of(robot, order))
                assert not turn.no_position(checker.F, robot.model, order, checker.S)
            for reach in (0.3, 0.05, 1e-3):
                cell = turn_cell(rng, robot, reach, order)
                for k in range(3):
                    if not robot.model.planar or k == 1:
                        cell[2 * k : 2 * k + 2] += rng.uniform(-2.0, 2.0)
                # Half the pivot's length: the spheres meet less often.
                pivot = int(robot.model.orders[order, 0])
                lengths_sq, exact = robot.model.lengths_sq.copy(), list(robot.lengths_sq)
                lengths_sq[pivot] *= 0.25
                exact[pivot] /= 4
                short = replace(robot, model=robot.model._replace(lengths_sq=lengths_sq), lengths_sq=exact)
                checker, _ = turn_checker(short, cell, 1)
                if turn.no_position(checker.F, short.model, order, checker.S):
                    claimed += 1
                    for _ in range(5):
                        assert short.position(point_of(rng, cell, 3), order, 1) is None
    assert claimed >= 5


@every_count
def test_spheres_that_just_touch_have_a_position(n: int) -> None:
    """The lengths are such that the two branches meet at the planted u; the pivot's is at its border."""
    rng = random.Random(22)
    apart = 0
    for robot in planted(n)[:6]:
        order = rng.randrange(len(robot.model.orders))
        pivot = int(robot.model.orders[order, 0])
        m = robot.frame(robot.u, order)[2]
        height = dot(m, way(robot, order))
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
            for reach in (1e-5, 1e-9, 0.0):
                cell = turn_cell(rng, robot, reach, order)
                checker, found = turn_checker(replace(robot, model=model), cell, 1)
                if found and not shift:
                    checker.point(cell, robot.u)
                    checker.place(
                        [a - height / dot(m, m) * b for a, b in zip(way(robot, order), m, strict=True)]
                    )
                claimed = turn.no_position(checker.F, model, order, checker.S)
                assert shift or not claimed
                apart += claimed
    assert apart >= 5


@every_count
def test_slack_is_excluded_only_by_a_cable_that_is_too_long(n: int) -> None:
    rng = random.Random(16)
    excluded = 0
    for robot in planted(n):
        pivot = int(robot.model.orders[0, 0])
        short = robot.model.lengths_sq.copy()
        cable = rng.choice([n, n + 1])
        short[cable] = float(robot.lengths_sq[cable]) * rng.choice([0.3, 0.9])
        cut = robot.model._replace(lengths_sq=short)
        for reach in CELLS:
            cell = pose_cell(rng, robot, reach)
            checker = pose_checker(robot, cell)
            F, S = checker.F, checker.S
            assert not turn.slack_excluded(F, robot.model, robot.chart, 0, S)
            cell_u = turn_cell(rng, robot, reach)
            near, found = turn_checker(robot, cell_u, branch_of(robot, 0))
            assert not found or not turn.slack_excluded(near.F, robot.model, robot.chart, 0, near.S)
            if turn.slack_excluded(F, cut, robot.chart, 0, S):
                excluded += 1
                limit = Fraction(short[cable]) - Fraction(robot.model.lengths_sq_err[cable])
                for _ in range(5):
                    u, x = point_of(rng, cell, 3), point_of(rng, cell[6:], 3)
                    e = minus(minus(robot.centre(u, cable), robot.centre(u, pivot)), x)
                    # Up to what the pivot's sphere is missed by.
                    assert dot(e, e) - (dot(x, x) - robot.lengths_sq[pivot]) > limit
    assert excluded >= 10


def holds(cell: Any, values: Sequence[Fraction]) -> bool:
    return all(cell[2 * k] <= x <= cell[2 * k + 1] for k, x in enumerate(values))


def descend(rng: random.Random, process: Any, context: Any, cell: Any, robot: Planted, branch: int) -> int:
    """Follow the planted equilibrium down to a leaf; return the leaf's kind, 0 where its cell was dropped.

    A child that holds it must keep it, also one of several that share it at a face.
    """
    searches_u = len(cell) == turn.WIDTH
    values = robot.u if searches_u else [*robot.u, *way(robot, 0)]
    children = np.empty((4, len(cell)))
    for _ in range(600):
        parent = cell.copy()
        verdict = process(context, cell, children)
        if verdict == 0:
            return 0
        family = children[: abs(verdict) if verdict > 0 else 1].copy()
        for child in family:
            # No child reaches out of its parent.
            assert np.all(parent[0 : len(values) * 2 : 2] <= child[0 : len(values) * 2 : 2])
            assert np.all(child[1 : len(values) * 2 : 2] <= parent[1 : len(values) * 2 : 2])
        if verdict < 0:
            assert holds(family[0], values)
            return -verdict
        assert np.isclose(family[:, -1].sum(), parent[-1])
        keep = [child for child in family if holds(child, values)]
        if searches_u:
            keep = [child for child in keep if child[turn.BRANCH] in (0.0, branch)]
        assert keep
        cell = rng.choice(keep)
    raise AssertionError("no leaf after 600 steps")


def no_roots(robot: Planted) -> Any:
    return np.empty((0, 1 + 2 * (6 + robot.n)))


def whole_space(robot: Planted) -> Any:
    """Return a (u, x) cell that holds everything within the pivot's length."""
    reach = robot.model.lengths[robot.model.orders[0, 0], 1]
    cell = np.zeros(pose.P_WIDTH)
    for k in range(3):
        flat = robot.model.planar and k != 1
        cell[2 * k : 2 * k + 2] = [0.0, 0.0] if flat else [-1.0, 1.0]
        cell[6 + 2 * k : 8 + 2 * k] = [0.0, 0.0] if robot.model.planar and k == 1 else [-reach, reach]
    cell[pose.P_CHART], cell[pose.P_SHARE] = robot.chart, 1.0
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


@every_count
def test_the_search_in_u_keeps_the_equilibrium_from_the_whole_chart(n: int) -> None:
    rng = random.Random(17)
    kinds = []
    for start in planted(n):
        for robot in variants(rng, start):
            for order in range(len(robot.model.orders)):
                cell = np.array([*whole_space(robot)[:6], robot.chart, 0.0, order, 1.0])
                context = Checker(ROTATION_ONLY).context(robot, no_roots(robot), 1e-9)
                kinds.append(descend(rng, turn.process, context, cell, robot, branch_of(robot, order)))
    assert set(kinds) <= {turn.SMALL, turn.FOLDED}
    assert kinds.count(turn.SMALL) >= 0.2 * len(kinds)


@every_count
def test_the_search_in_u_keeps_the_equilibrium_of_any_cell(n: int) -> None:
    rng = random.Random(18)
    kinds = []
    for start in planted(n):
        for robot in variants(rng, start):
            for reach in CELLS:
                order = rng.randrange(len(robot.model.orders))
                branch = branch_of(robot, order)
                cell = turn_cell(rng, robot, reach, order, rng.choice([0, branch]))
                context = Checker(ROTATION_ONLY).context(robot, no_roots(robot), 1e-9)
                kinds.append(descend(rng, turn.process, context, cell, robot, branch))
    assert set(kinds) <= {turn.SMALL, turn.FOLDED}
    assert kinds.count(turn.SMALL) >= 0.2 * len(kinds)


@every_count
def test_the_search_in_u_and_x_keeps_the_equilibrium(n: int) -> None:
    rng = random.Random(19)
    for start in planted(n):
        for robot in variants(rng, start):
            cells = [whole_space(robot), *(pose_cell(rng, robot, reach) for reach in rng.sample(CELLS, 2))]
            for cell in cells:
                context = Checker(WHOLE_POSE).context(robot, no_roots(robot), 1e-9)
                assert descend(rng, pose.process, context, cell, robot, 0) == turn.SMALL


@every_count
def test_the_searches_drop_most_cells(n: int) -> None:
    """The tests above would pass for a search that keeps everything."""
    rng = random.Random(20)
    dropped = 0
    for robot in planted(n)[:3]:
        near = Checker(ROTATION_ONLY).context(robot, no_roots(robot), 1e-9)
        whole = Checker(WHOLE_POSE).context(robot, no_roots(robot), 1e-9)
        for _ in range(20):
            cell = turn_cell(rng, robot, 1e-3, 0, rng.choice([-1, 1]))
            far = pose_cell(rng, robot, 1e-3)
            for k in range(3):
                if not robot.model.planar or k == 1:
                    cell[2 * k : 2 * k + 2] += rng.choice([-1, 1]) * rng.uniform(0.1, 0.5)
                if not robot.model.planar or k != 1:
                    far[6 + 2 * k : 8 + 2 * k] += rng.choice([-1, 1]) * rng.uniform(0.1, 0.5)
            dropped += turn.process(near, cell, np.empty((4, len(cell)))) == 0
            dropped += pose.process(whole, far, np.empty((4, len(far)))) == 0
    assert dropped >= 80


def box_row(robot: Planted, lo: Any, hi: Any) -> Any:
    return np.concatenate([[robot.chart], lo, hi])[None, :]


def run_search(rng: random.Random, robot: Planted, search: str, roots: Any) -> int:
    """Return what becomes of a small cell with the planted equilibrium, given settled boxes."""
    if search == "u":
        branch = branch_of(robot, 0)
        cell = turn_cell(rng, robot, 1e-3, 0, branch)
        context = Checker(ROTATION_ONLY).context(robot, roots, 1e-8)
        return descend(rng, turn.process, context, cell, robot, branch)
    cell = pose_cell(rng, robot, 1e-3)
    context = Checker(WHOLE_POSE).context(robot, roots, 1e-8)
    return descend(rng, pose.process, context, cell, robot, 0)


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
                assert run_search(rng, robot, search, box_row(robot, a, b)) != 0


@pytest.mark.parametrize("n", (3, 4, 6))
def test_no_cell_is_its_own_child(n: int) -> None:
    """Cells of a few doubles: a search would look at such a child for ever."""
    rng = random.Random(31 + n)
    F, W = np.zeros((forms.FORM_ROWS, width(WHOLE_POSE))), np.zeros(forms.WORK_SHAPE)
    for robot in planted(n):
        lo, hi = np.zeros((2, 6 + n))
        context = (robot.model, no_roots(robot), 1e-9, WHOLE_POSE, F, W, lo, hi)
        for _ in range(40):
            cell = pose_cell(rng, robot, 0.0)
            for k in range(6):
                cell[2 * k + 1] += rng.choice([0, 1, 5, 300, 5000]) * np.spacing(abs(cell[2 * k]))
            for _ in range(60):
                children = np.zeros((4, pose.P_WIDTH))
                before = cell.copy()
                if pose.process(context, cell, children) != 1:
                    break
                assert not np.array_equal(children[0], before)
                cell = children[0].copy()


@pytest.mark.parametrize(("low", "high"), [(0.0, 5e-324), (1.0, 1.0), (0.0, 0.0)])
def test_a_cut_without_progress_is_not_worth_another_look(low: float, high: float) -> None:
    cell = np.array([low, high])
    assert not elimination.cut(cell, 0, -0.1, 0.1)
    assert (cell == [low, high]).all()


def test_a_width_is_worth_another_look_at_the_same_share_everywhere() -> None:
    assert elimination.shrunk(0.6, 1.0) and elimination.shrunk(1716.0, 2860.0)
    assert not elimination.shrunk(0.7, 1.0) and not elimination.shrunk(0.0, 0.0)
