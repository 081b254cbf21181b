"""Whether a result holds a planted pose, and whether what it lists is in balance, in plain floats."""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact.enclosure import Bounds
from solvers.answers.data import CableState, Solution, StopReason
from solvers.answers.result import Result
from tests.support.planted.platform import Planted

Floats = NDArray[np.float64]

NEAR = 1e-6
"""A box this near to the planted pose (m, and rotation entries) is taken for its box."""
BALANCE = 1e-6
"""Residual force and moment as a share of the load, beyond what the boxes' widths explain."""


class Verdict(StrEnum):
    """What became of a planted pose."""

    FOUND = "found"
    """In the box of a proved solution with the planted taut cables, the others slack or switching."""
    UNDECIDED = "undecided"
    """In an undecided region, or in an entry that is not proved or has a cable whose state is open."""
    PENDING = "pending"
    """Not found before a budget ran out."""
    LOST = "LOST"


def judge(planted: Planted, result: Result) -> Verdict:
    """Return what became of the planted pose."""
    rotation, position = planted_pose(planted)
    com = np.array(planted.robot.platform.centre_of_mass, dtype=np.float64)
    holding = [s for s in result.solutions if holds(s, rotation, position, com)]
    if any(s.is_decided and agrees(planted, s) for s in holding):
        return Verdict.FOUND
    if any(agrees(planted, s) for s in holding):
        return Verdict.UNDECIDED
    for region in result.undecided:
        if covers(region.position, position) and covers(region.rotation, rotation):
            return Verdict.UNDECIDED
    if result.pending or result.stop_reason is not StopReason.EXHAUSTED:
        return Verdict.PENDING
    return Verdict.LOST


def planted_pose(planted: Planted) -> tuple[Floats, Floats]:
    """Return rotation and platform origin as floats."""
    return np.array(planted.rotation, dtype=np.float64), np.array(planted.position, dtype=np.float64)


def agrees(planted: Planted, solution: Solution) -> bool:
    """Return True when no cable state of a solution contradicts the planted one."""
    wanted = [CableState.TAUT if i in planted.taut else CableState.SLACK for i in range(len(planted.lengths))]
    either = (CableState.UNDECIDED, CableState.SWITCHING)
    return all(s is w or s in either for s, w in zip(solution.cable_states, wanted, strict=True))


def covers(bounds: Bounds, value: Floats) -> bool:
    """Return True when every entry lies in its range, up to the tolerance."""
    return bool(np.all(bounds[..., 0] - NEAR <= value) and np.all(value <= bounds[..., 1] + NEAR))


def middle(bounds: Bounds) -> Floats:
    """Return the centres of ranges."""
    return np.asarray(0.5 * (bounds[..., 0] + bounds[..., 1]), dtype=np.float64)


def holds(solution: Solution, rotation: Floats, position: Floats, com: Floats) -> bool:
    """Return True when a pose lies in a solution's box, for a family after turning it back."""
    family = solution.family
    if family is None:
        return covers(solution.rotation, rotation) and covers(solution.position, position)
    if family.kind == "all-rotations":
        # Turning moves the origin, but not the centre of mass.
        origin = position + (rotation - middle(solution.rotation)) @ com
        return covers(solution.position, origin)
    assert family.axis_point is not None and family.axis_direction is not None
    points, directions = middle(family.axis_point), middle(family.axis_direction)
    listed = middle(solution.rotation)
    if family.kind == "torus":
        first = angle_between(directions[0], directions[1], rotation @ listed.T @ directions[1])
        back = turn(directions[0], -first)
        rotation, position = back @ rotation, points[0] + back @ (position - points[0])
        points, directions = points[1], directions[1]
    across = perpendicular(directions)
    angle = angle_between(directions, across, rotation @ listed.T @ across)
    back = turn(directions, -angle)
    turned = back @ rotation, points + back @ (position - points)
    ranges = family.angle_ranges if family.kind == "rotation" else np.array([[[-4.0, -4.0], [4.0, 4.0]]])
    inside = any(
        lo[0] - NEAR <= angle + k * 2 * np.pi <= hi[1] + NEAR for lo, hi in ranges for k in (-1, 0, 1)
    )
    return inside and covers(solution.rotation, turned[0]) and covers(solution.position, turned[1])


