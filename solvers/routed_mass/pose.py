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
from solvers.answers.data import Family
from solvers.point_mass.cell_rows import WIDTH
from solvers.point_mass.convex import Unproved
from solvers.point_mass.entry import Fields, unpacked
from solvers.point_mass.fields import OPEN, SLACK, TAUT
from solvers.point_mass.one_call import DECIDED, anywhere
from solvers.routed_mass.balance import prove_balance
from solvers.routed_mass.cells import first_cells, run_cells
from solvers.routed_mass.circle import Circle, circle_of
from solvers.routed_mass.data import Routed, RoutedMass
from solvers.routed_mass.guess import guess
from solvers.routed_mass.one_call import (
    AMONG_OTHERS,
    SMALLEST,
    classify,
    data_of,
    fill,
    is_outward,
    others_outward,
    routed_pose,
    slack_around,
    strength,
    ways_at,
)
from solvers.routed_mass.tied import prove_tied, strict_minimum, tied_tensions

States = NDArray[np.int64]
FINER = 0.125
"""Widths of the smallest cells of a further search over those of the one before."""
FINEST = 1e-7
"""In the kernels' units: smaller cells are left undecided."""
WIDTHS = tuple(0.25 * 0.5**i for i in range(20))
"""In the kernels' units: radii of domains of uniqueness that are tried."""
MOST_CELLS = 100_000
"""Of the searches for one question, unless it sets a limit: ten seconds."""
NEAR = "between cells that are not excluded a pose may lie: next to a pulley, or one too close to another"
TIGHT = "cables {} tight up to rounding, tensions may not be unique"
OPEN_STATE = "whether {} taut is not decided"


Families = tuple[Family | None, ...]


@dataclass(frozen=True)
class Effort:
    """What a search may spend, and whom it tells."""

    budget: Budget
    threads: int = 1
    report: Report | None = None
    own_limit: bool = False
    """The budget's cells are no limit of the question's: what is left over is undecided."""

    @staticmethod
    def of(time_limit: float | None, cell_limit: int | None) -> Effort:
        """Return the effort for a question with these limits, or without."""
        return Effort(Budget(time_limit, cell_limit or MOST_CELLS), own_limit=cell_limit is None)


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
    families: Families = ()
    """Of each pose; shorter than these where none has one."""

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


@dataclass(frozen=True, eq=False)
class _Zero:
    """A zero of the equations as far as positions tell, in the kernels' units."""

    box: Bounds
    """(3, 2)"""
    domain: Bounds
    """(3, 2), in which it is the only one."""

    def is_same(self, other: _Zero) -> bool:
        """Return True when both are proved to be one."""
        return _contains(self.domain, other.box) or _contains(other.domain, self.box)


@dataclass
class _Hunt:
    """The search for poses in what no proof covers."""

    mass: RoutedMass
    data: Routed
    budget: Budget
    threads: int
    report: Report | None
    own_limit: bool = False
    """The limit of cells is this room's, not the question's."""
    cells: int = 0
    pending: int = 0
    rest: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, WIDTH)))
    """The cells that are pending."""
    stop: Stop = Stop.EXHAUSTED
    poses: list[Fields] = field(default_factory=list)
    stability: list[Stability] = field(default_factory=list)
    regions: list[Bounds] = field(default_factory=list)
    zeros: list[_Zero] = field(default_factory=list)
    """Of the poses that are proved, the first one included."""

    def run(self, first: tuple[Any, ...]) -> None:
        """Look at everything that may hold a pose, finer and finer.

        ``first`` are the context's entries after the data, see `solvers.routed_mass.cells`.
        """
        stack = np.empty((max(64, len(self.mass.routes)), WIDTH))
        cells = stack[: first_cells(self.data, first[0], stack)]
        smallest = SMALLEST
        while len(cells):
            leaves = self._search(cells, first, smallest)
            if self.pending:
                self._give_up(np.concatenate([self.rest, leaves]))
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

    def _give_up(self, left: NDArray[np.float64]) -> None:
        """Keep the cells that are left as regions, unless the question has set the limit."""
        self.pending = len(left)
        if self.own_limit and self.stop is Stop.CELL_LIMIT:
            self.regions += [_hull(cluster) for cluster in _clusters(left) if not self._proved(cluster)]
            self.pending, self.stop = 0, Stop.EXHAUSTED

    def _search(self, cells: NDArray[np.float64], first: tuple[Any, ...], smallest: float) -> Bounds:
        context = (self.data, *first, smallest)

        def make_run() -> Run:
            return lambda stack, count, leaves, kinds, children, limit: run_cells(
                context, stack, count, leaves, kinds, children, limit
            )

        found = search(make_run, cells, self.budget, threads=self.threads, report=self.report)
        self.cells += found.cells
        self.rest = found.pending
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
        zero = _Zero(box, domain)
        if any(zero.is_same(other) for other in self.zeros):
            return True
        fields = fields_at(self.mass, self.data, taut[:0], box)
        if fields is None or not all(_apart(box, other.box) for other in self.zeros):
            return False
        self.zeros.append(zero)
        self.poses.append(fields)
        self.stability.append(stability_of(self.mass, self.data, fields))
        return True


