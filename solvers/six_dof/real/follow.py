"""The pose of a platform on real cables, followed along lengths, also where cables become slack or taut.

A way is gone in legs (``real.leg``). The zeros of two legs that meet are one and the same: at the shared
place of the way the zero for one choice of the lengths, the core, lies in the domains of both, and as far as
one choice can be changed into another both zeros go on together. Where a cable switches a leg is proved as a
system with one row of complementarity (`cdpr_interval.mechanics.complementarity`): one pose for each choice,
the cable taut or slack.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from flint import arb_mat
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Budget
from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.cables.path import Balls, OffTheCable
from cdpr_interval.mechanics.complementarity import either_way, improved, slope
from cdpr_interval.mechanics.loaded import NO_FORCE
from cdpr_interval.mechanics.orientation import quaternion_from_rotation
from cdpr_interval.mechanics.rotation import chart_of, quaternion_of, u_in
from cdpr_interval.mechanics.six_dof.frame import Frame, Pose, centred_cayley, coordinates, half_turn
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import Point
from solvers.answers.data import Solution
from solvers.questions.problem import Problem
from solvers.six_dof.real.build import build, cables_of
from solvers.six_dof.real.leg import ENDS, HELD, LIFTS, SLACKENS, TIGHTENS, loads, prove
from solvers.six_dof.real.model import RealModel
from solvers.six_dof.real.system import existence_box, improve, new_bench, system

Floats = NDArray[np.float64]

ROUNDED = 4e-16
"""Covers the rounding of a few operations, relative."""
NEWTON_STEPS = 12
FINEST = 2.0**-14
"""Shortest leg that is tried, over the way."""
NEAR = 2.0**-10
"""Legs before a place where a cable may switch are this part of the way, or shorter where no leg through the
switch is proved from there."""
ACROSS = 4.0
"""First leg through a switch, over the last one that was too long before it."""
MARGINS = (0.5, 0.1, 0.01)
"""By which a leg's box with a switch is widened, over its widths, to one without a second pose."""
CHART_END = 1.2
"""Largest entry of u before another chart takes over."""


class Fault(NamedTuple):
    """Why a pose goes no further."""

    status: int
    """As in ``real.leg``; HELD where it was only stopped."""
    cable: int = -1
    """File order."""


@dataclass(frozen=True, eq=False)
class Leg:
    """A part of a way, and where the pose is on it, for all choices of the lengths."""

    first: float
    """Share of the way where it begins,"""
    last: float
    """and where it ends."""
    chart: int
    taut: tuple[int, ...]
    """Cables of the box; with ``open`` that one is last."""
    open: int
    """The cable that is taut or slack; -1: none."""
    box: Bounds
    """(6 + n, 2) of u, the centre of mass in m and t in N/m."""
    spans: Floats
    """(N, 4) m, those in the box first: bounds of free lengths and of lengths along the cables."""


@dataclass(frozen=True, eq=False)
class Known:
    """Where a pose is, and what is proved of which one it is."""

    chart: int
    taut: tuple[int, ...]
    """As of `Leg`."""
    open: int
    z: Floats
    """(6 + n,) in floats."""
    middle: Floats
    """(N,) one choice of the lengths,"""
    core: Bounds
    """(6 + n, 2) where the pose is for that choice,"""
    domain: Bounds
    """(6 + n, 2) and where it is the only one."""

    def among(self, taut: tuple[int, ...]) -> tuple[Floats, Bounds]:
        """Return z and core for other cables, those that are new with t = 0."""
        count = 6 + len(taut)
        z, core = np.zeros(count), np.zeros((count, 2))
        z[:6], core[:6] = self.z[:6], self.core[:6]
        for j, cable in enumerate(taut):
            if cable in self.taut:
                i = self.taut.index(cable)
                z[6 + j], core[6 + j] = self.z[6 + i], self.core[6 + i]
        return z, core


class Place(NamedTuple):
    """The lengths on a part of a way: ``middle`` + s ``way`` + r, -1/2 <= s <= 1/2, r up to ``room``."""

    middle: Floats
    """(N,) m, file order, as all of these."""
    way: Floats
    room: Floats

    @property
    def bounds(self) -> Bounds:
        """The hull (N, 2)."""
        half = (0.5 * np.abs(self.way) + self.room) * (1.0 + ROUNDED)
        return np.stack([_down(self.middle - half), _up(self.middle + half)], axis=1)


