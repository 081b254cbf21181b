"""A platform's forms enclose the exact geometry, and no test ever drops a planted equilibrium."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest

from cdpr_interval.kernels import affine
from cdpr_interval.kernels.enclosure import enclose
from solvers import platform_contract
from solvers import platform_forms as forms
from solvers import platform_position as position
from solvers import platform_sigma as sigma
from tests.planted_platform import (
    UNCERTAIN,
    Planted,
    Vector,
    apply,
    cross,
    dot,
    minus,
    plant,
    shifted,
    solve3,
)

TAUT = (3, 4, 5, 6)
WIDTHS = (Fraction(0), Fraction(1, 10**7), Fraction(1, 300))
"""Half widths of the data's ranges."""
CELLS = (0.8, 0.3, 0.05, 1e-3, 1e-7)
"""Widths of the cells in u; affine forms of wider ones off the chart's middle may not bound 1 + |u|^2."""

every_count = pytest.mark.parametrize("n", TAUT)


@cache
def planted(n: int) -> list[Planted]:
    """Return a few robots with n taut cables, with exact and with uncertain data."""
    rng = random.Random(100 + n)
    return [
        plant(rng, n, slack=2, width=width, zero_tension=k == 2) for width in WIDTHS for k in range(3)
    ]  # fmt: skip


def around(rng: random.Random, x: Fraction, width: float) -> tuple[float, float]:
    """Return bounds that hold x, often just so at one end."""
    lo, hi = enclose(x)
    side = rng.choice([0.0, 1.0, rng.random()])
    return lo - side * width, hi + (1.0 - side) * width


def u_box(rng: random.Random, u: Sequence[Fraction], width: float) -> list[float]:
    """Return bounds of u; some entries are fixed where u is a double."""
    box: list[float] = []
    for x in u:
        thin = Fraction(float(x)) == x and rng.random() < 0.3
        box += around(rng, x, 0.0 if thin else width)
    return box


def sigma_cell(rng: random.Random, robot: Planted, width: float, order: int = 0) -> Any:
    """Return a (u, sigma) cell that holds the planted equilibrium."""
    exact = robot.sigma(order)
    scale = math.sqrt(max(1e-6, float(dot(*[robot.frame(robot.u, order)[2]] * 2))))
    cell = np.zeros(sigma.WIDTH)
    cell[:6] = u_box(rng, robot.u, width)
    cell[6:8] = around(rng, exact, width * scale * rng.choice([1.0, 10.0, 0.1]))
    cell[sigma.CHART], cell[sigma.ORDER], cell[sigma.SHARE] = robot.chart, order, 1.0
    return cell


def position_cell(rng: random.Random, robot: Planted, width: float) -> Any:
    """Return a (u, p) cell that holds the planted equilibrium."""
    cell = np.zeros(position.P_WIDTH)
    cell[:6] = u_box(rng, robot.u, width)
    cell[6:12] = [b for x in robot.p for b in around(rng, x, width)]
    cell[position.P_CHART], cell[position.P_SHARE] = robot.chart, 1.0
    return cell


def inside(rng: random.Random, lo: float, hi: float) -> Fraction:
    """Return an exact number in [lo, hi], often an end."""
    return Fraction(lo) + (Fraction(hi) - Fraction(lo)) * rng.choice(
        [0, 1, Fraction(rng.randint(0, 999), 999)]
    )


def symbol_value(row: Any, symbol: int, value: Fraction) -> Fraction:
    """Return the value of the noise symbol at which a variable's form takes ``value``."""
    rest = value - Fraction(row[0])
    eps = rest / Fraction(row[symbol]) if row[symbol] else rest
    assert abs(eps) <= 1
    return eps


