"""Platforms on pulleys: planted poses are kept by every cell and found, enclosures enclose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval.engine.budget import Budget
from cdpr_interval.engine.search import search
from cdpr_interval.exact import balls
from cdpr_interval.mechanics.orientation import quaternion_from_rotation
from cdpr_interval.mechanics.rotation import chart_of, u_in
from solvers.six_dof.cells.merge import distinct
from solvers.six_dof.cells.roots import Root
from solvers.six_dof.clusters import connected
from solvers.six_dof.real.build import RealCable, Vector, build, within
from solvers.six_dof.real.columns import DENSITIES, REAL_COLUMNS
from solvers.six_dof.real.model import RealModel
from solvers.six_dof.real.roots import RealRoot, root_near, rotation_of
from solvers.six_dof.real.strands import piece_at, strands_in
from solvers.six_dof.real.subset import RealSearch
from solvers.six_dof.real.system import new_bench, system
from tests.support.planted.pulleys import FloatCable, Floats, Planted, any_cable, plant, random_cable

Cable = Callable[[np.random.Generator, float], FloatCable]
NEAR = 1e-9
"""How far the planted pose may be from the exact one, by rounding."""


def chart_and_u(planted: Planted) -> tuple[int, Floats]:
    """Return where the planted rotation is."""
    chart, u = chart_of(quaternion_from_rotation(planted.rotation))
    return chart, np.array(u)


def is_planted(planted: Planted, root: RealRoot) -> bool:
    """Return True when a root is the planted pose."""
    off = rotation_of(root.chart, root.box[:3].mean(axis=1)) - planted.rotation
    away = root.box[3:6].mean(axis=1) - planted.position
    return bool(np.abs(off).max() < 1e-6 and np.abs(away).max() < 1e-6)


@pytest.mark.parametrize("compliance", [0.0, 1e-4, 2e-2, "some"])
@pytest.mark.parametrize("count", [3, 4, 5, 6, 7, 8])
@pytest.mark.parametrize("seed", range(8))
def test_no_cell_loses_a_planted_pose(seed: int, count: int, compliance: float | str) -> None:
    """Of any cell around a pose, however large, what the search leaves holds the pose.

    More than six cables are taut together only where those behind stretch.
    """
    if compliance == 0.0 and count > 6:
        return
    # From the fourth on two joints and ropes that lift off, too.
    planted = plant(seed, count, any_cable if seed >= 3 else random_cable)
    rigid = min(6, seed % (count + 1))
    some = [0.0] * rigid + [10.0 ** -(1 + (seed + i) % 4) for i in range(count - rigid)]
    run = RealSearch(planted.real(some if isinstance(compliance, str) else compliance), Budget())
    chart, u = chart_and_u(planted)
    rng = np.random.default_rng(seed)
    for _ in range(12):
        width = 10.0 ** rng.uniform(-4.0, -0.5)
        in_position = width * 10.0 ** rng.uniform(-1.0, 1.0)
        a, b = rng.random(3), rng.random(3)
        cell = np.zeros((1, REAL_COLUMNS.width))
        cell[0, 0:6:2], cell[0, 1:6:2] = u - width * a - NEAR, u + width * (1.0 - a) + NEAR
        cell[0, 6:12:2] = planted.position - in_position * b - NEAR
        cell[0, 7:12:2] = planted.position + in_position * (1.0 - b) + NEAR
        cell[0, REAL_COLUMNS.chart] = chart
        cell[0, DENSITIES + 1 : REAL_COLUMNS.share : 2] = np.inf
        leaf = width / 2.0 ** rng.integers(0, 6)
        result = search(lambda size=leaf: run.run(size), cell, Budget(None, 10_000))
        left = np.concatenate([result.leaves, result.pending])
        here = np.concatenate([u, planted.position])
        inside = (left[:, 0:12:2] <= here + 2.0 * NEAR) & (here - 2.0 * NEAR <= left[:, 1:12:2])
        assert inside.all(axis=1).any()


@pytest.mark.parametrize("compliance", [0.0, 1e-4])
@pytest.mark.parametrize(("seed", "count"), [(0, 3), (1, 4), (2, 5), (3, 6)])
def test_a_planted_pose_is_found_or_the_search_not_finished(seed: int, count: int, compliance: float) -> None:
    planted = plant(seed, count)
    low = within(planted.real(compliance), 20.0 * float(np.linalg.norm(planted.load)))
    run = RealSearch(low, Budget(None, 200_000))
    run.solve()
    assert any(is_planted(planted, root) for root in run.roots) or run.pending or len(run.undecided)


@pytest.mark.parametrize("cable", [random_cable, any_cable])
@pytest.mark.parametrize("seed", range(8))
def test_the_system_over_a_box_encloses_it_at_every_point(seed: int, cable: Cable) -> None:
    """Lengths and balance by the paths in floats, written anew, lie in the bounds; so do slopes."""
    planted = plant(seed, 4, cable)
    chart, u = chart_and_u(planted)
    bench = new_bench(planted.real(), chart)
    free = np.array(
        [c.path(x)[2] for c, x in zip(planted.cables, anchors_at(planted, chart, u), strict=True)]
    )
    middle = np.concatenate([u, planted.position, planted.tensions / free])
    rng = np.random.default_rng(seed)
    for half in (1e-7, 1e-3, 2e-2):
        spread = np.concatenate([np.full(6, half), np.full(4, 50.0 * half)])
        box = np.stack([middle - spread, middle + spread], axis=1)
        f, J = np.empty((10, 2)), np.empty((10, 10, 2))
        is_smooth = system(bench, box, f, J, True)
        assert is_smooth or (cable is any_cable and half > 1e-7)
        if not is_smooth:
            # Some rope may lift off there.
            continue
        for _ in range(20):
            z = middle + spread * rng.uniform(-1.0, 1.0, 10)
            value = equations(planted, chart, z)
            assert ((f[:, 0] - 1e-10 <= value) & (value <= f[:, 1] + 1e-10)).all()
            for j in range(10):
                step = np.zeros(10)
                step[j] = 1e-6
                slope = (equations(planted, chart, z + step) - equations(planted, chart, z - step)) / 2e-6
                assert ((J[:, j, 0] - 1e-6 <= slope) & (slope <= J[:, j, 1] + 1e-6)).all()


def anchors_at(planted: Planted, chart: int, u: Floats) -> Floats:
    """Return the anchors (N, 3) of a pose at the planted position."""
    return planted.position + planted.arms @ rotation_of(chart, u).T


def equations(planted: Planted, chart: int, z: Floats) -> Floats:
    """Return what is to vanish, in floats."""
    rotation = rotation_of(chart, z[:3])
    arms = planted.arms @ rotation.T
    seen = [c.path(z[3:6] + r) for c, r in zip(planted.cables, arms, strict=True)]
    lengths = [length - own for (length, _, _), own in zip(seen, planted.lengths, strict=True)]
    spokes = np.array([-free * a for _, a, free in seen])
    force = z[6:] @ spokes + planted.load
    return np.concatenate([lengths, force, z[6:] @ np.cross(arms, spokes)])


def lifted(*, straight: bool) -> RealModel:
    """Return three cables whose ropes run past pulleys on long arms, or the same without pulleys."""
    exits = [("-0.96", "0.02", "0.78"), ("1.14", "1.19", "0.77"), ("-0.97", "2.34", "0.74")]
    arms = [("-0.136", "-0.235", "0.088"), ("0.273", "0.000", "0.088"), ("-0.136", "0.240", "0.088")]
    axes = [("1", "0", "0"), ("-0.7", "-0.7", "0"), ("0.7", "-0.7", "0")]
    lengths = ["1.488157", "1.198477", "1.444177"]
    pulley = {} if straight else {"radius": Fraction("0.02"), "pulley_arm": Fraction("0.08")}
    cables = [
        RealCable(triple(a), triple(b), (Fraction(own),) * 2, axis=triple(axes[i]), **pulley)
        for i, (a, b, own) in enumerate(zip(exits, arms, lengths, strict=True))
    ]
    return build(cables, triple(("0.55", "-1.23", "-78.5")), 3)


def triple(entries: tuple[str, str, str]) -> Vector:
    """Return a vector as exact numbers."""
    x, y, z = map(Fraction, entries)
    return x, y, z


def test_a_rope_that_lifts_off_its_pulley_has_the_poses_of_a_straight_one() -> None:
    """Beyond theta_K the rope runs straight from C, which is A here: no negative wrap is proved."""
    cell = np.zeros((1, REAL_COLUMNS.width))
    cell[0, 0:6:2], cell[0, 1:6:2] = -0.1, 0.1
    cell[0, 6:12:2], cell[0, 7:12:2] = [-0.08, 1.14, -0.19], [0.02, 1.26, -0.07]
    cell[0, DENSITIES + 1 : REAL_COLUMNS.share : 2] = np.inf
    found = []
    for straight in (True, False):
        run = RealSearch(lifted(straight=straight), Budget(None, 20_000))
        run.solve(cell.copy())
        assert len(run.roots) == 1 and not run.pending and not len(run.undecided)
        found.append(run.roots[0].box[:6].mean(axis=1))
    assert np.allclose(*found, atol=1e-12)


@pytest.mark.parametrize(("seed", "half"), [(1, 5.67e-4), (2, 4e-4), (4, 4.67e-4), (5, 5e-4)])
def test_a_pose_at_the_border_of_two_charts_is_one_pose_for_wide_ranges_too(seed: int, half: float) -> None:
    """Its box is then nearly as large as the one in which it is proved to be alone."""
    planted = plant(seed, 4)
    quarter = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    body = planted.rotation.T @ quarter
    real = replace(planted, arms=planted.arms @ body, rotation=quarter).real()
    off = np.array([-half, half])
    real = real._replace(lengths=real.lengths + off, paths=real.paths + off)
    roots: list[Root] = []
    for chart in (0, 1):
        u = np.array(u_in(chart, quaternion_from_rotation(quarter)))
        found = root_near(real, chart, np.concatenate([u, planted.position]), [])
        assert found is not None
        roots.append(Root(found.chart, found.box, found.unique, found.core))
    with balls.precision():
        assert len(distinct(roots)) == 1


def is_in_cells(planted: Planted, cells: Floats) -> bool:
    """Return True when some cell of the planted pose's charts holds it."""
    quaternion = quaternion_from_rotation(planted.rotation)
    for chart in range(4):
        here = np.array([*u_in(chart, quaternion), *planted.position])
        own = cells[cells[:, REAL_COLUMNS.chart] == chart]
        inside = (own[:, 0:12:2] <= here + 2.0 * NEAR) & (here - 2.0 * NEAR <= own[:, 1:12:2])
        if inside.all(axis=1).any():
            return True
    return False


