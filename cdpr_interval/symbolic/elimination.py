"""Eliminants modulo one prime: evaluate plane curves on a grid, take resultants, interpolate.

The eliminant G of two curves is their resultant by rho_2. Its roots contain rho_1 of every static pose, and
others: a second eliminant H, of other curves, tells most of them apart.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import nmod_poly

from cdpr_interval.symbolic.curves import Numbers, conditions, line, matrices
from cdpr_interval.symbolic.residues import Integers, Residues, determinant, interpolated, residue
from cdpr_interval.symbolic.statics import Statics

SEED = 20261123
"""Of the places where curves are evaluated; the polynomials do not depend on them."""
HIGHEST = 90
"""Larger than the degree of every curve in each unknown."""


class Vanishes(Exception):
    """An eliminant is identically zero: it says nothing about the poses."""


@dataclass(frozen=True)
class Curve:
    """One curve: which it is, the powers of known factors in it, and its degrees without them."""

    index: int
    powers: tuple[int, ...]
    """Of rho_1, rho_2 and the line's divisors."""
    degrees: tuple[int, int]
    """In rho_1 and rho_2."""


class Grid:
    """A system's curves modulo a prime at all pairs of some rho_1 and rho_2, each a run of integers."""

    def __init__(
        self, statics: Statics, prime: int, shape: tuple[int, int], generator: random.Random
    ) -> None:
        numbers = Numbers.of(statics, lambda x: Residues(np.array(residue(x, prime)), prime))
        self.prime = prime
        while True:
            self.starts = [generator.randrange(1, prime - count) for count in shape]
            runs = [start + np.arange(count) for start, count in zip(self.starts, shape, strict=True)]
            r1, r2 = Residues(runs[0][:, None], prime), Residues(runs[1][None, :], prime)
            found = line(numbers, r1, r2)
            self.factors = [r1, r2, *found.divisors]
            if all(factor.values.all() for factor in self.factors):
                break
        self.inverses = [factor.inverse() for factor in self.factors]
        self.matrices = matrices(conditions(numbers, found, r1, r2))

    def values(self, index: int, powers: Sequence[int]) -> Residues:
        """Return a curve's values, divided by powers of the known factors."""
        found = determinant(self.matrices[index], self.prime)
        for inverse, power in zip(self.inverses, powers, strict=False):
            found = found * inverse**power
        return found

    def degrees(self, values: Residues) -> tuple[int, int]:
        """Return a curve's degrees in rho_1 and rho_2."""
        v = values.values
        return degree(v[:, :3], self.prime), degree(v[:3].T, self.prime)


def degree(values: Integers, prime: int) -> int:
    """Return the largest degree of the polynomials with values (n, ...) at n places; -1: all are 0."""
    found = interpolated(0, values, prime).reshape(len(values), -1)
    return max((k for k in range(len(found)) if found[k].any()), default=-1)


def survey(statics: Statics, prime: int) -> list[Curve]:
    """Return a system's curves with their degrees; raise `Vanishes` where one is zero."""
    grid = Grid(statics, prime, (HIGHEST, HIGHEST), random.Random(SEED))
    found = []
    for index in range(len(grid.matrices)):
        powers, values = [0] * len(grid.inverses), grid.values(index, ())
        now = grid.degrees(values)
        if min(now) < 0:
            raise Vanishes("a condition vanishes identically")
        for k, inverse in enumerate(grid.inverses):
            while True:
                divided = values * inverse
                lower = grid.degrees(divided)
                if not (max(lower) < HIGHEST - 1 and sum(lower) < sum(now)):
                    break
                powers[k], values, now = powers[k] + 1, divided, lower
        found.append(Curve(index, tuple(powers), now))
    return found


def resultant(statics: Statics, curves: Sequence[Curve], prime: int) -> nmod_poly:
    """Return the resultant of two curves by rho_2, a polynomial in rho_1."""
    (a1, a2), (b1, b2) = (curve.degrees for curve in curves)
    count = a1 * b2 + b1 * a2 + 1
    grid = Grid(statics, prime, (count, max(a2, b2) + 1), random.Random(SEED))
    coefficients = [
        interpolated(grid.starts[1], grid.values(curve.index, curve.powers).values.T, prime).T.tolist()
        for curve in curves
    ]
    found = []
    for a, b in zip(*coefficients, strict=True):
        left, right = nmod_poly(a, prime), nmod_poly(b, prime)
        # A degree that drops takes a factor out of the resultant: it is put back.
        value = int(left.resultant(right))
        if left.degree() < a2 and right.degree() < b2:
            value = 0
        elif left.degree() < a2:
            value = (
                value * pow(int(right[b2]), a2 - left.degree(), prime) * (-1) ** (b2 * (a2 - left.degree()))
            )
        elif right.degree() < b2:
            value = value * pow(int(left[a2]), b2 - right.degree(), prime)
        found.append(value % prime)
    polynomial = nmod_poly(interpolated(grid.starts[0], np.array(found), prime).tolist(), prime)
    if polynomial.degree() < 0:
        raise Vanishes("the eliminant vanishes identically")
    return polynomial
