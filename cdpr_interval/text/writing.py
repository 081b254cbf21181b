"""YAML 1.2 from mappings, lists, texts and exact numbers: what is read again is what was written.

PyYAML's emitter knows YAML 1.1 (it writes the text ``1e-3`` without quotes, which is a number here) and takes
the nearest double of a decimal.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from decimal import Decimal
from fractions import Fraction
from typing import Any

from cdpr_interval.text.literal import LONGEST_NUMBER, resolve

_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_./-]*")
_ESCAPED = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t"}


def yaml_text(data: Mapping[str, Any]) -> str:
    """Return the text of a file.

    Parameters
    ----------
    data : mapping
        Of mappings, lists, texts, bools and numbers: int, `Decimal`, and a `Fraction` that is no decimal:
        it is written ``1/3``, which no reader takes. Blocks are indented; lists of scalars stay on one line.
    """
    return "\n".join(_block(data, "")) + "\n"


def _block(data: Mapping[str, Any], indent: str) -> list[str]:
    """Return the lines of a mapping."""
    lines = []
    for key, value in data.items():
        if isinstance(value, Mapping) and value and not _is_short(value):
            lines += [f"{indent}{key}:", *_block(value, indent + "  ")]
        elif isinstance(value, list) and any(isinstance(entry, Mapping) for entry in value):
            lines.append(f"{indent}{key}:")
            for entry in value:
                first, *others = _block(entry, indent + "    ")
                lines += [f"{indent}  - {first.lstrip()}", *others]
        else:
            lines.append(f"{indent}{key}: {_flow(value)}")
    return lines


def _is_short(data: Mapping[str, Any]) -> bool:
    """Return whether a mapping fits on the line of its key: one number, or a range with its tolerance."""
    return len(data) == 1 and not isinstance(next(iter(data.values())), Mapping | list | str)


def _flow(value: Any) -> str:
    """Return a value on one line."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_flow(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_flow, value)) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    return f"{value:f}" if isinstance(value, Decimal) else str(value)


def _text(value: str) -> str:
    """Return a text, in quotes unless no reader takes it for anything else."""
    if _PLAIN.fullmatch(value) and isinstance(resolve(value), str):
        return value
    plain = value.isprintable() and not ('"' in value or "\\" in value)
    return f'"{value}"' if plain else '"' + "".join(map(_character, value)) + '"'


def _character(c: str) -> str:
    if c in _ESCAPED:
        return _ESCAPED[c]
    return c if c.isprintable() else f"\\U{ord(c):08x}"


def unreadable(value: Any) -> str | None:
    """Return the first number in some data that no file can hold, no decimal or too long a one; else None."""
    if isinstance(value, Mapping):
        value = list(value.values())
    if isinstance(value, list):
        return next((found for entry in value if (found := unreadable(entry)) is not None), None)
    text = _flow(value)
    is_long = isinstance(value, int | Decimal) and len(text) > LONGEST_NUMBER
    return text[:60] if isinstance(value, Fraction) or is_long else None
