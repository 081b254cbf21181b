"""Undecided cells as connected clusters, each with its hull in the robot's frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solvers import balls
from solvers import platform_position as position
from solvers import platform_sigma as sigma
from solvers.platform_forms import FORM_ROWS, WORK_SHAPE
from solvers.platform_frame import Pose, centred_cayley, half_turn
from solvers.platform_reduction import Reduced
from solvers.platform_solution import origin
from solvers.platform_subset import SubsetSearch
from solvers.problem import Problem
from solvers.result import Undecided

Floats = NDArray[np.float64]

FINEST = 2_000
"""More cells than this are reported as one cluster: pairing them would take longer than it tells."""


def clusters(
    problem: Problem, taut: tuple[int, ...], reduced: Reduced, search: SubsetSearch
) -> list[Undecided]:
    """Return one entry for each connected cluster of a search's undecided cells."""
    found = []
    for cells, chart in ((search.undecided, sigma.CHART), (search.undecided_position, position.P_CHART)):
        for group in connected(cells, chart):
            found.append(entry(problem, taut, reduced, group, chart, search.reason))
    return found


def connected(cells: Floats, chart: int) -> list[Floats]:
    """Split cells into groups of one chart whose boxes touch."""
    if len(cells) == 0:
        return []
    if len(cells) > FINEST:
        return [cells[cells[:, chart] == c] for c in np.unique(cells[:, chart])]
    lo, hi = cells[:, 0:chart:2][:, : chart // 2], cells[:, 1:chart:2][:, : chart // 2]
    label = np.full(len(cells), -1)
    groups = []
    for k in range(len(cells)):
        if label[k] >= 0:
            continue
        label[k] = k
        todo = [k]
        while todo:
            i = todo.pop()
            touch = np.all((lo <= hi[i]) & (lo[i] <= hi), axis=1) & (cells[:, chart] == cells[i, chart])
            fresh = np.flatnonzero(touch & (label < 0))
            label[fresh] = k
            todo.extend(fresh.tolist())
        groups.append(cells[label == k])
    return groups


def entry(
    problem: Problem, taut: tuple[int, ...], reduced: Reduced, cells: Floats, chart: int, reason: str
) -> Undecided:
    """Return the undecided entry of one cluster: hulls over its cells."""
    lo, hi = cells[:, 0:6:2].min(axis=0), cells[:, 1:6:2].max(axis=0)
    u = [balls.from_bounds(a, b) for a, b in zip(lo, hi, strict=True)]
    frame = reduced.frame
    back = frame.base.transpose()
    rotation = back * centred_cayley(u) * half_turn(int(cells[0, chart])) * frame.platform
    place = position_hull(reduced, cells, chart)
    if place is None:
        box = reachable_box(problem, taut)
    else:
        p = balls.vector([balls.from_bounds(a, b) for a, b in place])
        centre = back * p + balls.fractions(frame.origin)
        box = balls.bounds_array(origin(problem.robot, Pose(rotation, centre, ())))
    bounds = np.clip(balls.bounds_array(rotation), -1.0, 1.0).reshape(3, 3, 2)
    return Undecided(taut, len(cells), reason, box, bounds)


def position_hull(reduced: Reduced, cells: Floats, chart: int) -> Floats | None:
    """Return bounds (3, 2) of p over a cluster, model frame; None where a cell does not bound it."""
    if chart == position.P_CHART:
        return np.column_stack([cells[:, 6:12:2].min(axis=0), cells[:, 7:12:2].max(axis=0)])
    model = reduced.model
    forms, work = np.zeros((FORM_ROWS, 6)), np.zeros(WORK_SHAPE)
    lo, hi = np.empty(6 + model.n_taut), np.empty(6 + model.n_taut)
    best = np.array([[np.inf, -np.inf]] * 3)
    for cell in cells:
        if not sigma.enclose_position(forms, work, model, cell, lo, hi):
            return None
        best[:, 0] = np.minimum(best[:, 0], lo[3:6])
        best[:, 1] = np.maximum(best[:, 1], hi[3:6])
    return best


def reachable_box(problem: Problem, taut: tuple[int, ...]) -> Floats:
    """Return bounds (3, 2) of the platform origin over all poses the taut cables allow."""
    box = np.array([[-np.inf, np.inf]] * 3)
    for i in taut:
        cable = problem.robot.cables[i]
        arm = balls.norm(balls.fractions(cable.platform_anchor))
        reach = balls.from_fraction(problem.lengths[i][1]) + arm
        for k in range(3):
            a = balls.from_fraction(cable.frame_anchor[k])
            box[k, 0] = max(box[k, 0], balls.to_bounds(a - reach)[0])
            box[k, 1] = min(box[k, 1], balls.to_bounds(a + reach)[1])
    return np.sort(box, axis=1)
