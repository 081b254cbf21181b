"""The least and the largest value of a number of the pose over all choices of the data, by branch and bound.

In a box of choices, data by which the number is proved to rise are put to one end and those by which it
falls to the other; what is left is bounded by slopes. Where that is not sharp the box is cut. A box in
which the taut cables are not known has a bound for each set that may carry the load there.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

from flint import arb

from cdpr_interval.exact.balls import to_bounds
from solvers.point_mass.ranges.choices import Choices
from solvers.point_mass.ranges.sensitivity import (
    ZERO,
    Balls,
    Output,
    System,
    Zero,
    at_middle,
    data_balls,
    enclosed,
)

ROUNDS = 4
"""Times that data are put to their ends: the box is narrower then, and more slopes have one sign."""
SHARP = 0.02
"""A bound is sharp enough when it is so near to a value that is reached, as a share of the width."""
NEAR = 1e-12
"""Bounds are not made sharper than that, in the kernels' units."""
Measure = Callable[[System, Balls, Balls], Output]
"""An output of a system at unknowns and data."""


@dataclass(frozen=True, eq=False)
class Part:
    """A box of choices with all that may carry the load in it."""

    choices: Choices
    systems: tuple[System, ...]
    """One of them holds the pose of every choice, where it is known which may."""
    is_sharp: bool
    """They are all there are, and each has an enclosure over the whole box."""

    @cached_property
    def zeros(self) -> tuple[Zero | None, ...]:
        """The zeros of the systems over the box."""
        return tuple(enclosed(system, self.choices) for system in self.systems)


@dataclass(frozen=True)
class Bound:
    """An upper bound, a value near one that is reached, and which number to cut to come nearer."""

    most: float
    reached: float
    cut: int | None


@dataclass(eq=False)
class Extremes:
    """Bounds of outputs over a cover of all choices by parts; keeps the parts that cuts make.

    Parameters
    ----------
    parts : list of Part
        Together they hold all choices.
    examine : callable
        From a box of choices to the part, None where nothing is known of what carries the load there.
    budget : int
        Boxes that may still be examined.
    """

    parts: list[Part]
    examine: Callable[[Choices], Part | None]
    budget: int
    _halves: dict[tuple[int, int], tuple[Part, ...] | None] = field(default_factory=dict)
    _kept: list[Part] = field(default_factory=list)

    def range_of(self, measure: Measure, lo: float, hi: float) -> tuple[float, float]:
        """Return bounds of an output, of which some are known; only these where some part gives none.

        Guarantee
        ---------
        For every choice the output of the pose lies within, where it does within those known.
        """
        tops = [self._bounds(part, measure, 1) for part in self.parts]
        bottoms = [self._bounds(part, measure, -1) for part in self.parts]
        if any(b is None for b in (*tops, *bottoms)):
            return lo, hi
        reached = [max(b.reached for b in side) for side in (tops, bottoms)]  # type: ignore[union-attr]
        width = reached[0] + reached[1] if math.isfinite(sum(reached)) else 0.0
        near = max(SHARP * width, NEAR)
        most = [
            self._largest(list(side), measure, sign, near, known)  # type: ignore[arg-type]
            for side, sign, known in ((tops, 1, hi), (bottoms, -1, -lo))
        ]
        return -most[1], most[0]

    def _largest(self, bounds: list[Bound], measure: Measure, sign: int, near: float, known: float) -> float:
        """Return an upper bound of sign times the output, cutting the parts that decide it."""
        order = itertools.count()
        heap = [(-b.most, next(order), b, p) for b, p in zip(bounds, self.parts, strict=True)]
        heapq.heapify(heap)
        best = max(b.reached for b in bounds)
        while heap:
            top, _, bound, part = heap[0]
            if min(-top, known) <= best + near or bound.cut is None:
                return min(-top, known)
            halves = self._cut(part, bound.cut)
            if halves is None:
                return min(-top, known)
            found = [self._bounds(half, measure, sign) for half in halves]
            if any(b is None for b in found):
                return min(-top, known)
            heapq.heappop(heap)
            for half, b in zip(halves, found, strict=True):
                assert b is not None
                best = max(best, b.reached)
                heapq.heappush(heap, (-min(b.most, -top), next(order), b, half))
        return -math.inf

    def _cut(self, part: Part, number: int) -> tuple[Part, ...] | None:
        """Return the halves of a part; None where the budget is spent or a half is unknown."""
        key = id(part), number
        if key not in self._halves:
            if self.budget <= 0:
                return None
            self.budget -= 2
            # The part is kept, so that its identity stays its own.
            self._kept.append(part)
            halves = [self.examine(half) for half in part.choices.halves(number)]
            found = tuple(half for half in halves if half is not None)
            self._halves[key] = found if len(found) == len(halves) else None
        return self._halves[key]

    def _bounds(self, part: Part, measure: Measure, sign: int) -> Bound | None:
        """Return the bound of a part: that of the system with the largest one."""
        if not part.is_sharp:
            return None
        pairs = zip(part.systems, part.zeros, strict=True)
        found = [_bound(system, part.choices, zero, measure, sign) for system, zero in pairs]
        if not found or any(b is None for b in found):
            return None
        top = max(found, key=lambda b: b.most)  # type: ignore[union-attr]
        assert top is not None
        reached = max(b.reached for b in found if b is not None)
        cut = _steepest(part, measure) if top.cut is None and reached < top.most else top.cut
        return Bound(top.most, reached, cut)


