"""Where the pose of a point mass may be when it is not proved: a box around the common points of all balls.

With weights w >= 0 of sum 1, c = sum w_i A_i, a common point has |p - c|^2 <= sum w_i (l_i^2 - |c - A_i|^2).
Then each ball cuts the box to the points to which the other two coordinates leave room in it. Where all exits
and the load lie in a plane across an axis, a static pose does: p is a mean of the A_i plus a share of f.

The box ends where the common points do: the farthest of them along an axis is the pose of the same robot
under a load along that axis, and bounds of that are proved as those of any pose (``one_call.balls_pose``).
"""

from __future__ import annotations

import numpy as np

from cdpr_interval.exact.enclosure import Bounds
from solvers.point_mass.arrays import RobotArrays
from solvers.point_mass.one_call import DECIDED, balls_pose
from solvers.point_mass.rationals.emptiness import deepest_point

SHAVINGS = 20
"""Times that all balls cut the box."""
MARGIN = 1e-12
"""By which every bound is moved outwards, relative to the robot's size: rounding is some 1e-15."""


def reachable(arrays: RobotArrays, lengths: Bounds, in_plane: bool = True) -> Bounds:
    """Return a box (3, 2) in m around the platform origins that all cables reach and where a pose may be.

    Of inextensible cables.
    ``in_plane``: exit points in a plane are there exactly, and so is the load.
    """
    unit = arrays.frame[0, 0]
    exits, longest = arrays.exit_bounds.mean(axis=-1), lengths[:, 1] / unit
    margin = MARGIN * float(np.abs(exits).max() + longest.max())
    with np.errstate(all="ignore"):
        box = _within_radii(exits, longest, margin)
        for j in range(3):
            if in_plane and arrays.load_exact[j] == 0 and not arrays.exit_bounds[:, j].any():
                # The exit points are measured from the first one: all are in the plane through it.
                box[:, j] = -margin, margin
        for _ in range(SHAVINGS):
            for exit_point, size in zip(exits, longest, strict=True):
                nearest = (np.clip(exit_point, box[0], box[1]) - exit_point) ** 2
                room = np.sqrt(np.maximum(size**2 - (nearest.sum() - nearest), 0.0)) + margin
                box = _cut(box, exit_point - room, exit_point + room)
        found = np.asarray(box.T * unit + arrays.frame[2:5])
    for j in range(3):
        found[j] = _extent(arrays, lengths, j, found[j])
    return found


def _extent(arrays: RobotArrays, lengths: Bounds, axis: int, known: Bounds) -> Bounds:
    """Return bounds (2,) of the common points along an axis, within those known; m."""
    count = len(lengths)
    longest = np.repeat(lengths[:, 1:], 2, axis=1)
    states, ends = np.empty(count, dtype=np.int64), known.copy()
    for k, direction in enumerate((-1.0, 1.0)):
        load, bounds = np.zeros((3, 2)), np.empty((4 + 2 * count, 2))
        load[axis] = direction
        if balls_pose(arrays.exit_bounds, longest, load, arrays.frame, bounds, states) == DECIDED:
            ends[k] = (max if k == 0 else min)(known[k], bounds[axis, k])
    return ends if ends[0] <= ends[1] else known


def _within_radii(exits: Bounds, longest: Bounds, margin: float) -> Bounds:
    """Return a box (2, 3), lows and highs, around the common points: of all balls, and of a small one."""
    box = np.array([(exits - longest[:, None]).max(axis=0), (exits + longest[:, None]).min(axis=0)])
    box = np.array([box.min(axis=0) - margin, box.max(axis=0) + margin])
    weights, _ = deepest_point(exits, longest)
    few, shares = list(weights), np.array(list(weights.values())) / sum(weights.values())
    centre = shares @ exits[few]
    left = shares @ (longest[few] ** 2 - ((exits[few] - centre) ** 2).sum(axis=1))
    radius = np.sqrt(max(left, 0.0) + margin * longest.max()) + margin
    return _cut(box, centre - radius, centre + radius)


def _cut(box: Bounds, low: Bounds, high: Bounds) -> Bounds:
    """Return what of a box is in another one; the box where that is nothing, or no numbers."""
    part = np.array([np.maximum(box[0], low), np.minimum(box[1], high)])
    return part if bool((part[0] <= part[1]).all()) else box
