"""The poses of a point mass on routed cables over ranges, cut until each part is proved in one call."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.stability import Stability
from solvers.point_mass.arrays import is_range
from solvers.point_mass.entry import Fields, hull, unpacked
from solvers.point_mass.fields import OPEN
from solvers.point_mass.one_call import DECIDED
from solvers.routed_mass.data import RoutedMass
from solvers.routed_mass.pose import (
    Effort,
    Found,
    data_for,
    find_poses,
    hangs_outward,
    noted,
    quick_pose,
    stability_of,
)

Part = tuple[RoutedMass, Bounds, Fields]
"""A robot, (N, 2) lengths in m, and the only pose."""
VAGUE = 0.02
"""Share of the load up to which its range is not cut: tensions are proved within it."""
CHANGES = "taut for some choices, slack for others, or not decided: {}"
PIECES = 64
"""Most parts that ranges are cut into: some ten milliseconds."""


def find_all(mass: RoutedMass, lengths: Bounds, effort: Effort) -> Found:
    """Find every static pose for all lengths (N, 2) in m; guarantee as `find_poses`.

    Over ranges whose parts have one pose each, the pose moves from part to part without a jump.
    """
    parts = _parts(mass, lengths) if is_range(lengths) or _share(mass) > 0.0 else None
    if parts is None:
        return find_poses(mass, lengths, effort)
    looked = [(part, data_for(part, piece), fields) for part, piece, fields in parts]
    outward = all(hangs_outward(*one) for one in looked)
    stable = all(stability_of(*one) is Stability.STABLE for one in looked)
    stability = Stability.STABLE if stable else Stability.UNDECIDED
    whole = hull([fields for _, _, fields in parts])
    if len(parts) > 1 and whole.is_open:
        names = [mass.robot.cable_names[i] for i in np.flatnonzero(whole.states == OPEN)]
        whole = replace(whole, note=CHANGES.format(", ".join(names)))
    else:
        whole = noted(whole, mass)
    return Found((whole,), (stability,), by_convexity=outward)


def _share(mass: RoutedMass) -> float:
    """Return how wide the load's widest component is, as a share of the load; rounding counts as none."""
    width = float((mass.load[:, 1] - mass.load[:, 0]).max() / np.abs(mass.load).max())
    return width if width > 1e-12 else 0.0


def _parts(mass: RoutedMass, lengths: Bounds) -> list[Part] | None:
    """Return the parts of the ranges, each with its only pose; None where a part is not proved."""
    todo, found = [(mass, lengths)], list[Part]()
    used = 0
    while todo:
        part, piece = todo.pop()
        status, bounds, states = quick_pose(part, piece)
        used += 1
        if status == DECIDED:
            found.append((part, piece, unpacked(bounds, states)))
            continue
        halves = _halved(part, piece)
        if used + len(todo) >= PIECES or not halves:
            return None
        todo += halves
    return found


def _halved(mass: RoutedMass, lengths: Bounds) -> list[tuple[RoutedMass, Bounds]]:
    """Cut the load where it is vague, else the widest length; nothing where both are exact."""
    if _share(mass) > VAGUE:
        row = int((mass.load[:, 1] - mass.load[:, 0]).argmax())
        return [(replace(mass, load=half), lengths) for half in _cut(mass.load, row)]
    row = int((lengths[:, 1] - lengths[:, 0]).argmax())
    if not lengths[row, 1] - lengths[row, 0] > 1e-12 * lengths[row, 1]:
        return []
    return [(mass, half) for half in _cut(lengths, row)]


def _cut(bounds: Bounds, row: int) -> list[Bounds]:
    """Return bounds (n, 2) with one row in two halves."""
    low, high = bounds.copy(), bounds.copy()
    low[row, 1] = high[row, 0] = 0.5 * bounds[row].sum()
    return [low, high]
