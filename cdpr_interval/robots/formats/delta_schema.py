"""The blocks of a ``delta-robot/1`` file as pydantic models; also the source of its JSON Schema."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import PlainValidator, WithJsonSchema

from cdpr_interval.exact.angle import WITH_UNIT, Angle
from cdpr_interval.exact.range import Range
from cdpr_interval.files.document import Node
from cdpr_interval.files.fields import (
    SHAPES,
    Block,
    Name,
    Positive,
    Quantity,
    Text,
    Tolerance,
    Vector,
    kind,
    list_of,
    number,
    one_of,
    schema_of,
    text,
)
from cdpr_interval.robots.delta import DRIVES, FORMAT, ROTARY
from cdpr_interval.text.literal import quote, read_number

DELTA_FORMAT = FORMAT


def _format(value: object) -> str:
    if text(value) != DELTA_FORMAT:
        raise ValueError(f"must be {quote(DELTA_FORMAT)}, got {kind(value)}")
    return DELTA_FORMAT


def angle(value: object) -> Angle:
    """Return an angle: a number of radians, or a text with its unit."""
    if isinstance(value, Node) and isinstance(value.value, str):
        found = WITH_UNIT.fullmatch(value.value.strip())
        if found is None:
            raise ValueError(f"must be a number in rad, or a text such as 120deg, got {kind(value)}")
        return Angle(Range.exact(read_number(found[1].strip())), found[2] != "rad")
    return Angle(Range.exact(number(value)), in_degrees=False)


AngleField = Annotated[
    Angle, PlainValidator(angle), WithJsonSchema({"anyOf": [{"type": "number"}, {"type": "string"}]})
]


class DeltaBlock(Block):
    """A Delta robot: three chains of arm (or carriage) and bars that carry a platform which never turns."""

    format: Annotated[str, PlainValidator(_format), WithJsonSchema({"const": DELTA_FORMAT})]
    name: Name
    source: Text | None = None
    """Where the numbers come from."""
    base_radius_m: Quantity
    """R_A: from the axis z to the shoulders, or to where the rails start."""
    platform_radius_m: Quantity
    """R_B: from the platform's centre to its ball joints."""
    arm_m: Positive | None = None
    """L_A; needed with rotary drives, without meaning with linear ones."""
    bar_m: Positive
    """L_B."""
    bar_spacing_m: Quantity | None = None
    """Between the two bars of a chain; positions do not depend on it."""
    arm_angles_rad: Annotated[tuple[AngleField, AngleField, AngleField], list_of(3, "3 angles")] | None = None
    """Of the chains about z; default 0, 120deg and 240deg."""
    drives: one_of(*DRIVES) = ROTARY  # type: ignore[valid-type]
    """Arms that turn, or carriages on rails."""
    rail_directions: Annotated[tuple[Vector, Vector, Vector], list_of(3, "3 vectors")] | None = None
    """Linear drives: where a carriage's position grows, base axes, of any length but zero."""
    tool_offset_m: Vector | None = None
    """From the platform's centre to the point whose position is meant; default the centre."""
    gamma_max_rad: AngleField | None = None
    """Most that a bar may lean out of the plane of its chain; reported against, never a filter."""
    elbow_min_rad: AngleField | None = None
    """Least interior angle at the knee; reported against, never a filter."""
    elbow_max_rad: AngleField | None = None
    """Largest interior angle at the knee, half a turn is stretched; reported against, never a filter."""


BLOCKS: dict[str, type[Block]] = {"": DeltaBlock, SHAPES[1]: Tolerance}
"""Each block by the last name of its place, for suggestions."""


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of ``delta-robot/1``."""
    return schema_of(DeltaBlock, DELTA_FORMAT)
