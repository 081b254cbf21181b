"""The tables of scratch rows: no two ranges meet, and kernels write nothing beyond their ranges."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from cdpr_interval.engine import rows as engine
from cdpr_interval.engine.rows import Rows, Table
from cdpr_interval.kernels.lanes import LANES
from cdpr_interval.kernels.second_order import POSE_AND_ALL_DATA, ROTATION_ONLY, WHOLE_POSE, width
from cdpr_interval.mechanics.six_dof import rows as six_dof
from cdpr_interval.mechanics.six_dof.rows import BOUNDS, COLUMNS, FORMS, WORK, Y, moving_rows
from tests.support.planted_platform import Planted, plant, plant_planar
from tests.support.platform_cells import SPACES, Stepper, no_tubes, pose, pose_cell, turn, turn_cell

UNTOUCHED = 7.25
"""What stands where nothing may be written."""
MARGIN = 3
"""Rows and columns beyond the tables."""


@pytest.mark.parametrize("table", [engine.FORMS, engine.WORK, FORMS, WORK])
def test_no_two_ranges_share_a_row(table: Table) -> None:
    assert table.overlaps() == []
    assert all(0 <= rows.first < rows.end <= table.height for rows in table.ranges)
    assert all(0 < rows.columns <= table.columns for rows in table.ranges)
    assert len({rows.name for rows in table.ranges}) == len(table.ranges)


def test_a_planted_overlap_is_found() -> None:
    last = Rows("PLANTED", Y + moving_rows(engine.MOST_SYMBOLS) - 1, 1, 1)
    assert Table([*WORK.ranges, last]).overlaps() == [("Y", "PLANTED")]
    after = Rows("BEHIND", WORK.height, 2, 1)
    assert Table([*WORK.ranges, after]).overlaps() == []


@pytest.mark.parametrize(
    ("own", "below", "module"),
    [
        (engine.FORMS, None, engine),
        (engine.WORK, None, engine),
        (FORMS, engine.FORMS, six_dof),
        (WORK, engine.WORK, six_dof),
    ],
)
def test_a_name_is_where_its_range_begins(own: Table, below: Table | None, module: Any) -> None:
    known = [] if below is None else below.ranges
    assert own.ranges[: len(known)] == known
    for rows in own.ranges[len(known) :]:
        assert getattr(module, rows.name) == rows.first


def test_every_symbol_has_a_slope() -> None:
    y = next(rows for rows in WORK.ranges if rows.name == "Y")
    most = max(len(S.noise) + len(S.data) for S in (ROTATION_ONLY, WHOLE_POSE, POSE_AND_ALL_DATA))
    assert y.height == 1 + most == moving_rows(engine.MOST_SYMBOLS + engine.MOST_DATA)


def test_states_are_distinct() -> None:
    open_ones = (engine.OPEN, engine.SMALLER, engine.WIDE, engine.UNSMOOTH, engine.BOTH)
    reasons = (
        *(engine.NO_POSITION, engine.NO_LENGTH, engine.NOT_SLACK),
        *(engine.UNBALANCED, engine.SETTLED, engine.UNLOADED),
    )
    assert len({engine.EMPTY, *open_ones, *reasons}) == 1 + len(open_ones) + len(reasons)
    assert min(open_ones) > engine.EMPTY and max(open_ones) < min(reasons)


def robots() -> list[Planted]:
    rng = random.Random(41)
    spread = Fraction(1, 10**6)
    planted = [plant(rng, n, slack=1, width=spread) for n in (3, 4, 5, 6)]
    return [plant_planar(rng, slack=1, width=spread), *planted]


def roots_around(robot: Planted, ranged: bool = False) -> Any:
    """Return a uniqueness box, or a tube, that holds all near the equilibrium, so that cells are settled."""
    if ranged:
        tubes = no_tubes(robot.model, 1)
        tubes.charts[:] = robot.chart
        tubes.near[:] = -1e3, 1e3
        tubes.reach[:] = 1e3
        return tubes
    lo, hi = np.full((2, 6 + robot.n), -1e3)
    hi[:] = 1e3
    return np.array([[float(robot.chart), *lo, *hi]])


def written(search: Any, robot: Planted, ranged: bool) -> Any:
    """Return which places of W any lane wrote to, in an array wider and higher than the table."""
    rng = random.Random(42)
    work = np.full((WORK.height + MARGIN, WORK.columns + MARGIN, LANES), UNTOUCHED)
    for reach in (1.0, 0.3, 0.1, 0.03, 1e-2, 1e-3):
        for k in range(6):
            # What a root settles is not contracted.
            roots = roots_around(robot, ranged) if k % 2 else None
            stepper = Stepper(search, robot.model, roots, 1e-3, ranged=ranged)
            scratch = stepper.context.scratch._replace(work=work)
            stepper.context = stepper.context._replace(scratch=scratch)
            make = turn_cell if search is turn else pose_cell
            cells = [make(rng, robot, reach * rng.random()) for _ in range(LANES)]
            for cell in cells:
                # Away from the equilibrium as well, or no test would fail.
                cell[:6] += rng.choice([0.0, 0.0, 0.05, 0.3]) * (2.0 * rng.random() - 1.0)
            stepper.step(cells)
    return (work != UNTOUCHED).any(axis=2)


def strays(touched: Any, table: Table) -> list[tuple[int, int]]:
    """Return the places that were written to and lie in no range."""
    allowed = np.zeros_like(touched)
    for rows in table.ranges:
        allowed[rows.first : rows.end, : rows.columns] = True
    return [(int(row), int(column)) for row, column in np.argwhere(touched & ~allowed)]


def test_kernels_write_within_their_ranges() -> None:
    """Through all searches, which use every range but those for rare cells and for certificates."""
    searches = [(search, ranged) for search in (turn, pose) for ranged in (False, True)]
    touched = sum(written(search, robot, ranged) for search, ranged in searches for robot in robots()) > 0
    assert strays(touched, WORK) == []
    for name in ("COLUMNS", "BOUNDS", "Y"):
        smaller = Table(rows for rows in WORK.ranges if rows.name != name)
        assert strays(touched, smaller), f"a missing range {name} would not be noticed"
    unused = {rows.name for rows in WORK.ranges if not touched[rows.first : rows.end, : rows.columns].any()}
    assert unused <= {"PLACES", "PASSED", "HULL", "TRIED", "KEPT_Y"}
    assert touched[[COLUMNS, BOUNDS, Y]].any(axis=1).all()


def test_forms_are_written_within_their_ranges() -> None:
    for search, ranged in ((turn, False), (pose, False), (turn, True), (pose, True)):
        robot = robots()[2]
        symbols = SPACES[ranged][0 if search is turn else 1]
        stepper = Stepper(search, robot.model, roots_around(robot, ranged), 1e-3, ranged=ranged)
        forms = np.full((FORMS.height + MARGIN, width(symbols) + MARGIN, LANES), UNTOUCHED)
        stepper.context = stepper.context._replace(scratch=stepper.context.scratch._replace(forms=forms))
        make = turn_cell if search is turn else pose_cell
        rng = random.Random(43)
        for reach in (0.3, 0.03, 1e-3):
            stepper.step([make(rng, robot, reach) for _ in range(LANES)])
        assert (forms[: FORMS.height, : width(symbols)] != UNTOUCHED).any()
        assert (forms[FORMS.height :] == UNTOUCHED).all() and (forms[:, width(symbols) :] == UNTOUCHED).all()