def perpendicular(direction: Floats) -> Floats:
    """Return a unit vector perpendicular to a direction."""
    other = np.eye(3)[int(np.argmin(np.abs(direction)))]
    across = np.cross(direction, other)
    return np.asarray(across / np.linalg.norm(across), dtype=np.float64)


def angle_between(axis: Floats, a: Floats, b: Floats) -> float:
    """Return the angle about a unit axis that turns a to b."""
    a, b = a - axis * (axis @ a), b - axis * (axis @ b)
    return float(np.arctan2(axis @ np.cross(a, b), a @ b))


def turn(axis: Floats, angle: float) -> Floats:
    """Return the rotation about a unit axis."""
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k, dtype=np.float64)


def complaints(planted: Planted, result: Result) -> list[str]:
    """Return what is wrong with any listed pose: lengths, tensions, balance, slackness."""
    found = result.verify(planted.robot)
    for number, solution in enumerate(result.solutions):
        for rotation, position in listed_poses(solution):
            found += [
                f"solutions[{number}]: {text}" for text in imbalance(planted, solution, rotation, position)
            ]
    return found


def listed_poses(solution: Solution) -> list[tuple[Floats, Floats]]:
    """Return the middle of a solution's box; for a turning family also at the ends of its ranges."""
    rotation, position = middle(solution.rotation), middle(solution.position)
    poses = [(rotation, position)]
    family = solution.family
    if family is None or family.kind != "rotation":
        return poses
    assert family.axis_point is not None and family.axis_direction is not None
    point, direction = middle(family.axis_point), middle(family.axis_direction)
    for start, end in family.angle_ranges:
        for angle in np.linspace(start[1], end[0], 5):
            r = turn(direction, float(angle))
            poses.append((r @ rotation, point + r @ (position - point)))
    return poses


def imbalance(planted: Planted, solution: Solution, rotation: Floats, position: Floats) -> Iterator[str]:
    """Check one pose of a solution against lengths, slackness and equilibrium."""
    com = np.array(planted.robot.platform.centre_of_mass, dtype=np.float64)
    load = np.array(planted.load, dtype=np.float64)
    size = float(np.linalg.norm(load))
    pull = np.concatenate([load, np.zeros(3)])
    loose = BALANCE + 10.0 * float(np.max(solution.position[:, 1] - solution.position[:, 0]))
    loose += 10.0 * float(np.max(solution.rotation[..., 1] - solution.rotation[..., 0]))
    loose += float(np.max(solution.tensions[:, 1] - solution.tensions[:, 0])) / size
    for i, cable in enumerate(planted.robot.cables):
        arm = rotation @ (np.array(cable.platform_anchor, dtype=np.float64) - com)
        spoke = np.array(cable.frame_anchor, dtype=np.float64) - position - rotation @ com - arm
        distance = float(np.linalg.norm(spoke))
        lo, hi = (float(x) for x in planted.lengths[i])
        state, tension = solution.cable_states[i], middle(solution.tensions[i])
        if state is CableState.TAUT and not lo - loose <= distance <= hi + loose:
            yield f"cable {i} is taut at {distance}, its length is {lo}..{hi}"
        if state is CableState.SLACK and solution.slack_respected and distance > hi + loose:
            yield f"cable {i} is slack at {distance}, its length is {lo}..{hi}"
        if tension < 0:
            yield f"cable {i} pushes"
        pull += tension / distance * np.concatenate([spoke, np.cross(arm, spoke)])
    if np.max(np.abs(pull)) > loose * size:
        yield f"out of balance by {np.max(np.abs(pull)) / size} of the load"
