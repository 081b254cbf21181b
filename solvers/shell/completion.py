"""What a shell offers for the arguments of commands: robots that ship, files, folders.

click writes the shell's part (``_CDPR_SOLVE_COMPLETE=bash_source cdpr-solve``); docs/command-line.md says
how to use it. Nothing is read but the names of files.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import click
from click.shell_completion import CompletionItem

Completion = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def robots(ctx: click.Context | None, parameter: click.Parameter | None, begun: str) -> list[CompletionItem]:
    """Return the shipped robots, files of robots, and folders that begin like this."""
    from cdpr_interval.robots.shipped import SUFFIXES, shipped_machines

    shipped = [name for name in shipped_machines() if name.startswith(begun)]
    found = [*shipped, *_files(begun, SUFFIXES)]
    # Without a candidate of our own the shell completes files: folders on the way, links, `~`.
    return [CompletionItem(name) for name in found] or files(ctx, parameter, begun)


def files(ctx: click.Context | None, parameter: click.Parameter | None, begun: str) -> list[CompletionItem]:
    """Let the shell complete files."""
    return [CompletionItem(begun, type="file")]


def folders(ctx: click.Context | None, parameter: click.Parameter | None, begun: str) -> list[CompletionItem]:
    """Let the shell complete folders."""
    return [CompletionItem(begun, type="dir")]


robot_argument = click.argument("robot", shell_complete=robots)


def _files(begun: str, suffixes: Iterable[str]) -> list[str]:
    """Return the files with these suffixes that a path begun names, spelled as it was begun."""
    place, _, name = begun.rpartition("/")
    here = f"{place}/" if "/" in begun else ""
    try:
        entries = sorted(path.name for path in Path(here or ".").iterdir() if path.suffix in suffixes)
    except OSError:
        return []
    return [here + entry for entry in entries if entry.startswith(name or entry.lstrip("."))]
