"""The blocks of a ``mechanism/1`` file as pydantic models; also the source of its JSON Schema."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, PlainValidator, WithJsonSchema

from cdpr_interval.files.fields import Block, Name, Number, Text, kind, list_of, one_of, schema_of, text
from cdpr_interval.robots.mechanism import FORMAT, FREEDOMS
from cdpr_interval.text.literal import quote

MECHANISM_FORMAT = FORMAT
Exact = Annotated[tuple[Number, Number, Number], list_of(3, "3 numbers")]


def _format(value: object) -> str:
    if text(value) != MECHANISM_FORMAT:
        raise ValueError(f"must be {quote(MECHANISM_FORMAT)}, got {kind(value)}")
    return MECHANISM_FORMAT


class JointBlock(Block):
    """A joint between two bodies."""

    name: Name | None = None
    """Default: its kind and place, R1, S2, ..."""
    kind: one_of(*FREEDOMS)  # type: ignore[valid-type]
    """Revolute, prismatic, cylindrical, universal or spherical."""
    bodies: Annotated[tuple[Name, Name], list_of(2, "2 bodies")]
    point_m: Exact | None = None
    """On the axes, or the centre of the sphere; not needed for a P."""
    axis: Exact | None = None
    """Of an R, P or C; of any length but zero."""
    axes: Annotated[list[Exact], Field(max_length=2)] | None = None
    """Of a U both; of an R, P or C a list of one in place of ``axis``."""


class MechanismBlock(Block):
    """Bodies and joints."""

    format: Annotated[str, PlainValidator(_format), WithJsonSchema({"const": MECHANISM_FORMAT})]
    name: Name
    source: Text | None = None
    """Where it comes from."""
    bodies: Annotated[list[Name], Field(min_length=2)]
    """Names."""
    base: Name | None = None
    """The body that stands still; default the first one."""
    platform: Name | None = None
    """The body whose freedoms are asked for; default none."""
    joints: Annotated[list[JointBlock], Field(min_length=1)]


BLOCKS: dict[str, type[Block]] = {"": MechanismBlock, "joints": JointBlock}
"""Each block by the last name of its place, for suggestions."""


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of ``mechanism/1``."""
    return schema_of(MechanismBlock, MECHANISM_FORMAT)
