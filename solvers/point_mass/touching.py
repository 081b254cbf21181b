"""Balls that only touch, decided exactly: their one common point, and the tensions that hold the load there.

The point q with the smallest largest power max_i (|q - A_i|^2 - l_i^2) is q = sum lambda_i A_i with weights
lambda >= 0 of at most four balls of equal power v (see `rationals.emptiness`): all of them rational
where exit points and lengths are. Every common point p of all balls has |p - q|^2 <= -v. So v > 0 proves that
there is none; with v = 0 it is q alone, the weighted cables are exactly tight and pull against each other;
with v < 0 there is a point strictly inside all balls, and the pose is not farther than sqrt(-v) from it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations

import numpy as np

from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.exact.vector import Vector, dot
from cdpr_interval.exact.vector import minus as difference
from solvers.point_mass.arrays import Cables, RobotArrays
from solvers.point_mass.entry import Fields, fields_of
from solvers.point_mass.fields import OPEN, SLACK, TAUT
from solvers.point_mass.rationals.emptiness import Floats, deepest_point
from solvers.point_mass.rationals.tension_polytope import MOST_TIGHT, Tensions, solved, tensions_at

NEAR = 1e-7
"""Relative to its squared length, how far a ball's power may be from the largest one for it to be tried."""
PRESTRESS = "cables {{{}}} only just reach each other: prestress, nothing bounds these tensions from above"
CLOSE = "the cables have hardly a common point: which of {{{}}} are taut is not decided, nor their tensions"


@dataclass(frozen=True)
class Deepest:
    """The point with the smallest largest power, exactly."""

    point: Vector
    weights: dict[int, Fraction]
    """Positive; at most four."""
    power: Fraction
    """v: the largest |q - A_i|^2 - l_i^2."""


@dataclass(frozen=True)
class Unheld:
    """Proved: the weighted balls have one common point, and no finite tensions hold the load there."""

    weights: dict[int, Fraction]


def deepest_exactly(
    exits: Sequence[Vector], lengths: Sequence[Fraction], tried: Sequence[int]
) -> Deepest | None:
    """Return the point deepest in all balls, exactly, from weights of some of the balls ``tried``."""
    for size in range(1, min(4, len(tried)) + 1):
        for few in combinations(tried, size):
            weights = equal_power_weights([exits[i] for i in few], [lengths[i] for i in few])
            if weights is None or min(weights) <= 0:
                continue
            x, y, z = (
                sum((w * exits[i][j] for w, i in zip(weights, few, strict=True)), Fraction(0))
                for j in range(3)
            )
            point: Vector = (x, y, z)
            powers = [_power(point, a, s) for a, s in zip(exits, lengths, strict=True)]
            if max(powers) == powers[few[0]]:
                return Deepest(point, dict(zip(few, weights, strict=True)), powers[few[0]])
    return None


def equal_power_weights(exits: Sequence[Vector], lengths: Sequence[Fraction]) -> list[Fraction] | None:
    """Return the weights, of sum 1, of the centres' mean of equal powers; None if singular."""
    ways = [difference(a, exits[0]) for a in exits[1:]]
    gram = [[dot(a, b) for b in ways] for a in ways]
    right = [(dot(a, a) + lengths[0] ** 2 - s**2) / 2 for a, s in zip(ways, lengths[1:], strict=True)]
    others = solved(gram, right)
    return None if others is None else [1 - sum(others, Fraction(0)), *others]


def _power(point: Vector, exit_point: Vector, length: Fraction) -> Fraction:
    spoke = difference(point, exit_point)
    return dot(spoke, spoke) - length**2


def settle_touching(
    arrays: RobotArrays, cables: Cables, lengths: Sequence[Fraction]
) -> Fields | Unheld | Deepest | None:
    """Find the pose where balls touch or hardly overlap, for exact lengths in m.

    Returns
    -------
    Fields
        There is exactly one pose, in these bounds, which hold for all tensions that are possible.
    Unheld
        The balls have one common point, and nothing holds the load there.
    Deepest
        The balls have no common point: the weights prove it.
    None
        Nothing is decided.
    """
    exits = arrays.exits
    deepest = deepest_exactly(exits, lengths, _tried(cables))
    if deepest is None or deepest.power > 0:
        return deepest
    if deepest.power < 0:
        return _hardly_overlapping(arrays, cables, lengths, deepest)
    tight = [
        i for i, (a, s) in enumerate(zip(exits, lengths, strict=True)) if _power(deepest.point, a, s) == 0
    ]
    if len(tight) > MOST_TIGHT:
        return None
    held = tensions_at(deepest.point, {i: exits[i] for i in tight}, arrays.load_exact)
    if not held.corners:
        return Unheld(deepest.weights)
    return _held(arrays, cables, lengths, deepest, tight, held)