def place_on(before: Bounds, after: Bounds, first: float, last: float) -> Place:
    """Return the lengths on a part of the straight way from one to another."""
    ends = [after if share == 1.0 else before + share * (after - before) for share in (first, last)]
    middles = [0.5 * one[:, 0] + 0.5 * one[:, 1] for one in ends]
    widths = [0.5 * (one[:, 1] - one[:, 0]) for one in ends]
    slack = 4.0 * ROUNDED * (before[:, 1] + after[:, 1])
    middle = middles[1] if first == last else 0.5 * (middles[0] + middles[1])
    return Place(middle, middles[1] - middles[0], np.maximum(*widths) + slack)


class NotSmooth(Exception):
    """Some cable may lift off its pulley in a box, or come too near to it."""


class Corner:
    """The system of the taut cables in one chart, as ``complementarity`` asks for it."""

    def __init__(self, real: RealModel, chart: int) -> None:
        self._bench = new_bench(real, chart)

    def at(self, box: Floats) -> tuple[arb_mat, arb_mat]:
        """Return equations and derivatives over a box (6 + n, 2)."""
        m = len(box)
        f, J = np.empty((m, 2)), np.empty((m, m, 2))
        if not system(self._bench, np.ascontiguousarray(box), f, J, True):
            raise NotSmooth
        return balls.column(f), balls.matrix(J)


class Cables:
    """The cables of a robot under a force, some of them taut, others slack."""

    def __init__(self, robot: Robot, force: Point = NO_FORCE) -> None:
        self.count = len(robot.cables)
        problem = Problem(robot, ((Fraction(1), Fraction(1)),) * self.count, force)
        self.loaded = problem.loaded
        self._cables = cables_of(problem)
        self._models: dict[tuple[int, ...], RealModel] = {}

    def order(self, taut: tuple[int, ...]) -> tuple[int, ...]:
        """Return all cables, these in front."""
        return (*taut, *(i for i in range(self.count) if i not in taut))

    def model(self, taut: tuple[int, ...], lengths: Bounds) -> RealModel:
        """Return the arrays for lengths (N, 2), file order."""
        order = self.order(taut)
        found = self._models.get(taut)
        if found is None:
            found = build([self._cables[i] for i in order], self.loaded.load, len(taut))
            self._models[taut] = found
        own, compliance = np.ascontiguousarray(lengths[list(order)]), found.compliance
        if compliance.any():
            compliance = np.array(
                [self._compliance(i, *pair) for i, pair in zip(order, own.tolist(), strict=True)]
            )
        return found._replace(lengths=own, compliance=compliance)

    def _compliance(self, cable: int, lo: float, hi: float) -> tuple[float, float]:
        """Bound 1 / k, which is monotone in the length, over a range of lengths."""
        law = self.loaded.models[cable].law
        springs = [law.spring_constant(Fraction(end)) for end in (lo, hi)]
        found = [0.0 if k is None else float(1 / k) for k in springs]
        if not any(found):
            return 0.0, 0.0
        return math.nextafter(min(found), 0.0), math.nextafter(max(found), math.inf)

    def slack_paths(self, chart: int, box: Bounds, cables: Sequence[int]) -> list[tuple[float, float] | None]:
        """Bound path lengths over a box in balls, of ropes that may run past their pulleys; None: unknown."""
        turn = centred_cayley([balls.from_bounds(*pair) for pair in box[:3].tolist()]) * half_turn(chart)
        loaded, numbers, centre = self.loaded, Balls(), balls.column(box[3:6])
        found: list[tuple[float, float] | None] = []
        for i in cables:
            x, y, z = balls.entries(centre + turn * balls.fractions(loaded.arms[i]))
            try:
                found.append(balls.to_bounds(loaded.models[i].route.path((x, y, z), numbers).length))
            except OffTheCable:
                found.append(None)
        return found


