"""Kinds of values in results: arrays and indices in Python, lists with units and names of cables in JSON.

The classes are markers in the annotations of result data. pydantic asks them for their schemas when the first
document is written or read; nothing here imports it before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Annotated, Any, ClassVar

import numpy as np

from cdpr_interval.exact.decimals import exact_text
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.exact.range import LengthRange, Range
from cdpr_interval.text.count import counted
from solvers.answers.robot_data import LONGEST, robot_from_json, robot_to_json

CABLES, ANY = "N", "m"
"""Lengths of an axis: the number of cables, and any."""
UNITS = {
    "angle": "rad",
    "angle_ranges": "rad",
    "angles": "rad",
    "axis_point": "m",
    "bar_angles": "rad",
    "distance": "m",
    "distances": "m",
    "elbow_angles": "rad",
    "external_force": "N",
    "force": "N",
    "height": "m",
    "lengths": "m",
    "moment": "N_m",
    "near": "m",
    "other_branch": "rad",
    "other_positions": "m",
    "position": "m",
    "positions": "m",
    "rpy": "rad",
    "settle_within": "m",
    "step": "s",
    "t": "s",
    "tension": "N",
    "tensions": "N",
    "tensions_given": "N",
    "time": "s",
    "tolerance": "m",
    "travel": "m",
}
"""What the key of a field has at its end."""
Shape = tuple[int | str, ...]


def key_of(name: str) -> str:
    """Return the key of a field in JSON."""
    return f"{name}_{UNITS[name]}" if name in UNITS else name


class Described:
    """Base of the dataclasses that are objects in JSON, read strictly."""

    __pydantic_config__: ClassVar[dict[str, Any]] = {
        "alias_generator": key_of,
        "strict": True,
        "allow_inf_nan": False,
    }


class Numbers:
    """Bounds in an array of one of some shapes; an infinite one is null in JSON.

    Parameters
    ----------
    shapes : tuple of int or str
        The last axis is (lo, hi); ``CABLES`` and ``ANY`` are lengths of axes too.
    """

    def __init__(self, *shapes: Shape) -> None:
        self._shapes = shapes

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Return how the array is read and written."""
        from pydantic_core import core_schema

        written = core_schema.plain_serializer_function_ser_schema(numbers)
        return core_schema.with_info_plain_validator_function(self._read, serialization=written)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        """Return nested lists of the lengths of the axes."""
        options = [_nested(shape) for shape in self._shapes]
        return options[0] if len(options) == 1 else {"anyOf": options}

    def _read(self, value: Any, info: Any) -> Bounds:
        shapes = [tuple(len(info.context) if n == CABLES else n for n in shape) for shape in self._shapes]
        for shape in shapes:
            if _has_shape(value, shape):
                return np.array(_ends(value, 0), dtype=np.float64).reshape(_lengths(value, shape))
        wanted = " or ".join(
            "(" + ", ".join(map(str, s)) + ("," if len(s) == 1 else "") + ")" for s in shapes
        )
        raise ValueError(f"must be numbers in the shape {wanted}")


class AsNames:
    """Indices of cables; their names in JSON."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Return how indices are read and written; the context holds the names in file order."""
        from pydantic_core import core_schema

        written = core_schema.plain_serializer_function_ser_schema(_names, info_arg=True)
        return core_schema.with_info_plain_validator_function(_indices, serialization=written)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        """Return a list of names."""
        return {"type": "array", "items": {"type": "string"}}


class PerCable:
    """A list with one entry for each cable."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Return the rule; the context holds the names of the cables."""
        from pydantic_core import core_schema

        return core_schema.with_info_after_validator_function(_one_each, handler(source))


class OrUndecided:
    """True, false, or None, which is ``undecided`` in JSON."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Return how the word is read and written."""
        from pydantic_core import core_schema

        def read(value: Any) -> bool | None:
            if isinstance(value, bool) or value == UNDECIDED:
                return None if value == UNDECIDED else value
            raise ValueError("must be true, false or 'undecided'")

        written = core_schema.plain_serializer_function_ser_schema(lambda v: UNDECIDED if v is None else v)
        return core_schema.no_info_plain_validator_function(read, serialization=written)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        """Return the three words."""
        return {"enum": [True, False, UNDECIDED]}


UNDECIDED = "undecided"


class NotNegative:
    """A whole number from 0."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Return the bound."""
        from pydantic_core import core_schema

        return core_schema.int_schema(ge=0, strict=True)


class ExactRanges:
    """Exact ranges; in JSON texts such as 7.1 or 7.099..7.101."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Return how ranges are read and written."""
        return _of_texts(_read_range, _range_text, "a list of numbers or ranges as texts")

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        """Return a list of texts."""
        return {"type": "array", "items": {"type": "string"}}


class ExactScalars:
    """Exact numbers and ranges; in JSON texts such as 7.1 or 7.099..7.101."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Return how numbers are read and written."""
        return _of_texts(_read_scalar, _scalar_text, "a list of numbers or ranges as texts")

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        """Return a list of texts."""
        return {"type": "array", "items": {"type": "string"}}


