"""The square system and its derivatives in exact numbers, the proofs of planted roots, and double roots."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest

from cdpr_interval.engine import krawczyk
from cdpr_interval.engine.budget import Budget
from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.exact.range import Range, RangeVector
from cdpr_interval.mechanics.six_dof import system as newton
from cdpr_interval.mechanics.six_dof.arrays import Model, build_model
from solvers.six_dof.cells.columns import POSE_COLUMNS
from solvers.six_dof.cells.kinds import POSE_CELLS
from solvers.six_dof.cells.root_search import FEW_LEAVES
from solvers.six_dof.cells.roots import GENERAL, GEOMETRY, PLANAR, Prover, Root
from tests.support.exact_system import Dual, equations, total
from tests.support.kernel_callers import Callers
from tests.support.planted_platform import Planted, plant, shifted

called = Callers(krawczyk)
TAUT = (2, 3, 4, 5, 6)
WIDTHS = (Fraction(0), Fraction(1, 10**6))
every_count = pytest.mark.parametrize("n", TAUT)


@cache
def planted(n: int) -> list[Planted]:
    rng = random.Random(200 + n)
    return [plant(rng, n, slack=1, width=width) for width in WIDTHS for _ in range(3)]


def random_box(rng: random.Random, n: int) -> Any:
    """Return a box of (u, p, t), also beyond the chart, also thin and across zero."""
    size = np.array([rng.choice([0.0, 1e-9, 1e-3, 0.3, 2.0]) * rng.random() for _ in range(6 + n)])
    middle = np.array(
        [rng.uniform(-2.5, 2.5) for _ in range(6)] + [rng.uniform(-30.0, 50.0) for _ in range(n)]
    )
    middle[rng.randrange(6 + n)] = 0.0
    return np.column_stack([middle - size, middle + size])


def point_in(rng: random.Random, box: Any) -> list[Fraction]:
    values = []
    for lo, hi in box:
        share = rng.choice([Fraction(0), Fraction(1), Fraction(rng.randint(0, 97), 97)])
        values.append(Fraction(lo) + (Fraction(hi) - Fraction(lo)) * share)
    return values


def data_of(model: Model, chart: int) -> Any:
    data = np.empty((model.n_taut + 1, 7, 2))
    newton.fill_data(model, chart, data)
    return data


def contains(bounds: Any, x: Fraction) -> bool:
    return bool(bounds[0] <= x <= bounds[1])


@every_count
def test_system_and_derivatives_enclose_the_exact_ones(n: int) -> None:
    rng = random.Random(1)
    for robot in planted(n):
        for _ in range(4):
            chart = rng.randrange(4)
            box = random_box(rng, n)
            f, J = np.empty((n + 6, 2)), np.empty((n + 6, 6 + n, 2))
            newton.system(data_of(robot.model, chart), box, f, J, True)
            z = point_in(rng, box)
            for k in range(6 + n):
                at = [Dual(x, int(j == k)) for j, x in enumerate(z)]
                for row, value in enumerate(equations(robot, chart, at)):
                    assert contains(f[row], value.value)
                    assert contains(J[row, k], value.slope)


@every_count
def test_the_system_vanishes_at_the_planted_pose(n: int) -> None:
    """In the tightest box around it, so that only the data's own errors make room."""
    for robot in planted(n):
        box = np.array([enclose(x) for x in [*robot.u, *robot.p, *robot.t]])
        f, J = np.empty((n + 6, 2)), np.empty((n + 6, 6 + n, 2))
        newton.system(data_of(robot.model, robot.chart), box, f, J, True)
        assert all(contains(row, Fraction(0)) for row in f)


@every_count
@pytest.mark.parametrize("name", ["exits", "arms", "lengths_sq", "load"])
def test_the_error_of_every_datum_is_counted(n: int, name: str) -> None:
    robot = shifted(planted(n)[0], name, 1e-3)
    box = np.array([enclose(x) for x in [*robot.u, *robot.p, *robot.t]])
    f, J = np.empty((n + 6, 2)), np.empty((n + 6, 6 + n, 2))
    newton.system(data_of(robot.model, robot.chart), box, f, J, True)
    assert all(contains(row, Fraction(0)) for row in f)
    assert np.any(f[:, 1] - f[:, 0] > 1e-6)
    for k in range(6 + n):
        at = [Dual(x, int(j == k)) for j, x in enumerate([*robot.u, *robot.p, *robot.t])]
        for row, value in enumerate(equations(robot, robot.chart, at)):
            assert contains(J[row, k], value.slope)