class Checker:
    """Form arrays of a cell, and a point of it in exact numbers."""

    def __init__(self, symbols: int) -> None:
        self.F = np.zeros((forms.FORM_ROWS, symbols + 2))
        self.W = np.zeros(forms.WORK_SHAPE)
        self.eps: list[Fraction] = [Fraction(0)] * symbols

    def at(self, rows: Sequence[int], values: Sequence[Fraction]) -> None:
        """Set the point by the values of the variables written at ``rows``, symbol by symbol."""
        for k, (row, value) in enumerate(zip(rows, values, strict=True)):
            self.eps[k] = symbol_value(self.F[row], k + 1, value)

    def encloses(self, row: int, value: Fraction) -> None:
        """Assert that a form encloses the value at the point."""
        form = self.F[row]
        assert np.all(np.isfinite(form))
        linear = sum((Fraction(a) * e for a, e in zip(form[1:-1], self.eps, strict=True)), Fraction(form[0]))
        assert abs(value - linear) <= Fraction(form[-1])

    def enclose_all(self, first: int, values: Sequence[Fraction]) -> None:
        for k, value in enumerate(values):
            self.encloses(first + k, value)


def sigma_checker(robot: Planted, cell: Any) -> Checker:
    """Write rotation, triple and sigma of a cell."""
    checker = Checker(4)
    assert forms.rotation_forms(checker.F, cell)
    sigma.triple_forms(checker.F, robot.model, robot.chart, int(cell[sigma.ORDER]))
    affine.variable(checker.F, sigma.OFFSET + 2, 4, cell[6], cell[7])
    return checker


def point_of(rng: random.Random, cell: Any, variables: int) -> Vector:
    return [inside(rng, cell[2 * k], cell[2 * k + 1]) for k in range(variables)]


def test_rotation_forms_enclose_every_rotation_of_the_cell() -> None:
    rng = random.Random(1)
    robot = planted(3)[0]
    for k in range(150):
        cell = np.zeros(sigma.WIDTH)
        width = CELLS[k % len(CELLS)]
        # Beyond the chart as well: uniqueness boxes reach out of it.
        middle = [Fraction(rng.uniform(-2.0, 2.0)) for _ in range(3)]
        cell[:6] = [-1.0, 1.0] * 3 if k < 5 else u_box(rng, middle, width)
        checker = Checker(4)
        assert forms.rotation_forms(checker.F, cell)
        for _ in range(3):
            u = point_of(rng, cell, 3)
            checker.at([forms.U, forms.U + 1, forms.U + 2], u)
            signs = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]][robot.chart]
            rows = robot.rotation(u)
            # The forms hold R(u) without the chart's half turn.
            checker.enclose_all(
                forms.ROTATION, [x * s for row in rows for x, s in zip(row, signs, strict=True)]
            )


@every_count
def test_triple_forms_and_squared_distances(n: int) -> None:
    rng = random.Random(2)
    for k, robot in enumerate(planted(n)):
        for width in CELLS:
            order = k % len(robot.model.orders)
            cell = sigma_cell(rng, robot, width, order)
            checker = sigma_checker(robot, cell)
            _, j, h = (int(c) for c in robot.model.orders[order, :3])
            for _ in range(2):
                u = point_of(rng, cell, 3)
                checker.at([forms.U, forms.U + 1, forms.U + 2], u)
                d, e, m = robot.frame(u, order)
                checker.enclose_all(forms.GRAM, [dot(d, d), dot(e, e), dot(d, e)])
                checker.enclose_all(forms.OFFSET, robot.offsets(u, order))
                checker.enclose_all(forms.FRAME, [*d, *e, *m])
                forms.squared_distance(checker.F, forms.SCRATCH, robot.model, robot.chart, h, j)
                gap = minus(robot.centre(u, h), robot.centre(u, j))
                checker.encloses(forms.SCRATCH, dot(gap, gap))


@every_count
def test_sphere_bounds_hold_sigma_squared(n: int) -> None:
    rng = random.Random(3)
    for robot in planted(n):
        for width in CELLS:
            cell = sigma_cell(rng, robot, width)
            checker = sigma_checker(robot, cell)
            lo, hi, mlo, mhi = sigma.sphere_bounds(checker.F, robot.model, 0)
            assert lo <= robot.sigma(0) ** 2 <= hi
            pivot = int(robot.model.orders[0, 0])
            for _ in range(2):
                u = point_of(rng, cell, 3)
                d, e, m = robot.frame(u, 0)
                k2, k3 = robot.offsets(u, 0)
                rest = [k2 * b - k3 * a for a, b in zip(d, e, strict=True)]
                assert lo <= robot.lengths_sq[pivot] * dot(m, m) - dot(rest, rest) <= hi
                assert mlo <= dot(m, m) <= mhi


