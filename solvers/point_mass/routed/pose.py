"""All static poses of a point mass on routed cables: one compiled call, and what it leaves open."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.engine.search import Report, Run, search
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.stability import Stability
from solvers.point_mass.cell_rows import WIDTH
from solvers.point_mass.convex import Unproved
from solvers.point_mass.entry import Fields, unpacked
from solvers.point_mass.fields import OPEN, SLACK
from solvers.point_mass.one_call import DECIDED, anywhere
from solvers.point_mass.routed.balance import prove_balance
from solvers.point_mass.routed.cells import first_cells, run_cells
from solvers.point_mass.routed.data import Routed, RoutedMass
from solvers.point_mass.routed.guess import guess
from solvers.point_mass.routed.one_call import (
    AMONG_OTHERS,
    SMALLEST,
    classify,
    data_of,
    fill,
    is_outward,
    routed_pose,
)
from solvers.point_mass.routed.tied import prove_tied, tied_tensions

States = NDArray[np.int64]
FINER = 0.125
"""Widths of the smallest cells of a further search over those of the one before."""
FINEST = 1e-7
"""In the kernels' units: smaller cells are left undecided."""
WIDTHS = tuple(0.25 * 0.5**i for i in range(20))
"""In the kernels' units: radii of domains of uniqueness that are tried."""
MOST_CELLS = 200_000
"""Of the searches for one question, unless it sets a limit: seconds."""
NEAR = "between cells that are not excluded a pose may lie: next to a pulley, or one too close to another"
TIGHT = "cables {} tight up to rounding, tensions may not be unique"
OPEN_STATE = "whether {} taut is not decided"


@dataclass(frozen=True)
class Found:
    """What is known of the poses of a robot."""

    poses: tuple[Fields, ...]
    stability: tuple[Stability, ...]
    regions: tuple[Unproved, ...] = ()
    """Where further poses may lie."""
    pending: int = 0
    cells: int = 0
    stop: Stop = Stop.EXHAUSTED
    by_convexity: bool = True
    """The only pose is one by convexity."""

    @property
    def complete(self) -> bool:
        """True when there is no pose but those listed."""
        return not self.regions and not self.pending


def quick_pose(mass: RoutedMass, lengths: Bounds) -> tuple[int, Bounds, States]:
    """Run the compiled path once for lengths (N, 2) in m; returns status, fields and states."""
    count = len(lengths)
    bounds, states = np.empty((4 + 2 * count, 2)), np.empty(count, dtype=np.int64)
    status = routed_pose(
        mass.routes,
        mass.elastic,
        mass.constant,
        mass.given,
        mass.load,
        mass.frame,
        lengths,
        bounds,
        states,
    )
    return status, bounds, states


@dataclass
class _Hunt:
    """The search for poses in what no proof covers."""

    mass: RoutedMass
    data: Routed
    budget: Budget
    threads: int
    report: Report | None
    cells: int = 0
    pending: int = 0
    stop: Stop = Stop.EXHAUSTED
    poses: list[Fields] = field(default_factory=list)
    stability: list[Stability] = field(default_factory=list)
    regions: list[Bounds] = field(default_factory=list)

    def run(self, outward: bool, taut: States, known: Bounds) -> None:
        """Look at everything that may hold a pose, finer and finer."""
        stack = np.empty((max(64, len(self.mass.routes)), WIDTH))
        cells = stack[: first_cells(self.data, outward, stack)]
        smallest = SMALLEST
        while len(cells):
            leaves = self._search(cells, (outward, taut, known), smallest)
            if self.pending:
                return
            smallest *= FINER
            cells = np.empty((0, WIDTH))
            for cluster in _clusters(leaves):
                if self._proved(cluster):
                    continue
                if smallest < FINEST:
                    self.regions.append(_hull(cluster))
                else:
                    cells = np.concatenate([cells, cluster])

    def _search(self, cells: NDArray[np.float64], first: tuple[Any, ...], smallest: float) -> Bounds:
        context = (self.data, *first, smallest)

        def make_run() -> Run:
            return lambda stack, count, leaves, kinds, children, limit: run_cells(
                context, stack, count, leaves, kinds, children, limit
            )

        found = search(make_run, cells, self.budget, threads=self.threads, report=self.report)
        self.cells += found.cells
        self.pending, self.stop = len(found.pending), found.stop
        return found.leaves

    def _proved(self, cluster: NDArray[np.float64]) -> bool:
        """Prove that all poses in a cluster of cells are one; only where every cable stretches."""
        if not self.mass.elastic.all():
            return False
        cover = _hull(cluster)
        x, box, domain = cover.mean(axis=1), np.empty((3, 2)), np.empty((3, 2))
        taut = np.empty(1, dtype=np.int64)
        if not prove_balance(self.data, taut, x, cover, box, domain):
            return False
        fields = fields_at(self.mass, self.data, taut[:0], box)
        if fields is None:
            return False
        apart = [_apart(fields.position, other.position) for other in self.poses]
        if all(apart):
            self.poses.append(fields)
            self.stability.append(Stability.STABLE if is_outward(self.data, box) else Stability.UNDECIDED)
        return True


def _apart(a: Bounds, b: Bounds) -> bool:
    return bool((a[:, 0] > b[:, 1]).any() or (b[:, 0] > a[:, 1]).any())


def _hull(cells: NDArray[np.float64]) -> Bounds:
    lo, hi = cells[:, 0:6:2].min(axis=0), cells[:, 1:6:2].max(axis=0)
    return np.ascontiguousarray(np.stack([lo, hi], axis=1))