class RobotData:
    """A robot; in JSON the text of its file, or its data in exact numbers."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Return how a robot is read and written."""
        from pydantic_core import core_schema

        written = core_schema.plain_serializer_function_ser_schema(robot_to_json)
        return core_schema.no_info_plain_validator_function(robot_from_json, serialization=written)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        """Return a text or an object."""
        return {"type": ["string", "object"]}


Interval = Annotated[Bounds, Numbers((2,))]
Vector = Annotated[Bounds, Numbers((3, 2))]
Matrix = Annotated[Bounds, Numbers((3, 3, 2))]
OfCables = Annotated[Bounds, Numbers((CABLES, 2))]
Cables = Annotated[tuple[int, ...], AsNames()]
Count = Annotated[int, NotNegative()]
Floats = Annotated[tuple[float, ...], PerCable()]
Triple = tuple[float, float, float]
FloatOrRange = float | tuple[float, float]
Quadruple = tuple[float, float, float, float]


def _of_texts(read: Callable[[str], Any], write: Callable[[Any], str], what: str) -> Any:
    """Return how a tuple of exact values is read and written, as a list of texts."""
    from pydantic_core import core_schema

    def read_all(value: Any) -> Any:
        if not isinstance(value, list) or not all(isinstance(entry, str) for entry in value):
            raise ValueError(f"must be {what}")
        try:
            return tuple(read(entry) for entry in value)
        except (ValueError, ZeroDivisionError):
            raise ValueError(f"must be {what}") from None

    written = core_schema.plain_serializer_function_ser_schema(lambda values: [write(v) for v in values])
    return core_schema.no_info_plain_validator_function(read_all, serialization=written)


def _read_range(text: str) -> LengthRange:
    lo, _, hi = text.partition("..")
    return Fraction(lo), Fraction(hi or lo)


def _range_text(ends: LengthRange) -> str:
    lo, hi = (exact_text(end, LONGEST) for end in ends)
    return lo if lo == hi else f"{lo}..{hi}"


def _read_scalar(text: str) -> Fraction | Range:
    lo, hi = _read_range(text)
    return lo if lo == hi else Range(lo, hi)


def _scalar_text(value: Fraction | Range) -> str:
    return _range_text(value if isinstance(value, Range) else (value, value))


def floats_of(values: tuple[Any, Any, Any]) -> tuple[FloatOrRange, FloatOrRange, FloatOrRange]:
    """Return the doubles nearest to three exact numbers, or to the ends of ranges."""
    x, y, z = ((float(v.lo), float(v.hi)) if isinstance(v, Range) else float(v) for v in values)
    return x, y, z


def numbers(bounds: Bounds) -> Any:
    """Return bounds as lists, with null for those that are infinite."""
    values = np.asarray(bounds, dtype=np.float64)
    return values.tolist() if np.isfinite(values).all() else _finite(values.tolist())


def _finite(value: Any) -> Any:
    if isinstance(value, list):
        return [_finite(entry) for entry in value]
    if math.isnan(value):
        raise ValueError("a bound of a result is NaN")
    return value if math.isfinite(value) else None


def _has_shape(value: Any, shape: Sequence[int | str]) -> bool:
    """Return whether nested lists of numbers (or null) have a shape."""
    if not shape:
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return value is None or (is_number and math.isfinite(value))
    if not isinstance(value, list) or shape[0] not in (ANY, len(value)):
        return False
    return all(_has_shape(entry, shape[1:]) for entry in value)


def _lengths(value: list[Any], shape: Sequence[int | str]) -> tuple[Any, ...]:
    """Return the shape with the length of its first axis: only that may be any."""
    return (len(value), *shape[1:])


def _ends(value: Any, place: int) -> Any:
    """Return nested lists of floats: null is an infinite bound, its sign given by its place in the pair."""
    if isinstance(value, list):
        return [_ends(entry, i) for i, entry in enumerate(value)]
    if value is None:
        return -math.inf if place == 0 else math.inf
    return float(value)


def _nested(shape: Sequence[int | str]) -> dict[str, Any]:
    """Return the JSON Schema of nested lists."""
    if len(shape) == 1:
        return {"type": "array", "items": {"type": ["number", "null"]}, "minItems": 2, "maxItems": 2}
    found = {"type": "array", "items": _nested(shape[1:])}
    return found if isinstance(shape[0], str) else {**found, "minItems": shape[0], "maxItems": shape[0]}


def _names(indices: Sequence[int], info: Any) -> list[str]:
    return [info.context[index] for index in indices]


def _one_each(value: tuple[Any, ...], info: Any) -> tuple[Any, ...]:
    if len(value) != len(info.context):
        cables = counted(len(info.context), "cable")
        raise ValueError(f"must hold one entry for each of {cables}, holds {len(value)}")
    return value


def _indices(value: Any, info: Any) -> tuple[int, ...]:
    if not isinstance(value, list) or not all(name in info.context for name in value):
        raise ValueError("must be a list of cable names")
    return tuple(info.context.index(name) for name in value)
