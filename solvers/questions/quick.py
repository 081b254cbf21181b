"""The input of prepared solvers, read in microseconds where it is plain floats."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np

from cdpr_interval.exact.enclosure import Bounds, length_bounds
from cdpr_interval.text.number import LARGEST, SMALLEST
from solvers.questions.errors import InputErrors
from solvers.questions.lengths import read_lengths

T = TypeVar("T")


def quick_bounds(lengths: Any, count: int) -> Bounds | None:
    """Return bounds (count, 2) of lengths that are floats, pairs of floats or an array; None for others.

    What is wrong with others is found, and said, by the reader of lengths.
    """
    if isinstance(lengths, np.ndarray) and lengths.dtype == np.float64:
        lengths = lengths.tolist()
    if type(lengths) not in (list, tuple) or len(lengths) != count:
        return None
    ends: list[float] = []
    for value in lengths:
        if isinstance(value, float):
            lo = hi = value
        elif type(value) in (list, tuple) and len(value) == 2:
            lo, hi = value
            if not (isinstance(lo, float) and isinstance(hi, float)):
                return None
        else:
            return None
        if not SMALLEST <= lo <= hi < LARGEST:
            # Also NaN.
            return None
        ends += (lo, hi)
    return np.array(ends).reshape(-1, 2)


def force_key(force: Any) -> tuple[float, ...] | None:
    """Return a force given as plain floats as a tuple; None for other spellings, which are read anew."""
    if not isinstance(force, list | tuple | np.ndarray):
        return None
    values = tuple(force)
    return values if all(isinstance(value, float) for value in values) else None


def checked(
    lengths: Any, bounds: Bounds | None, names: Sequence[str], under: Callable[[Any], T], external_force: Any
) -> tuple[Bounds, T]:
    """Return bounds of the lengths (read where they are not known) and what ``under`` makes of the force.

    Raises
    ------
    InputError
        With every error of both.
    """
    errors = InputErrors()
    if bounds is None:
        bounds = length_bounds(errors.read(read_lengths, lengths, names) or ())
    found = errors.read(under, external_force)
    errors.require_none()
    assert found is not None
    return bounds, found
