"""Inextensible poses where a cable is just taut or slack: the pose is proved, states as far as they go.

With a point strictly inside all balls (Slater's condition) the lowest point of the balls exists, is
unique, and carries multipliers; by Caratheodory's theorem every multiplier vector is a mean of vectors
that live on at most three cables with independent directions. So the pose lies in the hull of the
enclosures of all such subsets that cannot be excluded, and a cable outside all of them has no tension.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from itertools import combinations, islice

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact.enclosure import Bounds
from solvers.point_mass.arrays import Cables, RobotArrays, is_range
from solvers.point_mass.candidates import candidates
from solvers.point_mass.duality import duality_box, feasible_near, inside_all, largest_tension
from solvers.point_mass.fields import OPEN, SLACK, TAUT, distance
from solvers.point_mass.one_call import guess_inextensible, middles
from solvers.point_mass.rationals.emptiness import deepest_point
from solvers.point_mass.rationals.surd import corners
from solvers.point_mass.switching import dependent, just_switching, tensions_unique

NOT_UNIQUE = "cables {{{}}} tight, tensions not unique"
MAY_DIFFER = "cables {{{}}} tight up to rounding, tensions may not be unique"
CHANGES = "which of the cables {{{}}} are taut changes over the ranges"
CHANGING = "which of the cables {{{}}} are taut changes over the ranges or is not decided"
TOUCHING = (
    "no point is proved to lie strictly within all cables' lengths: "
    "the pose may be missing or its tensions unbounded"
)


@dataclass(frozen=True, eq=False)
class Enclosed:
    """A pose proved to exist and to be unique for all lengths, in the kernels' units."""

    box: Bounds
    """(3, 2)."""
    tension: Bounds
    """(N, 2)."""
    states: NDArray[np.int64]
    """(N,) ``SLACK``, ``TAUT``, ``OPEN`` or ``SWITCHING``."""
    note: str = ""


def settle_balls(
    arrays: RobotArrays, cables: Cables, exact: Sequence[Fraction] | None = None
) -> Enclosed | str:
    """Enclose the pose of inextensible cables without knowing which of them are taut.

    Parameters
    ----------
    arrays, cables
        The robot, and its cables as the kernels know them.
    exact : sequence of Fraction, optional
        The lengths in m, where they are no ranges.

    Returns
    -------
    Enclosed or str
        The reason where not even the pose is proved.
    """
    _, points, lengths, _, _ = cables
    load = arrays.load
    A, L, _, f = middles(cables, load)
    shortest = np.ascontiguousarray(lengths[:, 0])
    _, deep = deepest_point(A, shortest)
    if not inside_all(cables, deep):
        return TOUCHING
    outer = outer_box(cables, load, A, L, f, deep)
    if outer is None:
        return "the numbers are too large or too small to bound the pose"
    count = len(L)
    near = tuple(i for i in range(count) if not distance(points, i, outer)[1] < lengths[i, 0])
    most = np.zeros(count)
    for i in near:
        most[i] = largest_tension(cables, load, outer, deep, i)
    subsets = _independent_subsets(arrays, near)
    boxes, tensions = np.empty((len(subsets), 3, 2)), np.empty((len(subsets), count, 2))
    kept = candidates(cables, load, (A, L, f), subsets, outer, most, boxes, tensions)
    if kept.any():
        merged = _merge(arrays, cables, boxes[kept], tensions[kept])
        few = [tuple(row[1 : 1 + row[0]].tolist()) for row in subsets[kept]]
        tight = [] if exact is None or not merged.note else tight_without_unique_tensions(arrays, exact, few)
        return replace(merged, note=NOT_UNIQUE.format(_names(arrays, tight))) if tight else merged
    # Rounding cannot exclude everything; keep the proved box and leave every state open.
    unknown = np.column_stack([np.zeros(count), most])
    return _merge(arrays, cables, outer[None], unknown[None])


