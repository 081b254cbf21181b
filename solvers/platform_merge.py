"""One entry for one pose: roots seen in several charts, and poses that several taut sets share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from solvers.platform_frame import Frame, lies_in, pose_of
from solvers.platform_roots import Root
from solvers.result import CableState, Solution, Stability, Undecided

Floats = NDArray[np.float64]

CLUSTER = 1e-3
"""Widest hull (rotation entries, position over its size) of a cluster that a proved pose may absorb."""


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


def is_open(solution: Solution) -> bool:
    """Return True where a tension or a slack is only just zero."""
    return CableState.UNDECIDED in solution.cable_states


def overlap(a: Floats, b: Floats) -> bool:
    """Return True when two boxes (..., 2) meet."""
    return bool(np.all(a[..., 0] <= b[..., 1]) and np.all(b[..., 0] <= a[..., 1]))


def same_place(a: Solution, b: Solution) -> bool:
    """Return True when two poses cannot be told apart."""
    return overlap(a.position, b.position) and overlap(a.rotation, b.rotation)


def shared(solutions: Sequence[Solution], names: Sequence[str]) -> list[Solution]:
    """Merge entries of different taut sets that share a pose, up to proof, into one with hulls."""
    merged: list[Solution] = []
    for solution in solutions:
        place = next(
            (
                k
                for k, other in enumerate(merged)
                if is_open(other) and is_open(solution) and same_place(other, solution)
            ),
            None,
        )
        if place is None:
            merged.append(solution)
        else:
            merged[place] = union(merged[place], solution, names)
    return merged


def union(a: Solution, b: Solution, names: Sequence[str]) -> Solution:
    """Return one entry for two taut sets at one pose."""
    states = tuple(
        x if x is y else CableState.UNDECIDED for x, y in zip(a.cable_states, b.cable_states, strict=True)
    )
    tight = [name for name, s in zip(names, states, strict=True) if s is not CableState.SLACK]
    respected = a.slack_respected if a.slack_respected == b.slack_respected else None
    return replace(
        a,
        taut=tuple(i for i, s in enumerate(states) if s is CableState.TAUT),
        cable_states=states,
        position=hull(a.position, b.position),
        rotation=hull(a.rotation, b.rotation),
        height=hull(a.height, b.height),
        tensions=hull(a.tensions, b.tensions),
        distances=hull(a.distances, b.distances),
        slack_respected=respected,
        stability=a.stability if a.stability is b.stability else Stability.UNDECIDED,
        family=a.family if b.family is not None else None,
        note=f"cables {{{', '.join(tight)}}} tight, tensions not unique",
    )


def hull(a: Floats, b: Floats) -> Floats:
    """Return the smallest box (..., 2) around two."""
    return np.stack([np.minimum(a[..., 0], b[..., 0]), np.maximum(a[..., 1], b[..., 1])], axis=-1)


def absorb(
    solutions: Sequence[Solution], undecided: Sequence[Undecided], names: Sequence[str]
) -> tuple[list[Solution], list[Undecided]]:
    """Fold small undecided clusters into the open pose they surround.

    Where more cables are exactly tight than their wrenches have rank, the larger taut sets have
    no isolated root there. The pose's cables stay undecided, so the outcome stays incomplete.
    """
    found = list(solutions)
    left: list[Undecided] = []
    for cluster in undecided:
        place = next((k for k, s in enumerate(found) if belongs(cluster, s)), None)
        if place is None:
            left.append(cluster)
            continue
        tight = [
            n for n, s in zip(names, found[place].cable_states, strict=True) if s is not CableState.SLACK
        ]
        note = f"cables {{{', '.join(tight)}}} tight, tensions not unique"
        found[place] = replace(found[place], note=note)
    return found, left


def belongs(cluster: Undecided, solution: Solution) -> bool:
    """Return True when a cluster is small, holds the pose and needs no cable that is slack there."""
    size = max(1.0, float(np.abs(solution.position).max()))
    small = (
        np.max(cluster.rotation[..., 1] - cluster.rotation[..., 0]) < CLUSTER
        and np.max(cluster.position[:, 1] - cluster.position[:, 0]) < CLUSTER * size
    )
    return bool(
        is_open(solution)
        and small
        and overlap(cluster.position, solution.position)
        and overlap(cluster.rotation, solution.rotation)
        and all(solution.cable_states[i] is not CableState.SLACK for i in cluster.taut)
    )
