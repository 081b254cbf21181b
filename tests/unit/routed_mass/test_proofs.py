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
from solvers.point_mass.one_call import UNCLEAR, anywhere
from solvers.routed_mass.balance import prove_balance
from solvers.routed_mass.cells import first_cells
from solvers.routed_mass.data import routed_mass
from solvers.routed_mass.over_ranges import find_all
from solvers.routed_mass.pose import Effort, _Hunt, data_for, quick_pose
from tests.support.routed_robots import Line, Made, way

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
    found = find_all(mass, exact(2.0, 6.0), Effort.of(None, None))
    assert not found.poses
    found = find_all(mass, exact(1.5, 6.0), Effort.of(None, None))
    assert len(found.poses) == 1 and found.complete


@pytest.mark.parametrize(
    ("beyond", "half", "proved"), [(1e-3, 0.0, True), (-1e-3, 0.0, False), (0.0, 2e-4, False)]
)
def test_nor_where_a_slack_rope_has_lifted_off(beyond, half, proved):
    """Below the arm the rope of a slack cable runs past its pulley, whose rim some lengths lead across."""
    points = [(np.cos(t), np.sin(t), 2.0) for t in (0.3, 2.4, 4.5)]
    pulley = Pulley(F("0.1"), F("0.3"), lead_in=F("0.5"))
    mass = mass_of(cable("p", (0, 0, 0), pulley), *(cable(f"c{i}", p) for i, p in enumerate(points)))
    turn = np.radians(205)
    x = np.array([0.3 + (0.1 + beyond) * np.cos(turn), 0.0, (0.1 + beyond) * np.sin(turn)])
    distances = np.linalg.norm(x - np.array(points), axis=1)
    lengths = np.array([(10.0, 10.0), *((d - half, d + half) for d in distances)])
    status, _, _ = quick_pose(mass, lengths)
    assert (status != UNCLEAR) == proved


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


def pulled(x, load_share, k=400):
    """Return a mass under a pulley that rests at x, nearer to the axis than the rope leaves."""
    line = Line("one", np.zeros(3), radius=0.4, arm=0.4, lead=1.0, k=k)
    length, along = way(line, np.array(x))
    points = np.array([(2.0, 0.0, -6.0), (-1.0, 2.0, -6.0), (-1.0, -2.0, -6.0)])
    lines = [line, *(Line("fixed", p, k=k) for p in points)]
    away = np.array(x) - points
    sizes = np.linalg.norm(away, axis=1)
    pulls = load_share * np.array([30.0, 30.0, 30.0])
    load = 40.0 * along + pulls @ (away / sizes[:, None])
    return Made(lines, load, np.append(length - 40.0 / k, sizes - pulls / k), np.array(x))


def stability_at(made):
    """Return what is said of the pose that a robot was made for."""
    found = find_all(made.mass(), made.bounds(), Effort.of(None, None))
    said = [
        (stability, found.by_convexity)
        for fields, stability in zip(found.poses, found.stability, strict=True)
        if (np.abs(fields.position.mean(axis=1) - made.pose) < 1e-6).all()
    ]
    assert len(said) == 1
    return said[0]


def curvatures(made):
    """Return the eigenvalues of the energy's second derivative at the pose, by differences."""
    columns = []
    for j in range(3):
        step = np.eye(3)[j] * 1e-6
        columns.append((made.forces(made.pose + step)[0] - made.forces(made.pose - step)[0]) / 2e-6)
    return np.linalg.eigvalsh(0.5 * (np.array(columns) + np.array(columns).T))


@pytest.mark.parametrize(("share", "k"), [(1.0, 400), (0.005, 40)])
def test_a_rope_that_leaves_inward_is_stable_only_by_its_curvature(share, k):
    """Under a pulley, nearer to its axis than the rope leaves: convexity says nothing."""
    made = pulled((0.3, 0.0, -3.0), share, k)
    stability, by_convexity = stability_at(made)
    assert not by_convexity
    assert (stability is Stability.STABLE) == (curvatures(made)[0] > 0)


def test_a_mass_that_leans_inward_alone_is_not_stable():
    """A push towards the axis balances it; turned about the axis a little it runs away."""
    line = Line("one", np.zeros(3), radius=0.4, arm=0.4, lead=1.0, k=500.0)
    x = np.array([0.3, 0.1, -3.0])
    length, along = way(line, x)
    made = Made([line], 30.0 * along, np.array([length - 30.0 / 500.0]), x)
    assert curvatures(made)[0] < 0
    found = find_all(made.mass(), made.bounds(), Effort.of(None, None))
    inside = [
        stability
        for fields, stability in zip(found.poses, found.stability, strict=True)
        if (np.abs(fields.position.mean(axis=1) - x) < 1e-6).all()
    ]
    assert inside == [Stability.UNDECIDED]


def test_nothing_is_asked_of_a_cover_without_sides():
    assert (anywhere(2)[:, 0] == np.inf).all()


@pytest.mark.parametrize("spring", [0.0, 300.0])
def test_more_tight_cables_than_needed_leave_a_narrow_box(spring):
    """Lengths of four or five tight cables up to rounding: one pose, as sharp as three lengths make it."""
    x = np.array([0.3, -0.4, 1.0])
    corners = [(2.0, 2.0, 5.0), (2.0, -2.0, 5.0), (-2.0, -2.0, 5.0), (-2.0, 2.0, 5.0)]
    lines = [Line("one", np.array(p), radius=0.05, arm=0.1, lead=0.5) for p in corners]
    lines.append(Line("fixed", np.array([0.0, 0.0, 6.0]), k=spring))
    ways = [way(line, x) for line in lines]
    lengths = np.array([one[0] for one in ways])
    if spring:
        lengths[4] -= 0.02
    made = Made(lines, np.array([0.0, 0.0, -50.0]), lengths, x)
    found = find_all(made.mass(), made.bounds(), Effort.of(None, None))
    assert found.complete and len(found.poses) == 1
    (fields,) = found.poses
    lo, hi = fields.position.T
    assert (lo - 1e-12 <= x).all() and (x <= hi + 1e-12).all()
    assert (hi - lo < 1e-10).all()
    assert "tensions may not be unique" in fields.note
    # Tensions that a linear program finds lie in the bounds.
    along = np.array([one[1] for one in ways])
    pull = spring * 0.02
    rest = made.load - pull * along[4]
    for left_out in range(4):
        three = [i for i in range(4) if i != left_out]
        t = np.linalg.solve(along[three].T, rest)
        if (t >= 0).all():
            for i, tension in zip(three, t, strict=True):
                assert fields.tensions[i, 0] - 1e-6 <= tension <= fields.tensions[i, 1] + 1e-6
