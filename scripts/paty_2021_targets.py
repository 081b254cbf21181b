"""Where the study of Paty et al. 2021 asks: straight paths, the plane z = 2.5 m, the grid of a box."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray
from paty_2021_model import LEAD_IN, SIDE, Floats, Poses, corners, solved

from cdpr_interval.robots.cable_robot import Robot

MIDDLE = 2.5
"""m: height of the plane."""
HALF_WIDTH, TOP = 2.314, 3.75
"""m, of the box of the averages, RW_C: the printed volume is 80.31 m3, and the path of section 5 ends at this
height."""


@dataclass(frozen=True)
class Settings:
    """How finely the study asks."""

    points: int = 50
    """Across the box of the averages each way, twice as many upward: 250000 in all, as in the paper."""
    line_points: int = 30
    """The same where the optima are searched."""
    path_points: int = 1001
    plane_intervals: int = 60
    lead_in: Fraction = LEAD_IN


@dataclass(frozen=True)
class Path:
    """A straight path of targets."""

    targets: Floats
    """(T, 3), m."""
    abscissa: Floats
    """(T,), m from the start."""


def straight(start: Sequence[float], end: Sequence[float], count: int) -> Path:
    """Return evenly spaced targets from one point to another, m."""
    a, b = np.array(start, float), np.array(end, float)
    share = np.linspace(0.0, 1.0, count)
    return Path(a + share[:, None] * (b - a), share * float(np.linalg.norm(b - a)))


def rising(cables: int, count: int) -> Path:
    """Return the path of section 3.3: from below A_1, or between A_1 and A_4, up to the other side."""
    x, y, top = corners(cables)[0]
    start = (x, y if cables == 3 else 0.0, 0.0)
    reach = 0.5 if cables == 3 else 1.0
    return straight(start, (-reach * start[0], -reach * start[1], top), count)


def plane(cables: int, intervals: int) -> Floats:
    """Return targets (T, 3) on z = 2.5 m, the corners and edges of the floor plan included."""
    if cables == 3:
        i, j = (k.ravel() for k in np.indices((intervals + 1, intervals + 1)))
        kept = i + j <= intervals
        weights = np.column_stack([i, j, intervals - i - j])[kept] / intervals
        flat = weights @ corners(3)[:, :2]
    else:
        x = np.linspace(-SIDE / 2, SIDE / 2, intervals + 1)
        flat = np.stack([g.ravel() for g in np.meshgrid(x, x, indexing="ij")], axis=1)
    return np.column_stack([flat, np.full(len(flat), MIDDLE)])


@dataclass(frozen=True)
class Mean:
    """The mean error over a grid of targets."""

    error: float
    """m, over the targets that three cables can hold."""
    valid: int
    """Targets that they can hold, of ``total``."""
    total: int


def grid(points: int) -> tuple[Floats, NDArray[np.int64]]:
    """Return targets (T, 3) that stand for the grid of the box, and for how many (T,) each stands.

    The grid has ``points`` across each way and twice as many upward, the faces included. The square robot
    is its own mirror image in x = 0, y = 0 and x = y: one target in eight is enough.
    """
    x = np.round(np.linspace(-HALF_WIDTH, HALF_WIDTH, points), 12)
    whole = np.stack([g.ravel() for g in np.meshgrid(x, x, indexing="ij")], axis=1)
    flat, times = np.unique(np.sort(np.abs(whole), axis=1), axis=0, return_counts=True)
    z = np.linspace(0.0, TOP, 2 * points)
    targets = np.column_stack([np.repeat(flat, len(z), axis=0), np.tile(z, len(flat))])
    return targets, np.repeat(times, len(z)).astype(np.int64)


def mean(robot: Robot, points: int) -> Mean:
    """Return the mean error of a robot on four cables over the grid."""
    targets, times = grid(points)
    return weighted(solved(robot, targets), times)


def weighted(poses: Poses, times: NDArray[np.int64]) -> Mean:
    """Return the mean error of targets that stand for several each."""
    kept = poses.valid
    valid = int(times[kept].sum())
    error = float((poses.error[kept] * times[kept]).sum()) / valid if valid else float("nan")
    return Mean(error, valid, int(times.sum()))
