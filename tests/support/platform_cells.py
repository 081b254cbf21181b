"""Batches of cells around planted equilibria, whose lanes are checked one by one in exact numbers."""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from cdpr_interval.engine import batch_cells as platform_batch
from cdpr_interval.engine import rows as engine_rows
from cdpr_interval.engine.scratch import Scratch
from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.kernels.lanes import LANES
from cdpr_interval.kernels.second_order import (
    POSE_AND_DATA,
    ROTATION_AND_DATA,
    ROTATION_ONLY,
    WHOLE_POSE,
    Symbols,
    width,
)
from cdpr_interval.mechanics.six_dof import geometry as platform_polynomials
from cdpr_interval.mechanics.six_dof import rows as platform_rows
from solvers.six_dof.cells import bounds as platform_bounds
from solvers.six_dof.cells import branch as platform_branch
from solvers.six_dof.cells import pose_cells as platform_pose
from solvers.six_dof.cells import ranged_cells as platform_ranged
from solvers.six_dof.cells import rotation_cells as platform_turn
from solvers.six_dof.cells.columns import POSE_COLUMNS, ROTATION_COLUMNS
from solvers.six_dof.cells.kinds import Context
from solvers.six_dof.cells.tube_offsets import Tubes
from tests.support import lane_calls as calls
from tests.support import lane_platform as platform
from tests.support.exact_rows import Point, error_column, polynomial
from tests.support.kernel_callers import Callers
from tests.support.planted_platform import Planted, Vector

forms = Callers(platform_polynomials, platform_rows, engine_rows)
pose = Callers(platform_pose, platform_bounds, platform_batch, engine_rows, platform_rows)
turn = Callers(platform_turn, platform_bounds, platform_branch, platform_batch, engine_rows, platform_rows)
ranged_cells = Callers(platform_ranged)

SPACES = {False: (ROTATION_ONLY, WHOLE_POSE), True: (ROTATION_AND_DATA, POSE_AND_DATA)}
"""The symbols of cells in u and in (u, x), without and with those of data that have ranges."""


@dataclass(frozen=True)
class Trial:
    """A cell that holds the equilibrium of a robot, as seen in the cell's chart."""

    robot: Planted
    cell: Any
    branch: int
    """Whose position is asked for."""
    reach: float


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


def turn_cell(rng: random.Random, robot: Planted, reach: float, branch: int = 0) -> Any:
    """Return a cell in u that holds the planted equilibrium."""
    cell = np.zeros(ROTATION_COLUMNS.width)
    cell[:6] = u_box(rng, robot, reach)
    cell[turn.CHART], cell[turn.BRANCH], cell[ROTATION_COLUMNS.share] = robot.chart, branch, 1.0
    return cell


def pose_cell(rng: random.Random, robot: Planted, reach: float) -> Any:
    """Return a (u, x) cell that holds the planted equilibrium."""
    cell = np.zeros(POSE_COLUMNS.width)
    cell[:6] = u_box(rng, robot, reach)
    for k, x in enumerate(robot.way()):
        thin = robot.model.planar and k == 1
        cell[6 + 2 * k : 8 + 2 * k] = around(rng, x, 0.0 if thin else reach)
    cell[POSE_COLUMNS.chart], cell[POSE_COLUMNS.share] = robot.chart, 1.0
    return cell


def turn_trial(rng: random.Random, robot: Planted, reach: float, branch: int = 0) -> Trial:
    """Return a cell in u on the equilibrium's branch, or on another one."""
    branch = branch or robot.branch()
    return Trial(robot, turn_cell(rng, robot, reach, branch), branch, reach)


def pose_trial(rng: random.Random, robot: Planted, reach: float) -> Trial:
    return Trial(robot, pose_cell(rng, robot, reach), 0, reach)


def inside(rng: random.Random, lo: float, hi: float) -> Fraction:
    """Return an exact number in [lo, hi], often an end."""
    return Fraction(lo) + (Fraction(hi) - Fraction(lo)) * rng.choice(
        [0, 1, Fraction(rng.randint(0, 999), 999)]
    )


def point_of(rng: random.Random, cell: Any, variables: int) -> Vector:
    return [inside(rng, cell[2 * k], cell[2 * k + 1]) for k in range(variables)]


