"""The block of a ``cdpr-problem/1`` file as a pydantic model, from which its JSON Schema and page come."""

from __future__ import annotations

from fractions import Fraction
from typing import Annotated, Any

from pydantic import Discriminator, PlainValidator, Tag, WithJsonSchema

from cdpr_interval.files.document import Node
from cdpr_interval.files.fields import Block, kind
from cdpr_interval.text.literal import quote
from solvers.questions.lengths import read_length

PROBLEM_FORMAT = "cdpr-problem/1"
TAGS = ("<list>", "<mapping>")
NUMBER = {"type": "number"}
LENGTH = {
    "description": "2.69, '2.69+-0.01', '2.68..2.70', [2.68, 2.70], or value and tolerance, in m",
    "anyOf": [
        NUMBER,
        {"type": "string"},
        {"type": "array", "items": NUMBER, "minItems": 2, "maxItems": 2},
        {
            "type": "object",
            "properties": {"value": NUMBER, "tolerance": {"type": "number", "minimum": 0}},
            "required": ["value", "tolerance"],
            "additionalProperties": False,
        },
    ],
}


def _format(value: object) -> str:
    if not (isinstance(value, Node) and value.value == PROBLEM_FORMAT):
        raise ValueError(f"must be {quote(PROBLEM_FORMAT)}, got {kind(value)}")
    return PROBLEM_FORMAT


def length(value: object) -> Any:
    """Return the exact range of one length."""
    if isinstance(value, Node) and isinstance(value.value, Fraction | str):
        return read_length(value.value)
    if isinstance(value, list) and len(value) == 2:
        return read_length(tuple(_number(entry) for entry in value))
    if isinstance(value, dict) and set(value) == {"value", "tolerance"}:
        middle, tolerance = _number(value["value"]), _number(value["tolerance"])
        if tolerance < 0:
            raise ValueError("the tolerance is negative")
        return read_length((middle - tolerance, middle + tolerance))
    raise ValueError(f"must be a length such as 2.69, 2.69+-0.01 or [2.68, 2.70], got {kind(value)}")


def _number(value: object) -> Fraction:
    if not (isinstance(value, Node) and isinstance(value.value, Fraction)):
        raise ValueError(f"must hold numbers, got {kind(value)}")
    return value.value


def _spelling(value: object) -> str:
    return TAGS[isinstance(value, dict)]


def _force(value: object) -> Any:
    if not (isinstance(value, list) and len(value) == 3):
        raise ValueError(f"must be a list of 3 numbers, got {kind(value)}")
    return tuple(_number(entry) for entry in value)


Length = Annotated[Any, PlainValidator(length), WithJsonSchema(LENGTH)]
Force = Annotated[
    Any,
    PlainValidator(_force),
    WithJsonSchema({"type": "array", "items": NUMBER, "minItems": 3, "maxItems": 3}),
]


class ProblemBlock(Block):
    """Cable lengths and an optional external force: what is asked of a robot."""

    format: Annotated[str, PlainValidator(_format), WithJsonSchema({"const": PROBLEM_FORMAT})]
    """The format."""
    lengths_m: Annotated[
        Annotated[list[Length], Tag(TAGS[0])] | Annotated[dict[str, Length], Tag(TAGS[1])],
        Discriminator(_spelling),
    ]
    """One length for each cable: a list in the order of the robot's file, or a mapping from names;
    unstretched for elastic cables."""
    external_force_N: Force | None = None
    """Constant force at the centre of mass, base axes, added to the weight; default none."""
