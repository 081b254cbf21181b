"""Newton at 50 digits, also on solutions that come in continua."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np

from .statics import DIGITS, Pose, System, jacobian, moved, number, residual

SINGULAR = (1e-8, 1e-12)
"""A singular value below such a share of the largest may be zero: the solution is then one of a continuum."""
GUARD = 10
STEPS = 9


def refine(system: System, precise: System, pose: Pose, taut: Any) -> tuple[Pose, int] | None:
    """Return a float solution at 50 digits and the number of its free directions; None where that fails.

    The Jacobian is bordered with its null vectors, so that each step changes nothing along a
    continuum.
    """
    u, s, vt = np.linalg.svd(jacobian(system, pose, taut))
    # A nearly singular isolated solution looks like a continuum, but its bordered system has no solution.
    for free in dict.fromkeys(int((s < share * s[0]).sum()) for share in SINGULAR):
        left, right = u[:, len(s) - free :], vt[len(s) - free :]
        with mpmath.workdps(DIGITS + GUARD):
            sharp = _iterated(precise, exact_start(pose, system.turns), taut, left, right)
        if sharp is not None:
            return sharp, free
    return None


def _iterated(precise: System, pose: Pose, taut: Any, left: Any, right: Any) -> Pose | None:
    last = mpmath.mpf(1)
    for _ in range(STEPS):
        step = _bordered_step(precise, pose, taut, left, right)
        if step is None:
            return None
        size = max(abs(x) for x in step)
        if size > 1e-2 or (size > last and size > 1e-30):
            return None
        pose, last = moved(pose, step[None], precise.turns), size
        if size < mpmath.mpf(10) ** (-DIGITS + 3):
            off = max(abs(x) for x in residual(precise, pose, taut)[0])
            one = Pose(pose.p[0], pose.rotation[0], pose.tensions[0])
            return one if off < mpmath.mpf(10) ** (-DIGITS + 5) else None
    return None


def exact_start(pose: Pose, turns: bool) -> Pose:
    """Return the same pose as a batch of one in mpmath numbers, its rotation orthogonal to all digits."""
    sharp = np.vectorize(number, otypes=[object])
    rotation = sharp(np.eye(3))
    if turns:
        q = sharp(quaternion_of(pose.rotation))
        rotation = rotation_of(q)
    return Pose(sharp(pose.p)[None], rotation[None], sharp(pose.tensions)[None])


def rotation_of(q: Any) -> Any:
    """Return the rotation of a quaternion of mpmath numbers."""
    norm = mpmath.sqrt(sum(x * x for x in q))
    w, x, y, z = (c / norm for c in q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ],
        dtype=object,
    )


def quaternion_of(rotation: Any) -> Any:
    """Return the quaternion (w, x, y, z) of a rotation matrix: the largest column of 4 q q^T."""
    m = rotation
    t = np.trace(m)
    outer = np.array(
        [
            [1 + t, m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], 1 - t + 2 * m[0, 0], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
            [m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], 1 - t + 2 * m[1, 1], m[1, 2] + m[2, 1]],
            [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], 1 - t + 2 * m[2, 2]],
        ]
    )
    column = outer[:, int(np.argmax(np.diagonal(outer)))]
    return column / np.linalg.norm(column)


def _bordered_step(precise: System, pose: Pose, taut: Any, left: Any, right: Any) -> Any:
    """Return the Newton step of the bordered system; None where it is singular."""
    j = jacobian(precise, pose, taut)[0]
    m, free = len(j), left.shape[1]
    big = mpmath.zeros(m + free)
    for a in range(m):
        for b in range(m):
            big[a, b] = j[a, b]
        for k in range(free):
            big[a, m + k] = mpmath.mpf(float(left[a, k]))
            big[m + k, a] = mpmath.mpf(float(right[k, a]))
    value = residual(precise, pose, taut)[0]
    side = mpmath.matrix([-x for x in value] + [mpmath.mpf(0)] * free)
    try:
        step = mpmath.lu_solve(big, side)
    except ZeroDivisionError:
        return None
    return np.array([step[a] for a in range(m)], dtype=object)
