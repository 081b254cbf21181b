"""Roots: boxes of poses that hold exactly one zero of a subset's equations, and tight bounds of that zero.

The unknowns are the free entries of u, x and the tensions t over the lengths; the equations are lengths and
balance. For six taut cables the lengths alone fix the pose, and t follows. Cables over
pulleys have p in place of x, and the densities of all taut cables among the unknowns.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from flint import arb, arb_mat

from certificates import newton
from certificates.arithmetic import guess
from certificates.arithmetic.balls import column
from certificates.arithmetic.floats import Floats
from certificates.arithmetic.forms import PLACE, TENSION, TURN, Array, Form, Vector, stacked
from certificates.arithmetic.guess import usable
from certificates.arithmetic.integers import Integers
from certificates.arithmetic.jets import Jet
from certificates.arithmetic.vectors import dot, minus
from certificates.cells import contained, deviation, doubles
from certificates.frames import Setting
from certificates.geometry import Platform, Rotated
from certificates.newton import Zero
from certificates.routed.ropes import Posed, Ropes
from certificates.verdicts import NotProved


class System:
    """The equations of one search in one chart, or in charts, one a cell."""

    def __init__(
        self, setting: Setting, platform: Platform, over: Callable[[type[Form]], Platform], chart: Any
    ) -> None:
        self.setting, self.platform, self.over, self.chart = setting, platform, over, chart
        # Chart 0 is always needed, and all that are have the same entries 0.
        frozen = setting.frozen(0) or ()
        self.unknowns = [TURN + k for k in range(3) if k not in frozen]
        self.unknowns += [PLACE + k for k in range(3) if not (setting.planar and k == 1)]
        self.balanced = platform.taut < 6
        if self.balanced:
            self.unknowns += [TENSION + k for k in range(platform.taut)]
        self.ranged = [k for k, w in enumerate(platform.swings) if w != 0]
        """The taut cables whose lengths have a range, by their places."""

    @property
    def is_regular_all_along(self) -> bool:
        """Along ranges of lengths the full statics are regular where one zero at most is in a box.

        Not where a symmetry leaves equations out.
        """
        return bool(self.ranged) and self.balanced and not (self.setting.planar or self.setting.family)

    def rotated(self, platform: Any, u: Sequence[Any]) -> Any:
        """Return the platform turned."""
        return Rotated(platform, self.chart, u)

    def jets(self, x: Sequence[Any]) -> list[Any]:
        """Return u, x and t with derivatives by the unknowns, given these, data behind them; others are 0."""
        one = 0 * x[0] + 1
        found = {k: Jet(v, {i: one}) for i, (k, v) in enumerate(zip(self.unknowns, x, strict=False))}
        return [found.get(k, 0 * x[0]) for k in range(TENSION + self.balanced * self.platform.taut)]

    def moved(self, x: Sequence[arb]) -> Platform:
        """Return the platform with derivatives by the symbols of lengths, given behind the unknowns."""
        n = len(self.unknowns)
        given = [(k, n + i, d) for i, (k, d) in enumerate(zip(self.ranged, x[n:], strict=True))]
        swings = self.platform.swings
        return self.platform.ranging({k: Jet(swings[k] * d, {i: swings[k]}) for k, i, d in given})

    def equations(self, platform: Platform, x: Sequence[Any], apart: bool) -> list[Jet]:
        """Return numbers that are 0 where lengths and balance hold; ``apart``: each has its own length."""
        z = self.jets(x)
        rotated = Rotated(platform, self.chart, z[:3])
        found = rotated.spheres(z[3:6]) if apart else rotated.lengths(z[3:6], rotated.lines)
        if not self.balanced:
            return found
        *wrenches, load = rotated.wrenches(z[3:6])
        left = [load[k] + dot(z[6:], [w[k] for w in wrenches]) for k in range(6)]
        if self.setting.planar:
            return [*found, left[0], left[2], left[4]]
        if self.setting.vertical:
            return [*found, *left[:5]]
        if self.setting.rod:
            return [*found, *left[:3], *(dot(left[3:], [row[k] for row in rotated.rotation]) for k in (0, 1))]
        return [*found, *left]

    @np.errstate(all="ignore")
    def tensions(self, box: Vector) -> tuple[Array, Array, Array]:
        """Return middles, and radii, of every t that balances the load somewhere in boxes of (u, x).

        Doubles (n, N), bounds (n, N), and where these are right. With L near a left inverse of the wrenches
        W: t - t_0 = -L (W t_0 + w_0) - (L W - I)(t - t_0).
        """
        kind = type(box[0])
        *wrenches, load = self.rotated(self.over(kind), box[:3]).wrenches(box[3:])
        columns = stacked([stacked([v.doubles() for v in w]) for w in [*wrenches, load]])
        columns, right = columns[:-1], columns[-1]
        L = usable(guess.solve(guess.gram(columns, np.ones((len(columns), right.shape[-1]), bool)), columns))
        t = -np.einsum("ikc,kc->ic", L, right)
        rows = list(zip(*wrenches, strict=True))
        rest = [f + kind.combine(t, row) for f, row in zip(load, rows, strict=True)]
        bound, holds = contained(kind, [kind.combine(row, rest).size() for row in L], deviation(L, rows))
        return t, bound, holds

    def has_one_zero_at_most(self, bounds: Array) -> bool:
        """Return True when boxes (6, 2, N) of (u, x) hold at most one zero each, whatever its tensions.

        Two zeros z, z' in a box have |z - z'| <= |C J - I| |z - z'| with J the derivatives over the box.
        """
        return bool(self.one_zero(bounds, Floats).all() or self.one_zero(bounds, Integers).all())

    @np.errstate(all="ignore")
    def one_zero(self, bounds: Array, kind: type[Form]) -> Array:
        """Return in which boxes one arithmetic shows it; what overflows is no proof."""
        z: Vector = [kind.between(lo, hi, k) for k, (lo, hi) in enumerate(bounds)]
        holds = np.ones(bounds.shape[-1], dtype=bool)
        if self.balanced:
            middles, radii, holds = self.tensions(z)
            numbered = enumerate(zip(middles, radii, strict=True), TENSION)
            z += [kind.near(t) + kind.unknown(r, k) for k, (t, r) in numbered]
        found = self.equations(self.over(kind), [z[k] for k in self.unknowns], apart=False)
        J = [[f.slopes.get(k, kind.constant(0)) for k in range(len(found))] for f in found]
        C = usable(guess.inverse(doubles(J)))
        first = [kind.numbers(np.ones(1))] * len(C)
        return holds & contained(kind, first, deviation(C, J))[1]

    def zero_near(self, middle: Sequence[float], data: Sequence[arb]) -> Zero:
        """Enclose a zero's unknowns, found by Newton from (u, x); raise NotProved where that fails.

        ``data`` : parts of [-1, 1], or points, for the lengths that have a range.
        """
        t, _, holds = self.tensions([Floats.constant(v) for v in middle])
        if not holds.all():
            raise NotProved("no tensions near a root's middle")
        z = [arb(v) for v in [*middle, *t[:, 0].tolist()]]

        def system(x: list[arb], axes: arb_mat) -> tuple[arb_mat, arb_mat]:
            """Return the values of the equations and their slopes along axes."""
            found = self.equations(self.moved(x), x, apart=True)
            slopes = [[f.slopes.get(k, 0) for k in range(axes.nrows())] for f in found]
            return column([f.value for f in found]), arb_mat(slopes) * axes

        try:
            return newton.zero(system, [z[k] for k in self.unknowns], data)
        except ZeroDivisionError:
            raise NotProved("no pose is proved near a root's middle: singular") from None

    def pose(self, zero: Zero) -> tuple[arb_mat, arb_mat, list[arb], list[arb], list[arb]]:
        """Enclose rotation, way from the first exit point to the centre of mass, t, tensions and distances.

        Tensions are those of the taut cables, distances (of exit and platform point) those of all others.
        """
        base, platform = self.setting.base.transpose().tolist(), self.setting.platform.transpose().tolist()
        taut, count = self.platform.taut, len(self.platform.exits)

        def entries(x: list[arb]) -> list[Any]:
            """Return all of them at some unknowns."""
            z, moved = self.jets(x), self.moved(x)
            rotated = Rotated(moved, self.chart, z[:3])
            rows = [[v * rotated.s.inverse() for v in row] for row in rotated.rotation]
            way = minus(z[3:6], [dot(row, moved.arm) for row in rows])
            found = [[dot(row, axis) for row in rows] for axis in platform]
            columns = [[dot(axis, v) for axis in base] for v in [*found, way]]
            densities = z[6:] if self.balanced else carried(rotated, z[3:6])
            pulls = [t * as_jet(moved.length_square(k)).root() for k, t in enumerate(densities)]
            spokes = [self.spoke(i, rows, z[3:6]) for i in range(taut, count)]
            squares = [dot(e, e) for e in spokes]
            return [as_jet(v) for v in [*(v for c in columns for v in c), *densities, *pulls, *squares]]

        try:
            found = zero.image(entries)
        except ZeroDivisionError:
            raise NotProved("tensions of six cables are not bounded: singular") from None
        t, pulls, squares = found[12 : 12 + taut], found[12 + taut : 12 + 2 * taut], found[12 + 2 * taut :]
        distances = [v.nonnegative_part().sqrt() for v in squares]
        return arb_mat(3, 3, found[:9]).transpose(), column(found[9:12]), t, pulls, distances

    def spoke(self, i: int, rotation: Sequence[Vector], x: Vector) -> Vector:
        """Return the way of a cable from its platform point to its exit point."""
        p = self.platform
        return [a - dot(row, p.points[i]) - v for a, row, v in zip(p.exits[i], rotation, x, strict=True)]


class RoutedSystem(System):
    """The equations of one search in one chart, or in charts, one a cell."""

    def __init__(
        self,
        setting: Setting,
        platform: Any,
        over: Callable[[type[Form]], Any],
        chart: Any,
        first_exit: Sequence[Any],
    ) -> None:
        super().__init__(setting, platform, over, chart)
        self.first_exit, self.balanced = first_exit, True
        self.unknowns = list(range(TENSION + platform.taut))

    def rotated(self, platform: Any, u: Sequence[Any]) -> Posed:
        """Return the platform turned."""
        return Posed(platform, self.chart, u)

    def equations(self, platform: Any, x: Sequence[Any], apart: bool) -> list[Jet]:
        """Return numbers that are 0 where lengths and balance hold."""
        z = self.jets(x)
        posed, t = self.rotated(platform, z[:3]), z[TENSION:]
        found = [self.length(platform, posed, i, z[3:6]) for i in range(platform.taut)]
        *wrenches, load = posed.wrenches(z[3:6])
        return [*found, *(load[k] + dot(t, [w[k] for w in wrenches]) for k in range(6))]

    def length(self, ropes: Ropes, posed: Posed, i: int, p: Sequence[Any]) -> Any:
        """Return a number that is 0 where a taut cable has its length."""
        rope = posed.rope(i, list(p))
        if ropes.axes[i]:
            return rope.length - ropes.lengths[i]
        straight = ropes.lengths[i] - ropes.before[i]
        return rope.square - straight * straight

    def pose(self, zero: Zero) -> tuple[arb_mat, arb_mat, list[arb], list[arb], list[arb]]:
        """Enclose the same, but no tensions and distances: they follow from where the anchors are."""

        def entries(x: list[arb]) -> list[Jet]:
            z = self.jets(x)
            rotated = self.rotated(self.platform, z[:3])
            inverse = rotated.s.inverse()
            return [*(v * inverse for row in rotated.rotation for v in row), *z[3:]]

        found = zero.image(entries)
        way = minus(found[9:12], [arb(v) for v in self.first_exit])
        return arb_mat(3, 3, found[:9]), column(way), found[12:], [], []


def as_jet(x: Any) -> Jet:
    """Return a number with its derivatives; a constant has none."""
    return x if isinstance(x, Jet) else Jet(x, {})


def carried(rotated: Rotated, x: Vector) -> list[Jet]:
    """Return the t of six cables in a pose: W t = -w_0, and with it W t' = -w_0' - W' t."""
    *wrenches, load = [[as_jet(v) for v in w] for w in rotated.wrenches(x)]
    matrix = arb_mat([[v.value for v in w] for w in wrenches]).transpose()
    t = matrix.solve(-column([v.value for v in load])).entries()
    slopes: list[dict[int, arb]] = [{} for _ in t]
    for k in sorted({k for w in [*wrenches, load] for v in w for k in v.slopes}):
        change = column([v.slopes.get(k, 0) for v in load])
        for w, v in zip(wrenches, t, strict=True):
            change += column([x.slopes.get(k, 0) for x in w]) * v
        for row, v in zip(slopes, matrix.solve(-change).entries(), strict=True):
            row[k] = v
    return [Jet(v, row) for v, row in zip(t, slopes, strict=True)]