@every_count
def test_bounds_at_a_point_are_tight(n: int) -> None:
    rng = random.Random(2)
    robot = planted(n)[0]
    box = random_box(rng, n)
    box[:, 1] = box[:, 0]
    f, J = np.empty((n + 6, 2)), np.empty((n + 6, 6 + n, 2))
    newton.system(data_of(robot.model, 0), box, f, J, True)
    assert np.all(f[:, 1] - f[:, 0] < 1e-11)
    assert np.all(J[..., 1] - J[..., 0] < 1e-11)


def test_rows_and_fixed_unknowns_select_from_the_full_system() -> None:
    rng = random.Random(3)
    for robot in planted(4):
        n = 4
        box = random_box(rng, n)
        rows = np.array([[rng.uniform(-1.0, 1.0) for _ in range(6)] for _ in range(4)])
        rows[1, 2] = 0.0
        free = np.array([0, 1, 3, 4, 5, 6, 8, 9])
        J, f = np.empty((8, 8, 2)), np.empty((8, 2))
        alone = np.empty((8, 2))
        newton.jacobian_over(data_of(robot.model, 2), rows, free, box, f, J)
        newton.residual_at(data_of(robot.model, 2), rows, box, alone)
        assert np.array_equal(f, alone)
        z = point_in(rng, box)
        for column, k in enumerate(free):
            full = equations(robot, 2, [Dual(x, int(j == k)) for j, x in enumerate(z)])
            chosen = full[:n]
            for combination in rows:
                chosen.append(
                    total([Dual(Fraction(c)) * x for c, x in zip(combination, full[n:], strict=True)])
                )
            for row, value in enumerate(chosen):
                assert contains(f[row], value.value)
                assert contains(J[row, column], value.slope)


def proved_root(robot: Planted) -> tuple[Prover, Root | None]:
    """Find and prove the planted root from a start beside it."""
    prover = Prover(robot.model, GEOMETRY if robot.n == 6 else GENERAL)
    start = np.array([float(x) for x in [*robot.u, *robot.p]]) + 1e-5 * np.sin(np.arange(6))
    return prover, prover.root_near(robot.chart, start[:3], start[3:])


def exact_unknowns(robot: Planted) -> list[Fraction]:
    return [*robot.u, *robot.p, *(robot.t if robot.n < 6 else [Fraction(0)] * 6)]


@pytest.mark.parametrize("n", TAUT[1:])
def test_planted_roots_are_proved_and_lie_in_their_boxes(n: int) -> None:
    for robot in planted(n):
        _, root = proved_root(robot)
        exact_data = bool(np.all(robot.model.exits_err < 1e-15))
        assert root is not None or not exact_data
        if root is None:
            continue
        for x, box, unique in zip(exact_unknowns(robot), root.box, root.unique, strict=True):
            assert contains(box, x)
            assert unique[0] <= box[0] and box[1] <= unique[1]
        assert not exact_data or np.all(np.ptp(root.box, axis=1)[:6] < 1e-9)


def setup(prover: Prover, chart: int, z: Any) -> tuple[Any, Any, Any]:
    """Return rows, free unknowns and the preconditioner at a float point."""
    rows, free = prover.system.rows, prover.system.free[chart]
    m = len(free)
    f, J, C = np.empty((m, 2)), np.empty((m, m, 2)), np.empty((m, m))
    newton.jacobian_over(data_of(prover.model, chart), rows, free, np.column_stack([z, z]), f, J)
    assert called.preconditioner(J, C)
    return rows, free, C


@pytest.mark.parametrize("n", TAUT[1:])
def test_krawczyk_never_proves_a_box_without_a_root(n: int) -> None:
    """Boxes beside the planted root, of the size at which the root's own box is proved."""
    rng = random.Random(4)
    for robot in planted(n)[:3]:
        prover, root = proved_root(robot)
        assert root is not None
        chart, model = robot.chart, robot.model
        z = root.box.mean(axis=1)
        rows, free, C = setup(prover, chart, z)
        image = np.empty_like(root.box)
        for radius in (1e-7, 1e-5, 1e-4):
            box = np.column_stack([z, z])
            box[free] += np.array([-radius, radius])
            proved = newton.krawczyk(data_of(model, chart), rows, free, C, box, image)
            assert proved or radius > 1e-6
            if proved:
                assert all(contains(b, x) for b, x in zip(image, exact_unknowns(robot), strict=True))
            for _ in range(10):
                away = box.copy()
                away[rng.choice(list(free))] += rng.choice([-1, 1]) * radius * rng.uniform(1.01, 5.0)
                assert not newton.krawczyk(data_of(model, chart), rows, free, C, away, image)


