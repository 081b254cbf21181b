"""``cdpr-solve validate``: reads a robot file and prints what it says, or every error in it."""

from __future__ import annotations

from fractions import Fraction
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cdpr_interval.text.count import counted
from solvers.shell.completion import robots
from solvers.shell.examples import examples

if TYPE_CHECKING:
    from cdpr_interval.robots.cable_robot import Cable, Robot
    from cdpr_interval.robots.delta import DeltaRobot
    from cdpr_interval.robots.numbers import Point, Scalar
    from cdpr_interval.robots.pulley import Pulley
    from solvers.commands.target import JsonTarget

FORMAT = "cdpr-validation/1"
DATA = "cdpr_interval.robots"
"""The package that holds schema and template."""
SCHEMA, TEMPLATE = "schemas/cdpr-robot-1.schema.json", "template.yaml"


@click.command(
    "validate",
    short_help="Read a robot file and print a summary, or every error.",
    epilog=examples("validate merlet_4_1", "validate --template", "validate --schema"),
)
@click.argument("robot", required=False, shell_complete=robots)
@click.option("--json", "target", metavar="FILE|-", help="Write the summary as JSON; with - nothing else.")
@click.option("-q", "--quiet", is_flag=True, help="No summary; warnings and errors always.")
@click.option(
    "--template", is_flag=True, help="Print a robot file with comments, to be filled in: `> crane.yaml`."
)
@click.option("--schema", is_flag=True, help="Print where the JSON Schema of robot files is, for editors.")
def command(robot: str | None, target: str | None, quiet: bool, template: bool, schema: bool) -> int:
    """Read ROBOT and print a summary, or every error with line and column.

    Warnings tell what is allowed and hardly meant (millimetres typed as metres), and what this version cannot
    solve yet. Exit code 0: the file is valid, also with warnings; 2: it is not.
    """
    from cdpr_interval.errors import InputError
    from cdpr_interval.robots.delta import DeltaRobot
    from cdpr_interval.robots.doubts import doubts
    from cdpr_interval.robots.formats.reader import load_machine
    from solvers.classes import class_of
    from solvers.commands.target import JsonTarget

    if template or schema:
        if robot is not None or (template and schema):
            raise InputError("validate: needs one of ROBOT, --template and --schema")
        click.echo(_template() if template else _schema_path(), nl=not template)
        return 0
    if robot is None:
        raise InputError("validate: ROBOT is missing: a robot file, or the name of a shipped robot")
    out = None if target is None else JsonTarget(target)
    if out is not None:
        out.require_writable()
    found = load_machine(robot)
    if isinstance(found, DeltaRobot):
        return _delta(found, out, quiet)
    reason = class_of(found).refuses(found)
    said = doubts(found)
    if out is not None:
        from solvers.answers.json_text import dumps

        out.write(dumps(_document(found, reason, said)))
    if not (quiet or (out is not None and out.is_stdout)):
        for line in _summary(found):
            click.echo(line)
    for doubt in said:
        click.echo(f"warning: {doubt}", err=True)
    if reason is not None:
        click.echo(f"warning: this version cannot solve it: {reason}", err=True)
    return 0


def _delta(robot: DeltaRobot, out: JsonTarget | None, quiet: bool) -> int:
    """Print and write the summary of a Delta."""
    if out is not None:
        from solvers.answers.json_text import dumps

        document = {
            "format": FORMAT,
            "robot": {"name": robot.name, "sha256": robot.sha256},
            "model": robot.model,
            "source": robot.source,
            "notes": robot.notes,
            "uncertain": [
                {"path": path, "bounds": [float(value.lo), float(value.hi)]}
                for path, value in robot.scalars()
                if not isinstance(value, Fraction)
            ],
            "warnings": [],
            "not_supported": None,
        }
        out.write(dumps(document))
    if quiet or (out is not None and out.is_stdout):
        return 0
    drives = "carriages on rails" if robot.is_linear else "turning arms"
    click.echo(f"{robot.name}: valid, Delta with {drives}")
    numbers = {
        "base radius": robot.base_radius,
        "platform radius": robot.platform_radius,
        "arms": None if robot.is_linear else robot.arm,
        "bars": robot.bar,
    }
    for name, value in numbers.items():
        if value is not None:
            click.echo(f"  {name} {_scalar(value)} m")
    click.echo(f"  chains at {', '.join(map(str, robot.arm_angles))}")
    for name, angle in robot.limits.items():
        click.echo(f"  {name.replace('_', ' ')} {angle}")
    for name, text in (("source", robot.source), ("notes", robot.notes)):
        if text is not None:
            click.echo(f"  {name}: {text}")
    return 0