class Batch:
    """Rows of up to ``LANES`` cells of one model."""

    def __init__(self, S: Symbols, cells: Sequence[Any], trials: Sequence[Trial | None]) -> None:
        self.S = S
        # Nothing may be read before it was written.
        self.F = np.full((platform_rows.FORMS.height, width(S), LANES), np.nan)
        self.W = np.full((platform_rows.WORK.height, platform_rows.WORK.columns, LANES), np.nan)
        self.C = np.zeros((1, len(cells[0]), LANES))
        for lane in range(LANES):
            self.C[0, :, lane] = cells[min(lane, len(cells) - 1)]
        self.lanes = [Lane(self, k, trial) for k, trial in enumerate(trials)]
        self.rank = 0

    @property
    def model(self) -> Any:
        return self.lanes[0].robot.model

    def bounds(self, row: int) -> Any:
        """Return lower and upper bounds of a row, lane by lane."""
        return calls.bounds(self.F, row, self.S)

    def read(self, lane: int, size: int) -> Any:
        """Return the bounds of (u, p, t) that a kernel left."""
        lo, hi = np.zeros((2, size))
        turn.read_bounds(self.W, self.C, lane, self.model, lo, hi)
        return lo, hi


class Lane:
    """One lane's rows, and a point of its cell in exact numbers."""

    def __init__(self, batch: Batch, lane: int, trial: Trial | None) -> None:
        self.batch, self.lane, self.trial = batch, lane, trial
        self.F, self.W = batch.F[:, :, lane], batch.W[:, :, lane]
        self.cell = batch.C[0, :, lane].copy()
        self.error = error_column(batch.S)
        self.delta = choice_of(trial.robot, batch.S) if trial else [Fraction(0) for _ in batch.S.data]
        self.at = Point([Fraction(0)] * len(batch.S.noise), self.delta)
        self.room = Fraction(0)
        self.found = True
        """Whether the position is a smooth branch."""

    @property
    def robot(self) -> Planted:
        assert self.trial is not None
        return self.trial.robot

    def point(self, values: Sequence[Fraction]) -> None:
        """Set the point by the values of the first symbols' variables."""
        C = self.batch.C
        eps = [Fraction(0)] * len(self.batch.S.noise)
        for k, value in enumerate(values):
            m, r = platform.middle_and_radius(C[0, 2 * k], C[0, 2 * k + 1])
            rest = value - Fraction(m[self.lane])
            eps[k] = rest / Fraction(r[self.lane]) if r[self.lane] else rest
            assert abs(eps[k]) <= 1
        self.at = Point(eps, self.delta)

    def encloses(self, row: int, value: Fraction) -> None:
        """Assert that a row encloses the value at the point."""
        form = self.F[row]
        assert np.all(np.isfinite(form))
        assert abs(value - polynomial(form, self.at)) <= Fraction(form[self.error]) + self.room

    def enclose_all(self, first: int, values: Iterable[Fraction]) -> None:
        for k, value in enumerate(values):
            self.encloses(first + k, value)

    def brackets(self, row: int, value: Fraction) -> None:
        """Assert that the bounds of a row hold the value."""
        lo, hi = (x[self.lane] for x in self.batch.bounds(row))
        assert lo <= value + self.room and value - self.room <= hi

    def place(self, x: Vector) -> None:
        """Assert that one value of the error symbol encloses all of x; take it for the point."""
        low, high = Fraction(-1), Fraction(1)
        column = 1 + turn.ERROR_SYMBOL
        assert self.at.eps[turn.ERROR_SYMBOL] == 0
        for k in range(3):
            form = self.F[forms.POSITION + k]
            assert np.all(np.isfinite(form))
            error, slope = Fraction(form[self.error]) + self.room, Fraction(form[column])
            rest = x[k] - polynomial(form, self.at)
            if slope == 0:
                assert abs(rest) <= error
                continue
            ends = sorted([(rest - error) / slope, (rest + error) / slope])
            low, high = max(low, ends[0]), min(high, ends[1])
        assert low <= high
        eps = list(self.at.eps)
        eps[turn.ERROR_SYMBOL] = (low + high) / 2
        self.at = Point(eps, self.delta)