def _steepest(part: Part, measure: Measure) -> int | None:
    """Return the number whose range moves an output most."""
    width = part.choices.bounds[:, 1] - part.choices.bounds[:, 0]
    for system, zero in zip(part.systems, part.zeros, strict=True):
        if zero is not None:
            slopes = _slopes(measure(system, zero.box, data_balls(part.choices.bounds)), zero)
            return max(slopes, key=lambda k: float(abs(slopes[k]).upper()) * float(width[k]), default=None)
    return None


def _slopes(output: Output, zero: Zero) -> dict[int, arb]:
    """Return the derivatives of an output by the data that are ranges."""
    return {
        k: sum((a * b for a, b in zip(output.by_unknowns, slope, strict=True)), output.by_data.get(k, ZERO))
        for k, slope in zero.slopes.items()
    } | {k: slope for k, slope in output.by_data.items() if k in zero.wide and k not in zero.slopes}


def _bound(system: System, choices: Choices, zero: Zero | None, measure: Measure, sign: int) -> Bound | None:
    """Return the bound of sign times an output of one system over a box, in which it has a zero."""
    if zero is None:
        return None

    def signed(system: System, x: Balls, d: Balls) -> Output:
        return measure(system, x, d).times(sign)

    relaxed, is_bent = _relaxed(system, choices, zero, signed)
    bounds, left = choices.bounds.copy(), dict[int, arb]()
    for _ in range(ROUNDS):
        d = data_balls(bounds)
        output = relaxed(system, zero.box, d)
        slopes = _slopes(output, zero)
        left = {k: s for k, s in slopes.items() if not (s >= 0 or s <= 0)}
        if not slopes.keys() - left.keys():
            break
        for k in slopes.keys() - left.keys():
            bounds[k] = bounds[k, 1] if slopes[k] >= 0 else bounds[k, 0]
        zero = enclosed(system, Choices(choices.arrays, bounds.copy()))
        if zero is None:
            return None
        d = data_balls(bounds)
        output = relaxed(system, zero.box, d)
        left = {k: s for k, s in _slopes(output, zero).items() if not (s >= 0 or s <= 0)}
    value = relaxed(system, zero.middle, at_middle(d, zero.wide)).value
    rise = sum((abs(s * (d[k] - d[k].mid())).upper() for k, s in _slopes(output, zero).items()), ZERO)
    most = min(to_bounds(value + rise)[1], to_bounds(output.value)[1])
    likely = sum((abs(float(s.mid())) * float(d[k].rad()) for k, s in left.items()), 0.0)
    cut = max(left, key=lambda k: float(left[k].rad()) * float(d[k].rad()), default=None)
    reached = float(value.mid()) + likely if is_bent or system.is_pose(zero.middle, d) else -math.inf
    return Bound(most, reached, cut)


def _relaxed(system: System, choices: Choices, zero: Zero, measure: Measure) -> tuple[Measure, bool]:
    """Return an output not below the given one where the system holds the pose, and whether it differs.

    Numbers that are not negative there - multipliers, and what the lengths of other cables leave - are
    added with weights >= 0: those that make the linear bound lowest (Lagrange's relaxation), by floats; any
    will do.
    """
    d = data_balls(choices.bounds)
    rules = system.rules(zero.box, d)
    if not rules:
        return measure, False
    radius = {k: float(d[k].rad()) for k in zero.wide}
    nothing = dict.fromkeys(zero.wide, 0.0)
    value, slopes = _linear(measure(system, zero.box, d), zero)
    slopes = nothing | slopes
    weights = {}
    for rule in rules:
        rest, by = _linear(system.rule(rule, zero.box, d), zero)
        by = nothing | by
        found = _best_weight(slopes, by, value, rest, radius)
        if found > 0.0:
            weights[rule] = found
            value += found * rest
            slopes = {k: slopes[k] + found * by[k] for k in slopes}
    if not weights:
        return measure, False

    def relaxed(system: System, x: Balls, d: Balls) -> Output:
        total = measure(system, x, d)
        for rule, weight in weights.items():
            total = total.plus(system.rule(rule, x, d).times(weight))
        return total

    return relaxed, True


def _linear(output: Output, zero: Zero) -> tuple[float, dict[int, float]]:
    """Return value and slopes of an output in floats."""
    return float(output.value.mid()), {k: float(s.mid()) for k, s in _slopes(output, zero).items()}


def _best_weight(
    slopes: dict[int, float], by: dict[int, float], value: float, rest: float, radius: dict[int, float]
) -> float:
    """Return the weight w >= 0 at which value + w rest + sum |slope + w by| radius is least."""

    def most(w: float) -> float:
        return value + w * rest + sum(abs(slopes[k] + w * by[k]) * radius[k] for k in slopes)

    bends = [-slopes[k] / by[k] for k in slopes if by[k]]
    return min((w for w in (0.0, *bends) if w >= 0.0), key=most)
