"""A Python mapping as a checked tree: the same readers take it, with the same errors, that take files."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.files.document import DEEPEST_LEVEL, TOO_DEEP, Document, Node, child
from cdpr_interval.text.literal import Scalar, quote
from cdpr_interval.text.number import exact_number


def document_of(data: Mapping[str, Any], label: str) -> Document:
    """Turn nested mappings, lists and scalars into a tree.

    Parameters
    ----------
    data : mapping
        Keys are texts. Numbers are exact: an int, `Decimal` or `Fraction` is itself, a float that very
        double, a text the decimal that is written. Tuples and arrays are lists.
    label : str
        What messages call it, in place of a file and a line.

    Returns
    -------
    Document
        With ``root`` set and no bytes; errors of single values are already in it.

    Raises
    ------
    InputError
        It is no mapping.
    """
    if not isinstance(data, Mapping):
        raise InputError(f"{label}: must be a mapping, got {quote(type(data).__name__)}")
    document = Document(label, b"")
    document.root = _Composer(document).node(data, "", 1, None)
    return document


class _Composer:
    """Builds nodes; they are numbered in place of columns, so that errors keep their order."""

    def __init__(self, document: Document) -> None:
        self._document = document
        self._count = 0

    def node(self, value: Any, path: str, level: int, key: Node | None) -> Node:
        """Return the node of a value."""
        self._count += 1
        place = self._count
        if isinstance(value, Mapping):
            return Node(self._mapping(value, path, level), 0, place, key=key, broken=self._deep(path, level))
        if callable(tolist := getattr(value, "tolist", None)):
            value = tolist()
        if isinstance(value, list | tuple):
            deep = self._deep(path, level)
            entries = [] if deep else [
                self.node(entry, child(path, i), level + 1, None) for i, entry in enumerate(value)
            ]  # fmt: skip
            return Node(entries, 0, place, key=key, broken=deep)
        scalar, broken = self._scalar(value, path)
        literal = "" if value is None else str(value)
        return Node(scalar, 0, place, literal, plain=True, key=key, broken=broken)

    def _deep(self, path: str, level: int) -> bool:
        """Report a value below too many others; also what holds itself."""
        if level > DEEPEST_LEVEL:
            self._document.report_at(0, self._count, path[:60], TOO_DEEP)
        return level > DEEPEST_LEVEL

    def _mapping(self, value: Mapping[Any, Any], path: str, level: int) -> dict[str, Node]:
        entries: dict[str, Node] = {}
        if level > DEEPEST_LEVEL:
            return entries
        for name, entry in value.items():
            if not isinstance(name, str):
                rule = f"a key must be a text, got {quote(repr(name))}"
                self._document.report_at(0, self._count, path, rule)
                continue
            self._count += 1
            key = Node(name, 0, self._count, name)
            entries[name] = self.node(entry, child(path, name), level + 1, key)
        return entries

    def _scalar(self, value: Any, path: str) -> tuple[Scalar, bool]:
        """Return the value of a scalar, and whether it is broken: none that a file can hold."""
        if value is None or isinstance(value, bool | str):
            return value, False
        try:
            return exact_number(value), False
        except ValueError as error:
            self._document.report_at(0, self._count, path, str(error))
            return None, True