def scalar_range(x: float | int) -> Range:
    return Range.exact(Fraction(x))


def swing(height: float) -> Model:
    """Return a symmetric plane swing: with growing height of G its middle pose splits into three."""
    anchors = [(-2.0, 0, 0), (2.0, 0, 0)]
    points = [(-1.0, 0, height), (1.0, 0, height)]

    def data(v: Sequence[float]) -> RangeVector:
        x, y, z = (scalar_range(c) for c in v)
        return x, y, z

    lengths = [scalar_range(2.0)] * 2
    return build_model(
        [data(a) for a in anchors], [data(b) for b in points], lengths, data((0, 0, -100.0)), 2, planar=True
    )


CRITICAL = -5.0 / math.sqrt(3.0)
"""Height at which the swing's middle pose is a triple root."""


def swing_roots(above: float) -> tuple[Prover, list[Root]]:
    """Return the three proved poses of a swing a little above the critical height."""
    prover = Prover(swing(CRITICAL + above), PLANAR)
    tilt = 0.18 * math.sqrt(above)
    roots: list[Root] = []
    for u in (-tilt, 0.0, tilt):
        p = np.array([9.2 * u, 0.0, -math.sqrt(3.0) - CRITICAL - above])
        root = prover.root_near(0, np.array([0.0, u, 0.0]), p)
        assert root is not None
        roots.append(root)
    return prover, roots


def apart(a: Any, b: Any) -> bool:
    return bool(np.any(a[:, 1] < b[:, 0]) or np.any(b[:, 1] < a[:, 0]))


def inside(a: Any, b: Any) -> bool:
    return bool(np.all(b[:, 0] <= a[:, 0]) and np.all(a[:, 1] <= b[:, 1]))


@pytest.mark.parametrize("above", [1e-1, 1e-2, 1e-3, 1e-4, 1e-5])
def test_no_box_with_two_roots_is_called_regular(above: float) -> None:
    prover, roots = swing_roots(above)
    image = np.empty_like(roots[0].box)
    for i, j in ((0, 1), (1, 2), (0, 2)):
        a, b = roots[i], roots[j]
        assert apart(a.box, b.box)
        assert not inside(a.box, b.unique) and not inside(b.box, a.unique)
        hull = np.column_stack([np.minimum(a.box, b.box)[:, 0], np.maximum(a.box, b.box)[:, 1]])
        for z in (a.box.mean(axis=1), b.box.mean(axis=1), hull.mean(axis=1)):
            rows, free, C = setup(prover, 0, z)
            for grow in (0.0, 1e-3, 0.5):
                box = hull.copy()
                box[free] += grow * np.ptp(hull, axis=1)[free, None] * np.array([-1.0, 1.0])
                assert not newton.regular(data_of(prover.model, 0), rows, free, C, box)
                assert not newton.krawczyk(data_of(prover.model, 0), rows, free, C, box, image)


@pytest.mark.parametrize("above", [1e-1, 1e-2, 1e-4])
def test_boxes_around_one_of_three_roots_are_regular(above: float) -> None:
    """The test above would pass for a kernel that calls nothing regular."""
    prover, roots = swing_roots(above)
    for root in roots:
        z = root.box.mean(axis=1)
        rows, free, C = setup(prover, 0, z)
        assert newton.regular(data_of(prover.model, 0), rows, free, C, root.unique)
        gap = abs(roots[0].box - roots[1].box).max()
        assert np.ptp(root.unique, axis=1)[free].max() > 1e-5 * gap


@pytest.mark.parametrize("n", TAUT[1:5])
def test_the_krawczyk_matrix_encloses_the_exact_one(n: int) -> None:
    """I - C J(x) at points x of the box, with J from exact derivatives."""
    rng = random.Random(5)
    robot = planted(n)[0]
    prover, root = proved_root(robot)
    assert root is not None
    rows, free, C = setup(prover, robot.chart, root.box.mean(axis=1))
    m = len(free)
    E = np.empty((m, m, 2))
    for radius in (0.0, 1e-6, 0.1):
        box = root.box.copy()
        box[free] += np.array([-radius, radius])
        newton.krawczyk_matrix(data_of(prover.model, robot.chart), rows, free, C, box, E)
        z = point_in(rng, box)
        for j, k in enumerate(free):
            at = [Dual(x, int(i == k)) for i, x in enumerate(z)]
            column = [value.slope for value in equations(robot, robot.chart, at)][:m]
            for i in range(m):
                product = sum((Fraction(c) * x for c, x in zip(C[i], column, strict=True)), Fraction(0))
                assert contains(E[i, j], int(i == j) - product)


