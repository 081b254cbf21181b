"""Rows of second-order forms in exact numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations
from typing import Any


class Point:
    """Values of the symbols, and the monomials that belong to a row's coefficients."""

    def __init__(self, eps: Sequence[Fraction], delta: Sequence[Fraction] = ()) -> None:
        self.eps, self.delta = list(eps), list(delta)
        common = math.lcm(*(e.denominator for e in eps))
        n = [e.numerator * (common // e.denominator) for e in eps]
        self.denominator = common**2
        """One for all monomials; integers are much faster than fractions."""
        self.numerators = [self.denominator, *(common * a for a in n)]
        self.numerators += [*(a * a for a in n), *(a * b for a, b in combinations(n, 2))]


def polynomial(row: Any, at: Point) -> Fraction:
    """Return a row's polynomial at a point."""
    ratios = [float(a).as_integer_ratio() for a in row[: len(at.numerators)]]
    digits = max(q.bit_length() for _, q in ratios)
    total = sum((p * m) << (digits - q.bit_length()) for (p, q), m in zip(ratios, at.numerators, strict=True))
    # The slopes in the symbols of data stand behind the error and two sums.
    slopes = row[len(at.numerators) + 3 :][: len(at.delta)]
    of_data = sum((Fraction(a) * d for a, d in zip(slopes, at.delta, strict=True)), Fraction(0))
    return Fraction(total, at.denominator << (digits - 1)) + of_data


def error_column(symbols: Any) -> int:
    """Return the column of a row's error; behind it are the sums |l| and |q|."""
    k = len(symbols.noise)
    return 1 + k + k * (k + 1) // 2
