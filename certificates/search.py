"""The search of one subset of taut cables in one frame: trees of cells, and roots."""

from __future__ import annotations

import base64
import binascii
import math
from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb, arb_mat, ctx, fmpq

from certificates.arithmetic.balls import BITS, column, hull, norm, unit
from certificates.arithmetic.forms import Array, Form, Vector
from certificates.arithmetic.rotations import HALF_TURNS
from certificates.frames import UNIT, Setting
from certificates.geometry import Platform, Rotated
from certificates.literals import bounds_of, entry_of, index_of, list_of
from certificates.problem import Problem
from certificates.roots import RoutedSystem, System
from certificates.routed.ropes import Ropes
from certificates.routed.views import Lengths, Shells
from certificates.tree import Cell, Leaf, decode
from certificates.verdicts import Malformed, NotProved

MOST_ROOTS = 1000
"""Of one search."""
SHORTEST, LONGEST = 1e-6, 1e9
"""Lengths in m between which both arithmetics have digits enough."""
WRAPPED = 7
"""Radii by which a rope may be longer than the straight way to its anchor: at most 7 / 4 pi of them lie on
the pulley, and what is free is at most 1 of them longer, as the centre is 1 from the exit point; or the rope
goes round further, and ends beside the exit point after at most 2 pi."""
Bounds = list[tuple[float, float]]


@dataclass(frozen=True)
class Root:
    """A box of (u, x) in one chart, and the solution whose pose it holds."""

    chart: int
    box: Bounds
    pose: int | None

    def holds(self, chart: Array, u: Array, x: Vector) -> Array:
        """Return in which cells (charts, N) bounds (3, 2, N) of u and the numbers x lie in the box.

        An entry of x without width is 0 at all positions of a plane: nothing need be shown of it.
        """
        rotated = [(lo <= a) & (b <= hi) for (a, b), (lo, hi) in zip(u, self.box[:3], strict=True)]
        placed = [v.within(lo, hi) for v, (lo, hi) in zip(x, self.box[3:], strict=True) if lo < hi]
        return (self.chart == chart) & np.all(np.broadcast_arrays(*rotated, *placed), axis=0)