@lru_cache(maxsize=64)
def _independent_subsets(arrays: RobotArrays, near: tuple[int, ...]) -> NDArray[np.int64]:
    """Return the subsets of 1 to 3 of the cables ``near`` with independent directions, (K, 4): size, indices.

    Kept by robot and load: the exact test takes longer than all the rest of a solution.
    """
    exits = arrays.exits
    rows = [
        (size, *taut, *[0] * (3 - size))
        for size in range(1, min(3, len(near)) + 1)
        for taut in combinations(near, size)
        if not dependent(exits, taut, arrays.load_exact)
    ]
    return np.array(rows, dtype=np.int64).reshape(-1, 4)


def outer_box(cables: Cables, load: Bounds, A: Bounds, L: Bounds, f: Bounds, deep: Bounds) -> Bounds | None:
    """Bound the pose by the duality gap between a guess and a feasible point."""
    count = len(L)
    taut = np.zeros(max(count, 4), dtype=np.int64)
    x = np.zeros(3 + max(count, 4))
    t = np.zeros(count)
    _, m = guess_inextensible(A, L, f, taut, x)
    t[taut[:m]] = np.maximum(x[3 : 3 + m], 0.0)
    if not (np.isfinite(t).all() and t.sum() > 0.0):
        t = np.ones(count)
    start = x[:3].copy()
    guess_inextensible(A, np.ascontiguousarray(cables[2][:, 0]), f, taut, x)
    best: Bounds | None = None
    for p in (start, x[:3].copy(), deep):
        q = np.empty(3)
        box = np.empty((3, 2))
        if not (np.isfinite(p).all() and feasible_near(cables, p, deep, q)):
            continue
        if duality_box(cables, load, t, q, box) and (best is None or _width(box) < _width(best)):
            best = box
    return best


def _width(box: Bounds) -> float:
    return float((box[:, 1] - box[:, 0]).max())


def _merge(arrays: RobotArrays, cables: Cables, boxes: Bounds, tensions: Bounds) -> Enclosed:
    """Return the hull of all candidates, with the states and tensions that hold for all of them.

    Parameters
    ----------
    boxes, tensions
        The pose (K, 3, 2) and the tensions (K, N, 2) of each.
    """
    lengths = cables[2]
    box = np.column_stack([boxes[:, :, 0].min(axis=0), boxes[:, :, 1].max(axis=0)])
    tension = np.column_stack([tensions[:, :, 0].min(axis=0), tensions[:, :, 1].max(axis=0)])
    states = np.full(len(tension), SLACK, dtype=np.int64)
    states[tension[:, 1] > 0.0] = OPEN
    states[tension[:, 0] > 0.0] = TAUT
    if not is_range(lengths):
        states = just_switching(arrays, cables, box, tension, states)
    return Enclosed(box, tension, states, open_note(arrays, lengths, states))


def tight_without_unique_tensions(
    arrays: RobotArrays, lengths: Sequence[Fraction], subsets: Sequence[tuple[int, ...]]
) -> list[int]:
    """Return the exactly tight cables where two of the subsets hold the load alone; empty elsewhere."""
    exits = arrays.exits
    found = list(islice(corners(exits, lengths, arrays.load_exact, subsets), 2))
    if len(found) < 2:
        return []
    _, pose = found[0]
    return [i for i, (a, s) in enumerate(zip(exits, lengths, strict=True)) if pose.excess(a, s) == 0]


def _names(arrays: RobotArrays, chosen: Sequence[int]) -> str:
    return ", ".join(arrays.robot.cable_names[i] for i in chosen)


def open_note(arrays: RobotArrays, lengths: Bounds, states: NDArray[np.int64]) -> str:
    """Return what is to be said of cables that are not proved taut or slack; empty where all are."""
    tight, just = np.flatnonzero(states != SLACK).tolist(), np.flatnonzero(states > TAUT).tolist()
    if not just:
        return ""
    listed, those = _names(arrays, tight), _names(arrays, just)
    if is_range(lengths):
        return (CHANGING if (states == OPEN).any() else CHANGES).format(listed)
    if not tensions_unique(arrays, lengths, tight):
        return MAY_DIFFER.format(listed)
    return (
        f"whether {those} taut is not decided"
        if (states == OPEN).any()
        else f"{those} just taut or just slack"
    )
