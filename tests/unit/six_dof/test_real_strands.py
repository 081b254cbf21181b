"""Roots of parts are joined where they are one root, and only there."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.engine.budget import Budget
from solvers.questions.problem import Problem
from solvers.six_dof.real.build import model_for
from solvers.six_dof.real.columns import DENSITIES, REAL_COLUMNS
from solvers.six_dof.real.model import RealModel
from solvers.six_dof.real.roots import RealRoot
from solvers.six_dof.real.strands import (
    Piece,
    at_lengths,
    core_at,
    joined,
    lies_in,
    piece_at,
    strands_in,
    zero_at,
)
from solvers.six_dof.real.subset import RealSearch

Floats = np.ndarray
LENGTHS = ["1.54832", "1.64748", "1.53246"]


def grab33(half: str) -> RealModel:
    """Return GRAB_33 with its three cables taut, lengths known to ``half`` m."""
    ends = [(Fraction(x) - Fraction(half), Fraction(x) + Fraction(half)) for x in LENGTHS]
    return model_for(Problem(load_robot("grab33"), tuple(ends)), (0, 1, 2))


@pytest.fixture(scope="module")
def whole() -> tuple[RealModel, list[RealRoot]]:
    """Return the robot with lengths to 0.1 mm and its roots."""
    real = grab33("0.0001")
    run = RealSearch(real, Budget())
    run.solve()
    assert len(run.roots) >= 7 and not run.pending
    return real, run.roots


def halves(real: RealModel) -> tuple[RealModel, RealModel, Floats]:
    """Return a model with the first length in either half, and the middle of the face between."""
    low, high = real.lengths[:3].copy(), real.lengths[:3].copy()
    face = real.lengths[:3].mean(axis=1)
    low[0, 1] = high[0, 0] = face[0]
    return at_lengths(real, low), at_lengths(real, high), face


def test_a_root_is_joined_with_itself_and_with_no_other(whole: tuple[RealModel, list[RealRoot]]) -> None:
    real, roots = whole
    low, high, face = halves(real)
    first = [[Piece(low, root)] for root in roots]
    second = [[Piece(high, root)] for root in reversed(roots)]
    strands = joined(first, second, face)
    assert strands is not None and len(strands) == len(roots)
    assert all(len(s) == 2 and s[0].root is s[1].root for s in strands)
    assert joined(first[:1], second[:1], face) is None
    assert joined(first[:2], second, face) is None


def test_the_zero_of_a_strand_lies_in_its_piece(whole: tuple[RealModel, list[RealRoot]]) -> None:
    real, roots = whole
    low, high, face = halves(real)
    for root in roots:
        strand = [Piece(low, root), Piece(high, root)]
        for lengths in (face, real.lengths[:3, 0], real.lengths[:3, 1]):
            core = core_at(strand, lengths)
            assert core is not None and lies_in(core, root.unique)


@pytest.mark.parametrize("half", ["0.0005", pytest.param("0.002", marks=pytest.mark.slow)])
def test_strands_follow_the_zero_through_all_parts(
    half: str, whole: tuple[RealModel, list[RealRoot]]
) -> None:
    """What Newton finds for lengths drawn from the ranges lies in the box of their piece."""
    real, rng = grab33(half), np.random.default_rng(7)
    strands = []
    for root in whole[1]:
        strands += strands_in(real, around(root.core.mean(axis=1), root.chart), [], Budget())[0] or []
    assert len(strands) >= 3 and max(map(len, strands)) > 1
    for strand in strands:
        for _ in range(20):
            lengths = rng.uniform(real.lengths[:3, 0], real.lengths[:3, 1])
            own = piece_at(strand, lengths).root
            z, _ = zero_at(real, own.chart, own.box.mean(axis=1), lengths)
            assert z is not None
            assert (own.box[:, 0] - 1e-9 <= z).all() and (z <= own.box[:, 1] + 1e-9).all()


def around(middle: Floats, chart: int) -> Floats:
    """Return a cell a little larger than what a zero moves through."""
    cell = np.zeros((1, REAL_COLUMNS.width))
    cell[0, 0:6:2], cell[0, 1:6:2] = middle[:3] - 0.02, middle[:3] + 0.02
    cell[0, 6:12:2], cell[0, 7:12:2] = middle[3:6] - 0.01, middle[3:6] + 0.01
    cell[0, REAL_COLUMNS.chart] = chart
    cell[0, DENSITIES + 1 : REAL_COLUMNS.share : 2] = np.inf
    return cell


@pytest.mark.slow
def test_no_zero_of_a_cluster_is_lost_where_parts_go_on() -> None:
    """Three zeros in one cluster, some of which are proved for parts that have cells left."""
    run = RealSearch(grab33("0.0001"), Budget())
    run.solve()
    starts = [root.core.mean(axis=1) for root in run.roots if root.chart == 2]
    assert len(starts) == 3
    real = grab33("0.0006")
    strands, _ = strands_in(
        real, np.concatenate([around(z, 2) for z in starts]), [], Budget(cell_limit=400_000)
    )
    assert strands is not None
    middle = real.lengths[:3].mean(axis=1)
    held = [zero_at(real, 2, piece_at(strand, middle).root.box.mean(axis=1), middle)[0] for strand in strands]
    for start in starts:
        exact = zero_at(real, 2, start, middle)[0]
        assert (exact[6:] > 0).all()
        assert any(np.abs(exact - zero).max() < 1e-6 for zero in held)
