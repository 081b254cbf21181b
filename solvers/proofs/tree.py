"""The search trees and roots of one taut subset: cells are split until the checker can confirm each.

Compiled kernels say which cells of u hold no equilibrium and why; their reasons are those of the format.
Cells in (u, x) are tried with the checker's own tests. Nothing here needs to be trusted: what is written is
checked.
"""

from __future__ import annotations

import base64
import math
import struct
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.rows import BOTH, NO_LENGTH, NO_POSITION, NOT_SLACK, OPEN, UNBALANCED, UNSMOOTH
from cdpr_interval.mechanics.rotation import rotation_at
from certificates.arithmetic import guess
from certificates.arithmetic.forms import box_forms, value
from certificates.balance import unbalanced
from certificates.cells import Place
from certificates.frames import Setting
from certificates.geometry import Turned
from certificates.leaves import confirmed, longest
from certificates.problem import Listed
from certificates.problem import Problem as Question
from certificates.root_claims import check_root
from certificates.roots import System
from certificates.search import Root as Claimed
from certificates.search import Search
from certificates.tree import Cell, Leaf, Node
from certificates.verdicts import NotProved
from solvers.six_dof.cell_kinds import ROTATION_CELLS
from solvers.six_dof.reasons import look_turn
from solvers.six_dof.reduction import Reduced
from solvers.six_dof.roots import Root
from solvers.six_dof.rotation_cells import FOLD_WIDTH

Floats = NDArray[np.float64]

REASONS = {NO_POSITION: Node.NO_POSITION, NO_LENGTH: Node.NO_LENGTH, UNBALANCED: Node.UNBALANCED}
LARGEST_Y = 2**31 - 1
"""The largest of 32 bits."""
DOUBTFUL = 2.0**-9
"""Narrower leaves, near poses and folds, are tried with the checker's test before they are written."""
SMALLEST = 1e-7
"""Width of u at which a cell is written as undecided."""
MOST_UNDECIDED = 2_000
"""Undecided cells of a chart after which no more is tried: they surround what the checker has no rule for."""
USEFUL_CUT = 0.7
"""A cut is written when some entry keeps at most this share of its width."""
WIDER = 1e-9
"""A kept interval is widened by this share of its width, so that the checker confirms it."""
ROUNDING = 2.0**-50
"""And by this share of itself: a bound is rounded to a double."""
UNKNOWN = base64.b64encode(bytes([Node.UNDECIDED])).decode("ascii")
"""A tree of one leaf."""
GROWTH = (8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125)
"""Sizes of a root's box in (u, x) that are tried, over the solver's smallest half width in u."""


