"""The equilibrium of a point mass as a function of all its data, in balls: bounds of it and of its slopes.

A system G(x; d) = 0 has unknowns x (the position, and the multipliers of taut cables) and data d (a box
`Choices`). Krawczyk's operator encloses its zero for every choice; the data enter it through the columns C
dG/d d_k, so that what one number does to several equations stays together. From the same matrices follow
bounds of the slopes dx/d d_k over the whole box.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from flint import arb, arb_mat

from cdpr_interval.exact.balls import from_bounds
from cdpr_interval.exact.enclosure import Bounds
from solvers.point_mass.ranges.choices import Choices

NEWTON_STEPS = 8
CONVERGED = 2.0**-60
"""Newton's step from a double that is near enough, relative to the number: the next one is rounding."""
WIDENINGS = 12
"""Boxes tried around a guess, each larger by half."""
CONTRACTIONS = 3
GAIN = 0.98
"""Boxes that shrink by less are not contracted again."""
Balls = list[arb]
ZERO, ONE = arb(0), arb(1)


@dataclass(frozen=True, eq=False)
class Output:
    """A number that a result reports, at a zero: its value, and its derivatives by unknowns and data."""

    value: arb
    by_unknowns: Balls
    by_data: dict[int, arb]

    def times(self, factor: float) -> Output:
        """Return the output times a number."""
        by_data = {k: v * factor for k, v in self.by_data.items()}
        return Output(self.value * factor, [v * factor for v in self.by_unknowns], by_data)

    def plus(self, other: Output) -> Output:
        """Return the sum of two outputs."""
        by_data = dict(self.by_data)
        for k, v in other.by_data.items():
            by_data[k] = by_data.get(k, ZERO) + v
        pairs = zip(self.by_unknowns, other.by_unknowns, strict=True)
        return Output(self.value + other.value, [a + b for a, b in pairs], by_data)


class System(Protocol):
    """Equations of an equilibrium."""

    @property
    def size(self) -> int:
        """Unknowns; the first three are the position, in the kernels' units."""

    @property
    def taut(self) -> tuple[int, ...]:
        """The cables that carry."""

    def start(self, d: Sequence[float]) -> Balls | None:
        """Return a guess for exact data, or None."""

    def residual(self, x: Balls, d: Balls) -> Balls:
        """Return G."""

    def jacobian(self, x: Balls, d: Balls) -> arb_mat:
        """Return dG/dx."""

    def by_data(self, x: Balls, d: Balls) -> dict[int, list[tuple[int, arb]]]:
        """Return the entries that are not zero of dG/d d_k by the number k: (row, value)."""

    def is_only(self, x: Balls, d: Balls) -> bool:
        """Return whether no zero but the one in a box can be a pose."""

    def rules(self, x: Balls, d: Balls) -> tuple[int, ...]:
        """Return the cables whose rule decides whether a zero is the pose, and may be broken."""

    def rule(self, cable: int, x: Balls, d: Balls) -> Output:
        """Return what is not negative for a cable where a zero is the pose."""

    def is_pose(self, x: Balls, d: Balls) -> bool:
        """Return whether the middle of a zero looks like the pose: a guess, in floats."""

    def tension(self, cable: int, x: Balls, d: Balls) -> Output:
        """Return the tension of a cable, in units of force for the middle load."""


@dataclass(frozen=True, eq=False)
class Zero:
    """The zero of a system for every choice of a box, its slopes, and it at the middle of the box."""

    box: Balls
    middle: Balls
    """At the middles of all ranges."""
    slopes: dict[int, Balls]
    """dx/d d_k over the whole box, for the data of the system that are ranges."""
    wide: tuple[int, ...]
    """All data that are ranges."""


def position(axis: int, x: Balls) -> Output:
    """Return a coordinate of the position as an output."""
    return Output(x[axis], [ONE if i == axis else ZERO for i in range(len(x))], {})


def data_balls(bounds: Bounds) -> Balls:
    """Return the data as balls."""
    return [from_bounds(lo, hi) for lo, hi in bounds.tolist()]


def at_middle(d: Balls, wide: Sequence[int]) -> Balls:
    """Return the data with the ranges at their middles; what is no range keeps its few last bits."""
    found = list(d)
    for k in wide:
        found[k] = d[k].mid()
    return found


def enclosed(system: System, choices: Choices) -> Zero | None:
    """Return the zero near a guess for every choice, or None where it is not proved.

    Guarantee
    ---------
    For every choice the system has exactly one zero in ``box``, and no other one anywhere that could be a
    pose. For any two choices the difference of their zeros is the sum over k of a number in ``slopes[k]``
    times the difference of d_k.
    """
    wide = np.flatnonzero(choices.wide).tolist()
    d = data_balls(choices.bounds)
    d0 = at_middle(d, wide)
    guess = system.start([float(v.mid()) for v in d0])
    if guess is None:
        return None
    try:
        zero = _krawczyk(system, guess, d, d0, wide)
    except ZeroDivisionError:
        return None
    return zero if zero is not None and system.is_only(zero.box, d) else None


