"""Platforms that hang by cables at their centre of mass: others are slack, or just tight without tension.

Which poses these are, and one of them to list. See ``unloaded`` for the cells of larger subsets.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.mechanics.rotation import HALF_TURNS
from cdpr_interval.mechanics.six_dof.frame import Pose, cayley, half_turn
from solvers.questions.problem import Problem

Floats = NDArray[np.float64]

FINEST = 2.0**-7
"""Half width in u of the smallest rotations looked at for one that leaves all other cables slack."""
MOST = 300_000
"""And the most of them."""


def hangs_by_centre(problem: Problem, taut: Sequence[int], pose: Pose) -> bool:
    """Return True where a proved pose has no tension but in cables at the centre of mass, exactly."""
    outer = [i for i in taut if any(map(any, problem.loaded.arm_ranges[i]))]
    if len(outer) in (0, len(taut)) or len(outer) > 3:
        return False
    moments = []
    for i in outer:
        arm = pose.rotation * balls.ranges(problem.loaded.arm_ranges[i])
        moments.append(balls.cross(arm, balls.ranges(problem.loaded.exit_ranges[i]) - pose.centre))
    if len(outer) == 1:
        return any(not x.contains(0) for x in balls.entries(moments[0]))
    normal = balls.cross(moments[0], moments[1])
    if len(outer) == 2:
        return any(not x.contains(0) for x in balls.entries(normal))
    return not balls.dot(normal, moments[2]).contains(0)


def slack_rotation(problem: Problem, centre: arb_mat, cables: Sequence[int]) -> arb_mat | bool:
    """Look for a rotation about the centre of mass that leaves some cables slack.

    Returns it, False where it is proved that there is none, and True where neither was found.

    Guarantee: with a = A - p a cable is at most l long where a . R b >= (|a|^2 + |b|^2 - l^2) / 2. Rotations
    R(u), R(v) differ by an angle of at most 2 |u - v|, so a . R b by at most that times |a| |b|.
    """
    spokes = [balls.ranges(problem.loaded.exit_ranges[j]) - centre for j in cables]
    arms = [balls.ranges(problem.loaded.arm_ranges[j]) for j in cables]
    most = [balls.from_fraction(problem.lengths[j][1]) for j in cables]
    least = [
        balls.to_bounds((balls.dot(a, a) + balls.dot(b, b) - length * length) / 2)[0]
        for a, b, length in zip(spokes, arms, most, strict=True)
    ]
    a = np.array([balls.middle(x)[:, 0] for x in spokes])
    b = np.array([balls.middle(x)[:, 0] for x in arms])
    size = np.array(
        [balls.to_bounds(balls.norm(x) * balls.norm(y))[1] for x, y in zip(spokes, arms, strict=True)]
    )
    # Of a and b, and some dozens of roundings.
    loose = [
        balls.to_bounds((radius_of(s) * balls.norm(y) + balls.norm(s) * radius_of(y)) * 2)[1]
        for s, y in zip(spokes, arms, strict=True)
    ]
    error = np.array(loose) + 1e-13 * (size + np.abs(least))
    h = 1.0
    cells = np.array([[0.0, 0.0, 0.0, chart] for chart in range(4)])
    while True:
        above = excesses(cells, a, b) - np.array(least)
        best = cells[int(np.argmax(above.min(axis=1)))]
        if above.min(axis=1).max() > 0.0:
            rotation = rotation_of(best)
            if all(is_slack_at(problem, centre, rotation, j) for j in cables):
                return rotation
        reach = 2.0 * np.sqrt(3.0) * h * (1.0 + 1e-12)
        cells = cells[np.all(above + reach * size * (1.0 + 1e-12) + error >= 0.0, axis=1)]
        if len(cells) == 0:
            return False
        if h <= FINEST or 8 * len(cells) > MOST:
            return True
        h *= 0.5
        corners = h * np.array([[x, y, z, 0.0] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        cells = (cells[:, None, :] + corners[None]).reshape(-1, 4)


def radius_of(v: arb_mat) -> arb:
    """Return a bound of how far vectors in a ball are from its middle."""
    return sum((x.rad() for x in balls.entries(v)), arb(0))


def excesses(cells: Floats, a: Floats, b: Floats) -> Floats:
    """Return a_j . R b_j (m, k) at the middles of cells (m, 4) of rotations: u and the chart."""
    u = cells[:, None, :3]
    turned = HALF_TURNS[cells[:, 3].astype(np.int64)][:, None, :] * b[None]
    across = np.cross(u, turned)
    rotated = turned + 2.0 * (across + np.cross(u, across)) / (1.0 + (u * u).sum(axis=2, keepdims=True))
    return np.asarray((rotated * a[None]).sum(axis=2))


def rotation_of(cell: Floats) -> arb_mat:
    """Return the rotation at the middle of a cell."""
    return cayley([arb(float(x)) for x in cell[:3]]) * half_turn(int(cell[3]))


def is_slack_at(problem: Problem, centre: arb_mat, rotation: arb_mat, j: int) -> bool:
    """Return True where a cable is proved slack."""
    point = centre + rotation * balls.ranges(problem.loaded.arm_ranges[j])
    distance = balls.norm(balls.ranges(problem.loaded.exit_ranges[j]) - point)
    return bool(distance < balls.from_fraction(problem.lengths[j][0]))
