"""Cells cut to where lengths are kept: sampled poses stay inside, and little more is left."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.rotation import HALF_TURNS
from cdpr_interval.mechanics.six_dof.arrays import Model, build_model
from cdpr_interval.robots.formats.reader import parse_robot
from solvers import forward_kinematics
from solvers.six_dof.cells.drawn_in import drawn_in

SEED = 20261130


@dataclass
class Case:
    """A model, a box of poses, and poses in it for lengths in their ranges."""

    model: Model
    chart: int
    box: np.ndarray
    poses: np.ndarray


def rotations(u: np.ndarray) -> np.ndarray:
    """Return R(u) (K, 3, 3), from the textbook matrix of the quaternion (1, u)."""
    w = 1.0 / np.sqrt(1.0 + (u * u).sum(axis=1))
    x, y, z = (u * w[:, None]).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def case(rng: np.random.Generator, count: int, n: int, room: float, slack: bool) -> Case:
    """Return a frame with cables from all sides, lengths with some room at a pose, and a box around it."""
    exits, arms = rng.uniform(-3, 3, (count, 3)), rng.uniform(-0.5, 0.5, (count, 3))
    chart, u, p = int(rng.integers(4)), rng.uniform(-0.8, 0.8, 3), rng.uniform(-1, 1, 3)

    def distances(us: np.ndarray, ps: np.ndarray) -> np.ndarray:
        turned = np.einsum("kij,nj->kni", rotations(us), arms * HALF_TURNS[chart])
        return np.linalg.norm(exits - ps[:, None] - turned, axis=2)

    lengths = distances(u[None], p[None])[0] + room * rng.uniform(0.2, 1.0, count)
    exact = [[Range.exact(Fraction(float(x))) for x in v] for v in (*exits, *arms)]
    points = [(x, y, z) for x, y, z in exact]
    zero, pull = Range.exact(Fraction(0)), Range.exact(Fraction(-1))
    shorter = lengths - 2.0 * room
    ranges = [
        Range(Fraction(float(lo)), Fraction(float(hi))) for lo, hi in zip(shorter, lengths, strict=True)
    ]
    model = build_model(points[:count], points[count:], ranges, (zero, zero, pull), n, slack=slack)
    middle, half = np.concatenate([u, p]), np.array([0.05] * 3 + [0.3] * 3)
    middle = middle + 0.5 * half * rng.uniform(-1, 1, 6)
    box = np.stack([middle - half, middle + half], axis=1)
    box[:3] = np.clip(box[:3], -1.0, 1.0)
    poses = rng.uniform(box[:, 0], box[:, 1], (20000, 6))
    # Many near the pose as well, which all cables reach.
    poses[:10000] = np.clip(np.concatenate([u, p]) + rng.normal(size=(10000, 6)) * room, box[:, 0], box[:, 1])
    found = distances(poses[:, :3], poses[:, 3:])
    within = (found <= lengths) & ((found >= shorter) | (np.arange(count) >= n))
    return Case(model, chart, box, poses[within[:, : count if slack else n].all(axis=1)])


@pytest.mark.parametrize("slack", [True, False])
@pytest.mark.parametrize("bounded", [True, False])
@pytest.mark.parametrize("count", [3, 5, 8])
def test_poses_that_all_cables_reach_stay_inside(count: int, bounded: bool, slack: bool) -> None:
    rng, seen = np.random.default_rng(SEED + count), 0
    for room in (0.003, 0.03, 0.3):
        one = case(rng, count, min(count, 4), room, slack)
        given = one.box.copy()
        if not bounded:
            given[3:] = np.nan
        (left,), (kept,) = drawn_in(one.model, np.array([float(one.chart)]), given[None])
        seen += len(one.poses)
        assert kept or not len(one.poses)
        assert (left[:, 0] <= one.poses.min(axis=0, initial=np.inf)).all()
        assert (one.poses.max(axis=0, initial=-np.inf) <= left[:, 1]).all()
        if bounded and kept:
            assert (given[:, 0] <= left[:, 0]).all() and (left[:, 1] <= given[:, 1]).all()
    assert seen > 1000


def test_oblique_cables_cut_a_box_together() -> None:
    """Cables from all corners with a millimetre of room leave millimetres; one by one they cut nothing."""
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    zero = Range.exact(Fraction(0))
    exits = [
        (Range.exact(Fraction(x)), Range.exact(Fraction(y)), Range.exact(Fraction(z))) for x, y, z in corners
    ]
    length = Range(Fraction(1), Fraction(1733, 1000))
    load = (zero, zero, Range.exact(Fraction(-1)))
    model = build_model(exits, [(zero, zero, zero)] * 8, [length] * 8, load, 3)
    box = np.array([[0.0, 0.01]] * 3 + [[-0.3, 0.3]] * 3)
    (left,), (kept,) = drawn_in(model, np.array([0.0]), box[None])
    # |p| <= l - sqrt(3) = 0.95 mm along the diagonals: sqrt(3) times as much along the axes.
    assert kept and (np.abs(left[3:]) < 1.7e-3).all() and (np.abs(left[3:]) > 0.95e-3).all()
    short = model._replace(lengths=model.lengths - 2e-3)
    assert not drawn_in(short, np.array([0.0]), box[None])[1][0]


DESK = """\
{format: cdpr-robot/1, name: desk, platform: {mass_kg: 1.2}, cables: [
 {name: c1, frame_anchor_m: [0.68, 0.56, 0.66], platform_anchor_m: [0.0375, 0.0375, -0.045]},
 {name: c2, frame_anchor_m: [0.68, 0, 0.66], platform_anchor_m: [0.0375, -0.0375, -0.045]},
 {name: c3, frame_anchor_m: [0, 0, 0.66], platform_anchor_m: [-0.0375, -0.0375, -0.045]},
 {name: c4, frame_anchor_m: [0, 0.56, 0.66], platform_anchor_m: [-0.0375, 0.0375, -0.045]},
 {name: c5, frame_anchor_m: [0.68, 0.56, 0], platform_anchor_m: [0.0375, 0.0225, 0.045]},
 {name: c6, frame_anchor_m: [0.68, 0, 0], platform_anchor_m: [0.0375, -0.0225, 0.045]},
 {name: c7, frame_anchor_m: [0, 0, 0], platform_anchor_m: [-0.0375, -0.0225, 0.045]},
 {name: c8, frame_anchor_m: [0, 0.56, 0], platform_anchor_m: [-0.0375, 0.0225, 0.045]}]}
