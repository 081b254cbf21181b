"""A YAML 1.2 or JSON file as a checked tree that knows where everything stands.

`read_document` turns a file into a `Document`: a tree of `Node` objects with line,
column and literal text, and the list of errors found so far. A reader of one format walks
the tree, adds its own errors with `Document.report` and ends with `Document.require_valid`,
which raises one `InputError` with one line per error, in file order::

    document = read_document("problem.yaml")
    root = document.root
    if not root.is_mapping:
        document.report(root, "", "must be a mapping")
    for key, node in root.mapping.items():
        if key not in known:
            document.report_unknown_key(node, child(path, key), known)
    document.require_valid()
"""

from __future__ import annotations

import difflib
import hashlib
import os
import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import yaml

from cdpr_interval.errors import InputError
from cdpr_interval.files.spelling import key_hint
from cdpr_interval.files.syntax import explained
from cdpr_interval.text.count import counted
from cdpr_interval.text.literal import Scalar, printable, quote, resolve

LARGEST_FILE = 1_000_000
"""Bytes."""
DEEPEST_LEVEL = 32
"""Nested lists and mappings; also bounds the recursion of every reader."""
TOO_DEEP = f"nested deeper than {DEEPEST_LEVEL} levels"
MOST_ERRORS = 100
"""Errors printed of one file; the rest is counted."""
MOST_ALIKE = 5
"""Errors printed that say the same of different places; the rest is counted."""

_PLAIN_KEY = re.compile(r"[A-Za-z_][A-Za-z0-9_.-]*")
_OF_ONE_PLACE = re.compile(r"'[^']*'|\[\d+\]|, got .*|-?\d[\d.e+-]*")
"""What differs between errors that say the same: names, indices, numbers, what was found instead."""
_NOT_TEXT = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_PARSER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """A value of the file and its place."""

    value: dict[str, Node] | list[Node] | Scalar
    """A mapping, a list, or a scalar: None, bool, exact Fraction or str."""
    line: int
    """From 1."""
    column: int
    """From 1."""
    literal: str | None = None
    """Text of a scalar (quotes and escapes resolved); None for a mapping or a list."""
    plain: bool = False
    """True for an unquoted scalar; a quoted one is always a str."""
    key: Node | None = None
    """The key, when the node is a value of a mapping."""
    broken: bool = False
    """An error was reported for this value already; further reports on it are dropped."""

    @property
    def is_mapping(self) -> bool:
        """True for a mapping."""
        return isinstance(self.value, dict)

    @property
    def is_list(self) -> bool:
        """True for a list."""
        return isinstance(self.value, list)

    @property
    def mapping(self) -> dict[str, Node]:
        """Entries in file order, each key as its text; empty when the node is no mapping."""
        return self.value if isinstance(self.value, dict) else {}

    @property
    def items(self) -> list[Node]:
        """Entries in file order; empty when the node is no list."""
        return self.value if isinstance(self.value, list) else []

    @property
    def kind(self) -> str:
        """What the value is, for messages: ``a mapping``, ``a list of 2``, ``the text 'abc'``, ..."""
        if isinstance(self.value, dict):
            return "a mapping"
        if isinstance(self.value, list):
            return f"a list of {len(self.value)}"
        if self.value is None:
            return "nothing"
        if isinstance(self.value, str):
            return f"the text {quote(self.value)}"
        return printable(self.literal or "")


def child(path: str, key: str | int) -> str:
    """Return the path of an entry: ``cables[1]`` for ("cables", 1), ``a.b`` for ("a", "b")."""
    if isinstance(key, int):
        return f"{path}[{key}]"
    name = key if _PLAIN_KEY.fullmatch(key) and len(key) <= 60 else quote(key)
    return f"{path}.{name}" if path else name


def suggestion(word: str, known: Iterable[str]) -> str:
    """Return `` (did you mean 'x'?)`` when a known word is close, else an empty string."""
    close = difflib.get_close_matches(word, list(known), 1)
    return f" (did you mean {quote(close[0])}?)" if close else ""


