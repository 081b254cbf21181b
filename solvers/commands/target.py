"""Where a command writes what it found: a file replaced in one step, or standard output."""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path

import click

from cdpr_interval.errors import InputError
from cdpr_interval.text.literal import quote
from solvers.shell.completion import files

json_option = click.option(
    "--json",
    "json_file",
    metavar="FILE",
    shell_complete=files,
    help="Write the result as JSON; - is standard output.",
)
"""Of the commands that write one result."""


class JsonTarget:
    """The target of ``--json`` or ``--certificate``: a path, or ``-`` for standard output.

    A regular file is written beside its place and renamed, so that a reader sees the old contents
    or the new, never a part.
    """

    def __init__(self, path: str, option: str = "--json") -> None:
        self._name = path
        self._option = option
        self._path = Path() if "\0" in path else Path(path)
        if self._is_replaced:
            # A link stays a link: what it points to is replaced.
            self._path = Path(os.path.realpath(self._path))

    @property
    def is_stdout(self) -> bool:
        """True for ``-``."""
        return self._name == "-"

    def is_same(self, other: JsonTarget) -> bool:
        """Return True when both are one file."""
        return self._is_replaced and not self.is_stdout and self._path == other._path

    def require_writable(self) -> None:
        """Raise `InputError` when the target cannot be written; nothing is left behind."""
        if self.is_stdout:
            return
        if not self._name or "\0" in self._name or self._path.is_dir():
            raise InputError(f"{self._option}: {quote(self._name)} is not a file name")
        try:
            if self._path.exists() and not os.access(self._path, os.W_OK):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
            if self._is_replaced:
                scratch = self._scratch()
                scratch.touch(exist_ok=False)
                scratch.unlink()
        except OSError as error:
            raise InputError(
                f"{self._option}: {quote(self._name)} cannot be written: {error.strerror}"
            ) from None

    def write(self, text: str) -> None:
        """Write the document."""
        if self.is_stdout:
            sys.stdout.write(text)
            sys.stdout.flush()
        else:
            self.write_bytes(text.encode())

    def write_bytes(self, content: bytes) -> None:
        """Write the content of a file."""
        if self._is_replaced:
            scratch = self._scratch()
            try:
                scratch.write_bytes(content)
                if self._path.exists():
                    scratch.chmod(self._path.stat().st_mode & 0o777)
                scratch.replace(self._path)
            except BaseException:
                scratch.unlink(missing_ok=True)
                raise
        else:
            self._path.write_bytes(content)

    @property
    def _is_replaced(self) -> bool:
        """False for a device or a pipe, which must not be replaced by a file."""
        return self._path.is_file() or not self._path.exists()

    def _scratch(self) -> Path:
        return self._path.with_name(f".{self._path.name[:100]}.{os.getpid()}.part")
