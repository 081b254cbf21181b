"""A robot in one pose as points and lines to draw; plain floats, nothing certified.

Of a number that the robot has as a range the middle is drawn.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.orientation import rotation_from_quaternion
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import Point
from solvers.answers.data import CableState, Solution
from solvers.report.rope import course, wheel

Points = NDArray[np.float64]
CURVE_POINTS = 25
"""Of a hanging cable."""
CLOSE = 0.04
"""Share of the frame within which labels would lie over each other."""
ROOM = 0.04
"""Around what is drawn, as a share of it."""
FLAT = 0.25
"""Of the longest axis is the shortest at least, also of a robot in a plane."""
MOST_BINS = 40
LEAST_SPREAD = 1e-6
"""Of a histogram, as a share of its values."""
VISIBLE = 1e-5
"""Of a tube, in m; that of exact data is thinner."""
STEEP = 1e-6
"""Seen from above, a cable whose ends are nearer than this share of its length hangs down and up again."""


@dataclass(frozen=True)
class DrawnCable:
    """One cable."""

    name: str
    points: Points
    """(n, 3) m: two for a straight cable, more for a hanging one and over a pulley."""
    state: CableState
    tension: float
    """N, in the middle of the proved bounds."""
    text: str
    """What is known of it."""


@dataclass(frozen=True)
class Scene:
    """One pose."""

    title: str
    cables: tuple[DrawnCable, ...]
    platform: Points
    """(N, 3) m: platform anchors."""
    centre: Points
    """(3,) m: centre of mass."""
    tube: Points
    """(n, 3) m: edges of boxes as pairs of corners, where the platform anchors are for every choice of the
    data; empty where these are exact."""
    wheels: Points
    """(n, 3) m: edges of pulleys as pairs of points."""

    @property
    def body(self) -> Points:
        """Pairs of points that are joined to show the platform, (2 n, 3); empty for a point mass."""
        points = np.unique(np.concatenate([self.platform, self.centre[None, :]]), axis=0)
        pairs = [points[[i, j]] for i in range(len(points)) for j in range(i)]
        return np.concatenate(pairs) if pairs else np.empty((0, 3))


def axis_range(values: Sequence[float]) -> tuple[float, float]:
    """Return bounds of a histogram's axis, apart even when all values are the same."""
    low, high = min(values), max(values)
    least = LEAST_SPREAD * max(abs(low), abs(high), 1.0)
    return (low, high) if high - low > least else (low - least, high + least)


def frame_points(robot: Robot) -> Points:
    """Return the exit points, (N, 3) m."""
    return np.array([_floats(cable.frame_anchor) for cable in robot.cables])


def labels(robot: Robot) -> list[str]:
    """Return what to write at each exit point: those that are close together share the label of the first."""
    points, names = frame_points(robot), robot.cable_names
    reach = CLOSE * float(np.linalg.norm(np.ptp(points, axis=0)))
    found = [""] * len(names)
    free = list(range(len(names)))
    while free:
        first = free[0]
        near = [i for i in free if float(np.linalg.norm(points[i] - points[first])) <= reach]
        found[first] = ", ".join(names[i] for i in near)
        free = [i for i in free if i not in near]
    return found


def scene(robot: Robot, solution: Solution, lengths: Bounds, number: int) -> Scene:
    """Return what to draw of a solution.

    Parameters
    ----------
    robot : Robot
    solution : Solution
    lengths : (N, 2) array
        m, of the cables.
    number : int
        Of the solution, from 1.
    """
    origin = np.array(solution.nominal.position)
    turn = rotation_from_quaternion(solution.nominal.quaternion_wxyz)
    anchors = np.array([_floats(cable.platform_anchor) for cable in robot.cables])
    platform = origin + anchors @ turn.T
    centre = origin + turn @ _floats(robot.platform.centre_of_mass)
    up = -_floats(robot.gravity) / np.linalg.norm(_floats(robot.gravity))
    cables = []
    for i, cable in enumerate(robot.cables):
        state = solution.cable_states[i]
        points = course(cable, robot, platform[i])
        if state is CableState.SLACK:
            # What is slack hangs between the pulley, or the exit point, and the platform.
            gone = float(np.linalg.norm(np.diff(points[:-1], axis=0), axis=1).sum())
            free = hanging(points[-2], platform[i], float(lengths[i].mean()) - gone, up)
            points = np.concatenate([points[:-2], free])
        text = f"{cable.name}: {state.value}, {_range(solution.tensions[i], 'N')}"
        least, most = solution.tensions[i].tolist()
        tension = max(0.5 * (least + most) if math.isfinite(most) else least, 0.0)
        cables.append(DrawnCable(cable.name, points, state, tension, text))
    taut = ", ".join(robot.cables[i].name for i in solution.taut)
    title = f"{number}: {taut} taut, {solution.stability.value}"
    wheels = [wheel(cable, robot, platform[i]) for i, cable in enumerate(robot.cables)]
    return Scene(title, tuple(cables), platform, centre, tube(solution, anchors), np.concatenate(wheels))