class Recorder:
    """Writes one search of one subset."""

    def __init__(self, question: Question, setting: Setting, reduced: Reduced, listed: list[Listed]) -> None:
        # The format has no leaf for poses that belong to a smaller subset.
        self.model, self.setting, self.listed = reduced.model._replace(hanging=False), setting, listed
        order = [setting.taut[k] for k in reduced.model.orders[0]]
        charts = [None if setting.frozen(chart) is None else UNKNOWN for chart in range(4)]
        self.search = Search(question, setting, {"order": order, "roots": [], "trees": charts}, len(listed))
        self.y, self.place = np.zeros(6), np.zeros((3, 2))
        self.unit = 1.0 / float(self.search.platform.per_unit)

    def entry(self, whole: bool) -> dict[str, Any]:
        """Return the search as the document has it; where it was not ended its trees are pending."""
        trees: list[str | None] = []
        for chart in range(4):
            frozen = self.setting.frozen(chart)
            if frozen is None:
                trees.append(None)
                continue
            start = Cell(chart, tuple((0.0, 0.0) if k in frozen else (-1.0, 1.0) for k in range(3)))
            nodes = self.nodes(start) if whole else [leaf(Node.PENDING)]
            trees.append(base64.b64encode(b"".join(nodes)).decode("ascii"))
        return {
            "order": list(self.search.order),
            "roots": [root_entry(r) for r in self.search.roots],
            "trees": trees,
        }

    def add(self, root: Root, candidates: Sequence[int]) -> None:
        """Add a root with the first claim about it that the checker confirms, if any."""
        box = self.box(root)
        if box is None:
            return
        for claim in [Claimed(root.chart, box, k) for k in (*candidates, None)]:
            try:
                check_root(self.search, claim, self.listed)
            except NotProved:
                continue
            self.search.roots.append(claim)
            return

    def box(self, root: Root) -> list[tuple[float, float]] | None:
        """Return the largest box tried in which the checker finds one zero at most, or None."""
        z = root.core.mean(axis=1)
        turned = np.empty((3, 3))
        rotation_at(z[:3].copy(), turned)
        pivot = self.model.orders[0, 0]
        x = z[3:6] - self.model.anchors[pivot] + turned @ self.model.points[root.chart, pivot]
        flat = self.search.flat(root.chart)
        assert flat is not None
        widths = [hi - lo for lo, hi in root.unique[:3].tolist() if hi > lo]
        system = System(self.setting, self.search.platform, root.chart)
        for grown in GROWTH:
            half = grown * 0.5 * min(widths)
            reach = [half] * 3 + [half * self.model.size] * 3
            box = [
                (0.0, 0.0) if k in flat else (m - r, m + r)
                for k, (m, r) in enumerate(zip([*z[:3].tolist(), *x.tolist()], reach, strict=True))
            ]
            if system.has_one_zero_at_most(box_forms(box)):
                return box
        return None

    def nodes(self, start: Cell) -> Iterable[bytes]:
        """Yield the nodes of a chart's tree; where too much stays undecided the rest is pending."""
        waiting, undecided = [start], 0
        while waiting and undecided < MOST_UNDECIDED:
            cell = waiting.pop()
            node, below = self.placed(cell) if cell.placed else self.turned(cell)
            undecided += node == leaf(Node.UNDECIDED)
            yield node
            waiting += reversed(below)
        yield from [leaf(Node.PENDING)] * len(waiting)

    def turned(self, cell: Cell) -> tuple[bytes, Sequence[Cell]]:
        """Return a cell of u's node, and the cells below."""
        row = np.array([*np.ravel(cell.bounds), cell.chart, cell.side, 0.0])
        state = look_turn(ROTATION_CELLS.scratch(), self.model, row, self.y, self.place)
        widest = max(hi - lo for lo, hi in cell.bounds)
        if state == NOT_SLACK:
            cable = self.too_long(cell)
            return self.split(cell) if cable is None else (leaf(Node.TOO_LONG, [cable]), ())
        if state in REASONS:
            found = Leaf(cell, REASONS[state], tuple(self.written_y()))
            if widest >= DOUBTFUL or confirmed(self.search, found, cell):
                return leaf(found.node, found.data), ()
            return self.split(cell)
        if state == BOTH:
            return bytes([Node.SIDES]), [Cell(cell.chart, cell.bounds, side) for side in (1, -1)]
        if self.setting.planar:
            self.place[1] = 0.0
        place = [(lo, hi) for lo, hi in self.place.tolist()]
        if state == OPEN and self.is_settled(cell.chart, [*cell.bounds, *place]):
            return leaf(Node.ROOT), ()
        if state == UNSMOOTH and widest <= FOLD_WIDTH:
            most = self.search.reach
            x = [(0.0, 0.0) if k == 1 and self.setting.planar else (-most, most) for k in range(3)]
            return bytes([Node.HAND_ON]), [Cell(cell.chart, (*cell.bounds, *x))]
        return self.split(cell)

    def split(self, cell: Cell) -> tuple[bytes, Sequence[Cell]]:
        """Return the node that halves a cell, or gives it up where it is too small for that."""
        k = longest(self.search, cell)
        lo, hi = cell.bounds[k]
        if hi - lo < SMALLEST * (1.0 if k < 3 else self.unit):
            return leaf(Node.UNDECIDED), ()
        return bytes([k]), cell.halves(k)

    def too_long(self, cell: Cell) -> int | None:
        """Return a cable of which the checker confirms that it is too long over a cell of u; None: no one."""
        others = range(self.search.platform.taut, len(self.search.platform.exits))
        for cable in map(self.cable_at, others):
            if confirmed(self.search, Leaf(cell, Node.TOO_LONG, (cable,)), cell):
                return cable
        return None

    def is_settled(self, chart: int, bounds: Sequence[tuple[float, float]]) -> bool:
        """Return True where a box of (u, x) lies in a root's box."""
        return any(root.holds(chart, bounds) for root in self.search.roots)

    def written_y(self) -> list[int]:
        """Return the direction tried last in 32 bits, its moments divided by the format's length."""
        y = self.y * np.array([1.0] * 3 + [self.unit / self.model.size] * 3)
        most = float(np.abs(y).max())
        return [round(LARGEST_Y * v / most) if most > 0.0 and math.isfinite(most) else 0 for v in y.tolist()]

    def placed(self, cell: Cell) -> tuple[bytes, Sequence[Cell]]:
        """Return a cell of (u, x)'s node, and the cells below."""
        if self.is_settled(cell.chart, cell.bounds):
            return leaf(Node.ROOT), ()
        platform, entries = self.search.platform, box_forms(cell.bounds)
        turned, x = Turned(self.search.forms, cell.chart, entries[:3]), entries[3:]
        place = Place(turned, x, False)
        if place.no_length():
            return leaf(Node.NO_LENGTH), ()
        cut = self.cut(cell, place)
        if cut is not None:
            return cut
        for j in range(platform.taut, len(platform.exits)):
            cable = self.cable_at(j)
            if self.search.may_be_slack(cable) and place.positive(turned.excess(j, x)):
                return leaf(Node.TOO_LONG, [cable]), ()
        if not self.search.problem.ignore_tension_sign:
            y = likely_direction(turned, x)
            if y is not None and unbalanced(place, y):
                return leaf(Node.UNBALANCED, y), ()
        return self.split(cell)

    def cable_at(self, j: int) -> int:
        """Return the cable at a place of the platform's list."""
        return [
            *self.search.order,
            *(i for i in range(len(self.search.problem.names)) if i not in self.search.order),
        ][j]

    def cut(self, cell: Cell, place: Place) -> tuple[bytes, Sequence[Cell]] | None:
        """Return the node that cuts a cell to where the lengths can hold, where that helps."""
        kept, written, useful = cell, [], 0
        for k, (lo, hi) in enumerate(cell.bounds):
            found = place.kept(k, lo, hi) if lo < hi else None
            if found is None:
                continue
            slack = WIDER * (hi - lo) + ROUNDING * max(abs(lo), abs(hi))
            new = (max(lo, clipped(found[0]) - slack), min(hi, clipped(found[1]) + slack))
            if not new[0] < new[1]:
                continue
            if new[1] - new[0] <= USEFUL_CUT * (hi - lo):
                useful |= 1 << k
                kept = kept.with_bounds(k, *new)
                written.append(struct.pack("<dd", *new))
        return (bytes([Node.CUT, useful]) + b"".join(written), [kept]) if useful else None


