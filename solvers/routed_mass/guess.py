"""Where a point mass on routed cables hangs, in plain floats: a guess, proved elsewhere.

The energy -f . X + sum k_i / 2 max(0, L_i(X) - l_i)^2 is lowered by Newton steps, with inextensible cables as
stiff springs; then those that came out taut are solved as constraints, one too many or too few exchanged.

Arrays, for N cables: ``data`` is a `solvers.routed_mass.data.Routed`; ``L``, ``k`` (N,) floats inside
their enclosures, ``f`` (3,) the load; ``x`` (>= 3 + N,) position, then tensions; ``taut`` (>= N,) the m
inextensible cables that carry; ``a`` (N, 3) directions, ``D`` (N, 3, 3) their derivatives, ``length`` (N,) of
the ways, all at x; ``g`` (3,) a gradient, ``work`` (>= n, >= n + 1) a linear system; ``step`` (3,).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.interval import mid
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.mechanics.cables.rows import ARM, BEFORE, EXIT, RADIUS
from cdpr_interval.mechanics.cables.way_at import way_at
from solvers.point_mass.guesses.lowest import lowest_point

STIFF = 1e4
"""Spring constant of an inextensible cable in the kernels' units: it stretches by some 1e-4 of the robot."""
DESCENTS = 60
"""Newton steps for the energy at most; ten are usual."""
HALVINGS = 30
"""Of a step that does not lower the energy."""
EXCHANGES = 8
"""Changes of the set of taut cables at most."""
POLISHES = 8
"""Newton steps for a set of taut cables."""
VIOLATED = 1e-11
"""Excess of a length in the kernels' units that makes a cable taut: some thousand roundings."""


@kernel()
def look(data: Any, x: Any, length: Any, a: Any, D: Any) -> None:
    """Write lengths (N,), directions (N, 3) and derivatives (N, 3, 3) of all ways at x (>= 3,)."""
    for i in range(length.shape[0]):
        length[i] = way_at(data[0][i], x, a[i], D[i])


@kernel()
def energy(L: Any, k: Any, f: Any, x: Any, length: Any) -> float:
    """Return the energy of springs (N,) and load (3,) at x (>= 3,), where the ways have lengths (N,)."""
    total = -(f[0] * x[0] + f[1] * x[1] + f[2] * x[2])
    for i in range(L.shape[0]):
        e = length[i] - L[i]
        if e > 0.0:
            total += 0.5 * k[i] * e * e
    return total


@kernel()
def descent(L: Any, k: Any, f: Any, length: Any, a: Any, D: Any, g: Any, step: Any) -> bool:
    """Write the gradient g (3,) and a step (3,) that lowers the energy; a (N, 3), D (N, 3, 3), rest (N,)."""
    work = np.zeros((3, 4))
    size = 0.0
    for j in range(3):
        g[j] = -f[j]
    for i in range(L.shape[0]):
        e = length[i] - L[i]
        if not e > 0.0:
            continue
        for j in range(3):
            g[j] += k[i] * e * a[i, j]
            for h in range(3):
                work[j, h] += k[i] * a[i, j] * a[i, h] + k[i] * e * 0.5 * (D[i, j, h] + D[i, h, j])
        size = max(size, k[i])
    damping = 1e-14 * size
    for _ in range(HALVINGS):
        trial = work.copy()
        for j in range(3):
            trial[j, j] += damping
            trial[j, 3] = -g[j]
        # Cholesky's pivots tell whether the matrix is positive definite.
        p0 = trial[0, 0]
        p1 = trial[1, 1] * trial[0, 0] - trial[0, 1] * trial[0, 1]
        p2 = (
            trial[0, 0] * (trial[1, 1] * trial[2, 2] - trial[1, 2] * trial[1, 2])
            - trial[0, 1] * (trial[0, 1] * trial[2, 2] - trial[1, 2] * trial[0, 2])
            + trial[0, 2] * (trial[0, 1] * trial[1, 2] - trial[1, 1] * trial[0, 2])
        )
        if p0 > 0.0 and p1 > 0.0 and p2 > 0.0 and solve_in_place(trial, 3, 1):
            for j in range(3):
                step[j] = trial[j, 3]
            return True
        damping = max(10.0 * damping, 1e-6 * size, 1e-6)
    return False


@kernel()
def settle_down(data: Any, L: Any, k: Any, f: Any, x: Any, length: Any, a: Any, D: Any) -> None:
    """Lower the energy from x (>= 3,) by Newton steps; length (N,), a (N, 3), D (N, 3, 3) are those of x."""
    g, step, trial = np.empty(3), np.empty(3), np.empty(3)
    look(data, x, length, a, D)
    here = energy(L, k, f, x, length)
    for _ in range(DESCENTS):
        if not descent(L, k, f, length, a, D, g, step):
            return
        slope = g[0] * step[0] + g[1] * step[1] + g[2] * step[2]
        share, moved = 1.0, False
        size = abs(step[0]) + abs(step[1]) + abs(step[2])
        if size > 1.0:
            share = 1.0 / size
        for _ in range(HALVINGS):
            for j in range(3):
                trial[j] = x[j] + share * step[j]
            look(data, trial, length, a, D)
            there = energy(L, k, f, trial, length)
            if there <= here + 1e-4 * share * slope or size < 1e-13:
                moved = True
                break
            share *= 0.5
        if not moved:
            look(data, x, length, a, D)
            return
        for j in range(3):
            x[j] = trial[j]
        here = there
        if size * share < 1e-14:
            return


