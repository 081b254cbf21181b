"""More than six taut cables, of which some stretch and some do not."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.engine.budget import Budget
from cdpr_interval.mechanics.orientation import quaternion_from_rotation
from cdpr_interval.mechanics.rotation import chart_of
from cdpr_interval.robots.cable_robot import Elasticity
from solvers import forward_kinematics
from solvers.six_dof.real.build import RealCable, build
from solvers.six_dof.real.columns import DENSITIES, REAL_COLUMNS
from solvers.six_dof.real.subset import RealSearch
from tests.support.planted.pulleys import exact, plant

STRAIN = 0.01


@pytest.mark.parametrize("elastic", [(0,), (8,)])
def test_nine_cables_of_which_any_one_stretches_get_an_answer(elastic: tuple[int, ...]) -> None:
    """Whichever it is, in front of the others or behind them."""
    robot = load_robot("cogiro")
    first = robot.cables[0]
    more = replace(first, name="ninth", frame_anchor=(Fraction(0), Fraction(0), Fraction(6)))
    spring = Elasticity(axial_stiffness=Fraction(100_000))
    cables = (*robot.cables, more)
    cables = tuple(replace(c, elasticity=spring) if i in elastic else c for i, c in enumerate(cables))
    result = forward_kinematics(replace(robot, cables=cables), [8.0] * 9, cell_limit=1)
    assert result.undecided or result.pending


@pytest.mark.parametrize(("count", "rigid"), [(6, 3), (7, 0), (7, 1), (7, 3), (8, 0), (8, 1), (8, 3), (8, 6)])
@pytest.mark.parametrize("seed", range(2))
def test_a_small_cell_around_a_pose_is_settled(seed: int, count: int, rigid: int) -> None:
    """Also where the balance of forces alone does not bound the tensions."""
    planted = plant(seed, count)
    cables = []
    for i in range(count):
        cable, length, tension = planted.cables[i], float(planted.lengths[i]), float(planted.tensions[i])
        stretch = 0.0 if i < rigid else length * STRAIN / (1.0 + STRAIN)
        own = Fraction(length - stretch)
        compliance = Fraction(stretch / tension)
        cables.append(
            RealCable(
                exact(cable.exit),
                exact(planted.arms[i]),
                (own, own),
                Fraction(cable.radius),
                Fraction(cable.arm),
                exact(cable.axis),
                Fraction(cable.lead_in),
                compliance=(compliance, compliance),
            )
        )
    run = RealSearch(build(cables, exact(planted.load), count), Budget(None, 200_000))
    chart, u = chart_of(quaternion_from_rotation(planted.rotation))
    cell = np.zeros((1, REAL_COLUMNS.width))
    cell[0, 0:6:2], cell[0, 1:6:2] = np.array(u) - 0.02, np.array(u) + 0.021
    cell[0, 6:12:2], cell[0, 7:12:2] = planted.position - 0.02, planted.position + 0.021
    cell[0, REAL_COLUMNS.chart] = chart
    cell[0, DENSITIES + 1 : REAL_COLUMNS.share : 2] = np.inf
    run.solve(cell)
    assert len(run.roots) == 1
    assert not run.pending and not len(run.undecided)


def test_a_search_needs_stretching_cables_behind_the_sixth() -> None:
    real = plant(0, 7).real([1e-3] * 6 + [0.0])
    with pytest.raises(ValueError, match="must stretch"):
        RealSearch(real, Budget())
