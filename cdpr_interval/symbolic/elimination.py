"""Eliminants modulo one prime: the plane curves as polynomials, and their resultants.

The eliminant G of two curves is their resultant by rho_2. Its roots contain rho_1 of every static pose, and
others: a second eliminant H, of other curves, tells most of them apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import Ordering, fmpq, nmod_mpoly, nmod_mpoly_ctx, nmod_poly

from cdpr_interval.symbolic.curves import Numbers, Polynomial, conditions, line, matrices
from cdpr_interval.symbolic.residues import residue
from cdpr_interval.symbolic.statics import Statics


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


def ring(prime: int) -> nmod_mpoly_ctx:
    """Return the ring of the curves: polynomials in rho_1 and rho_2 modulo a prime."""
    return nmod_mpoly_ctx.get(("rho_1", "rho_2"), prime, Ordering.lex)


def conditions_modulo(statics: Statics, prime: int) -> tuple[list[Polynomial], list[nmod_mpoly]]:
    """Return S and the D_i as polynomials in rho_3, and the known factors of their curves."""
    known = ring(prime)
    r1, r2 = known.gens()

    def convert(x: fmpq) -> nmod_mpoly:
        return known.constant(residue(x, prime))

    numbers = Numbers.of(statics, convert)
    found = line(numbers, r1, r2)
    return conditions(numbers, found, r1, r2), [r1, r2, *found.divisors]


def determinant(rows: Sequence[Sequence[nmod_mpoly | int]]) -> nmod_mpoly | int:
    """Return a determinant by its first row: matrices of up to six rows with many zeros."""
    if len(rows) == 1:
        return rows[0][0]
    found: nmod_mpoly | int = 0
    for k, entry in enumerate(rows[0]):
        if entry != 0:
            minor = entry * determinant([[*row[:k], *row[k + 1 :]] for row in rows[1:]])
            found = found - minor if k % 2 else found + minor
    return found


class Curves:
    """A system's curves modulo a prime, each computed when it is asked for."""

    def __init__(self, statics: Statics, prime: int) -> None:
        found, self.factors = conditions_modulo(statics, prime)
        self._matrices = matrices(found)
        self._curves: dict[int, nmod_mpoly] = {}
        self._zero = ring(prime).constant(0)

    def __len__(self) -> int:
        return len(self._matrices)

    def whole(self, index: int) -> nmod_mpoly:
        """Return a curve with its known factors."""
        if index not in self._curves:
            self._curves[index] = self._zero + determinant(self._matrices[index])
        return self._curves[index]

    def divided(self, curve: Curve) -> nmod_mpoly:
        """Return a curve without its known factors; raise `ZeroDivisionError` where this prime has others."""
        found = self.whole(curve.index)
        for factor, power in zip(self.factors, curve.powers, strict=True):
            found, rest = divmod(found, factor**power)
            if rest != 0:
                raise ZeroDivisionError
        return found


def survey(statics: Statics, prime: int) -> list[Curve]:
    """Return a system's curves with their degrees; raise `Vanishes` where one is zero."""
    curves = Curves(statics, prime)
    found = []
    for index in range(len(curves)):
        polynomial = curves.whole(index)
        if polynomial == 0:
            raise Vanishes("a condition vanishes identically")
        powers = []
        for factor in curves.factors:
            power = 0
            while factor.total_degree() > 0:
                quotient, rest = divmod(polynomial, factor)
                if rest != 0:
                    break
                polynomial, power = quotient, power + 1
            powers.append(power)
        found.append(Curve(index, tuple(powers), polynomial.degrees()))
    return found


def resultant(statics: Statics, curves: Sequence[Curve], prime: int) -> nmod_poly:
    """Return the resultant of two curves by rho_2, a polynomial in rho_1."""
    modulo = Curves(statics, prime)
    left, right = (modulo.divided(curve) for curve in curves)
    found = left.resultant(right, "rho_2")
    if found == 0:
        raise Vanishes("the eliminant vanishes identically")
    coefficients = [0] * (found.degrees()[0] + 1)
    for (power, _), value in found.to_dict().items():
        coefficients[power] = int(value)
    return nmod_poly(coefficients, prime)
