"""The lowest point of an intersection of balls in plain floating point: a guess, proved elsewhere.

Inextensible cables: minimise -f . p under |p - A_i| <= l_i. Multipliers t_i >= 0 (N/m) balance the load,
sum t_i (p - A_i) = f. The problem is of LP type: the lowest point of all balls is that of at most three
of them, and the lowest point of at most four balls without a common point shows that there is none.
So a basis of one to three balls is exchanged against the most violated one until none is violated.

Arrays: ``A`` (N, 3) exit points, ``L`` (N,) lengths, ``f`` (3,) load; ``p`` (3,) a point, and ``t`` (>= m,)
the multipliers of the m cables that hold it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import cdpr_interval.kernels  # noqa: F401  its cache
from cdpr_interval.kernels.kernel import entry

LOWEST = 0
"""Status: ``p`` is the lowest point of all balls, up to rounding."""
APART = 1
"""Status: the (at most four) balls of the basis seem to have no common point."""
STUCK = 2
"""Status: rounding stopped the exchange; ``p`` is the best point found."""

TOLERANCE = 1e-14
"""A ball is violated from this fraction of the sizes involved: a few roundings of a squared distance."""
EXCHANGE_ERROR = 1e-10
"""Most (relative) violation of its own members a new basis may show: closed forms lose half the digits
near touching spheres, and a wrong basis is caught by the proof, never reported."""


@entry()
def lowest_of_one(A: Any, L: Any, f: Any, i: int, p: Any, t: Any) -> bool:
    """Write the lowest point of one ball and its multiplier."""
    size = math.sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2])
    for k in range(3):
        p[k] = A[i, k] + L[i] * (f[k] / size)
    t[0] = size / L[i]
    return True


@entry()
def lowest_of_two(A: Any, L: Any, f: Any, i: int, j: int, p: Any, t: Any) -> bool:
    """Write the lowest point of the circle of two spheres and its multipliers; False where there is none.

    With d = A_j - A_i and g the part of f normal to d: p = A_i + (a / |d|) d + b g / |g|.
    """
    dx, dy, dz = A[j, 0] - A[i, 0], A[j, 1] - A[i, 1], A[j, 2] - A[i, 2]
    dd = dx * dx + dy * dy + dz * dz
    if not dd > 0.0:
        return False
    q = (f[0] * dx + f[1] * dy + f[2] * dz) / dd
    gx, gy, gz = f[0] - q * dx, f[1] - q * dy, f[2] - q * dz
    gg = gx * gx + gy * gy + gz * gz
    c = 0.5 * (1.0 + (L[i] - L[j]) * (L[i] + L[j]) / dd)
    bb = L[i] * L[i] - c * c * dd
    if not (bb > 0.0 and gg > 0.0):
        return False
    total = math.sqrt(gg / bb)
    p[0] = A[i, 0] + c * dx + gx / total
    p[1] = A[i, 1] + c * dy + gy / total
    p[2] = A[i, 2] + c * dz + gz / total
    t[1] = total * c - q
    t[0] = total - t[1]
    return True


@entry()
def lowest_of_three(A: Any, L: Any, f: Any, i: int, j: int, h: int, p: Any, t: Any) -> bool:
    """Write the lower common point of three spheres and its multipliers; False where there is none.

    x = p - A_i solves d . x = K_2, e . x = K_3, m . x = s with m = d x e, and s has the sign of f . m.
    """
    dx, dy, dz = A[j, 0] - A[i, 0], A[j, 1] - A[i, 1], A[j, 2] - A[i, 2]
    ex, ey, ez = A[h, 0] - A[i, 0], A[h, 1] - A[i, 1], A[h, 2] - A[i, 2]
    mx, my, mz = dy * ez - dz * ey, dz * ex - dx * ez, dx * ey - dy * ex
    mm = mx * mx + my * my + mz * mz
    dd = dx * dx + dy * dy + dz * dz
    ee = ex * ex + ey * ey + ez * ez
    if not mm > 0.0:
        return False
    k2 = 0.5 * (dd + (L[i] - L[j]) * (L[i] + L[j]))
    k3 = 0.5 * (ee + (L[i] - L[h]) * (L[i] + L[h]))
    vx, vy, vz = k2 * ex - k3 * dx, k2 * ey - k3 * dy, k2 * ez - k3 * dz
    ss = L[i] * L[i] * mm - (vx * vx + vy * vy + vz * vz)
    fm = f[0] * mx + f[1] * my + f[2] * mz
    if not (ss > 0.0 and fm != 0.0):
        return False
    s = math.sqrt(ss) if fm > 0.0 else -math.sqrt(ss)
    # x = (v x m + s m) / mm, because K_2 (e x m) + K_3 (m x d) = v x m.
    x = (vy * mz - vz * my + s * mx) / mm
    y = (vz * mx - vx * mz + s * my) / mm
    z = (vx * my - vy * mx + s * mz) / mm
    total = fm / s
    wx, wy, wz = total * x - f[0], total * y - f[1], total * z - f[2]
    t[1] = ((wy * ez - wz * ey) * mx + (wz * ex - wx * ez) * my + (wx * ey - wy * ex) * mz) / mm
    t[2] = ((dy * wz - dz * wy) * mx + (dz * wx - dx * wz) * my + (dx * wy - dy * wx) * mz) / mm
    t[0] = total - t[1] - t[2]
    p[0], p[1], p[2] = A[i, 0] + x, A[i, 1] + y, A[i, 2] + z
    return True


@entry()
def lowest_of_subset(A: Any, L: Any, f: Any, taut: Any, m: int, p: Any, t: Any) -> bool:
    """Write the pose and multipliers with which the ``m`` <= 3 cables ``taut`` alone balance the load.

    Parameters
    ----------
    A, L, f : (N, 3), (N,), (3,)
        Exit points, lengths and load.
    taut : (>= m,)
        Cable indices.
    p, t : (3,), (>= m,)
        Written: the point, and the multipliers (of any sign; their sum is positive).

    Returns
    -------
    bool
        False where the closed form has no (finite) value.
    """
    if m == 1:
        return lowest_of_one(A, L, f, taut[0], p, t)
    if m == 2:
        return lowest_of_two(A, L, f, taut[0], taut[1], p, t)
    return lowest_of_three(A, L, f, taut[0], taut[1], taut[2], p, t)


@entry()
def violation(A: Any, L: Any, p: Any, i: int) -> float:
    """Return by how much (relative to the sizes) p is outside ball ``i``; negative inside."""
    x, y, z = p[0] - A[i, 0], p[1] - A[i, 1], p[2] - A[i, 2]
    d = math.sqrt(x * x + y * y + z * z)
    return (d - L[i]) / (L[i] + abs(A[i, 0]) + abs(A[i, 1]) + abs(A[i, 2]))


@entry()
def exchange(A: Any, L: Any, f: Any, members: Any, n: int, basis: Any, p: Any, t: Any) -> int:
    """Find the lowest point of ``n`` <= 4 balls, the last of which is in the basis.

    Parameters
    ----------
    members : (>= n,)
        The balls.
    basis, p, t : (>= 3,), (3,), (>= 3,)
        Written: the new basis, its point and multipliers.

    Returns
    -------
    int
        Size of the new basis, 0 when no subset fits.
    """
    best = EXCHANGE_ERROR
    size = 0
    trial = np.empty(3, dtype=np.int64)
    q = np.empty(3)
    s = np.empty(3)
    for mask in range(1 << (n - 1)):
        m = 0
        for b in range(n - 1):
            if mask >> b & 1:
                if m < 3:
                    trial[m] = members[b]
                m += 1
        if m > 2:
            continue
        trial[m] = members[n - 1]
        m += 1
        if not lowest_of_subset(A, L, f, trial, m, q, s):
            continue
        worst = 0.0
        total = 0.0
        for a in range(m):
            total += abs(s[a])
        for a in range(m):
            worst = max(worst, -s[a] / total)
        for a in range(n):
            worst = max(worst, violation(A, L, q, members[a]))
        # The smaller basis wins a tie, so that a redundant ball stays out.
        if worst < best and not (size > 0 and m > size and worst > best - TOLERANCE):
            best = worst
            size = m
            for a in range(m):
                basis[a] = trial[a]
                t[a] = s[a]
            for k in range(3):
                p[k] = q[k]
    return size


@entry()
def lowest_point(A: Any, L: Any, f: Any, basis: Any, p: Any, t: Any) -> tuple[int, int]:
    """Find the lowest point of all balls.

    Parameters
    ----------
    A, L, f : (N, 3), (N,), (3,)
        Exit points, lengths and load.
    basis, p, t : (4,), (3,), (>= 3,)
        Written: the cables that carry the load (or up to four balls without a common point), the
        point and the multipliers.

    Returns
    -------
    status, size : int
        ``LOWEST``, ``APART`` or ``STUCK``, and the number of entries of ``basis``.
    """
    count = A.shape[0]
    members = np.empty(4, dtype=np.int64)
    basis[0] = 0
    size = 1
    lowest_of_one(A, L, f, 0, p, t)
    height = -(p[0] * f[0] + p[1] * f[1] + p[2] * f[2])
    for _ in range(20 + 10 * count):
        worst = TOLERANCE
        j = -1
        for i in range(count):
            v = violation(A, L, p, i)
            if v > worst:
                worst = v
                j = i
        if j < 0:
            return LOWEST, size
        for a in range(size):
            if basis[a] == j:
                return STUCK, size
            members[a] = basis[a]
        members[size] = j
        m = exchange(A, L, f, members, size + 1, basis, p, t)
        if m == 0:
            for a in range(size + 1):
                basis[a] = members[a]
            return APART, size + 1
        size = m
        new = -(p[0] * f[0] + p[1] * f[1] + p[2] * f[2])
        if not new > height:
            return STUCK, size
        height = new
    return STUCK, size
