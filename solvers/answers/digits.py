"""Decimal text of an enclosure: only digits that are proved, and the width where it matters."""

from __future__ import annotations

import math
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal

_EXACT = Context(prec=800)
"""Holds every digit of a double, so that quantizing rounds once."""
LEAST_UNITS = 5
"""Of the last decimal in a radius at least: rounding centre and radius adds at most 30 % to it."""
MOST_DECIMALS = 9
"""Of a number with significant digits: rounding errors around zero are no digits."""
LARGEST_PLAIN = 1e7
"""From here on, and below `SMALLEST_PLAIN`, the ends of a range are written with an exponent."""
SMALLEST_PLAIN = 1e-6


def proved_decimal(lo: float, hi: float, most: int) -> str:
    """Return the number that an enclosure shows at so many decimals, with its radius where that is visible.

    Parameters
    ----------
    lo, hi : float
        The enclosure.
    most : int
        Largest number of decimals.

    Returns
    -------
    str
        ``5.296411``: every number of the enclosure rounds to this one at its last decimal. Where the
        enclosure is wider than one unit of the decimal ``most``, ``5.2964 +- 0.0009``: a ball, its radius
        rounded up, that holds the enclosure. Without a bound on some side the range ``lo..hi``, rounded
        outwards.
    """
    if not (math.isfinite(lo) and math.isfinite(hi)):
        return _range(lo, hi)
    low, high = Decimal(lo), Decimal(hi)
    if _EXACT.subtract(high, low) <= Decimal(1).scaleb(-most):
        for decimals in range(most, -1, -1):
            unit = Decimal(1).scaleb(-decimals)
            below, above = (bound.quantize(unit, context=_EXACT) for bound in (low, high))
            if below == above:
                return _plain(below)
    return _ball(low, high, most)


def proved_significant(lo: float, hi: float, digits: int) -> str:
    """Return `proved_decimal` with at most so many significant digits; ``lo..hi`` where not one is proved."""
    size = max(abs(lo), abs(hi))
    if not (math.isfinite(size) and size > 0.0):
        return proved_decimal(lo, hi, 0)
    decimals = min(max(0, digits - 1 - math.floor(math.log10(size))), MOST_DECIMALS)
    if hi - lo > max(0.5 * size, 10.0**-decimals):
        return _range(lo, hi)
    return proved_decimal(lo, hi, decimals)


def at_most(value: float) -> str:
    """Return a number of two significant digits that is not below a non-negative one."""
    if not math.isfinite(value) or value == 0.0:
        return f"{value:g}"
    rounded = Context(prec=2, rounding=ROUND_CEILING).create_decimal(Decimal(value)).normalize()
    return f"{rounded:f}" if SMALLEST_PLAIN <= value < LARGEST_PLAIN else f"{rounded:e}"


def _ball(low: Decimal, high: Decimal, most: int) -> str:
    """Return ``centre +- radius`` around an enclosure, the radius rounded up to one or two digits."""
    width = _EXACT.subtract(high, low)
    half = _EXACT.divide(width, Decimal(2))
    # The unit of the last decimal: the largest of which the radius has some.
    decimals = min(most, -(half / LEAST_UNITS).adjusted()) if half else most
    unit = Decimal(1).scaleb(-decimals)
    centre = _EXACT.divide(_EXACT.add(low, high), Decimal(2)).quantize(unit, context=_EXACT)
    reach = max(_EXACT.subtract(centre, low), _EXACT.subtract(high, centre))
    radius = reach.quantize(unit, rounding=ROUND_CEILING, context=_EXACT)
    return f"{_plain(centre)} +- {radius:f}"


def _plain(number: Decimal) -> str:
    # A zero loses its sign: it may come from a tiny negative bound.
    return f"{abs(number) if number == 0 else number:f}"


def _range(lo: float, hi: float) -> str:
    return f"{_outward(lo, ROUND_FLOOR)}..{_outward(hi, ROUND_CEILING)}"


def _outward(bound: float, rounding: str) -> str:
    if not math.isfinite(bound):
        return str(bound)
    rounded = Context(prec=4, rounding=rounding).create_decimal(Decimal(bound)).normalize()
    return f"{rounded:f}" if SMALLEST_PLAIN <= abs(bound) < LARGEST_PLAIN else f"{rounded:g}"
