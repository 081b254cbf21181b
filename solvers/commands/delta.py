"""What `fk` and `ik` do for a Delta: closed forms, without search, budgets and cables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from cdpr_interval.errors import CdprError
from solvers.questions.errors import InputErrors

if TYPE_CHECKING:
    from solvers.cli import Ending
    from solvers.commands.target import JsonTarget
    from solvers.delta.result import DeltaIkResult, DeltaResult

OF_ALL = ("angles", "positions", "pose", "json_file", "quiet", "verbose")
"""Options that have a meaning for a Delta."""


def is_delta(source: str) -> bool:
    """Return True for a file that says it is a Delta's; what is wrong with a source its reader says."""
    from cdpr_interval.robots.delta import FORMAT
    from cdpr_interval.robots.formats.reader import stated_format

    try:
        return stated_format(source) == FORMAT
    except CdprError:
        return False


def of_drives(source: str, given: dict[str, Any], target: JsonTarget | None) -> Ending:
    """Print and write all poses for given drives."""
    from solvers.delta.poses import answer_drives

    errors = _refused(given, target)
    robot = errors.read(_load, source)
    result = None
    if robot is not None:
        result = errors.read(answer_drives, robot, given["angles"], given["positions"], _option_name)
    errors.require_none()
    assert result is not None
    return _shown(result, bool(result.solutions), given["quiet"], target)


def of_position(source: str, given: dict[str, Any], target: JsonTarget | None) -> Ending:
    """Print and write the drives at a pose."""
    from solvers.delta.drives import answer_position

    errors = _refused(given, target)
    robot = errors.read(_load, source)
    result = None
    if given["pose"] is None:
        errors.add("--pose: missing")
    elif robot is not None:
        result = errors.read(answer_position, robot, given["pose"], lambda name: "--pose")
    errors.require_none()
    assert result is not None
    return _shown(result, result.reachable is not False, given["quiet"], target)


def _load(source: str) -> Any:
    from cdpr_interval.robots.formats.reader import load_delta

    return load_delta(source)


def _refused(given: dict[str, Any], target: JsonTarget | None) -> InputErrors:
    """Return errors about options that were given and have no meaning for a Delta."""
    errors, context = InputErrors(), click.get_current_context()
    for name, value in given.items():
        is_given = context.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE
        if name not in OF_ALL and is_given and value not in (None, False):
            errors.add(f"{_option_name(name)}: not for a Delta")
    if target is not None:
        errors.read(target.require_writable)
    return errors


def _shown(
    result: DeltaResult | DeltaIkResult, is_some: bool, quiet: bool, target: JsonTarget | None
) -> Ending:
    from solvers.answers.data import Outcome
    from solvers.cli import Ending, ExitCode

    if target is not None:
        target.write(result.to_json())
    if not quiet and (target is None or not target.is_stdout):
        click.echo(str(result))
    if result.outcome is Outcome.INCOMPLETE:
        return Ending(ExitCode.INCOMPLETE, f"not proved: {'; '.join(result.undecided)}")
    return Ending(ExitCode.COMPLETE if is_some else ExitCode.NO_POSE, result.message)


def _option_name(parameter: str) -> str:
    return "--" + parameter.replace("_", "-")
