"""Vectors as lists of numbers of any kind: floats, exact numbers, balls, forms, jets."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import add
from typing import Any


def total(terms: Sequence[Any]) -> Any:
    """Return a sum."""
    return reduce(add, terms)


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Return a . b."""
    return total([x * y for x, y in zip(a, b, strict=True)])


def cross(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """Return a x b."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def minus(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """Return a - b."""
    return [x - y for x, y in zip(a, b, strict=True)]