def exact_position(robot: Planted, u: Vector, s: Fraction, order: int) -> Vector | None:
    """Solve the linear system of the position."""
    d, e, m = robot.frame(u, order)
    return solve3([d, e, m], [*robot.offsets(u, order), s]) if dot(m, m) else None


@every_count
def test_position_and_cable_forms_enclose_the_solution_of_the_linear_system(n: int) -> None:
    rng = random.Random(4)
    solved = 0
    for k, robot in enumerate(planted(n)):
        for width in CELLS:
            order = k % len(robot.model.orders)
            cell = sigma_cell(rng, robot, width, order)
            checker = sigma_checker(robot, cell)
            if not sigma.position_forms(checker.F, checker.W):
                continue
            solved += 1
            pivot = int(robot.model.orders[order, 0])
            sigma.cable_forms(checker.F, robot.model, robot.chart, pivot)
            forms.moment_forms(checker.F, robot.model)
            lo, hi = np.empty(3), np.empty(3)
            sigma.position_bounds(checker.F, checker.W, robot.model, pivot, lo, hi)
            u, s = robot.u, robot.sigma(order)
            for _ in range(2):
                x = exact_position(robot, u, s, order)
                assert x is not None
                checker.at([forms.U, forms.U + 1, forms.U + 2, forms.OFFSET + 2], [*u, s])
                checker.enclose_all(forms.POSITION, x)
                check_cables(checker, robot, u, x, pivot)
                p = [a + b for a, b in zip(robot.centre(u, pivot), x, strict=True)]
                assert all(a <= c <= b for a, b, c in zip(lo, hi, p, strict=True))
                *u, s = point_of(rng, cell, 4)
    assert solved >= 2 * len(planted(n))


def check_cables(checker: Checker, robot: Planted, u: Vector, x: Vector, pivot: int) -> None:
    """Assert that arms, spokes and moments of the taut cables are enclosed."""
    first = robot.centre(u, pivot)
    for i in range(robot.n):
        r = apply(robot.rotation(u), robot.points[i])
        e = minus(minus(robot.centre(u, i), first), x)
        checker.enclose_all(forms.CABLE + forms.BLOCK * i, [*r, *e, *cross(r, e)])


@every_count
def test_length_gap_encloses_the_excess_of_the_other_cables(n: int) -> None:
    rng = random.Random(5)
    for robot in planted(n):
        for width in (0.05, 1e-4):
            cell = sigma_cell(rng, robot, width)
            checker = sigma_checker(robot, cell)
            if not sigma.position_forms(checker.F, checker.W):
                continue
            pivot = int(robot.model.orders[0, 0])
            for i in range(robot.n + 2):
                lo, hi = sigma.length_gap(checker.F, forms.EQUATION, robot.model, robot.chart, i, pivot)
                assert lo <= 0 <= hi or (i >= robot.n and lo <= 0)
                for _ in range(2):
                    u, s = point_of(rng, cell, 3), inside(rng, cell[6], cell[7])
                    x = exact_position(robot, u, s, 0)
                    assert x is not None
                    d = minus(robot.centre(u, i), robot.centre(u, pivot))
                    offset = (dot(d, d) + robot.lengths_sq[pivot] - robot.lengths_sq[i]) / 2
                    if i < robot.n:
                        assert lo <= offset - dot(d, x) <= hi
                    else:
                        # The data's length is at least |e_i| at the equilibrium.
                        assert lo <= offset - dot(d, x)


