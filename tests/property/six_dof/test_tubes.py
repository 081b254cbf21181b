"""Tubes: forms along the data against exact numbers; what tubes and cells say of every choice of lengths."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest

from cdpr_interval.kernels import second_order
from cdpr_interval.kernels.lanes import LANES
from cdpr_interval.kernels.second_order import width
from cdpr_interval.mechanics.six_dof import form_system, tube
from cdpr_interval.mechanics.six_dof.arrays import Model
from cdpr_interval.mechanics.six_dof.system import fill_data, improve
from solvers.six_dof.cells.columns import POSE_COLUMNS
from solvers.six_dof.cells.halves import cell_around, halved
from solvers.six_dof.cells.kinds import RANGED_POSE_CELLS, RANGED_ROTATION_CELLS
from solvers.six_dof.cells.ranged_cells import pose_offsets, turn_offsets
from solvers.six_dof.cells.roots import GENERAL, GEOMETRY, PLANAR, Reduction
from solvers.six_dof.cells.tube import GluedTube, Tube, glued
from solvers.six_dof.cells.tube_offsets import Tubes
from solvers.six_dof.cells.tube_prover import TubeProver, has_ranges, prover_of
from tests.support.exact_rows import Point, error_column, polynomial
from tests.support.exact_system import Dual, equations, total
from tests.support.kernel_callers import Callers
from tests.support.planted_platform import Planted, plant, plant_planar
from tests.support.platform_cells import (
    Stepper,
    choice_of,
    no_tubes,
    pose,
    pose_cell,
    pose_trial,
    turn,
    turn_cell,
    turn_trial,
)

forms = Callers(form_system)
kernels = Callers(second_order)
SYMBOLS = tube.SYMBOLS
COUNTS = (2, 3, 4, 5, 6)
"""Taut cables; two stand for the problem in a plane."""
every_count = pytest.mark.parametrize("n", COUNTS)


@cache
def planted(n: int) -> list[Planted]:
    """Return robots whose exact lengths are somewhere in the ranges of their model."""
    rng = random.Random(500 + n)
    spreads = (Fraction(1, 10**6), Fraction(1, 5000))
    make = plant_planar if n == 2 else lambda rng, **more: plant(rng, n, **more)
    return [make(rng, slack=1, width=spread) for spread in spreads for _ in range(2)]


@cache
def known_exactly(n: int) -> list[Planted]:
    """Return robots of exact data."""
    rng = random.Random(600 + n)
    return [plant_planar(rng, slack=1) if n == 2 else plant(rng, n, slack=1) for _ in range(4)]


def reduction_of(robot: Planted) -> Reduction:
    """Return which unknowns are free."""
    return PLANAR if robot.n == 2 else GEOMETRY if robot.n == 6 else GENERAL


def exact_unknowns(robot: Planted) -> list[Fraction]:
    """Return (u, p, t); the tensions of six cables stand as 0."""
    return [*robot.u, *robot.p, *(robot.t if robot.n < 6 else [Fraction(0)] * 6)]


def value_at(coefficients: Any, delta: Sequence[Fraction]) -> Fraction:
    """Return a polynomial's exact value."""
    return polynomial(coefficients, Point([*delta, *[Fraction(0)] * (6 - len(delta))]))


# Forms along the data.


