"""The exceptions of the toolkit.

Bad input is an exception; a proof that fails is a status of the result, never an
exception. Every message names the thing, the rule it breaks and its actual value.
"""

from __future__ import annotations


class CdprError(Exception):
    """Base class of every error this toolkit raises on purpose."""


class InputError(CdprError):
    """A robot file, a problem file or an argument breaks a rule.

    ``messages`` holds one line per error, each naming its place (file, line and
    column, or option and entry) and the rule.
    """

    def __init__(self, *messages: str) -> None:
        super().__init__("\n".join(messages))
        self.messages: tuple[str, ...] = messages


class NotSupportedError(CdprError):
    """The input is valid, but this version cannot solve it and will not ignore a part of it."""
