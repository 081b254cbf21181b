"""The choices of a point mass in boxes, and the sets of cables that may carry the load in each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import combinations

import numpy as np
from flint import arb
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import Bounds, enclose
from cdpr_interval.exact.irrational import root_bounds
from cdpr_interval.exact.range import Range, RangeVector, as_range
from cdpr_interval.robots.numbers import Point
from solvers.point_mass.arrays import Cables, RobotArrays, robot_arrays, select
from solvers.point_mass.balance import unbalanced
from solvers.point_mass.candidates import candidates
from solvers.point_mass.convex import (
    NoPose,
    quick_pose,
    scaled_cables,
)
from solvers.point_mass.degenerate import TOUCHING, outer_box
from solvers.point_mass.duality import inside_all, largest_tension
from solvers.point_mass.fields import TAUT, distance
from solvers.point_mass.one_call import DECIDED, middles
from solvers.point_mass.ranges.choices import Choices, around_middles
from solvers.point_mass.ranges.extremes import Part
from solvers.point_mass.ranges.sensitivity import ZERO, System, enclosed
from solvers.point_mass.rationals.emptiness import deepest_point, proves_empty
from solvers.point_mass.taut_cables import TautCables
from solvers.questions.problem import Problem

MOST_SETS = 40
"""Sets of springs looked at in one box."""


def choices_of(problem: Problem) -> Choices | None:
    """Return the box of all choices of a problem's data; None where the load may vanish by its scale."""
    under_load = problem.loaded
    middle, spread = under_load.middle, under_load.spread
    arrays = robot_arrays(middle)
    unit, force = (Fraction(x) for x in arrays.frame[:2, 0].tolist())
    rows = [_scaled(Range(*length), unit) for length in problem.lengths]
    for cable in problem.robot.cables:
        ends = zip(map(as_range, cable.frame_anchor), arrays.origin, strict=True)
        rows += [_scaled(a - Range.exact(o), unit) for a, o in ends]
    for cable in problem.robot.cables:
        spring = cable.elasticity
        if spring is None:
            rows.append((0.0, 0.0))
        elif spring.stiffness is not None:
            rows.append(_scaled(as_range(spring.stiffness), force / unit))
        else:
            assert spring.axial_stiffness is not None
            rows.append(_scaled(as_range(spring.axial_stiffness), force))
    if spread.load_scale.lo <= 0:
        return None
    # Of inextensible cables the load is divided by its scale, see `taut_cables`.
    least = Fraction(1) if arrays.is_elastic else spread.load_scale.lo
    rows += [_scaled(Range(-x, x), force * least) for x in spread.load]
    rows.append(_scaled(spread.load_scale, Fraction(1)))
    return Choices(_with_frame(arrays, problem), np.array(rows))


def _scaled(value: Range, unit: Fraction) -> tuple[float, float]:
    return enclose(value.lo / unit)[0], enclose(value.hi / unit)[1]


def _with_frame(arrays: RobotArrays, problem: Problem) -> RobotArrays:
    """Return the arrays with the direction of up for every choice of gravity."""
    gravity = problem.robot.gravity
    if not any(isinstance(g, Range) for g in gravity):
        return arrays
    up = up_ranges(gravity)
    height = sum((u * Range.exact(a) for u, a in zip(up, arrays.origin, strict=True)), Range.exact(0))
    frame = arrays.frame.copy()
    for k, r in enumerate((*up, height)):
        frame[5 + k] = enclose(r.lo)[0], enclose(r.hi)[1]
    return replace(arrays, frame=frame)


def up_ranges(gravity: Point) -> RangeVector:
    """Enclose the unit vector against a gravity of which some components are ranges."""
    ranges = [as_range(g) for g in gravity]
    square = sum((g.squared() for g in ranges), Range.exact(0))
    if square.lo <= 0:
        unit = Range(Fraction(-1), Fraction(1))
        return unit, unit, unit
    norm = Range(root_bounds(square.lo)[0], root_bounds(square.hi)[1])
    x, y, z = (-g / norm for g in ranges)
    return x, y, z


