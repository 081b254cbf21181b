"""What a tracker claims, against exact poses and against the complete lists of forward kinematics."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np
import pytest
from flint import arb, ctx

from cdpr_interval import load_robot
from cdpr_interval.engine import krawczyk
from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.mechanics.rotation import chart_of, quaternion_of, rotation_interval
from cdpr_interval.mechanics.six_dof import system as newton
from solvers import forward_kinematics
from solvers.six_dof import track as pt
from solvers.six_dof.cells.roots import GENERAL, GEOMETRY, system_of
from solvers.six_dof.prepared import cables_of as report_cables
from solvers.six_dof.tracker import Tracker as FollowingTracker
from solvers.six_dof.tracker import charts_of
from tests.support.kernel_callers import Callers
from tests.support.planted.platform import Planted as PlantedRobot
from tests.support.planted.platform import plant as plant_robot
from tests.support.planted_platform import (
    HALF_TURN_SIGNS,
    Planted,
    apply,
    cayley,
    dot,
    fraction,
    minus,
    plant,
    quaternion_product,
    root_range,
    unit_quaternion,
)
from tests.support.tracked_region import check_alone, depth, is_finite, moved, start_at, widest

called = Callers(krawczyk, pt)
Tracker = partial(FollowingTracker, follow=False)
"""What is proved here is proved by a region alone; `test_continuation` has the rest."""
TAUT = (2, 3, 4, 5, 6)
every_count = pytest.mark.parametrize("n", TAUT)


def lower_tangent(x: Fraction) -> Fraction:
    """Return a double just below tan(x)."""
    before = ctx.prec
    ctx.prec = 128
    try:
        value = float((arb(x.numerator) / x.denominator).tan().lower())
    finally:
        ctx.prec = before
    return Fraction(value) * (1 - Fraction(1, 2**52))


def exact_root(x: Fraction) -> Fraction:
    """Return a fraction just above the square root of x."""
    return Fraction(math.isqrt((x * 4**80).__floor__()) + 1, 2**80)


def random_reference(rng: random.Random) -> tuple[Any, float, float]:
    """Return z, a radius and a size; sometimes u lies on an axis."""
    n = rng.choice(TAUT)
    z = np.array([rng.uniform(-1.2, 1.2) for _ in range(3)] + [rng.uniform(-9, 9) for _ in range(3 + n)])
    if rng.random() < 0.4:
        z[:3] = 0.0
        z[rng.randrange(3)] = rng.uniform(-1.2, 1.2)
    size = 2.0 ** rng.randint(-3, 4)
    return z, size * rng.choice([0.3, 0.125, 1e-2, 1e-5, 1e-9]) * rng.uniform(0.3, 1.0), size


def turn_within(rng: random.Random, u: Sequence[Fraction], tangent: Fraction) -> list[Fraction]:
    """Return a Rodrigues vector of norm nearly ``tangent``, mostly: along u, along an axis, or anywhere."""
    kind = rng.randrange(3)
    v = [fraction(rng, -1, 1) for _ in range(3)]
    if kind == 0 and any(u):
        v = list(u)
    elif kind == 1:
        v = [Fraction(int(k == rng.randrange(3))) for k in range(3)]
    if not any(v):
        v = [Fraction(1), Fraction(0), Fraction(0)]
    share = rng.choice([Fraction(-1), Fraction(1), fraction(rng, -1, 1)])
    scale = share * tangent / exact_root(dot(v, v))
    return [x * scale for x in v]


def turned_by(v: Sequence[Fraction], u: Sequence[Fraction]) -> list[Fraction]:
    """Return u' with R(u') = V R(u), from the product of the quaternions."""
    q = quaternion_product([Fraction(1), *v], [Fraction(1), *u])
    return [x / q[0] for x in q[1:]]


def shift_within(rng: random.Random, radius: Fraction) -> list[Fraction]:
    """Return a vector of norm at most ``radius``, often just that, along an axis too."""
    return turn_within(rng, [Fraction(0)] * 3, radius)


def contains(bounds: Any, values: Sequence[Fraction]) -> bool:
    return all(lo <= x <= hi for (lo, hi), x in zip(np.asarray(bounds).tolist(), values, strict=True))


def test_region_holds_every_pose_within_radius_and_angle() -> None:
    rng = random.Random(11)
    seen = 0
    for _ in range(600):
        z, radius, size = random_reference(rng)
        X = np.empty((len(z), 2))
        if not pt.region(z, radius, size, X):
            continue
        seen += 1
        u, p = [Fraction(x) for x in z[:3]], [Fraction(x) for x in z[3:6]]
        tangent = lower_tangent(Fraction(radius) / Fraction(size) / 2)
        for _ in range(4):
            assert contains(X[:3], turned_by(turn_within(rng, u, tangent), u))
            shift = shift_within(rng, Fraction(radius))
            assert contains(X[3:6], [a + b for a, b in zip(p, shift, strict=True)])
        for k in range(3):
            # The very ends along an axis.
            assert X[3 + k, 0] <= p[k] - Fraction(radius) and p[k] + Fraction(radius) <= X[3 + k, 1]
    assert seen > 400


def test_region_refuses_rotations_near_the_end_of_the_chart() -> None:
    X = np.empty((8, 2))
    z = np.array([4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0])
    assert not pt.region(z, 0.5, 1.0, X)
    assert not pt.region(z, 3.0, 1.0, X)
    assert not pt.region(z * np.nan, 0.1, 1.0, X)
    assert pt.region(z, 0.05, 1.0, X)


def test_a_box_is_held_only_when_all_its_poses_are_within_radius_and_angle() -> None:
    rng = random.Random(12)
    answers = []
    for _ in range(600):
        z, radius, size = random_reference(rng)
        u, p = [Fraction(x) for x in z[:3]], [Fraction(x) for x in z[3:6]]
        tangent = lower_tangent(Fraction(radius) / Fraction(size) / 2)
        much = rng.choice([Fraction(1, 2), Fraction(9999, 10_000), Fraction(10_001, 10_000), Fraction(3, 2)])
        v = turn_within(rng, u, tangent * much)
        shift = shift_within(rng, Fraction(radius) * (much if rng.random() < 0.5 else Fraction(1, 2)))
        inside = dot(v, v) <= tangent**2 and dot(shift, shift) <= Fraction(radius) ** 2
        clearly = (
            dot(v, v) <= (tangent * 9999 / 10_000) ** 2
            and dot(shift, shift) <= (Fraction(radius) * 9999 / 10_000) ** 2
        )
        values = [*turned_by(v, u), *(a + b for a, b in zip(p, shift, strict=True))]
        box = np.array([enclose(x) for x in values])
        # A corner that is the pose itself: what is held must hold it.
        wide = rng.random() < 0.3
        if wide:
            box[:, 0] -= radius / size * 1e-7
        held = pt.holds(z, box, radius, size)
        assert not held or inside
        assert held or not clearly or wide or radius < 1e-8 * size
        answers.append(held)
    assert 100 < sum(answers) < 500
    box[0, 0] = np.nan
    assert not pt.holds(z, box, radius, size)


@pytest.mark.parametrize("where", range(6))
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_nothing_that_is_no_number_is_held(where: int, value: float) -> None:
    z = np.array([0.1, 0.2, -0.3, 1.0, 2.0, 3.0])
    box = np.stack([z, z], axis=-1)
    assert pt.holds(z, box, 0.1, 1.0)
    box[where] = value
    assert not pt.holds(z, box, 0.1, 1.0)


# Kernels on planted platforms.


def cables_of(robot: Planted) -> Any:
    """Return the arrays of a planted platform in its chart, and the load."""
    signs = HALF_TURN_SIGNS[robot.chart]
    rows = [
        [enclose(x) for x in a] + [enclose(s * x) for s, x in zip(signs, b, strict=True)]
        for a, b in zip(robot.anchors, robot.points, strict=True)
    ]
    return np.array(rows), np.array([enclose(x) for x in robot.load])


def lengths_of(robot: Planted, longer: float = 0.1, width: float = 0.0) -> Any:
    """Return the exact lengths of the taut cables in bounds, the others longer."""
    rows = []
    for i, square in enumerate(robot.lengths_sq):
        r = root_range(square)
        lo, hi = enclose(r.lo)[0], enclose(r.hi)[1]
        rows.append((lo - width, hi + width) if i < robot.n else (lo + longer, hi + longer))
    return np.array(rows)


def reference_near(rng: random.Random, robot: Planted, radius: float, size: float) -> Any:
    """Return z (6 + n,) of a pose around which the planted one is in the region; t as planted."""
    tangent = lower_tangent(Fraction(radius) / Fraction(size) / 2) * Fraction(999, 1000)
    u = turned_by(turn_within(rng, robot.u, tangent), robot.u)
    shift = shift_within(rng, Fraction(radius) * Fraction(999, 1000))
    p = [a + b for a, b in zip(robot.p, shift, strict=True)]
    return np.array([float(x) for x in [*u, *p, *robot.t]])


def exact_distance_sq(robot: Planted, i: int, u: Sequence[Fraction], p: Sequence[Fraction]) -> Fraction:
    e = minus(robot.centre(u, i), p)
    return dot(e, e)


def planted(seed: int, n: int, count: int, slack: int = 0) -> list[Planted]:
    rng = random.Random(1000 * seed + n)
    return [plant(rng, n, slack=slack) for _ in range(count)]


def squares(data: Any, robot: Planted) -> None:
    """Check the squares of the lengths and the entries of ``fill_data``."""
    for i in range(robot.n):
        assert contains(data[i, :3], robot.anchors[i])
        signs = HALF_TURN_SIGNS[robot.chart]
        assert contains(data[i, 3:6], [s * x for s, x in zip(signs, robot.points[i], strict=True)])
        assert contains(data[i, 6:7], [robot.lengths_sq[i]])
    assert contains(data[robot.n, :3], robot.load)


@every_count
def test_data_enclose_the_exact_ones(n: int) -> None:
    for robot in planted(1, n, 4, slack=1):
        cables, load = cables_of(robot)
        data = np.empty((n + 1, 7, 2))
        pt.fill_data(cables, load, lengths_of(robot), np.arange(n), data)
        squares(data, robot)
        wide = np.empty((n + 1, 7, 2))
        pt.fill_data(cables, load, lengths_of(robot, width=0.01), np.arange(n), wide)
        assert np.all(wide[:n, 6, 0] < data[:n, 6, 0]) and np.all(wide[:n, 6, 1] > data[:n, 6, 1])


@every_count
def test_tensions_hold_the_planted_ones(n: int) -> None:
    rng = random.Random(21)
    done = 0
    for robot in planted(2, n, 6):
        cables, load = cables_of(robot)
        data = np.empty((n + 1, 7, 2))
        pt.fill_data(cables, load, lengths_of(robot), np.arange(n), data)
        for radius in (1e-2, 1e-3, 1e-6, 1e-10):
            z = reference_near(rng, robot, radius, 0.5)
            X, T = np.empty((6 + n, 2)), np.empty((n, 1, 2))
            R, slopes = np.empty((3, 3, 2)), np.empty((3, 3, 3, 2))
            X[6:] = 0.0
            assert pt.region(z, radius, 0.5, X)
            rotation_interval(X, R, slopes)
            if pt.tensions(data, R, X, 0.5, T):
                done += 1
                assert contains(T[:, 0], robot.t)
                assert radius > 1e-9 or np.all(np.ptp(T[:, 0], axis=-1) < 1e-3)
    assert done >= 12


@every_count
def test_a_cable_is_only_called_slack_where_it_is_everywhere(n: int) -> None:
    rng = random.Random(22)
    slack, tight = 0, 0
    for robot in planted(3, n, 6, slack=3):
        cables, load = cables_of(robot)
        others = np.array([n, n + 1, n + 2])
        for _ in range(12):
            radius = rng.choice([0.1, 1e-3, 1e-9])
            z = reference_near(rng, robot, radius, 0.5)
            X, R, slopes = np.empty((6 + n, 2)), np.empty((3, 3, 2)), np.empty((3, 3, 3, 2))
            X[6:] = 0.0
            assert pt.region(z, radius, 0.5, X)
            rotation_interval(X, R, slopes)
            u, p = [Fraction(x) for x in z[:3]], [Fraction(x) for x in z[3:6]]
            # How long the cables are at the planted pose, and a bit more.
            more = radius * rng.choice([-1.0, 0.0, 1e-9, 0.5, 3.0, 30.0])
            lengths = lengths_of(robot, longer=10.0)
            own = rng.choice(others)
            root = exact_root(robot.lengths_sq[own])
            lengths[own] = enclose(root)[0] + more, enclose(root)[1] + more + 5.0
            far = np.empty((4, 7, 2))
            pt.fill_data(cables, load, lengths, others, far)
            found = pt.tight_cable(far, R, X)
            assert found in (-1, own - n)
            reach = exact_distance_sq(robot, own, robot.u, robot.p)
            if found == -1:
                slack += 1
                assert reach < Fraction(lengths[own, 0]) ** 2
                tangent = lower_tangent(Fraction(radius))
                for _ in range(4):
                    pose = turned_by(turn_within(rng, u, tangent), u)
                    shift = shift_within(rng, Fraction(radius))
                    at = [a + b for a, b in zip(p, shift, strict=True)]
                    assert exact_distance_sq(robot, own, pose, at) < Fraction(lengths[own, 0]) ** 2
            else:
                tight += 1
                assert more < 5.0 * radius
    assert slack > 10 and tight > 10


def krawczyk_parts(robot: Planted, z: Any, lengths: Any, X: Any) -> tuple[Any, ...]:
    """Return the data, f, E, rows, free and C of one planted platform over X."""
    cables, load = cables_of(robot)
    n = robot.n
    data = np.empty((n + 1, 7, 2))
    pt.fill_data(cables, load, lengths, np.arange(n), data)
    system = system_of(GEOMETRY if n == 6 else GENERAL, n)
    rows, free = system.rows, system.free[0].copy()
    m = len(free)
    C, E, f, J = np.empty((m, m)), np.empty((m, m, 2)), np.empty((m, 2)), np.empty((m, m, 2))
    thin = np.stack([z, z], axis=-1)
    newton.jacobian_over(data, rows, free, thin, f, J)
    assert called.preconditioner(J, C)
    newton.residual_at(data, rows, thin, f)
    newton.krawczyk_matrix(data, rows, free, C, X, E)
    return data, f, E, rows, free, C


def exact_z(robot: Planted) -> list[Fraction]:
    return [*robot.u, *robot.p, *(robot.t if robot.n < 6 else [Fraction(0)] * 6)]


@every_count
def test_the_box_around_a_root_holds_it_and_lies_in_the_region(n: int) -> None:
    rng = random.Random(23)
    done = 0
    for robot in planted(4, n, 5):
        for width, half in ((0.0, 1e-3), (0.0, 1e-4), (1e-8, 1e-4), (1e-6, 1e-3), (1e-6, 1e-4)):
            exact = exact_z(robot)
            z = np.array([float(x) for x in exact]) + 1e-9 * np.array([rng.uniform(-1, 1) for _ in exact])
            if n == 6:
                z[6:] = 0.0
            most = np.array([half] * 6 + [30.0 * half] * n)
            X = np.stack([z - most, z + most], axis=-1)
            data, f, E, rows, free, C = krawczyk_parts(robot, z, lengths_of(robot, width=width), X)
            box = np.stack([z, z], axis=-1)
            if not (pt.lone(E, free, X) and pt.box_around(f, E, free, C, z, X, box)):
                continue
            done += 1
            assert contains(box, exact)
            assert np.all(X[:, 0] <= box[:, 0]) and np.all(box[:, 1] <= X[:, 1])
            # What E was not made for is refused, in every unknown, on either side.
            for k in free:
                for side, sign in ((0, -1.0), (1, 1.0)):
                    tight = X.copy()
                    tight[k, side] = z[k] + sign * 0.3 * abs(box[k, side] - z[k])
                    assert not pt.box_around(f, E, free, C, z, tight, box.copy())
                    tight[k, side] = np.nan
                    assert not pt.box_around(f, E, free, C, z, tight, box.copy())
            pt.contract(data, rows, free, C, box)
            assert contains(box, exact)
    assert done >= 5


def test_no_box_without_a_contraction() -> None:
    m = 6
    free, z = np.arange(m), np.zeros(6)
    f, C, X, box = np.full((m, 2), 1e-9), np.eye(m), np.empty((6, 2)), np.empty((6, 2))
    X[:, 0], X[:, 1] = -1.0, 1.0
    E = np.zeros((m, m, 2))
    assert pt.box_around(f, E, free, C, z, X, box)
    assert np.all(box[:, 0] <= -1e-9)
    for entry in ((-1.0, 1.0), (1.0, 1.0), (-1.0, -0.5), (np.nan, np.nan), (-np.inf, np.inf)):
        E[2, 2] = entry
        assert not pt.box_around(f, E, free, C, z, X, box)
    E[2, 2] = 0.0
    for residual in (np.nan, np.inf, 2.0):
        f[3] = residual
        assert not pt.box_around(f, E, free, C, z, X, box)


def run_track(
    robot: Planted, z: Any, lengths: Any, radius: float, size: float = 0.5, last: int = 10
) -> tuple[int, int, int, Any]:
    """Track a planted platform from z; return status, halvings, cable and box."""
    cables, load = cables_of(robot)
    n = robot.n
    system = system_of(GEOMETRY if n == 6 else GENERAL, n)
    root, box = np.empty(6 + n), np.empty((6 + n, 2))
    taut, others = np.arange(n), np.arange(n, len(robot.anchors))
    z = z.copy()
    if n == 6:
        z[6:] = 0.0
    order, regions = np.concatenate([taut, others]), np.array((size, radius, 0.0, last))
    free = system.free[0].copy()
    return *pt.track(cables, load, lengths, order, system.rows, free, regions, z, root, box), box


@every_count
@pytest.mark.parametrize("width", [0.0, 1e-6])
def test_a_planted_pose_is_tracked_into_its_box(n: int, width: float) -> None:
    rng = random.Random(25)
    tracked = 0
    for robot in planted(5, n, 10, slack=2):
        for radius in (1e-2, 1e-3, 1e-4):
            z = reference_near(rng, robot, radius * rng.choice([0.01, 0.3, 1.0]), 0.5)
            status, k, cable, box = run_track(robot, z, lengths_of(robot, 0.3, width), radius)
            if status != pt.TRACKED:
                continue
            tracked += 1
            assert cable == -1
            own = [*robot.u, *robot.p]
            # The planted pose is static for some lengths in the ranges: it is the tracked one or far away.
            tangent = lower_tangent(Fraction(radius) / 2**k / Fraction(1))
            u0 = [-Fraction(x) for x in z[:3]]
            q = quaternion_product([Fraction(1), *robot.u], [Fraction(1), *u0])
            shift = minus(robot.p, [Fraction(x) for x in z[3:6]])
            near = dot(q[1:], q[1:]) <= (tangent * q[0]) ** 2
            near = near and dot(shift, shift) <= (Fraction(radius) / 2**k) ** 2
            if width == 0.0:
                assert near
            if near:
                assert contains(box[:6], own)
                assert n == 6 or contains(box[6:], robot.t)
            assert pt.holds(z, box, radius * 0.5**k, 0.5)
    assert tracked >= (3 if width else 8)


@pytest.mark.parametrize("n", TAUT[1:])
def test_a_tension_that_may_be_zero_is_never_tracked(n: int) -> None:
    rng = random.Random(26)
    for _ in range(4):
        robot = plant(rng, n, zero_tension=True)
        for radius in (1e-2, 1e-4, 1e-8):
            z = reference_near(rng, robot, radius, 0.5)
            status, _, cable, _ = run_track(robot, z, lengths_of(robot), radius)
            assert status != pt.TRACKED
            assert status != pt.LOOSE or cable == n - 1


@every_count
def test_a_cable_just_tight_is_never_tracked_as_slack(n: int) -> None:
    rng = random.Random(27)
    for robot in planted(6, n, 4, slack=2):
        for radius in (1e-2, 1e-4, 1e-8):
            z = reference_near(rng, robot, radius, 0.5)
            lengths = lengths_of(robot, 5.0)
            lengths[n + 1] = lengths_of(robot, 0.0)[n + 1]
            status, _, cable, _ = run_track(robot, z, lengths, radius)
            assert status != pt.TRACKED
            assert cable == n + 1 or status in (pt.MOVED, pt.NO_ROOT)


@every_count
def test_what_is_no_number_is_never_tracked(n: int) -> None:
    (robot,) = planted(7, n, 1, slack=1)
    z = np.array([float(x) for x in [*robot.u, *robot.p, *robot.t]])
    lengths = lengths_of(robot)
    assert run_track(robot, z, lengths, 1e-4)[0] == pt.TRACKED
    for value in (np.nan, np.inf, -np.inf, 1e300):
        for k in range(6 if n == 6 else 6 + n):
            bad = z.copy()
            bad[k] = value
            status, _, _, box = run_track(robot, bad, lengths, 1e-4)
            assert status != pt.TRACKED or (k >= 6 and contains(box[:6], [*robot.u, *robot.p]))
    for value in (np.nan, np.inf, 1e200):
        for i in range(n + 1):
            bad = lengths.copy()
            bad[i, 1] = value
            assert run_track(robot, z, bad, 1e-4)[0] != pt.TRACKED or i == n
            bad[i, 0] = value
            assert run_track(robot, z, bad, 1e-4)[0] != pt.TRACKED or (i == n and value > 1.0)


@pytest.mark.parametrize("chart", range(4))
def test_quaternions_and_charts_are_inverse_and_exact(chart: int) -> None:
    rng = random.Random(28)
    for _ in range(50):
        z = np.array([rng.uniform(-1, 1) for _ in range(3)])
        q = quaternion_of(chart, z)
        exact = quaternion_product([Fraction(1), *(Fraction(x) for x in z)], unit_quaternion(chart))
        assert [Fraction(x) for x in q] == exact
        # The rotation is R(u) D_c.
        wanted = [
            [x * s for x, s in zip(row, HALF_TURN_SIGNS[chart], strict=True)]
            for row in cayley([Fraction(x) for x in z])
        ]
        w, x, y, v = exact
        turned = cayley([x / w, y / w, v / w]) if w else None
        assert turned is None or turned == wanted
        again, u = chart_of(q)
        assert again == chart and u == tuple(z.tolist())
        other, u = chart_of(tuple(-3.0 * x for x in q))  # type: ignore[arg-type]
        assert other == chart and np.allclose(u, z, rtol=1e-15)


def test_charts_turn_the_platform_points() -> None:
    robot = load_robot("cogiro")
    charts = charts_of(report_cables(loaded(robot)))
    centre = robot.platform.centre_of_mass
    for chart, signs in enumerate(HALF_TURN_SIGNS):
        for i, cable in enumerate(robot.cables):
            arm = [s * (b - c) for s, b, c in zip(signs, cable.platform_anchor, centre, strict=True)]
            assert contains(charts[chart, i], [*cable.frame_anchor, *arm])


# The class, on robots whose pose is known exactly.


def start_of(robot: PlantedRobot) -> Any:
    rotation = np.array(robot.rotation, dtype=np.float64)
    position = np.array(robot.position, dtype=np.float64)
    return start_at(robot.robot, robot.taut, rotation, position, [float(t) for t in robot.tensions])


def random_move(rng: random.Random, size: float) -> tuple[list[float], list[float]]:
    return [rng.uniform(-size, size) for _ in range(3)], [rng.uniform(-size, size) for _ in range(3)]


def check_exact(robot: PlantedRobot, pose: Any) -> None:
    """Check that the bounds hold the planted pose."""
    for row, exact in zip(pose.rotation, robot.rotation, strict=True):
        assert contains(row, exact)
    assert contains(pose.position, robot.position)
    assert contains(pose.tensions, robot.tensions)
    spokes = [
        minus(minus(c.frame_anchor, robot.position), apply(robot.rotation, c.platform_anchor))
        for c in robot.robot.cables
    ]
    for (lo, hi), e in zip(pose.distances, spokes, strict=True):
        assert Fraction(lo) ** 2 <= dot(e, e) <= Fraction(hi) ** 2
    load = robot.load
    assert not any(
        sum((t / exact_root(dot(e, e)) * e[k] for t, e in zip(robot.tensions, spokes, strict=True)), load[k])
        > Fraction(1, 10**15)
        for k in range(3)
    )


SINGLE = (
    "two-cables",
    "two-cables-large-platform",
    "two-parallel",
    *(f"general-{n}" for n in (3, 4, 5, 6)),
    *(f"chart-face-{n}" for n in (3, 6)),
    *(f"large-platform-{n}" for n in (3, 4, 5, 6)),
    *(f"shared-points-{n}" for n in (4, 5)),
    *(f"shared-exits-{n}" for n in (3, 6)),
    "sigma-zero-4",
    *(f"interval-lengths-{n}" for n in (3, 5)),
    "two-cables-interval-lengths",
)


@pytest.mark.parametrize("kind", SINGLE)
def test_the_planted_pose_of_a_robot_is_tracked(kind: str) -> None:
    tracked = 0
    for seed in range(8):
        rng = random.Random(seed)
        robot = plant_robot(kind, seed)
        force = robot.external_force
        for size in (0.0, 1e-5, 3e-4):
            start = moved(robot.robot, start_of(robot), *random_move(rng, size))
            pose = Tracker(robot.robot, start).update(robot.lengths, force)
            if not pose.tracked:
                continue
            assert pose.region is not None and is_finite(pose) and pose.taut == robot.taut
            rotation = np.array(robot.rotation, dtype=np.float64)
            where = depth(robot.robot, pose.region, rotation, np.array(robot.position, dtype=np.float64))
            assert where < 1.0 + 1e-9 or "interval" in kind
            if where < 1.0 - 1e-9:
                tracked += 1
                check_exact(robot, pose)
    assert tracked >= (2 if kind == "large-platform-6" else 6)


@pytest.mark.parametrize(
    "kind",
    (
        "just-tight-3",
        "a-vertical-line-3",
        "a-hook-2",
        "a-hook-3",
        "b-rod-3",
        "b-rod-5",
        "c-at-centre-1",
        "c-at-centre-3",
        "d-one-point-1",
        "d-one-point-2",
        "ab-torus-2",
        "ab-torus-3",
    ),
)
def test_neither_families_nor_just_tight_cables_are_tracked(kind: str) -> None:
    for seed in range(4):
        robot = plant_robot(kind, seed)
        for size in (0.0, 1e-4):
            start = moved(robot.robot, start_of(robot), *random_move(random.Random(seed), size))
            pose = Tracker(robot.robot, start).update(robot.lengths, robot.external_force)
            assert not pose.tracked and pose.reason
            if kind == "just-tight-3" and size == 0.0:
                assert "may be taut" in pose.reason or "singular" in pose.reason


# Against the complete lists of forward kinematics.

UC = {"uc2": [7.5, 8.0], "uc3": [7.5, 8.0, 7.0], "uc4": [7.5, 8.0, 7.0, 9.0]}


@pytest.mark.parametrize("name", UC)
def test_every_pose_is_followed_to_other_lengths(name: str) -> None:
    """Stable or not, with whatever cables taut."""
    rng = random.Random(31)
    robot = load_robot(name)
    trackers = [Tracker(robot, s) for s in forward_kinematics(robot, UC[name]).solutions]
    tracked = 0
    for step in (1e-5, 1e-4, 3e-4):
        lengths = [x + rng.uniform(-step, step) for x in UC[name]]
        result = forward_kinematics(robot, lengths)
        for tracker in trackers:
            pose = tracker.update(lengths)
            if pose.tracked:
                tracked += 1
                check_alone(robot, pose, result)
                assert widest(pose) < 1e-8
    assert tracked > 2 * len(trackers)


@pytest.mark.parametrize(("name", "step"), [("uc2", 0.002), ("uc3", 0.004), ("uc4", 0.002)])
def test_several_hundred_steps_of_a_path(name: str, step: float) -> None:
    rng = random.Random(32)
    robot = load_robot(name)
    result = forward_kinematics(robot, UC[name])
    stable = next(s for s in result.solutions if s.stability == "stable")
    tracker = Tracker(robot, stable)
    lengths, heading = np.array(UC[name]), np.zeros(len(UC[name]))
    lost = 0
    for k in range(1, 401):
        heading = 0.95 * heading + np.array([rng.gauss(0, 0.3) for _ in lengths])
        before, lengths = lengths, lengths + step * np.clip(heading, -1, 1)
        pose = tracker.update(lengths)
        if not pose.tracked:
            # The other way.
            lost, lengths, heading = lost + 1, before, -heading
            continue
        assert pose.taut == stable.taut
        if k % 100 == 0:
            check_alone(robot, pose, forward_kinematics(robot, lengths))
    assert lost < 80


COGIRO = (
    "10.737826963826153,10.996863446575965,10.519354683477053,10.587410916921941,"
    "9.838356404726296,9.423395407318322,9.501702491749816,11.157614327874176"
)


@pytest.mark.parametrize(
    ("name", "least"), [("uc2", 8), ("uc3", 14), ("uc4", 10), ("two-cables", 5), ("large-platform-3", 8)]
)
def test_starts_near_static_poses_lead_to_them(name: str, least: int) -> None:
    if name in UC:
        robot, lengths, force = load_robot(name), UC[name], None
    else:
        made = plant_robot(name, 0)
        robot, lengths, force = made.robot, made.lengths, made.external_force
    check_starts(robot, lengths, force, least)


@pytest.mark.slow
def test_starts_near_static_poses_of_a_robot_with_eight_cables() -> None:
    check_starts(load_robot("cogiro"), COGIRO, None, 44)


def check_starts(robot: Any, lengths: Any, force: Any, least: int) -> None:
    """Track all static poses from starts beside them, with regions of many sizes."""
    rng = random.Random(33)
    result = forward_kinematics(robot, lengths, external_force=force, threads=2)
    tracked = 0
    for s in result.solutions:
        for size in (1e-5, 1e-4, 1e-3, 1e-2):
            for share in (0.25, 2.0, 8.0):
                start = moved(robot, s, *random_move(rng, size))
                plain = Tracker(robot, start)
                tracker = Tracker(robot, start, radius=min(size * share, 0.5) * plain.size)
                pose = tracker.update(lengths, force)
                if pose.tracked:
                    tracked += 1
                    check_alone(robot, pose, result)
    assert tracked >= least


def test_two_poses_near_a_fold_are_never_both_in_the_region() -> None:
    robot = load_robot("uc2")
    gaps = []
    for second in (7.488, 7.374, 7.337, 7.3300625, 7.3297734375, 7.3295205078125, 7.329516255855561):
        lengths = [7.5, second]
        result = forward_kinematics(robot, lengths)
        solutions = result.solutions
        rotations = [s.rotation.mean(axis=-1) for s in solutions]
        pairs = [(np.abs(rotations[i] - rotations[j]).max(), i, j) for i in range(8) for j in range(i)]
        gap, i, j = min(pairs)
        gaps.append(gap)
        for s in (solutions[i], solutions[j]):
            for radius in (1.0, 0.25, 1e-2, 1e-3, 1e-4):
                pose = Tracker(robot, s, radius=radius).update(lengths)
                if pose.tracked:
                    check_alone(robot, pose, result)
                elif pose.tried is not None and pose.tried.radius < 0.02 * gap:
                    raise AssertionError("a region much smaller than the gap should do")
    assert gaps[0] > 0.4 and gaps[-1] < 1e-4


def test_a_pose_is_lost_at_its_fold() -> None:
    """Beyond it there is no pose near, and before it the region shrinks."""
    robot = load_robot("uc2")
    start = forward_kinematics(robot, [7.5, 7.374]).solutions
    for s in (start[2], start[3]):
        tracker = Tracker(robot, s)
        radii = []
        second = 7.374
        while (pose := tracker.update([7.5, second])).tracked:
            radii.append(pose.region.radius)
            second -= 1e-4
        assert second > 7.3294
        assert len(radii) > 50 and radii[-1] < radii[0]
        assert "singular" in pose.reason or "pose" in pose.reason
        assert not tracker.update([7.5, 7.32]).tracked
        # The reference stays.
        assert tracker.update([7.5, second + 2e-4]).tracked


def switch_of_c4() -> tuple[Any, Any, float]:
    """Return the robot, its stable pose with c4 slack, and the length of c4 below which it is taut."""
    robot = load_robot("uc4")
    result = forward_kinematics(robot, [*UC["uc4"][:3], 9.3])
    (three,) = (s for s in result.solutions if s.stability == "stable")
    assert three.taut == (0, 1, 2)
    return robot, three, float(three.distances[3].mean())


def test_a_slack_cable_that_becomes_tight_is_named() -> None:
    robot, three, reach = switch_of_c4()
    tracker = Tracker(robot, three)
    radii = []
    for more in (0.05, 0.01, 1e-3, 3e-4):
        pose = tracker.update([*UC["uc4"][:3], reach + more])
        assert pose.tracked and pose.taut == (0, 1, 2) and pose.states[3] == "slack"
        radii.append(pose.region.radius)
    assert radii[-1] < radii[0]
    for more in (1e-7, 1e-9, 0.0, -1e-9, -1e-4, -1e-2):
        pose = tracker.update([*UC["uc4"][:3], reach + more])
        assert not pose.tracked and "cable c4, slack in the last pose, may be taut" in pose.reason
    assert tracker.update([*UC["uc4"][:3], (reach + 1e-3, reach + 1e-2)]).tracked
    assert not tracker.update([*UC["uc4"][:3], (reach - 1e-12, reach + 1e-2)]).tracked


def test_a_taut_cable_that_becomes_slack_is_named() -> None:
    robot, _, reach = switch_of_c4()
    result = forward_kinematics(robot, [*UC["uc4"][:3], reach - 0.1])
    (four,) = (s for s in result.solutions if s.stability == "stable")
    tracker = Tracker(robot, four)
    tensions = []
    less = 0.1
    while (pose := tracker.update([*UC["uc4"][:3], reach - less])).tracked:
        assert pose.taut == (0, 1, 2, 3)
        tensions.append(pose.tensions[3].tolist())
        less -= 1e-3
    assert 0.0 < less < 0.03 and "cable c4, taut in the last pose, may be slack" in pose.reason
    assert tensions[-1][0] < 0.2 * tensions[0][0] and tensions[-1][0] > 0.0
    for less in (1e-4, 1e-9, 0.0, -1e-9, -1e-3, -1e-2):
        # At most the pose with c4 taut may be told, and only where there is one.
        assert not tracker.update([*UC["uc4"][:3], reach - less]).tracked


def test_the_lengths_of_another_pose_are_a_jump() -> None:
    robot = load_robot("uc4")
    first = forward_kinematics(robot, UC["uc4"]).solutions[0]
    tracker = Tracker(robot, first)
    for lengths in ([6.0, 9.5, 7.0, 8.0], [9.0, 6.0, 8.0, 9.0], [1.0, 1.0, 1.0, 1.0], [80.0] * 4, [0.01] * 4):
        pose = tracker.update(lengths)
        assert not pose.tracked and pose.reason and pose.tried is not None
    assert tracker.update(UC["uc4"]).tracked


@pytest.mark.parametrize(("cable", "number"), [(1, 6), (2, 11)])
def test_a_pose_is_followed_into_another_chart(cable: int, number: int) -> None:
    robot = load_robot("uc3")
    lengths = list(UC["uc3"])
    tracker = Tracker(robot, forward_kinematics(robot, lengths).solutions[number])
    charts: list[int] = []
    for k in range(900):
        lengths[cable] += 0.001
        pose = tracker.update(lengths)
        assert pose.tracked and pose.region is not None
        chart = pose.region.quaternion.index(1.0)
        if chart not in charts:
            charts.append(chart)
            check_alone(robot, pose, forward_kinematics(robot, lengths))
        assert max(map(abs, pose.region.quaternion)) <= 1.2 or k == 0
    check_alone(robot, pose, forward_kinematics(robot, lengths))
    assert len(charts) == 2


def test_where_a_second_pose_may_be_near_that_is_the_reason() -> None:
    robot = load_robot("uc2")
    s = forward_kinematics(robot, UC["uc2"]).solutions[2]
    tracker = Tracker(robot, s)
    second = 8.0
    while (pose := tracker.update([7.5, second])).tracked:
        second -= 0.002
    assert second > 7.3 and "more than one pose may lie within" in pose.reason
