"""Undecided cells as connected clusters, each with its hull in the robot's frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.mechanics.six_dof.frame import Pose, centred_cayley, half_turn
from solvers.answers.data import Undecided
from solvers.questions.problem import Problem
from solvers.six_dof.cells.kinds import POSE_CELLS, ROTATION_CELLS, CellKind
from solvers.six_dof.reduction import Reduced
from solvers.six_dof.solution import origin
from solvers.six_dof.subset_search import SubsetSearch

Floats = NDArray[np.float64]

NEAR = 1e-6
"""Cells nearer than this, or than the widest of them is, are one region: contraction leaves gaps."""
FINEST = 2_000
"""Most boxes whose touching is looked at pair by pair."""


def clusters(
    problem: Problem, taut: tuple[int, ...], reduced: Reduced, search: SubsetSearch, family: bool
) -> list[Undecided]:
    """Return one entry for each connected cluster of a search's undecided cells.

    In a family a cluster stands for all poses that turning makes of it: one entry covers everything.
    """
    if family:
        count = len(search.undecided) + len(search.undecided_position)
        return [anywhere(problem, taut, search.reason, count)] if count else []
    found = []
    for cells, kind in ((search.undecided, ROTATION_CELLS), (search.undecided_position, POSE_CELLS)):
        for group in connected(cells, kind.columns.chart):
            found.append(entry(problem, taut, reduced, group, kind, search.reason))
    return found


def connected(cells: Floats, chart: int) -> list[Floats]:
    """Split cells into groups of one chart whose boxes (of very many: coarse boxes) nearly touch."""
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
    return [cells[label[bucket] == k] for k in np.unique(label)]


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
    problem: Problem, taut: tuple[int, ...], reduced: Reduced, cells: Floats, kind: CellKind, reason: str
) -> Undecided:
    """Return the undecided entry of one cluster: hulls over its cells."""
    lo, hi = cells[:, 0:6:2].min(axis=0), cells[:, 1:6:2].max(axis=0)
    u = [balls.from_bounds(a, b) for a, b in zip(lo, hi, strict=True)]
    frame = reduced.frame
    back = frame.base.transpose()
    rotation = back * centred_cayley(u) * half_turn(int(cells[0, kind.columns.chart])) * frame.platform
    place = position_hull(reduced, cells, kind)
    if place is None:
        box = reachable_box(problem, taut)
    else:
        p = balls.vector([balls.from_bounds(a, b) for a, b in place])
        centre = back * p + balls.fractions(frame.origin)
        box = balls.bounds_array(origin(problem.robot, Pose(rotation, centre, ())))
    bounds = np.clip(balls.bounds_array(rotation), -1.0, 1.0).reshape(3, 3, 2)
    return Undecided(taut, len(cells), reason, box, bounds)


def position_hull(reduced: Reduced, cells: Floats, kind: CellKind) -> Floats | None:
    """Return bounds (3, 2) of p over a cluster, model frame; None where a cell does not bound it."""
    model = reduced.model
    lo, hi = np.empty(6), np.empty(6)
    best = np.array([[np.inf, -np.inf]] * 3)
    for cell in cells:
        if not kind.enclose(model, cell, lo, hi):
            return None
        best[:, 0] = np.minimum(best[:, 0], lo[3:6])
        best[:, 1] = np.maximum(best[:, 1], hi[3:6])
    return best


def anywhere(problem: Problem, taut: tuple[int, ...], reason: str, cells: int = 1) -> Undecided:
    """Return an undecided entry that covers every pose the taut cables allow."""
    rotation = np.tile(np.array([-1.0, 1.0]), (3, 3, 1))
    return Undecided(taut, cells, reason, reachable_box(problem, taut), rotation)


def reachable_box(problem: Problem, taut: tuple[int, ...]) -> Floats:
    """Return bounds (3, 2) of the platform origin over all poses the taut cables allow."""
    box = np.array([[-np.inf, np.inf]] * 3)
    for i in taut:
        arm = balls.norm(balls.fractions(problem.loaded.anchors[i]))
        reach = balls.from_fraction(problem.lengths[i][1]) + arm
        for k in range(3):
            a = balls.from_fraction(problem.loaded.exits[i][k])
            box[k, 0] = max(box[k, 0], balls.to_bounds(a - reach)[0])
            box[k, 1] = min(box[k, 1], balls.to_bounds(a + reach)[1])
    return np.sort(box, axis=1)
