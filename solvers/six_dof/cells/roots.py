"""Proved roots of a taut subset's square system, and which unknowns and equations that system has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np
from flint import arb
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Budget
from cdpr_interval.exact import balls
from cdpr_interval.mechanics.rotation import rotation_at
from cdpr_interval.mechanics.six_dof.arrays import Model
from cdpr_interval.mechanics.six_dof.frame import Frame, Pose, centred_cayley, coordinates, half_turn
from solvers.six_dof.cells.columns import POSE_COLUMNS
from solvers.six_dof.cells.kinds import POSE_CELLS, ROTATION_CELLS, CellKind
from solvers.six_dof.cells.root_search import FEW_LEAVES, MOST_STARTS, Bench, System, find_roots

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Reduction:
    """Which unknowns are free and which statics equations are kept, by chart.

    ``frozen[c]`` are the entries of u fixed at 0 in chart c, or None where the chart is not used.
    """

    frozen: tuple[tuple[int, ...] | None, ...]
    statics: tuple[int, ...]
    """Kept rows among (force, moment) in the base frame; with ``rod`` the moment is projected."""
    planar: bool = False
    rod: bool = False
    """Keep only the two moments across the line of the platform points (its z axis)."""

    def free(self, n: int, chart: int) -> Ints:
        """Return the indices of the free unknowns of z = (u, p, t)."""
        if not self.statics:
            return np.arange(6, dtype=np.int64)
        fixed = set(self.frozen[chart] or ())
        if self.planar:
            fixed.add(4)
        return np.array([k for k in range(6 + n) if k not in fixed], dtype=np.int64)

    def rows(self) -> Floats:
        """Return the kept combinations of the six statics equations; with ``rod`` two are left zero."""
        unit = np.eye(6)[list(self.statics)].reshape(-1, 6)
        return np.vstack([unit, np.zeros((2, 6))]) if self.rod else np.ascontiguousarray(unit)


@cache
def system_of(reduction: Reduction, n: int) -> System:
    """Return the reduced system of n taut cables as the kernels see it; there are only a few."""
    used = [chart for chart in range(4) if reduction.frozen[chart] is not None]
    free = np.array([reduction.free(n, chart if chart in used else used[0]) for chart in range(4)])
    frozen = np.array([[k in (reduction.frozen[chart] or ()) for k in range(3)] for chart in range(4)])
    return System(free, frozen, reduction.rows(), reduction.rod, bool(reduction.statics))


GENERAL = Reduction(((), (), (), ()), (0, 1, 2, 3, 4, 5))
GEOMETRY = Reduction(((), (), (), ()), ())
"""Six taut cables: the lengths alone fix the pose, the tensions follow by a linear solve."""
ABOUT_VERTICAL = Reduction(((2,), (2,), None, None), (0, 1, 2, 3, 4))
"""Family (a): turning about the load direction z is taken out; its moment equation is dropped.

A turn about z turns the quaternion entries (w, z) and (x, y) each in its plane. Of the longer pair the
second can be made 0, and its first is then the largest entry: chart 0 with z = 0, or chart 1 with y = 0.
"""
ABOUT_ROD = Reduction(((2,), (2,), None, None), (0, 1, 2), rod=True)
"""Family (b): turning about the platform's z axis is taken out."""
PLANAR = Reduction(((0, 2), None, (0, 2), None), (0, 2, 4), planar=True)
"""The plane y = 0: one angle, two coordinates, three equilibrium equations."""


@dataclass(frozen=True, eq=False)
class Root:
    """A proved zero of exact data: exactly one in ``box``, no other one in ``unique``, which holds ``box``.

    Boxes are (6 + n, 2) in (u, p, t). ``core`` holds the zero, too: for data with ranges that of one choice.
    """

    chart: int
    box: Floats
    unique: Floats
    core: Floats

    @property
    def parts(self) -> tuple[Any, ...]:
        """The tubes it is made of; none for exact data."""
        return ()

    def row(self) -> Floats:
        """Return the uniqueness box as the kernels read it."""
        return np.concatenate([[self.chart], self.unique[:, 0], self.unique[:, 1]])