@every_count
def test_forms_of_the_system_enclose_it_for_every_choice(n: int) -> None:
    """At unknowns that are random polynomials of the data with errors; derivatives by dual numbers."""
    rng = random.Random(1)
    e = error_column(SYMBOLS)
    for robot in planted(n):
        F = np.full((form_system.TABLE.height, width(SYMBOLS), LANES), np.nan)
        size = rng.choice([1e-6, 1e-3, 0.1])
        middle = [rng.uniform(-1.0, 1.0) for _ in range(6)] + [rng.uniform(-5.0, 30.0) for _ in range(n)]
        for k in range(6 + n):
            F[form_system.Z + k] = 0.0
            F[form_system.Z + k, 0] = middle[k]
            for column in range(1, 1 + n):
                F[form_system.Z + k, column] = size * rng.uniform(-1.0, 1.0)
            for column in range(7, e):
                F[form_system.Z + k, column] = size**2 * rng.uniform(-1.0, 1.0)
            F[form_system.Z + k, e] = rng.choice([0.0, size**2])
            close(F, form_system.Z + k)
        forms.form_system(F, robot.model, robot.chart, True, SYMBOLS)
        delta = choice_of(robot, SYMBOLS)[:6]
        at = Point(delta, [Fraction(0) for _ in SYMBOLS.data])
        z = []
        for k in range(6 + n):
            row = F[form_system.Z + k, :, 0]
            z.append(polynomial(row, at) + Fraction(row[e]) * Fraction(rng.randint(-9, 9), 9))

        def encloses(row: int, exact: Fraction, F: Any = F, at: Point = at) -> bool:
            return abs(exact - polynomial(F[row, :, 0], at)) <= Fraction(F[row, e, 0])

        for k in range(6 + n):
            point = [Dual(x, int(j == k)) for j, x in enumerate(z)]
            scale = total([Dual(1), *(x * x for x in point[:3])])
            for i, equation in enumerate(equations(robot, robot.chart, point)):
                exact = scale * equation
                assert encloses(form_system.EQUATIONS + i, exact.value)
                assert encloses(form_system.JACOBIAN + form_system.MOST_UNKNOWNS * i + k, exact.slope)
        assert np.isfinite(F[form_system.EQUATIONS : form_system.EQUATIONS + n + 6, e]).all()


def close(F: Any, row: int) -> None:
    """Bring a row's sums into step."""
    kernels.close(F, row, SYMBOLS)


def test_an_exact_system_is_enclosed_tightly() -> None:
    """The test above would pass for errors of any size."""
    robot = plant(random.Random(2), 4)
    n, e = 4, error_column(SYMBOLS)
    F = np.zeros((form_system.TABLE.height, width(SYMBOLS), LANES))
    for k, x in enumerate([*robot.u, *robot.p, *robot.t]):
        F[form_system.Z + k, 0] = float(x)
    forms.form_system(F, robot.model, robot.chart, True, SYMBOLS)
    rows = F[form_system.EQUATIONS : form_system.EQUATIONS + n + 6]
    assert np.all(abs(rows[:, 0]) < 1e-10) and np.all(rows[:, e] < 1e-10)


# Tubes.


def tube_of(robot: Planted) -> Tube | None:
    """Return the tube that is found from a start beside the planted pose."""
    prover = TubeProver(robot.model, reduction_of(robot))
    start = np.array([float(x) for x in [*robot.u, *robot.p]]) + 1e-5 * np.sin(np.arange(6))
    fixed = prover.system.frozen[robot.chart]
    start[:3][fixed] = 0.0
    if robot.model.planar:
        start[4] = 0.0
    found = prover.root_near(robot.chart, start[:3], start[3:])
    assert found is None or isinstance(found, Tube)
    return found


@every_count
def test_a_tube_holds_the_exact_zero(n: int) -> None:
    """All data are off their middles: the lengths by their symbols, the others as errors."""
    proved = 0
    for robot in planted(n):
        found = tube_of(robot)
        if found is None:
            continue
        proved += 1
        delta = choice_of(robot, SYMBOLS)[:6]
        for k, x in enumerate(exact_unknowns(robot)):
            # The zero that the tube was found near is the planted one if it is within reach of it.
            off = abs(x - value_at(found.polynomial[k], delta))
            assert off <= Fraction(found.radii[k]) or off > Fraction(found.reach[k]) > 0
            assert off <= Fraction(found.radii[k])
            assert found.box[k, 0] <= x <= found.box[k, 1]
    assert proved >= 2


def ranged(robot: Planted, half: float) -> Planted:
    """Return a robot of exact data whose taut lengths have ranges, squares +- half."""
    errors = robot.model.lengths_sq_err.copy()
    errors[: robot.n] = half
    lengths = robot.model.lengths.copy()
    squares = robot.model.lengths_sq
    lengths[: robot.n] = np.sqrt(np.stack([squares - 1.01 * half, squares + 1.01 * half], axis=1)[: robot.n])
    model = robot.model._replace(lengths_sq_err=errors, lengths=lengths)
    return replace(robot, model=model)


