"""The whole convex path in one compiled call: guess the pose, prove it, fill the reported fields.

Arrays: ``cables`` is an ``arrays.Cables`` of N cables, ``elastic`` (N,), ``exits`` (N, 3, 2) and
``lengths`` (N, 2) as in it, ``constant`` (N,) and ``given`` (N, 2) their springs, ``load`` (3, 2) and
``frame`` (9, 2) as `solvers.point_mass.arrays.RobotArrays` has them; ``A`` (N, 3), ``L`` (N,), ``k`` (N,),
``f`` (3,) floats inside their enclosures; ``taut`` (>= m,) holds m taut cables, ``x`` (>= 3 + m,) a guess
(p, t) for them, ``box`` (3 + m, 2) its enclosure; ``tension`` (N, 2), ``states`` (N,), ``bounds`` (4 + 2 N,
2) as `balls_pose` has it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr_interval.kernels.interval import div, mid, mul
from cdpr_interval.kernels.kernel import entry
from cdpr_interval.mechanics.cables.compiled import reach
from solvers.point_mass.fields import OPEN, SLACK, TAUT, distance, report
from solvers.point_mass.guesses.lowest import APART, lowest_of_subset, lowest_point
from solvers.point_mass.guesses.springs import lowest_energy
from solvers.point_mass.system import krawczyk

DECIDED = 0
"""Every cable is proved taut or slack: by convexity this is the only pose."""
UNCLEAR = 1
"""The proof, or the state of a cable, is missing."""
NO_POSE = 2
"""The balls of the listed cables seem to have no common point."""


@entry()
def springs(elastic: Any, constant: Any, given: Any, lengths: Any) -> Any:
    """Return enclosures (N, 2) of k and of k l from spring constants or EA."""
    count = lengths.shape[0]
    k = np.zeros((count, 2))
    w = np.zeros((count, 2))
    for i in range(count):
        if elastic[i]:
            if constant[i]:
                k[i, 0], k[i, 1] = given[i, 0], given[i, 1]
                w[i, 0], w[i, 1] = mul(given[i, 0], given[i, 1], lengths[i, 0], lengths[i, 1])
            else:
                k[i, 0], k[i, 1] = div(given[i, 0], given[i, 1], lengths[i, 0], lengths[i, 1])
                w[i, 0], w[i, 1] = given[i, 0], given[i, 1]
    return k, w


@entry()
def anywhere(n: int) -> Any:
    """Return the (n, 2) cover that asks nothing of a domain of uniqueness."""
    cover = np.empty((n, 2))
    for i in range(n):
        cover[i, 0], cover[i, 1] = np.inf, -np.inf
    return cover


@entry()
def middles(cables: Any, load: Any) -> Any:
    """Return floats (N, 3), (N,), (N,), (3,) inside the enclosures of A, l, k and f."""
    _, exits, lengths, stiffness, _ = cables
    count = lengths.shape[0]
    A = np.empty((count, 3))
    L = np.empty(count)
    k = np.empty(count)
    f = np.empty(3)
    for i in range(count):
        L[i] = mid(lengths[i, 0], lengths[i, 1])
        k[i] = mid(stiffness[i, 0], stiffness[i, 1])
        for j in range(3):
            A[i, j] = mid(exits[i, j, 0], exits[i, j, 1])
    for j in range(3):
        f[j] = mid(load[j, 0], load[j, 1])
    return A, L, k, f


@entry()
def guess_elastic(A: Any, L: Any, k: Any, f: Any, taut: Any, x: Any) -> int:
    """Write the minimum of the energy: the taut cables and x = (p, t); return their number.

    ``taut`` : (>= N,); ``x`` : (>= 3 + N,).
    """
    count = A.shape[0]
    p = np.empty(3)
    t = np.empty(4)
    basis = np.empty(4, dtype=np.int64)
    lowest_point(A, L, f, basis, p, t)
    size = np.sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2])
    for j in range(3):
        # Hang from the last basis cable as if alone: one cable is certainly taut there.
        p[j] += f[j] / size * (size / k[basis[0]])
    lowest_energy(A, L, k, f, p)
    m = 0
    for i in range(count):
        r = 0.0
        for j in range(3):
            d = p[j] - A[i, j]
            r += d * d
        r = np.sqrt(r)
        if r > L[i]:
            taut[m] = i
            x[3 + m] = k[i] * ((r - L[i]) / r)
            m += 1
    for j in range(3):
        x[j] = p[j]
    return m


@entry()
def guess_inextensible(A: Any, L: Any, f: Any, taut: Any, x: Any) -> tuple[int, int]:
    """Write the lowest point of the balls: the taut cables and x = (p, t); return status and number.

    ``taut`` : (>= 4,); ``x`` : (>= 7,).
    """
    p = np.empty(3)
    t = np.empty(4)
    basis = np.empty(4, dtype=np.int64)
    status, m = lowest_point(A, L, f, basis, p, t)
    for a in range(m):
        taut[a] = basis[a]
    if status == APART:
        return NO_POSE, m
    # Ascending order: the result must not depend on the way the basis was found.
    for a in range(1, m):
        b = a
        while b > 0 and taut[b - 1] > taut[b]:
            taut[b - 1], taut[b] = taut[b], taut[b - 1]
            t[b - 1], t[b] = t[b], t[b - 1]
            b -= 1
    if lowest_of_subset(A, L, f, taut, m, p, t):
        for j in range(3):
            x[j] = p[j]
        for a in range(m):
            x[3 + a] = t[a]
    return DECIDED, m


@entry()
def tension_bounds(cables: Any, taut: Any, m: int, box: Any, tension: Any) -> None:
    """Write the tensions (N, 2) = multiplier times distance, zero outside the taut set."""
    lengths = cables[2]
    for i in range(lengths.shape[0]):
        tension[i, 0], tension[i, 1] = 0.0, 0.0
    for a in range(m):
        c = taut[a]
        lo, hi = reach(cables, c, box[3 + a, 0], box[3 + a, 1])
        tension[c, 0], tension[c, 1] = mul(box[3 + a, 0], box[3 + a, 1], lo, hi)


@entry()
def classify(cables: Any, taut: Any, m: int, box: Any, states: Any) -> tuple[bool, bool]:
    """Decide every cable's state over the enclosure of an equilibrium of the cables ``taut``.

    Returns
    -------
    carried, fits : bool
        All tensions of ``taut`` are proved positive; all other cables are proved slack.
    """
    _, exits, lengths, _, _ = cables
    for i in range(lengths.shape[0]):
        states[i] = SLACK
    carried = True
    for a in range(m):
        states[taut[a]] = TAUT
        if not box[3 + a, 0] > 0.0:
            states[taut[a]] = OPEN
            carried = False
    fits = True
    for i in range(lengths.shape[0]):
        if states[i] == SLACK:
            _, far = distance(exits, i, box)
            if not far < lengths[i, 0]:
                states[i] = OPEN
                fits = False
    return carried, fits


@entry()
def in_units(lengths: Any, unit: float) -> Any:
    """Return lengths (N, 2) divided by a unit that is a power of two, which is exact."""
    scaled = np.empty((lengths.shape[0], 2))
    for i in range(lengths.shape[0]):
        scaled[i, 0], scaled[i, 1] = lengths[i, 0] / unit, lengths[i, 1] / unit
    return scaled


@entry()
def prove_pose(
    cables: Any, load: Any, frame: Any, taut: Any, m: int, x: Any, bounds: Any, states: Any
) -> int:
    """Prove the guess ``x`` for the first ``m`` cables of ``taut`` and fill the reported fields.

    Parameters and guarantee as `balls_pose`; the equilibrium fulfils the Karush-Kuhn-Tucker conditions of
    a convex problem whose Lagrangian is strictly convex.
    """
    count = states.shape[0]
    box = np.empty((3 + m, 2))
    if not krawczyk(cables, load, taut, m, x, anywhere(3 + m), box, np.empty((3 + m, 2))):
        return UNCLEAR
    carried, fits = classify(cables, taut, m, box, states)
    if not (carried and fits):
        return UNCLEAR
    tension = np.empty((count, 2))
    tension_bounds(cables, taut, m, box, tension)
    report(
        cables,
        frame,
        box,
        tension,
        states,
        bounds[0:3],
        bounds[3],
        bounds[4 : 4 + count],
        bounds[4 + count : 4 + 2 * count],
    )
    return DECIDED


@entry()
def balls_pose(exits: Any, lengths: Any, load: Any, frame: Any, bounds: Any, states: Any) -> int:
    """Find the static pose of inextensible cables and prove that it is the only one.

    Parameters
    ----------
    exits, load, frame
        See `solvers.point_mass.arrays.RobotArrays`.
    lengths : (N, 2)
        In m.
    bounds : (4 + 2 N, 2)
        Written when DECIDED: position (3 rows, m), height (m), tensions (N rows, N), distances (N rows, m),
        see `solvers.point_mass.fields.report`.
    states : (N,)
        Written when DECIDED: ``SLACK`` or ``TAUT``.

    Returns
    -------
    int
        ``DECIDED``, ``UNCLEAR`` or ``NO_POSE``.

    Guarantee
    ---------
    DECIDED: for all lengths in their ranges the robot has exactly one static pose, exactly the cables in
    state ``TAUT`` carry tension there, and ``bounds`` encloses it. Nothing else is claimed.
    """
    count = lengths.shape[0]
    nothing = np.zeros((count, 2))
    cables = (np.zeros(count, dtype=np.bool_), exits, in_units(lengths, frame[0, 0]), nothing, nothing)
    A, L, _, f = middles(cables, load)
    x = np.empty(3 + max(count, 4))
    taut = np.empty(max(count, 4), dtype=np.int64)
    status, m = guess_inextensible(A, L, f, taut, x)
    if status != DECIDED:
        return status
    return prove_pose(cables, load, frame, taut, m, x, bounds, states)


@entry()
def springs_pose(
    constant: Any, given: Any, exits: Any, lengths: Any, load: Any, frame: Any, bounds: Any, states: Any
) -> int:
    """Find the static pose of elastic cables and prove it; all else as `balls_pose`.

    Parameters
    ----------
    constant, given : (N,), (N, 2)
        See `solvers.point_mass.arrays.RobotArrays`.
    """
    count = lengths.shape[0]
    scaled = in_units(lengths, frame[0, 0])
    elastic = np.empty(count, dtype=np.bool_)
    for i in range(count):
        elastic[i] = True
    k, w = springs(elastic, constant, given, scaled)
    cables = (elastic, exits, scaled, k, w)
    A, L, stiffness, f = middles(cables, load)
    x = np.empty(3 + max(count, 4))
    taut = np.empty(max(count, 4), dtype=np.int64)
    m = guess_elastic(A, L, stiffness, f, taut, x)
    if m == 0:
        return UNCLEAR
    return prove_pose(cables, load, frame, taut, m, x, bounds, states)
