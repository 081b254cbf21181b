"""What the proofs of poses on routed cables may not claim."""

from fractions import Fraction as F

import numpy as np
import pytest

from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Robot
from cdpr_interval.robots.pulley import Pulley
from solvers.point_mass.cell_rows import WIDTH
from solvers.point_mass.one_call import anywhere
from solvers.point_mass.routed.balance import prove_balance
from solvers.point_mass.routed.cells import first_cells
from solvers.point_mass.routed.data import routed_mass
from solvers.point_mass.routed.over_ranges import find_all
from solvers.point_mass.routed.pose import Effort, _Hunt, data_for, find_poses

ORIGIN = (F(0), F(0), F(0))


def cable(name, point, pulley=None, k=None):
    elasticity = None if k is None else Elasticity(stiffness=F(k))
    return Cable(name, tuple(map(F, point)), ORIGIN, elasticity=elasticity, pulley=pulley)


def mass_of(*cables, force=ORIGIN, mass=1):
    return routed_mass(loaded(Robot("r", Platform(F(mass)), cables), force))


def exact(*lengths):
    return np.array([(x, x) for x in lengths])


def test_a_load_that_may_pull_the_other_way_hangs_there_too():
    """The middle of the ranges pulls to the right, some choices to the left: no pose may be cut off."""
    mass = mass_of(
        cable("a", (0, 0, 0)),
        cable("b", (4, 0, 0), Pulley(F("0.1"), lead_in=F(1))),
        force=(Range(F(-5), F(100)), F(0), F(0)),
        mass="0.1",
    )
    data = data_for(mass, exact(2.0, 30.0))
    stack = np.empty((8, WIDTH))
    count = first_cells(data, False, stack)
    cells = stack[:count]
    for push in (-5.0, -3.0, 0.0, 50.0, 100.0):
        load = np.array([push, 0.0, -0.980665])
        pose = 2.0 * load / np.linalg.norm(load) / mass.unit
        inside = (cells[:, 0:6:2] <= pose).all(axis=1) & (pose <= cells[:, 1:6:2]).all(axis=1)
        assert inside.any(), push


def passing(k=None):
    """Return a mass on one cable, below its exit, where a slack cable's pulley is in the way at 2 m."""
    return mass_of(
        cable("a", (0, 0, 0), k=k), cable("b", ("-0.05", 0, -2), Pulley(F("0.05"), lead_in=F("0.5")), k)
    )


@pytest.mark.parametrize("k", [None, 1e6])
def test_no_pose_is_proved_inside_the_pulley_of_a_slack_cable(k):
    """At some lengths in the range the mass would hang inside a pulley: then it has no pose."""
    mass = passing(k)
    for middle in (2.0, 2.056, 1.944):
        lengths = np.array([(middle - 0.01, middle + 0.01), (6.0, 6.0)])
        found = find_all(mass, lengths, Effort.of(1.0, 4000))
        assert not (found.complete and found.poses), middle
    found = find_all(mass, exact(2.0, 6.0), Effort.of(3.0, None))
    assert not found.poses
    found = find_all(mass, exact(1.5, 6.0), Effort.of(3.0, None))
    assert len(found.poses) == 1 and found.complete


CUT_PULLEY = Pulley(F("0.5"), F("0.9"), lead_in=F(0))


def at_the_cut(free=0.2):
    """Return the point (u, k) at a distance along the tangent where the angle of a rope is cut."""
    along = np.array([-np.sqrt(0.5), np.sqrt(0.5)])
    touch = np.array([0.9, 0.0]) - 0.5 * np.sqrt(0.5)
    return touch + free * along


