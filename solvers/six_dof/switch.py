"""A cable that is just taut or just slack: exactly one pose, whichever it is, proved as one system.

With T the cables that carry and cable j that may, the unknowns z = (u, p, t) of T's square system solve the
balance, the lengths of all but j, and min(t_j, h_j) = 0 with h_j = l_j^2 - |e_j|^2: see
`cdpr_interval.mechanics.complementarity`. With g the derivative of j's length and H the form of stability on
the free motions, what is to be positive there is g' H^-1 g.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.complementarity import either_way, improved, slope
from cdpr_interval.mechanics.energy import to_matrix
from cdpr_interval.mechanics.rotation import best_chart
from cdpr_interval.mechanics.six_dof import system as newton
from cdpr_interval.mechanics.six_dof.arrays import Model, build_model
from cdpr_interval.mechanics.six_dof.frame import Frame, Pose, centred_cayley, coordinates, half_turn
from cdpr_interval.mechanics.six_dof.tension_polytope import column, wrench_matrix
from solvers.questions.problem import Problem
from solvers.six_dof.solution import geometry

Floats = NDArray[np.float64]

MARGINS = (1e-4, 1e-6, 1e-8)
"""Margins of the box without a second pose that are tried, over the size of each unknown."""
MOST_CABLES = 6


@dataclass(frozen=True, eq=False)
class Switch:
    """Exactly one pose, cable ``switching`` just taut or just slack, for every choice of lengths."""

    problem: Problem
    cables: tuple[int, ...]
    """Those that carry and the one that may."""
    switching: int
    chart: int
    pose: Pose
    """Encloses the pose for all choices, with t of ``cables``."""
    alone: Floats
    """(6 + n, 2) bounds of (u, p, t) in which there is no second one."""

    def holds(self, rotation: arb_mat, centre: arb_mat) -> bool:
        """Return True when all static poses with these rotations and centres are this one.

        They are zeros of the system only where no other cable can carry, and where those that carry here
        carry in all of them: a slack one's length is not an equation.
        """
        pose = Pose(rotation, centre, ())
        where = coordinates(pose, Frame.plain(), self.chart)
        if where is None or not self.others_are_slack(pose):
            return False
        t = tensions_at(self.problem, self.cables, pose)
        if t is None or not all(x > 0 for i, x in zip(self.cables, t, strict=True) if i != self.switching):
            return False
        found = [*where[0], *where[1], *t]
        return all(balls.inside(x, lo, hi) for x, (lo, hi) in zip(found, self.alone.tolist(), strict=True))

    def others_are_slack(self, pose: Pose) -> bool:
        """Return True when all cables but these are proved slack in a pose's bounds, for all lengths."""
        distances = geometry(self.problem, pose).distances
        shortest = [balls.from_fraction(length[0]) for length in self.problem.lengths]
        pairs = enumerate(zip(distances, shortest, strict=True))
        return all(bool(d < least) for i, (d, least) in pairs if i not in self.cables)


class System:
    """The square system of some cables in one chart, in the robot's own frames."""

    def __init__(self, problem: Problem, cables: tuple[int, ...], chart: int) -> None:
        self.count = len(cables)
        self.model = model_of(problem, cables)
        self.data = np.empty((self.count + 1, 7, 2))
        newton.fill_data(self.model, chart, self.data)
        self.rows = np.eye(6)
        self.free = np.arange(6 + self.count, dtype=np.int64)

    def at(self, box: Floats) -> tuple[arb_mat, arb_mat]:
        """Return the equations (lengths first) and their derivatives over a box (6 + n, 2)."""
        m = 6 + self.count
        f, J = np.empty((m, 2)), np.empty((m, m, 2))
        newton.jacobian_over(self.data, self.rows, self.free, np.ascontiguousarray(box), f, J)
        return balls.column(f), balls.matrix(J)