class Search:
    """One frame's trees and roots."""

    def __init__(self, problem: Problem, setting: Setting, entry: Any, solutions: int) -> None:
        self.problem, self.setting = problem, setting
        found = entry_of(entry, "search", ("order", "roots", "trees"))
        n = len(setting.taut)
        self.order = tuple(
            index_of(v, len(problem.names), "order") for v in list_of(found["order"], "order", n)
        )
        if sorted(self.order) != list(setting.taut):
            raise Malformed("order: not the taut cables")
        roots = list_of(found["roots"], "roots")
        if len(roots) > MOST_ROOTS:
            raise Malformed(f"more than {MOST_ROOTS} roots in a search")
        self.roots = [self.read_root(v, solutions) for v in roots]
        with ctx.workprec(BITS):
            self.platform = self.built()
        self.mapped: dict[type[Form], Platform] = {}
        self.trees = list_of(found["trees"], "trees", 4)
        if not SHORTEST < self.reach < LONGEST:
            raise NotProved(f"cells of lengths like {self.reach:g} m are not checked")

    @property
    def views(self) -> Sequence[Any]:
        """Sets of equations and wrenches by which cells in (u, x) are looked at, one after the other."""
        return (Rotated,)

    def built(self) -> Any:
        """Return the platform in balls."""
        return self.setting.cables(self.problem, self.order)

    def start(self, chart: int, frozen: Container[int]) -> Cell:
        """Return the cell of all poses of a chart."""
        return Cell(chart, tuple((0.0, 0.0) if k in frozen else (-1.0, 1.0) for k in range(3)))

    def read_root(self, entry: Any, solutions: int) -> Root:
        """Return a root as it is written. Older files have "end": null in it."""
        former = ("end",) if isinstance(entry, dict) and "end" in entry else ()
        found = entry_of(entry, "root", ("chart", "u", "x", "pose", *former))
        if found.get("end") is not None:
            raise Malformed("root: end must be null")
        box = [bounds_of(v, "root") for key in ("u", "x") for v in list_of(found[key], key, 3)]
        pose = None if found["pose"] is None else index_of(found["pose"], solutions, "pose")
        root = Root(index_of(found["chart"], 4, "chart"), box, pose)
        flat = self.flat(root.chart)
        points = [k for k, (lo, hi) in enumerate(box) if lo == hi]
        if flat is None or points != sorted(flat) or any(box[k] != (0.0, 0.0) for k in points):
            raise Malformed("root: its box does not fit its chart, or has no width")
        return root

    def flat(self, chart: int) -> tuple[int, ...] | None:
        """Return the entries of (u, x) that are 0 at every pose, or None where the chart is not needed."""
        frozen = self.setting.frozen(chart)
        return None if frozen is None else (*frozen, *((4,) if self.setting.planar else ()))

    def leaves(self) -> Iterator[Leaf]:
        """Yield the leaves of all charts as they are read: a tree takes little more memory than its text."""
        for chart, text in enumerate(self.trees):
            frozen = self.setting.frozen(chart)
            if frozen is None:
                if text is not None:
                    raise Malformed("trees: a tree of a chart that is not needed")
                continue
            try:
                content = base64.b64decode(text, validate=True)
            except (TypeError, ValueError, binascii.Error):
                raise Malformed("trees: not base64") from None
            yield from decode(content, self.start(chart, frozen), self.reach, self.setting.planar)

    @cached_property
    def reach(self) -> float:
        """The smallest double that is not below the first cable's length."""
        longest = self.problem.lengths[self.order[0]][1]
        found = int(longest.p) / int(longest.q)
        while fmpq(*found.as_integer_ratio()) < longest:
            found = math.nextafter(found, math.inf)
        return found

    def over(self, kind: type[Form]) -> Platform:
        """Return the platform in forms, of which each length that has a range moves one symbol."""
        if kind not in self.mapped:
            with ctx.workprec(BITS):
                found = self.platform.mapped(kind.enclosing)
                ranged = [(k, w) for k, w in enumerate(self.platform.swings) if w != 0]
                sizes = {k: kind.enclosing(w).size() for k, w in ranged}
                self.mapped[kind] = found.ranging({k: kind.datum(size, k) for k, size in sizes.items()})
        return self.mapped[kind]

    def system(self, chart: Any) -> System:
        """Return the equations in a chart, or in one of each cell."""
        return System(self.setting, self.platform, self.over, chart)

    def coordinates(self, chart: int, rotation: arb_mat, centre: arb_mat) -> list[arb] | None:
        """Return (u, x) of a pose in a chart, or None where the chart may not reach it."""
        base = self.setting.base
        r = base * rotation * self.setting.platform.transpose() * half_turn(chart)
        trace = 1 + r[0, 0] + r[1, 1] + r[2, 2]
        if not trace > 0:
            return None
        u = [(r[2, 1] - r[1, 2]) / trace, (r[0, 2] - r[2, 0]) / trace, (r[1, 0] - r[0, 1]) / trace]
        return [*u, *(base * self.way(rotation, centre)).entries()]

    def way(self, rotation: arb_mat, centre: arb_mat) -> arb_mat:
        """Return x in the robot's frame."""
        first = self.order[0]
        return centre + rotation * column(self.problem.points[first]) - column(self.problem.exits[first])

    def lies_in(self, values: list[arb], root: Root) -> bool:
        """Return True when a pose (u, x) of this search is proved to lie in a root's box.

        The entries that the symmetry fixes are exactly 0 at such a pose: nothing need be shown of them.
        """
        flat = self.flat(root.chart)
        assert flat is not None
        free = [k for k in range(6) if k not in flat]
        within = all_within([values[k] for k in free], [root.box[k] for k in free])
        return within and all(may_be_zero(values[k]) for k in flat)

    def may_be_slack(self, cable: int) -> bool:
        """Return True for a cable whose slackness is asked for."""
        others = cable < len(self.problem.names) and cable not in self.order
        return others and not self.problem.ignore_slack and not self.setting.family

    def place_of(self, cable: int) -> int:
        """Return the place of a cable that is not taut in the platform's list."""
        return [*self.order, *(i for i in range(len(self.problem.names)) if i not in self.order)].index(cable)