def _touch(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    return bool((a[0:6:2] <= b[1:6:2]).all() and (b[0:6:2] <= a[1:6:2]).all())


def _clusters(cells: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Return cells that touch each other together."""
    left = list(range(len(cells)))
    found = []
    while left:
        group, front = [left[0]], [left.pop(0)]
        while front:
            here = cells[front.pop()]
            near = [i for i in left if _touch(cells[i], here)]
            left = [i for i in left if i not in set(near)]
            group += near
            front += near
        found.append(cells[group])
    return found


def fields_at(mass: RoutedMass, data: Routed, taut: NDArray[np.int64], box: Bounds) -> Fields | None:
    """Return the fields of a proved zero (3 + m, 2); None where cables may not do as they should."""
    count = len(mass.elastic)
    states = np.empty(count, dtype=np.int64)
    tension, distance = np.empty((count, 2)), np.empty((count, 2))
    if not classify(data, taut, len(taut), box, states, tension, distance):
        return None
    return _filled(mass, box, tension, distance, states)


def _filled(mass: RoutedMass, box: Bounds, tension: Bounds, distance: Bounds, states: States) -> Fields:
    bounds = np.empty((4 + 2 * len(states), 2))
    fill(mass.frame, box, tension, distance, bounds)
    return noted(unpacked(bounds, states), mass)


def noted(fields: Fields, mass: RoutedMass) -> Fields:
    """Return fields that say which cables are neither taut nor slack for sure."""
    open_ones = np.flatnonzero(fields.states == OPEN).tolist()
    if not open_ones:
        return fields
    names = mass.robot.cable_names
    if mass.elastic[open_ones].all():
        those = ", ".join(names[i] for i in open_ones) + (" is" if len(open_ones) == 1 else " are")
        return replace(fields, note=OPEN_STATE.format(those))
    tight = np.flatnonzero(fields.states != SLACK).tolist()
    return replace(fields, note=TIGHT.format("{" + ", ".join(names[i] for i in tight) + "}"))


def data_for(mass: RoutedMass, lengths: Bounds) -> Routed:
    """Return what the kernels know for lengths (N, 2) in m."""
    found: Routed = data_of(
        mass.routes, mass.elastic, mass.constant, mass.given, mass.load, mass.unit, lengths
    )
    return found


def find_poses(
    mass: RoutedMass, lengths: Bounds, budget: Budget, threads: int = 1, report: Report | None = None
) -> Found:
    """Find every static pose of a robot for all lengths (N, 2) in m.

    Guarantee --------- For every choice of data in their ranges there is exactly one static pose in each of
    ``poses``, their fields enclose it, and every further one lies in a region or in what is pending.
    """
    status, bounds, states = quick_pose(mass, lengths)
    if status == DECIDED:
        return Found((noted(unpacked(bounds, states), mass),), (Stability.STABLE,))
    data = data_for(mass, lengths)
    first, outward, taut, known = _first(mass, data, status == AMONG_OTHERS)
    hunt = _Hunt(mass, data, budget, threads, report)
    hunt.run(outward, taut, known)
    poses = ([first] if first is not None else []) + hunt.poses
    stability = ([Stability.STABLE if outward else Stability.UNDECIDED] if first is not None else []) + (
        hunt.stability
    )
    regions = tuple(Unproved(NEAR, _in_metres(mass, region)) for region in hunt.regions)
    return Found(tuple(poses), tuple(stability), regions, hunt.pending, hunt.cells, hunt.stop, False)


def _first(mass: RoutedMass, data: Routed, proved: bool) -> tuple[Fields | None, bool, States, Bounds]:
    """Return the pose by guess and proof, whether it is outward, its taut cables and domain of uniqueness."""
    count = len(mass.elastic)
    none = np.empty(0, dtype=np.int64)
    nowhere = np.column_stack([np.full(3, np.inf), np.full(3, -np.inf)])
    taut, x = np.empty(count + 1, dtype=np.int64), np.empty(4 + count)
    m = guess(data, taut, x)
    if m < 0:
        return None, False, none, nowhere
    if proved:
        box, domain = np.empty((3 + m, 2)), np.empty((3 + m, 2))
        if prove_balance(data, taut, x[: 3 + m].copy(), anywhere(3 + m), box, domain):
            fields = fields_at(mass, data, taut[:m], box)
            widest = _widened(data, taut, x[: 3 + m], domain)
            return fields, bool(is_outward(data, box)), taut[:m].copy(), widest
    box, multiplier = np.empty((3, 2)), np.zeros(count)
    multiplier[taut[:m]] = np.maximum(x[3 : 3 + m], 0.0)
    if not prove_tied(data, x[:3].copy(), multiplier, box):
        return None, False, none, nowhere
    states, tension, distance = np.empty(count, dtype=np.int64), np.empty((count, 2)), np.empty((count, 2))
    if not tied_tensions(data, box, states, tension, distance):
        return None, False, none, nowhere
    return _filled(mass, box, tension, distance, states), True, none, nowhere


def _widened(data: Routed, taut: States, x: NDArray[np.float64], domain: Bounds) -> Bounds:
    """Return the widest of a few domains around a zero in which it is proved to be the only one."""
    box, wide = np.empty(domain.shape), np.empty(domain.shape)
    for radius in WIDTHS:
        cover = np.stack([x - radius, x + radius], axis=1)
        if prove_balance(data, taut, x.copy(), cover, box, wide):
            return wide
    return domain


def _in_metres(mass: RoutedMass, box: Bounds) -> Bounds:
    """Return positions in the kernels' units as ones of the platform's origin in the base frame, outward."""
    inside = box * mass.unit
    lo = np.nextafter(inside[:, 0] + mass.frame[2:5, 0], -np.inf)
    hi = np.nextafter(inside[:, 1] + mass.frame[2:5, 1], np.inf)
    return np.stack([lo, hi], axis=1)
