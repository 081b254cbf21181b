"""Many numbers modulo one prime at once, and the linear algebra that elimination needs of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from flint import fmpq, fmpz
from numpy.typing import NDArray

Integers = NDArray[np.int64]
LARGEST_PRIME = 2**31 - 1
"""Products of two residues stay below 2^62: they fit 64 bits with sign."""


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


class Residues:
    """An array of numbers modulo a prime with the operations of a ring."""

    __slots__ = ("prime", "values")

    def __init__(self, values: Integers, prime: int) -> None:
        self.values, self.prime = values, prime

    def __add__(self, other: Residues | int) -> Residues:
        return Residues((self.values + plain(other)) % self.prime, self.prime)

    def __sub__(self, other: Residues | int) -> Residues:
        return Residues((self.values - plain(other)) % self.prime, self.prime)

    def __rsub__(self, other: int) -> Residues:
        return Residues((other - self.values) % self.prime, self.prime)

    def __mul__(self, other: Residues | int) -> Residues:
        return Residues(self.values * plain(other) % self.prime, self.prime)

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> Residues:
        return Residues(-self.values % self.prime, self.prime)

    def __pow__(self, exponent: int) -> Residues:
        found, square = Residues(np.ones_like(self.values), self.prime), self
        while exponent:
            if exponent & 1:
                found = found * square
            square, exponent = square * square, exponent >> 1
        return found

    def inverse(self) -> Residues:
        """Return 1 / self (Fermat); 0 where the number is 0."""
        return self ** (self.prime - 2)


def plain(x: Residues | int) -> Integers | int:
    """Return the numbers of residues; an integer must lie within 2^31 of 0."""
    return x.values if isinstance(x, Residues) else x


def determinant(rows: Sequence[Sequence[Residues | int]], prime: int) -> Residues:
    """Return the determinants of many matrices: one for each place of the entries' arrays."""
    n = len(rows)
    entries = np.broadcast_arrays(*[np.asarray(plain(x), dtype=np.int64) for row in rows for x in row])
    left = np.array(entries).reshape((n, n, *entries[0].shape)) % prime
    found = np.ones_like(left[0, 0])
    for k in range(n):
        for i in range(k + 1, n):
            swapped = (left[k, k] == 0) & (left[i, k] != 0)
            if swapped.any():
                upper = left[k][:, swapped]
                left[k][:, swapped] = left[i][:, swapped]
                left[i][:, swapped] = -upper % prime
        found = found * left[k, k] % prime
        inverse = Residues(left[k, k], prime).inverse().values
        for i in range(k + 1, n):
            left[i, k:] = (left[i, k:] - left[i, k] * inverse % prime * left[k, k:]) % prime
    return Residues(found, prime)


def interpolated(start: int, values: Integers, prime: int) -> Integers:
    """Return coefficients (n, ...) of polynomials with values (n, ...) at start, start + 1, ... (Newton)."""
    c = values % prime
    n = len(c)
    for k in range(1, n):
        c[k:] = (c[k:] - c[k - 1 : -1]) % prime * pow(k, -1, prime) % prime
    found = np.zeros_like(c)
    for k in range(n - 1, -1, -1):
        place = (start + k) % prime
        found[1:], found[0] = (found[:-1] - place * found[1:]) % prime, (c[k] - place * found[0]) % prime
    return found