@dataclass(eq=False)
class Document:
    """A file's tree and the errors found in it so far."""

    file: str
    """The name shown in messages."""
    data: bytes
    """The file's bytes; empty where there is no file."""
    root: Node = field(init=False)
    _errors: list[tuple[int, int, str, str]] = field(default_factory=list)
    """Line, column, text, and what all errors of the same kind have in common."""
    _alike: Counter[str] = field(default_factory=Counter)
    _further: int = 0

    @cached_property
    def sha256(self) -> str:
        """Hex digest of the file's bytes."""
        return hashlib.sha256(self.data).hexdigest()

    def report_at(self, line: int, column: int, path: str, rule: str) -> None:
        """Add an error at a place; an empty path means the file as a whole."""
        kind = _OF_ONE_PLACE.sub("", f"{path}: {rule}")
        self._alike[kind] += 1
        if self._alike[kind] > MOST_ALIKE:
            return
        if len(self._errors) < MOST_ERRORS:
            self._errors.append((line, column, f"{path}: {rule}" if path else rule, kind))
        else:
            self._further += 1

    def report(self, node: Node, path: str, rule: str) -> None:
        """Add an error at a value, unless that value is broken already."""
        if not node.broken:
            self.report_at(node.line, node.column, path, rule)

    def report_unknown_key(self, node: Node, path: str, known: Collection[str]) -> None:
        """Add ``unknown key`` at the key of a mapping's value, and what to write instead."""
        key = node.key or node
        hint = ""
        if len(self._errors) < MOST_ERRORS:
            hint = key_hint(key.literal or "", known) or suggestion(key.literal or "", known)
        self.report(key, path, f"unknown key{hint}")

    @property
    def messages(self) -> tuple[str, ...]:
        """One line per error, ``FILE:LINE:COL: path: rule``, in file order; those alike are counted."""
        lines: list[str] = []
        shown: Counter[str] = Counter()
        for line, column, text, kind in sorted(self._errors):
            place = f"{self.file}:{line}:{column}" if line else self.file
            lines.append(f"{place}: {text}")
            shown[kind] += 1
            if shown[kind] == MOST_ALIKE < self._alike[kind]:
                lines.append(f"{self.file}: and {self._alike[kind] - MOST_ALIKE} more like it")
        if self._further:
            lines.append(f"{self.file}: and {counted(self._further, 'more error')}")
        return tuple(lines)

    def require_valid(self) -> None:
        """Raise `InputError` with every error reported so far; return when there is none."""
        if self._errors:
            raise InputError(*self.messages)


def read_document(path: str | os.PathLike[str]) -> Document:
    """Read a YAML 1.2 or JSON file into a tree.

    Parameters
    ----------
    path : str or PathLike
        The file; its name as given appears in messages.

    Returns
    -------
    Document
        With ``root`` set. Errors that do not hide the rest of the file (a duplicate key, a tag,
        an alias, NaN) are already in it: the caller adds its own and calls ``require_valid``.

    Raises
    ------
    InputError
        When there is no tree: missing file, directory, too large, not text, wrong syntax, nested
        too deeply, empty.
    """
    return parse_document(read_bytes(path), os.fspath(path))


def read_bytes(path: str | os.PathLike[str]) -> bytes:
    """Return the contents of a file, not more than shows that it is too large; `InputError`: unreadable."""
    try:
        with Path(path).open("rb") as stream:
            return stream.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise InputError(f"{printable(os.fspath(path))}: cannot be read: {reason}") from None


def parse_document(data: bytes | str, file: str = "<text>") -> Document:
    """Turn the bytes or the text of a file into a tree; see `read_document`.

    Parameters
    ----------
    data : bytes or str
        The contents, UTF-8 (a byte order mark is allowed).
    file : str
        The name shown in messages.

    Returns
    -------
    Document
        As `read_document`.

    Raises
    ------
    InputError
        As `read_document`.
    """
    raw = data.encode("utf-8", "surrogatepass") if isinstance(data, str) else data
    document = Document(printable(file), raw)
    if len(raw) > LARGEST_FILE:
        raise InputError(f"{document.file}: is larger than {LARGEST_FILE} bytes, the limit for a file")
    text = _decode(raw, document)
    try:
        document.root = _Composer(document, text).document()
    except (yaml.YAMLError, ValueError) as error:
        # ValueError: PyYAML's own, of a version number with thousands of digits.
        place = _too_deep_at(text)
        found = explained(text, error)
        rule = TOO_DEEP if place else f"not valid YAML: {found.rule}"
        document.report_at(*(place or found[:2]), "", rule)
    except _Hopeless:
        pass
    if not hasattr(document, "root"):
        document.require_valid()
    return document


def _too_deep_at(text: str) -> tuple[int, int] | None:
    """Return where a text that a parser gave up on is nested too deeply; None when it is not.

    libyaml reads a thousand brackets ahead, and some versions give up at a depth of their own before they
    have said anything of it. The parser in Python tells each one: it is slow, so only asked where it can be.
    """
    if text.count("[") + text.count("{") <= DEEPEST_LEVEL:
        return None
    level = 0
    with suppress(yaml.YAMLError, ValueError):
        for event in yaml.parse(text, Loader=yaml.SafeLoader):
            level += isinstance(event, yaml.CollectionStartEvent)
            level -= isinstance(event, yaml.CollectionEndEvent)
            if level > DEEPEST_LEVEL:
                return _place(event)
    return None


