"""The search of one subset of taut cables that run over pulleys or stretch: boxes of (u, p), and roots."""

from __future__ import annotations

import math
from collections.abc import Container, Sequence
from typing import Any

from flint import arb, arb_mat, fmpq

from certificates.arithmetic.balls import Vector, hull, norm, unit
from certificates.arithmetic.vectors import minus
from certificates.frames import UNIT, Setting
from certificates.problem import Problem
from certificates.routed.ropes import Posed, Ropes
from certificates.routed.system import RoutedSystem
from certificates.routed.views import Lengths, Pulls, Shells
from certificates.search import Search
from certificates.tree import Cell
from certificates.verdicts import NotProved

MOST_TAUT = 6
"""More wrenches are never independent: no bound of their tensions follows from the balance."""
WRAPPED = 7
"""Radii by which a rope may be longer than the way from its exit point: less than 7 / 4 pi of them lie on
the pulley, and where it leaves is within 1 of them of the centre."""


class RoutedSearch(Search):
    """One subset's trees and roots; x stands for p, the centre of mass, in the robot's frame."""

    def __init__(self, problem: Problem, taut: tuple[int, ...], entry: Any, solutions: int) -> None:
        if len(taut) > MOST_TAUT:
            raise NotProved(f"more than {MOST_TAUT} taut cables over pulleys or elastic are not searched")
        frame = arb_mat(3, 3, [x for row in UNIT for x in row])
        super().__init__(problem, Setting(taut, frame, frame, False, False, False), entry, solutions)

    @property
    def views(self) -> Sequence[type[Posed]]:
        """Sets of equations and wrenches by which cells are looked at, one after the other."""
        return (Shells, Lengths, Pulls) if self.problem.is_elastic else (Shells, Lengths)

    def built(self) -> Ropes:
        """Return the platform in balls."""
        problem, taut = self.problem, len(self.order)
        everyone = [*self.order, *(i for i in range(len(problem.names)) if i not in self.order)]
        pulleys = [problem.pulleys[i] if problem.pulleys else None for i in everyone]
        before = [fmpq(0) if p is None else p.before for p in pulleys]
        radii = [fmpq(0) if p is None else p.radius for p in pulleys]
        straight = [problem.lengths[i][0] - b for i, b in zip(everyone, before, strict=True)]
        lows = [max(fmpq(0), n - WRAPPED * r) for n, r in zip(straight, radii, strict=True)]
        highs = self.farthest(straight[:taut], radii[:taut])
        self.positions = self.reached(highs)
        return Ropes(
            exits=[[arb(x) for x in problem.exits[i]] for i in everyone],
            points=[[arb(x) for x in problem.points[i]] for i in everyone],
            lengths=[arb(problem.lengths[i][0]) for i in everyone],
            axes=[[] if p is None else unit(p.axis) for p in pulleys],
            radii=[arb(r) for r in radii],
            before=[arb(b) for b in before],
            stiffnesses=[arb(problem.spring(i)) for i in everyone if problem.is_elastic],
            shells=[hull(lo * lo, (hi * hi).upper()) for lo, hi in zip(lows, highs, strict=False)],
            load=[arb(x) for x in problem.load],
            per_unit=1
            / arb(max(sum(map(abs, problem.points[i]), fmpq(0)) for i in range(len(problem.names)))),
            half_turn=arb.pi(),
            taut=taut,
        )

    def farthest(self, straight: Sequence[fmpq], radii: Sequence[fmpq]) -> Vector:
        """Return how far the anchors of the taut cables are from their exit points at most.

        Of a cable that stretches: with c the first exit point and Q at least as large as |A - c| + 2 r + |b|
        of all, every rope pulls towards c by a third of its tension at least where |p - c| >= 2 Q. The load
        balances all of them, so that no tension is more than 3 |f|. Elsewhere no anchor is farther than 3 Q.
        """
        problem = self.problem
        if not problem.is_elastic:
            return [arb(n) for n in straight]
        exits, points = [problem.exits[i] for i in self.order], [problem.points[i] for i in self.order]
        sizes = [
            norm(minus(a, exits[0])) + 2 * r + norm(b) for a, r, b in zip(exits, radii, points, strict=True)
        ]
        size, load = max(s.upper() for s in sizes), norm(problem.load)
        stretched = [n + 3 * load / problem.spring(i) for n, i in zip(straight, self.order, strict=True)]
        return [max(n.upper(), 3 * size) for n in stretched]

    def reached(self, highs: Vector) -> list[tuple[float, float]]:
        """Return bounds of p: no anchor is farther from its exit point than ``highs``."""
        bounds = []
        for k in range(3):
            lows, tops = [], []
            for i, far in zip(self.order, highs, strict=True):
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
