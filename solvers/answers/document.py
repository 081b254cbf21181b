"""Results as JSON documents and back, every double restored: the models are the dataclasses of the results.

A bound that is infinite (a tension nothing bounds) is written as null.
"""

from __future__ import annotations

import json
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import fields
from functools import cache
from typing import TYPE_CHECKING, Any, TypeVar, cast

from cdpr_interval.errors import InputError
from cdpr_interval.files.document import child
from cdpr_interval.text.count import counted
from solvers.answers.data import FORMAT, ResultData
from solvers.answers.fields import Described
from solvers.answers.json_text import Json

if TYPE_CHECKING:
    from pydantic import TypeAdapter, ValidationError
    from pydantic_core import ErrorDetails

T = TypeVar("T")
R = TypeVar("R", bound=ResultData)

MOST_COMPLAINTS = 20
"""About one document; the rest is counted."""
ABSENT = {
    "note": "",
    "tension_respected": True,
    "tensions_given_N": None,
    "provenance": None,
    "outside_length_limits": [],
}
"""Keys that are left out where they say nothing."""
_RULES = {
    "missing": "missing",
    "int_type": "must be a whole number",
    "finite_number": "must be a finite number",
    "float_type": "must be a number",
    "string_type": "must be a text",
    "bool_type": "must be true or false",
    "tuple_type": "must be a list",
    "dict_type": "must be an object",
    "dataclass_type": "must be an object",
}
"""What pydantic's kinds of errors are in our words."""


def adapter(kind: type[T]) -> TypeAdapter[T]:
    """Return what writes and reads a dataclass; made once a process, in some hundredths of a second."""
    found: TypeAdapter[T] = _adapter(cast("Hashable", kind))
    return found


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    from pydantic import TypeAdapter

    return TypeAdapter(kind)


def result_to_dict(result: ResultData) -> Json:
    """Return the document, its keys in the order of the format."""
    return to_document(result, FORMAT, result.cables)


def result_from_json(source: str | bytes | Mapping[str, Any], kind: type[R]) -> R:
    """Return the result of class ``kind`` a ``cdpr-result/1`` document describes; unknown keys are ignored.

    Raises
    ------
    InputError
        The text is not JSON, has another format, or a key is missing or of a wrong kind: a line each.
    """
    return from_document(source, kind, FORMAT, "result")


def to_document(value: Any, form: str, cables: Sequence[str]) -> Json:
    """Return a dataclass as a document of a format; the names of cables stand for their indices."""
    return {"format": form, **_without_absent(to_json(value, cables))}


def to_json(value: Any, cables: Sequence[str] = ()) -> Json:
    """Return a dataclass as it stands in a document."""
    written: Json = adapter(type(value)).serializer.to_python(
        value, mode="json", by_alias=True, context=tuple(cables), warnings=False
    )
    return written


def _without_absent(document: Json) -> Json:
    for part in (document, document.get("question", {}), *document.get("solutions", ())):
        for key, nothing in ABSENT.items():
            if key in part and part[key] == nothing:
                del part[key]
    return document


def from_document(source: str | bytes | Mapping[str, Any], kind: type[T], form: str, label: str) -> T:
    """Return the dataclass that a document of a format describes.

    Parameters
    ----------
    source : str, bytes or mapping
        JSON text, or what it describes.
    kind : type
        The dataclass.
    form : str
        The format that the document must have.
    label : str
        What messages call the document.

    Raises
    ------
    InputError
        A line for each thing that is wrong, with its path.
    """
    from pydantic import ValidationError

    text, root = _parsed(source, form, label)
    if root.get("format") != form:
        found = f"is {root['format']!r}" if "format" in root else "missing"
        raise InputError(f"{label}.format: must be '{form}', {found}")
    try:
        names = _names(root, label) if any(f.name == "cables" for f in fields(cast("Any", kind))) else ()
        return adapter(kind).validate_json(text, context=names)
    except ValidationError as error:
        raise InputError(*_complaints(error, label)) from None


def _parsed(source: str | bytes | Mapping[str, Any], form: str, label: str) -> tuple[str | bytes, Json]:
    """Return a document as text and as a dictionary."""
    if not isinstance(source, str | bytes | Mapping):
        raise InputError(f"{label}: must be JSON text or a dictionary, got {type(source).__name__}")
    try:
        text = json.dumps(source) if isinstance(source, Mapping) else source
        root = json.loads(text)
    except (TypeError, ValueError, RecursionError) as error:
        raise InputError(f"{label}: not a {form} document: {error}") from None
    if not isinstance(root, dict):
        raise InputError(f"{label}: must be an object")
    return text, root


def _names(root: Json, label: str) -> tuple[str, ...]:
    """Return the names of the cables: everything else is read with them."""
    names = root.get("cables")
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InputError(f"{label}.cables: {'missing' if names is None else 'must be a list of texts'}")
    if len(set(names)) < len(names):
        raise InputError(f"{label}.cables: names must differ")
    return tuple(names)


def _complaints(error: ValidationError, label: str) -> list[str]:
    """Return a line for each error, with its path."""
    details = error.errors(include_url=False)
    lines = [f"{_path(detail, label)}: {_rule(detail)}" for detail in details[:MOST_COMPLAINTS]]
    if len(details) > MOST_COMPLAINTS:
        lines.append(f"{label}: and {counted(len(details) - MOST_COMPLAINTS, 'more error')}")
    return lines


def _path(detail: ErrorDetails, label: str) -> str:
    path = label
    for step in detail["loc"]:
        path = child(path, step)
    return path


def _rule(detail: ErrorDetails) -> str:
    kind = detail["type"]
    context: dict[str, Any] = detail.get("ctx", {})
    if kind == "value_error":
        return str(context["error"])
    if kind in ("enum", "literal_error"):
        return f"must be one of {context['expected']}".replace("'", "").replace(" or ", ", ")
    if kind in _RULES:
        return _RULES[kind]
    return detail["msg"][0].lower() + detail["msg"][1:]


def schema_of(kind: type[Any], form: str) -> Json:
    """Return the JSON Schema (draft 2020-12) of a format from its dataclass, docstrings and all."""
    from pydantic import TypeAdapter

    plainly = Described.__pydantic_config__
    # For the schema alone: to find the docstrings in the source takes five times as long as all the rest.
    Described.__pydantic_config__ = {**plainly, "use_attribute_docstrings": True}
    try:
        found = TypeAdapter(kind).json_schema()
    finally:
        Described.__pydantic_config__ = plainly
    found["properties"] = {"format": {"const": form, "description": "The format."}, **found["properties"]}
    found["required"] = ["format", *found["required"]]
    plain: Json = _without_titles(found)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": form, **plain}


def _without_titles(value: Any, is_properties: bool = False) -> Any:
    """Return a schema without the titles and defaults that pydantic makes of names."""
    if isinstance(value, list):
        return [_without_titles(entry) for entry in value]
    if not isinstance(value, dict):
        return value
    dropped = () if is_properties else ("title", "default")
    return {
        key: _without_titles(entry, key in ("properties", "$defs"))
        for key, entry in value.items()
        if key not in dropped
    }