_NO_UTF_8 = "not a text file (invalid UTF-8): save it in the encoding UTF-8"


def _decode(raw: bytes, document: Document) -> str:
    """Return the text, or raise `InputError` at the first byte that is none."""
    rule = ""
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        text, rule = (
            raw[: error.start].decode("utf-8-sig"),
            _NO_UTF_8,
        )
    place = len(text)
    if odd := _NOT_TEXT.search(text):
        place, rule = odd.start(), f"not a text file (control character {quote(odd[0])})"
    if not rule:
        return text
    start = text.rfind("\n", 0, place) + 1
    document.report_at(text.count("\n", 0, place) + 1, place - start + 1, "", rule)
    raise InputError(*document.messages)


class _Hopeless(Exception):
    """The rest of the file is not worth reading; the reason is reported already."""


def _place(event: Any) -> tuple[int, int]:
    """Return line and column of an event, from 1."""
    return event.start_mark.line + 1, event.start_mark.column + 1


class _Composer:
    """Builds nodes from PyYAML's events, so that depth is known before anything is built."""

    def __init__(self, document: Document, text: str) -> None:
        self._document = document
        self._events: Iterator[Any] = iter(yaml.parse(text, Loader=_PARSER))

    def document(self) -> Node:
        """Return the root of the only document of the stream."""
        next(self._events)
        if isinstance(next(self._events), yaml.StreamEndEvent):
            self._document.report_at(1, 1, "", "the file is empty")
            raise _Hopeless
        root = self._node(next(self._events), "", 1, None)
        next(self._events)
        event = next(self._events)
        if not isinstance(event, yaml.StreamEndEvent):
            self._report(event, "", "a second document starts here; a file holds one")
        return root

    def _report(self, event: Any, path: str, rule: str) -> None:
        self._document.report_at(*_place(event), path, rule)

    def _node(self, event: Any, path: str, level: int, key: Node | None) -> Node:
        broken = self._check_properties(event, path)
        line, column = _place(event)
        if isinstance(event, yaml.CollectionStartEvent):
            if level > DEEPEST_LEVEL:
                self._report(event, "", TOO_DEEP)
                raise _Hopeless
            is_mapping = isinstance(event, yaml.MappingStartEvent)
            entries = self._mapping(path, level) if is_mapping else self._list(path, level)
            return Node(entries, line, column, key=key, broken=broken)
        text = getattr(event, "value", "")
        plain = getattr(event, "style", None) in (None, "")
        value: Scalar = text
        if plain and not broken:
            try:
                value = resolve(text)
            except ValueError as error:
                self._report(event, path, str(error))
                broken = True
        return Node(value, line, column, text, plain, key, broken)

    def _check_properties(self, event: Any, path: str) -> bool:
        """Refuse aliases, anchors and tags; return whether the value is unusable."""
        if isinstance(event, yaml.AliasEvent):
            self._report(event, path, f"aliases are not allowed ({quote(f'*{event.anchor}')})")
            return True
        if event.anchor is not None:
            self._report(event, path, f"anchors are not allowed ({quote('&' + event.anchor)})")
        if event.tag is not None:
            tag = event.tag.replace("tag:yaml.org,2002:", "!!")
            self._report(event, path, f"tags are not allowed ({quote(tag)})")
            return True
        return False

    def _list(self, path: str, level: int) -> list[Node]:
        entries: list[Node] = []
        while not isinstance(event := next(self._events), yaml.SequenceEndEvent):
            entries.append(self._node(event, child(path, len(entries)), level + 1, None))
        return entries

    def _mapping(self, path: str, level: int) -> dict[str, Node]:
        entries: dict[str, Node] = {}
        while not isinstance(event := next(self._events), yaml.MappingEndEvent):
            if not isinstance(event, yaml.ScalarEvent):
                self._report(event, path, "a key must be a word, not a list, a mapping or an alias")
                raise _Hopeless
            here = child(path, event.value)
            self._check_properties(event, here)
            key = Node(event.value, *_place(event), event.value)
            node = self._node(next(self._events), here, level + 1, key)
            first = entries.setdefault(event.value, node).key
            # After '-name' without a space all entries of a list fall into one mapping.
            if first is not None and first is not key and not any(name.startswith("-") for name in entries):
                hint = ": a new entry begins with '- '" if path.endswith("]") else ""
                self._document.report(key, here, f"duplicate key (first on line {first.line}){hint}")
        return entries
