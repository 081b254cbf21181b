"""Random starts for Newton: a rotation, a place within reach and the tensions that fit best."""

from __future__ import annotations

from typing import Any

import numpy as np

from .statics import Pose, System, cross, spokes


def rotation_of(q: Any) -> Any:
    """Return the rotation matrices of quaternions (..., 4), scalar first, of any length but zero."""
    q = q / np.sqrt((q * q).sum(axis=-1))[..., None]
    v, w = q[..., 1:], q[..., 0]
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def random_starts(rng: np.random.Generator, system: System, taut: Any, count: int) -> Pose:
    """Return random poses whose lengths are not far off, with fitting tensions."""
    rotation = np.broadcast_to(np.eye(3), (count, 3, 3))
    if system.turns:
        rotation = rotation_of(rng.normal(size=(count, 4)))
    centres = system.exits[taut] - (rotation[:, None, :, :] * system.arms[taut][:, None, :]).sum(axis=-1)
    reach = system.lengths[taut][None, :, None]
    lo, hi = (centres - reach).max(axis=1), (centres + reach).min(axis=1)
    p = np.minimum(lo, hi) + rng.random((count, 3)) * np.abs(hi - lo)
    # Poses hang below their exits more often than not: half of the starts are moved that way.
    down = system.load / np.linalg.norm(system.load)
    sunk = rng.random(count) < 0.5
    p = p + np.where(sunk, rng.random(count) * 0.5, 0.0)[:, None] * down
    pose = Pose(p, rotation, np.ones((count, len(taut))))
    r, e = spokes(system, pose, taut)
    unit = e / np.maximum(np.linalg.norm(e, axis=-1), 1e-9)[..., None]
    rows = np.concatenate([unit, cross(r, unit)], axis=-1)
    right = rows @ np.concatenate([-system.load, np.zeros(3)])
    gram = rows @ np.swapaxes(rows, -1, -2) + 1e-3 * np.eye(len(taut))
    tensions = np.linalg.solve(gram, right[..., None])[..., 0]
    return Pose(p, rotation, np.clip(tensions, 0.02, 5.0))
