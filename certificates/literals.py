"""Values in a certificate, which is not trusted: everything of another kind raises Malformed."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from fractions import Fraction
from typing import Any

from flint import fmpq

from certificates.verdicts import Malformed

EXACT = re.compile(r"-?[0-9]{1,300}(/[1-9][0-9]{0,300}|(\.[0-9]{1,300})?(e[+-]?[0-9]{1,3})?)")


def exact(text: Any) -> fmpq:
    """Return the number that a decimal or a fraction means."""
    if not isinstance(text, str) or not EXACT.fullmatch(text):
        raise Malformed(f"{ascii(text)[:40]} is not an exact number")
    return fmpq(*Fraction(text).as_integer_ratio())


def exacts(value: Any, count: int) -> list[fmpq]:
    """Return a list of so many numbers."""
    return [exact(v) for v in list_of(value, "numbers", count)]


def list_of(value: Any, what: str, count: int | None = None) -> list[Any]:
    """Return a list, of so many entries if a count is given."""
    if not isinstance(value, list) or count not in (None, len(value)):
        raise Malformed(f"{what}: a list{'' if count is None else f' of {count}'} is needed")
    return value


def entry_of(value: Any, what: str, keys: Iterable[str]) -> dict[str, Any]:
    """Return an object that has exactly these keys, with the values in the order of the keys."""
    wanted = list(keys)
    if not isinstance(value, dict) or set(value) != set(wanted):
        raise Malformed(f"{what}: an object with the keys {', '.join(wanted)} is needed")
    return {key: value[key] for key in wanted}


def index_of(value: Any, count: int, what: str) -> int:
    """Return an index below ``count``."""
    if type(value) is not int or not 0 <= value < count:
        raise Malformed(f"{what}: {ascii(value)[:40]} is no index below {count}")
    return value


def bounds_of(value: Any, what: str) -> tuple[float, float]:
    """Return [lo, hi] of two finite doubles, written as ``float.hex`` writes them."""
    lo, hi = (double(v, what) for v in list_of(value, what, 2))
    if lo > hi:
        raise Malformed(f"{what}: the bounds are in the wrong order")
    return lo, hi


def double(text: Any, what: str) -> float:
    """Return the finite double that a hexadecimal number means."""
    try:
        found = float.fromhex(text)
    except (TypeError, ValueError, OverflowError):
        found = math.inf
    if not math.isfinite(found) or found.hex() != text:
        raise Malformed(f"{what}: {ascii(text)[:40]} is not a double")
    return found


def text_of(value: Any, what: str, words: Iterable[str] = ()) -> str:
    """Return a text without control characters; with ``words`` one of these."""
    allowed = list(words)
    if not isinstance(value, str) or not value.isprintable() or (allowed and value not in allowed):
        raise Malformed(f"{what}: {' or '.join(allowed) or 'a text'} is needed, not {ascii(value)[:40]}")
    return value


def choice_of(value: Any, what: str, choices: Iterable[bool | None] = (True, False)) -> Any:
    """Return true or false, or null where it is among the choices."""
    if not any(value is choice for choice in choices):
        raise Malformed(f"{what}: {ascii(value)[:40]} is not a choice")
    return value
