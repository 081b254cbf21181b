"""Lengths of legs beyond their limits: said of an answer, which keeps its poses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from cdpr_interval.robots.cable_robot import Cable, Robot

Lengths = Sequence[tuple[float | Fraction, float | Fraction]]
"""m, file order: the lowest and the highest length of each leg."""


def beyond_limits(robot: Robot, lengths: Lengths) -> list[str]:
    """Return a sentence about every leg of which a length may be outside its limits; none of cables."""
    return [_sentence(cable, *bounds) for cable, bounds in _beyond(robot, lengths)]


def names_beyond(robot: Robot, lengths: Lengths) -> tuple[str, ...]:
    """Return the names of these legs."""
    return tuple(cable.name for cable, _ in _beyond(robot, lengths))


def _beyond(
    robot: Robot, lengths: Lengths
) -> Iterator[tuple[Cable, tuple[float | Fraction, float | Fraction]]]:
    if not robot.has_legs:
        return
    for cable, (lo, hi) in zip(robot.cables, lengths, strict=True):
        limits = cable.length_limits
        if limits is not None and not limits[0] <= lo <= hi <= limits[1]:
            yield cable, (lo, hi)


def _sentence(cable: Cable, lo: float | Fraction, hi: float | Fraction) -> str:
    """Return what is said of a leg; a range may be outside in part."""
    assert cable.length_limits is not None
    least, most = map(float, cable.length_limits)
    length = f"{float(lo):.15g}" if lo == hi else f"{float(lo):.15g} to {float(hi):.15g}"
    return f"{cable.name} is {length} m long, its limits are {least:.15g} and {most:.15g} m"
