"""The command line ``cdpr-solve``: its commands, loaded when they run, and its exit codes.

Importing this module imports click and nothing heavier.
"""

from __future__ import annotations

import gc
import os
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from enum import IntEnum
from importlib import import_module
from typing import Any, NoReturn

import click

from cdpr_interval.errors import InputError, NotSupportedError

COMMANDS = {
    "fk": "solvers.commands.fk",
    "ik": "solvers.commands.ik",
    "batch": "solvers.commands.batch",
    "check": "solvers.commands.check",
    "polynomial": "solvers.commands.polynomial",
    "report": "solvers.commands.report",
    "validate": "solvers.commands.validate",
    "warm-up": "solvers.commands.warm_up",
    "winch": "solvers.commands.winch",
}
"""Module of each command; its attribute ``command`` is the click command."""
VERBOSE = ("-v", "--verbose")
GARBAGE_THRESHOLD = 100_000
"""New objects after which Python looks for cycles, instead of 700: imports make many objects and no garbage.
With `gc.freeze` at the end a short command takes a quarter less time."""


class ExitCode(IntEnum):
    """What the process returns."""

    COMPLETE = 0
    INTERNAL_ERROR = 1
    INVALID = 2
    INCOMPLETE = 3
    NO_POSE = 4
    NOT_PROVED = 5
    """A certificate's claims do not follow from what is in it."""
    INTERRUPTED = 130
    OUTPUT_CLOSED = 141
    """The reader of the output has gone (``| head``): what a shell reports for a process ended by SIGPIPE."""


class OutputClosed(Exception):
    """The reader of the output has gone. No OSError: click ends the process with code 1 for those."""


@contextmanager
def _closed_pipe_noticed() -> Iterator[None]:
    try:
        yield
    except BrokenPipeError as error:
        raise OutputClosed from error


class CommandLine(click.Group):
    """A group whose commands are imported on use, whose errors are one line each."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the commands in the order of the help text."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return a command."""
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = import_module(COMMANDS[cmd_name]).command
        return command

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read ``cdpr-solve ROBOT ...`` as ``cdpr-solve fk ROBOT ...``."""
        if not args:
            args = ["--help"]
        own = {option for parameter in self.get_params(ctx) for option in parameter.opts}
        if args[0] not in COMMANDS and args[0] not in own:
            args = ["fk", *args]
        return super().parse_args(ctx, args)

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        """Read the arguments; this is where help and version are printed."""
        with _closed_pipe_noticed():
            return super().make_context(info_name, args, parent, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command that was asked for."""
        with _closed_pipe_noticed():
            return super().invoke(ctx)

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> Any:
        """Run a command; in standalone mode exit with its code."""
        arguments = list(sys.argv[1:] if args is None else args)
        if not standalone_mode:
            return super().main(arguments, prog_name, complete_var, standalone_mode=False, **extra)
        try:
            code = self._run(arguments, prog_name, complete_var, extra)
        except (BrokenPipeError, OutputClosed):
            _discard_output()
            code = ExitCode.OUTPUT_CLOSED
        sys.exit(code)

    def _run(
        self, args: list[str], prog_name: str | None, complete_var: str | None, extra: dict[str, Any]
    ) -> int:
        try:
            code = super().main(args, prog_name, complete_var, standalone_mode=False, **extra)
            sys.stdout.flush()
        except (InputError, NotSupportedError) as error:
            return _fail(ExitCode.INVALID, str(error))
        except click.ClickException as error:
            return _fail(ExitCode.INVALID, _one_line(error))
        except (click.Abort, KeyboardInterrupt):
            return _fail(ExitCode.INTERRUPTED, "interrupted")
        except (BrokenPipeError, OutputClosed):
            raise
        except Exception as error:
            if any(option in args for option in VERBOSE):
                traceback.print_exc()
            text = " ".join(f"{type(error).__name__}: {error}".split())
            return _fail(ExitCode.INTERNAL_ERROR, f"internal error: {text}")
        return code if isinstance(code, int) else ExitCode.COMPLETE


def _discard_output() -> None:
    """Let what is still held for a closed pipe go nowhere; Python would complain about it at its end."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except BrokenPipeError:
            os.dup2(nowhere, stream.fileno())


def _one_line(error: click.ClickException) -> str:
    if isinstance(error, click.BadParameter) and error.param is not None and error.param.opts:
        return f"{error.param.opts[-1]}: {' '.join(error.message.split())}"
    return " ".join(error.format_message().split())


def _fail(code: ExitCode, message: str) -> ExitCode:
    click.echo(message, err=True)
    return code


@click.group(cls=CommandLine, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="cdpr-interval", prog_name="cdpr-solve")
def cli() -> None:
    """Find and prove every static pose of a cable-driven parallel robot.

    `cdpr-solve ROBOT --lengths ...` is the same as `cdpr-solve fk ROBOT --lengths ...`. ROBOT is a
    file or the name of a robot that ships with the program.
    """


def main() -> NoReturn:
    """Run the command line of this process."""
    gc.set_threshold(GARBAGE_THRESHOLD)
    try:
        cli.main(prog_name="cdpr-solve")
    finally:
        # At its end Python looks for garbage in everything that was imported, which lives until then anyway.
        gc.freeze()
    raise AssertionError("the command line exits by itself")
