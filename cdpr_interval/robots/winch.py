"""A winch as data: drum, gear, encoder, limits and marks, every number the exact rational of its source text.

Lengths are unstrained: what the cable measures without tension, from the exit point A to its platform end.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction


@dataclass(frozen=True)
class Range:
    """A quantity known to lie between two exact bounds; arithmetic encloses."""

    lo: Fraction
    hi: Fraction

    @property
    def mid(self) -> Fraction:
        """The middle: the nominal value."""
        return (self.lo + self.hi) / 2

    @property
    def width(self) -> Fraction:
        """Upper minus lower bound."""
        return self.hi - self.lo

    def __add__(self, other: Range) -> Range:
        return Range(self.lo + other.lo, self.hi + other.hi)

    def __sub__(self, other: Range) -> Range:
        return Range(self.lo - other.hi, self.hi - other.lo)

    def __mul__(self, other: Range) -> Range:
        products = (self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi)
        return Range(min(products), max(products))

    def __contains__(self, value: Fraction | int) -> bool:
        return self.lo <= value <= self.hi

    def meets(self, other: Range) -> bool:
        """Return whether the two have a point in common."""
        return self.lo <= other.hi and other.lo <= self.hi

    def hull(self, other: Range) -> Range:
        """Return the smallest range around both."""
        return Range(min(self.lo, other.lo), max(self.hi, other.hi))

    def widened(self, by: Fraction | int) -> Range:
        """Return the range with both bounds moved outwards by a distance."""
        return Range(self.lo - by, self.hi + by)


@dataclass(frozen=True)
class HelicalDrum:
    """A grooved drum, one layer: a turn pays out ``sqrt((2 pi r)^2 + pitch^2)``, r = groove radius + d/2."""

    groove_radius: Range
    """m, to the bottom of the groove."""
    cable_diameter: Range
    """m."""
    pitch: Range
    """m a turn."""


@dataclass(frozen=True)
class MultilayerDrum:
    """A drum on which the cable winds over itself: layer k has the radius r0 + d/2 + (k - 1) c d."""

    core_radius: Range
    """m."""
    cable_diameter: Range
    """m."""
    turns_per_layer: Fraction
    layers: int
    """How many the drum holds."""
    packing: Range
    """c: sqrt(3)/2 (a layer lies in the grooves of the last) to 1 (turn on turn)."""
    cable_length: Fraction
    """m: what is paid out when the drum is bare."""
    transition_turns: Fraction
    """How far from its nominal place a change of layer may happen."""


@dataclass(frozen=True)
class TableDrum:
    """Measured points (drum turns, length), straight lines between them."""

    points: tuple[tuple[Fraction, Fraction], ...]
    """Turns and m, both ascending."""
    error: Fraction
    """m: how far the true length may be from the line."""


@dataclass(frozen=True)
class LinearDrum:
    """One number for drum, gear and encoder together."""

    metres_per_count: Range


Drum = HelicalDrum | MultilayerDrum | TableDrum | LinearDrum


@dataclass(frozen=True)
class Mark:
    """A mark on the cable."""

    name: str
    distance: Range
    """m along the unstrained cable from its end at the platform."""


@dataclass(frozen=True)
class MarkSensor:
    """Marks of one cable and the sensor that sees them pass."""

    marks: tuple[Mark, ...]
    """By ascending distance."""
    offset: Fraction
    """m from the exit point to the sensor along the cable, towards the drum; negative: outside."""
    hysteresis: Fraction
    """m: how much further out a mark is seen when the cable is paid out than when it is wound in."""
    latency: Fraction
    """s from the mark's passage to the latched count; 0 where the drive latches it."""


@dataclass(frozen=True)
class WinchLimits:
    """What a winch may do."""

    length: tuple[Fraction, Fraction]
    """m."""
    velocity: Fraction
    """m/s."""
    acceleration: Fraction
    """m/s^2."""
    following_error: Fraction
    """m between target and actual position."""
    torque: Fraction | None
    """Rated torque = 1; None: not looked at."""


@dataclass(frozen=True)
class Winch:
    """The winch of one cable."""

    drum: Drum
    gear_ratio: Fraction
    """Motor turns a drum turn, exact."""
    counts_per_turn: int
    """Of the motor."""
    sign: int
    """+1: counts grow while cable is paid out."""
    encoder_error: Fraction
    """Counts by which a reading may differ from the true angle."""
    limits: WinchLimits
    node: int
    """CANopen node id, 1 to 127."""
    sensor: MarkSensor | None = None


@dataclass(frozen=True)
class WinchGroupSettings:
    """What holds for all winches of a robot together."""

    cycle: Fraction = Fraction(1, 100)
    """s between two SYNC messages."""
    heartbeat: Fraction = Fraction(1, 20)
    """s between two heartbeats of a drive."""
    lookahead: Fraction = Fraction(1, 20)
    """s: how far ahead a set-point without a time is placed; a caller who is later than that is a fault."""
    coherence: Fraction | None = None
    """m: how far the following errors of two cables may differ; None: not looked at."""
    correction_rate: Fraction = Fraction(1, 100)
    """m/s at which a correction by a mark is worked off."""
    armed: bool = False
    """True: ``--live`` needs no typed name."""