@every_count
def test_tensions_and_pose_of_the_equilibrium_are_enclosed(n: int) -> None:
    rng = random.Random(6)
    bounded = 0
    for k, robot in enumerate(planted(n)):
        exact = [*robot.u, *robot.p, *(robot.t if n < 6 else [Fraction(0)] * 6)]
        lo, hi = np.empty(6 + n), np.empty(6 + n)
        for width in CELLS:
            cell = sigma_cell(rng, robot, width, k % len(robot.model.orders))
            checker = Checker(4)
            if sigma.enclose_cell(checker.F, checker.W, robot.model, cell, lo, hi):
                bounded += 1
                assert all(a <= c <= b for a, b, c in zip(lo, hi, exact, strict=True))
            wide = Checker(6)
            cell = position_cell(rng, robot, width)
            if position.enclose_position_cell(wide.F, wide.W, robot.model, cell, lo, hi):
                bounded += 1
                assert all(a <= c <= b for a, b, c in zip(lo, hi, exact, strict=True))
    assert bounded >= 2 * len(planted(n))


@pytest.mark.parametrize("name", UNCERTAIN)
@pytest.mark.parametrize("n", [3, 5])
def test_the_error_of_every_datum_is_counted(n: int, name: str) -> None:
    """In tiny cells nothing else makes room for a datum at the border of its enclosure."""
    rng = random.Random(14)
    enclosed = 0
    for robot in (shifted(robot, name, 1e-5) for robot in planted(n)[:3]):
        cell = sigma_cell(rng, robot, 1e-9)
        checker = sigma_checker(robot, cell)
        F, W = checker.F, checker.W
        checker.at([forms.U, forms.U + 1, forms.U + 2, forms.OFFSET + 2], [*robot.u, robot.sigma(0)])
        d, e, m = robot.frame(robot.u, 0)
        checker.enclose_all(forms.GRAM, [dot(d, d), dot(e, e), dot(d, e)])
        checker.enclose_all(forms.OFFSET, robot.offsets(robot.u, 0))
        checker.enclose_all(forms.FRAME, [*d, *e, *m])
        lo, hi = sigma.sphere_bounds(F, robot.model, 0)[:2]
        assert lo <= robot.sigma(0) ** 2 <= hi
        exact = [*robot.u, *robot.p, *robot.t]
        low, high = np.empty(6 + n), np.empty(6 + n)
        if sigma.enclose_cell(F, W, robot.model, cell, low, high):
            enclosed += 1
            assert all(a <= c <= b for a, b, c in zip(low, high, exact, strict=True))
        pivot = int(robot.model.orders[0, 0])
        for i in range(n):
            below, above = sigma.length_gap(F, forms.EQUATION, robot.model, robot.chart, i, pivot)
            assert below <= 0 <= above
        wide = Checker(6)
        cell = position_cell(rng, robot, 1e-9)
        if position.enclose_position_cell(wide.F, wide.W, robot.model, cell, low, high):
            enclosed += 1
            assert all(a <= c <= b for a, b, c in zip(low, high, exact, strict=True))
        for i in range(n):
            below, above = position.sphere_gap(wide.F, robot.model, i, forms.CABLE + forms.BLOCK * i + 3)
            assert below <= 0 <= above
    assert enclosed >= 3


def test_tension_bounds_of_six_cables() -> None:
    """The search does not use them for six cables, but they hold as well."""
    rng = random.Random(7)
    lo, hi = np.empty(6), np.empty(6)
    bounded = 0
    for robot in planted(6):
        for width in (1e-4, 1e-8, 0.0):
            cell = sigma_cell(rng, robot, width)
            checker = sigma_checker(robot, cell)
            if not sigma.position_forms(checker.F, checker.W):
                continue
            sigma.cable_forms(checker.F, robot.model, robot.chart, int(robot.model.orders[0, 0]))
            forms.moment_forms(checker.F, robot.model)
            if forms.tension_bounds(checker.F, checker.W, robot.model, lo, hi):
                bounded += 1
                assert all(a <= t <= b for a, b, t in zip(lo, hi, robot.t, strict=True))
    assert bounded >= 5