def cover(choices: Choices, most: int) -> tuple[list[Part], list[Choices], NoPose | None, str]:
    """Cut the choices until each box is proved, into so many boxes at most.

    Returns
    -------
    parts, left, empty, reason
        Parts, boxes left open, why some are empty, why some are open.
    """
    todo, parts, left = [choices], list[Part](), list[Choices]()
    empty: NoPose | None = None
    reason, used = "", 0
    while todo:
        box = todo.pop(0)
        used += 1
        part = examine(box)
        if isinstance(part, NoPose):
            empty = part
            continue
        if isinstance(part, Part) and part.is_sharp:
            parts.append(part)
            continue
        number = _to_cut(box, part.systems if isinstance(part, Part) else ())
        if number is not None and used + len(todo) < most:
            todo += box.halves(number)
        elif isinstance(part, Part):
            # Proved, but for a sharp enclosure: its coarse one will do.
            parts.append(part)
        else:
            left.append(box)
            reason = part
    return parts, left, empty, reason


def examine(choices: Choices) -> Part | NoPose | str:
    """Return what may carry the load in a box; that it has no pose; or why neither is proved."""
    arrays, lengths = choices.kernel_arrays(), choices.lengths
    status, _, states = quick_pose(arrays, lengths)
    if status == DECIDED:
        only = TautCables(choices, tuple(np.flatnonzero(states == TAUT).tolist()))
        return Part(choices, (only,), enclosed(only, choices) is not None)
    if choices.arrays.is_elastic:
        return _springs(choices)
    cables = scaled_cables(arrays, lengths)
    few = carriers(arrays, cables)
    if few is None:
        middle, longest = around_middles(choices)
        weights = _proved_empty(middle, longest)
        return TOUCHING if weights is None else NoPose(weights)
    return _known(choices, few, cables, arrays.load)


def _known(choices: Choices, few: list[tuple[int, ...]], cables: Cables, load: Bounds) -> Part:
    """Return which of some sets of inextensible cables hold the pose for some choice.

    A set without an enclosure is left out where it balances the load nowhere in the hull of the others: the
    pose moves continuously with the data, is in that hull at their middle, and would have to leave it with
    such a set.
    """
    systems, vague, hull = list[System](), list[System](), list[Bounds]()
    for taut in few:
        system = TautCables(choices, taut)
        zero = enclosed(system, choices)
        if zero is None:
            vague.append(system)
        elif system.pattern(zero)[0]:
            systems.append(system)
            hull.append(np.array([balls.to_bounds(x) for x in zero.box[:3]]))
    if not systems:
        return Part(choices, tuple(vague), False)
    if vague and _taut_at_middle(choices) in [system.taut for system in systems]:
        box = box_around(hull)
        vague = [v for v in vague if not unbalanced(select(cables, v.taut), load, box)]
    return Part(choices, (*systems, *vague), not vague)


def _taut_at_middle(choices: Choices) -> tuple[int, ...]:
    """Return the taut cables at the middle of the data; none where they are not proved."""
    middle = choices.bounds.mean(axis=1)
    one = Choices(choices.arrays, np.column_stack([middle, middle]))
    status, _, states = quick_pose(one.kernel_arrays(), one.lengths)
    return tuple(np.flatnonzero(states == TAUT).tolist()) if status == DECIDED else ()


def box_around(boxes: Sequence[Bounds]) -> Bounds:
    """Return the hull of boxes (3, 2)."""
    found = np.array(boxes)
    return np.column_stack([found[:, :, 0].min(axis=0), found[:, :, 1].max(axis=0)])


