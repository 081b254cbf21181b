"""``cdpr-solve mobility``: degrees of freedom of a mechanism, by count and by rank."""

from __future__ import annotations

from typing import Any

import click

from solvers.commands.target import JsonTarget, json_option
from solvers.questions.errors import InputErrors
from solvers.shell.completion import files
from solvers.shell.examples import examples


@click.command(
    "mobility",
    short_help="Degrees of freedom of a mechanism, by count and by rank.",
    epilog=examples("mobility delta_12_balls", "mobility four_bar --json -"),
)
@click.argument("mechanism", shell_complete=files)
@json_option
@click.option("-q", "--quiet", is_flag=True, help="No table.")
@click.option("-v", "--verbose", is_flag=True, help="More about errors.")
def command(mechanism: str, **given: Any) -> int:
    """Count the freedoms of MECHANISM, a mechanism/1 file or the name of one that ships.

    Gruebler's formula with its loops; where points and axes of all joints are given, also the exact rank of
    what the loops demand, which tells over-constraint and idle spins from freedoms of the platform.
    """
    from solvers.kinematics.mobility import mobility

    target = None if given["json_file"] is None else JsonTarget(given["json_file"])
    errors = InputErrors()
    if target is not None:
        errors.read(target.require_writable)
    found = errors.read(mobility, mechanism)
    errors.require_none()
    assert found is not None
    if target is not None:
        target.write(found.to_json())
    if not given["quiet"] and (target is None or not target.is_stdout):
        click.echo(str(found))
    return 0