class Follower:
    """The pose of one robot, wherever it goes."""

    def __init__(self, robot: Robot, force: Point = NO_FORCE) -> None:
        self.cables = Cables(robot, force)
        self._pace = math.inf
        """m of the fastest cable on the longest leg of the last way."""
        self.known: Known | None = None
        self.lengths: Bounds = np.empty((0, 2))
        """(N, 2) m, those for which the pose is where it is."""

    def begin(self, start: Solution, lengths: Bounds) -> Fault:
        """Start from a solution for some lengths in (N, 2), m, with every cable proved taut or slack.

        Guarantee: with HELD the pose that is followed is the solution's.
        """
        rotation, taut = start.rotation, start.taut
        with balls.precision():
            turn = balls.matrix(rotation)
            centre = balls.column(start.position) + turn * balls.ranges(self.cables.loaded.centre_ranges)
            chart, _ = chart_of(quaternion_from_rotation(rotation.mean(axis=-1)))
            where = coordinates(Pose(turn, centre, ()), Frame.plain(), chart)
            if where is None:
                return Fault(ENDS)
            here = place_on(lengths, lengths, 1.0, 1.0)
            box = np.zeros((6 + len(taut), 2))
            box[:6] = [balls.to_bounds(x) for x in (*where[0], *where[1])]
            box[6:] = self._densities(chart, taut, here, box, start.tensions)
            if not np.isfinite(box).all():
                return Fault(ENDS)
            known = self._pinned(chart, taut, box.mean(axis=1), here.middle)
            if known is None:
                return Fault(ENDS)
            fault, _, domain = self._leg(known, here, 1.0, 1.0, box)
            if fault.status == HELD:
                self.known, self.lengths = replace(known, domain=domain), lengths
            return fault

    def go(
        self, lengths: Bounds, budget: Budget | None = None, most: int | None = None
    ) -> tuple[float, list[Leg], Fault]:
        """Follow the pose while the lengths go straight from the last ones to these (N, 2), m.

        ``most`` bounds how many legs are tried.

        Returns how much of the way is proved, the legs, and why it goes no further; the pose is then there.

        Guarantee
        ---------
        For every choice of the lengths before and of those after the pose has moved continuously, at any
        share of the way within the box of the leg of that share.
        """
        before, here, legs, fault = self.lengths, 0.0, list[Leg](), Fault(HELD)
        near = NEAR
        travel = float(np.abs(lengths - before).max())
        step = min(1.0, max(2.0 * self._pace / travel, FINEST)) if travel else 1.0
        tried = 0
        with balls.precision():
            while here < 1.0 and tried != most:
                if budget is not None and budget.stop() is not None:
                    fault = Fault(HELD)
                    break
                tried += 1
                there = min(here + step, 1.0)
                fault, leg = self._part(before, lengths, here, there)
                may_switch = fault.status in (SLACKENS, TIGHTENS) and self._is_decided
                if leg is None and may_switch and step <= near:
                    there = min(here + ACROSS * step, 1.0)
                    leg = self._through(fault.cable, before, lengths, here, there)
                    near = NEAR if leg is not None else max(near / ACROSS, FINEST)
                if leg is not None:
                    legs.append(leg)
                    here, step = there, 2.0 * (there - here)
                    continue
                step *= 0.5
                if step < FINEST:
                    break
        if legs:
            self._pace = max(leg.last - leg.first for leg in legs) * travel or self._pace
            self.lengths = lengths if here == 1.0 else place_on(before, lengths, here, here).bounds
        return here, legs, fault

    def rest(self) -> Leg | None:
        """Return where the pose is for the last lengths, all choices; None where that is not proved apart."""
        known = self.known
        assert known is not None
        here = place_on(self.lengths, self.lengths, 1.0, 1.0)
        with balls.precision():
            if known.open < 0:
                return self._leg(known, here, 1.0, 1.0)[1]
            found = self._switch(known, known.open, here, 1.0, 1.0)
            return None if found is None else found[0]

    @property
    def _is_decided(self) -> bool:
        """Return True where every cable is taut or slack."""
        return self.known is not None and self.known.open < 0

    def _part(self, before: Bounds, after: Bounds, first: float, last: float) -> tuple[Fault, Leg | None]:
        """Go a part of a way; with one cable that may be taut or slack if there is one now."""
        known = self.known
        assert known is not None
        if known.open >= 0:
            leg = self._through(known.open, before, after, first, last)
            return Fault(HELD if leg is not None else ENDS, known.open), leg
        place = place_on(before, after, first, last)
        fault, leg, domain = self._leg(known, place, first, last)
        if leg is None:
            return fault, None
        middle = place_on(before, after, last, last).middle
        arrived = self._pinned(known.chart, known.taut, known.z, middle)
        if arrived is None or not _is_inside(arrived.core, domain):
            return Fault(ENDS), None
        self.known = self._in_good_chart(replace(arrived, domain=domain))
        return fault, leg

    def _leg(
        self, known: Known, place: Place, first: float, last: float, cover: Bounds | None = None
    ) -> tuple[Fault, Leg | None, Bounds]:
        """Prove the pose for all lengths of a part of a way; also return where it is the only one."""
        taut, lengths, m = known.taut, place.bounds, len(known.z)
        order = self.cables.order(taut)
        real = self.cables.model(taut, lengths)
        own = list(order[: len(taut)])
        middle = np.ascontiguousarray(np.repeat(place.middle[list(order), None], 2, axis=1))
        bench = new_bench(real._replace(lengths=middle), known.chart)
        z, C = known.z.copy(), np.empty((m, m))
        # The box tried last tells why; before there is one, what is known.
        box, domain, spans = known.core.copy(), np.empty((m, 2)), np.zeros((len(order), 4))
        hold = known.core if cover is None else _hull(known.core, cover)
        if not (
            improve(bench, z, C, NEWTON_STEPS)
            and prove(bench, z, place.way[own], place.room[own], hold, C, box, domain)
        ):
            status, i = loads(new_bench(real, known.chart), box, -1, spans)
            lifts = status == LIFTS and i < len(taut)
            return Fault(LIFTS, taut[i]) if lifts else Fault(ENDS), None, domain
        fault = self._loads(real, known.chart, order, box, -1, spans)
        leg = Leg(first, last, known.chart, taut, -1, box, spans)
        return fault, leg if fault.status == HELD else None, domain

    def _loads(
        self, real: RealModel, chart: int, order: tuple[int, ...], box: Bounds, switching: int, spans: Floats
    ) -> Fault:
        """Prove what cables do over a box; ``spans`` (N, 4) is written."""
        status, i = loads(new_bench(real, chart), box, switching, spans)
        if status == LIFTS and i >= real.n_taut:
            # Slack ropes may run past their pulleys.
            found = self.cables.slack_paths(chart, box, order[real.n_taut :])
            for j, path in enumerate(found, real.n_taut):
                if path is None or not path[1] < real.lengths[j, 0]:
                    return Fault(LIFTS, order[j])
                spans[j] = 0.0, 0.0, *path
            return Fault(HELD)
        return Fault(status, order[i] if i >= 0 else -1)

    def _through(self, cable: int, before: Bounds, after: Bounds, first: float, last: float) -> Leg | None:
        """Go a part of a way on which a cable may become taut or slack."""
        known = self.known
        assert known is not None
        found = self._switch(known, cable, place_on(before, after, first, last), first, last)
        if found is None:
            return None
        leg, alone = found
        there = place_on(before, after, last, last)
        for taut in (leg.taut[:-1], tuple(sorted(leg.taut))):
            arrived = self._pinned(known.chart, taut, known.among(taut)[0], there.middle)
            if arrived is None or not _is_inside(arrived.among(leg.taut)[1], alone):
                continue
            fault, _, domain = self._leg(arrived, there, 1.0, 1.0)
            if fault.status == HELD and _is_inside(arrived.core, domain):
                self.known = replace(arrived, domain=domain)
                return leg
        point = Place(there.middle, np.zeros_like(there.middle), np.zeros_like(there.middle))
        found = self._switch(known, cable, point, 1.0, 1.0, is_apart=True)
        if found is None or not _is_inside(found[0].box, alone):
            return None
        core = found[0].box
        self.known = Known(known.chart, leg.taut, cable, core.mean(axis=1), there.middle, core, alone)
        return leg

    def _switch(
        self, known: Known, cable: int, place: Place, first: float, last: float, is_apart: bool = False
    ) -> tuple[Leg, Bounds] | None:
        """Prove one pose, a cable taut or slack, for all lengths of a part of a way, and where it is alone.

        It is the known one; ``is_apart``: or another one.
        """
        carrying = tuple(i for i in known.taut if i != cable)
        if not carrying:
            return None
        taut, k = (*carrying, cable), len(carrying)
        z, core = known.among(taut)
        real, spans = self.cables.model(taut, place.bounds), np.zeros((self.cables.count, 4))
        corner = Corner(real, known.chart)
        try:
            start = improved(corner, z, k)
            box = None if start is None else either_way(corner, start, k)
            if box is None or not np.isfinite(box).all():
                return None
            whole = box if is_apart else _hull(box, core)
            alone = next((x for x in _wider(whole) if slope(corner, x, k) is not None), None)
        except NotSmooth:
            return None
        if alone is None:
            return None
        order = self.cables.order(taut)
        if self._loads(real, known.chart, order, box, k, spans).status != HELD:
            return None
        return Leg(first, last, known.chart, taut, cable, box, spans), alone

    def _pinned(self, chart: int, taut: tuple[int, ...], z: Floats, middle: Floats) -> Known | None:
        """Return the pose near z for one choice of the lengths (N,), in the narrowest bounds."""
        m = 6 + len(taut)
        bench = new_bench(self.cables.model(taut, np.repeat(middle[:, None], 2, axis=1)), chart)
        z, C, core = z.copy(), np.empty((m, m)), np.empty((m, 2))
        if not (improve(bench, z, C, NEWTON_STEPS) and existence_box(bench, z, C, core)):
            return None
        return Known(chart, taut, -1, z, middle, core, core)

    def _densities(
        self, chart: int, taut: tuple[int, ...], here: Place, box: Bounds, tensions: Bounds
    ) -> Bounds:
        """Bound t = tension / free length of a pose in a box (6 + n, 2) of which t is not looked at."""
        real, spans = self.cables.model(taut, here.bounds), np.zeros((self.cables.count, 4))
        loads(new_bench(real, chart), np.concatenate([box[:6], np.ones((len(taut), 2))]), -1, spans)
        found = np.full((len(taut), 2), np.nan)
        for j, i in enumerate(taut):
            if spans[j, 0] > 0.0:
                found[j] = _down(tensions[i, 0] / spans[j, 1]), _up(tensions[i, 1] / spans[j, 0])
        return found

    def _in_good_chart(self, known: Known) -> Known:
        """Return a pose in another chart where u is too large, if that is proved to be the same one."""
        if float(np.abs(known.z[:3]).max()) <= CHART_END:
            return known
        quaternion = quaternion_of(known.chart, known.z)
        chart, _ = chart_of(quaternion)
        z = known.z.copy()
        z[:3] = u_in(chart, quaternion)
        found = self._pinned(chart, known.taut, z, known.middle)
        if found is None:
            return known
        u = [balls.from_bounds(*pair) for pair in found.core[:3].tolist()]
        centre = balls.column(found.core[3:6])
        where = coordinates(
            Pose(centred_cayley(u) * half_turn(chart), centre, ()), Frame.plain(), known.chart
        )
        if where is None:
            return known
        there = np.array([*(balls.to_bounds(x) for x in (*where[0], *where[1])), *found.core[6:]])
        return found if _is_inside(there, known.domain) else known