@pytest.mark.parametrize("n", TAUT[1:])
def test_regular_means_that_the_matrix_contracts_the_box(n: int) -> None:
    """The largest eigenvalue of |I - C J| is below 1, for boxes at the border where the answer changes."""
    robot = planted(n)[0]
    prover, root = proved_root(robot)
    assert root is not None
    middle = root.box.mean(axis=1)
    rows, free, C = setup(prover, robot.chart, middle)
    m = len(free)
    E = np.empty((m, m, 2))
    reach = np.ptp(root.unique, axis=1)
    small, large = 0.0, 1e3
    answers = []
    for _ in range(60):
        scale = 0.5 * (small + large)
        box = np.column_stack([middle - scale * reach, middle + scale * reach])
        answer = newton.regular(data_of(prover.model, robot.chart), rows, free, C, box)
        answers.append(answer)
        newton.krawczyk_matrix(data_of(prover.model, robot.chart), rows, free, C, box, E)
        growth = np.abs(np.linalg.eigvals(np.abs(E).max(axis=2))).max()
        assert growth < 1.0 + 1e-12 or not answer
        # A few steps of power iteration may miss a vector close to the border.
        assert answer or growth > 0.9
        small, large = (scale, large) if answer else (small, scale)
    assert True in answers and False in answers


@pytest.mark.parametrize("n", TAUT[1:])
def test_boxes_that_are_not_finite_prove_nothing(n: int) -> None:
    robot = planted(n)[0]
    prover, root = proved_root(robot)
    assert root is not None
    rows, free, C = setup(prover, robot.chart, root.box.mean(axis=1))
    image = np.empty_like(root.box)
    for k in range(6):
        for lo, hi in ((-math.inf, math.inf), (math.nan, math.nan), (-1.0, math.inf), (-1e200, 1e200)):
            box = root.box.copy()
            box[k] = lo, hi
            assert not newton.regular(data_of(prover.model, robot.chart), rows, free, C, box)
            assert not newton.krawczyk(data_of(prover.model, robot.chart), rows, free, C, box, image)


def settled(prover: Prover, cell: Any, roots: Sequence[Root]) -> bool:
    """Return True when all equilibria of a cell lie in the uniqueness box of one root."""
    lo, hi = np.empty(6 + prover.model.n_taut), np.empty(6 + prover.model.n_taut)
    if not POSE_CELLS.enclose(prover.model, cell, lo, hi):
        return False
    near = [root.unique for root in roots if root.chart == cell[POSE_COLUMNS.chart]]
    return any(bool(np.all(u[:, 0] <= lo) and np.all(hi <= u[:, 1])) for u in near)


@pytest.mark.parametrize("n", TAUT[1:])
def test_only_leaves_that_roots_settle_are_struck_off(n: int) -> None:
    """Leaves around a planted root, of many sizes, more than one call looks at."""
    rng = random.Random(41 + n)
    kept = struck = 0
    for robot in planted(n):
        prover, root = proved_root(robot)
        if root is None:
            continue
        cells = np.zeros((2 * FEW_LEAVES + 5, POSE_COLUMNS.width))
        for cell in cells:
            reach = 10.0 ** rng.uniform(-9.0, -1.0)
            z = [*map(float, robot.u), *map(float, robot.way())]
            for k, x in enumerate(z):
                middle = x + reach * rng.uniform(-2.0, 2.0) * rng.choice([0.0, 1.0])
                cell[2 * k], cell[2 * k + 1] = middle - reach, middle + reach
            cell[POSE_COLUMNS.chart] = robot.chart if rng.random() < 0.8 else (robot.chart + 1) % 4
        found, left = prover.find(cells, 0.0, POSE_CELLS, [root], Budget())
        assert np.array_equal(left, cells)
        few, left = prover.find(cells[:FEW_LEAVES], 0.0, POSE_CELLS, [root], Budget())
        roots = [root, *few]
        assert np.array_equal(left, [c for c in cells[:FEW_LEAVES] if not settled(prover, c, roots)])
        roots = [root, *found]
        left = prover.unsettled(cells, roots, POSE_CELLS)
        assert np.array_equal(left, [cell for cell in cells if not settled(prover, cell, roots)])
        for cell in left:
            assert any(np.array_equal(cell, other) for other in cells)
        kept, struck = kept + len(left), struck + len(cells) - len(left)
    assert kept > 20 and struck > 20
