"""Rational numbers modulo primes."""

from __future__ import annotations

from flint import fmpq, fmpz

LARGEST_PRIME = 2**31 - 1
"""Products of two residues stay below 2^62, which suits every processor."""


def primes(count: int, below: int = LARGEST_PRIME + 1) -> list[int]:
    """Return the largest primes below a bound, the largest first."""
    found: list[int] = []
    candidate = below - 1
    while len(found) < count:
        if fmpz(candidate).is_prime():
            found.append(candidate)
        candidate -= 1
    return found


def residue(x: fmpq, prime: int) -> int:
    """Return a rational number modulo a prime; raise `ZeroDivisionError` where it divides the denominator."""
    if int(x.q) % prime == 0:
        raise ZeroDivisionError
    return int(x.p) * pow(int(x.q), -1, prime) % prime