def sprung(k, pulley=CUT_PULLEY):
    """Return a mass between three strong springs, and the lengths with which it rests at the cut."""
    s, z = at_the_cut()
    x = np.array([s, 0.0, z])
    points = np.array([(0.0, 4.0, 4.0), (3.0, -3.0, 4.0), (-3.0, -3.0, 4.0), (0.5, 0.0, -5.0)])
    cables = [cable(f"c{i}", p, k=4000) for i, p in enumerate(points)]
    cables.append(cable("p", (0, 0, 0), pulley, k))
    a = (x - points) / np.linalg.norm(x - points, axis=1)[:, None]
    pulls = np.linalg.lstsq(a[:3].T, np.array([0, 0, -9.80665]) - 2000.0 * a[3], rcond=None)[0]
    assert (pulls > 0).all()
    lengths = np.linalg.norm(x - points, axis=1) - np.append(pulls, 2000.0) / 4000
    return mass_of(*cables), exact(*lengths, 1.0), (x - points[0])


def test_a_domain_of_uniqueness_does_not_cross_a_jump_of_length():
    """One turn more or less around the pulley: the mean value theorem ends at the cut."""
    mass, lengths, x = sprung(0.5)
    data = data_for(mass, lengths)
    taut, box, domain = np.empty(1, dtype=np.int64), np.empty((3, 2)), np.empty((3, 2))
    near = x / mass.unit
    cover = np.stack([near - 0.001, near + 0.001], axis=1)
    assert not prove_balance(data, taut, near.copy(), cover, box, domain)
    # Without that rope the same domain is one.
    short = lengths.copy()
    short[4] = 20.0
    assert prove_balance(data_for(mass, short), taut, near.copy(), cover, box, domain)


def test_cells_that_end_small_stay_in_regions_when_the_limit_is_reached():
    """Small undecided cells count as much as those nobody looked at."""
    mass = mass_of(cable("a", (0, 0, 0)), cable("b", (1, 0, 0), Pulley(F("0.1"), lead_in=F(1))))
    data = data_for(mass, exact(1.0, 2.0))
    small = np.array([[0.1, 0.1001, 0.0, 0.0001, -0.5, -0.4999, 0.5]])
    for own in (True, False):
        hunt = _Hunt(mass, data, Effort.of(None, None).budget, 1, None, own)

        def searched(cells, first, smallest, hunt=hunt):
            hunt.rest, hunt.pending = small + 1.0, 1
            hunt.stop = Effort.of(None, 1).budget.stop() or type(hunt.stop)("cell_limit")
            return small

        hunt._search = searched
        hunt.run((False, np.empty(0, dtype=np.int64), np.full((3, 2), np.nan), -1))
        if own:
            assert len(hunt.regions) == 2 and not hunt.pending
            assert any((box[:, 0] == small[0, 0:6:2]).all() for box in hunt.regions)
        else:
            assert hunt.pending == 2


def test_a_pose_that_leaves_inward_is_not_called_stable_by_convexity():
    """Under a pulley, nearer to its axis than the rope leaves: springs hold the mass there."""
    pulley = Pulley(F("0.4"), lead_in=F(1))
    points = np.array([(2.0, 0.0, -6.0), (-1.0, 2.0, -6.0), (-1.0, -2.0, -6.0)])
    x = np.array([0.3, 0.0, -3.0])
    a = (x - points) / np.linalg.norm(x - points, axis=1)[:, None]
    cables = [cable(f"c{i}", p, k=500) for i, p in enumerate(points)]
    cables.append(cable("p", (0, 0, 0), pulley, 500))
    mass = mass_of(*cables)
    lengths = np.append(np.linalg.norm(x - points, axis=1) - 0.2, 3.0)
    found = find_poses(mass, np.stack([lengths, lengths], axis=1), Effort.of(3.0, None))
    assert a.shape == (3, 3)
    for fields, stability in zip(found.poses, found.stability, strict=True):
        across = np.hypot(*fields.position[:2].mean(axis=1))
        if across < 0.8:
            assert stability is Stability.UNDECIDED and not found.by_convexity


def test_nothing_is_asked_of_a_cover_without_sides():
    assert (anywhere(2)[:, 0] == np.inf).all()
