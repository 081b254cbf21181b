"""The equations of a root: lengths and balance, unknowns u, p and the densities t of all taut cables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from flint import arb, arb_mat

from certificates.arithmetic.balls import column, minus
from certificates.arithmetic.forms import TENSION, Form
from certificates.arithmetic.jets import Jet
from certificates.arithmetic.vectors import dot
from certificates.frames import Setting
from certificates.newton import Zero
from certificates.roots import System
from certificates.routed.ropes import Posed, Ropes


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
        found = [self.length(platform, posed, i, z[3:6], t[i]) for i in range(platform.taut)]
        *wrenches, load = posed.wrenches(z[3:6])
        return [*found, *(load[k] + dot(t, [w[k] for w in wrenches]) for k in range(6))]

    def length(self, ropes: Ropes, posed: Posed, i: int, p: Sequence[Any], t: Any) -> Any:
        """Return a number that is 0 where a taut cable has its length, stretched by its tension t sigma."""
        rope = posed.rope(i, list(p))
        if ropes.stiffnesses:
            return ropes.stiffnesses[i] * (rope.length - ropes.lengths[i]) - t * rope.free
        if ropes.axes[i]:
            return rope.length - ropes.lengths[i]
        straight = ropes.lengths[i] - ropes.before[i]
        return rope.square - straight * straight

    def pose(self, zero: Zero) -> tuple[arb_mat, arb_mat, list[arb]]:
        """Enclose rotation, way from the first exit point to the centre of mass, and t."""

        def entries(x: list[arb]) -> list[Jet]:
            z = self.jets(x)
            rotated = self.rotated(self.platform, z[:3])
            inverse = rotated.s.inverse()
            return [*(v * inverse for row in rotated.rotation for v in row), *z[3:]]

        found = zero.image(entries)
        return arb_mat(3, 3, found[:9]), column(minus(found[9:12], self.first_exit)), found[12:]
