"""Which roots are compared at all: what is skipped would not have been merged."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np

from cdpr_interval import load_robot
from cdpr_interval.engine.budget import Budget
from cdpr_interval.exact import balls
from cdpr_interval.mechanics.six_dof.frame import Frame, lies_in, pose_of
from solvers.questions.problem import Options, Problem
from solvers.six_dof.merge import distinct, may_coincide
from solvers.six_dof.prepared import lengths_of, prepared
from solvers.six_dof.reduction import reduced_problems
from solvers.six_dof.roots import Root
from solvers.six_dof.subset_search import SubsetSearch


def found(width: str) -> tuple[list[Root], Frame]:
    """Return the roots of UC3 in all charts, before they are merged, and the frame of their search."""
    ranges = tuple((Fraction(x), Fraction(x) + Fraction(width)) for x in ("7.5", "8", "7"))
    problem = Problem(load_robot("uc3"), ranges)
    (reduced,) = reduced_problems(prepared(problem), lengths_of(problem), Options(), (0, 1, 2))
    search = SubsetSearch(reduced.model, reduced.reduction, Budget(cell_limit=60_000))
    search.solve()
    return search.roots, reduced.frame


def test_pairs_that_are_skipped_would_not_be_merged() -> None:
    for width in ("0", "1e-5"):
        roots, frame = found(width)
        # The same poses again, and beside their uniqueness boxes.
        moved = [replace(r, core=r.core + 3.0 * np.ptp(r.unique, axis=1)[:, None]) for r in roots]
        everyone = [*roots, *roots, *moved]
        candidates = may_coincide(everyone)
        with balls.precision():
            for i, root in enumerate(everyone):
                pose = pose_of(replace(root, box=root.core), frame)
                inside = [lies_in(pose, frame, other) for other in everyone]
                assert not np.any(np.array(inside) & ~candidates[i])
            assert 0 < candidates.sum() < candidates.size
            # One root may have a negative tension.
            assert len(distinct([*roots, *roots], frame)) == len(distinct(roots, frame)) >= 14


def test_no_roots() -> None:
    assert may_coincide([]).shape == (0, 0)
