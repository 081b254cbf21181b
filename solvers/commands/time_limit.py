"""The option ``--time-limit``, read alike by every command that has it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from cdpr_interval.errors import InputError
from solvers.questions.errors import InputErrors

LABEL = "--time-limit"


def time_limit_option(help_text: str, default: str | None = None) -> Callable[[Any], Any]:
    """Return the option."""
    shown = default is not None
    return click.option(LABEL, metavar="S", default=default, show_default=shown, help=help_text)


def read_time_limit(given: dict[str, Any], errors: InputErrors | None = None) -> float | None:
    """Return the s of the command line; None where there are none.

    Raises
    ------
    InputError
        When it is no positive time (``90``, ``90s``, ``1.5min``), and no ``errors`` to note that in.
    """
    if given["time_limit"] is None:
        return None
    noted = InputErrors() if errors is None else errors
    found = noted.read(_seconds, given["time_limit"])
    if errors is None:
        noted.require_none()
    return found


def _seconds(text: str) -> float:
    from solvers.questions.units import read_seconds

    try:
        seconds = float(read_seconds(text.strip()))
    except ValueError as error:
        raise InputError(f"{LABEL}: {error}") from None
    if seconds <= 0.0:
        raise InputError(f"{LABEL}: must be a positive number, got {seconds!r}")
    return seconds
