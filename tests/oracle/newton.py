"""Many Newton iterations at once: Levenberg-Marquardt on a batch of starts, in floats."""

from __future__ import annotations

from typing import Any

import numpy as np

from .statics import Pose, System, jacobian, moved, residual

CONVERGED = 1e-11
STEPS = 70
PATIENCE = 20
"""After so many steps a start whose residual is still above `HOPELESS` is given up."""
HOPELESS = 0.3


def solve(system: System, starts: Pose, taut: Any) -> Pose:
    """Return the solutions that the starts (K, ...) lead to; those that lead nowhere are left out.

    The damping is in proportion to the squared residual, so that the iteration also converges
    fast to solutions that come in continua.
    """
    pose, damping = starts, np.full(len(starts.p), 1.0)
    value = residual(system, pose, taut)
    size = np.linalg.norm(value, axis=-1)
    # A pushing spring has no meaning; it must not shrink to nothing on the way.
    soft = system.compliance[taut]
    least = np.where(soft > 0, -0.5 * system.lengths[taut] / np.where(soft > 0, soft, 1.0), -np.inf)
    found: list[Pose] = []
    for step in range(STEPS):
        done = size < CONVERGED
        if done.any():
            found.append(_chosen(pose, done))
        keep = ~done & (damping < 1e12)
        if step > PATIENCE:
            keep &= size < HOPELESS
        if not keep.any():
            break
        pose, value, size, damping = _chosen(pose, keep), value[keep], size[keep], damping[keep]
        j = jacobian(system, pose, taut)
        jt = np.swapaxes(j, -1, -2)
        mu = damping * np.minimum(size, 1.0) ** 2 * 1e-2 + 1e-15
        normal = jt @ j + mu[:, None, None] * np.eye(j.shape[-1])
        change = -np.linalg.solve(normal, jt @ value[..., None])[..., 0]
        change *= np.minimum(1.0, 1.0 / np.linalg.norm(change, axis=-1))[:, None]
        trial = moved(pose, change, system.turns)
        trial = Pose(trial.p, trial.rotation, np.maximum(trial.tensions, least))
        new_value = residual(system, trial, taut)
        new_size = np.linalg.norm(new_value, axis=-1)
        better = new_size < size
        pose = Pose(
            *(np.where(better.reshape(-1, *(1,) * (a.ndim - 1)), b, a) for a, b in _pairs(pose, trial))
        )
        value = np.where(better[:, None], new_value, value)
        size = np.where(better, new_size, size)
        damping = np.where(better, np.maximum(damping / 5.0, 1e-6), damping * 6.0)
    return Pose(
        *(
            np.concatenate([getattr(f, name) for f in found]) if found else getattr(starts, name)[:0]
            for name in ("p", "rotation", "tensions")
        )
    )


def _pairs(a: Pose, b: Pose) -> list[tuple[Any, Any]]:
    return [(a.p, b.p), (a.rotation, b.rotation), (a.tensions, b.tensions)]


def _chosen(pose: Pose, mask: Any) -> Pose:
    return Pose(pose.p[mask], pose.rotation[mask], pose.tensions[mask])
