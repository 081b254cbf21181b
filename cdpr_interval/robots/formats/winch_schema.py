"""The blocks of a ``cdpr-robot/1`` file that say how its cables are moved, as pydantic models."""

from __future__ import annotations

import re
from fractions import Fraction
from itertools import pairwise
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    Discriminator,
    Field,
    PlainValidator,
    Tag,
    WithJsonSchema,
    model_validator,
)

from cdpr_interval.files.document import Node
from cdpr_interval.files.fields import (
    SHAPES,
    Block,
    Flag,
    Name,
    NotNegativeNumber,
    Number,
    Pair,
    Positive,
    PositiveNumber,
    Quantity,
    at_least_zero,
    bounds,
    constant,
    decimal,
    integer,
    kind,
    known_type,
    lengths_rising,
    list_of,
    number,
    type_tag,
)
from cdpr_interval.robots.formats import schema
from cdpr_interval.robots.formats.schema import CableBlock, RobotBlock
from cdpr_interval.text.literal import quote

LARGEST_NODE = 127
"""CANopen node ids are 1 to 127."""
MOST_COUNTS = 2**31
"""Of a motor turn: a counter has 32 bits."""
BELOW_TWO_PI = Fraction(6283185307179586, 10**15)
"""A little less than 2 pi, for a check that must not refuse too much."""
RATIO = re.compile(r"([0-9]{1,9}):([0-9]{1,9})")


def _ratio(value: object) -> Fraction:
    """Return motor turns per drum turn from ``a:b`` or an integer."""
    if isinstance(value, Node) and isinstance(value.literal, str):
        parts = RATIO.fullmatch(value.literal)
        if parts and int(parts[1]) and int(parts[2]):
            return Fraction(int(parts[1]), int(parts[2]))
        if isinstance(value.value, Fraction) and value.value.denominator == 1 and value.value > 0:
            return value.value
    got = kind(value)
    raise ValueError(f"must be two positive integers 'a:b' (a decimal ratio would drift), got {got}")


def _sign(value: object) -> int:
    found = number(value)
    if abs(found) != 1:
        raise ValueError(f"must be 1 or -1, got {decimal(found)}")
    return int(found)


def _not_negative(value: Any) -> Any:
    at_least_zero(bounds(value)[0])
    return value


NotNegative = Annotated[Quantity, AfterValidator(_not_negative)]
Ratio = Annotated[
    Fraction,
    PlainValidator(_ratio),
    WithJsonSchema({"anyOf": [{"type": "string", "pattern": f"^{RATIO.pattern}$"}, {"type": "integer"}]}),
]


class HelicalBlock(Block):
    """A grooved drum with one layer."""

    type: constant("helical")  # type: ignore[valid-type]
    groove_radius_m: Positive
    """To the bottom of the groove."""
    cable_diameter_m: Positive
    pitch_m: NotNegative
    """Along the drum, a turn."""


class MultilayerBlock(Block):
    """A drum on which the cable winds over itself."""

    type: constant("multilayer")  # type: ignore[valid-type]
    core_radius_m: Positive
    cable_diameter_m: Positive
    turns_per_layer: PositiveNumber
    layers: integer(1, 1000)  # type: ignore[valid-type]
    cable_length_m: PositiveNumber
    """Paid out when the drum is bare."""
    packing: Positive | None = None
    """Growth of the radius from layer to layer, in cable diameters; default from sqrt(3)/2 to 1."""
    transition_turns: NotNegativeNumber | None = None
    """How far from its place a change of layer may happen; default 1/2."""


Point = Annotated[tuple[Number, Number], list_of(2, "2 numbers")]


def _ascending_points(value: list[tuple[Fraction, Fraction]]) -> list[tuple[Fraction, Fraction]]:
    for i, (before, after) in enumerate(pairwise(value)):
        if not (before[0] < after[0] and before[1] < after[1]):
            raise ValueError(f"turns and lengths must ascend, point {i + 1} does not")
    return value


class TableBlock(Block):
    """Measured points, straight lines between them."""

    type: constant("table")  # type: ignore[valid-type]
    points_turns_m: Annotated[list[Point], Field(min_length=2), AfterValidator(_ascending_points)]
    """Drum turns and paid-out length, both ascending."""
    error_m: NotNegativeNumber
    """How far the true length may be from the line."""


class LinearBlock(Block):
    """Drum, gear and encoder in one number."""

    type: constant("linear")  # type: ignore[valid-type]
    metres_per_count: Positive


DRUMS: dict[str, type[Block]] = {
    "<helical>": HelicalBlock,
    "<multilayer>": MultilayerBlock,
    "<table>": TableBlock,
    "<linear>": LinearBlock,
}
"""Each drum by its tag in pydantic's error locations."""


DrumBlock = Annotated[
    Annotated[HelicalBlock, Tag("<helical>")]
    | Annotated[MultilayerBlock, Tag("<multilayer>")]
    | Annotated[TableBlock, Tag("<table>")]
    | Annotated[LinearBlock, Tag("<linear>")],
    Discriminator(type_tag),
]


class LimitsBlock(Block):
    """What a winch may do."""

    length_m: Annotated[Pair, AfterValidator(lengths_rising)]
    velocity_m_s: PositiveNumber
    acceleration_m_s2: PositiveNumber
    following_error_m: PositiveNumber
    """Between target and actual position."""
    torque: PositiveNumber | None = None
    """Share of the drive's rated torque; absent: not looked at."""