@every_count
def test_tension_bounds_are_tight_at_a_point(n: int) -> None:
    if n == 6:
        return
    robot = planted(n)[0]
    lo, hi = np.empty(6 + n), np.empty(6 + n)
    checker = Checker(6)
    cell = position_cell(random.Random(8), robot, 0.0)
    assert position.enclose_position_cell(checker.F, checker.W, robot.model, cell, lo, hi)
    assert np.all(hi[6:] - lo[6:] < 1e-8)


@every_count
def test_statics_never_excludes_a_cell_with_an_equilibrium(n: int) -> None:
    rng = random.Random(9)
    for robot in planted(n):
        pivot = int(robot.model.orders[0, 0])
        for width in CELLS:
            cell = sigma_cell(rng, robot, width)
            checker = sigma_checker(robot, cell)
            if sigma.position_forms(checker.F, checker.W):
                sigma.cable_forms(checker.F, robot.model, robot.chart, pivot)
                assert not forms.statics_excluded(checker.F, checker.W, robot.model)
            wide = Checker(6)
            cell = position_cell(rng, robot, width)
            position.enclose_position_cell(
                wide.F, wide.W, robot.model, cell, np.empty(6 + n), np.empty(6 + n)
            )
            assert not forms.statics_excluded(wide.F, wide.W, robot.model)


@every_count
def test_statics_excludes_cells_far_from_balance(n: int) -> None:
    """The test above would pass for a kernel that never excludes anything."""
    rng = random.Random(10)
    excluded = 0
    for robot in planted(n):
        for _ in range(10):
            checker = Checker(6)
            cell = position_cell(rng, robot, 1e-3)
            cell[6:12] += np.repeat([rng.uniform(-2.0, 2.0) for _ in range(3)], 2)
            position.enclose_position_cell(
                checker.F, checker.W, robot.model, cell, np.empty(6 + n), np.empty(6 + n)
            )
            excluded += forms.statics_excluded(checker.F, checker.W, robot.model)
    assert excluded >= 30


@every_count
def test_statics_agrees_with_a_cell_that_only_misses_by_signs(n: int) -> None:
    """Balance with one pulling and one pushing cable is excluded, unlike the planted one."""
    rng = random.Random(11)
    for robot in planted(n)[:3]:
        if 0 in robot.t:
            continue
        turned = robot.model._replace(load=-robot.model.load)
        checker = Checker(6)
        cell = position_cell(rng, robot, 1e-7)
        position.enclose_position_cell(checker.F, checker.W, turned, cell, np.empty(6 + n), np.empty(6 + n))
        assert forms.statics_excluded(checker.F, checker.W, turned)


@every_count
def test_the_equations_of_a_cell_vanish_at_the_equilibrium(n: int) -> None:
    rng = random.Random(13)
    for robot in planted(n):
        lo, hi = np.empty(n), np.empty(n)
        for width in (0.05, 1e-3, 1e-7):
            checker = Checker(6)
            F, W = checker.F, checker.W
            cell = position_cell(rng, robot, width)
            size = np.empty(6 + n)
            position.enclose_position_cell(F, W, robot.model, cell, size, size.copy())
            symbols = [forms.U, forms.U + 1, forms.U + 2, *range(forms.POSITION, forms.POSITION + 3)]
            checker.at(symbols, [*robot.u, *robot.p])
            for i in range(n):
                below, above = position.sphere_gap(F, robot.model, i, forms.CABLE + forms.BLOCK * i + 3)
                assert below <= 0 <= above
                checker.encloses(forms.SCRATCH, Fraction(0))
            if n < 6 and forms.tension_bounds(F, W, robot.model, lo, hi):
                for below, above in ((0.0, 0.0), (500.0, 1.0), (0.0, 900.0)):
                    count = platform_contract.statics_equations(
                        F, W, robot.model, forms.EQUATION, lo - below, hi + above
                    )
                    assert count == 6 - n
                    checker.enclose_all(forms.EQUATION, [Fraction(0)] * count)


def holds(cell: Any, values: Sequence[Fraction]) -> bool:
    return all(cell[2 * k] <= x <= cell[2 * k + 1] for k, x in enumerate(values))


