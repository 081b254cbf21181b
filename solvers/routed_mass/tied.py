"""A pose of a point mass where more cables are tight than can be told apart, enclosed by its energy.

Where an inextensible cable is only just tight, no set of taut cables is proved, and yet there is one pose.
With a point X_f in reach of all cables, energy E, multipliers l_j >= 0 of the inextensible ones and the
Lagrangian

    Q(X) = E(X) + sum l_j (L_j(X) - l_j) <= E(X) at every point in reach,

a lower bound of Q on the surface of a ball that is above E(X_f) puts every minimum of the energy inside it;
its quadratic growth from the middle of the ball gives that bound. There is one: the reachable part of the
ball is compact. It is a static pose, since X_f is in the interior of reach, and the only one in the ball
where every rope leaves outward: along a segment of minima no loaded cable could keep length and direction.

Arrays: ``data`` and ``ways`` (N, WAY, 2) as in `solvers.routed_mass.balance`; ``multiplier`` (N,) >= 0,
zero for elastic cables; ``x`` (3,) the middle of the ball, ``box`` (3, 2) around it, ``H`` (3, 3, 2);
``tension`` (N, 2).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.kernels.box import point
from cdpr_interval.kernels.interval import add, mag, mid, mul, sqr, sub
from cdpr_interval.kernels.interval_matrix import POSITIVE, definiteness
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.rounding import down, up
from cdpr_interval.mechanics.cables.ways import ALONG, FREE, LENGTH, WAY, turning_over
from solvers.routed_mass.balance import bend, pull, survey
from solvers.routed_mass.cells import all_beyond, balance_across_pairs, bounded_by_load
from solvers.routed_mass.guess import VIOLATED

TIGHT = 1e3 * VIOLATED
"""In the kernels' units: a cable no longer than that beyond its way counts as tight."""
LIFTS = 40
"""Tries, each twice as far, to find a point in reach of all cables."""
RADII = 30
"""Balls tried, each twice as wide."""
HALVINGS = 30
"""Bounds of the least curvature tried, each half the one before."""


@kernel()
def energy_over(data: Any, box: Any, ways: Any) -> tuple[float, float]:
    """Enclose the energy over a box (3, 2) with these ways."""
    _, elastic, lengths, k, load = data
    elo, ehi = 0.0, 0.0
    for j in range(3):
        lo, hi = mul(load[j, 0], load[j, 1], box[j, 0], box[j, 1])
        elo, ehi = sub(elo, ehi, lo, hi)
    for i in range(lengths.shape[0]):
        if elastic[i]:
            lo, hi = sub(ways[i, LENGTH, 0], ways[i, LENGTH, 1], lengths[i, 0], lengths[i, 1])
            lo, hi = sqr(max(lo, 0.0), max(hi, 0.0))
            lo, hi = mul(0.5 * k[i, 0], 0.5 * k[i, 1], lo, hi)
            elo, ehi = add(elo, ehi, lo, hi)
    return elo, ehi


@kernel()
def lagrangian(data: Any, multiplier: Any, box: Any, ways: Any, gradients: Any, slope: Any) -> float:
    """Bound Q at a point box (3, 2) from below; enclose its gradient in slope (3, 2), gradients (N, 3, 2)."""
    _, elastic, lengths, _, load = data
    least = energy_over(data, box, ways)[0]
    for j in range(3):
        slope[j, 0], slope[j, 1] = -load[j, 1], -load[j, 0]
    for i in range(lengths.shape[0]):
        lo, hi = multiplier[i], multiplier[i]
        if elastic[i]:
            lo, hi, _, _ = pull(data, i, ways[i])
        else:
            short = down(ways[i, LENGTH, 0] - lengths[i, 1])
            least = down(least + down(multiplier[i] * short))
        for j in range(3):
            clo, chi = mul(lo, hi, gradients[i, j, 0], gradients[i, j, 1])
            slope[j, 0], slope[j, 1] = add(slope[j, 0], slope[j, 1], clo, chi)
    return least


@kernel()
def curvature(data: Any, multiplier: Any, ways: Any, H: Any) -> bool:
    """Enclose the Hessian H (3, 3, 2) of Q over a box; False where a way may end in a pulley."""
    routes, elastic, lengths, k, _ = data
    turning = np.empty((3, 3, 2))
    H[:] = 0.0
    for i in range(lengths.shape[0]):
        lo, hi = multiplier[i], multiplier[i]
        wlo, whi = 0.0, 0.0
        if elastic[i]:
            lo, hi, wlo, whi = pull(data, i, ways[i])
        if hi == 0.0:
            continue
        if not ways[i, FREE, 0] > 0.0:
            return False
        turning_over(routes[i], ways[i], turning)
        bend(turning, lo, hi, H)
        wlo, whi = mul(k[i, 0], k[i, 1], wlo, whi)
        for a in range(3):
            for b in range(3):
                clo, chi = mul(
                    ways[i, ALONG + a, 0], ways[i, ALONG + a, 1], ways[i, ALONG + b, 0], ways[i, ALONG + b, 1]
                )
                clo, chi = mul(wlo, whi, clo, chi)
                H[a, b, 0], H[a, b, 1] = add(H[a, b, 0], H[a, b, 1], clo, chi)
    for a in range(3):
        for b in range(a):
            # Both halves enclose the same symmetric matrices.
            lo, hi = max(H[a, b, 0], H[b, a, 0]), min(H[a, b, 1], H[b, a, 1])
            H[a, b, 0], H[a, b, 1], H[b, a, 0], H[b, a, 1] = lo, hi, lo, hi
    return True


