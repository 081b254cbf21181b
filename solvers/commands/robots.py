"""``cdpr-solve robots``: the robots that ship with the program."""

from __future__ import annotations

import json
import shutil
import sys
from typing import TYPE_CHECKING, Any

import click

from solvers.shell.examples import examples

if TYPE_CHECKING:
    from cdpr_interval.robots.formats.reader import Machine

LEAST_SOURCE = 20
"""Characters of a source that are shown on any terminal."""


@click.command(
    "robots",
    short_help="The robots that ship with the program.",
    epilog=examples("robots", "fk uc2 --lengths 7.5,8"),
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON, sources in full.")
def command(as_json: bool) -> int:
    """List the robots that ship with the program, by the names that ROBOT may be.

    Class, number of cables, mass, and where the numbers come from; `validate NAME` shows all of one.
    """
    from cdpr_interval.robots.formats.reader import load_machine
    from cdpr_interval.robots.shipped import shipped_machines

    rows = [_row(name, load_machine(name)) for name in shipped_machines()]
    if as_json:
        click.echo(json.dumps(rows, ensure_ascii=False))
        return 0
    names = max(len(row["name"]) for row in rows)
    click.echo(f"{'name':{names}}  class       cables  mass kg  source")
    for row in rows:
        start = f"{row['name']:{names}}  {row['model']:10}  {row['cables']:6}  {_mass(row['mass_kg']):>7}  "
        click.echo(start + _fitted(row["source"], len(start)))
    return 0


def _row(name: str, robot: Machine) -> dict[str, Any]:
    return {
        "name": name,
        "model": robot.model,
        "cables": len(robot.cable_names),
        "mass_kg": _mass_of(robot),
        "source": " ".join((robot.source or "").split()),
    }


def _mass_of(robot: Machine) -> float | list[float] | None:
    from cdpr_interval.exact.range import as_range
    from cdpr_interval.robots.cable_robot import Robot

    if not isinstance(robot, Robot):
        return None
    lo, hi = map(float, as_range(robot.platform.mass))
    return lo if lo == hi else [lo, hi]


def _mass(mass: float | list[float] | None) -> str:
    if mass is None:
        return "-"
    return f"{mass:g}" if isinstance(mass, float) else "..".join(f"{end:g}" for end in mass)


def _fitted(text: str, used: int) -> str:
    """Return what of a text fits into the line of a terminal; all of it elsewhere."""
    if not sys.stdout.isatty():
        return text
    room = max(shutil.get_terminal_size().columns - used, LEAST_SOURCE)
    return text if len(text) <= room else f"{text[: room - 3]}..."
