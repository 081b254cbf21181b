"""The block of a ``cdpr-problem/1`` file as a pydantic model, from which its JSON Schema and page come."""

from __future__ import annotations

from fractions import Fraction
from typing import Annotated, Any

from pydantic import Discriminator, PlainValidator, Tag, WithJsonSchema

from cdpr_interval.exact.range import Range
from cdpr_interval.files.document import Node
from cdpr_interval.files.fields import Block, kind, list_of
from cdpr_interval.robots.numbers import Scalar
from cdpr_interval.text.literal import quote
from solvers.questions.lengths import read_length
from solvers.questions.ranges import around, read_range
from solvers.questions.units import NEWTONS

PROBLEM_FORMAT = "cdpr-problem/1"
TAGS = ("<list>", "<mapping>")
NUMBER = {"type": "number"}
RANGES = [
    NUMBER,
    {"type": "string"},
    {"type": "array", "items": NUMBER, "minItems": 2, "maxItems": 2},
    {
        "type": "object",
        "properties": {"value": NUMBER, "tolerance": {"type": "number", "minimum": 0}},
        "required": ["value", "tolerance"],
        "additionalProperties": False,
    },
]
LENGTH = {
    "description": "2.69, '2.69+-0.01', '2.68..2.70', [2.68, 2.70], or value and tolerance, in m",
    "anyOf": RANGES,
}
COMPONENT = {
    "description": "5, '5+-0.1', '4..6', [4, 6], or value and tolerance, in N",
    "anyOf": RANGES,
}


def _format(value: object) -> str:
    if not (isinstance(value, Node) and value.value == PROBLEM_FORMAT):
        raise ValueError(f"must be {quote(PROBLEM_FORMAT)}, got {kind(value)}")
    return PROBLEM_FORMAT


def length(value: object) -> Any:
    """Return the exact range of one length."""
    given = _plain(value)
    if given is None:
        raise ValueError(f"must be a length such as 2.69, 2.69+-0.01 or [2.68, 2.70], got {kind(value)}")
    return read_length(given)


def _plain(value: object) -> Any:
    """Return a number, a text or two bounds, as readers of ranges take them; None for anything else."""
    if isinstance(value, Node) and isinstance(value.value, Fraction | str):
        return value.value
    if isinstance(value, list) and len(value) == 2:
        return tuple(_number(entry) for entry in value)
    if isinstance(value, dict) and set(value) == {"value", "tolerance"}:
        return around(_number(value["value"]), _number(value["tolerance"]))
    return None


def _number(value: object) -> Fraction:
    if not (isinstance(value, Node) and isinstance(value.value, Fraction)):
        raise ValueError(f"must hold numbers, got {kind(value)}")
    return value.value


def _spelling(value: object) -> str:
    return TAGS[isinstance(value, dict)]


def component(value: object) -> Scalar:
    """Return one entry of a force: a number or a range."""
    given = _plain(value)
    if given is None:
        raise ValueError(f"must be a number or a range such as [4, 6], got {kind(value)}")
    lo, hi = read_range(given, NEWTONS)
    return lo if lo == hi else Range(lo, hi)


Length = Annotated[Any, PlainValidator(length), WithJsonSchema(LENGTH)]
Component = Annotated[Any, PlainValidator(component), WithJsonSchema(COMPONENT)]
Force = Annotated[tuple[Component, Component, Component], list_of(3, "3 numbers")]


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
