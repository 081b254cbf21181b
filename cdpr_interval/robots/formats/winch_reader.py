"""From the winch blocks of a robot file to frozen data."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from cdpr_interval.exact.range import Range
from cdpr_interval.files.fields import bounds
from cdpr_interval.robots.formats.winch_schema import (
    HelicalBlock,
    LinearBlock,
    MarksBlock,
    MultilayerBlock,
    TableBlock,
    WinchBlock,
    WinchesBlock,
)
from cdpr_interval.robots.winch import (
    Drum,
    HelicalDrum,
    LinearDrum,
    Mark,
    MarkSensor,
    MultilayerDrum,
    TableDrum,
    Winch,
    WinchGroupSettings,
    WinchLimits,
)

ZERO = Fraction(0)
PACKING = Range(Fraction(866025, 10**6), Fraction(1))
"""From just below sqrt(3)/2, a layer lying in the grooves of the last, to 1, turn on turn."""
TRANSITION = Fraction(1, 2)
"""Turns: a crossover takes a part of a turn, its place on the drum varies."""


def settings(block: WinchesBlock) -> WinchGroupSettings:
    """Return what holds for all winches; absent keys take the model's defaults."""
    given: dict[str, Any] = {
        "cycle": block.cycle_s,
        "heartbeat": block.heartbeat_s,
        "lookahead": block.lookahead_s,
        "coherence": block.coherence_m,
        "correction_rate": block.correction_rate_m_s,
        "armed": block.armed,
    }
    return WinchGroupSettings(**{name: value for name, value in given.items() if value is not None})


def winch(block: WinchBlock) -> Winch:
    """Return the winch of a checked block."""
    limits = block.limits
    return Winch(
        _drum(block.drum),
        Fraction(1) if block.gear_ratio is None else block.gear_ratio,
        1 if block.counts_per_turn is None else block.counts_per_turn,
        1 if block.sign is None else block.sign,
        Fraction(1) if block.encoder_error_counts is None else block.encoder_error_counts,
        WinchLimits(
            limits.length_m,
            limits.velocity_m_s,
            limits.acceleration_m_s2,
            limits.following_error_m,
            limits.torque,
        ),
        block.node,
        None if block.marks is None else _sensor(block.marks),
    )


def _range(quantity: Any) -> Range:
    return Range(*bounds(quantity))


def _drum(block: Any) -> Drum:
    if isinstance(block, HelicalBlock):
        return HelicalDrum(
            _range(block.groove_radius_m), _range(block.cable_diameter_m), _range(block.pitch_m)
        )
    if isinstance(block, MultilayerBlock):
        return MultilayerDrum(
            _range(block.core_radius_m),
            _range(block.cable_diameter_m),
            block.turns_per_layer,
            block.layers,
            PACKING if block.packing is None else _range(block.packing),
            block.cable_length_m,
            TRANSITION if block.transition_turns is None else block.transition_turns,
        )
    if isinstance(block, TableBlock):
        return TableDrum(tuple(block.points_turns_m), block.error_m)
    assert isinstance(block, LinearBlock)
    return LinearDrum(_range(block.metres_per_count))


def _sensor(block: MarksBlock) -> MarkSensor:
    marks = []
    for number, mark in enumerate(block.at, 1):
        tolerance = mark.tolerance_m or ZERO
        place = Range(mark.distance_m - tolerance, mark.distance_m + tolerance)
        marks.append(Mark(mark.name or str(number), place))
    return MarkSensor(
        tuple(marks), block.sensor_offset_m or ZERO, block.hysteresis_m or ZERO, block.latency_s or ZERO
    )
