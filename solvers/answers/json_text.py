"""The JSON text of results: doubles that round-trip, and vectors and matrices on one line."""

from __future__ import annotations

import json
from typing import Any

Json = dict[str, Any]
"""A document of plain lists and dictionaries."""


def dumps(document: Any) -> str:
    """Return ``document`` as JSON text, objects indented and lists of plain values on one line.

    A double is written as its shortest decimal that restores it (``repr``); NaN and infinities
    are refused.
    """
    return _text(document, "") + "\n"


def _text(value: Any, indent: str) -> str:
    deeper = indent + "  "
    if isinstance(value, dict) and value:
        entries = (f"{deeper}{json.dumps(key)}: {_text(entry, deeper)}" for key, entry in value.items())
        return "{\n" + ",\n".join(entries) + f"\n{indent}}}"
    if isinstance(value, list) and _holds_object(value):
        return "[\n" + ",\n".join(deeper + _text(entry, deeper) for entry in value) + f"\n{indent}]"
    return json.dumps(value, allow_nan=False)


def _holds_object(value: Any) -> bool:
    if isinstance(value, list):
        return any(_holds_object(entry) for entry in value)
    return isinstance(value, dict)
