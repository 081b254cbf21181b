"""A pose of a point mass where more cables are tight than can be told apart, enclosed by its energy.

Where an inextensible cable is only just tight, no set of taut cables is proved, and yet there is one pose.
With a point X_f of a ball in reach of all cables, energy E, multipliers l_j >= 0 of the inextensible ones and
the Lagrangian

    Q(X) = E(X) + sum l_j (L_j(X) - l_j) <= E(X) at every point in reach,

a lower bound of Q on the surface of the ball that is above E(X_f) puts every minimum of the energy inside it;
its quadratic growth from the middle of the ball gives that bound. There is one: the reachable part of the
ball is compact. It is a static pose, since X_f is in the interior of reach, and the only one in the ball
where every rope leaves outward: along a segment of minima no loaded cable could keep length and direction.
What the energy leaves open is the root of a rounding; the lengths of three cables with multipliers are known
far better.

Arrays: ``data`` and ``ways`` (N, WAY, 2) as in `solvers.routed_mass.balance`; ``multiplier`` (N,) >= 0,
zero for elastic cables; ``x`` (3,) the middle of the ball, ``box`` (3, 2) around it, ``H`` (3, 3, 2);
``tension`` (N, 2).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.engine.krawczyk import deviation, preconditioner
from cdpr_interval.kernels.box import point
from cdpr_interval.kernels.interval import add, mag, mid, mul, sqr, sub
from cdpr_interval.kernels.interval_matrix import POSITIVE, definiteness
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.rounding import down, up
from cdpr_interval.mechanics.cables.rows import ALONG, BISECTED, FREE, KIND, LENGTH, WAY
from cdpr_interval.mechanics.cables.ways import turning_over
from solvers.routed_mass.balance import bend, off_pulleys, pull, smooth, survey
from solvers.routed_mass.cells import all_beyond, balance_across_pairs, bounded_by_load
from solvers.routed_mass.guess import VIOLATED

TIGHT = 1e3 * VIOLATED
"""In the kernels' units: a cable no longer than that beyond its way counts as tight."""
LIFTS = 40
"""Tries, each twice as far, to find a point in reach of all cables."""
RADII = 30
"""Balls tried, each twice as wide."""
STIFFENED = 100.0
"""Stiffness that stands for a length that is kept, over the largest tension per length."""
NARROWINGS = 2
"""Each squares what the curvature of the ropes leaves."""
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
def curvature(data: Any, held: Any, ways: Any, H: Any) -> bool:
    """Enclose the Hessian H (3, 3, 2) of Q over a box; False where a loaded way is not `smooth`.

    ``held`` (N, 2) bounds the multipliers.
    """
    routes, elastic, lengths, k, _ = data
    turning = np.empty((3, 3, 2))
    H[:] = 0.0
    for i in range(lengths.shape[0]):
        lo, hi = held[i, 0], held[i, 1]
        wlo, whi = 0.0, 0.0
        if elastic[i]:
            lo, hi, wlo, whi = pull(data, i, ways[i])
        if hi == 0.0:
            continue
        if not smooth(ways[i]):
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
def far_from(x: Any, y: Any) -> float:
    """Bound the distance of two points (3,) from above."""
    total = 0.0
    for j in range(3):
        apart = up(abs(y[j] - x[j]))
        total = up(total + up(apart * apart))
    return up(math.sqrt(total))