def zero_for(model: Model, reduction: Reduction, chart: int, squares: Any, start: Any) -> Any:
    """Return the zero for some squares of length by Newton's method in floats, if it converges."""
    system = prover_of(model, reduction).system
    data = np.empty((model.n_taut + 1, 7, 2))
    fill_data(model, chart, data)
    data[: model.n_taut, 6] = np.asarray(squares)[:, None]
    z, m = start.copy(), system.free.shape[1]
    return z if improve(data, system.rows, system.free[chart], z, np.empty((m, m)), 40) else None


def choices(rng: random.Random, n: int, count: int) -> list[Any]:
    """Return values of the n symbols: corners first, then some inside."""
    corners = [np.array([rng.choice([-1.0, 1.0]) for _ in range(n)]) for _ in range(count // 2)]
    return corners + [np.array([rng.uniform(-1.0, 1.0) for _ in range(n)]) for _ in range(count // 2)]


@every_count
def test_a_tube_is_little_wider_than_its_zeros(n: int) -> None:
    """The zeros of random choices, followed by Newton, lie in it and reach nearly as far."""
    rng = random.Random(3)
    proved = 0
    for start in known_exactly(n):
        robot = ranged(start, 1e-3)
        found = tube_of(robot)
        if found is None:
            continue
        proved += 1
        zeros = []
        for delta in choices(rng, n, 40):
            squares = found.squares + delta * found.radii_of_squares
            guess, part = found.zero_at(squares)
            assert part is found
            z = zero_for(robot.model, reduction_of(robot), robot.chart, squares, guess)
            assert z is not None and np.all(abs(z - guess) <= found.radii + 1e-9 * (1.0 + abs(z)))
            zeros.append(z)
        # Corners of the linear part: what no sample of 40 may reach.
        reach = 2.0 * abs(found.slopes).sum(axis=1)
        free = found.reach > 0.0
        assert np.all(np.ptp(found.box, axis=1)[free] <= 1.5 * reach[free] + 1e-6)
        assert np.all(np.ptp(zeros, axis=0) <= np.ptp(found.box, axis=1) + 1e-9)
    assert proved >= 2


def test_exact_data_have_no_tubes() -> None:
    robot = plant(random.Random(4), 3)
    assert not has_ranges(robot.model)
    assert not isinstance(prover_of(robot.model, GENERAL), TubeProver)
    assert isinstance(prover_of(ranged(robot, 1e-6).model, GENERAL), TubeProver)


# Cells and tubes.


def tube_through(
    rng: random.Random, robot: Planted, reach: Any, off: Any = 0.0, chart: int | None = None
) -> Tubes:
    """Return one tube, of random slopes, that for the exact lengths is ``off`` the exact unknowns."""
    free = reach_of(robot, np.ones(6 + robot.n)) > 0.0
    tubes = no_tubes(robot.model, 1)
    slopes = np.array([[rng.uniform(-1.0, 1.0) for _ in range(6)] for _ in free])
    slopes *= rng.choice([0.0, 1e-6, 1e-4]) * free[:, None]
    delta = np.array(choice_of(robot, SYMBOLS)[:6], dtype=float)
    delta = delta[: robot.n]
    slopes[:, robot.n :] = 0.0
    exact = np.array([float(x) for x in exact_unknowns(robot)])
    tubes.charts[0] = robot.chart if chart is None else chart
    tubes.near[0] = -1e3, 1e3
    tubes.centres[0] = exact - slopes[:, : robot.n] @ delta + off
    tubes.slopes[0], tubes.reach[0] = slopes, reach
    return tubes


def reach_of(robot: Planted, reach: Any) -> Any:
    """Return a reach that is 0 in what the reduced problem fixes, and in the tensions of six cables."""
    reach = reach.copy()
    if robot.model.planar:
        reach[[0, 2, 4]] = 0.0
    if robot.n == 6:
        reach[6:] = 0.0
    return reach


def fate(rng: random.Random, robot: Planted, search: Any, tubes: Tubes) -> int:
    """Return what becomes of a small cell with the planted equilibrium: 0 where it was dropped."""
    trial = turn_trial(rng, robot, 1e-3) if search is turn else pose_trial(rng, robot, 1e-3)
    stepper = Stepper(search, robot.model, tubes, 1e-8, ranged=True)
    values = robot.u if search is turn else [*robot.u, *robot.way()]
    cell = trial.cell
    for _ in range(600):
        ((verdict, family),) = stepper.step([cell])
        if verdict <= 0:
            return -verdict
        keep = [
            child
            for child in family
            if all(child[2 * k] <= x <= child[2 * k + 1] for k, x in enumerate(values))
            and (search is pose or child[turn.BRANCH] in (0.0, trial.branch))
        ]
        assert keep
        cell = rng.choice(keep)
    raise AssertionError("no leaf after 600 steps")


@every_count
@pytest.mark.parametrize("search", [turn, pose], ids=["u", "u and x"])
def test_a_cell_is_settled_only_by_a_tube_that_holds_its_equilibrium(n: int, search: Any) -> None:
    """Also of problems in a plane, whose fixed unknowns have no reach."""
    rng = random.Random(5)
    for k, robot in enumerate(planted(n)):
        reach = reach_of(robot, np.array([0.3] * 3 + [1.0] * 3 + [20.0] * n))
        # The other data of the last ones are too uncertain for bounds of all tensions.
        assert k >= 2 or fate(rng, robot, search, tube_through(rng, robot, reach)) == 0
        other = tube_through(rng, robot, reach, chart=(robot.chart + 1) % 4)
        assert fate(rng, robot, search, other) != 0
        for k in np.flatnonzero(reach):
            off = np.zeros(6 + n)
            off[k] = rng.choice([-1.0, 1.0]) * (reach[k] + 1e-6)
            assert fate(rng, robot, search, tube_through(rng, robot, reach, off)) != 0


@every_count
def test_offsets_hold_those_of_the_equilibrium(n: int) -> None:
    rng = random.Random(6)
    bounded, exact, sharp = 0, 0, 0
    for robot in planted(n):
        for reach in (1e-2, 1e-4, 0.0):
            for kind, offsets in ((RANGED_ROTATION_CELLS, turn_offsets), (RANGED_POSE_CELLS, pose_offsets)):
                in_turn = kind is RANGED_ROTATION_CELLS
                cell = (
                    turn_cell(rng, robot, reach, robot.branch()) if in_turn else pose_cell(rng, robot, reach)
                )
                off = np.array([rng.uniform(-1e-2, 1e-2) for _ in range(6 + n)])
                off[reach_of(robot, np.ones(6 + n)) == 0.0] = 0.0
                tubes = tube_through(rng, robot, reach_of(robot, np.ones(6 + n)), off)
                found = np.full(6 + n, np.nan)
                if offsets(kind.scratch(), robot.model, cell, tubes, 0, found):
                    bounded += 1
                    assert np.all(abs(off) <= found + 1e-12)
                    exact += reach == 0.0
                    sharp += reach == 0.0 and bool(np.all(found[:6] <= abs(off[:6]) + 0.01))
    # Some robots are nearly singular.
    assert bounded >= 10 and sharp >= 0.5 * exact > 0.0


def test_a_cell_on_both_branches_is_not_asked_for_offsets() -> None:
    """Its position is one of two: bounds of one branch would settle the other."""
    rng = random.Random(7)
    for robot in planted(3):
        cell = turn_cell(rng, robot, 1e-4, robot.branch())
        scratch, found = RANGED_ROTATION_CELLS.scratch(), np.empty(9)
        tubes = tube_through(rng, robot, np.ones(9))
        if turn_offsets(scratch, robot.model, cell, tubes, 0, found):
            cell[turn.BRANCH] = 0.0
            assert not turn_offsets(scratch, robot.model, cell, tubes, 0, found)
            prover = TubeProver(robot.model, GENERAL)
            known = [root for root in [tube_of(robot)] if root is not None]
            cells = np.array([cell])
            assert len(prover.unsettled(cells, known, RANGED_ROTATION_CELLS)) == 1


# Halves.


def test_halves_of_a_range_are_the_whole() -> None:
    robot = ranged(plant(random.Random(8), 3), 1e-3)
    low, high = halved(robot.model, 1)
    whole = robot.model
    wanted = ends_of(whole)
    for k in (0, 2):
        assert np.array_equal(ends_of(low)[k], wanted[k]) and np.array_equal(ends_of(high)[k], wanted[k])
    (first, cut), (again, last) = ends_of(low)[1], ends_of(high)[1]
    assert first <= wanted[1, 0] and again <= whole.lengths_sq[1] <= cut and wanted[1, 1] <= last
    assert low.lengths[1, 0] == whole.lengths[1, 0] and high.lengths[1, 1] == whole.lengths[1, 1]
    square = Fraction(whole.lengths_sq[1])
    assert Fraction(high.lengths[1, 0]) ** 2 <= square <= Fraction(low.lengths[1, 1]) ** 2


def ends_of(model: Model) -> Any:
    """Return the ends (n, 2) of the taut cables' squares of length."""
    n = model.n_taut
    middles, errors = model.lengths_sq[:n], model.lengths_sq_err[:n]
    return np.stack([middles - errors, middles + errors], axis=1)


def tubes_of_halves(robot: Planted, cable: int) -> tuple[Tube, Tube]:
    """Return the tubes of both halves of a cable's lengths."""
    found = [tube_of(replace(robot, model=model)) for model in halved(robot.model, cable)]
    assert found[0] is not None and found[1] is not None
    return found[0], found[1]


@pytest.mark.parametrize("n", (3, 4, 5))
def test_glued_tubes_are_one_tube_of_the_whole_range(n: int) -> None:
    rng = random.Random(9)
    joined = 0
    for start in known_exactly(n):
        robot = ranged(start, 1e-4)
        cable = rng.randrange(n)
        low, high = tubes_of_halves(robot, cable)
        squares = robot.model.lengths_sq[:n]
        one = glued(low, high, cable, squares)
        if one is None:
            continue
        joined += 1
        assert isinstance(one, GluedTube) and one.parts == (low, high)
        for delta in choices(rng, n, 20):
            chosen = squares + delta * robot.model.lengths_sq_err[:n]
            guess, part = one.zero_at(chosen)
            assert part is (high if chosen[cable] > squares[cable] else low)
            z = zero_for(robot.model, reduction_of(robot), robot.chart, chosen, guess)
            assert z is not None and np.all(abs(z - guess) <= part.radii + 1e-9 * (1.0 + abs(z)))
            assert np.all((one.box[:, 0] - 1e-9 <= z) & (z <= one.box[:, 1] + 1e-9))
        whole = tube_of(robot)
        assert whole is not None and whole.holds(one, squares)
    assert joined >= 2


def test_tubes_of_other_zeros_are_not_glued() -> None:
    robot = ranged(known_exactly(3)[0], 1e-4)
    low, high = tubes_of_halves(robot, 0)
    squares = robot.model.lengths_sq[:3]
    assert glued(low, high, 0, squares) is not None
    for k in range(9):
        moved = high.polynomial.copy()
        moved[k, 0] += high.reach[k] + low.reach[k]
        assert glued(low, replace(high, polynomial=moved), 0, squares) is None
    assert glued(low, replace(high, chart=(high.chart + 1) % 4), 0, squares) is None


@pytest.mark.parametrize("n", (3, 4, 6))
def test_the_cell_around_a_tube_holds_its_poses(n: int) -> None:
    """Its x turns with u: the arm moves the centre of the pivot's sphere."""
    rng = random.Random(10)
    for start in known_exactly(n):
        robot = ranged(start, 1e-3)
        found = tube_of(robot)
        if found is None:
            continue
        # As wide as a tube that turns a lot.
        wide = replace(found, box=found.box + np.array([-0.2, 0.2]) * (np.arange(6 + n) < 3)[:, None])
        cell = cell_around(robot.model, wide)[0]
        assert cell[POSE_COLUMNS.chart] == found.chart
        for _ in range(30):
            u, p = (
                [Fraction(lo) + (Fraction(hi) - Fraction(lo)) * rng.randint(0, 4) / 4 for lo, hi in part]
                for part in (wide.box[:3], wide.box[3:6])
            )
            x = [a - c for a, c in zip(p, robot.centre(u, robot.pivot), strict=True)]
            for k, value in enumerate([*u, *x]):
                assert cell[2 * k] <= value + Fraction(1, 10**9)
                assert value - Fraction(1, 10**9) <= cell[2 * k + 1]
