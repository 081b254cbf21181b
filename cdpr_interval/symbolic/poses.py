"""From a root of an eliminant back to poses: the other unknowns, and the proof that they solve the system."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flint import acb, acb_mat, acb_poly, arb, ctx, fmpq

from cdpr_interval.symbolic.curves import Numbers, conditions, line, matrices
from cdpr_interval.symbolic.elimination import Curve
from cdpr_interval.symbolic.statics import Statics

BITS = 640
"""Working precision: polynomials of degree 80 lose some hundred bits."""
SMALL = arb(2) ** -80
"""A value this small, relative to the sum of its terms' sizes, is taken for zero: candidates only."""
WIDTH = arb(2) ** -200
"""Relative radius of the box in which a zero is proved."""
TIGHT = arb(2) ** -240
"""Width to which roots are refined."""
PARTING = arb(2) ** -400
"""Relative change of coefficients that parts multiple roots: double ones by 2^-200, triple ones by 2^-133."""
STEPS = 8
"""Newton steps; each doubles some twenty digits at least."""


@dataclass(frozen=True)
class Solution:
    """A proved zero of the system in complex balls: C (base frame) and rho_i in m, tensions in N."""

    centre: list[acb]
    distances: list[acb]
    tensions: list[acb]

    @property
    def is_real(self) -> bool:
        """True when the zero is real.

        Its conjugate is a zero too; where every entry may be real both lie in the box in which there is one.
        """
        return all(v.imag.contains(0) for v in [*self.centre, *self.distances])

    @property
    def is_static(self) -> bool:
        """True when it is real with positive distances and tensions: a pose that the cables can hold."""
        return self.is_real and all(v.real > 0 for v in [*self.distances, *self.tensions])


def solutions_at(statics: Statics, curves: Sequence[Curve], root: acb) -> list[Solution]:
    """Return all proved zeros of a system whose rho_1 is a root of its eliminant."""
    with ctx.workprec(BITS):
        found: list[Solution] = []
        for start in candidates(statics, curves, acb(root.real.mid(), root.imag.mid())):
            proved = zero_near(statics, start)
            if proved is None or not proved.distances[0].overlaps(root):
                continue
            if not any(same(proved, other) for other in found):
                found.append(proved)
        return found


def same(a: Solution, b: Solution) -> bool:
    """Return True when two zeros may be one."""
    return all(x.overlaps(y) for x, y in zip(a.centre + a.distances, b.centre + b.distances, strict=True))


def candidates(statics: Statics, curves: Sequence[Curve], r1: acb) -> list[list[acb]]:
    """Return C and rho near all zeros of a system with a given rho_1."""
    if statics.count == 1:
        return filled(statics, [statics_w(statics, 0, r1)], [r1])
    numbers = Numbers.of(statics, acb)
    first, second = (along(numbers, curve, r1) for curve in curves[:2])
    found = []
    for r2 in simple_roots(second):
        if is_zero(first, r2):
            for w in weights(numbers, r1, r2):
                found += filled(statics, w, [r1, r2])
    return found


def statics_w(statics: Statics, i: int, rho: acb) -> acb:
    """Return w_i at a distance."""
    return acb(statics.u[i]) - acb(statics.v[i]) / rho


def along(numbers: Numbers, curve: Curve, r1: acb) -> list[acb]:
    """Return the coefficients, in rho_2, of a curve at a given rho_1 (by its values at roots of unity)."""
    count = curve.degrees[1] + 1
    places = [acb(fmpq(2 * k, count)).exp_pi_i() for k in range(count)]
    values = []
    for r2 in places:
        found = line(numbers, r1, r2)
        value = acb_mat(matrices(conditions(numbers, found, r1, r2))[curve.index]).det()
        for factor, power in zip((r1, r2, *found.divisors), curve.powers, strict=True):
            value /= factor**power
        values.append(value)
    return [
        sum((v * p ** (-k) for v, p in zip(values, places, strict=True)), acb(0)) / count
        for k in range(count)
    ]


def simple_roots(coefficients: Sequence[acb]) -> list[acb]:
    """Return numbers near the roots of a polynomial near one with these coefficients.

    Multiple roots cannot be isolated: there the coefficients are moved a little, which parts them.
    """
    middles = [acb(c.real.mid(), c.imag.mid()) for c in coefficients]
    for noise in (arb(0), PARTING):
        try:
            return list(acb_poly([c + c * noise / (k + 1) for k, c in enumerate(middles)]).roots(TIGHT))
        except ValueError:
            continue
    return []


