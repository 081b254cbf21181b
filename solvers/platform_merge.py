"""One root for one pose: roots of one search that were seen in several charts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from solvers.platform_frame import Frame, lies_in, pose_of
from solvers.platform_roots import Root

Floats = NDArray[np.float64]


def distinct(roots: Sequence[Root], frame: Frame) -> list[Root]:
    """Keep one root of each pose: two are the same when one lies in the other's uniqueness box.

    Roots inside their chart are preferred; the order is the roots' own.
    """
    ordered = sorted(roots, key=order_of)
    candidates = may_coincide(ordered)
    kept: list[Root] = []
    indices: list[int] = []
    for k, root in enumerate(ordered):
        others = [other for other, j in zip(kept, indices, strict=True) if candidates[k, j]]
        pose = pose_of(replace(root, box=root.core), frame) if others else None
        if pose is None or not any(lies_in(pose, frame, other) for other in others):
            kept.append(root)
            indices.append(k)
    return kept


def order_of(root: Root) -> tuple[bool, int, list[float]]:
    """Return the key by which roots are sorted."""
    low, high = root.box.T.tolist()
    return max(high[:3]) > 1.0 or min(low[:3]) < -1.0, root.chart, low


def may_coincide(roots: Sequence[Root]) -> NDArray[np.bool_]:
    """Return which roots (rows) may lie in which uniqueness boxes (columns), by positions and tensions alone.

    These mean the same in all charts: where False, ``lies_in`` is False as well.
    """
    if not roots:
        return np.zeros((0, 0), dtype=np.bool_)
    core = np.array([root.core for root in roots])[:, None, 3:]
    unique = np.array([root.unique for root in roots])[None, :, 3:]
    inside = (unique[..., 0] <= core[..., 0]) & (core[..., 1] <= unique[..., 1])
    return np.asarray(inside.all(axis=-1))