@kernel()
def energy_in_reach(data: Any, x: Any, ways: Any, gradients: Any) -> tuple[float, float]:
    """Bound the energy of a point near x (3,) inside of reach of all cables, and how far it is from x.

    Both are inf without one.
    """
    _, elastic, lengths, _, _ = data
    there, box, d = np.empty(3), np.empty((3, 2)), np.empty(3)
    point(x, box)
    if not survey(data, box, ways, gradients):
        return math.inf, math.inf
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
            return math.inf, math.inf
        inside = True
        for i in range(lengths.shape[0]):
            inside = inside and (elastic[i] or ways[i, LENGTH, 1] < lengths[i, 0])
        if inside:
            return energy_over(data, box, ways)[1], far_from(x, there)
        step *= 2.0
    return math.inf, math.inf


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

    Guarantee
    ---------
    True: for all data in their ranges there is exactly one static pose at which every cable is straight,
    leaves outward or hangs loose, and it lies in ``box``.
    """
    count = data[1].shape[0]
    ways, gradients = np.empty((count, WAY, 2)), np.empty((count, 3, 2))
    slope, H, held = np.empty((3, 2)), np.empty((3, 3, 2)), np.empty((count, 2))
    for i in range(count):
        held[i, 0] = held[i, 1] = multiplier[i]
    point(x, box)
    if not survey(data, box, ways, gradients):
        return False
    least = lagrangian(data, multiplier, box, ways, gradients, slope)
    steep = 0.0
    for j in range(3):
        steep = up(steep + mag(slope[j, 0], slope[j, 1]))
    ceiling, apart = energy_in_reach(data, x, ways, gradients)
    if not ceiling < math.inf:
        return False
    radius = max(1e-12, 2.0 * apart)
    for _ in range(RADII):
        for j in range(3):
            box[j, 0], box[j, 1] = down(x[j] - radius), up(x[j] + radius)
        if not survey(data, box, ways, gradients) or not all_beyond(data, box, ways):
            return False
        if not off_pulleys(data, ways):
            return False
        if not curvature(data, held, ways, H):
            return False
        growth = down(down(0.5 * least_curvature(H)) * down(radius * radius))
        if down(down(least + growth) - up(steep * radius)) > ceiling:
            narrow(data, x, multiplier, up(ceiling - down(least - up(steep * radius))), box)
            return True
        radius *= 2.0
    return False


@kernel()
def narrow(data: Any, x: Any, multiplier: Any, gap: float, box: Any) -> None:
    """Contract the box (3, 2) of a pose in the ball around x (3,), if three cables have multipliers (N,).

    At the pose Q is at most ``gap`` below the energy, so l_j (l_j - L_j) <= gap for each of them: three
    lengths that are known, and the mean value theorem from x.
    """
    count = data[1].shape[0]
    held, m = np.empty(3, dtype=np.int64), 0
    for i in range(count):
        if multiplier[i] > 0.0:
            if m == 3:
                return
            held[m] = i
            m += 1
    if m < 3:
        return
    ways, gradients = np.empty((count, WAY, 2)), np.empty((count, 3, 2))
    here, change = np.empty((3, 2)), np.empty((3, 2))
    G, C, E = np.empty((3, 3, 2)), np.empty((3, 3)), np.empty((3, 3, 2))
    point(x, here)
    if not survey(data, here, ways, gradients):
        return
    for b in range(3):
        way, length = ways[held[b]], data[2][held[b]]
        shortest = down(length[0] - up(gap / multiplier[held[b]]))
        change[b, 0], change[b, 1] = sub(shortest, length[1], way[LENGTH, 0], way[LENGTH, 1])
    for _ in range(NARROWINGS):
        for a in range(3):
            # The line from x to the pose lies in here.
            here[a, 0], here[a, 1] = min(box[a, 0], x[a]), max(box[a, 1], x[a])
        if not survey(data, here, ways, gradients):
            return
        for b in range(3):
            G[b] = gradients[held[b]]
        if not preconditioner(G, C):
            return
        deviation(C, G, E)
        for a in range(3):
            lo, hi = x[a], x[a]
            for b in range(3):
                clo, chi = mul(C[a, b], C[a, b], change[b, 0], change[b, 1])
                lo, hi = add(lo, hi, clo, chi)
                clo, chi = sub(box[b, 0], box[b, 1], x[b], x[b])
                clo, chi = mul(E[a, b, 0], E[a, b, 1], clo, chi)
                lo, hi = add(lo, hi, clo, chi)
            here[a, 0], here[a, 1] = max(box[a, 0], lo), min(box[a, 1], hi)
            if not here[a, 0] <= here[a, 1]:
                return
        box[:] = here


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


@entry()
def strict_minimum(data: Any, box: Any, tension: Any) -> bool:
    """Prove that the energy has a strict minimum at a pose in a box (3, 2) with tensions (N, 2).

    Near the pose Q + c / 2 sum (L_j - l_j)^2, the sum over the inextensible cables that carry, is no more
    than the energy at points in reach, whatever c is: T_j (L_j - l_j) outweighs the square there. So it is
    enough that its Hessian is positive. The bisector has no energy.
    """
    routes, elastic, _, _, _ = data
    count = elastic.shape[0]
    ways, gradients, H = np.empty((count, WAY, 2)), np.empty((count, 3, 2)), np.empty((3, 3, 2))
    if not survey(data, box, ways, gradients) or not curvature(data, tension, ways, H):
        return False
    most = 0.0
    for i in range(count):
        if tension[i, 1] > 0.0:
            if routes[i, KIND, 0] == BISECTED or not tension[i, 1] < math.inf or not ways[i, FREE, 0] > 0.0:
                return False
            most = max(most, tension[i, 1] / ways[i, FREE, 0])
    for i in range(count):
        if elastic[i] or not tension[i, 0] > 0.0:
            continue
        for a in range(3):
            for b in range(3):
                lo, hi = mul(
                    ways[i, ALONG + a, 0], ways[i, ALONG + a, 1], ways[i, ALONG + b, 0], ways[i, ALONG + b, 1]
                )
                lo, hi = mul(STIFFENED * most, STIFFENED * most, lo, hi)
                H[a, b, 0], H[a, b, 1] = add(H[a, b, 0], H[a, b, 1], lo, hi)
    return bool(definiteness(H) == POSITIVE)
