"""The numbers in a robot's data: exact, or known to lie between bounds; and what all its parts share."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator
from fractions import Fraction
from typing import Any, Self

from cdpr_interval.errors import InputError, NotSupportedError
from cdpr_interval.exact.range import Range, RangeVector, as_range
from cdpr_interval.exact.vector import Vector
from cdpr_interval.text.number import exact_number

Scalar = Fraction | Range
"""A number, or the bounds between which it lies."""
Point = tuple[Scalar, Scalar, Scalar]


def exact(value: Scalar) -> Fraction:
    """Return a number that is known exactly.

    Raises
    ------
    NotSupportedError
        For a range.
    """
    if isinstance(value, Range):
        raise NotSupportedError(f"a range is not supported here yet: [{value.lo}, {value.hi}]")
    return value


def exact_point(point: Point) -> Vector:
    """Return a point of which every coordinate is known exactly; raises as `exact` does."""
    x, y, z = point
    return exact(x), exact(y), exact(z)


def range_point(point: Point) -> RangeVector:
    """Return each number as a range."""
    x, y, z = map(as_range, point)
    return x, y, z


def middle(value: Scalar) -> Fraction:
    """Return a number, of a range its middle."""
    return value.mid if isinstance(value, Range) else value


def middle_point(point: Point) -> Vector:
    """Return a point with every range replaced by its middle."""
    x, y, z = point
    return middle(x), middle(y), middle(z)


def is_exact_point(point: Point) -> bool:
    """Return True when no coordinate is a range."""
    return not any(isinstance(x, Range) for x in point)


def entries(path: str, point: Point) -> Iterator[tuple[str, Scalar]]:
    """Yield the numbers of a point, each with its path in a file."""
    for i, value in enumerate(point):
        yield f"{path}[{i}]", value


def read_scalar(value: Any, name: str) -> Scalar:
    """Return a number or a range as this module keeps it; `InputError` with the name for anything else."""
    if type(value) in (Fraction, Range):
        found: Scalar = value
        return found
    try:
        if isinstance(value, list | tuple) and len(value) == 2:
            lo, hi = map(exact_number, value)
            if lo > hi:
                raise ValueError(f"the lower bound {value[0]} is above the upper bound {value[1]}")
            return lo if lo == hi else Range(lo, hi)
        return exact_number(value)
    except ValueError as error:
        raise InputError(f"{name}: {error}") from None


def read_point(value: Any, name: str) -> Point:
    """Return three numbers as this module keeps them."""
    if type(value) is tuple and list(map(type, value)) == [Fraction] * 3:
        # The usual case first: a batch makes thousands of robots.
        x, y, z = value
        return x, y, z
    entries = tuple(value) if isinstance(value, Iterable) and not isinstance(value, str) else ()
    if len(entries) != 3:
        raise InputError(f"{name}: must be 3 numbers, got {value!r}")
    x, y, z = (read_scalar(entry, f"{name}[{i}]") for i, entry in enumerate(entries))
    return x, y, z


class Part:
    """A frozen part of a robot that is changed by making another one."""

    def replace(self, **changes: Any) -> Self:
        """Return a copy with other values in some fields.

        Raises
        ------
        InputError
            There is no such field, or the value breaks a rule.
        """
        known = [f.name for f in dataclasses.fields(self) if f.init]  # type: ignore[arg-type]
        wrong = [name for name in changes if name not in known]
        if wrong:
            rule = f"{type(self).__name__} has no {', '.join(wrong)}, only {', '.join(known)}"
            raise InputError(f"replace: {rule}")
        return dataclasses.replace(self, **changes)  # type: ignore[type-var]

    def _keep(self, name: str, value: object) -> None:
        """Put a value into a field while the object is made."""
        object.__setattr__(self, name, value)