def model_of(problem: Problem, cables: tuple[int, ...]) -> Model:
    """Return the arrays of some cables, all of them taut."""
    frame = Frame.plain()
    return build_model(
        [frame.exit_point(problem.loaded.exit_ranges[i]) for i in cables],
        [frame.arm(problem.loaded.arm_ranges[i]) for i in cables],
        [Range(*problem.lengths[i]) for i in cables],
        frame.force(problem.loaded.load_ranges),
        len(cables),
        slack=False,
    )


def tensions_at(problem: Problem, cables: Sequence[int], pose: Pose) -> list[arb] | None:
    """Return all t that balance in a pose's bounds; None where the wrenches may be dependent."""
    view = geometry(problem, pose)
    load = balls.ranges(problem.loaded.load_ranges)
    size = platform_size(problem)
    matrix = wrench_matrix([view.spokes[i] for i in cables], [view.arms[i] for i in cables], load, size)
    middle = balls.middle(matrix)
    n = len(cables)
    if n > MOST_CABLES or not np.isfinite(middle).all():
        return None
    left = to_matrix(np.asarray(np.linalg.pinv(middle[:, :n])))
    own = balls.columns(*[column(matrix, k) for k in range(n)])
    try:
        return balls.entries((left * own).solve(left * column(matrix, n) * -1))
    except ZeroDivisionError:
        return None


def platform_size(problem: Problem) -> float:
    """Return a length of the platform, in m."""
    return float(max(sum(abs(x) for x in b) for b in problem.loaded.middle.arms)) or 1.0


def switch_at(
    problem: Problem, carrying: tuple[int, ...], switching: int, rotation: arb_mat, centre: arb_mat
) -> Switch | None:
    """Return the proved pose near a guess at which one cable switches; None where the proof fails.

    Parameters
    ----------
    carrying, switching
        The cables with positive tensions, and the one that is just tight.
    rotation, centre : (3, 3), (3, 1)
        The guess, in the robot's frames.
    """
    cables = tuple(sorted((*carrying, switching)))
    if len(cables) > MOST_CABLES:
        return None
    middle = Pose(to_matrix(balls.middle(rotation)), to_matrix(balls.middle(centre)), ())
    chart = best_chart(balls.middle(rotation))
    where = coordinates(middle, Frame.plain(), chart)
    t = tensions_at(problem, cables, middle)
    if where is None or t is None:
        return None
    k = cables.index(switching)
    system = System(problem, cables, chart)
    z = np.array([float(x.mid()) for x in (*where[0], *where[1], *t)])
    start = improved(system, z, k)
    if start is None:
        return None
    return proved_near(problem, cables, k, chart, system, start)


def proved_near(
    problem: Problem, cables: tuple[int, ...], k: int, chart: int, system: System, z: Floats
) -> Switch | None:
    """Prove existence and uniqueness around the float zero z with t_k = 0."""
    box = either_way(system, z, k)
    if box is None:
        return None
    if not all(lo > 0.0 for i, (lo, _) in enumerate(box[6:].tolist()) if i != k):
        return None
    pose = pose_in(box, chart)
    scales = np.array([1.0] * 3 + [platform_size(problem)] * 3 + [float(np.abs(box[6:]).max())] * len(cables))
    for margin in MARGINS:
        wide = np.column_stack([box[:, 0] - margin * scales, box[:, 1] + margin * scales])
        if slope(system, wide, k) is None:
            continue
        found = Switch(problem, cables, cables[k], chart, pose, wide)
        # Whatever balances at the poses listed must lie where there is no second zero.
        if found.holds(pose.rotation, pose.centre):
            return found
    return None


def pose_in(box: Floats, chart: int) -> Pose:
    """Return the pose of a box of (u, p, t) in the robot's frames."""
    entries = [balls.from_bounds(lo, hi) for lo, hi in box.tolist()]
    rotation = centred_cayley(entries[:3]) * half_turn(chart)
    return Pose(rotation, balls.vector(entries[3:6]), tuple(entries[6:]))
