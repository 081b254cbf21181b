"""The subsets of inextensible cables that may carry the load at a pose whose taut cables are not known.

Arrays: ``cables`` is an ``arrays.Cables`` of N cables, ``middle`` is ``(A, L, f)``, floats (N, 3), (N,),
(3,); ``load`` (3, 2); ``taut`` (>= m,) the cables of a subset; ``outer`` (3, 2) holds the pose, ``most``
(N,) bounds the tensions; ``box`` (3, 2) and ``tension`` (N, 2) are what the subset can contribute.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr_interval.kernels.kernel import entry
from cdpr_interval.kernels.rounding import down
from solvers.point_mass.duality import closed_form_exists
from solvers.point_mass.fields import distance
from solvers.point_mass.guesses.lowest import lowest_of_subset
from solvers.point_mass.one_call import anywhere, tension_bounds
from solvers.point_mass.system import krawczyk


@entry()
def in_reach(cables: Any, box: Any) -> bool:
    """Return False when a box (3, 2) is empty or provably outside the reach of some cable."""
    _, exits, lengths, _, _ = cables
    for j in range(3):
        if box[j, 0] > box[j, 1]:
            return False
    for i in range(lengths.shape[0]):  # noqa: SIM110 - numba compiles no generator expressions
        if distance(exits, i, box)[0] > lengths[i, 1]:
            return False
    return True


@entry()
def sharpen(
    cables: Any, load: Any, middle: Any, taut: Any, m: int, outer: Any, most: Any, box: Any, tension: Any
) -> bool:
    """Enclose the equilibrium of ``m`` cables alone, where it can be proved; else leave the box as it is.

    Returns
    -------
    bool
        False when the cables provably carry no positive tensions in ``outer``. The square system of a subset
        with independent directions has at most one zero whose multipliers have a positive sum, so a proved
        zero with such a sum is the only one that matters.
    """
    A, L, f = middle
    p, t = np.empty(3), np.empty(4)
    if not lowest_of_subset(A, L, f, taut, m, p, t):
        return True
    x = np.empty(3 + m)
    x[:3], x[3:] = p, t[:m]
    zero = np.empty((3 + m, 2))
    if not krawczyk(cables, load, taut, m, x, anywhere(3 + m), zero, np.empty((3 + m, 2))):
        return True
    total = 0.0
    for a in range(m):
        total = down(total + zero[3 + a, 0])
    if not total > 0.0:
        return True
    for a in range(m):
        if zero[3 + a, 1] <= 0.0:
            return False
    tension_bounds(cables, taut, m, zero, tension)
    for a in range(m):
        c = taut[a]
        tension[c, 0], tension[c, 1] = max(tension[c, 0], 0.0), min(tension[c, 1], most[c])
        if tension[c, 0] > tension[c, 1]:
            return False
    for j in range(3):
        box[j, 0], box[j, 1] = max(zero[j, 0], outer[j, 0]), min(zero[j, 1], outer[j, 1])
    return True


@entry()
def candidates(
    cables: Any, load: Any, middle: Any, subsets: Any, outer: Any, most: Any, boxes: Any, tensions: Any
) -> Any:
    """Enclose what each subset can contribute to the pose.

    Parameters
    ----------
    cables, load
        See `solvers.point_mass.system.evaluate`; inextensible.
    middle
        ``(A, L, f)``: floats (N, 3), (N,), (3,) inside the enclosures.
    subsets : (K, 4) int
        Size, then indices of the cables (filled up with zeros), of independent directions.
    outer : (3, 2)
        Holds the pose.
    most : (N,)
        Upper bounds of the tensions, in units of force.
    boxes, tensions : (K, 3, 2), (K, N, 2)
        Written where kept.

    Returns
    -------
    (K,) bool
        Which subsets are kept.

    Guarantee
    ---------
    For all parameters in their ranges: where the cables of a subset, and no others, carry the load at the
    pose, the subset is kept, its box holds the pose and its tensions enclose theirs.
    """
    kept = np.zeros(subsets.shape[0], dtype=np.bool_)
    for s in range(subsets.shape[0]):
        m = subsets[s, 0]
        taut = subsets[s, 1:]
        if not closed_form_exists(cables, load, taut, m):
            continue
        tensions[s, :, :] = 0.0
        boxes[s, :, :] = outer
        for a in range(m):
            tensions[s, taut[a], 1] = most[taut[a]]
        if sharpen(cables, load, middle, taut, m, outer, most, boxes[s], tensions[s]):
            kept[s] = in_reach(cables, boxes[s])
    return kept