"""


def test_a_frame_of_eight_cables_known_to_a_millimetre_leaves_millimetres() -> None:
    """It was a region of 3 to 4 cm; poses of chosen lengths lie within 1.6 x 2.7 x 2.1 mm."""
    middles = (0.552, 0.529, 0.489, 0.513, 0.608, 0.579, 0.528, 0.562)
    lengths = [(x - 1e-3, x + 1e-3) for x in middles]
    robot = parse_robot(DESK)
    result = forward_kinematics(robot, lengths, taut=("c1", "c2", "c3", "c4", "c5"))
    low, high = np.array([0.2995, 0.2493, 0.3585]), np.array([0.3011, 0.2520, 0.3606])
    (region,) = result.undecided
    assert (region.position[:, 0] <= low).all() and (high <= region.position[:, 1]).all()
    assert (region.position[:, 1] - region.position[:, 0] < 0.015).all()


def test_taut_cables_cannot_be_shorter_either() -> None:
    """Three cables of equal length from a triangle above: how high the box reaches is cut, too."""
    zero = Range.exact(Fraction(0))
    corners = [(1, 0), (-1, 1), (-1, -1)]
    exits = [
        (Range.exact(Fraction(x)), Range.exact(Fraction(y)), Range.exact(Fraction(2))) for x, y in corners
    ]
    lengths = [Range(Fraction(2236, 1000), Fraction(2237, 1000))] + [
        Range(Fraction(2449, 1000), Fraction(245, 100))
    ] * 2
    load = (zero, zero, Range.exact(Fraction(-1)))
    model = build_model(exits, [(zero, zero, zero)] * 3, lengths, load, 3)
    box = np.array([[0.0, 0.01]] * 3 + [[-0.1, 0.1]] * 3)
    (left,), (kept,) = drawn_in(model, np.array([0.0]), box[None])
    assert kept and (left[3:, 0] <= 0).all() and (left[3:, 1] >= -1e-3).all()
    assert (left[3:, 1] - left[3:, 0] < 4e-3).all()
