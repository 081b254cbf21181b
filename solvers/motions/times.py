"""Times for display: as many decimals as the length of a motion calls for, whenever it began."""

from __future__ import annotations

import math
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal

DIGITS = 6
"""Of the whole motion."""
MOST_DECIMALS = 9
EXACT = Context(prec=800)
"""Holds every digit of a double."""


def shown_time(time: float, span: float, rounding: str = ROUND_HALF_EVEN) -> str:
    """Return a time in s of a motion that takes ``span`` s."""
    size = math.floor(math.log10(span)) if span > 0.0 else -MOST_DECIMALS
    decimals = min(max(DIGITS - size, 0), MOST_DECIMALS)
    text = f"{Decimal(time).quantize(Decimal(1).scaleb(-decimals), rounding, EXACT):f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def between(begin: float, end: float, span: float) -> str:
    """Return two times between which something happens, rounded outwards."""
    return f"{shown_time(begin, span, ROUND_FLOOR)}..{shown_time(end, span, ROUND_CEILING)}"
