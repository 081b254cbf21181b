"""The command line ``cdpr-solve``: its commands, loaded when they run, and its exit codes.

Importing this module imports click and nothing heavier.
"""

from __future__ import annotations

import gc
import os
import re
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from enum import IntEnum
from importlib import import_module
from typing import TYPE_CHECKING, Any, NoReturn

import click

from cdpr_interval.errors import InputError, NotSupportedError
from solvers.shell.examples import examples
from solvers.shell.interrupt import interruptible

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

COMMANDS = {
    "fk": "solvers.commands.fk",
    "ik": "solvers.commands.ik",
    "batch": "solvers.commands.batch",
    "check": "solvers.commands.check",
    "kinematics": "solvers.commands.kinematics",
    "mobility": "solvers.commands.mobility",
    "motion": "solvers.commands.motion",
    "polynomial": "solvers.commands.polynomial",
    "report": "solvers.commands.report",
    "robots": "solvers.commands.robots",
    "validate": "solvers.commands.validate",
    "warm-up": "solvers.commands.warm_up",
    "winch": "solvers.commands.winch",
}
"""Module of each command; its attribute ``command`` is the click command."""
VERBOSE = ("-v", "--verbose")
NUMBER_AS_WORD = re.compile(r"(No such option '-|extra arguments? \()[-+]?\.?\d")
"""Errors of usage whose culprit is a number."""
SYNONYMS = {
    **dict.fromkeys(("jobs", "workers", "processes", "cores", "cpus", "j"), "threads"),
    **dict.fromkeys(("timeout", "time", "seconds"), "time-limit"),
    **dict.fromkeys(("force", "load"), "external-force"),
    **dict.fromkeys(("output", "o"), "out"),
}
"""Options of other programs, and what they are called here."""
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
    """A certificate's claims do not follow from what is in it, or jobs of a batch failed."""
    NONE_FOUND = 6
    """Inverse kinematics found no pose, which proves nothing."""
    INTERRUPTED = 130
    OUTPUT_CLOSED = 141
    """The reader of the output has gone (``| head``): what a shell reports for a process ended by SIGPIPE."""

    @property
    def meaning(self) -> str:
        """What the code says, whatever the command; docs/exit-codes.md says it of each command."""
        return MEANINGS[self]


MEANINGS = {
    ExitCode.COMPLETE: "complete: nothing is left open",
    ExitCode.INTERNAL_ERROR: "internal error: nothing may be concluded",
    ExitCode.INVALID: "wrong usage or file, or not supported: nothing was done",
    ExitCode.INCOMPLETE: "something is left undecided, or was not looked at",
    ExitCode.NO_POSE: "proved that there is no pose",
    ExitCode.NOT_PROVED: "not proved, or failed",
    ExitCode.NONE_FOUND: "no pose was found, which proves nothing",
    ExitCode.INTERRUPTED: "interrupted",
    ExitCode.OUTPUT_CLOSED: "the reader of the output has gone",
}


class Ending(int):
    """An exit code that a command returns, with the one line that standard error says about it."""

    line: str

    def __new__(cls, code: ExitCode | int, line: str) -> Ending:
        """Return the code with its line."""
        ending = super().__new__(cls, code)
        ending.line = line
        return ending


class OutputClosed(Exception):
    """The reader of the output has gone. No OSError: click ends the process with code 1 for those."""


class Interrupted(Exception):
    """Ctrl-C or SIGTERM, with what was done until then. No KeyboardInterrupt: click writes an empty line."""


