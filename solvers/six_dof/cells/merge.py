"""One root for one pose: roots of one search that were seen in several charts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from flint import arb
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.mechanics.six_dof.frame import Frame, Pose, half_turn
from solvers.six_dof.cells.roots import ABOUT_ROD, ABOUT_VERTICAL, GENERAL, Reduction, Root, lies_in, pose_of

Floats = NDArray[np.float64]

PLAIN = Frame.plain()
"""The model's own frames."""


def distinct(roots: Sequence[Root], reduction: Reduction = GENERAL) -> list[Root]:
    """Keep one root of each pose: two are the same when one lies in the other's uniqueness box.

    All is seen in the model's own frames: those of data with ranges differ from choice to choice.
    Of a family each chart shows another pose: it is turned to where the other chart would show it. Roots
    inside their chart are preferred; the order is the roots' own.
    """
    ordered = sorted(roots, key=order_of)
    turns = reduction in (ABOUT_VERTICAL, ABOUT_ROD)
    candidates = np.ones((len(ordered),) * 2, dtype=np.bool_) if turns else may_coincide(ordered)
    kept: list[Root] = []
    indices: list[int] = []
    for k, root in enumerate(ordered):
        pairs = list(zip(kept, indices, strict=True))
        if not any(
            (candidates[k, j] and is_in(root, other, reduction))
            or (candidates[j, k] and is_in(other, root, reduction))
            for other, j in pairs
        ):
            kept.append(root)
            indices.append(k)
    return kept


def is_in(one: Root, other: Root, reduction: Reduction) -> bool:
    """Return True when a root is proved to be in another one's uniqueness box."""
    pose = pose_of(replace(one, box=one.core), PLAIN)
    return lies_in(in_family(pose, reduction, other.chart), PLAIN, other)


def in_family(pose: Pose, reduction: Reduction, chart: int) -> Pose:
    """Turn a pose about its family's axis to where u has no third entry in a chart.

    The pose itself without a family, or where it is not proved that the chart shows it.
    """
    if reduction not in (ABOUT_VERTICAL, ABOUT_ROD):
        return pose
    flip = half_turn(chart)
    r = pose.rotation * flip
    along, across = r[1, 0] - r[0, 1], r[0, 0] + r[1, 1]
    if not (across > 0 or along > 0 or along < 0):
        return pose
    behind = across.mid() < 0
    angle = arb.pi() + arb.atan2(-along, -across) if behind else arb.atan2(along, across)
    back = balls.turn(balls.vector([0, 0, 1]), -angle)
    if reduction == ABOUT_ROD:
        return replace(pose, rotation=pose.rotation * flip * back * flip)
    return Pose(back * pose.rotation, back * pose.centre, pose.densities)


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


def one_of_each_torus(roots: Sequence[Root]) -> list[Root]:
    """Keep one root of each family about two axes, the vertical z and a rod along the platform's x axis.

    Both lie in the plane y = 0 of the search. Half a turn about the one and half a turn about the other
    take a root's pose to another one in that plane, which is of the same family.
    """
    about_z, about_x = half_turn(3), half_turn(1)
    kept: list[Root] = []
    for root in roots:
        pose = pose_of(replace(root, box=root.core), PLAIN)
        other = Pose(about_z * pose.rotation * about_x, about_z * pose.centre, pose.densities)
        if not any(lies_in(other, PLAIN, one) for one in kept):
            kept.append(root)
    return kept
