"""Roots: boxes of poses that hold exactly one zero of a subset's equations, and tight bounds of that zero.

The unknowns are the free entries of u, x and the tensions t over the lengths; the equations are lengths and
balance. For six taut cables the lengths alone fix the pose, and t follows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import fmpq, fmpq_mpoly, fmpz

from certificates import guess
from certificates.cells import combine, contained
from certificates.frames import Setting
from certificates.geometry import Platform, Turned
from certificates.polynomials import (
    PLACE,
    SYMBOL,
    TENSION,
    TURN,
    ZERO,
    Vector,
    centre,
    constant,
    dot,
    number,
    rational,
    size,
    slopes,
    total,
)

Numbers = list[fmpq]
GRID = fmpz(2) ** 200
"""Starts are multiples of 1 / GRID."""
STEPS = 40
"""Most Newton steps; each in exact numbers with a float inverse gains at least a digit near a root."""
SMALL = fmpq(1, GRID // 2**60)
"""A Newton step this short is the last one."""
WIDENINGS = 12
"""Most boxes tried around a start."""


@dataclass(frozen=True)
class Zero:
    """Bounds of one zero: middles and radii of u (3), x (3) and t (n)."""

    middle: Numbers
    radius: Numbers


class System:
    """The equations of one search in one chart."""

    def __init__(self, setting: Setting, platform: Platform, chart: int) -> None:
        self.setting, self.platform, self.chart = setting, platform, chart
        n = platform.taut
        frozen = setting.frozen(chart) or ()
        self.unknowns = [TURN + k for k in range(3) if k not in frozen]
        self.unknowns += [PLACE + k for k in range(3) if not (setting.planar and k == 1)]
        self.balanced = n < 6
        if self.balanced:
            self.unknowns += [TENSION + k for k in range(n)]
        self.symbols = [*range(TURN, TURN + 3), *range(PLACE, PLACE + 3), *range(TENSION, TENSION + n)]

    def around(self, middle: Numbers, radius: Numbers) -> Vector:
        """Return u, x, t as polynomials over a box."""
        return [constant(m) + SYMBOL[k] * r for m, r, k in zip(middle, radius, self.symbols, strict=True)]

    def equations(self, z: Vector) -> Vector:
        """Return polynomials that vanish where lengths and balance hold."""
        turned = Turned(self.platform, self.chart, z[:3])
        found = turned.lengths(z[3:6])
        if not self.balanced:
            return found
        *wrenches, load = turned.wrenches(z[3:6])
        left = [load[k] + dot(z[6:], [w[k] for w in wrenches]) for k in range(6)]
        if self.setting.planar:
            return [*found, left[0], left[2], left[4]]
        if self.setting.vertical:
            return [*found, *left[:5]]
        if self.setting.rod:
            return [*found, *left[:3], *(dot(left[3:], [row[k] for row in turned.rotation]) for k in (0, 1))]
        return [*found, *left]

    def changes(self, equations: Vector) -> list[list[fmpq_mpoly]]:
        """Return the derivatives by the unknowns' symbols."""
        return [[f.derivative(k) for k in self.unknowns] for f in equations]

    def tensions(self, middle: Numbers, radius: Numbers) -> tuple[Numbers, Numbers] | None:
        """Return middles and radii of every t that balances the load somewhere in a box of (u, x), or None.

        With L near a left inverse of the wrenches W: t - t_0 = -L (W t_0 + w_0) - (L W - I)(t - t_0).
        """
        z = self.around(
            [*middle[:6], *[ZERO] * self.platform.taut], [*radius[:6], *[ZERO] * self.platform.taut]
        )
        *wrenches, load = Turned(self.platform, self.chart, z[:3]).wrenches(z[3:6])
        columns = [[number(centre(v)) for v in w] for w in wrenches]
        left = guess.solve(guess.gram(columns), columns)
        if left is None:
            return None
        L = [[rational(v) for v in row] for row in left]
        t = [-total([constant(v) * centre(f) for v, f in zip(row, load, strict=True)]) for row in L]
        rest = [f + dot(t, [w[k] for w in wrenches]) for k, f in enumerate(load)]
        wrong = [size(combine(row, rest)) for row in L]
        error = [
            [size(combine(row, w) - int(i == j)) for j, w in enumerate(wrenches)] for i, row in enumerate(L)
        ]
        bound = contained(wrong, error)
        return None if bound is None else ([centre(v) for v in t], bound)

    def has_one_zero_at_most(self, lo: Sequence[float], hi: Sequence[float]) -> bool:
        """Return True when a box of (u, x) holds at most one zero, whatever its tensions.

        Two zeros z, z' in a box have |z - z'| <= |C J - I| |z - z'| with J the derivatives over the box.
        """
        middle = [(rational(a) + rational(b)) / 2 for a, b in zip(lo, hi, strict=True)]
        radius = [(rational(b) - rational(a)) / 2 for a, b in zip(lo, hi, strict=True)]
        tensions = self.tensions(middle, radius) if self.balanced else ([ZERO] * 6, [ZERO] * 6)
        if tensions is None:
            return False
        z = self.around([*middle, *tensions[0]], [*radius, *tensions[1]])
        return self.deviation(self.equations(z)) is not None

    def deviation(self, equations: Vector) -> list[list[fmpq]] | None:
        """Return |C J - I| over the box where its spectral radius is below 1, C being a float inverse."""
        J = self.changes(equations)
        inverse = guess.inverse([[number(centre(v)) for v in row] for row in J])
        if inverse is None:
            return None
        C = [[rational(v) for v in row] for row in inverse]
        error = [
            [size(combine(row, column) - int(i == j)) for j, column in enumerate(zip(*J, strict=True))]
            for i, row in enumerate(C)
        ]
        return error if contained([ZERO] * len(C), error) is not None else None

    def zero_near(self, lo: Sequence[float], hi: Sequence[float]) -> Zero | None:
        """Return tight bounds of a zero, found by Newton from a box's middle and proved by Krawczyk."""
        n = self.platform.taut
        z = [(rational(a) + rational(b)) / 2 for a, b in zip(lo, hi, strict=True)]
        start = self.tensions(z, [ZERO] * 6)
        if start is None:
            return None
        z += start[0] if self.balanced else [ZERO] * n
        places = [self.symbols.index(k) for k in self.unknowns]
        for _ in range(STEPS):
            unit = [fmpq(int(k in self.unknowns)) for k in self.symbols]
            J = [[number(v) for v in slopes(f, self.unknowns)] for f in self.equations(self.around(z, unit))]
            inverse = guess.inverse(J)
            if inverse is None:
                return None
            C = [[rational(v) for v in row] for row in inverse]
            wrong = self.equations(self.around(z, [ZERO] * len(z)))
            step = [centre(combine(row, wrong)) for row in C]
            if max(map(abs, step)) < SMALL:
                return self.proved(z, places, C, [size(combine(row, wrong)) for row in C])
            for k, s in zip(places, step, strict=True):
                z[k] = fmpq(((z[k] - s) * GRID).round(), GRID)
        return None

    def proved(self, z: Numbers, places: list[int], C: list[Numbers], wrong: Numbers) -> Zero | None:
        """Return bounds around z in which there is exactly one zero for every choice of the data, or None."""
        reach = [2 * w + SMALL for w in wrong]
        for _ in range(WIDENINGS):
            radius = [ZERO] * len(z)
            for k, r in zip(places, reach, strict=True):
                radius[k] = r
            J = self.changes(self.equations(self.around(z, radius)))
            image = []
            for i, row in enumerate(C):
                columns = enumerate(zip(*J, strict=True))
                image.append(
                    wrong[i] + total_size([combine(row, c) - int(i == j) * reach[j] for j, c in columns])
                )
            if all(new < old for new, old in zip(image, reach, strict=True)):
                for k, r in zip(places, image, strict=True):
                    radius[k] = r
                return self.completed(Zero(z, radius))
            reach = [2 * new for new in image]
        return None

    def completed(self, zero: Zero) -> Zero | None:
        """Fill in the tensions of six cables."""
        if self.balanced:
            return zero
        tensions = self.tensions(zero.middle, zero.radius)
        if tensions is None:
            return None
        return Zero([*zero.middle[:6], *tensions[0]], [*zero.radius[:6], *tensions[1]])


def total_size(forms: Vector) -> fmpq:
    """Return a bound of a sum of absolute values."""
    return sum(map(size, forms), ZERO)