def _tried(cables: Cables) -> list[int]:
    """Return the balls whose power may be the largest at the deepest point, by floats."""
    _, exits, lengths, _, _ = cables
    A: Floats = 0.5 * exits[:, :, 0] + 0.5 * exits[:, :, 1]
    L: Floats = 0.5 * lengths[:, 0] + 0.5 * lengths[:, 1]
    weights, point = deepest_point(A, L)
    powers = ((A - point) ** 2).sum(axis=1) - L**2
    near = np.flatnonzero(powers >= powers.max() - NEAR * float(L.max()) ** 2).tolist()
    return near if len(near) <= MOST_TIGHT else sorted(weights)


def _held(
    arrays: RobotArrays,
    cables: Cables,
    lengths: Sequence[Fraction],
    deepest: Deepest,
    tight: Sequence[int],
    held: Tensions,
) -> Fields:
    """Return the pose at the one common point, with bounds of all tensions that hold the load."""
    count = len(lengths)
    states, tension = np.full(count, SLACK, dtype=np.int64), np.zeros((count, 2))
    unit = Fraction(float(arrays.frame[1, 0]))
    unbounded = []
    for i in tight:
        least, most = held.least(i), held.most(i)
        if most is None:
            unbounded.append(i)
        elif most == 0:
            continue
        states[i] = TAUT if least > 0 else OPEN
        tension[i] = _enclosed(
            least * lengths[i] / unit, (least if most is None else most) * lengths[i] / unit
        )
    names = ", ".join(arrays.robot.cable_names[i] for i in unbounded)
    fields = fields_of(cables, arrays.frame, _around(arrays, deepest.point), tension, states)
    fields.tensions[unbounded, 1] = math.inf
    return Fields(
        fields.position, fields.height, fields.tensions, fields.distances, states, PRESTRESS.format(names)
    )


def _hardly_overlapping(
    arrays: RobotArrays, cables: Cables, lengths: Sequence[Fraction], deepest: Deepest
) -> Fields:
    """Return the pose of balls that have a common interior, too small for floats to find it.

    With q strictly inside all balls every multiplier has t_i (l_i^2 - |q - A_i|^2) / 2 <= f . (p - q), see
    `solvers.point_mass.duality.largest_tension`, and the right side is at most |f| |p - q|.
    """
    radius, load = _root(-deepest.power), _root(dot(arrays.load_exact, arrays.load_exact))
    box = _around(arrays, deepest.point, radius)
    count = len(lengths)
    states, tension = np.full(count, SLACK, dtype=np.int64), np.zeros((count, 2))
    unit = Fraction(float(arrays.frame[1, 0]))
    for i, (exit_point, length) in enumerate(zip(arrays.exits, lengths, strict=True)):
        power = _power(deepest.point, exit_point, length)
        # |p - A_i| <= |q - A_i| + r < l_i.
        room = length - radius
        if room > 0 and power + length**2 < room**2:
            continue
        states[i] = OPEN
        most = 2 * load * radius / -power * length
        tension[i, 1] = enclose(most / unit)[1]
    near = ", ".join(arrays.robot.cable_names[i] for i in np.flatnonzero(states == OPEN))
    return fields_of(cables, arrays.frame, box, tension, states, CLOSE.format(near))


def _around(arrays: RobotArrays, point: Vector, radius: Fraction = Fraction(0)) -> Floats:
    """Return the box (3, 2) around a point in m, in the kernels' units."""
    unit, origin = Fraction(float(arrays.frame[0, 0])), arrays.origin
    return np.array(
        [
            _enclosed((p - a - radius) / unit, (p - a + radius) / unit)
            for p, a in zip(point, origin, strict=True)
        ]
    )


def _root(x: Fraction) -> Fraction:
    """Return a number that is not below the square root of ``x``."""
    return Fraction(math.nextafter(math.sqrt(enclose(x)[1]), math.inf))


def _enclosed(lo: Fraction, hi: Fraction) -> tuple[float, float]:
    return enclose(lo)[0], enclose(hi)[1]