def _apart(a: Bounds, b: Bounds) -> bool:
    return bool((a[:, 0] > b[:, 1]).any() or (b[:, 0] > a[:, 1]).any())


def _contains(outer: Bounds, inner: Bounds) -> bool:
    return bool((outer[:, 0] <= inner[:, 0]).all() and (inner[:, 1] <= outer[:, 1]).all())


def _hull(cells: NDArray[np.float64]) -> Bounds:
    lo, hi = cells[:, 0:6:2].min(axis=0), cells[:, 1:6:2].max(axis=0)
    return np.ascontiguousarray(np.stack([lo, hi], axis=1))


def _clusters(cells: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Return cells that touch each other together."""
    low, high = cells[:, 0:6:2], cells[:, 1:6:2]
    # In the order of their low sides along x, those that may touch one follow from a place on.
    order = np.argsort(low[:, 0], kind="stable")
    cells, low, high = cells[order], low[order], high[order]
    widest = float((high[:, 0] - low[:, 0]).max(initial=0.0)) * (1.0 + 1e-9) + 1e-300
    starts = np.searchsorted(low[:, 0], low[:, 0] - widest * 1.001, side="left")
    ends = np.searchsorted(low[:, 0], high[:, 0], side="right")
    left, found = np.ones(len(cells), dtype=np.bool_), []
    for start in range(len(cells)):
        if not left[start]:
            continue
        group, front = [start], [start]
        left[start] = False
        while front:
            here = front.pop()
            part = slice(int(starts[here]), int(ends[here]))
            touching = (low[part] <= high[here]).all(axis=1) & (low[here] <= high[part]).all(axis=1)
            near = np.flatnonzero(left[part] & touching) + part.start
            left[near] = False
            group += near.tolist()
            front += near.tolist()
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


def find_poses(mass: RoutedMass, lengths: Bounds, effort: Effort) -> Found:
    """Find every static pose of a robot for all lengths (N, 2) in m.

    Guarantee
    ---------
    For every choice of data in their ranges there is exactly one static pose in each of ``poses`` (or one
    family), their fields enclose it, and every further one lies in a region or in what is pending.
    """
    status, bounds, states = quick_pose(mass, lengths)
    data = data_for(mass, lengths)
    if status == DECIDED:
        fields = noted(unpacked(bounds, states), mass)
        outward = hangs_outward(mass, data, fields)
        return Found((fields,), (stability_of(mass, data, fields),), by_convexity=outward)
    hunt = _Hunt(mass, data, effort.budget, effort.threads, effort.report, effort.own_limit)
    circle = _circle(mass, data) if status != AMONG_OTHERS else None
    if circle is not None:
        return _on_circle(hunt, circle)
    first = _first(mass, data, status == AMONG_OTHERS)
    if first.zero is not None:
        hunt.zeros.append(first.zero)
    hunt.run((first.outward, first.taut, first.known, -1))
    poses, stability = hunt.poses, hunt.stability
    if first.fields is not None:
        own = Stability.STABLE if first.outward else stability_of(mass, data, first.fields)
        poses, stability = [first.fields, *poses], [own, *stability]
    return _found(hunt, poses, stability)


def hangs_outward(mass: RoutedMass, data: Routed, fields: Fields) -> bool:
    """Return True when every cable is straight, leaves outward or hangs loose at a pose."""
    return bool(is_outward(data, _in_units(mass, fields.position)))


def stability_of(mass: RoutedMass, data: Routed, fields: Fields) -> Stability:
    """Return STABLE where a pose is proved to be a strict minimum of the energy."""
    stable = hangs_outward(mass, data, fields) or strict_minimum(
        data, _in_units(mass, fields.position), np.ascontiguousarray(fields.tensions / mass.frame[1, 0])
    )
    return Stability.STABLE if stable else Stability.UNDECIDED


def _in_units(mass: RoutedMass, position: Bounds) -> Bounds:
    """Return positions of the platform's origin in m, (3, 2), as anchors in the kernels' units, outward."""
    lo = np.nextafter(position[:, 0] - mass.frame[2:5, 1], -np.inf) / mass.unit
    hi = np.nextafter(position[:, 1] - mass.frame[2:5, 0], np.inf) / mass.unit
    return np.ascontiguousarray(np.stack([lo, hi], axis=1))


def _found(hunt: _Hunt, poses: list[Fields], stability: list[Stability], families: Families = ()) -> Found:
    regions = tuple(Unproved(NEAR, _in_metres(hunt.mass, region)) for region in hunt.regions)
    return Found(
        tuple(poses), tuple(stability), regions, hunt.pending, hunt.cells, hunt.stop, False, families
    )


def _circle(mass: RoutedMass, data: Routed) -> Circle | None:
    """Return the circle of poses on one cable where all others are slack."""
    if not mass.exact:
        return None
    distance = np.empty((len(mass.elastic), 2))
    for cable in range(len(mass.elastic)):
        circle = circle_of(mass, data, cable, mass.load_exact)
        if circle is not None and slack_around(data, circle.around, cable, distance):
            return circle
    return None


def _on_circle(hunt: _Hunt, circle: Circle) -> Found:
    """Return the family on a circle, and whatever else there is."""
    mass, data = hunt.mass, hunt.data
    count = len(mass.elastic)
    states, tension, distance = np.zeros(count, dtype=np.int64), np.zeros((count, 2)), np.empty((count, 2))
    # Where x is arm + radius, the tangent planes still are those of the rope itself.
    outward = bool(others_outward(data, circle.around, circle.cable))
    hunt.run((outward, _First().taut, _First().known, circle.cable))
    ways_at(data, circle.listed, distance)
    states[circle.cable] = TAUT
    tension[circle.cable] = strength(data)
    fields = _filled(mass, circle.listed, tension, distance, states)
    return _found(hunt, [fields, *hunt.poses], [Stability.STABLE, *hunt.stability], (circle.family,))


@dataclass(frozen=True, eq=False)
class _First:
    """The pose by guess and proof."""

    fields: Fields | None = None
    """None where there is none."""
    outward: bool = False
    taut: States = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    known: Bounds = field(default_factory=lambda: np.column_stack([np.full(3, np.inf), np.full(3, -np.inf)]))
    """Of position and tensions of the taut cables: where no other zero is."""
    zero: _Zero | None = None


def _first(mass: RoutedMass, data: Routed, proved: bool) -> _First:
    """Return the pose by guess and proof; ``proved``: that of the compiled call."""
    count = len(mass.elastic)
    taut, x = np.empty(count + 1, dtype=np.int64), np.empty(4 + count)
    m = guess(data, taut, x)
    if m < 0:
        return _First()
    if proved:
        box, domain = np.empty((3 + m, 2)), np.empty((3 + m, 2))
        if prove_balance(data, taut, x[: 3 + m].copy(), anywhere(3 + m), box, domain):
            fields = fields_at(mass, data, taut[:m], box)
            if fields is None:
                return _First()
            widest = _widened(data, taut, x[: 3 + m], box, domain)
            zero = _Zero(box[:3], widest[:3])
            return _First(fields, bool(is_outward(data, box)), taut[:m].copy(), widest, zero)
    box, multiplier = np.empty((3, 2)), np.zeros(count)
    multiplier[taut[:m]] = np.maximum(x[3 : 3 + m], 0.0)
    if not prove_tied(data, x[:3].copy(), multiplier, box):
        return _First()
    states, tension, distance = np.empty(count, dtype=np.int64), np.empty((count, 2)), np.empty((count, 2))
    if not tied_tensions(data, box, states, tension, distance):
        return _First()
    fields = _filled(mass, box, tension, distance, states)
    # Wherever all ropes leave outward there is no other pose.
    return _First(fields, True, zero=_Zero(box, box))


def _widened(data: Routed, taut: States, x: NDArray[np.float64], zero: Bounds, domain: Bounds) -> Bounds:
    """Return the widest of a few domains around a zero, a box, in which it is proved to be the only one."""
    box, wide = np.empty(domain.shape), np.empty(domain.shape)
    for radius in WIDTHS:
        cover = np.stack([x - radius, x + radius], axis=1)
        if prove_balance(data, taut, x.copy(), cover, box, wide) and _contains(wide, zero):
            return wide
    return domain


def _in_metres(mass: RoutedMass, box: Bounds) -> Bounds:
    """Return positions in the kernels' units as ones of the platform's origin in the base frame, outward."""
    inside = box * mass.unit
    lo = np.nextafter(inside[:, 0] + mass.frame[2:5, 0], -np.inf)
    hi = np.nextafter(inside[:, 1] + mass.frame[2:5, 1], np.inf)
    return np.stack([lo, hi], axis=1)