def choice_of(robot: Planted, S: Symbols) -> list[Fraction]:
    """Return the values of the symbols of data that the exact lengths are."""
    found = []
    for i, _ in enumerate(S.data):
        error = Fraction(robot.model.lengths_sq_err[i]) if i < robot.n else Fraction(0)
        gap = robot.lengths_sq[i] - Fraction(robot.model.lengths_sq[i]) if error else Fraction(0)
        found.append(gap / error if error else gap)
    assert all(abs(delta) <= 1 for delta in found)
    return found


def batches(S: Symbols, trials: Sequence[Trial]) -> Iterator[Batch]:
    """Fill batches with the trials (of one model), in their order."""
    for k in range(0, len(trials), LANES):
        chosen = trials[k : k + LANES]
        yield Batch(S, [trial.cell for trial in chosen], chosen)


def turn_batches(trials: Sequence[Trial], ranged: bool = False) -> Iterator[Batch]:
    """Write the rows of cells in u; ``found`` tells whether the position is a smooth branch."""
    for batch in batches(SPACES[ranged][0], trials):
        F, W, C, S, model = batch.F, batch.W, batch.C, batch.S, batch.model
        branch = np.array([lane.trial.branch for lane in batch.lanes if lane.trial], dtype=float)
        branch = np.concatenate([branch, np.full(LANES - len(branch), branch[-1])])
        turn.prepare(F, model, C, S)
        found = platform.on_branch(F, W, model, branch, S)
        forms.wrench_rows(F, model, S)
        for lane in batch.lanes:
            assert found[lane.lane] in (0.0, 1.0)
            lane.found = found[lane.lane] > 0.0
        yield batch


def pose_batches(trials: Sequence[Trial], ranged: bool = False) -> Iterator[Batch]:
    """Write the rows of (u, x) cells."""
    for batch in batches(SPACES[ranged][1], trials):
        F, S = batch.F, batch.S
        forms.rotation_rows(F, batch.C, POSE_COLUMNS.chart, S)
        forms.triple_rows(F, batch.model, S)
        pose.position_variables(F, batch.C, S)
        forms.wrench_rows(F, batch.model, S)
        yield batch


def no_tubes(model: Any, count: int = 0) -> Tubes:
    """Return room for so many tubes."""
    k = 6 + model.n_taut
    shapes = ((3, 2), (k,), (k, 6), (k, 0), (k,), (k,))
    return Tubes(np.zeros(count, dtype=np.int64), *(np.zeros((count, *shape)) for shape in shapes))


Verdict = tuple[int, Any]
"""What ``process`` did to a cell, and its children or the leaf."""


class Stepper:
    """One thread's scratch around a search's ``process``."""

    def __init__(
        self, search: Any, model: Any, roots: Any = None, leaf_size: float = 1e-9, *, ranged: bool = False
    ) -> None:
        self.search = search
        self.process = search.process
        if ranged:
            self.process = ranged_cells.process_turns if search is turn else ranged_cells.process_poses
        S = SPACES[ranged][0 if search is turn else 1]
        columns = ROTATION_COLUMNS if search is turn else POSE_COLUMNS
        self.width = columns.width
        self.F = np.full((platform_rows.FORMS.height, width(S), LANES), np.nan)
        self.W = np.full((platform_rows.WORK.height, platform_rows.WORK.columns, LANES), np.nan)
        self.C = np.full((1, self.width, LANES), np.nan)
        self.states, self.verdicts = np.full((2, LANES), 99)
        self.children = np.full((2 * LANES, self.width), np.nan)
        if roots is None:
            roots = no_tubes(model) if ranged else np.empty((0, 1 + 2 * (6 + model.n_taut)))
        scratch = Scratch(S, self.F, self.W, self.C, self.states, self.verdicts)
        self.context = Context(model, roots, leaf_size, columns, (0,) * columns.variables, scratch)

    def step(self, cells: Sequence[Any], spare: Any = None) -> list[Verdict]:
        """Process up to ``LANES`` cells; ``spare`` fills the lanes beyond them (default: the last)."""
        for lane in range(LANES):
            last = cells[-1] if spare is None else spare
            self.C[0, :, lane] = cells[lane] if lane < len(cells) else last
        self.process(self.context, len(cells), self.children)
        done: list[Verdict] = []
        for lane in range(len(cells)):
            verdict = int(self.verdicts[lane])
            rows = 1 if verdict < 0 else verdict
            done.append((verdict, self.children[2 * lane : 2 * lane + rows].copy()))
        return done