class MarkBlock(Block):
    """One mark."""

    name: Name | None = None
    """Default: its number, from 1."""
    distance_m: PositiveNumber
    """Along the unstrained cable from its end at the platform."""
    tolerance_m: NotNegativeNumber | None = None


class MarksBlock(Block):
    """Marks on the cable, and the sensor that sees them."""

    sensor_offset_m: Number | None = None
    """From the exit point to the sensor, towards the drum."""
    hysteresis_m: NotNegativeNumber | None = None
    """How much further out a mark is seen paying out than winding in."""
    latency_s: NotNegativeNumber | None = None
    """From the mark's passage to the latched count."""
    at: Annotated[list[MarkBlock], Field(min_length=1)]
    """By ascending distance."""

    @model_validator(mode="after")
    def _apart(self) -> MarksBlock:
        reach = [(m.distance_m, m.tolerance_m or Fraction(0)) for m in self.at]
        for i, ((a, s), (b, t)) in enumerate(pairwise(reach)):
            if a + s >= b - t:
                raise ValueError(f"marks must ascend and stay apart: at[{i}] and at[{i + 1}] do not")
        names = [mark.name or str(i) for i, mark in enumerate(self.at, 1)]
        for i, name in enumerate(names):
            if name in names[:i]:
                raise ValueError(f"two marks have the name {quote(name)}")
        return self


class WinchBlock(Block):
    """The winch of one cable."""

    node: integer(1, LARGEST_NODE)  # type: ignore[valid-type]
    """CANopen node id."""
    drum: Annotated[DrumBlock, known_type(DRUMS)]
    gear_ratio: Ratio | None = None
    """Motor turns to drum turns, ``a:b`` or an integer."""
    counts_per_turn: integer(1, MOST_COUNTS) | None = None  # type: ignore[valid-type]
    """Of the motor."""
    sign: Annotated[int, PlainValidator(_sign), WithJsonSchema({"enum": [1, -1]})] | None = None
    """1: counts grow while cable is paid out (default)."""
    encoder_error_counts: NotNegativeNumber | None = None
    """By how many counts a reading may be wrong; default 1."""
    limits: LimitsBlock
    marks: MarksBlock | None = None

    @model_validator(mode="after")
    def _gear_and_encoder(self) -> WinchBlock:
        lumped = isinstance(self.drum, LinearBlock)
        for name in ("gear_ratio", "counts_per_turn"):
            given = getattr(self, name) is not None
            if given and lumped:
                raise ValueError(f"{name} is in metres_per_count already")
            if not given and not lumped:
                raise ValueError(f"{name} is missing")
        return self

    @model_validator(mode="after")
    def _within_the_drum(self) -> WinchBlock:
        least, most = _reach(self.drum)
        low, high = self.limits.length_m
        if (least is not None and low < least) or (most is not None and high > most):
            shown = f"{decimal(least or Fraction(0))} to {decimal(most or high)} m"
            raise ValueError(f"limits.length_m is beyond what the drum can do: {shown}")
        return self


def _reach(drum: Block) -> tuple[Fraction | None, Fraction | None]:
    """Return the least and largest length that can be paid out; None where there is no bound."""
    if isinstance(drum, TableBlock):
        return drum.points_turns_m[0][1], drum.points_turns_m[-1][1]
    if isinstance(drum, MultilayerBlock):
        radius = bounds(drum.core_radius_m)[0] + bounds(drum.cable_diameter_m)[0] / 2
        growth = bounds(drum.cable_diameter_m)[0] * (
            Fraction(866, 1000) if drum.packing is None else bounds(drum.packing)[0]
        )
        around = sum(radius + layer * growth for layer in range(drum.layers))
        return drum.cable_length_m - BELOW_TWO_PI * drum.turns_per_layer * around, drum.cable_length_m
    return None, None


class WinchesBlock(Block):
    """What holds for all winches together."""

    cycle_s: PositiveNumber | None = None
    """Between two SYNC messages; default 0.01."""
    heartbeat_s: PositiveNumber | None = None
    """Between two heartbeats of a drive; default 0.05."""
    lookahead_s: PositiveNumber | None = None
    """How far ahead a set-point without a time is placed; default 0.05."""
    coherence_m: PositiveNumber | None = None
    """How far the following errors of two cables may differ; absent: not looked at."""
    correction_rate_m_s: PositiveNumber | None = None
    """At which the correction by a mark is worked off; default 0.01."""
    armed: Flag | None = None
    """True: ``--live`` needs no typed name; default false."""


class CableWithWinch(CableBlock):
    """One cable, and what moves it."""

    winch: WinchBlock | None = None
    """For every cable or for none."""


class RobotWithWinches(RobotBlock):
    """A cable-driven parallel robot, SI units, the unit in the key."""

    cables: Annotated[list[CableWithWinch], Field(min_length=1)]  # type: ignore[assignment]
    winches: WinchesBlock | None = None
    """What holds for all winches together."""


BLOCKS: dict[str, type[Block]] = {
    **schema.BLOCKS,
    "": RobotWithWinches,
    "cables": CableWithWinch,
    "winch": WinchBlock,
    "winches": WinchesBlock,
    "limits": LimitsBlock,
    "marks": MarksBlock,
    "at": MarkBlock,
    **DRUMS,
}
"""Each block by the last name of its place, for suggestions."""

TAGS = (*SHAPES, *DRUMS)
"""Steps of pydantic's error locations that are no places in the file."""
