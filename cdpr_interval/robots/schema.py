"""The blocks of a ``cdpr-robot/1`` file as pydantic models; also the source of its JSON Schema.

The models see the checked tree of `document`: mappings and lists as they are, scalars as `Node`,
so that a number stays the exact fraction of its literal. Every length in m, mass in kg, force in N.
"""

from __future__ import annotations

import re
from fractions import Fraction
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    PlainValidator,
    Tag,
    WithJsonSchema,
    model_validator,
)
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from cdpr_interval.robots.document import Node
from cdpr_interval.robots.literal import quote, read_number

ROBOT_FORMAT = "cdpr-robot/1"
CABLE_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.-]*")
SHAPES = ("<number>", "<tolerance>", "<bounds>")
"""Tags of the three spellings of a quantity; they occur in pydantic's error locations only."""


def is_free(key: str) -> bool:
    """Return whether a key is the user's own: ``notes`` or ``x_...``, allowed in every block."""
    return key == "notes" or key.startswith("x_")


def kind(value: object) -> str:
    """Return what a value is, for an error message."""
    if isinstance(value, Node):
        return value.kind
    return f"a list of {len(value)}" if isinstance(value, list) else "a mapping"


def _number(value: object) -> Fraction:
    if isinstance(value, Node):
        if isinstance(value.value, Fraction):
            return value.value
        if isinstance(value.value, str) and value.plain:
            return read_number(value.value)
    raise ValueError(f"must be a number, got {kind(value)}")


def _text(value: object) -> str:
    if isinstance(value, Node) and isinstance(value.value, str) and value.value.strip():
        return value.value
    raise ValueError(f"must be a text (in quotes if it looks like a number), got {kind(value)}")


def _one_line(value: str) -> str:
    if not value.isprintable():
        raise ValueError(f"must be one printable line, got {quote(value)}")
    return value


def _cable_name(value: object) -> str:
    name = _text(value)
    if not CABLE_NAME.fullmatch(name):
        rule = "letters, digits, '_', '.' and '-', the first a letter or '_'"
        raise ValueError(f"must be {rule}, got {quote(name)}")
    return name


def _format(value: object) -> str:
    if _text(value) != ROBOT_FORMAT:
        raise ValueError(f"must be {quote(ROBOT_FORMAT)}, got {kind(value)}")
    return ROBOT_FORMAT


def _list_of(count: int, what: str) -> BeforeValidator:
    def check(value: object) -> object:
        if isinstance(value, list) and len(value) == count:
            return value
        raise ValueError(f"must be a list of {what}, got {kind(value)}")

    return BeforeValidator(check)


def _shape(value: object) -> str:
    return SHAPES[1] if isinstance(value, dict) else SHAPES[2] if isinstance(value, list) else SHAPES[0]


def _ascending(value: tuple[Fraction, Fraction]) -> tuple[Fraction, Fraction]:
    if value[0] > value[1]:
        raise ValueError(f"the lower bound {decimal(value[0])} is above the upper bound {decimal(value[1])}")
    return value


def decimal(value: Fraction) -> str:
    """Return a number for an error message, short and not necessarily exact."""
    return f"{float(value):.17g}"


class Block(BaseModel):
    """A mapping of the file; unknown keys are errors."""

    model_config = ConfigDict(
        extra="forbid",
        frozen=True,
        use_attribute_docstrings=True,
        json_schema_extra={"patternProperties": {"^(notes$|x_)": {}}},
    )


Number = Annotated[Fraction, PlainValidator(_number), WithJsonSchema({"type": "number"})]
Text = Annotated[str, PlainValidator(_text), WithJsonSchema({"type": "string", "minLength": 1})]
Pair = Annotated[tuple[Number, Number], _list_of(2, "2 numbers"), AfterValidator(_ascending)]


def _at_least_zero(value: Fraction) -> Fraction:
    if value < 0:
        raise ValueError(f"must not be negative, got {decimal(value)}")
    return value


class Tolerance(Block):
    """An uncertain scalar as value and half width."""

    value: Number
    tolerance: Annotated[Number, AfterValidator(_at_least_zero)]


