"""Cables that switch between taut and slack, where exactly one pose is proved on either side.

Both problems of a point mass are convex: once a pose exists there is exactly one, also for lengths nearby (a
point strictly inside all balls stays there, and springs need none). So a cable whose state is open only as
its tension is just zero, or because it is taut for some lengths of the ranges and slack for others, switches.
That is said where tensions are unique, so that they pass through zero and do not jump.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.exact.vector import Vector
from solvers.point_mass.arrays import Cables, RobotArrays, ranged
from solvers.point_mass.fields import OPEN, SLACK, SWITCHING, TAUT, distance

JUST = 1e-6
"""Largest tension (of the load) and slack (of the length) at which a cable is just taut or just slack."""
TRIED = 16
"""Choices of the others' lengths at which either end of a cable's range is tried: ten microseconds each."""
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def dependent(exits: Sequence[Vector], taut: Sequence[int], load: Vector) -> bool:
    """Return True when the directions of the cables are dependent at every equilibrium, decided exactly.

    That is so for equal exit points and for three on one line. Two exit points on a line parallel to the
    load, or three in a plane parallel to it, balance it only with multipliers of sum zero, or at a pose
    on that line or plane. More than three directions are always dependent. Otherwise they are independent at
    every equilibrium: these points and lines do not hold the load.
    """
    if any(exits[i] == exits[j] for i, j in combinations(taut, 2)):
        return True
    if len(taut) < 2 or len(taut) > 3:
        return len(taut) > 3
    a = exits[taut[0]]
    d, *rest = ([x - y for x, y in zip(exits[i], a, strict=True)] for i in taut[1:])
    other = rest[0] if rest else load
    normal = [d[j - 2] * other[j - 1] - d[j - 1] * other[j - 2] for j in range(3)]
    return not any(normal) or (bool(rest) and sum(n * f for n, f in zip(normal, load, strict=True)) == 0)


def tensions_unique(arrays: RobotArrays, lengths: Bounds, tight: Sequence[int]) -> bool:
    """Return True when the tensions are proved unique for all lengths but a set of choices of measure zero.

    Parameters
    ----------
    lengths : (N, 2)
        In any unit. A cable with a range is tight at a pose that others hold for single values of its
        length only, so the cables without a range decide.
    tight : sequence of int
        All cables that may be tight.
    """
    if arrays.is_elastic:
        return True
    wide = ranged(lengths)
    return not dependent(arrays.exits, [i for i in tight if not wide[i]], arrays.load_exact)


def just_switching(
    arrays: RobotArrays, cables: Cables, box: Bounds, tension: Bounds, states: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return the states with ``SWITCHING`` where an open cable is just taut or just slack.

    Parameters
    ----------
    box, tension, states : (3, 2), (N, 2), (N,)
        Of a pose proved to be the only one, in the kernels' units; the tensions enclose all possible ones.
    """
    _, exits, lengths, _, _ = cables
    load = float(np.linalg.norm(arrays.load.mean(axis=1)))
    if not tensions_unique(arrays, lengths, np.flatnonzero(states != SLACK).tolist()):
        return states
    found = states.copy()
    for i in np.flatnonzero(states == OPEN):
        near, _ = distance(exits, i, box)
        if tension[i, 1] <= JUST * load and near >= (1.0 - JUST) * lengths[i, 0]:
            found[i] = SWITCHING
    return found


def choices(lengths: Bounds, cable: int) -> Iterator[Bounds]:
    """Yield lengths (N, 2) within the ranges at which a cable is likely to be taut, or to be slack.

    The others are near the other ends of their ranges, by shares that differ (equal ones tie by symmetry), or
    each at one of its ends.
    """
    low, width = lengths[:, 0], lengths[:, 1] - lengths[:, 0]
    for k in range(TRIED):
        shares = (GOLDEN * (np.arange(len(low)) + k * len(low))) % 1.0
        shares = np.rint(shares) if k % 2 else shares * (k + 1) / TRIED
        for end in (0, 1):
            chosen = low + width * (shares if end else 1.0 - shares)
            chosen[cable] = lengths[cable, end]
            chosen = np.clip(chosen, low, lengths[:, 1])
            yield np.column_stack([chosen, chosen])


def changing(seen: Sequence[NDArray[np.int64]], cable: int) -> bool:
    """Return True when a cable is proved taut for some lengths and slack for others, or at the switch."""
    states = {int(one[cable]) for one in seen}
    return {TAUT, SLACK} <= states or SWITCHING in states
