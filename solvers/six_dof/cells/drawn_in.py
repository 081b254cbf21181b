"""What is left of undecided cells where lengths are kept: no cable longer than it is, no taut one shorter.

A cell of a taut subset is a box of rotations; its positions are what the taut cables' lengths leave. That
each other cable has to reach there, too, is asked of the whole cell by the search. Here every cable's ball
cuts the box of positions, and cells are halved in their rotations.

Cables in oblique directions cut a box together, not one by one. With p_0 the middle of the box, h half its
diagonal, C_i = A_i - R b_i and n_i the direction from C_i to p_0, at the distance d_i,

    d_i' = n_i . (p - C_i) <= |p - C_i| <= d_i' + h^2 / (2 (d_i - h)),

so that n_i . (p - p_0) is at most l_i - d_i, and of a taut cable at least l_i - d_i - h^2 / (2 (d_i - h)).
Each three cables whose directions make up that of an axis so bound p along it.
"""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.mechanics.six_dof.arrays import Model
from solvers.six_dof.cells.lift import turned_arms

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SHAVINGS = 3
"""Times that all balls cut a box."""
ROUNDING = 1e-13
"""Error of a distance over the sum of the sizes of its terms, see `lift`."""
MOST_BOXES = 2**15
"""Boxes that cells are halved into,"""
MOST_WORK = 2**18
"""and these times the threes of cables: bounds of time and memory."""
HALVINGS = 15
SUPPORTS = 2
"""Times that three balls together cut a box, in each of its axes."""
SIGNS = (-1.0, 1.0)


