"""Undecided cells as connected clusters, each with its hull in the robot's frames.

Cells are cut to where all cables reach. Those of which nothing is left are not among them, nor those at whose
poses no taut cable pulls against the load: they hold no static pose.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.mechanics.six_dof import system as newton
from cdpr_interval.mechanics.six_dof.arrays import Model
from cdpr_interval.mechanics.six_dof.frame import Pose, centred_cayley, half_turn
from solvers.answers.data import Undecided
from solvers.questions.problem import Problem
from solvers.six_dof.cells.drawn_in import drawn_in
from solvers.six_dof.cells.kinds import POSE_CELLS, ROTATION_CELLS, CellKind
from solvers.six_dof.cells.lift import may_lift
from solvers.six_dof.cells.root_search import System
from solvers.six_dof.cells.subset_search import SubsetSearch
from solvers.six_dof.reduction import Reduced
from solvers.six_dof.solution import origin

Floats = NDArray[np.float64]

NEAR = 1e-6
"""Cells nearer than this, or than the widest of them is, are one region: contraction leaves gaps."""
MOST_LOOKED_AT = 1_000
"""Most cells of a region over which the derivative is looked at."""
FINEST = 2_000
"""Most boxes whose touching is looked at pair by pair."""


def clusters(
    problem: Problem, taut: tuple[int, ...], reduced: Reduced, search: SubsetSearch, family: bool
) -> list[Undecided]:
    """Return one entry for each connected cluster of a search's undecided cells.

    In a family a cluster stands for all poses that turning makes of it: one entry covers everything.
    """
    count, found = 0, []
    for cells, kind in ((search.undecided, ROTATION_CELLS), (search.undecided_position, POSE_CELLS)):
        if len(cells) == 0:
            continue
        poses = enclosed(reduced.model, cells, kind)
        poses, kept = drawn_in(reduced.model, cells[:, kind.columns.chart], poses)
        cells, poses = cells[kept], poses[kept]
        kept = may_lift(reduced.model, cells[:, kind.columns.chart], poses)
        cells, poses = cells[kept], poses[kept]
        count += len(cells)
        for group in [] if family else connected(cells, kind.columns.chart):
            chart = int(cells[group[0], kind.columns.chart])
            one = entry(problem, taut, reduced, cells[group], poses[group], chart, search.reason)
            most = most_poses(reduced.model, search.prover.system, cells[group], chart, kind)
            found.append(replace(one, poses=most))
    return [anywhere(problem, taut, search.reason, count)] if family and count else found


def enclosed(model: Model, cells: Floats, kind: CellKind) -> Floats:
    """Return bounds (C, 6, 2) of the poses (u, p) in each cell, model frame; p is NaN where it has none."""
    poses = np.full((len(cells), 6, 2), np.nan)
    poses[:, :3, 0], poses[:, :3, 1] = cells[:, 0:6:2], cells[:, 1:6:2]
    lo, hi = np.empty(6), np.empty(6)
    for cell, pose in zip(cells, poses, strict=True):
        if kind.enclose(model, cell, lo, hi):
            pose[:, 0], pose[:, 1] = lo, hi
    return poses


def most_poses(
    model: Model, system: System, cells: Floats, chart: int, kind: CellKind
) -> tuple[int, int] | None:
    """Return (0, 1) where there are not two equilibria of the taut cables in some cells; None: unknown.

    The derivative of their system is regular over the hull of all unknowns, for every choice of the data.
    """
    n = model.n_taut
    if len(cells) > MOST_LOOKED_AT or system.rod:
        return None
    free, data = np.ascontiguousarray(system.free[chart]), np.empty((n + 1, 7, 2))
    unknowns = np.full((len(cells), 6 if len(free) == 6 else 6 + n, 2), np.nan)
    lo, hi = np.empty((2, unknowns.shape[1]))
    for cell, found in zip(cells, unknowns, strict=True):
        if not kind.enclose(model, cell, lo, hi):
            return None
        found[:, 0], found[:, 1] = lo, hi
    box = np.zeros((6 + n, 2))
    box[free, 0], box[free, 1] = unknowns[:, free, 0].min(axis=0), unknowns[:, free, 1].max(axis=0)
    newton.fill_data(model, chart, data)
    for columns, side in (
        (slice(0, 3), model.exit_spread),
        (slice(3, 6), model.anchor_sides + model.centre_sides),
    ):
        data[:n, columns, 0] = np.nextafter(data[:n, columns, 0] - side[:n], -np.inf)
        data[:n, columns, 1] = np.nextafter(data[:n, columns, 1] + side[:n], np.inf)
    f, J = np.empty((len(free), 2)), np.empty((len(free), len(free), 2))
    middle = box.mean(axis=1)
    newton.jacobian_over(data, system.rows, free, np.stack([middle, middle], axis=1), f, J)
    with np.errstate(all="ignore"):
        try:
            inverse = np.ascontiguousarray(np.linalg.inv(J.mean(axis=2)))
        except np.linalg.LinAlgError:
            return None
    return (0, 1) if newton.regular(data, system.rows, free, inverse, box) else None


def connected(cells: Floats, chart: int) -> list[NDArray[np.int64]]:
    """Return groups of rows: cells of one chart whose boxes (of very many: coarse boxes) nearly touch."""
    if len(cells) == 0:
        return []
    bucket = coarse_buckets(cells, chart)
    count = int(bucket.max()) + 1
    lo = np.full((count, chart // 2 + 1), np.inf)
    hi = np.full((count, chart // 2 + 1), -np.inf)
    # The chart joins as one more coordinate: boxes of different charts never touch.
    sides = np.column_stack([cells[:, 0:chart:2], cells[:, chart]])
    np.minimum.at(lo, bucket, sides)
    np.maximum.at(hi, bucket, np.column_stack([cells[:, 1:chart:2], cells[:, chart]]))
    label = np.full(count, -1)
    near = np.maximum(NEAR, (hi - lo).max(axis=0))
    near[-1] = NEAR
    for k in range(count):
        todo = [] if label[k] >= 0 else [k]
        while todo:
            i = todo.pop()
            label[i] = k
            fresh = np.flatnonzero(np.all((lo <= hi[i] + near) & (lo[i] <= hi + near), axis=1) & (label < 0))
            label[fresh] = k
            todo.extend(fresh.tolist())
    return [np.flatnonzero(label[bucket] == k) for k in np.unique(label)]


def coarse_buckets(cells: Floats, chart: int) -> NDArray[np.int64]:
    """Give the cells numbers; more than ``FINEST`` share them on a grid coarse enough for so many boxes."""
    if len(cells) <= FINEST:
        return np.arange(len(cells))
    middles = 0.5 * (cells[:, 0:chart:2] + cells[:, 1:chart:2])
    step = np.maximum((cells[:, 1:chart:2] - cells[:, 0:chart:2]).max(axis=0), 1e-300)
    while True:
        keys = np.column_stack([np.floor(middles / step), cells[:, chart]])
        _, bucket = np.unique(keys, axis=0, return_inverse=True)
        if bucket.max() < FINEST:
            return np.asarray(bucket.reshape(-1), dtype=np.int64)
        step = 2.0 * step


def entry(
    problem: Problem,
    taut: tuple[int, ...],
    reduced: Reduced,
    cells: Floats,
    poses: Floats,
    chart: int,
    reason: str,
) -> Undecided:
    """Return the undecided entry of one cluster: the hull over the ``poses`` of its cells, see `enclosed`."""
    lo, hi = poses[:, :3, 0].min(axis=0), poses[:, :3, 1].max(axis=0)
    u = [balls.from_bounds(a, b) for a, b in zip(lo, hi, strict=True)]
    frame = reduced.frame
    back = frame.base.transpose()
    rotation = back * centred_cayley(u) * half_turn(chart) * frame.platform
    lowest, highest = poses[:, 3:, 0].min(axis=0), poses[:, 3:, 1].max(axis=0)
    if np.isnan(lowest).any():
        # Some cell does not bound the position.
        box = reachable_box(problem, taut)
    else:
        p = balls.vector([balls.from_bounds(a, b) for a, b in zip(lowest, highest, strict=True)])
        centre = back * p + balls.ranges(frame.origin)
        box = balls.bounds_array(origin(problem.robot, Pose(rotation, centre, ())))
    bounds = np.clip(balls.bounds_array(rotation), -1.0, 1.0).reshape(3, 3, 2)
    return Undecided(taut, len(cells), reason, box, bounds)


def anywhere(problem: Problem, taut: tuple[int, ...], reason: str, cells: int = 1) -> Undecided:
    """Return an undecided entry that covers every pose the taut cables allow."""
    rotation = np.tile(np.array([-1.0, 1.0]), (3, 3, 1))
    return Undecided(taut, cells, reason, reachable_box(problem, taut), rotation)


def reachable_box(problem: Problem, taut: tuple[int, ...]) -> Floats:
    """Return bounds (3, 2) of the platform origin over all poses the taut cables allow."""
    box = np.array([[-np.inf, np.inf]] * 3)
    for i in taut:
        arm = balls.norm(balls.ranges(problem.loaded.anchor_ranges[i]))
        reach = balls.from_fraction(problem.lengths[i][1]) + arm
        for k in range(3):
            a = balls.from_range(problem.loaded.exit_ranges[i][k])
            box[k, 0] = max(box[k, 0], balls.to_bounds(a - reach)[0])
            box[k, 1] = min(box[k, 1], balls.to_bounds(a + reach)[1])
    return np.sort(box, axis=1)
