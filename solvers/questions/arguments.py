"""Arguments of Python callers: the kinds they must be of, so that a wrong one is said by its name."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from numbers import Integral, Real
from pathlib import Path
from typing import Any

from cdpr_interval.errors import InputError
from solvers.questions.errors import InputErrors

Label = Callable[[str], str]
"""From a parameter's name to what messages call it."""


def check_positive(errors: InputErrors, label: Label, **given: Any) -> None:
    """Note every argument that is not a positive, finite number; None is none."""
    for name, value in given.items():
        if value is not None and not (is_number(value) and value > 0.0):
            errors.add(f"{label(name)}: must be a positive number, got {shown(value)}")


def check_counts(errors: InputErrors, label: Label, **given: Any) -> None:
    """Note every argument that is not a whole number from 1; None is none."""
    for name, value in given.items():
        if value is None:
            continue
        if not isinstance(value, Integral) or isinstance(value, bool):
            errors.add(f"{label(name)}: must be a whole number, got {shown(value)}")
        elif value < 1:
            errors.add(f"{label(name)}: must be at least 1, got {value!r}")


def require_flags(**given: Any) -> None:
    """Raise `InputError` for every argument that is no bool: ``"no"`` and ``nan`` would count as true."""
    errors = InputErrors()
    for name, value in given.items():
        if not isinstance(value, bool):
            errors.add(f"{name}: must be True or False, got {shown(value)}")
    errors.require_none()


def check_called(errors: InputErrors, label: Label, **given: Any) -> None:
    """Note every argument that cannot be called; None is none."""
    for name, value in given.items():
        if value is not None and not callable(value):
            errors.add(f"{label(name)}: must be a function, got {shown(value)}")


def read_path(given: Any, label: str) -> Path:
    """Return a path; `InputError` for what names no file."""
    if not isinstance(given, str | os.PathLike) or not os.fspath(given) or "\0" in str(given):
        raise InputError(f"{label}: must be the name of a file, got {shown(given)}")
    return Path(given)


def is_number(value: Any) -> bool:
    """Return whether a value is a finite real number."""
    return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)


def shown(value: Any) -> str:
    """Return a value for a message: short ones as they are, of others the type."""
    text = repr(value)
    return text if len(text) <= 40 and "\n" not in text and " at 0x" not in text else type(value).__name__
