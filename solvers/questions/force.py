"""The constant external force at the centre of mass, as a user gives it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.exact.vector import Vector
from cdpr_interval.text.number import exact_number
from solvers.questions.units import NEWTONS, entries_of, read_quantity

ZERO: Vector = (Fraction(0), Fraction(0), Fraction(0))
NO_LOAD = "the weight and the external force cancel; without a load there are no statics"


def read_force(given: Sequence[Any], label: str = "external_force") -> Vector:
    """Return an exact force in N, of numbers or of texts that may have their unit (``-10N``).

    Raises
    ------
    InputError
        Names every entry that is no number, or no force.
    """
    if not isinstance(given, Iterable):
        raise InputError(f"{label}: must hold 3 numbers, got {given!r}")
    values = entries_of(given, label) if isinstance(given, str) else list(given)
    if len(values) != 3:
        raise InputError(f"{label}: must hold 3 numbers, got {len(values)}")
    errors, numbers = [], []
    for index, value in enumerate(values):
        try:
            text = isinstance(value, str)
            numbers.append(read_quantity(value.strip(), NEWTONS) if text else exact_number(value))
        except ValueError as error:
            errors.append(f"{label}[{index}]: {error}")
    if errors:
        raise InputError(*errors)
    x, y, z = numbers
    return x, y, z