Quantity = Annotated[
    Annotated[Number, Tag(SHAPES[0])]
    | Annotated[Tolerance, Tag(SHAPES[1])]
    | Annotated[Pair, Tag(SHAPES[2])],
    Discriminator(_shape),
]
Vector = Annotated[tuple[Quantity, Quantity, Quantity], _list_of(3, "3 numbers")]


def bounds(quantity: Fraction | Tolerance | tuple[Fraction, Fraction]) -> tuple[Fraction, Fraction]:
    """Return the exact lower and upper bound of a quantity."""
    if isinstance(quantity, Fraction):
        return quantity, quantity
    if isinstance(quantity, Tolerance):
        return quantity.value - quantity.tolerance, quantity.value + quantity.tolerance
    return quantity


def _positive(value: Any) -> Any:
    lowest = bounds(value)[0]
    if lowest <= 0:
        raise ValueError(f"must be greater than 0, got {decimal(lowest)}")
    return value


def _not_zero(value: Any) -> Any:
    if all(lo <= 0 <= hi for lo, hi in map(bounds, value)):
        raise ValueError("must not be the zero vector: without a load there are no statics")
    return value


def _tension_limits(value: tuple[Fraction, Fraction]) -> tuple[Fraction, Fraction]:
    _at_least_zero(value[0])
    return value


Positive = Annotated[Quantity, AfterValidator(_positive)]


class ElasticityBlock(Block):
    """How a cable stretches: exactly one of the two."""

    stiffness_N_per_m: Positive | None = None
    """Spring constant k."""
    axial_stiffness_N: Positive | None = None
    """EA; k = EA / (unstretched length)."""

    @model_validator(mode="after")
    def _exactly_one(self) -> ElasticityBlock:
        if len(self.model_fields_set) != 1:
            raise ValueError("must hold exactly one of 'stiffness_N_per_m' and 'axial_stiffness_N'")
        return self


class CableBlock(Block):
    """One cable."""

    name: Annotated[
        str,
        PlainValidator(_cable_name),
        WithJsonSchema({"type": "string", "pattern": f"^{CABLE_NAME.pattern}$"}),
    ]
    """Unique in the file."""
    frame_anchor_m: Vector
    """Exit point A_i, base frame."""
    platform_anchor_m: Vector
    """Platform point B_i, platform frame."""
    elasticity: ElasticityBlock | None = None
    """Absent: inextensible."""
    tension_limits_N: Annotated[Pair, AfterValidator(_tension_limits)] | None = None
    """Reported against, never a filter."""


class PlatformBlock(Block):
    """The load."""

    mass_kg: Positive
    centre_of_mass_m: Vector | None = None
    """Platform frame; default the origin."""


class RobotBlock(Block):
    """A cable-driven parallel robot, SI units, the unit in the key."""

    format: Annotated[str, PlainValidator(_format), WithJsonSchema({"const": ROBOT_FORMAT})]
    name: Annotated[Text, AfterValidator(_one_line)]
    source: Text | None = None
    """Where the numbers come from."""
    gravity_m_s2: Annotated[Vector, AfterValidator(_not_zero)] | None = None
    """Base frame; default [0, 0, -9.81]. "Up" is its opposite."""
    platform: PlatformBlock
    cables: Annotated[list[CableBlock], Field(min_length=1)]


BLOCKS: dict[str, type[Block]] = {
    "": RobotBlock,
    "platform": PlatformBlock,
    "cables": CableBlock,
    "elasticity": ElasticityBlock,
    SHAPES[1]: Tolerance,
}
"""Each block by the last name of its place, for suggestions."""


class _AbsentNotNull(GenerateJsonSchema):
    """An optional key may be absent, never null."""

    def nullable_schema(self, schema: core_schema.NullableSchema) -> JsonSchemaValue:
        return self.generate_inner(schema["schema"])

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        return self.generate_inner(schema["schema"])


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of ``cdpr-robot/1``."""
    schema = RobotBlock.model_json_schema(schema_generator=_AbsentNotNull)
    schema["title"] = ROBOT_FORMAT
    elasticity = schema["$defs"]["ElasticityBlock"]
    elasticity["oneOf"] = [{"required": [key]} for key in elasticity["properties"]]
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
