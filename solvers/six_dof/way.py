"""The way of a tracked pose from the lengths before to new ones, through cables that become taut or slack."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.mechanics.rotation import quaternion_of, u_in
from cdpr_interval.mechanics.six_dof.arrays import Model, build_model
from cdpr_interval.mechanics.six_dof.frame import Frame
from cdpr_interval.mechanics.six_dof.tube import SYMBOLS
from cdpr_interval.robots.cable_robot import Robot
from solvers.six_dof.cells.roots import GENERAL, system_of
from solvers.six_dof.cells.tube_prover import forms_of_thread
from solvers.six_dof.continuation import MOST_PIECES, NEAR, SHORTEST, Link, follow
from solvers.six_dof.crossing import OPEN_NOW, SLACK_NOW, TAUT_NOW, cross
from solvers.six_dof.track import FORCED, LOOSE, TIGHT, TRACKED

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_TAUT = 6
MOST_SWITCHES = 32
"""On one way: a bound of the time a call takes."""
ACROSS = 8.0
"""First step tried across a place where a cable may switch, over the last one that was too long before it."""
NEARER = 8.0
"""How much shorter pieces may be before a place where a cable may switch, when it was not reached."""
CHART_ROUNDING = 1e-14
"""Of u in a new chart."""


@dataclass
class Known:
    """Where a pose is: in floats, and what is proved of which one it is."""

    taut: tuple[int, ...]
    """File order."""
    z: Floats
    """(6 + N,) u, p, and t of all cables, file order."""
    lengths: Bounds
    """(N, 2) file order."""
    load: Bounds
    """(3, 2)."""
    zero: Floats
    """(6 + N,) near the pose for the middles of the lengths,"""
    radii: Floats
    """(6 + N,) within these, if ``region`` is None."""
    region: Floats | None = None
    """(7,): u and p of a reference, and the radius in m around it in which the pose is the only one."""
    open: int = -1
    """The cable, one of ``taut``, that may be taut or slack for these lengths; ``zero`` is the one taut,"""
    slack_zero: Floats | None = None
    """and this one that with it slack,"""
    slack_radii: Floats | None = None
    """within these. Of each choice of the data one of the two is the pose."""


@dataclass
class Noted:
    """A part of a way, and where the pose is proved to be on it, for all choices of the lengths."""

    first: float
    """Share of the way where it begins,"""
    last: float
    """and where it ends."""
    taut: tuple[int, ...]
    """Cables whose tensions the boxes have, in their order: those that are taut, and one that is ``open``."""
    boxes: tuple[Floats, ...]
    """(6 + n, 2): u, p and t of the pose; with ``open`` of that with it taut and of that with it slack."""
    open: int = -1
    """The cable that switches here."""


@dataclass
class Arrived:
    """What came of a way."""

    status: int
    """Of `track`."""
    pieces: int = 0
    cable: int = -1
    """At fault, file order."""
    share: float = 0.0
    """Of the way that is proved."""
    switching: tuple[int, ...] = ()
    """Cables that became slack or taut on the way, or may be either now."""
    open: int = -1
    """The cable that may be either now."""
    boxes: tuple[Floats, ...] = ()
    """(6 + n, 2): the enclosure of the pose; with ``open`` of that with it taut and of that with it slack."""
    known: Known | None = None
    """Of the pose at the end of the way."""


class Way:
    """The pose of one robot, wherever it goes."""

    def __init__(self, robot: Robot, known: Known, size: float) -> None:
        self.known = known
        self._robot, self._size = robot, size
        self._models: dict[tuple[int, ...], Model] = {}

    def go(
        self, chart: int, cables: Floats, load: Bounds, lengths: Bounds, notes: list[Noted] | None = None
    ) -> Arrived:
        """Follow the pose to new lengths (N, 2), file order; it is moved there by `arrive`.

        ``cables`` (N, 6, 2) are the bounds of A_i and D_c b_i in the chart, ``load`` (3, 2) those of the
        load. The parts of the way that are proved are added to ``notes``, each from where the last one ends.
        """
        if not np.array_equal(self.known.load, load):
            return Arrived(FORCED)
        return _Trip(self, chart, cables, load, lengths, notes).run()

    def alone_in(self, known: Known, reference: Floats, radius: float) -> None:
        """Take over a pose that is alone in a region: ``reference`` (6,) u and p, ``radius`` in m."""
        self.known = known
        known.region = np.array([*reference[:6], radius])

    def arrive(self, arrived: Arrived) -> None:
        """Be where a way has led."""
        assert arrived.known is not None
        self.known = arrived.known

    def turn_chart(self, before: int, after: int) -> None:
        """Go on in another chart."""
        known = self.known
        known.z = known.z.copy()
        known.z[:3] = u_in(after, quaternion_of(before, known.z))
        known.zero, known.radii = turned(before, after, known.zero, known.radii)
        if known.slack_zero is not None and known.slack_radii is not None:
            known.slack_zero, known.slack_radii = turned(before, after, known.slack_zero, known.slack_radii)
        if known.region is not None:
            known.region = known.region.copy()
            known.region[:3] = u_in(after, quaternion_of(before, known.region))
            known.region[6] = (1.0 - 1e-9) * known.region[6] - CHART_ROUNDING * self._size
            if not known.region[6] > 0.0:
                known.region, known.radii[:] = None, np.inf

    def model(self, order: tuple[int, ...], n: int, load: Bounds) -> Model:
        """Return the arrays of the cables in an order, of which n are taut, with a load (3, 2)."""
        found = self._models.get(order)
        if found is None:
            found = self._models[order] = model_of(self._robot, order)
        middle = load.mean(axis=1)
        found.load[:] = middle
        found.load_err[:] = np.nextafter(np.maximum(load[:, 1] - middle, middle - load[:, 0]), np.inf)
        # Regions speak of turns by their radius over the tracker's size, whatever the order of the cables.
        return found._replace(n_taut=n, size=self._size)


class _Trip:
    """One way, from the last lengths to new ones."""

    def __init__(
        self,
        way: Way,
        chart: int,
        cables: Floats,
        load: Bounds,
        lengths: Bounds,
        notes: list[Noted] | None = None,
    ) -> None:
        self.notes = notes
        self.way, self.chart, self.cables, self.load, self.lengths = way, chart, cables, load, lengths
        self.known = way.known
        self.share, self.pieces, self.step = 0.0, 0, 1.0
        self.switching: list[int] = []

    def run(self) -> Arrived:
        """Go piece by piece."""
        near = NEAR
        arrived = self.onward()
        for _ in range(MOST_SWITCHES):
            if arrived.status not in (LOOSE, TIGHT) or not self.is_pinned():
                break
            opened = self.through(arrived.cable, arrived.share)
            if opened is None:
                if near <= SHORTEST or self.known.open >= 0:
                    break
                # Nearer to the switch the two poses are nearer, too.
                near = max(near / NEARER, SHORTEST)
                arrived = self.regular(near)
                continue
            near = NEAR
            arrived = self.onward()
            if self.share == 1.0 and arrived.status != TRACKED:
                arrived = opened
        arrived.pieces, arrived.switching = self.pieces, tuple(sorted(set(self.switching)))
        if arrived.status == TRACKED:
            arrived.known = replace(self.known, lengths=self.lengths)
        return arrived

    def onward(self) -> Arrived:
        """Follow the pose as far as no cable may switch."""
        if self.known.open >= 0:
            return Arrived(LOOSE, cable=self.known.open, share=self.share)
        return self.regular()

    def regular(self, near: float = NEAR) -> Arrived:
        """Follow the pose with the taut cables it has now, in pieces down to ``near`` before a switch."""
        order, n = self.order(self.known.taut), len(self.known.taut)
        z, link = self.start(order, n)
        box, system = np.empty((6 + n, 2)), system_of(GENERAL, n)
        notes = self.sheet(MOST_PIECES, n)
        status, pieces, cable, share, step = follow(
            forms_of_thread(SYMBOLS), SYMBOLS, self.way.model(order, n, self.load), self.data(order, n),
            self.chart, system.rows, system.free[0].copy(), self.before(order), self.after(order), self.share,
            near, link, z, box, notes,
        )  # fmt: skip
        self.note(notes[:pieces], order[:n])
        self.pieces += pieces
        self.step = step
        if pieces:
            self.arrive(order[:n], z, link)
        self.share = share
        return Arrived(status, cable=order[cable] if cable >= 0 else -1, share=share, boxes=(box,))

    def is_pinned(self) -> bool:
        """Make sure that the pose is known for one choice, not only by a region."""
        if self.known.region is None:
            return True
        order, n = self.order(self.known.taut), len(self.known.taut)
        z, link = self.start(order, n)
        here, system = self.before(order), system_of(GENERAL, n)
        status, *_ = follow(
            forms_of_thread(SYMBOLS), SYMBOLS, self.way.model(order, n, self.load), self.data(order, n),
            self.chart, system.rows, system.free[0].copy(), here, here, 1.0, NEAR, link, z,
            np.empty((6 + n, 2)), np.empty((0, 7 + n, 2)),
        )  # fmt: skip
        if status == TRACKED:
            self.arrive(order[:n], z, link)
        return bool(status == TRACKED)

    def through(self, cable: int, start: float) -> Arrived | None:
        """Go on where a cable may switch; return what is known at the end of the way, or None."""
        carrying = tuple(i for i in self.known.taut if i != cable)
        if not 0 < len(carrying) < MOST_TAUT:
            return None
        was = TAUT_NOW if cable in self.known.taut else SLACK_NOW
        if self.known.open >= 0:
            was = OPEN_NOW
        order, n = self.order((*carrying, cable)), len(carrying) + 1
        z, link = self.start(order, n)
        slack_link = self.slack_start(order, n, link)
        boxes, notes = (np.empty((6 + n, 2)), np.empty((6 + n, 2))), self.sheet(4, n)
        proved, share, now = cross(
            forms_of_thread(SYMBOLS), SYMBOLS, self.way.model(order, n, self.load), self.data(order, n),
            self.data(order, n - 1), self.chart, self.before(order), self.after(order), start,
            ACROSS * max(self.step, SHORTEST), was, link, slack_link, z, *boxes, notes,
        )  # fmt: skip
        if not proved:
            return None
        self.note_switch(notes, order[:n], was, now)
        self.pieces += 1
        self.share, self.step = share, share - start
        self.switching.append(cable)
        if now == SLACK_NOW:
            self.arrive(order[: n - 1], z, slack_link)
        else:
            self.arrive(order[:n], z, link)
        if now == OPEN_NOW:
            self.known.open = cable
            self.known.slack_zero = spread(slack_link.zero, order[:n], len(order))
            self.known.slack_radii = spread(slack_link.radii, order[:n], len(order))
        return Arrived(TRACKED, share=share, open=cable, boxes=boxes)

    def sheet(self, count: int, n: int) -> Floats:
        """Return an array for so many notes; for none where nobody asks for them."""
        return np.empty((0 if self.notes is None else count, 7 + n, 2))

    def note(self, notes: Floats, taut: tuple[int, ...]) -> None:
        """Keep the parts (K, 7 + n, 2) of the way with these cables taut."""
        if self.notes is not None:
            self.notes += [Noted(one[0, 0], one[0, 1], taut, (one[1:].copy(),)) for one in notes]

    def note_switch(self, notes: Floats, taut: tuple[int, ...], was: int, now: int) -> None:
        """Keep the parts (4, 7 + n, 2) of a piece on which the last of these cables switches."""
        if self.notes is None:
            return
        before, during, slack, after = notes

        def keep(one: Floats, n: int) -> None:
            if one[0, 0] < one[0, 1]:
                self.note(one[None, : 7 + n], taut[:n])

        n = len(taut)
        keep(before, n if was == TAUT_NOW else n - 1)
        if during[0, 0] < during[0, 1]:
            boxes = (during[1:].copy(), slack[1:].copy())
            self.notes.append(Noted(during[0, 0], during[0, 1], taut, boxes, taut[-1]))
        keep(after, n if now == TAUT_NOW else n - 1)

    def order(self, taut: tuple[int, ...]) -> tuple[int, ...]:
        """Return all cables, these in front."""
        return (*taut, *(i for i in range(len(self.lengths)) if i not in taut))

    def start(self, order: tuple[int, ...], n: int) -> tuple[Floats, Link]:
        """Return the floats and the link of the pose, the first n cables of an order taut."""
        chosen, known = np.array([*range(6), *(6 + i for i in order[:n])]), self.known
        region = np.zeros(7) if known.region is None else known.region
        link = Link(np.array([known.region is None]), known.zero[chosen], known.radii[chosen], region)
        return known.z[chosen], link

    def slack_start(self, order: tuple[int, ...], n: int, link: Link) -> Link:
        """Return the link of the pose with the last of the n cables slack; ``link`` is that of one known."""
        known = self.known
        if known.slack_zero is None or known.slack_radii is None:
            return Link(*(x.copy() for x in link))
        chosen = np.array([*range(6), *(6 + i for i in order[:n])])
        return Link(np.array([True]), known.slack_zero[chosen], known.slack_radii[chosen], np.zeros(7))

    def arrive(self, taut: tuple[int, ...], z: Floats, link: Link) -> None:
        """Keep where the pose is now; of the way its lengths stay those before."""
        count, n = len(self.lengths), len(taut)
        whole, zero, radii = (spread(x[: 6 + n], taut, count) for x in (z, link.zero, link.radii))
        self.known = Known(taut, whole, self.known.lengths, self.known.load, zero, radii)

    def before(self, order: tuple[int, ...]) -> Bounds:
        """Return the lengths before, in an order."""
        return np.ascontiguousarray(self.way.known.lengths[list(order)])

    def after(self, order: tuple[int, ...]) -> Bounds:
        """Return the lengths after, in an order."""
        return np.ascontiguousarray(self.lengths[list(order)])

    def data(self, order: tuple[int, ...], n: int) -> Floats:
        """Return the numbers of n taut cables and the load as ``track`` has them, lengths left out."""
        data = np.empty((n + 1, 7, 2))
        data[:n, :6] = self.cables[list(order[:n])]
        data[n, :3] = self.load
        return data


def spread(z: Floats, taut: tuple[int, ...], count: int) -> Floats:
    """Return (6 + N,) of (6 + n,) numbers, or of (6,) of a pose whose tensions are not known."""
    whole = np.zeros(6 + count)
    whole[:6] = z[:6]
    whole[[6 + i for i in taut]] = z[6:] if len(z) > 6 else 1.0
    return whole


def turned(before: int, after: int, zero: Floats, radii: Floats) -> tuple[Floats, Floats]:
    """Return a zero (6 + N,) known within radii (6 + N,) in another chart.

    The half turn from one chart to the other is about an axis k: there u_k becomes 1 / u_k, and the other two
    change places and are divided by u_k, all but for signs.
    """
    zero, radii, k = zero.copy(), radii.copy(), (before ^ after) - 1
    a, b = (k + 1) % 3, (k + 2) % 3
    size, (ra, rb, rk) = np.abs(zero[:3]), radii[[a, b, k]]
    zero[:3] = u_in(after, quaternion_of(before, zero))
    least = (size[k] - rk) * (1.0 - CHART_ROUNDING)
    if not least > 0.0:
        radii[:3] = np.inf
        return zero, radii
    turn = rk / size[k]
    radii[[a, b, k]] = np.array([rb + size[b] * turn, ra + size[a] * turn, turn]) / least
    radii[:3] = radii[:3] * (1.0 + CHART_ROUNDING) + CHART_ROUNDING
    return zero, radii


def model_of(robot: Robot, order: tuple[int, ...]) -> Model:
    """Return the arrays of a robot's cables in an order; lengths, load and how many are taut are open."""
    frame, view = Frame.plain(), loaded(robot)
    return build_model(
        [frame.exit_point(view.exit_ranges[i]) for i in order],
        [frame.arm(view.arm_ranges[i]) for i in order],
        [Range.exact(1) for _ in order],
        frame.force(view.load_ranges),
        min(len(order), MOST_TAUT),
        spread=True,
    )._replace(own_points=True)


def warm_up_ways(robot: Robot, cables: Floats, load: Bounds) -> None:
    """Ask for all kernels of ways once: of lengths of 1 m, for a pose far away, which is none.

    ``cables`` (N, 6, 2) and ``load`` (3, 2) as in `Way.go`.
    """
    count = len(cables)
    z, lengths = np.ones(6 + count), np.ones((count, 2))
    z[3:6] = 1e3
    taut = tuple(range(min(2, count)))
    way = Way(robot, Known(taut, z, lengths, load, z, np.zeros(len(z))), 1.0)
    trip = _Trip(way, 0, cables, load, lengths)
    trip.regular()
    trip.through(0, 0.0)
