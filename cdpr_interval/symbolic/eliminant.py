"""The exact eliminant of a point mass's static poses in rho_1: its factors, and which of them hold poses.

All poses' rho_1 are roots of G = Res(P_1, P_2; rho_2) and, of three cables or more, of a second eliminant
H. What G and H have in common, each factor once, is computed over the rationals and factored there. A
factor is irreducible, so either every root of it belongs to a zero of the system or none does; a zero
proved over one of its roots decides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

from flint import acb, ctx, fmpq, fmpq_poly, fmpz_poly, nmod_poly

from cdpr_interval.symbolic.elimination import Curve, Vanishes, resultant, survey
from cdpr_interval.symbolic.poses import BITS, Solution, solutions_at
from cdpr_interval.symbolic.reconstruction import reconstructed
from cdpr_interval.symbolic.residues import primes
from cdpr_interval.symbolic.statics import Statics, dot

MOST_CABLES = 4
TRIED_ROOTS = 3
"""Roots of a factor over which zeros are looked for before it is called extraneous."""


@dataclass(frozen=True)
class Factor:
    """An irreducible factor over Q, a primitive polynomial in rho_1 (m)."""

    polynomial: fmpz_poly
    is_true: bool
    """Its roots belong to zeros of the system."""
    reason: str

    @property
    def degree(self) -> int:
        """Degree in rho_1."""
        return int(self.polynomial.degree())


@dataclass(frozen=True)
class Eliminant:
    """The elimination of one system."""

    statics: Statics
    prime: int
    """Modulo which the degrees and multiplicities of G were found."""
    curves: list[Curve]
    multiplicities: dict[int, int]
    """Degree of the product of G's factors of each multiplicity."""
    refuted: dict[int, int]
    """The same of the factors of G that H does not have: they are extraneous."""
    factors: list[Factor]

    @property
    def true_degree(self) -> int:
        """Number of complex solutions of the system, each counted by its rho_1."""
        return sum(factor.degree for factor in self.factors if factor.is_true)

    @cached_property
    def real_solutions(self) -> list[tuple[acb, list[Solution]]]:
        """The real roots of the true factors, ascending, each with the real zeros that are proved over it."""
        found = []
        with ctx.workprec(BITS):
            for factor in self.factors:
                for root, _ in factor.polynomial.complex_roots() if factor.is_true else []:
                    if root.imag.is_zero():
                        zeros = solutions_at(self.statics, self.curves, root)
                        found.append((root, [zero for zero in zeros if zero.is_real]))
            return sorted(found, key=lambda pair: float(pair[0].real))


def eliminant(statics: Statics) -> Eliminant:
    """Return the exact eliminant of 1 to 4 cables; raise `Vanishes` where the data do not allow one."""
    if not 1 <= statics.count <= MOST_CABLES:
        raise ValueError(f"1 to {MOST_CABLES} cables, not {statics.count}")
    require_independent(statics)
    (prime,) = primes(1)
    if statics.count == 1:
        found = single(statics)
        curves: list[Curve] = []
        whole = both = nmod_poly([int(c) % prime for c in found.coeffs()], prime)
    else:
        curves, common = survey(statics, prime), shared(statics, prime)
        whole, both = resultant(statics, curves[:2], prime), common(prime)
        found = reconstructed(lambda p: squarefree(common(p)))
    factors = [judged(statics, curves, f) for f, _ in found.factor()[1] if f.degree() > 0]
    factors.sort(key=lambda factor: (not factor.is_true, -factor.degree))
    return Eliminant(statics, prime, curves, multiplicities(whole), refuted(whole, both), factors)


def require_independent(statics: Statics) -> None:
    """Raise `Vanishes` where exit points coincide, or all lie on one line along the load."""
    arms = statics.arms()
    for i, a in enumerate(arms):
        if any(a == b for b in arms[:i]):
            raise Vanishes("two exit points coincide: the eliminant vanishes identically")
    load = dot(statics.load, statics.load)
    if load == 0:
        raise Vanishes("without a load every pose with slack cables is static")


def single(statics: Statics) -> fmpz_poly:
    """Return the eliminant of one cable: its tension is the load's size, (u rho - v)^2 = |f|^2."""
    u, v = statics.u[0], statics.v[0]
    found = fmpq_poly([v * v - dot(statics.load, statics.load), -2 * u * v, u * u])
    if found.degree() < 1:
        raise Vanishes("one cable with a given tension: its length is free, or there is no pose")
    return found.numer()


def shared(statics: Statics, prime: int) -> Callable[[int], nmod_poly]:
    """Return what gives the common factor of G and H modulo a prime (of two cables: G)."""
    curves = survey(statics, prime)
    if statics.count == 2:
        return lambda p: resultant(statics, curves, p)
    if statics.count == 3:
        swapped = statics.reordered([0, 2, 1])
        others = survey(swapped, prime)
        return lambda p: resultant(statics, curves, p).gcd(resultant(swapped, others, p))
    return lambda p: resultant(statics, curves[:2], p).gcd(resultant(statics, curves[1:3], p))


def multiplicities(f: nmod_poly) -> dict[int, int]:
    """Return the degrees of the products of all factors of each multiplicity."""
    found: dict[int, int] = {}
    for factor, multiplicity in f.factor_squarefree()[1]:
        found[multiplicity] = found.get(multiplicity, 0) + int(factor.degree())
    return found


def refuted(whole: nmod_poly, common: nmod_poly) -> dict[int, int]:
    """Return the degrees, by multiplicity, of the factors that are not in a common factor."""
    found: dict[int, int] = {}
    for factor, multiplicity in whole.factor_squarefree()[1]:
        degree = int(factor.degree() - factor.gcd(common).degree())
        if degree:
            found[multiplicity] = found.get(multiplicity, 0) + degree
    return found


def part(f: nmod_poly, multiplicity: int) -> nmod_poly:
    """Return the product of all factors of one multiplicity."""
    found = nmod_poly([1], f.modulus())
    for factor, m in f.factor_squarefree()[1]:
        if m == multiplicity:
            found *= factor
    return found


def squarefree(f: nmod_poly) -> nmod_poly:
    """Return the product of all factors, each once."""
    return f // f.gcd(f.derivative())


def judged(statics: Statics, curves: Sequence[Curve], polynomial: fmpz_poly) -> Factor:
    """Decide whether an irreducible factor is true."""
    with ctx.workprec(BITS):
        for root, _ in polynomial.complex_roots()[:TRIED_ROOTS]:
            if solutions_at(statics, curves, root):
                return Factor(polynomial, True, "a zero of the system is proved over one of its roots")
    tried = min(TRIED_ROOTS, int(polynomial.degree()))
    return Factor(polynomial, False, f"no zero of the system was found over {tried} of its roots")


def part_over_rationals(statics: Statics, multiplicity: int, pair: Sequence[int] = (0, 1)) -> fmpz_poly:
    """Return the product of the factors of one multiplicity of two curves' eliminant, over Q, true or not."""
    (prime,) = primes(1)
    found = survey(statics, prime)
    curves = [found[k] for k in pair]
    return reconstructed(lambda p: part(resultant(statics, curves, p), multiplicity))


def exact(values: Sequence[object]) -> list[fmpq]:
    """Return exact numbers from fractions or integers."""
    return [fmpq(*value.as_integer_ratio()) for value in values]  # type: ignore[attr-defined]
