"""A winch as data: drum, gear, encoder, limits and marks, every number the exact rational of its source text.

Lengths are unstrained: what the cable measures without tension, from the exit point A to its platform end.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from cdpr_interval.exact.decimals import plain, plain_scalar
from cdpr_interval.exact.range import Range


@dataclass(frozen=True)
class HelicalDrum:
    """A grooved drum, one layer: a turn pays out ``sqrt((2 pi r)^2 + pitch^2)``, r = groove radius + d/2."""

    groove_radius: Range
    """m, to the bottom of the groove."""
    cable_diameter: Range
    """m."""
    pitch: Range
    """m a turn."""

    def to_dict(self) -> dict[str, Any]:
        """Return the block of a file."""
        return {
            "type": "helical",
            "groove_radius_m": plain_scalar(self.groove_radius),
            "cable_diameter_m": plain_scalar(self.cable_diameter),
            "pitch_m": plain_scalar(self.pitch),
        }


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

    def to_dict(self) -> dict[str, Any]:
        """Return the block of a file."""
        return {
            "type": "multilayer",
            "core_radius_m": plain_scalar(self.core_radius),
            "cable_diameter_m": plain_scalar(self.cable_diameter),
            "turns_per_layer": plain(self.turns_per_layer),
            "layers": self.layers,
            "cable_length_m": plain(self.cable_length),
            "packing": plain_scalar(self.packing),
            "transition_turns": plain(self.transition_turns),
        }


@dataclass(frozen=True)
class TableDrum:
    """Measured points (drum turns, length), straight lines between them."""

    points: tuple[tuple[Fraction, Fraction], ...]
    """Turns and m, both ascending."""
    error: Fraction
    """m: how far the true length may be from the line."""

    def to_dict(self) -> dict[str, Any]:
        """Return the block of a file."""
        points = [[plain(turns), plain(length)] for turns, length in self.points]
        return {"type": "table", "points_turns_m": points, "error_m": plain(self.error)}


@dataclass(frozen=True)
class LinearDrum:
    """One number for drum, gear and encoder together."""

    metres_per_count: Range

    def to_dict(self) -> dict[str, Any]:
        """Return the block of a file."""
        return {"type": "linear", "metres_per_count": plain_scalar(self.metres_per_count)}


Drum = HelicalDrum | MultilayerDrum | TableDrum | LinearDrum


@dataclass(frozen=True)
class Mark:
    """A mark on the cable."""

    name: str
    distance: Range
    """m along the unstrained cable from its end at the platform."""

    def to_dict(self) -> dict[str, Any]:
        """Return the entry of a file."""
        distance, tolerance = plain(self.distance.mid), plain(self.distance.width / 2)
        return {"name": self.name, "distance_m": distance, "tolerance_m": tolerance}


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

    def to_dict(self) -> dict[str, Any]:
        """Return the block of a file."""
        return {
            "sensor_offset_m": plain(self.offset),
            "hysteresis_m": plain(self.hysteresis),
            "latency_s": plain(self.latency),
            "at": [mark.to_dict() for mark in self.marks],
        }


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

    def to_dict(self) -> dict[str, Any]:
        """Return the block of a file."""
        block: dict[str, Any] = {
            "length_m": [plain(bound) for bound in self.length],
            "velocity_m_s": plain(self.velocity),
            "acceleration_m_s2": plain(self.acceleration),
            "following_error_m": plain(self.following_error),
        }
        return block if self.torque is None else {**block, "torque": plain(self.torque)}


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

    def to_dict(self) -> dict[str, Any]:
        """Return the block of a file."""
        block: dict[str, Any] = {"node": self.node, "drum": self.drum.to_dict()}
        if not isinstance(self.drum, LinearDrum):
            ratio = self.gear_ratio
            block["gear_ratio"] = f"{ratio.numerator}:{ratio.denominator}"
            block["counts_per_turn"] = self.counts_per_turn
        block |= {
            "sign": self.sign,
            "encoder_error_counts": plain(self.encoder_error),
            "limits": self.limits.to_dict(),
        }
        return block if self.sensor is None else {**block, "marks": self.sensor.to_dict()}


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

    def to_dict(self) -> dict[str, Any]:
        """Return the block of a file: what differs from the defaults."""
        keys: dict[str, Any] = {
            "cycle_s": "cycle",
            "heartbeat_s": "heartbeat",
            "lookahead_s": "lookahead",
            "coherence_m": "coherence",
            "correction_rate_m_s": "correction_rate",
            "armed": "armed",
        }
        usual, block = WinchGroupSettings(), {}
        for key, name in keys.items():
            value = getattr(self, name)
            if value != getattr(usual, name):
                block[key] = value if isinstance(value, bool) else plain(value)
        return block