class Prover:
    """Finds and proves the zeros of one reduced system: roots, of exact data."""

    kinds: ClassVar[tuple[CellKind, CellKind]] = (ROTATION_CELLS, POSE_CELLS)
    """The cells of the search in u and of that in (u, x)."""
    find_zeros: ClassVar[Callable[..., tuple[int, int]]] = staticmethod(find_roots)
    """The compiled search for zeros from leaves."""

    def __init__(self, model: Model, reduction: Reduction) -> None:
        self.model = model
        self.system = system_of(reduction, model.n_taut)

    def seen_by_cells(self, roots: Sequence[Root]) -> Any:
        """Return the uniqueness boxes as one array for the kernels."""
        width = 1 + 2 * (6 + self.model.n_taut)
        return np.array([root.row() for root in roots]).reshape(len(roots), width)

    def bench(self, roots: Sequence[Root]) -> Any:
        """Return scratch that holds the roots known, with room for as many as one call may find."""
        room = (len(roots) + MOST_STARTS, 6 + self.model.n_taut, 2)
        charts, unique = np.zeros(room[0], dtype=np.int64), np.empty(room)
        for k, root in enumerate(roots):
            charts[k] = root.chart
            unique[k] = root.unique
        turn, pose = self.kinds
        return Bench(turn.scratch(), pose.scratch(), charts, unique, np.empty(room))

    def root(self, bench: Any, k: int) -> Root:
        """Return the root in row ``k``."""
        box, unique = bench.boxes[k].copy(), bench.unique[k].copy()
        return Root(int(bench.charts[k]), box, unique, box)

    def find(
        self, leaves: Floats, leaf_size: float, kind: CellKind, known: Sequence[Root], budget: Budget
    ) -> tuple[list[Root], Floats]:
        """Start Newton from leaves spread over each cluster.

        Returns the new roots that were proved, and the leaves that are not settled by roots yet.
        """
        found: list[Root] = []
        todo, first = np.ones(len(leaves), dtype=np.bool_), 0
        while first < len(leaves) and budget.stop() is None:
            before = [*known, *found]
            bench = self.bench(before)
            first, count = self.find_zeros(
                self.model, self.system, bench, len(before), leaves, todo, first, kind.columns, leaf_size
            )
            found += [self.root(bench, k) for k in range(len(before), count)]
        return found, leaves[todo] if first == len(leaves) else leaves

    def root_near(self, chart: int, u: Floats, p: Floats) -> Root | None:
        """Return the proved root that Newton finds from a pose."""
        cell = np.zeros((1, POSE_COLUMNS.width))
        pivot = self.model.orders[0, 0]
        turned = np.empty((3, 3))
        rotation_at(u, turned)
        x = p - self.model.exits[pivot] + turned @ self.model.arms[chart, pivot]
        cell[0, :6] = np.repeat(u, 2)
        cell[0, 6:12] = np.repeat(x, 2)
        cell[0, POSE_COLUMNS.chart] = chart
        found, _ = self.find(cell, 0.0, self.kinds[1], [], Budget())
        return found[0] if found else None

    def unsettled(self, cells: Floats, roots: Sequence[Root], kind: CellKind) -> Floats:
        """Return the cells whose equilibria are not all one root's.

        The search looks before it contracts a cell; here the contracted leaves get a last look.
        """
        bench, todo = self.bench(roots), np.zeros(len(cells), dtype=np.bool_)
        for first in range(0, len(cells), FEW_LEAVES):
            few = slice(first, first + FEW_LEAVES)
            # Without a leaf to start from only this last look is left.
            self.find_zeros(
                self.model, self.system, bench, len(roots), cells[few], todo[few], 0, kind.columns, 0.0
            )
        return cells[todo]


def pose_of(root: Root, frame: Frame) -> Pose:
    """Return a root's pose in the robot's frames.

    R(u) is enclosed by its value at the middle and the mean value theorem, so that wide boxes
    (interval lengths) are not overestimated more than needed.
    """
    u = [balls.from_bounds(lo, hi) for lo, hi in root.box[:3]]
    model_rotation = centred_cayley(u) * half_turn(root.chart)
    p = balls.vector([balls.from_bounds(lo, hi) for lo, hi in root.box[3:6]])
    back = frame.base.transpose()
    rotation = back * model_rotation * frame.platform
    centre = back * p + balls.ranges(frame.origin)
    densities = tuple(balls.from_bounds(lo, hi) for lo, hi in root.box[6:])
    return Pose(rotation, centre, densities)


def lies_in(pose: Pose, frame: Frame, root: Root) -> bool:
    """Return True when a pose with its densities is proved to lie in a root's uniqueness box.

    Coordinates that the reduced problem fixes are zero-width sides of the box. An equilibrium has
    them exactly, in one of the mirrored frames; in the other they are far off, so touching is enough.
    """
    where = coordinates(pose, frame, root.chart)
    if where is None:
        return False
    values = [*where[0], *where[1], *pose.densities]
    for x, (lo, hi) in zip(values, root.unique, strict=True):
        if not (x.contains(arb(lo)) if lo == hi else balls.inside(x, lo, hi)):
            return False
    return True
