"""Poses for a tracker to start from, and whether a pose lies in its region."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.mechanics.orientation import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_vector,
    vector_from_rotation,
)
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Robot
from solvers.answers.data import CableState, Certainty, Nominal, Proof, Solution
from solvers.answers.result import Result
from solvers.six_dof.tracked_pose import Region, TrackedPose

Floats = NDArray[np.float64]
EDGE = 1e-6
"""Poses this near to the border of a region, as a share of its radius, count as neither in nor out."""


def com_of(robot: Robot) -> Floats:
    """Return the centre of mass in the platform frame."""
    return np.array([float(x) for x in robot.platform.centre_of_mass])


def start_at(
    robot: Robot, taut: Sequence[int], rotation: Floats, position: Floats, tensions: Sequence[float]
) -> Solution:
    """Return a pose, right or wrong, in the shape in which a tracker takes it."""

    def thin(x: Any) -> Floats:
        return np.stack([x, x], axis=-1)

    exits = np.array([[float(x) for x in c.frame_anchor] for c in robot.cables])
    points = np.array([[float(x) for x in c.platform_anchor] for c in robot.cables])
    distances = np.linalg.norm(exits - position - points @ rotation.T, axis=1)
    states = [CableState.TAUT if i in taut else CableState.SLACK for i in range(len(robot.cables))]
    x, y, z = (float(value) for value in position)
    return Solution(
        taut=tuple(taut),
        cable_states=tuple(states),
        position=thin(position),
        rotation=thin(rotation),
        height=np.zeros(2),
        tensions=thin(np.array(tensions, dtype=np.float64)),
        distances=thin(distances),
        slack_respected=True,
        existence=Certainty.PROVED,
        uniqueness=Certainty.PROVED,
        proof=Proof.INTERVAL_NEWTON,
        stability=Stability.UNDECIDED,
        nominal=Nominal((x, y, z), quaternion_from_rotation(rotation), (0.0, 0.0, 0.0)),
        family=None,
    )


def moved(robot: Robot, s: Solution, turn: Sequence[float], shift: Sequence[float]) -> Solution:
    """Return a pose turned about its centre of mass and shifted."""
    before = s.rotation.mean(axis=-1)
    rotation = rotation_from_vector(turn) @ before
    position = s.position.mean(axis=-1) + (before - rotation) @ com_of(robot) + np.array(shift)
    return start_at(robot, s.taut, rotation, position, list(s.tensions.mean(axis=-1)))


def depth(robot: Robot, region: Region, rotation: Floats, position: Floats) -> float:
    """Return how far out in a region a pose lies: up to 1 it is inside."""
    centre = position + rotation @ com_of(robot)
    turn = vector_from_rotation(rotation @ rotation_from_quaternion(region.quaternion).T)
    shift = float(np.linalg.norm(centre - np.array(region.centre)))
    return max(shift / region.radius, float(np.linalg.norm(turn)) / region.angle)


def overlap(a: Any, b: Any) -> bool:
    """Return True when bounds meet in every entry."""
    return bool(np.all(a[..., 0] <= b[..., 1]) and np.all(b[..., 0] <= a[..., 1]))


def check_alone(robot: Robot, pose: TrackedPose, result: Result) -> None:
    """Check a tracked pose against the list of static poses for the same lengths.

    Of the poses in the region there is only the tracked one; it must be there where the list is complete.
    """
    assert pose.tracked and pose.region is not None
    where = [
        depth(robot, pose.region, s.rotation.mean(axis=-1), s.position.mean(axis=-1))
        for s in result.solutions
    ]
    near = [s for s, d in zip(result.solutions, where, strict=True) if d <= 1.0 + EDGE]
    sure = [s for s, d in zip(result.solutions, where, strict=True) if d <= 1.0 - EDGE]
    same = [s for s in near if same_pose(pose, s)]
    assert all(same_pose(pose, s) for s in sure), f"another pose lies in {pose.region}: {where}"
    assert len(same) <= 1
    if result.outcome == "complete":
        assert len(same) == 1, f"there is no such pose: {where}"
    for s in same:
        assert s.taut == pose.taut and s.cable_states == pose.states
        assert Stability.UNDECIDED in (s.stability, pose.stability) or s.stability is pose.stability


def same_pose(pose: TrackedPose, s: Solution) -> bool:
    """Return True when all bounds of two proved poses meet."""
    pairs = (
        (pose.rotation, s.rotation),
        (pose.position, s.position),
        (pose.tensions, s.tensions),
        (pose.distances, s.distances),
        (pose.height, s.height),
    )
    return all(overlap(a, b) for a, b in pairs)


def widest(pose: TrackedPose) -> float:
    """Return the largest width of position and rotation; NaN where a bound is."""
    return max(float(np.ptp(pose.position, axis=-1).max()), float(np.ptp(pose.rotation, axis=-1).max()))


def is_finite(pose: TrackedPose) -> bool:
    """Return True when every bound is a number."""
    fields = (pose.position, pose.rotation, pose.tensions, pose.distances, pose.height)
    return all(bool(np.isfinite(x).all()) for x in fields) and math.isfinite(sum(pose.quaternion))
