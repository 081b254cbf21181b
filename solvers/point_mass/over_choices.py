"""The pose of a point mass for every choice of its data: one for each, by convexity, in sharp bounds.

Existence and the sets of cables that may carry the load are proved by the kernels over boxes of choices; the
least and largest values of position and tensions follow by `solvers.point_mass.ranges.extremes`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from flint import arb
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import Bounds
from solvers.point_mass.arrays import RobotArrays
from solvers.point_mass.convex import (
    PARTLY,
    Finding,
    NoPose,
    Unproved,
    quick_pose,
    scaled_cables,
)
from solvers.point_mass.cover import box_around, choices_of, cover, examine
from solvers.point_mass.degenerate import CHANGES, CHANGING, outer_box
from solvers.point_mass.duality import inside_all, largest_tension
from solvers.point_mass.elastic import settle_springs
from solvers.point_mass.entry import Fields, both, fields_of, meet, with_states
from solvers.point_mass.fields import OPEN, SLACK, SWITCHING, TAUT
from solvers.point_mass.one_call import DECIDED, middles
from solvers.point_mass.ranges.choices import Choices, around_middles
from solvers.point_mass.ranges.extremes import Extremes, Part
from solvers.point_mass.ranges.sensitivity import Balls, Output, System, position
from solvers.point_mass.rationals.emptiness import deepest_point
from solvers.point_mass.reach import reachable
from solvers.questions.problem import Problem


class Effort(NamedTuple):
    """What bounds may cost."""

    parts: int
    """Boxes into which choices are cut, before what is left counts as not proved."""
    boxes: int
    """Boxes examined to make bounds sharp after that, some milliseconds each."""


THOROUGH = Effort(48, 40)
QUICK = Effort(16, 10)
"""For a pose that is proved already: where these parts do not do, twice as many seldom do, and they take
longer than all the rest; most bounds are sharp without more boxes."""
SAMPLES = 24
"""Choices at which an open cable is looked at, to see whether it switches."""
STRETCHES = 3
"""Times that tensions are bounded anew by poses, and poses by tensions."""
VANISHES = "the load may vanish within its ranges"
Known = tuple[Bounds, Bounds]
"""Bounds of the pose (3, 2) and of the tensions (N, 2) over all choices, in the kernels' units."""


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
        parts, open_boxes, empty, reason = cover(choices, THOROUGH.parts)
        if not parts and not open_boxes:
            assert empty is not None
            return empty
        if open_boxes or empty is not None:
            return _region(choices, parts, open_boxes, PARTLY if empty is not None else reason)
        known = _known(choices, _coarse(parts))
        found = _sharp_fields(choices, parts, known, THOROUGH)
        return _with_note(choices, _fields(choices, parts, known, 0) if found is None else found)


def sharpened(problem: Problem, arrays: RobotArrays, finding: Finding) -> Finding:
    """Return what is found over ranges of lengths in sharper bounds, where these are soon had.

    Guarantee
    ---------
    That of `find_over_choices`; bounds of a pose are never wider than those given.
    """
    if isinstance(finding, Fields):
        return _sharpened_pose(problem, arrays, finding)
    if isinstance(finding, NoPose):
        return finding
    other = find_over_choices(problem)
    return (
        replace(finding, position=meet(finding.position, other.position))
        if isinstance(other, Unproved)
        else other
    )


def _sharpened_pose(problem: Problem, arrays: RobotArrays, pose: Fields) -> Fields:
    choices = choices_of(problem)
    assert choices is not None, "the load of exact data does not vanish"
    with balls.precision():
        parts, open_boxes, empty, _ = cover(choices, QUICK.parts)
        if open_boxes or empty is not None:
            return pose
        found = _sharp_fields(choices, parts, _in_units(pose, arrays), QUICK)
        return pose if found is None else _with_note(choices, both(pose, found))


def _in_units(pose: Fields, arrays: RobotArrays) -> Known:
    """Return position and tensions in the kernels' units, relative to the first exit point."""
    frame = arrays.frame
    box = (pose.position - frame[2:5, ::-1]) / frame[0, 0]
    tension = pose.tensions / frame[1, 0]
    # Doubled roundings of a subtraction are far below this share.
    margin = 1e-14 * (1.0 + np.abs(pose.position).max() / frame[0, 0] + np.abs(box).max())
    return box + np.array([-margin, margin]), tension


def _sharp_fields(choices: Choices, parts: list[Part], known: Known, effort: Effort) -> Fields | None:
    """Return sharp fields of the pose of every choice, None where the parts are not sharp and show none."""
    if all(part.is_sharp for part in parts):
        return _fields(choices, parts, known, effort.boxes)
    twin = _as_inextensible(choices, known[0], effort.parts) if choices.arrays.is_elastic else None
    return None if twin is None else _fields(*twin, known, effort.boxes)


def _as_inextensible(choices: Choices, box: Bounds, most: int) -> tuple[Choices, list[Part]] | None:
    """Return inextensible cables whose poses hold those of springs over wide ranges; None: it shows nothing.

    The pose is the lowest point of the balls of the stretched lengths h_i: it is the pose of the robot on
    inextensible cables whose lengths go from l_i to the largest h_i. Its tensions are a mean of those that at
    most three of these cables have there (Caratheodory), so their bounds hold too.

    Parameters
    ----------
    choices : Choices
    box : (3, 2)
        Holds the pose of every choice.
    most : int
        Parts into which the twin's choices are cut.
    """
    twin = _stretched(choices, _first_multipliers(choices, box))
    found: tuple[Choices, list[Part]] | None = None
    for _ in range(STRETCHES):
        if twin is None:
            break
        covered, left, empty, _ = cover(twin, most)
        if left or empty is not None or not covered or not all(part.is_sharp for part in covered):
            break
        found = twin, covered
        twin = _stretched(choices, _multipliers(covered, choices.count))
    return found


