"""The pose of a point mass for every choice of its data: one for each, by convexity, in sharp bounds.

Existence and the sets of cables that may carry the load are proved by the kernels over boxes of choices; the
least and largest values of position and tensions follow by `solvers.point_mass.ranges.extremes`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from flint import arb
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import Bounds
from solvers.point_mass.convex import (
    PARTLY,
    Finding,
    Unproved,
    quick_pose,
    scaled_cables,
)
from solvers.point_mass.cover import box_around, choices_of, cover, examine
from solvers.point_mass.degenerate import CHANGES, CHANGING, outer_box
from solvers.point_mass.duality import inside_all, largest_tension
from solvers.point_mass.elastic import settle_springs
from solvers.point_mass.entry import Fields, fields_of
from solvers.point_mass.fields import OPEN, SLACK, SWITCHING, TAUT
from solvers.point_mass.one_call import DECIDED, middles
from solvers.point_mass.ranges.choices import Choices, around_middles
from solvers.point_mass.ranges.extremes import Extremes, Part
from solvers.point_mass.ranges.sensitivity import Balls, Output, System, enclosed, position
from solvers.point_mass.rationals.emptiness import deepest_point
from solvers.point_mass.reach import reachable
from solvers.questions.problem import Problem

BUDGET = 40
"""Boxes examined to make bounds sharp: half a millisecond each."""
SAMPLES = 24
"""Choices at which an open cable is looked at, to see whether it switches."""
STRETCHES = 3
"""Times that tensions are bounded anew by poses, and poses by tensions."""
VANISHES = "the load may vanish within its ranges"


def find_over_choices(problem: Problem) -> Finding:
    """Find the pose for every choice of the data.

    Guarantee
    ---------
    Fields: for every choice there is exactly one static pose, and the fields enclose it. NoPose: there is
    none for any choice. Unproved: for every choice the pose, where there is one, lies in the box.
    """
    choices = choices_of(problem)
    if choices is None:
        everywhere = np.tile([-np.inf, np.inf], (3, 1))
        return Unproved(VANISHES, everywhere)
    with balls.precision():
        parts, open_boxes, empty, reason = cover(choices)
        if not parts and not open_boxes:
            assert empty is not None
            return empty
        if open_boxes or empty is not None:
            return _region(choices, parts, open_boxes, PARTLY if empty is not None else reason)
        if choices.arrays.is_elastic and not all(part.is_sharp for part in parts):
            return _as_inextensible(choices, parts) or _fields(choices, choices, parts)
        return _fields(choices, choices, parts)


def _as_inextensible(choices: Choices, parts: list[Part]) -> Fields | None:
    """Return the pose of springs over wide ranges as that of inextensible cables; None: that shows nothing.

    The pose is the lowest point of the balls of the stretched lengths h_i: it is the pose of the robot on
    inextensible cables whose lengths go from l_i to the largest h_i. Its tensions are a mean of those that at
    most three of these cables have there (Caratheodory), so their bounds hold too.
    """
    twin = _stretched(choices, _first_multipliers(choices, _coarse(parts)))
    found: tuple[Choices, list[Part]] | None = None
    for _ in range(STRETCHES):
        if twin is None:
            break
        covered, left, empty, _ = cover(twin)
        if left or empty is not None or not covered or not all(part.is_sharp for part in covered):
            break
        found = twin, covered
        twin = _stretched(choices, _multipliers(covered, choices.count))
    return None if found is None else _fields(choices, *found)


def _first_multipliers(choices: Choices, box: Bounds) -> NDArray[np.float64] | None:
    """Bound the multipliers (N,) by what the load does on the way from a point deep inside all balls."""
    arrays, lengths = choices.kernel_arrays(), choices.lengths
    cables = scaled_cables(arrays, lengths)
    A, _, _, _ = middles(cables, arrays.load)
    _, deep = deepest_point(A, np.ascontiguousarray(cables[2][:, 0]))
    if not inside_all(cables, deep):
        return None
    pulls = [largest_tension(cables, arrays.load, box, deep, i) for i in range(choices.count)]
    return np.array(pulls) / cables[2][:, 1] * (1.0 + 1e-12)


def _multipliers(parts: list[Part], count: int) -> NDArray[np.float64]:
    """Return upper bounds (N,) of the multipliers over all parts."""
    most = np.zeros(count)
    for part in parts:
        scale = float(part.choices.bounds[-1, 1])
        for system in part.systems:
            zero = enclosed(system, part.choices)
            assert zero is not None
            for cable, t in zip(system.taut, zero.box[3:], strict=True):
                most[cable] = max(most[cable], balls.to_bounds(t)[1] * scale * (1.0 + 1e-12))
    return most


def _stretched(choices: Choices, multipliers: NDArray[np.float64] | None) -> Choices | None:
    """Return the choices of the inextensible robot whose lengths go up to what springs stretch to."""
    if multipliers is None or not np.isfinite(multipliers).all():
        return None
    n, arrays = choices.count, choices.arrays
    bounds = choices.bounds.copy()
    longest, weakest = bounds[:n, 1], bounds[4 * n : 5 * n, 0]
    k = np.where(arrays.constant, weakest, weakest / longest)
    if not (multipliers < 0.9 * k).all():
        return None
    bounds[:n, 1] = longest * k / (k - multipliers) * (1.0 + 1e-12)
    bounds[4 * n : 5 * n] = 0.0
    least = float(bounds[-1, 0])
    if not least > 0.0:
        return None
    bounds[5 * n : 5 * n + 3] *= (1.0 + 1e-12) / least
    cables = tuple(replace(cable, elasticity=None) for cable in arrays.robot.cables)
    robot = replace(arrays.robot, cables=cables)
    return Choices(replace(arrays, robot=robot, elastic=np.zeros(n, dtype=np.bool_)), bounds)


def _fields(asked: Choices, choices: Choices, parts: list[Part]) -> Fields:
    """Return what is reported of the pose of every choice: those asked for, which others may stand for."""
    arrays, lengths = choices.kernel_arrays(), choices.lengths
    cables = scaled_cables(arrays, lengths)
    search = Extremes(parts, _examined, BUDGET)
    coarse = _coarse(parts)
    box = np.array([search.range_of(_coordinate(j)) or coarse[j] for j in range(3)], dtype=np.float64)
    box[:, 0], box[:, 1] = np.maximum(box[:, 0], coarse[:, 0]), np.minimum(box[:, 1], coarse[:, 1])
    scale = (1.0, 1.0) if arrays.is_elastic else tuple(choices.bounds[-1].tolist())
    tension, states = np.zeros((choices.count, 2)), np.full(choices.count, SLACK)
    for i in range(choices.count):
        tension[i] = _tension(choices, parts, search, i, scale)
        if tension[i, 1] > 0.0:
            states[i] = TAUT if tension[i, 0] > 0.0 else OPEN
    note = ""
    if (states == OPEN).any():
        states = _with_switches(asked, states)
        names = ", ".join(choices.arrays.robot.cable_names[i] for i in np.flatnonzero(states != SLACK))
        text = CHANGING if (states == OPEN).any() else CHANGES
        note = text.format(names)
    return fields_of(cables, arrays.frame, box, tension, states, note)


def _examined(choices: Choices) -> Part | None:
    part = examine(choices)
    return part if isinstance(part, Part) and part.is_sharp else None


def _coordinate(axis: int):  # type: ignore[no-untyped-def]
    return lambda system, x, d: position(axis, x)


def _tension(
    choices: Choices, parts: list[Part], search: Extremes, cable: int, scale: tuple[float, ...]
) -> tuple[float, float]:
    """Return bounds of a tension in units of force."""
    if not any(cable in system.taut for part in parts for system in part.systems):
        return (0.0, 0.0) if all(part.is_sharp for part in parts) else (0.0, np.inf)

    def measure(system: System, x: Balls, d: Balls) -> Output:
        return system.tension(cable, x, d)

    found = search.range_of(measure)
    if found is None:
        return 0.0, np.inf
    lo, hi = max(found[0], 0.0), max(found[1], 0.0)
    with balls.precision():
        low, high = balls.to_bounds(arb(lo) * arb(scale[0])), balls.to_bounds(arb(hi) * arb(scale[1]))
    return low[0], high[1]


def _coarse(parts: Sequence[Part]) -> Bounds:
    """Return a box (3, 2) in the kernels' units around the poses of all parts."""
    return box_around([_part_box(part) for part in parts])