def warm_up_legs(robot: Robot) -> None:
    """Ask for all kernels of legs once: of one cable, for a pose that is none."""
    cables = Cables(robot, (Fraction(0), Fraction(0), Fraction(-1)))
    real = cables.model((0,), np.ones((cables.count, 2)))
    bench, z, one = new_bench(real, 0), np.zeros(7), np.ones(1)
    C, box, f, J = np.empty((7, 7)), np.zeros((7, 2)), np.empty((7, 2)), np.empty((7, 7, 2))
    z[3:6] = box[3:6] = 1e3
    system(bench, box, f, J, True)
    improve(bench, z.copy(), C, 1)
    existence_box(bench, z, C, box.copy())
    prove(bench, z, one, one, box, C, box.copy(), box.copy())
    loads(bench, box, -1, np.zeros((cables.count, 4)))


def _wider(box: Bounds) -> Iterator[Bounds]:
    """Yield wider boxes (m, 2), each narrower than the last."""
    width = box[:, 1] - box[:, 0]
    for margin in MARGINS:
        off = margin * width + 1e-14 * (1.0 + np.abs(box).max(axis=1))
        yield np.ascontiguousarray(np.stack([box[:, 0] - off, box[:, 1] + off], axis=1))


def _hull(one: Bounds, other: Bounds) -> Bounds:
    """Return the box (m, 2) around two boxes."""
    return np.stack([np.minimum(one[:, 0], other[:, 0]), np.maximum(one[:, 1], other[:, 1])], axis=1)


def _is_inside(inner: Bounds, outer: Bounds) -> bool:
    """Return True when a box (m, 2) lies in another one; False for NaN."""
    return bool(((outer[:, 0] <= inner[:, 0]) & (inner[:, 1] <= outer[:, 1])).all())


def _down(x: Any) -> Any:
    return np.nextafter(x, -np.inf)


def _up(x: Any) -> Any:
    return np.nextafter(x, np.inf)