def descend(process: Any, context: Any, cell: Any, values: Sequence[Fraction]) -> int:
    """Follow a planted point down to a leaf; return the leaf's kind, 0 where its cell was dropped."""
    children = np.empty((4, len(cell)))
    for _ in range(400):
        parent = cell.copy()
        verdict = process(context, cell, children)
        if verdict == 0:
            return 0
        if verdict < 0:
            assert holds(children[0], values)
            return -verdict
        family = children[:verdict].copy()
        assert np.isclose(family[:, -1].sum(), parent[-1])
        cell = next(child for child in family if holds(child, values))
    raise AssertionError("no leaf after 400 steps")


NO_ROOTS = np.empty((0, 1 + 2 * 12))


def sigma_context(robot: Planted, roots: Any, leaf_size: float) -> tuple[Any, ...]:
    size = 6 + robot.n
    F, W = np.zeros((forms.FORM_ROWS, 6)), np.zeros(forms.WORK_SHAPE)
    return robot.model, roots, leaf_size, F, W, np.empty(size), np.empty(size)


def position_context(robot: Planted, roots: Any, leaf_size: float) -> tuple[Any, ...]:
    size = 6 + robot.n
    F, W = np.zeros((forms.FORM_ROWS, 8)), np.zeros(forms.WORK_SHAPE)
    return robot.model, roots, leaf_size, robot.model.size, F, W, np.empty(size), np.empty(size)


def whole_chart(robot: Planted, order: int = 0) -> Any:
    """Return a start cell of the (u, sigma) search."""
    cell = np.array([-1.0, 1.0] * 3 + [-1e3, 1e3, robot.chart, order, 1.0])
    return cell


@every_count
def test_the_sigma_search_keeps_the_equilibrium(n: int) -> None:
    for robot in planted(n):
        for order in range(len(robot.model.orders)):
            context = sigma_context(robot, NO_ROOTS, 1e-9)
            values = [*robot.u, robot.sigma(order)]
            kind = descend(sigma.process, context, whole_chart(robot, order), values)
            assert kind in (sigma.SMALL, sigma.FLAT)


@every_count
def test_the_position_search_keeps_the_equilibrium(n: int) -> None:
    for robot in planted(n):
        cell = np.array([-1.0, 1.0] * 3 + [-20.0, 20.0] * 3 + [robot.chart, 1.0])
        context = position_context(robot, NO_ROOTS, 1e-9)
        assert descend(position.process_position, context, cell, [*robot.u, *robot.p]) == sigma.SMALL


def box_row(robot: Planted, lo: Any, hi: Any) -> Any:
    return np.concatenate([[robot.chart], lo, hi])[None, :]


@every_count
@pytest.mark.parametrize("search", ["sigma", "position"])
def test_a_cell_is_settled_only_inside_a_box_in_all_unknowns(n: int, search: str) -> None:
    """A box around the equilibrium settles it; one that misses it in any single unknown never does."""
    rng = random.Random(12)
    for robot in [r for r in planted(n) if n == 6 or 0 not in r.t][:3]:
        exact = np.array([float(x) for x in [*robot.u, *robot.p, *(robot.t if n < 6 else [0] * 6)]])
        reach = np.array([0.3] * 3 + [1.0] * 3 + [20.0] * n)
        lo, hi = exact - reach, exact + reach
        settled = run_search(rng, robot, search, box_row(robot, lo, hi))
        assert settled == 0
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


def run_search(rng: random.Random, robot: Planted, search: str, roots: Any) -> int:
    """Return what becomes of a small cell with the planted equilibrium, given settled boxes."""
    if search == "sigma":
        cell = sigma_cell(rng, robot, 1e-3)
        context = sigma_context(robot, roots, 1e-8)
        return descend(sigma.process, context, cell, [*robot.u, robot.sigma(0)])
    cell = position_cell(rng, robot, 1e-3)
    context = position_context(robot, roots, 1e-8)
    return descend(position.process_position, context, cell, [*robot.u, *robot.p])