def _part_box(part: Part) -> Bounds:
    if part.is_sharp:
        zeros = [enclosed(system, part.choices) for system in part.systems]
        rows = [[balls.to_bounds(x) for x in zero.box[:3]] for zero in zeros if zero is not None]
        found = np.array(rows)
        return np.column_stack([found[:, :, 0].min(axis=0), found[:, :, 1].max(axis=0)])
    arrays = part.choices.kernel_arrays()
    cables = scaled_cables(arrays, part.choices.lengths)
    if arrays.is_elastic:
        return settle_springs(arrays, cables).box
    A, L, _, f = middles(cables, arrays.load)
    _, deep = deepest_point(A, np.ascontiguousarray(cables[2][:, 0]))
    outer = outer_box(cables, arrays.load, A, L, f, deep)
    assert outer is not None
    return outer


def _with_switches(choices: Choices, states: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the states with the cables that are proved taut at one choice and slack at another."""
    seen = [set[int]() for _ in states]
    rng = np.random.default_rng(0)
    low, width = choices.bounds[:, 0], choices.bounds[:, 1] - choices.bounds[:, 0]
    for k in range(SAMPLES * int((states == OPEN).sum())):
        share = rng.random(len(low))
        chosen = np.clip(low + width * (np.rint(share) if k % 2 else share), low, choices.bounds[:, 1])
        one = Choices(choices.arrays, np.column_stack([chosen, chosen]))
        status, _, found = quick_pose(one.kernel_arrays(), one.lengths)
        if status == DECIDED:
            for i, state in enumerate(found.tolist()):
                seen[i].add(state)
    changed = np.array([{TAUT, SLACK} <= one for one in seen])
    return np.where((states == OPEN) & changed, SWITCHING, states)


def _region(choices: Choices, parts: list[Part], left: list[Choices], reason: str) -> Unproved:
    """Return where the pose of any choice is."""
    unit, shift = choices.arrays.frame[0, 0], choices.arrays.frame[2:5]
    boxes = [_part_box(part) * unit + shift for part in parts]
    boxes += [_held(box, reachable(*around_middles(box), in_plane=False)) for box in left]
    whole = box_around(boxes)
    margin = 1e-12 * np.abs(whole).max()
    return Unproved(reason, whole + np.array([-margin, margin]))


def _held(choices: Choices, box: Bounds) -> Bounds:
    """Return the part of a box (m) where cables can hold the load: p is a mean of exits plus a share of f."""
    n = choices.count
    unit, shift = choices.arrays.frame[0, 0], choices.arrays.frame[2:5]
    exits = choices.bounds[n : 4 * n].reshape(n, 3, 2) * unit
    load = choices.kernel_arrays().load
    found = box.copy()
    for j in range(3):
        if load[j, 0] >= 0.0:
            found[j, 0] = max(found[j, 0], exits[:, j, 0].min() + shift[j, 0])
        if load[j, 1] <= 0.0:
            found[j, 1] = min(found[j, 1], exits[:, j, 1].max() + shift[j, 1])
    return found if bool((found[:, 0] <= found[:, 1]).all()) else box
