"""Inextensible poses where a cable is just taut or slack: the pose is proved, states as far as they go.

With a point strictly inside all balls (Slater's condition) the lowest point of the balls exists, is
unique, and carries multipliers; by Caratheodory's theorem every multiplier vector is a mean of vectors
that live on at most three cables with independent directions. So the pose lies in the hull of the
enclosures of all such subsets that cannot be excluded, and a cable outside all of them has no tension.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.robots.model import Robot, Vector
from solvers.point_mass_duality import (
    closed_form_exists,
    duality_box,
    feasible_near,
    inside_all,
    largest_tension,
)
from solvers.point_mass_emptiness import deepest_point
from solvers.point_mass_fields import OPEN, SLACK, TAUT, distance
from solvers.point_mass_kernels import anywhere, guess_inextensible, middles, tension_bounds
from solvers.point_mass_lowest import lowest_of_subset
from solvers.point_mass_model import Cables, is_range
from solvers.point_mass_newton import krawczyk
from solvers.result import Bounds

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
    """(N,) ``SLACK``, ``TAUT`` or ``OPEN``."""
    note: str = ""


class Candidate(NamedTuple):
    """A subset that may carry the load, with enclosures of its pose and tensions (N, 2)."""

    taut: tuple[int, ...]
    box: Bounds
    tension: Bounds


def settle_balls(cables: Cables, load: Bounds, robot: Robot, exact_load: Vector) -> Enclosed | str:
    """Enclose the pose of inextensible cables without knowing which of them are taut.

    Returns
    -------
    Enclosed or str
        The reason where not even the pose is proved.
    """
    _, points, lengths, _, _ = cables
    A, L, _, f = middles(cables, load)
    shortest = np.ascontiguousarray(lengths[:, 0])
    _, deep = deepest_point(A, shortest)
    if not inside_all(cables, deep):
        return TOUCHING
    outer = _outer_box(cables, load, A, L, f, deep)
    if outer is None:
        return "the numbers are too large or too small to bound the pose"
    anchors = [cable.frame_anchor for cable in robot.cables]
    near = [i for i in range(len(L)) if not distance(points, i, outer)[1] < lengths[i, 0]]
    bounds = {i: largest_tension(cables, load, outer, deep, i) for i in near}
    found = []
    for size in range(1, min(3, len(near)) + 1):
        for taut in combinations(near, size):
            if dependent(anchors, taut, exact_load):
                continue
            candidate = _candidate(cables, load, (A, L, f), taut, outer, bounds)
            if candidate is not None:
                found.append(candidate)
    if not found:
        # Rounding cannot exclude everything; keep the proved box and leave every state open.
        zero = np.zeros((len(L), 2))
        zero[near, 1] = [bounds[i] for i in near]
        found = [Candidate((), outer, zero)]
    return _merge(found, near, robot.cable_names, is_range(cables[2]))


def _outer_box(cables: Cables, load: Bounds, A: Bounds, L: Bounds, f: Bounds, deep: Bounds) -> Bounds | None:
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


def _candidate(
    cables: Cables,
    load: Bounds,
    middle: tuple[Bounds, Bounds, Bounds],
    taut: tuple[int, ...],
    outer: Bounds,
    bounds: dict[int, float],
) -> Candidate | None:
    """Enclose what the subset can contribute; None when it provably carries no positive tensions here.

    The square system of a subset with independent directions has at most one zero whose multipliers
    have a positive sum, so a proved zero with such a sum is the only one that matters.
    """
    A, L, f = middle
    m = len(taut)
    index = np.array([*taut, 0, 0, 0], dtype=np.int64)
    if not closed_form_exists(cables, load, index, m):
        return None
    count = len(L)
    tension = np.zeros((count, 2))
    for i in taut:
        tension[i, 1] = bounds[i]
    box = outer
    p, t = np.empty(3), np.empty(4)
    if lowest_of_subset(A, L, f, index, m, p, t):
        x = np.concatenate([p, t[:m]])
        zero, domain = np.empty((3 + m, 2)), np.empty((3 + m, 2))
        if (
            krawczyk(cables, load, index, m, x, anywhere(3 + m), zero, domain)
            and math.fsum(zero[3:, 0]) > 0.0
        ):
            if (zero[3:, 1] <= 0.0).any():
                return None
            tension_bounds(cables, index, m, zero, tension)
            tension[:, 0] = np.maximum(tension[:, 0], 0.0)
            for i in taut:
                tension[i, 1] = min(tension[i, 1], bounds[i])
            box = np.column_stack(
                [np.maximum(zero[:3, 0], outer[:, 0]), np.minimum(zero[:3, 1], outer[:, 1])]
            )
    if (box[:, 0] > box[:, 1]).any() or (tension[:, 0] > tension[:, 1]).any():
        return None
    for i in range(count):
        if distance(cables[1], i, box)[0] > cables[2][i, 1]:
            return None
    return Candidate(taut, box, tension)


def dependent(anchors: Sequence[Vector], taut: tuple[int, ...], load: Vector) -> bool:
    """Return True when the directions of the cables are dependent at every equilibrium, decided exactly.

    That is so for equal exit points and for three on one line. Two exit points on a line parallel to the
    load, or three in a plane parallel to it, balance it only with multipliers of sum zero, or at a pose
    on that line or plane.
    """
    if any(anchors[i] == anchors[j] for i, j in combinations(taut, 2)):
        return True
    if len(taut) == 1:
        return False
    a = anchors[taut[0]]
    d, *rest = ([x - y for x, y in zip(anchors[i], a, strict=True)] for i in taut[1:])
    other = rest[0] if rest else load
    normal = [d[j - 2] * other[j - 1] - d[j - 1] * other[j - 2] for j in range(3)]
    return not any(normal) or (bool(rest) and sum(n * f for n, f in zip(normal, load, strict=True)) == 0)


def _merge(found: list[Candidate], near: list[int], names: tuple[str, ...], ranges: bool) -> Enclosed:
    """Return the hull of all candidates, with the states and tensions that hold for all of them."""
    box = np.column_stack(
        [np.min([c.box[:, 0] for c in found], axis=0), np.max([c.box[:, 1] for c in found], axis=0)]
    )
    tension = np.column_stack(
        [np.min([c.tension[:, 0] for c in found], axis=0), np.max([c.tension[:, 1] for c in found], axis=0)]
    )
    states = np.full(len(tension), SLACK, dtype=np.int64)
    for i in near:
        if tension[i, 0] > 0.0:
            states[i] = TAUT
        elif tension[i, 1] > 0.0:
            states[i] = OPEN
    note = ""
    if (states == OPEN).any():
        tight = tuple(int(i) for i in np.flatnonzero(states != SLACK))
        listed = f"cables {{{', '.join(names[i] for i in tight)}}}"
        if ranges:
            note = f"which of the {listed} are taut changes over the length ranges or is not decided"
        elif any(c.taut == tight for c in found):
            just = ", ".join(names[i] for i in np.flatnonzero(states == OPEN))
            note = f"{just} just taut or just slack"
        else:
            note = f"{listed} tight, tensions not unique"
    return Enclosed(box, tension, states, note)