def all_within(values: list[arb], box: Bounds) -> bool:
    """Return True when numbers are proved to lie within bounds."""
    return all(lo <= v and v <= hi for v, (lo, hi) in zip(values, box, strict=True))


def may_be_zero(value: arb) -> bool:
    """Return True when a number is not proved to be another one than 0. This proves nothing by itself.

    A pose of a plane or family has such entries exactly in one of the mirrored frames, and is far off in
    the other.
    """
    return bool(value.contains(arb(0)))


def half_turn(chart: int) -> arb_mat:
    """Return D_c."""
    return arb_mat([[HALF_TURNS[chart][i] if i == j else 0 for j in range(3)] for i in range(3)])


class RoutedSearch(Search):
    """One subset's trees and roots; x stands for p, the centre of mass, in the robot's frame."""

    def __init__(self, problem: Problem, taut: tuple[int, ...], entry: Any, solutions: int) -> None:
        frame = arb_mat(3, 3, [x for row in UNIT for x in row])
        super().__init__(problem, Setting(taut, frame, frame, False, False, False), entry, solutions)

    @property
    def views(self) -> Sequence[Any]:
        """Sets of equations and wrenches by which cells are looked at, one after the other."""
        return Shells, Lengths

    def built(self) -> Ropes:
        """Return the platform in balls."""
        problem, taut = self.problem, len(self.order)
        everyone = [*self.order, *(i for i in range(len(problem.names)) if i not in self.order)]
        pulleys = [problem.pulleys[i] if problem.pulleys else None for i in everyone]
        before = [fmpq(0) if p is None else p.before for p in pulleys]
        radii = [fmpq(0) if p is None else p.radius for p in pulleys]
        straight = [problem.lengths[i][0] - b for i, b in zip(everyone, before, strict=True)]
        lows = [max(fmpq(0), n - WRAPPED * r) for n, r in zip(straight, radii, strict=True)]
        self.positions = self.reached(straight[:taut])
        return Ropes(
            exits=[[arb(x) for x in problem.exits[i]] for i in everyone],
            points=[[arb(x) for x in problem.points[i]] for i in everyone],
            lengths=[arb(problem.lengths[i][0]) for i in everyone],
            axes=[[] if p is None else unit(p.axis) for p in pulleys],
            radii=[arb(r) for r in radii],
            before=[arb(b) for b in before],
            shells=[hull(lo * lo, hi * hi) for lo, hi in zip(lows, straight, strict=True)],
            load=[arb(x) for x in problem.load],
            per_unit=1 / arb(max(sum(map(abs, point), fmpq(0)) for point in problem.points)),
            half_turn=arb.pi(),
            taut=taut,
        )

    def reached(self, straight: Sequence[fmpq]) -> Bounds:
        """Return bounds of p: no anchor is farther from its exit point than its rope is long from there."""
        bounds = []
        for k in range(3):
            lows, tops = [], []
            for i, far in zip(self.order, straight, strict=True):
                middle, reach = self.problem.exits[i][k], far + norm(self.problem.points[i])
                lows.append(math.nextafter(float((middle - reach).lower()), -math.inf))
                tops.append(math.nextafter(float((middle + reach).upper()), math.inf))
            # Where nothing is left there is no pose, and any cell will do.
            bounds.append((max(lows), max(max(lows), min(tops))))
        return bounds

    def start(self, chart: int, frozen: Container[int]) -> Cell:
        """Return the cell of all poses of a chart."""
        return Cell(chart, (*[(-1.0, 1.0)] * 3, *self.positions))

    def system(self, chart: Any) -> RoutedSystem:
        """Return the equations in a chart, or in one of each cell."""
        return RoutedSystem(self.setting, self.platform, self.over, chart, self.problem.exits[self.order[0]])

    def way(self, rotation: arb_mat, centre: arb_mat) -> arb_mat:
        """Return p."""
        return centre
