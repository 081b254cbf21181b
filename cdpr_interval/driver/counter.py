"""Positions of 32 bits that wrap: from what a drive reports to a reading without end."""

from __future__ import annotations

BITS = 32
SPAN = 1 << BITS


def wrapped(counts: int) -> int:
    """Return the signed 32-bit value of a reading: what a drive reports, and takes as a target."""
    return (counts + SPAN // 2) % SPAN - SPAN // 2


def nearest(value: int, reading: int) -> int:
    """Return the reading nearest to another one whose 32-bit value is the given one.

    Right when the drum has turned less than half the counter's span (2^31 counts) since.
    """
    return reading + wrapped(value - reading)
