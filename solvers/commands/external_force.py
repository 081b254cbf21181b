"""The option ``--external-force``, for every command that asks about a pose under a load."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from cdpr_interval.exact.vector import Vector
    from solvers.questions.errors import InputErrors

LABEL = "--external-force"

external_force_option = click.option(
    LABEL, metavar="X,Y,Z", help="Force in N at the centre of mass, base axes, added to the weight."
)


def read_external_force(given: dict[str, Any], errors: InputErrors) -> Vector | None:
    """Return the force of the command line, exactly; None where there is none or it is no force."""
    from solvers.questions.force import read_force

    text = given["external_force"]
    return None if text is None else errors.read(read_force, text, LABEL)