@kernel()
def polish(data: Any, L: Any, k: Any, f: Any, taut: Any, m: int, x: Any, length: Any, a: Any, D: Any) -> bool:
    """Solve the equations of a set of taut cables by Newton steps from x; arrays as above."""
    elastic = data[1]
    n = 3 + m
    work = np.empty((n, n + 1))
    for _ in range(POLISHES):
        look(data, x, length, a, D)
        work[:] = 0.0
        for j in range(3):
            work[j, n] = f[j]
        for i in range(L.shape[0]):
            e = length[i] - L[i]
            if elastic[i] and e > 0.0:
                for j in range(3):
                    work[j, n] -= k[i] * e * a[i, j]
                    for h in range(3):
                        work[j, h] += k[i] * (a[i, j] * a[i, h] + e * D[i, j, h])
        for b in range(m):
            i = taut[b]
            t = x[3 + b]
            work[3 + b, n] = L[i] - length[i]
            for j in range(3):
                work[j, n] -= t * a[i, j]
                work[j, 3 + b] = a[i, j]
                work[3 + b, j] = a[i, j]
                for h in range(3):
                    work[j, h] += t * D[i, j, h]
        if not solve_in_place(work, n, 1):
            return False
        size = 0.0
        for r in range(n):
            if not abs(work[r, n]) < 1e100:
                return False
            x[r] += work[r, n]
            if r < 3:
                size += abs(work[r, n])
        if size < 1e-15:
            break
    look(data, x, length, a, D)
    return True


@kernel()
def without(taut: Any, m: int, b: int, x: Any) -> int:
    """Take entry b out of the m taut cables (>= m,) and of the tensions in x (>= 3 + m,); return m - 1."""
    for c in range(b, m - 1):
        taut[c] = taut[c + 1]
        x[3 + c] = x[4 + c]
    return m - 1


@kernel()
def least(values: Any, first: int, count: int) -> int:
    """Return which of ``count`` entries of values (>= first + count,) from ``first`` on is least."""
    found = 0
    for b in range(1, count):
        if values[first + b] < values[first + found]:
            found = b
    return found


@kernel()
def first_point(data: Any, L: Any, f: Any, x: Any) -> None:
    """Write where the mass hangs on straight cables of about the same lengths, x (>= 3,); L (N,), f (3,)."""
    routes = data[0]
    count = routes.shape[0]
    A, straight = np.empty((count, 3)), np.empty(count)
    t, basis, p = np.empty(4), np.empty(4, dtype=np.int64), np.empty(3)
    for i in range(count):
        for j in range(3):
            A[i, j] = mid(routes[i, EXIT + j, 0], routes[i, EXIT + j, 1])
        gone = mid(routes[i, BEFORE, 0], routes[i, BEFORE, 1]) + 1.5 * routes[i, RADIUS, 1]
        straight[i] = max(L[i] - gone + routes[i, ARM, 1], 0.01 * L[i])
    lowest_point(A, straight, f, basis, p, t)
    for j in range(3):
        x[j] = p[j]


@kernel()
def ascending(taut: Any, m: int, x: Any) -> None:
    """Sort the m taut cables (>= m,) with their tensions in x (>= 3 + m,): no result depends on the way."""
    for a in range(1, m):
        b = a
        while b > 0 and taut[b - 1] > taut[b]:
            taut[b - 1], taut[b] = taut[b], taut[b - 1]
            x[2 + b], x[3 + b] = x[3 + b], x[2 + b]
            b -= 1


@entry()
def guess(data: Any, taut: Any, x: Any) -> int:
    """Write a static pose: the inextensible cables that carry and x = (X, tensions); return their number.

    ``taut`` : (>= N,); ``x`` : (>= 3 + N,). Nothing is claimed of what is written; -1: no guess.
    """
    _, elastic, lengths, stiffness, load = data
    count = lengths.shape[0]
    L, k, f = np.empty(count), np.empty(count), np.empty(3)
    length, a, D = np.empty(count), np.empty((count, 3)), np.empty((count, 3, 3))
    for i in range(count):
        L[i] = mid(lengths[i, 0], lengths[i, 1])
        k[i] = mid(stiffness[i, 0], stiffness[i, 1]) if elastic[i] else STIFF
    for j in range(3):
        f[j] = mid(load[j, 0], load[j, 1])
    first_point(data, L, f, x)
    settle_down(data, L, k, f, x, length, a, D)
    m = 0
    for i in range(count):
        if not elastic[i] and length[i] > L[i]:
            taut[m] = i
            x[3 + m] = k[i] * (length[i] - L[i])
            m += 1
    for _ in range(EXCHANGES):
        while m > 3:
            m = without(taut, m, least(x, 3, m), x)
        if not polish(data, L, k, f, taut, m, x, length, a, D):
            return -1
        b = least(x, 3, m)
        if m > 0 and x[3 + b] < 0.0:
            m = without(taut, m, b, x)
            continue
        worst, excess = -1, VIOLATED
        for i in range(count):
            held = elastic[i]
            for c in range(m):
                held = held or taut[c] == i
            if not held and length[i] - L[i] > excess:
                worst, excess = i, length[i] - L[i]
        if worst < 0:
            ascending(taut, m, x)
            return m
        if m == 3:
            # Four constraints on a point: the one with the least tension gives way.
            m = without(taut, m, b, x)
        taut[m] = worst
        x[3 + m] = 0.0
        m += 1
    return -1
