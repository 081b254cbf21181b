"""Every error of an input, collected before any is raised."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from cdpr_interval.errors import InputError

P = ParamSpec("P")
T = TypeVar("T")


class InputErrors:
    """The messages found so far; a user sees all of them at once."""

    def __init__(self) -> None:
        self._messages: list[str] = []

    def add(self, message: str) -> None:
        """Note one message."""
        self._messages.append(message)

    def read(self, reader: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T | None:
        """Return what the reader returns, or None after noting the messages of its `InputError`."""
        try:
            return reader(*args, **kwargs)
        except InputError as error:
            self._messages += error.messages
            return None

    def require_none(self) -> None:
        """Raise `InputError` with every message noted; return when there is none."""
        if self._messages:
            raise InputError(*self._messages)