def drawn_in(model: Model, charts: Floats, poses: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Cut boxes of poses to where no cable is longer than its length, and no taut one shorter.

    Parameters
    ----------
    model : Model
    charts : (C,)
        Charts of the boxes.
    poses : (C, 6, 2)
        Bounds of u, within [-1, 1], and of p (the unit of length of the model); NaN where p has none.

    Returns
    -------
    poses, kept : (C, 6, 2), (C,)
        Hulls of what is left of the boxes, and whether anything is.

    Guarantee: R(u) and R(v) differ by an angle of at most 2 |u - v|, which moves C_i by at most
    2 |u - v| |b_i|: over a box the distances from C_i at the middle rotation are the lengths but for that,
    for all data in their enclosures.
    """
    whole, owners = poses.copy(), np.arange(len(poses))
    for k in (0, 1):
        whole[:, 3:, k] = np.where(np.isnan(poses[:, 3:, k]), SIGNS[k] * np.inf, poses[:, 3:, k])
    most = min(MOST_BOXES, MOST_WORK // max(math.comb(_count(model), 3), 1))
    for halving in range(HALVINGS + 1):
        whole, kept = _cut(model, charts[owners], whole)
        whole, owners = whole[kept], owners[kept]
        if halving == HALVINGS or 2 * len(whole) > most or not len(whole):
            break
        whole, owners = _halved(whole), np.repeat(owners, 2)
    found, left = np.empty_like(poses), np.zeros(len(poses), dtype=np.bool_)
    found[:, :, 0], found[:, :, 1], left[owners] = np.inf, -np.inf, True
    np.minimum.at(found[:, :, 0], owners, whole[:, :, 0])
    np.maximum.at(found[:, :, 1], owners, whole[:, :, 1])
    return found, left


def _count(model: Model) -> int:
    """Return how many cables keep their lengths: those whose slackness is not looked at may be longer."""
    return len(model.lengths) if model.slack else model.n_taut


def _halved(boxes: Floats) -> Floats:
    """Return boxes (2 B, 6, 2), each halved across its widest entry of u; halves behind each other."""
    found = np.repeat(boxes, 2, axis=0)
    axis = (boxes[:, :3, 1] - boxes[:, :3, 0]).argmax(axis=1)
    rows = np.arange(len(boxes))
    middle = 0.5 * boxes[rows, axis, 0] + 0.5 * boxes[rows, axis, 1]
    found[2 * rows, axis, 1] = middle
    found[2 * rows + 1, axis, 0] = middle
    return found


def _cut(model: Model, charts: Floats, boxes: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return boxes with positions cut by the ball of each cable, and which of them are not empty."""
    count = _count(model)
    with np.errstate(all="ignore"):
        centres, reach, least = _shells(model, charts, boxes, count)
        lo, hi = boxes[:, 3:, 0].copy(), boxes[:, 3:, 1].copy()
        kept = np.ones(len(boxes), dtype=np.bool_)
        for _ in range(SHAVINGS):
            for i in range(count):
                c, r = centres[:, i], reach[:, i]
                away = (np.clip(c, lo, hi) - c) ** 2
                total = away.sum(axis=1)
                kept &= ~(total > r * r * (1.0 + ROUNDING))
                room = np.sqrt(np.maximum((r * r)[:, None] - (total[:, None] - away), 0.0))
                room += ROUNDING * (r[:, None] + np.abs(c))
                lo, hi = np.maximum(lo, c - room), np.minimum(hi, c + room)
                kept &= ~(lo > hi).any(axis=1)
        for _ in range(SUPPORTS):
            bounded = kept & np.isfinite(lo).all(axis=1) & np.isfinite(hi).all(axis=1)
            given = (centres[bounded], reach[bounded], least[bounded], lo[bounded], hi[bounded])
            low, high = _along_axes(*given)
            lo[bounded], hi[bounded] = np.maximum(lo[bounded], low), np.minimum(hi[bounded], high)
            kept &= ~(lo > hi).any(axis=1)
    found = boxes.copy()
    found[:, 3:, 0], found[:, 3:, 1] = np.minimum(lo, hi), np.maximum(lo, hi)
    return found, kept


def _along_axes(
    centres: Floats, reach: Floats, least: Floats, lo: Floats, hi: Floats
) -> tuple[Floats, Floats]:
    """Return bounds (B, 3) of p by each three cables together, least (B, N) <= |p - C_i| <= reach (B, N)."""
    middle, half = 0.5 * lo + 0.5 * hi, np.linalg.norm(0.5 * (hi - lo), axis=1) * (1.0 + ROUNDING)
    away = middle[:, None] - centres
    distance = np.linalg.norm(away, axis=2)
    normals = away / distance[:, :, None]
    size = ROUNDING * (np.abs(centres).sum(axis=2) + np.abs(middle).sum(axis=1)[:, None] + reach)
    farther = reach - distance + size
    bulge = half[:, None] ** 2 / (2.0 * (distance - half[:, None]))
    nearer = np.where(distance > 2.0 * half[:, None], distance - least + bulge + size, np.inf)
    best = np.full((2, 3, len(lo)), np.inf)
    for triple in map(list, combinations(range(reach.shape[1]), 3)):
        shares = _inverse(normals[:, triple])
        up, down = farther[:, triple], nearer[:, triple]
        for j in range(3):
            share = shares[:, j]
            # What the three directions miss of the axis, by rounding.
            missing = np.abs((share[:, :, None] * normals[:, triple]).sum(axis=1) - np.eye(3)[j]).sum(axis=1)
            slack = (missing + ROUNDING * np.abs(share).sum(axis=1)) * half
            for k, signed in enumerate((-share, share)):
                parts = np.where(signed >= 0.0, signed * up, -signed * down)
                best[k, j] = np.fmin(best[k, j], parts.sum(axis=1) + slack)
    margin = ROUNDING * np.abs(middle)
    return middle - best[0].T - margin, middle + best[1].T + margin


def _inverse(matrices: Floats) -> Floats:
    """Return the transposed inverses of matrices (B, 3, 3); NaN of those that have none."""
    a, b, c = matrices[:, 0], matrices[:, 1], matrices[:, 2]
    first, second, third = np.cross(b, c), np.cross(c, a), np.cross(a, b)
    volume = (a * first).sum(axis=1)
    return np.stack([first, second, third], axis=2) / volume[:, None, None]


def _shells(model: Model, charts: Floats, boxes: Floats, count: int) -> tuple[Floats, Floats, Floats]:
    """Return centres (B, N, 3), and how far from them p is at most and at least (B, N), for all rotations.

    Of cables that may be slack the least is minus infinity.
    """
    middle = 0.5 * boxes[:, :3, 0] + 0.5 * boxes[:, :3, 1]
    radius = np.maximum(boxes[:, :3, 1] - middle, middle - boxes[:, :3, 0])
    length = np.linalg.norm(model.arms[0, :count], axis=1)
    turn = np.linalg.norm(radius, axis=1)
    size = np.abs(model.exits[:count]).sum(axis=1) + length + model.lengths[:count, 1]
    error = (model.exits_err[:count] + model.arms_err[:count]).sum(axis=1) + ROUNDING * size
    off = 2.0 * turn[:, None] * length * (1.0 + ROUNDING) + error
    is_taut = np.arange(count) < model.n_taut
    least = np.where(is_taut, model.lengths[:count, 0] - off, -np.inf)
    centres = model.exits[:count] - turned_arms(model, charts, middle, count)
    return centres, model.lengths[:count, 1] + off, least