def is_zero(coefficients: Sequence[acb], x: acb) -> bool:
    """Return True when a polynomial is small at x."""
    terms = [c * x**k for k, c in enumerate(coefficients)]
    return bool(abs(sum(terms, acb(0))).mid() < SMALL * sum((abs(t) for t in terms), arb(0)).mid())


def weights(numbers: Numbers, r1: acb, r2: acb) -> list[list[acb]]:
    """Return w_1..w_n for given rho_1, rho_2: of four cables for each rho_3 that fits."""
    found = line(numbers, r1, r2)
    thirds = [acb(0)]
    if len(numbers.pulls) == 4:
        a1, a2, a3 = conditions(numbers, found, r1, r2)
        thirds = [r for r in simple_roots(a1) if is_zero(a2, r) and is_zero(a3, r)]
    first = numbers.u[0] - numbers.v[0] / r1
    return [[first, *(at(w, r) / at(found.scale, r) for w in found.w)] for r in thirds]


def at(coefficients: Sequence[Any], x: acb) -> acb:
    """Return a polynomial's value."""
    return sum((c * x**k for k, c in enumerate(coefficients)), acb(0))


def filled(statics: Statics, w: Sequence[acb], known: Sequence[acb]) -> list[list[acb]]:
    """Return C and all rho from the w and the first rho; nothing where they are not finite."""
    total = sum(w, acb(0))
    pull = [
        acb(f) + sum((x * acb(a[k]) for x, a in zip(w, statics.arms(), strict=True)), acb(0))
        for k, f in enumerate(statics.load)
    ]
    centre = [acb(a) + m / total for a, m in zip(statics.exits[0], pull, strict=True)]
    others = [acb(statics.v[i]) / (acb(statics.u[i]) - w[i]) for i in range(len(known), statics.count)]
    found = [acb(v.real.mid(), v.imag.mid()) for v in [*centre, *known, *others]]
    return [found] if all(v.is_finite() for v in found) else []


def equations(statics: Statics, x: Sequence[acb]) -> tuple[acb_mat, acb_mat]:
    """Return |C - A_i|^2 - rho_i^2 and the balance at (or over) x = (C, rho), and their derivatives."""
    n = statics.count
    centre, rho = x[:3], x[3:]
    spokes = [[c - acb(v) for c, v in zip(centre, a, strict=True)] for a in statics.exits]
    w = [statics_w(statics, i, rho[i]) for i in range(n)]
    values = [sum((v * v for v in e), acb(0)) - r * r for e, r in zip(spokes, rho, strict=True)]
    slopes = [
        [2 * v for v in e] + [-2 * rho[i] if i == j else acb(0) for j in range(n)]
        for i, e in enumerate(spokes)
    ]
    total = sum(w, acb(0))
    for k in range(3):
        values.append(sum((v * e[k] for v, e in zip(w, spokes, strict=True)), acb(0)) - acb(statics.load[k]))
        pulls = [acb(statics.v[i]) / (rho[i] * rho[i]) * spokes[i][k] for i in range(n)]
        slopes.append([total if j == k else acb(0) for j in range(3)] + pulls)
    return acb_mat([[v] for v in values]), acb_mat(slopes)


def zero_near(statics: Statics, start: Sequence[acb]) -> Solution | None:
    """Return a zero near a start, proved by a Krawczyk operator; None where that fails."""
    x, n = acb_mat([[v] for v in start]), len(start)
    try:
        for _ in range(STEPS):
            value, slope = equations(statics, x.entries())
            x = middle(x - middle(slope).solve(middle(value)))
        value, slope = equations(statics, x.entries())
        inverse = middle(middle(slope).inv())
        reach = [(1 + abs(v)) * WIDTH for v in x.entries()]
        around = acb_mat([[acb(r.union(-r), r.union(-r))] for r in reach])
        change = equations(statics, (x + around).entries())[1]
    except ZeroDivisionError:
        return None
    unity = acb_mat([[int(i == j) for j in range(n)] for i in range(n)])
    moved = (unity - inverse * change) * around - inverse * value
    inside = all(abs(m.real) < r and abs(m.imag) < r for m, r in zip(moved.entries(), reach, strict=True))
    if not inside:
        return None
    found = (x + moved).entries()
    tensions = [statics_w(statics, i, rho) * rho for i, rho in enumerate(found[3:])]
    return Solution(found[:3], found[3:], tensions)


def middle(m: acb_mat) -> acb_mat:
    """Return the middles of a matrix."""
    return acb_mat(m.nrows(), m.ncols(), [acb(v.real.mid(), v.imag.mid()) for v in m.entries()])
