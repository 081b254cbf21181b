"""Numbers given as options of the command line."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from cdpr_interval.errors import InputError
from cdpr_interval.text.literal import printable, quote, read_number

if TYPE_CHECKING:
    from fractions import Fraction

    from cdpr_interval.robots.cable_robot import Robot


def read_float(text: str, label: str) -> float:
    """Return the double nearest to a number; `InputError` when the text is none."""
    try:
        return float(read_number(text.strip()))
    except ValueError as error:
        raise InputError(f"{label}: {error}") from None


def read_distance(text: str, label: str) -> float:
    """Return the double nearest to a length in m, mm or cm; `InputError` when the text is none."""
    from solvers.questions.units import read_metres

    try:
        return float(read_metres(text.strip()))
    except ValueError as error:
        raise InputError(f"{label}: {error}") from None


def read_count(text: str, label: str) -> int:
    """Return a whole number; `InputError` when the text is none."""
    try:
        value = read_number(text.strip())
    except ValueError as error:
        raise InputError(f"{label}: {error}") from None
    if value.denominator != 1:
        raise InputError(f"{label}: {quote(text)} is not a whole number")
    return int(value)


def say_middles(text: str, label: str) -> None:
    """Say on standard error how a pose with tolerances is read, as tables print them."""
    from solvers.questions.pose import middles_of

    if (middles := middles_of(text, label)) != text:
        click.echo(f"{label}: without its tolerances, read as {printable(middles)}", err=True)


def warn_of_lengths(
    robot: Robot, lengths: Sequence[tuple[float | Fraction, float | Fraction]], label: str
) -> None:
    """Say on standard error what lengths are beyond limits of legs, or far beyond the size of the robot.

    They are taken as given.
    """
    from solvers.questions.scale import absurd_lengths
    from solvers.questions.strokes import beyond_limits

    absurd = absurd_lengths(robot, lengths)
    for text in [*([absurd] if absurd else []), *beyond_limits(robot, lengths)]:
        click.echo(f"warning: {label}: {text}", err=True)
