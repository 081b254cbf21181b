"""Kinds of values in a robot file, as pydantic types: numbers, ranges, vectors, texts, blocks.

They see the checked tree of `document`: mappings and lists as they are, scalars as `Node`, so that a number
stays the exact fraction of its literal.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from fractions import Fraction
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    PlainValidator,
    Tag,
    WithJsonSchema,
)
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from cdpr_interval.files.document import Node
from cdpr_interval.text.literal import quote, read_number

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


def number(value: object) -> Fraction:
    """Return a number; `ValueError` for anything else."""
    if isinstance(value, Node):
        if isinstance(value.value, Fraction):
            return value.value
        if isinstance(value.value, str) and value.plain:
            return read_number(value.value.strip())
    raise ValueError(f"must be a number, got {kind(value)}")


def text(value: object) -> str:
    """Return a text that is not blank."""
    if isinstance(value, Node) and isinstance(value.value, str) and value.value.strip():
        return value.value
    raise ValueError(f"must be a text (in quotes if it looks like a number), got {kind(value)}")


def one_line(value: str) -> str:
    """Return a text that is one printable line."""
    if not value.isprintable():
        raise ValueError(f"must be one printable line, got {quote(value)}")
    return value


def cable_name(value: object) -> str:
    """Return the name of a cable."""
    name = text(value)
    if not CABLE_NAME.fullmatch(name):
        rule = "letters, digits, '_', '.' and '-', the first a letter or '_'"
        raise ValueError(f"must be {rule}, got {quote(name)}")
    return name


def list_of(count: int, what: str) -> BeforeValidator:
    """Return a check that a value is a list of so many."""

    def check(value: object) -> object:
        if isinstance(value, list) and len(value) == count:
            return value
        raise ValueError(f"must be a list of {what}, got {kind(value)}")

    return BeforeValidator(check)


def _shape(value: object) -> str:
    return SHAPES[1] if isinstance(value, dict) else SHAPES[2] if isinstance(value, list) else SHAPES[0]


def ascending(value: tuple[Fraction, Fraction]) -> tuple[Fraction, Fraction]:
    """Return two bounds of which the first is not above the second."""
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


Number = Annotated[Fraction, PlainValidator(number), WithJsonSchema({"type": "number"})]
Text = Annotated[str, PlainValidator(text), WithJsonSchema({"type": "string", "minLength": 1})]
Pair = Annotated[tuple[Number, Number], list_of(2, "2 numbers"), AfterValidator(ascending)]


def at_least_zero(value: Fraction) -> Fraction:
    """Return a number that is not negative."""
    if value < 0:
        raise ValueError(f"must not be negative, got {decimal(value)}")
    return value


class Tolerance(Block):
    """An uncertain scalar as value and half width."""

    value: Number
    tolerance: Annotated[Number, AfterValidator(at_least_zero)]


Quantity = Annotated[
    Annotated[Number, Tag(SHAPES[0])]
    | Annotated[Tolerance, Tag(SHAPES[1])]
    | Annotated[Pair, Tag(SHAPES[2])],
    Discriminator(_shape),
]
Vector = Annotated[tuple[Quantity, Quantity, Quantity], list_of(3, "3 numbers")]


def bounds(quantity: Fraction | Tolerance | tuple[Fraction, Fraction]) -> tuple[Fraction, Fraction]:
    """Return the exact lower and upper bound of a quantity."""
    if isinstance(quantity, Fraction):
        return quantity, quantity
    if isinstance(quantity, Tolerance):
        return quantity.value - quantity.tolerance, quantity.value + quantity.tolerance
    return quantity


def positive(value: Any) -> Any:
    """Return a quantity that is above 0, bounds and all."""
    lowest = bounds(value)[0]
    if lowest <= 0:
        raise ValueError(f"must be greater than 0, got {decimal(lowest)}")
    return value


def not_zero(value: Any) -> Any:
    """Return a vector that is not zero for sure."""
    if all(lo <= 0 <= hi for lo, hi in map(bounds, value)):
        raise ValueError("must not be the zero vector: without a load there are no statics")
    return value


def tension_limits(value: tuple[Fraction, Fraction]) -> tuple[Fraction, Fraction]:
    """Return two tensions, none of them negative."""
    at_least_zero(value[0])
    return value


def lengths_rising(value: tuple[Fraction, Fraction]) -> tuple[Fraction, Fraction]:
    """Return two lengths, both above 0 and the second one larger."""
    if value[0] <= 0 or value[0] == value[1]:
        got = f"[{decimal(value[0])}, {decimal(value[1])}]"
        raise ValueError(f"must be two lengths above 0, the second larger, got {got}")
    return value


Positive = Annotated[Quantity, AfterValidator(positive)]
PositiveNumber = Annotated[Number, AfterValidator(positive)]
NotNegativeNumber = Annotated[Number, AfterValidator(at_least_zero)]
Name = Annotated[Text, AfterValidator(one_line)]


def flag(value: object) -> bool:
    """Return true or false."""
    if isinstance(value, Node) and isinstance(value.value, bool):
        return value.value
    raise ValueError(f"must be true or false, got {kind(value)}")


Flag = Annotated[bool, PlainValidator(flag), WithJsonSchema({"type": "boolean"})]


def integer(least: int, most: int) -> Any:
    """Return the type of an integer between two bounds."""

    def check(value: object) -> int:
        found = number(value)
        if found.denominator != 1 or not least <= found <= most:
            raise ValueError(f"must be an integer from {least} to {most}, got {decimal(found)}")
        return int(found)

    rule = {"type": "integer", "minimum": least, "maximum": most}
    return Annotated[int, PlainValidator(check), WithJsonSchema(rule)]


def one_of(*names: str) -> Any:
    """Return the type of a text that is one of a few."""

    def check(value: object) -> str:
        if isinstance(value, Node) and value.value in names:
            return str(value.value)
        raise ValueError(f"must be one of {', '.join(names)}, got {kind(value)}")

    return Annotated[str, PlainValidator(check), WithJsonSchema({"enum": list(names)})]


def constant(name: str) -> Any:
    """Return the type of a key ``type`` that `known_type` has checked already."""
    return Annotated[str, PlainValidator(lambda value: name), WithJsonSchema({"const": name})]


def type_tag(value: Any) -> str:
    """Return the tag of a block that says in ``type`` what it is."""
    given = value["type"]
    return f"<{given.value}>" if isinstance(given, Node) and isinstance(given.value, str) else ""


def known_type(tags: Collection[str]) -> BeforeValidator:
    """Return a check that a mapping's ``type`` is one of some tags, before its model is chosen."""

    def check(value: object) -> object:
        if not isinstance(value, dict):
            raise ValueError(f"must be a mapping, got {kind(value)}")
        names = ", ".join(tag.strip("<>") for tag in tags)
        if "type" not in value:
            raise ValueError(f"type is missing, must be one of {names}")
        if type_tag(value) not in tags:
            raise ValueError(f"type must be one of {names}, got {kind(value['type'])}")
        return value

    return BeforeValidator(check)


class _AbsentNotNull(GenerateJsonSchema):
    """An optional key may be absent, never null."""

    def nullable_schema(self, schema: core_schema.NullableSchema) -> JsonSchemaValue:
        return self.generate_inner(schema["schema"])

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        return self.generate_inner(schema["schema"])


def schema_of(model: type[Block], title: str) -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a format from its model."""
    schema = model.model_json_schema(schema_generator=_AbsentNotNull)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": title}