def tube(solution: Solution, anchors: Points) -> Points:
    """Return the edges of boxes around the platform anchors (N, 3), as far as these are for every choice.

    Those of exact data are points, and not drawn; so is what is not bounded.
    """
    boxes = []
    for anchor in np.unique(anchors, axis=0):
        ends = solution.rotation * anchor[None, :, None]
        low, high = ends.min(axis=2).sum(axis=1), ends.max(axis=2).sum(axis=1)
        boxes.append(solution.position + np.stack([low, high], axis=1))
    found = np.array(boxes)
    visible = np.isfinite(found).all() and np.ptp(found, axis=2).max() > VISIBLE
    return np.concatenate([region(box) for box in found]) if visible else np.empty((0, 3))


def hanging(start: Points, end: Points, length: float, up: Points, count: int = CURVE_POINTS) -> Points:
    """Return points (count, 3) of the catenary of a length in m between two points; straight if too short."""
    way = end - start
    rise = float(way @ up)
    level = way - rise * up
    across = float(np.linalg.norm(level))
    if length <= float(np.linalg.norm(way)) * (1 + 1e-12):
        return np.array([start, end])
    if across < STEEP * length:
        lowest = start + 0.5 * level - 0.5 * (length - rise) * up
        return np.array([start, lowest, end])
    # sinh(x) / x = sqrt(length^2 - rise^2) / across gives the shape: x = across / (2 a).
    wanted = math.sqrt(length * length - rise * rise) / across
    x = _inverse_sinhc(wanted)
    a = across / (2 * x)
    middle = a * math.atanh(rise / length)
    s = np.linspace(-across / 2, across / 2, count)
    heights = a * np.cosh((s + middle) / a)
    heights -= heights[0]
    share = (s + across / 2) / across
    return start + share[:, None] * level + heights[:, None] * up


def _inverse_sinhc(wanted: float) -> float:
    """Return x > 0 with sinh(x) / x as wanted, above 1; bisection."""
    low, high = 1e-9, 1.0
    while math.sinh(high) / high < wanted:
        high *= 2
    for _ in range(80):
        x = 0.5 * (low + high)
        low, high = (x, high) if math.sinh(x) / x < wanted else (low, x)
    return x


def region(bounds: Bounds) -> Points:
    """Return the edges of a box as pairs of corners, (24, 3); infinite bounds are not drawn."""
    corners = [[bounds[k, (c >> k) & 1] for k in range(3)] for c in range(8)]
    edges = [(a, a | 1 << k) for a in range(8) for k in range(3) if not a >> k & 1]
    return np.array([corners[end] for edge in edges for end in edge], dtype=np.float64)


def hull(scenes: Sequence[Scene], robot: Robot, others: Sequence[Points] = ()) -> tuple[Points, Points]:
    """Return the least and largest coordinates of all that is drawn, other points (n, 3) in m among it."""
    points = [frame_points(robot), *others, *(scene.platform for scene in scenes)]
    points += [scene.centre[None, :] for scene in scenes]
    points += [cable.points for scene in scenes for cable in scene.cables]
    everything = np.concatenate(points)
    return everything.min(axis=0), everything.max(axis=0)


def space(low: Points, high: Points) -> tuple[Points, Points]:
    """Return where axes begin and end, (3,) m: around what is drawn, and thick also where that is flat."""
    size = high - low
    room = np.maximum(ROOM * size, 0.5 * (FLAT * size.max() - size)) + ROOM * size.max()
    return low - room, high + room


def bins(count: int) -> int:
    """Return how many bins a histogram of so many values has: Rice's rule, at most `MOST_BINS`."""
    return min(math.ceil(2.0 * count ** (1.0 / 3.0)), MOST_BINS)


def _floats(point: Point) -> Points:
    """Return the doubles next to a point, (3,); of a range its middle."""
    return np.array([float(x.mid if isinstance(x, Range) else x) for x in point])


def _range(bounds: Bounds, unit: str) -> str:
    lo, hi = (float(x) for x in bounds)
    if math.isfinite(hi) and hi - lo <= 1e-6 * max(abs(hi), 1.0):
        return f"{0.5 * (lo + hi):.6g} {unit}"
    return f"{lo:.6g} to {hi:.6g} {unit}" if math.isfinite(hi) else f"{lo:.6g} {unit} or more"
