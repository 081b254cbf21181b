"""Numbers with square roots, exactly: rationals, the root of 3, and up to a few roots of such numbers.

Whether such a number is 0 is decided, not guessed: by its product with all its conjugates, which has no roots
left but that of 3, and by balls that tell it from its conjugates.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import prod

from flint import arb, ctx

from cdpr_interval.exact.balls import from_fraction

PRECISIONS = (128, 512, 2048)
"""Bits with which a number is looked at before its conjugates are, and at most."""


@dataclass(frozen=True)
class Root3:
    """a + b sqrt(3)."""

    a: Fraction
    b: Fraction = Fraction(0)

    def __add__(self, other: Root3) -> Root3:
        return Root3(self.a + other.a, self.b + other.b)

    def __sub__(self, other: Root3) -> Root3:
        return Root3(self.a - other.a, self.b - other.b)

    def __neg__(self) -> Root3:
        return Root3(-self.a, -self.b)

    def __mul__(self, other: Root3) -> Root3:
        return Root3(self.a * other.a + 3 * self.b * other.b, self.a * other.b + self.b * other.a)

    def inverse(self) -> Root3:
        """Return 1 / self; `ZeroDivisionError` for 0."""
        norm = self.a**2 - 3 * self.b**2
        return Root3(self.a / norm, -self.b / norm)

    def __bool__(self) -> bool:
        return bool(self.a or self.b)

    @property
    def sign(self) -> int:
        """-1, 0 or 1."""
        a, b = self.a, self.b
        if (a >= 0) == (b >= 0) or not a or not b:
            return (a > 0 or b > 0) - (a < 0 or b < 0)
        larger = a**2 > 3 * b**2
        return (1 if a > 0 else -1) if larger else (1 if b > 0 else -1)

    def root(self) -> Root3 | None:
        """Return the square root that is not negative if it is such a number, too."""
        if not self.b and (found := rational_root(self.a)) is not None:
            return Root3(found)
        if not self.b and (found := rational_root(self.a / 3)) is not None:
            return Root3(Fraction(0), found)
        # (p + q sqrt 3)^2 = p^2 + 3 q^2 + 2 p q sqrt 3: p^2 is a root of t^2 - a t + 3 b^2 / 4.
        middle = rational_root(self.a**2 - 3 * self.b**2)
        for square in () if middle is None else ((self.a + middle) / 2, (self.a - middle) / 2):
            p = rational_root(square)
            if p:
                found_root = Root3(p, self.b / (2 * p))
                return found_root if found_root.sign >= 0 else -found_root
        return None

    def ball(self) -> arb:
        """Enclose it."""
        return from_fraction(self.a) + from_fraction(self.b) * arb(3).sqrt()


ZERO, ONE = Root3(Fraction(0)), Root3(Fraction(1))


def rational_root(x: Fraction) -> Fraction | None:
    """Return the square root of a rational if it is rational."""
    if x < 0:
        return None
    top, bottom = math.isqrt(x.numerator), math.isqrt(x.denominator)
    return Fraction(top, bottom) if top**2 == x.numerator and bottom**2 == x.denominator else None


@dataclass(frozen=True)
class Surd:
    """A sum of products of square roots of some numbers that are not negative, with coefficients of `Root3`.

    ``terms`` : the coefficient of each product, by the set of its roots' places in ``squares`` as bits.
    """

    squares: tuple[Root3, ...]
    terms: Mapping[int, Root3]

    def _of(self, terms: Mapping[int, Root3]) -> Surd:
        return Surd(self.squares, {mask: c for mask, c in terms.items() if c})

    def __add__(self, other: Surd) -> Surd:
        masks = self.terms.keys() | other.terms.keys()
        return self._of({m: self.terms.get(m, ZERO) + other.terms.get(m, ZERO) for m in masks})

    def __neg__(self) -> Surd:
        return self._of({m: -c for m, c in self.terms.items()})

    def __sub__(self, other: Surd) -> Surd:
        return self + (-other)

    def __mul__(self, other: Surd) -> Surd:
        found: dict[int, Root3] = {}
        for m, c in self.terms.items():
            for n, d in other.terms.items():
                product = c * d
                for k, square in enumerate(self.squares):
                    if m & n & (1 << k):
                        product = product * square
                found[m ^ n] = found.get(m ^ n, ZERO) + product
        return self._of(found)

    def conjugate(self, k: int) -> Surd:
        """Return the same with the other sign of one root."""
        return self._of({m: -c if m & (1 << k) else c for m, c in self.terms.items()})

    def ball(self) -> arb:
        """Enclose it."""
        roots = [square.ball().nonnegative_part().sqrt() for square in self.squares]
        found = arb(0)
        for mask, coefficient in self.terms.items():
            product = coefficient.ball()
            for k, root in enumerate(roots):
                if mask & (1 << k):
                    product *= root
            found += product
        return found

    @cached_property
    def is_zero(self) -> bool | None:
        """Whether it is 0; None where several conjugates cannot be told from 0."""
        if not self.terms:
            return True
        if self._is_apart(PRECISIONS[:2]):
            return False
        places = [k for k in range(len(self.squares)) if any(m & (1 << k) for m in self.terms)]
        others, product = [self], self
        for k in places:
            product = product * product.conjugate(k)
            others += [v.conjugate(k) for v in others]
        if product.terms:
            return False
        if all(v._is_apart(PRECISIONS) for v in others[1:]):
            return True
        return False if self._is_apart(PRECISIONS) else None

    def _is_apart(self, precisions: tuple[int, ...]) -> bool:
        """Return True when it is shown not to be 0."""
        for bits in precisions:
            with ctx.workprec(bits):
                ball = self.ball()
                if ball > 0 or ball < 0:
                    return True
        return False


def rational(value: Root3, like: Surd) -> Surd:
    """Return a number without further roots, over the roots of another."""
    return Surd(like.squares, {0: value} if value else {})


def roots_of(squares: Sequence[Root3]) -> list[Surd]:
    """Return the square roots of numbers that are not negative, over as few roots as are seen to be needed.

    A root that is in the field below is no new one, nor is one whose product with earlier roots is.
    """
    basis: list[Root3] = []
    found: list[tuple[int, Root3]] = []
    for square in squares:
        if (root := square.root()) is not None:
            found.append((0, root))
            continue
        for mask in range(1, 1 << len(basis)):
            others = prod((b for k, b in enumerate(basis) if mask & (1 << k)), start=ONE)
            if (product := (square * others).root()) is not None:
                found.append((mask, product * others.inverse()))
                break
        else:
            found.append((1 << len(basis), ONE))
            basis.append(square)
    return [Surd(tuple(basis), {mask: c} if c else {}) for mask, c in found]