def clipped(x: Fraction) -> float:
    """Return a double near an exact number, clipped."""
    return max(-1e300, min(1e300, float(x)))


def likely_direction(turned: Turned, x: Any) -> list[int] | None:
    """Return y in 32 bits with equal positive products with all wrenches, of length 1, at a cell's centre."""
    rows = [[value(v) for v in w] for w in turned.wrenches(x)]
    lengths = [math.sqrt(guess.inner(row, row)) or 1.0 for row in rows]
    unit = [[v / length for v in row] for row, length in zip(rows, lengths, strict=True)]
    found = guess.direction(unit, [1.0] * len(unit))
    if found is None:
        return None
    most = max(map(abs, found[0]))
    return [round(LARGEST_Y * v / most) for v in found[0]] if 0.0 < most < math.inf else None


def leaf(node: Node, data: Sequence[int] = ()) -> bytes:
    """Return a leaf's bytes."""
    if node is Node.TOO_LONG:
        return bytes([node, *data])
    return bytes([node]) + (struct.pack("<6i", *data) if node is Node.UNBALANCED else b"")


def root_entry(root: Claimed) -> dict[str, Any]:
    """Return a root as the document has it."""
    box = [[lo.hex(), hi.hex()] for lo, hi in root.box]
    return {"chart": root.chart, "u": box[:3], "x": box[3:], "pose": root.pose}
