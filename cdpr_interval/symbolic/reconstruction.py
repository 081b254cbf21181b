"""Polynomials over the rationals from their images modulo primes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from math import gcd, isqrt

from flint import fmpz_poly, nmod_poly

from cdpr_interval.symbolic.residues import primes

MOST_PRIMES = 4000
"""Of 31 bits each: coefficients of 60 000 bits."""
GROWTH = 1.3
"""Primes at a trial over those at the trial before."""
FURTHER_CHECKS = 2
"""Primes that a polynomial is compared with after the one that ended the search."""


class NotReconstructed(Exception):
    """No polynomial fits the images modulo all primes that were tried."""


def reconstructed(image: Callable[[int], nmod_poly], most_primes: int = MOST_PRIMES) -> fmpz_poly:
    """Return the primitive integer polynomial with given images modulo primes, up to constants.

    Images of another degree than most of the first ones come from unlucky primes and are left out, as are
    primes at which ``image`` divides by zero. A polynomial is accepted when it has the right image modulo
    further primes, which were not used to find it.
    """
    source = iter(primes(most_primes))
    seen: list[tuple[int, nmod_poly]] = []
    goal = 2
    while True:
        while len(seen) < goal:
            prime = next(source, None)
            if prime is None:
                raise NotReconstructed(f"{len(seen)} primes are not enough")
            try:
                found = image(prime)
            except ZeroDivisionError:
                continue
            seen.append((prime, found * pow(int(found[found.degree()]), -1, prime)))
        degree = Counter(f.degree() for _, f in seen).most_common(1)[0][0]
        lucky = [(p, f) for p, f in seen if f.degree() == degree]
        found = rational([(p, [int(c) for c in f.coeffs()]) for p, f in lucky[: -1 - FURTHER_CHECKS]])
        if found is not None and all(agrees(found, p, f) for p, f in lucky):
            return found
        goal = int(GROWTH * goal) + 1 + FURTHER_CHECKS


def agrees(found: fmpz_poly, prime: int, image: nmod_poly) -> bool:
    """Return True when a polynomial has an image up to a constant."""
    reduced = nmod_poly([int(c) % prime for c in found.coeffs()], prime)
    return reduced.degree() == image.degree() and bool(reduced == image * int(reduced[reduced.degree()]))


def rational(images: Sequence[tuple[int, list[int]]]) -> fmpz_poly | None:
    """Return an integer polynomial whose monic images these may be, or None."""
    if not images:
        return None
    modulus, residues = chinese(images)
    denominator = 1
    numerators: list[int] = []
    for c in residues:
        fraction = nearest_fraction(c * denominator % modulus, modulus)
        if fraction is None:
            return None
        numerator, factor = fraction
        numerators = [v * factor for v in numerators] + [numerator]
        denominator *= factor
    common = gcd(*numerators)
    return fmpz_poly([v // common for v in numerators])


def chinese(images: Sequence[tuple[int, list[int]]]) -> tuple[int, list[int]]:
    """Return the numbers with given residues modulo all primes, and the primes' product (by halves)."""
    if len(images) == 1:
        return images[0]
    middle = len(images) // 2
    (p, a), (q, b) = chinese(images[:middle]), chinese(images[middle:])
    inverse = pow(p, -1, q)
    return p * q, [x + p * ((y - x) * inverse % q) for x, y in zip(a, b, strict=True)]


def nearest_fraction(residue: int, modulus: int) -> tuple[int, int] | None:
    """Return small n, d > 0 with n = residue d (mod modulus), or None (Wang, Guy, Davenport 1982)."""
    bound = isqrt(modulus // 2)
    r, s, t, u = modulus, residue, 0, 1
    while s > bound:
        quotient = r // s
        r, s, t, u = s, r - quotient * s, u, t - quotient * u
    if not 0 < abs(u) <= bound or gcd(s, u) != 1:
        return None
    return (s, u) if u > 0 else (-s, -u)