@kernel()
def least_curvature(H: Any) -> float:
    """Return a number above 0 that no eigenvalue of the matrices H (3, 3, 2) is below; 0 without a proof."""
    least, shifted = 0.0, H.copy()
    for a in range(3):
        least += mid(H[a, a, 0], H[a, a, 1])
    for _ in range(HALVINGS):
        least *= 0.5
        for a in range(3):
            shifted[a, a, 0], shifted[a, a, 1] = sub(H[a, a, 0], H[a, a, 1], least, least)
        if least > 0.0 and definiteness(shifted) == POSITIVE:
            return least
    return 0.0


@kernel()
def energy_in_reach(data: Any, x: Any, ways: Any, gradients: Any) -> float:
    """Bound the energy of a point near x (3,) inside of reach of all cables; inf without one."""
    _, elastic, lengths, _, _ = data
    there, box, d = np.empty(3), np.empty((3, 2)), np.empty(3)
    point(x, box)
    if not survey(data, box, ways, gradients):
        return math.inf
    size = 0.0
    for j in range(3):
        d[j] = 0.0
        for i in range(lengths.shape[0]):
            if not elastic[i] and ways[i, LENGTH, 1] > lengths[i, 0] - TIGHT:
                d[j] -= mid(gradients[i, j, 0], gradients[i, j, 1])
        size += d[j] * d[j]
    size = math.sqrt(size) + 1e-300
    step = 1e-15
    for _ in range(LIFTS):
        for j in range(3):
            there[j] = x[j] + step * d[j] / size
        point(there, box)
        if not survey(data, box, ways, gradients):
            return math.inf
        inside = True
        for i in range(lengths.shape[0]):
            inside = inside and (elastic[i] or ways[i, LENGTH, 1] < lengths[i, 0])
        if inside:
            return energy_over(data, box, ways)[1]
        step *= 2.0
    return math.inf


@entry()
def prove_tied(data: Any, x: Any, multiplier: Any, box: Any) -> bool:
    """Prove and enclose the pose near a guess whatever cables are taut there.

    Parameters
    ----------
    data
        See `solvers.routed_mass.data.Routed`.
    x : (3,)
        Guess.
    multiplier : (N,)
        Tensions of inextensible cables that nearly balance the load there, none below 0; of elastic ones 0.
    box : (3, 2)
        Written, see the guarantee.

    Guarantee --------- True: for all data in their ranges there is exactly one static pose at which every
    cable is straight, leaves outward or hangs loose, and it lies in ``box``.
    """
    count = data[1].shape[0]
    ways, gradients = np.empty((count, WAY, 2)), np.empty((count, 3, 2))
    slope, H = np.empty((3, 2)), np.empty((3, 3, 2))
    point(x, box)
    if not survey(data, box, ways, gradients):
        return False
    least = lagrangian(data, multiplier, box, ways, gradients, slope)
    steep = 0.0
    for j in range(3):
        steep = up(steep + mag(slope[j, 0], slope[j, 1]))
    ceiling = energy_in_reach(data, x, ways, gradients)
    radius = 1e-12
    for _ in range(RADII):
        if not ceiling < math.inf:
            return False
        for j in range(3):
            box[j, 0], box[j, 1] = down(x[j] - radius), up(x[j] + radius)
        if not survey(data, box, ways, gradients) or not all_beyond(data, box, ways):
            return False
        if not curvature(data, multiplier, ways, H):
            return False
        growth = down(down(0.5 * least_curvature(H)) * down(radius * radius))
        if down(down(least + growth) - up(steep * radius)) > ceiling:
            return True
        radius *= 2.0
    return False


@entry()
def tied_tensions(data: Any, box: Any, states: Any, tension: Any, distance: Any) -> bool:
    """Bound the tensions (N, 2) over the box (3, 2) of a pose, and decide the cables' states (N,).

    Every direction y gives bounds of a tension from y . f = sum t_i (y . a_i); those across two cables are
    tried. ``distance`` (N, 2) is written, too: lengths of ways. False: the bounds contradict each other.
    """
    _, elastic, lengths, _, load = data
    count = states.shape[0]
    ways, gradients = np.empty((count, WAY, 2)), np.empty((count, 3, 2))
    if not survey(data, box, ways, gradients):
        return False
    for i in range(count):
        distance[i, 0], distance[i, 1] = ways[i, LENGTH, 0], ways[i, LENGTH, 1]
        tension[i, 0], tension[i, 1] = 0.0, 0.0
        if elastic[i]:
            tension[i, 0], tension[i, 1], _, _ = pull(data, i, ways[i])
        elif not distance[i, 1] < lengths[i, 0]:
            tension[i, 1] = math.inf
            distance[i, 1] = min(distance[i, 1], lengths[i, 1])
    if not bounded_by_load(data, ways, tension):
        return False
    balance_across_pairs(load, ways, tension)
    for i in range(count):
        if not tension[i, 0] <= tension[i, 1]:
            return False
        states[i] = 0 if tension[i, 1] == 0.0 else 1 if tension[i, 0] > 0.0 else 2
    return True