def _springs(choices: Choices) -> Part:
    """Return the sets of springs that are the taut ones for some choice.

    From the set at the middle on, what may change is tried both ways: the pose moves continuously with the
    data, and another set takes over only where the tension or the slack of each cable that changes is zero.
    """
    todo = [_taut_at_middle(choices)]
    if not todo[0]:
        return Part(choices, (), False)
    seen, systems = set(todo), list[System]()
    while todo:
        system = TautCables(choices, todo.pop())
        zero = enclosed(system, choices)
        if zero is None or len(seen) > MOST_SETS:
            return Part(choices, (system,), False)
        possible, open_ones = system.pattern(zero)
        if not possible:
            continue
        systems.append(system)
        for size in range(1, len(open_ones) + 1):
            for change in combinations(open_ones, size):
                other = tuple(sorted(set(system.taut) ^ set(change)))
                if other and other not in seen:
                    seen.add(other)
                    todo.append(other)
    return Part(choices, tuple(systems), True)


def carriers(arrays: RobotArrays, cables: Cables) -> list[tuple[int, ...]] | None:
    """Return sets of inextensible cables, one of which carries the load alone for every choice.

    None where no point is proved to lie strictly within the reach of all cables. By Caratheodory's theorem
    one to three cables with independent directions are enough.
    """
    _, points, lengths, _, _ = cables
    A, L, _, f = middles(cables, arrays.load)
    _, deep = deepest_point(A, np.ascontiguousarray(lengths[:, 0]))
    if not inside_all(cables, deep):
        return None
    outer = outer_box(cables, arrays.load, A, L, f, deep)
    if outer is None:
        return None
    count = len(L)
    near = [i for i in range(count) if not distance(points, i, outer)[1] < lengths[i, 0]]
    most = np.zeros(count)
    for i in near:
        most[i] = largest_tension(cables, arrays.load, outer, deep, i)
    rows = [
        (size, *taut, *[0] * (3 - size))
        for size in range(1, min(3, len(near)) + 1)
        for taut in combinations(near, size)
    ]
    subsets = np.array(rows, dtype=np.int64).reshape(-1, 4)
    boxes, tensions = np.empty((len(subsets), 3, 2)), np.empty((len(subsets), count, 2))
    kept = candidates(cables, arrays.load, (A, L, f), subsets, outer, most, boxes, tensions)
    return [tuple(row[1 : 1 + row[0]].tolist()) for row in subsets[kept]] or None


def _proved_empty(arrays: RobotArrays, lengths: Bounds) -> dict[int, float] | None:
    """Return weights that prove that no choice has a pose."""
    unit = Fraction(float(arrays.frame[0, 0]))
    cables = scaled_cables(arrays, lengths)
    A, _, _, _ = middles(cables, arrays.load)
    weights, _ = deepest_point(A, np.ascontiguousarray(cables[2][:, 1]))
    exits = [tuple(Fraction(x) * unit for x in row) for row in arrays.exit_bounds[:, :, 0].tolist()]
    longest = [Fraction(x) for x in lengths[:, 1].tolist()]
    return weights if proves_empty(weights, exits, longest) else None  # type: ignore[arg-type]


def _to_cut(choices: Choices, systems: Sequence[System]) -> int | None:
    """Return the number whose range moves the pose most; where that is not known, the widest range."""
    wide = np.flatnonzero(choices.wide)
    if not len(wide):
        return None
    width = choices.bounds[:, 1] - choices.bounds[:, 0]
    middle = choices.bounds.mean(axis=1)
    for system in systems:
        slopes = _slopes_at(system, choices, middle)
        if slopes:
            return max(slopes, key=lambda k: max(abs(s) for s in slopes[k]) * float(width[k]))
    return int(wide[width[wide].argmax()])


def _slopes_at(system: System, choices: Choices, middle: NDArray[np.float64]) -> dict[int, list[float]]:
    """Return slopes of the position at the middle of a box, in floats."""
    guess = system.start(middle.tolist())
    d = [arb(v) for v in middle.tolist()]
    if guess is None:
        return {}
    try:
        inverse = system.jacobian(guess, d).mid().inv().mid()
    except ZeroDivisionError:
        return {}
    entries = system.by_data(guess, d)
    wide = np.flatnonzero(choices.wide).tolist()
    return {
        k: [float(sum((inverse[j, r] * v for r, v in entries[k]), ZERO).mid()) for j in range(3)]
        for k in wide
        if k in entries
    }
