"""Families of poses: by which angles a pose is turned from the listed one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from .starts import rotation_of
from .statics import skew
from .subsets import StaticPose

TOLERANCE = 1e-7
"""Rotation entries, and lengths relative to the distances of the cables."""
EDGE = 1e-6
"""So near to an end of a range (rad) nothing is said."""


@dataclass(frozen=True)
class FamilyFit:
    """A member of a family."""

    angles: tuple[float, ...]
    place: str
    """``inside`` or ``outside`` the listed ranges, or at their ``edge``."""


def turn(axis: Any, angle: float) -> Any:
    """Return the rotation about a unit vector."""
    s = skew(axis)
    return np.eye(3) + np.sin(angle) * s + (1 - np.cos(angle)) * (s @ s)


def axes_of(family: Any) -> list[tuple[Any, Any]]:
    """Return the point and unit direction of each axis."""
    if family["kind"] == "all-rotations":
        return []
    points = np.array(family["axis_point_m"]).mean(axis=-1).reshape(-1, 3)
    directions = np.array(family["axis_direction"]).mean(axis=-1).reshape(-1, 3)
    return [(p, d / np.linalg.norm(d)) for p, d in zip(points, directions, strict=True)]


def member(family: Any, centre: Any, rotation: Any, angles: tuple[float, ...]) -> tuple[Any, Any]:
    """Return centre of mass and rotation of the listed pose turned about the axes, the last axis first."""
    for (point, axis), angle in reversed(list(zip(axes_of(family), angles, strict=True))):
        q = turn(axis, angle)
        centre, rotation = point + q @ (centre - point), q @ rotation
    return centre, rotation


def members(family: Any, centre: Any, rotation: Any, count: int) -> Iterator[tuple[Any, Any]]:
    """Yield centre of mass and rotation of members spread over a family."""
    rng = np.random.default_rng(0)
    axes = len(axes_of(family))
    for k in range(count):
        if axes == 0:
            yield centre, rotation_of(rng.normal(size=4))
            continue
        rest = rng.uniform(-np.pi, np.pi, axes - 1)
        yield member(family, centre, rotation, (2 * np.pi * k / count, *rest))


def fit_family(family: Any, centre: Any, rotation: Any, width: float, pose: StaticPose) -> FamilyFit | None:
    """Return the angles at which a family has a pose, or None.

    ``centre`` and ``rotation`` are the middles of what is listed, ``width`` the width of these bounds,
    relative like `TOLERANCE`.
    """
    there, turned = pose.centre.astype(float), pose.rotation.astype(float)
    scale = float(max(pose.distances)) + float(np.linalg.norm(there - centre))
    tolerance = TOLERANCE + 4.0 * width
    if family["kind"] == "all-rotations":
        return FamilyFit((), "inside") if np.linalg.norm(there - centre) < tolerance * scale else None
    axes = axes_of(family)
    relative = turned @ rotation.T
    if len(axes) == 1:
        angles: tuple[float, ...] = (_angle(axes[0][1], relative),)
    else:
        outer, inner = axes[0][1], axes[1][1]
        first = _angle_between(outer, inner, relative @ inner)
        angles = (first, _angle(inner, turn(outer, -first) @ relative))
    p, r = member(family, centre, rotation, angles)
    if np.abs(r - turned).max() > tolerance or np.linalg.norm(p - there) > tolerance * scale:
        return None
    return FamilyFit(angles, place(family, angles))


def place(family: Any, angles: tuple[float, ...]) -> str:
    """Return whether angles lie inside or outside the listed ranges, or at an edge."""
    ranges = family["angle_ranges_rad"]
    if family["kind"] != "rotation":
        # One full range an axis; anything else would be a range of pairs, which the format lacks.
        return "inside"
    best = "outside"
    for (before, start), (end, after) in ranges:
        for whole in (-2, -1, 0, 1, 2):
            angle = angles[0] + 2 * np.pi * whole
            if start + EDGE <= angle <= end - EDGE:
                return "inside"
            if before - EDGE <= angle <= after + EDGE:
                best = "edge"
    if ranges and sum(end - start for (_, start), (end, _) in ranges) > 2 * np.pi - EDGE:
        return "inside"
    return best


def _angle(axis: Any, rotation: Any) -> float:
    """Return the angle of a rotation about an axis."""
    twist = np.array(
        [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    )
    return float(np.arctan2(axis @ twist, np.trace(rotation) - axis @ rotation @ axis))


def _angle_between(axis: Any, a: Any, b: Any) -> float:
    """Return the angle about an axis that turns a to b; 0 for vectors along the axis."""
    a, b = a - axis * (axis @ a), b - axis * (axis @ b)
    if np.linalg.norm(a) < 1e-9:
        return 0.0
    return float(np.arctan2(axis @ np.cross(a, b), a @ b))