def is_in_root(planted: Planted, root: RealRoot) -> bool:
    """Return True when the planted pose is in a root's box."""
    here = np.array([*u_in(root.chart, quaternion_from_rotation(planted.rotation)), *planted.position])
    return bool(((root.box[:6, 0] <= here + NEAR) & (here - NEAR <= root.box[:6, 1])).all())


@pytest.mark.parametrize(
    ("seed", "count", "half"),
    [
        (40, 3, 1e-4),
        (29, 4, 3e-5),
        (99, 6, 3e-5),
        (121, 4, 5e-4),
        pytest.param(72, 3, 2e-3, marks=pytest.mark.slow),
        pytest.param(82, 5, 2e-3, marks=pytest.mark.slow),
        pytest.param(43, 6, 1e-2, marks=pytest.mark.slow),
        pytest.param(217, 4, 2e-3, marks=pytest.mark.slow),
    ],
)
def test_a_planted_pose_of_lengths_in_ranges_is_in_a_root_a_strand_or_a_cell(
    seed: int, count: int, half: float
) -> None:
    """The planted lengths lie anywhere in their ranges; cells that are settled by parts count as strands."""
    planted = plant(seed, count)
    real = planted.real()
    rng = np.random.default_rng(seed)
    low = half * rng.uniform(0.0, 2.0, count)[:, None]
    off = np.concatenate([-low, 2.0 * half - low], axis=1)
    real = real._replace(lengths=real.lengths + off, paths=real.paths + off)
    run = RealSearch(real, Budget(None, 1_000_000))
    run.solve()
    assert not run.pending
    roots, cells = list(run.roots), [run.undecided[:0]]
    for group in connected(run.undecided, REAL_COLUMNS.chart):
        strands, _ = strands_in(real, run.undecided[group], run.roots, Budget())
        if strands is None:
            cells.append(run.undecided[group])
        for strand in strands or []:
            roots.append(piece_at(strand, planted.lengths).root)
    assert any(is_in_root(planted, root) for root in roots) or is_in_cells(planted, np.concatenate(cells))
