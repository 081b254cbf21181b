"""From exact rationals to the doubles around them: the only way numbers of a file enter the kernels."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact.range import LengthRange

Bounds = NDArray[np.float64]
"""(lo, hi) on the last axis."""
LARGEST = sys.float_info.max


def enclose(x: Fraction) -> tuple[float, float]:
    """Return the tightest doubles around an exact number.

    Parameters
    ----------
    x : Fraction
        Any rational, also beyond the range of doubles.

    Returns
    -------
    lo, hi : float
        Equal when ``x`` is a double, else neighbours; an infinite bound where ``x`` is larger than
        every double.

    Guarantee
    ---------
    lo <= x <= hi, and no double lies strictly between lo and x or between x and hi.
    """
    numerator, denominator = x.numerator, x.denominator
    try:
        # Division of two ints is correctly rounded, also to subnormal numbers and to zero.
        nearest = numerator / denominator
    except OverflowError:
        return (LARGEST, math.inf) if numerator > 0 else (-math.inf, -LARGEST)
    a, b = nearest.as_integer_ratio()
    excess = a * denominator - numerator * b
    if excess == 0:
        return nearest, nearest
    if excess < 0:
        return nearest, math.nextafter(nearest, math.inf)
    return math.nextafter(nearest, -math.inf), nearest


def length_bounds(lengths: Iterable[LengthRange]) -> Bounds:
    """Return the tightest doubles around exact ranges, (N, 2)."""
    rows = []
    for lo, hi in lengths:
        below = enclose(lo)
        rows.append(below if lo is hi else (below[0], enclose(hi)[1]))
    return np.array(rows, dtype=np.float64)