def _template() -> str:
    return resources.files(DATA).joinpath(TEMPLATE).read_text(encoding="utf-8")


def _schema_path() -> str:
    return str(Path(str(resources.files(DATA))) / SCHEMA)


def _document(robot: Robot, reason: str | None, doubts: list[str]) -> dict[str, Any]:
    """Return the summary as ``cdpr-validation/1``."""
    from solvers.classes import class_of

    return {
        "format": FORMAT,
        "robot": {"name": robot.name, "sha256": robot.sha256},
        "model": class_of(robot).name,
        "cables": list(robot.cable_names),
        "elastic": robot.is_elastic,
        "source": robot.source,
        "notes": robot.notes,
        "uncertain": [{"path": x.path, "bounds": [float(x.lo), float(x.hi)]} for x in robot.uncertain],
        "warnings": doubts,
        "not_supported": reason,
    }


def _summary(robot: Robot) -> list[str]:
    from solvers.classes import class_of

    kind = class_of(robot).title
    lines = [
        f"{robot.name}: valid, {kind} on {_carriers(robot)}",
        f"  mass {_scalar(robot.platform.mass)} kg",
        f"  centre of mass {_point(robot.platform.centre_of_mass)} m",
        f"  gravity {_point(robot.gravity)} m/s2",
    ]
    if robot.source is not None:
        lines.append(f"  source: {robot.source}")
    if robot.notes is not None:
        lines += [f"  notes: {line}" for line in robot.notes.splitlines()]
    lines += [f"  {_cable(cable)}" for cable in robot.cables]
    if robot.uncertain:
        count = len(robot.uncertain)
        lines.append(f"  uncertain: {count} {'numbers are ranges' if count > 1 else 'number is a range'}")
    lines += [
        f"  uncertain: {scalar.path} in [{_number(scalar.lo)}, {_number(scalar.hi)}]"
        for scalar in robot.uncertain
    ]
    return lines


def _carriers(robot: Robot) -> str:
    """Return what carries a platform or a point mass."""
    count = len(robot.cables)
    if robot.has_legs:
        return counted(count, "leg")
    kind = "mixed cables" if robot.is_mixed else "elastic" if robot.is_elastic else "inextensible"
    return f"{counted(count, 'cable')}, {kind}"


def _cable(cable: Cable) -> str:
    text = f"{cable.name}: from {_point(cable.frame_anchor)} m to {_point(cable.platform_anchor)} m"
    if cable.pulley is not None:
        text += f", {_pulley(cable.pulley)}"
    if cable.elasticity is not None and cable.elasticity.stiffness is not None:
        text += f", {_scalar(cable.elasticity.stiffness)} N/m"
    elif cable.elasticity is not None and cable.elasticity.axial_stiffness is not None:
        text += f", EA = {_scalar(cable.elasticity.axial_stiffness)} N"
    if cable.tension_limits is not None:
        text += f", tension {_number(cable.tension_limits[0])} to {_number(cable.tension_limits[1])} N"
    if cable.length_limits is not None:
        text += f", length {_number(cable.length_limits[0])} to {_number(cable.length_limits[1])} m"
    return text


def _pulley(pulley: Pulley) -> str:
    """Return what a cable runs over."""
    if pulley.is_plain:
        return f"lead-in {_scalar(pulley.lead_in)} m"
    text = f"over a pulley of radius {_scalar(pulley.radius)} m"
    if pulley.arm is not None:
        text += f", arm {_scalar(pulley.arm)} m"
    if pulley.joints == 2:
        text += f", two joints ({pulley.balance})"
    if pulley.lead_in:
        text += f", lead-in {_scalar(pulley.lead_in)} m"
    return text if pulley.axis is None else f"{text}, axis {_point(pulley.axis)}"


def _point(values: Point) -> str:
    return "(" + ", ".join(_scalar(value) for value in values) + ")"


def _scalar(value: Scalar) -> str:
    if isinstance(value, Fraction):
        return _number(value)
    return f"[{_number(value.lo)}, {_number(value.hi)}]"


def _number(value: Fraction) -> str:
    return str(value.numerator) if value.denominator == 1 else repr(float(value))
