"""Exact numbers in proof data, which is not trusted."""

from __future__ import annotations

import re
from collections.abc import Iterable
from fractions import Fraction
from typing import Any

from flint import fmpq

from certificates.verdicts import Malformed

EXACT = re.compile(r"-?[0-9]{1,300}(/0*[1-9][0-9]{0,300}|(\.[0-9]{1,300})?(e[+-]?[0-9]{1,3})?)")


def exact(text: Any) -> fmpq:
    """Return the number that a decimal or a fraction means."""
    if not isinstance(text, str) or not EXACT.fullmatch(text):
        raise Malformed(f"{str(text)[:40]!r} is not an exact number")
    return fmpq(*Fraction(text).as_integer_ratio())


def exacts(texts: Any, count: int) -> list[fmpq]:
    """Return a list of so many numbers."""
    if not isinstance(texts, list) or len(texts) != count:
        raise Malformed(f"a list of {count} numbers is needed")
    return [exact(text) for text in texts]


def fields(document: Any, names: Iterable[str]) -> list[Any]:
    """Return the values of an object that has exactly these keys."""
    wanted = list(names)
    if not isinstance(document, dict) or set(document) != set(wanted):
        raise Malformed(f"an object with the keys {', '.join(wanted)} is needed")
    return [document[name] for name in wanted]


def index(value: Any, count: int) -> int:
    """Return an index below ``count``."""
    if type(value) is not int or not 0 <= value < count:
        raise Malformed(f"{str(value)[:40]!r} is no index below {count}")
    return value