@contextmanager
def _own_exceptions() -> Iterator[None]:
    try:
        yield
    except BrokenPipeError as error:
        raise OutputClosed from error
    except KeyboardInterrupt as error:
        raise Interrupted(*error.args) from None


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
            if (meant := _command_meant(args[0])) and not ctx.resilient_parsing:
                raise click.UsageError(f"No such command {args[0]!r}. Did you mean {meant!r}?")
            args = ["fk", *args]
        return super().parse_args(ctx, args)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Offer commands, and robots: `cdpr-solve ROBOT` is a command too."""
        from solvers.shell.completion import robots

        # After a character of an option's or a command's name files would only be in the way.
        others = robots(ctx, None, incomplete) if not incomplete.startswith("-") else []
        commands = super().shell_complete(ctx, incomplete)
        return commands + [one for one in others if one.type == "plain" or not commands]

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        """Read the arguments; this is where help and version are printed."""
        with _own_exceptions():
            return super().make_context(info_name, args, parent, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command that was asked for."""
        with _own_exceptions():
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
            with interruptible():
                code = super().main(args, prog_name, complete_var, standalone_mode=False, **extra)
                sys.stdout.flush()
        except (InputError, NotSupportedError) as error:
            return _fail(ExitCode.INVALID, str(error))
        except click.exceptions.NoArgsIsHelpError as error:
            click.echo(error.ctx.get_help())
            return _fail(ExitCode.INVALID, f"{error.ctx.command_path}: which command is missing")
        except click.ClickException as error:
            return _fail(ExitCode.INVALID, _one_line(error))
        except (click.Abort, KeyboardInterrupt, Interrupted) as error:
            return _fail(ExitCode.INTERRUPTED, ": ".join(["interrupted", *map(str, error.args)]))
        except (BrokenPipeError, OutputClosed):
            raise
        except Exception as error:
            if any(option in args for option in VERBOSE):
                traceback.print_exc()
            text = " ".join(f"{type(error).__name__}: {error}".split())
            return _fail(ExitCode.INTERNAL_ERROR, f"internal error: {text}")
        if not isinstance(code, int) or code == ExitCode.COMPLETE:
            return ExitCode.COMPLETE
        found = ExitCode(code)
        return _fail(found, code.line if isinstance(code, Ending) else found.meaning)


def _command_meant(word: str) -> str | None:
    """Return the command that the first word looks like, None where it is a robot or looks more like one."""
    import difflib

    from cdpr_interval.robots.shipped import SUFFIXES, shipped_machines

    shipped = shipped_machines()
    if word.startswith("-") or word.endswith(SUFFIXES) or word in shipped or os.path.lexists(word):
        return None
    close = difflib.get_close_matches(word, [*COMMANDS, *shipped], 1)
    return close[0] if close and close[0] in COMMANDS else None


def _options_meant(error: click.NoSuchOption) -> list[str]:
    """Return the options that an unknown one may stand for: of the same meaning, or much alike."""
    import difflib

    if error.ctx is None or not (word := error.option_name.lstrip("-")):
        return []
    names = [name for one in error.ctx.command.params for name in one.opts if name.startswith("--")]
    own = {name[2:]: name for name in names}
    if (other := SYNONYMS.get(word)) in own:
        return [own[other]]
    # Without the dashes, which all have in common.
    return [own[name] for name in difflib.get_close_matches(word, own)]


def _discard_output() -> None:
    """Let what is still held for a closed pipe go nowhere; Python would complain about it at its end."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except BrokenPipeError:
            os.dup2(nowhere, stream.fileno())


def _one_line(error: click.ClickException) -> str:
    """Return the message of an error of usage on one line."""
    if isinstance(error, click.MissingParameter) and error.param is not None and error.param.opts:
        return f"{error.param.opts[-1]}: missing"
    if isinstance(error, click.BadParameter) and error.param is not None and error.param.opts:
        return f"{error.param.opts[-1]}: {' '.join(error.message.split())}"
    text = " ".join(error.format_message().split())
    if isinstance(error, click.NoSuchOption):
        meant = " or ".join(map(repr, _options_meant(error)))
        text = f"{error.message} Did you mean {meant}?" if meant else error.message
    if NUMBER_AS_WORD.search(text):
        # `--pose 1 -2 3`: the shell has made three words of what was meant as one.
        text = f"{text.rstrip('.')}: a value that holds spaces needs quotes"
    return text


def _fail(code: ExitCode, message: str) -> ExitCode:
    click.echo(message, err=True)
    return code


def _print_version(context: click.Context, parameter: click.Parameter, is_asked: bool) -> None:
    """Print the version, which costs a question to git in a checkout: only when it is asked for."""
    if is_asked and not context.resilient_parsing:
        from cdpr_interval.version import version

        click.echo(f"cdpr-solve, version {version()}")
        context.exit()


@click.group(
    cls=CommandLine,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=examples("robots", "uc2 --lengths 7.5,8", "ik uc2 --pose 4,0,-7"),
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_version,
    help="Show the version and exit.",
)
def cli() -> None:
    """Find and prove every static pose of a cable-driven parallel robot.

    `cdpr-solve ROBOT --lengths ...` is the same as `cdpr-solve fk ROBOT --lengths ...`. ROBOT is a
    file or the name of a robot that ships with the program. `cdpr-solve COMMAND --help` has examples.
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
