"""The option ``--threads``, with one meaning for every command: how much is done at a time."""

from __future__ import annotations

import os
from typing import Any

import click

from solvers.commands.numbers import read_count
from solvers.questions.errors import InputErrors

LABEL = "--threads"

threads_option = click.option(
    LABEL, metavar="N", help="How many threads, or processes, work at a time.  [default: all cores]"
)


def read_threads(given: dict[str, Any], errors: InputErrors | None = None) -> int:
    """Return the number of the command line, all cores where there is none.

    Raises
    ------
    InputError
        When it is no number from 1 on, and there are no ``errors`` to note that in.
    """
    if given["threads"] is None:
        return os.cpu_count() or 1
    noted = InputErrors() if errors is None else errors
    count = noted.read(read_count, given["threads"], LABEL)
    if count is not None and count < 1:
        noted.add(f"{LABEL}: must be at least 1, got {count}")
    if errors is None:
        noted.require_none()
    return count if count is not None and count >= 1 else 1
