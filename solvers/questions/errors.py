"""Every error of an input, collected before any is raised."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from cdpr_interval.errors import InputError

P = ParamSpec("P")
T = TypeVar("T")

MOST_ALIKE = 5
"""Errors shown that say the same of different entries; the rest is counted."""

_OF_ONE_ENTRY = re.compile(r"'[^']*'|\[[^\]]*\]|, got .*|write .*|-?\d[\d.e+-]*")
"""What differs between errors that say the same: quoted texts, entries, numbers, what was found instead."""
_COUNTED = re.compile(r".*: and \d+ more.*")


class InputErrors:
    """The messages found so far; a user sees all of them at once, those alike up to `MOST_ALIKE`."""

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
        """Raise `InputError` with the messages noted; return when there is none."""
        if self._messages:
            raise InputError(*_alike_counted(self._messages))


def _alike_counted(messages: list[str]) -> list[str]:
    """Return the messages, of more than `MOST_ALIKE` alike the first ones and how many more there are."""
    kinds = [_OF_ONE_ENTRY.sub("", message) for message in messages]
    total, seen, lines = Counter(kinds), Counter[str](), []
    for message, kind in zip(messages, kinds, strict=True):
        seen[kind] += 1
        # What counts others stands for itself: a reader of a file has counted already.
        if seen[kind] <= MOST_ALIKE or _COUNTED.fullmatch(message):
            lines.append(message)
        elif seen[kind] == total[kind]:
            place = re.split(r"[\[:]", message, maxsplit=1)[0]
            lines.append(f"{place}: and {total[kind] - MOST_ALIKE} more like it")
    return lines
