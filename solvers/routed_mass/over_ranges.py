"""The poses of a point mass on routed cables over ranges, cut until each part is proved in one call."""

from __future__ import annotations

import numpy as np

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.stability import Stability
from solvers.point_mass.arrays import is_range
from solvers.point_mass.entry import Fields, hull, unpacked
from solvers.point_mass.one_call import DECIDED
from solvers.routed_mass.data import RoutedMass
from solvers.routed_mass.pose import Effort, Found, find_poses, noted, quick_pose

PIECES = 64
"""Most parts that ranges of lengths are cut into: some ten milliseconds."""


def find_all(mass: RoutedMass, lengths: Bounds, effort: Effort) -> Found:
    """Find every static pose for all lengths (N, 2) in m; guarantee as `find_poses`.

    Over ranges of lengths whose parts have one pose each, the pose moves from part to part without a jump.
    """
    parts = _parts(mass, lengths) if is_range(lengths) else None
    if parts is None:
        return find_poses(mass, lengths, effort)
    return Found((noted(hull(parts), mass),), (Stability.STABLE,))


def _parts(mass: RoutedMass, lengths: Bounds) -> list[Fields] | None:
    """Return the only pose of each part of the ranges; None where a part is not proved."""
    todo, found = [lengths], list[Fields]()
    used = 0
    while todo:
        piece = todo.pop()
        status, bounds, states = quick_pose(mass, piece)
        used += 1
        if status == DECIDED:
            found.append(unpacked(bounds, states))
            continue
        width = piece[:, 1] - piece[:, 0]
        cut = int(width.argmax())
        if used + len(todo) >= PIECES or not width[cut] > 1e-12 * piece[cut, 1]:
            return None
        middle = 0.5 * piece[cut].sum()
        for half in ((piece[cut, 0], middle), (middle, piece[cut, 1])):
            part = np.ascontiguousarray(piece.copy())
            part[cut] = half
            todo.append(part)
    return found
