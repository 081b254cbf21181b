"""The option ``--external-force``, for every command that asks about a pose under a load."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from cdpr_interval.robots.numbers import Point
    from solvers.questions.errors import InputErrors

LABEL = "--external-force"

external_force_option = click.option(
    LABEL, metavar="X,Y,Z", help="Force in N at the centre of mass, base axes, added to the weight."
)


def read_external_force(given: dict[str, Any], errors: InputErrors, ranges: bool = False) -> Point | None:
    """Return the force of the command line, exactly; None where there is none or it is no force.

    A range is one only where ``ranges`` says so, else an error.
    """
    from solvers.questions.force import read_force, read_force_ranges

    text = given["external_force"]
    return None if text is None else errors.read(read_force_ranges if ranges else read_force, text, LABEL)