def _known(choices: Choices, box: Bounds) -> Known:
    """Return a box with what the tensions at the poses in it may be at most."""
    tension = np.tile([0.0, np.inf], (choices.count, 1))
    multipliers, longest = _first_multipliers(choices, box), choices.bounds[: choices.count, 1]
    if choices.arrays.is_elastic:
        twin = _stretched(choices, multipliers)
        longest = np.full(choices.count, np.inf) if twin is None else twin.bounds[: choices.count, 1]
    if multipliers is not None:
        tension[:, 1] = multipliers * longest * (1.0 + 1e-12)
    return box, tension


def _first_multipliers(choices: Choices, box: Bounds) -> NDArray[np.float64] | None:
    """Bound the multipliers (N,) by what the load does on the way from a point deep inside all balls."""
    arrays, lengths = choices.kernel_arrays(), choices.lengths
    cables = scaled_cables(arrays, lengths)
    A, _, _, _ = middles(cables, arrays.load)
    _, deep = deepest_point(A, np.ascontiguousarray(cables[2][:, 0]))
    if not inside_all(cables, deep):
        return None
    pulls = [largest_tension(cables, arrays.load, box, deep, i) for i in range(choices.count)]
    # The kernel's tensions are those of inextensible cables: multipliers times the largest lengths.
    return np.array(pulls) / cables[2][:, 1] * (1.0 + 1e-12)


def _multipliers(parts: list[Part], count: int) -> NDArray[np.float64]:
    """Return upper bounds (N,) of the multipliers over all parts."""
    most = np.zeros(count)
    for part in parts:
        scale = float(part.choices.bounds[-1, 1])
        for system, zero in zip(part.systems, part.zeros, strict=True):
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


def _fields(choices: Choices, parts: list[Part], known: Known, budget: int) -> Fields:
    """Return what is reported of the pose of every choice, within what is known of it."""
    arrays, lengths = choices.kernel_arrays(), choices.lengths
    search = Extremes(parts, _examined, budget)
    box = np.array([search.range_of(_coordinate(j), *known[0][j].tolist()) for j in range(3)])
    scale = (1.0, 1.0) if arrays.is_elastic else tuple(choices.bounds[-1].tolist())
    tension, states = np.zeros((choices.count, 2)), np.full(choices.count, SLACK)
    for i in range(choices.count):
        tension[i] = _tension(parts, search, i, scale, known[1][i])
        if tension[i, 1] > 0.0:
            states[i] = TAUT if tension[i, 0] > 0.0 else OPEN
    return fields_of(scaled_cables(arrays, lengths), arrays.frame, box, tension, states)


def _with_note(choices: Choices, fields: Fields) -> Fields:
    """Return the fields with the cables that switch, and what is to be said of those that are open."""
    states = _with_switches(choices, fields.states)
    if not (states > TAUT).any():
        return with_states(fields, states)
    names = ", ".join(choices.arrays.robot.cable_names[i] for i in np.flatnonzero(states != SLACK))
    return with_states(fields, states, (CHANGING if (states == OPEN).any() else CHANGES).format(names))


def _examined(choices: Choices) -> Part | None:
    part = examine(choices)
    return part if isinstance(part, Part) and part.is_sharp else None


def _coordinate(axis: int):  # type: ignore[no-untyped-def]
    return lambda system, x, d: position(axis, x)


def _tension(
    parts: list[Part], search: Extremes, cable: int, scale: tuple[float, ...], known: Bounds
) -> tuple[float, float]:
    """Return bounds of a tension in units of force."""
    if all(part.is_sharp and not any(cable in s.taut for s in part.systems) for part in parts):
        return 0.0, 0.0

    def measure(system: System, x: Balls, d: Balls) -> Output:
        return system.tension(cable, x, d)

    least, most = known.tolist()
    # Rounding up is done by balls below; what is known holds again at the end.
    lo, hi = search.range_of(measure, least / scale[1], most / scale[0] * (1.0 + 1e-15))
    with balls.precision():
        ends = [balls.to_bounds(arb(max(end, 0.0)) * arb(s)) for end, s in zip((lo, hi), scale, strict=True)]
    return max(ends[0][0], least), min(ends[1][1], most)


def _coarse(parts: Sequence[Part]) -> Bounds:
    """Return a box (3, 2) in the kernels' units around the poses of all parts."""
    return box_around([_part_box(part) for part in parts])


def _part_box(part: Part) -> Bounds:
    if part.is_sharp:
        rows = [[balls.to_bounds(x) for x in zero.box[:3]] for zero in part.zeros if zero is not None]
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
    still_open = np.flatnonzero(states == OPEN).tolist()
    seen = {i: set[int]() for i in still_open}
    rng = np.random.default_rng(0)
    low, width = choices.bounds[:, 0], choices.bounds[:, 1] - choices.bounds[:, 0]
    for k in range(SAMPLES * len(still_open)):
        share = rng.random(len(low))
        chosen = np.clip(low + width * (np.rint(share) if k % 2 else share), low, choices.bounds[:, 1])
        one = Choices(choices.arrays, np.column_stack([chosen, chosen]))
        status, _, found = quick_pose(one.kernel_arrays(), one.lengths)
        if status == DECIDED:
            for i in still_open:
                seen[i].add(int(found[i]))
        if all({TAUT, SLACK} <= one for one in seen.values()):
            break
    found = states.copy()
    found[[i for i in still_open if {TAUT, SLACK} <= seen[i]]] = SWITCHING
    return found


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
