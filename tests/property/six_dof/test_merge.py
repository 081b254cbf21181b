"""Which roots are compared at all: what is skipped would not have been merged."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.engine.budget import Budget
from cdpr_interval.exact import balls
from cdpr_interval.mechanics.six_dof.frame import Frame
from cdpr_interval.robots.formats.reader import parse_robot
from solvers import forward_kinematics
from solvers.questions.problem import Options, Problem
from solvers.six_dof.cells.merge import distinct, may_coincide
from solvers.six_dof.cells.roots import Root, lies_in, pose_of
from solvers.six_dof.cells.subset_search import SubsetSearch
from solvers.six_dof.prepared import lengths_of
from solvers.six_dof.reduction import reduced_problems


def found(width: str) -> tuple[list[Root], Frame]:
    """Return the roots of UC3 in all charts, before they are merged, and the frame of their search."""
    ranges = tuple((Fraction(x), Fraction(x) + Fraction(width)) for x in ("7.5", "8", "7"))
    problem = Problem(load_robot("uc3"), ranges)
    (reduced,) = reduced_problems(problem.loaded, lengths_of(problem), Options(), (0, 1, 2))
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
            assert len(distinct([*roots, *roots])) == len(distinct(roots)) >= 14


def test_no_roots() -> None:
    assert may_coincide([]).shape == (0, 0)


HEAD = b"format: cdpr-robot/1\nname: family\nplatform: {mass_kg: 1}\ncables:\n"
ROD = parse_robot(
    HEAD.replace(b"platform:", b"gravity_m_s2: [-6.89, -10.99, 3.04]\nplatform:")
    + b"  - {name: c1, frame_anchor_m: [0.11, 1.732, 1.639], platform_anchor_m: [-0.2, 0.2, -0.6]}\n"
    b"  - {name: c2, frame_anchor_m: [0.11, 1.898, 1.639], platform_anchor_m: [0.1, -0.1, 0.3]}\n"
    b"  - {name: c3, frame_anchor_m: [0.11, 1.596, 1.639], platform_anchor_m: [0.3, -0.3, 0.9]}\n"
)
VERTICAL = parse_robot(
    HEAD
    + b"  - {name: c1, frame_anchor_m: [0.5, 0.25, 1.58], platform_anchor_m: [-0.15431, 0.23042, 0.12367]}\n"
    b"  - {name: c2, frame_anchor_m: [0.5, 0.25, 2.4], platform_anchor_m: [-0.32099, -0.05827, -0.43263]}\n"
    b"  - {name: c3, frame_anchor_m: [0.5, 0.25, 2.74], platform_anchor_m: [0.42053, 0.02957, -0.09317]}\n"
)


@pytest.mark.parametrize(
    "robot, lengths, rods",
    [(ROD, ["2.9605", "2.6029", "2.1755"], True), (VERTICAL, ["1.7729", "2.9467", "2.8822"], False)],
)
def test_a_family_at_the_border_of_two_charts_is_listed_once(robot, lengths, rods):
    """At the border each chart shows another pose of the family, and a box may reach over the border."""
    solved = forward_kinematics(robot, lengths)
    families = [s for s in solved.solutions if len(s.taut) == 3]
    assert len(families) == 2
    axis = [float(x) for x in robot.cables[0].platform_anchor]
    # What turning in the family leaves as it is: the rod's direction, or the heights of the platform's axes.
    kept = [s.rotation.mean(axis=2) @ axis if rods else s.rotation.mean(axis=2)[2] for s in families]
    assert not np.allclose(kept[0], kept[1], atol=1e-6)
