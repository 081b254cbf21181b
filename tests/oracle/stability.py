"""Stability from the Hessian of the Lagrangian on the free motions."""

from __future__ import annotations

from typing import Any

import numpy as np

from .statics import Pose, System, cross, skew, spokes, stretched

CLEAR = 1e-9
"""An eigenvalue nearer to zero, in the units of the system, says nothing."""


def stability(system: System, pose: Pose, taut: Any, free: Any) -> str:
    """Return ``stable``, ``unstable`` or ``unclear`` for a float pose.

    Parameters
    ----------
    free : ndarray
        (k, 6 or 3): the motions along the continuum of the pose, taken out first.
    """
    r, e = spokes(system, pose, taut)
    rho = stretched(system, pose, taut)
    q = pose.tensions / rho
    soft = system.compliance[taut]
    size = 6 if system.turns else 3
    hessian = np.zeros((size, size))
    gradients = (np.concatenate([e, cross(r, e)], axis=-1) if system.turns else e) / rho[:, None]
    for i in range(len(taut)):
        # Half the square of the distance has the second variation |v + w x r|^2 - e . (w x (w x r)).
        motion = np.hstack([np.eye(3), -skew(r[i])])[:, :size]
        second = motion.T @ motion
        if system.turns:
            second[3:, 3:] += (e[i] @ r[i]) * np.eye(3) - 0.5 * (np.outer(e[i], r[i]) + np.outer(r[i], e[i]))
        hessian += q[i] * second
        if soft[i] > 0:
            hessian += (1 / soft[i] - q[i]) * np.outer(gradients[i], gradients[i])
    fixed = [gradients[i] for i in range(len(taut)) if soft[i] == 0] + list(free)
    basis = np.eye(size)
    if fixed:
        _, s, vt = np.linalg.svd(np.array(fixed))
        basis = vt[int((s > 1e-9).sum()) :].T
    if basis.shape[1] == 0:
        return "stable"
    lowest = np.linalg.eigvalsh(basis.T @ hessian @ basis)[0]
    return "stable" if lowest > CLEAR else "unstable" if lowest < -CLEAR else "unclear"
