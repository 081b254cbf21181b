"""The course of a cable over its pulley as points to draw; plain floats, nothing certified."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.mechanics.cables.law import model_of
from cdpr_interval.mechanics.cables.path import Floats, OffTheCable, Path
from cdpr_interval.robots.cable_robot import Cable, Robot
from cdpr_interval.robots.numbers import middle_point

Points = NDArray[np.float64]
ARC_POINTS = 13
"""Of the rope on the pulley."""
WHEEL_POINTS = 32
"""Of the pulley."""


def course(cable: Cable, robot: Robot, anchor: Points) -> Points:
    """Return the points (n, 3) of a taut cable to an anchor (3,), m: along its way, over its pulley."""
    path = _path(cable, robot, anchor)
    if path is None:
        return np.array([[float(x) for x in middle_point(cable.frame_anchor)], anchor])
    start = np.array(path.entry) - _arriving(path)
    points = [start, *_turned(path, np.linspace(0.0, path.wrap, ARC_POINTS)), np.array(path.exit), anchor]
    found = np.array(points)
    # A fixed exit point is start, entry and exit in one.
    apart = np.linalg.norm(np.diff(found, axis=0), axis=1) > 0.0
    return found[np.concatenate([[True], apart])]


def wheel(cable: Cable, robot: Robot, anchor: Points) -> Points:
    """Return the edges of a cable's pulley as pairs of points, (2 n, 3) m; none where it has none."""
    path = _path(cable, robot, anchor)
    if cable.pulley is None or cable.pulley.is_plain or path is None:
        return np.empty((0, 3))
    ring = _turned(path, np.linspace(0.0, 2.0 * math.pi, WHEEL_POINTS + 1))
    return np.stack([ring[:-1], ring[1:]], axis=1).reshape(-1, 3)


def _path(cable: Cable, robot: Robot, anchor: Points) -> Path | None:
    x, y, z = anchor.tolist()
    try:
        return model_of(cable.middle(), middle_point(robot.gravity)).route.path((x, y, z), Floats())
    except OffTheCable:
        return None


def _arriving(path: Path) -> Points:
    """Return the straight piece that arrives at the pulley as a vector."""
    _, second = _axes(path)
    return np.asarray(path.before * second)


def _axes(path: Path) -> tuple[Points, Points]:
    """Return unit vectors from the pulley's centre to where the rope meets it, and along the rope there."""
    arm, leave = np.array(path.entry) - path.centre, np.array(path.direction)
    radius = float(np.linalg.norm(arm))
    if radius == 0.0:
        return np.zeros(3), leave
    first = arm / radius
    # The rope's direction where it leaves is the one where it arrives, turned by the wrap towards -first.
    second = leave + math.sin(path.wrap) * first
    if abs(math.cos(path.wrap)) > 1e-3:
        return first, second / math.cos(path.wrap)
    away = (np.array(path.exit) - path.centre) / radius
    return first, (away - math.cos(path.wrap) * first) / math.sin(path.wrap)


def _turned(path: Path, angles: Points) -> Points:
    first, second = _axes(path)
    radius = float(np.linalg.norm(np.array(path.entry) - path.centre))
    turned = np.cos(angles)[:, None] * first + np.sin(angles)[:, None] * second
    return np.asarray(np.array(path.centre) + radius * turned)