def _krawczyk(system: System, x0: Balls, d: Balls, d0: Balls, wide: list[int]) -> Zero | None:
    n = system.size
    for _ in range(NEWTON_STEPS):
        inverse = system.jacobian(x0, d0).mid().inv().mid()
        step = (inverse * arb_mat(n, 1, system.residual(x0, d0))).entries()
        x0 = [(x - s).mid() for x, s in zip(x0, step, strict=True)]
        if all(abs(s.mid()) < CONVERGED * (1 + abs(x)) for s, x in zip(step, x0, strict=True)):
            break
    here = (inverse * arb_mat(n, 1, system.residual(x0, d0))).entries()
    columns = _columns(inverse, system.by_data(x0, d), wide)
    shift = list(here)
    for k, column in columns.items():
        doubt = d[k] - d0[k]
        shift = [s + c * doubt for s, c in zip(shift, column, strict=True)]
    if not all(s.is_finite() for s in shift):
        return None
    tiny = [(1 + abs(x)).upper() * arb(2) ** -90 for x in x0]
    reach = [(2 * abs(s).upper() + t).mid() for s, t in zip(shift, tiny, strict=True)]
    for _ in range(WIDENINGS):
        deviation = _deviation(system, inverse, x0, reach, d)
        needed = [abs(s).upper() + v for s, v in zip(shift, _product(deviation, reach), strict=True)]
        if all(v < w for v, w in zip(needed, reach, strict=True)):
            break
        reach = [(1.5 * v + t).upper().mid() for v, t in zip(needed, tiny, strict=True)]
        if not all(w.is_finite() for w in reach):
            return None
    else:
        return None
    for _ in range(CONTRACTIONS):
        if all(v > GAIN * w for v, w in zip(needed, reach, strict=True)):
            break
        reach = [v.upper().mid() for v in needed]
        deviation = _deviation(system, inverse, x0, reach, d)
        needed = [abs(s).upper() + v for s, v in zip(shift, _product(deviation, reach), strict=True)]
    box = [x - s + _within(v) for x, s, v in zip(x0, shift, _product(deviation, reach), strict=True)]
    middle = [x - s + _within(v) for x, s, v in zip(x0, here, _product(deviation, reach), strict=True)]
    slopes = _slopes(deviation, reach, _columns(inverse, system.by_data(box, d), wide))
    return Zero(box, _thin(system, x0, d0, middle), slopes, tuple(wide))


def _thin(system: System, x0: Balls, d0: Balls, known: Balls) -> Balls:
    """Return the zero at the middle of the data, narrower than it is ``known`` where Krawczyk shows that."""
    n = system.size
    inverse = system.jacobian(x0, d0).mid().inv().mid()
    here = (inverse * arb_mat(n, 1, system.residual(x0, d0))).entries()
    reach = [
        (2 * abs(s).upper() + (1 + abs(x)).upper() * arb(2) ** -90).mid()
        for s, x in zip(here, x0, strict=True)
    ]
    grown = _product(_deviation(system, inverse, x0, reach, d0), reach)
    if all(abs(s).upper() + v < w for s, v, w in zip(here, grown, reach, strict=True)):
        return [x - s + _within(v) for x, s, v in zip(x0, here, grown, strict=True)]
    return known


def _columns(
    inverse: arb_mat, by_data: dict[int, list[tuple[int, arb]]], wide: list[int]
) -> dict[int, Balls]:
    """Return C dG/d d_k for the data that are ranges."""
    n = inverse.nrows()
    return {
        k: [sum((inverse[i, row] * value for row, value in by_data[k]), ZERO) for i in range(n)]
        for k in wide
        if k in by_data
    }


def _deviation(system: System, inverse: arb_mat, x0: Balls, reach: Balls, d: Balls) -> arb_mat:
    """Return upper bounds of |I - C J| over the box around ``x0``."""
    n = len(x0)
    J = system.jacobian([x + _within(w) for x, w in zip(x0, reach, strict=True)], d)
    E = arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)]) - inverse * J
    return arb_mat(n, n, [abs(e).upper() for e in E.entries()])


def _product(deviation: arb_mat, reach: Balls) -> Balls:
    """Return upper bounds of |E| w."""
    return [v.upper() for v in (deviation * arb_mat(len(reach), 1, reach)).entries()]


def _within(size: arb) -> arb:
    """Return the ball [-size, size]."""
    return size.union(-size)


def _slopes(deviation: arb_mat, reach: Balls, columns: dict[int, Balls]) -> dict[int, Balls]:
    """Bound the slopes S_k = -(C J)^-1 C dG/d d_k, with C J = I - E: S_k = -M_k + E S_k."""
    share = max(
        ((v / w).upper() for v, w in zip(_product(deviation, reach), reach, strict=True)), default=ZERO
    )
    found = {}
    for k, column in columns.items():
        most = max((abs(c) / w).upper() for c, w in zip(column, reach, strict=True)) / (1 - share)
        size = [(w * most).upper() for w in reach]
        found[k] = [-c + _within(v) for c, v in zip(column, _product(deviation, size), strict=True)]
    return found
