"""A file's tree checked against pydantic models, every error at its place in the file."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from cdpr_interval.files.document import Document, Node, child
from cdpr_interval.files.fields import Block, is_free, kind
from cdpr_interval.files.spelling import key_hint, list_hint, mapping_hint, number_hint, unquoted_hint

Root = TypeVar("Root", bound=Block)


@dataclass(frozen=True)
class Models(Generic[Root]):
    """The models of one format."""

    root: type[Root]
    by_name: Mapping[str, type[Block]]
    """Each block by the last name of its place; the root by the empty one."""
    tags: Collection[str]
    """Steps of pydantic's error locations that are no places in the file."""
    further: Mapping[str, Collection[str]] = field(default_factory=dict)
    """Keys to suggest for a block beside those of its model."""
    word: str = ""
    """What ``format`` must say."""

    def validated(self, document: Document) -> Root:
        """Return the tree as its model; `InputError` with every error, also those reported before."""
        try:
            found = self.root.model_validate(_plain(document.root))
        except ValidationError as error:
            for detail in error.errors(include_url=False):
                self._report(document, detail)
            document.require_valid()
            # Only values that are broken already failed, and those were reported.
            raise AssertionError("a validation error was not reported") from error
        document.require_valid()
        return found

    def _report(self, document: Document, detail: ErrorDetails) -> None:
        """Add one error of pydantic to the document, at its place in the file."""
        rule, loc, node, path = detail["type"], detail["loc"], document.root, ""
        for step in loc:
            if step in self.tags:
                continue
            path = child(path, step)
            node = node.items[step] if isinstance(step, int) else node.mapping.get(step, node)
        if rule == "extra_forbidden":
            block = next((step for step in reversed(loc[:-1]) if isinstance(step, str)), "")
            fields = self.by_name[block].model_fields
            known = [*(field.alias or name for name, field in fields.items()), *self.further.get(block, ())]
            document.report_unknown_key(node, path, known)
        elif rule == "missing":
            write = f": write 'format: {self.word}'" if self.word and loc == ("format",) else ""
            document.report(node, path, f"missing{write}")
        elif rule == "too_short":
            least = detail["ctx"]["min_length"]
            document.report(node, path, f"must hold at least {least} entr" + ("y" if least == 1 else "ies"))
        elif rule in ("model_type", "list_type"):
            wanted = "a list" if rule == "list_type" else "a mapping"
            hint = _shape_hint(node)
            document.report(node, path, f"must be {wanted}, got {kind(detail['input'])}{hint}")
        else:
            said = str(detail["ctx"]["error"])
            listed = said.startswith("must be a list")
            hint = _list_hint(node) if listed else _scalar_hint(node, _key(loc), said)
            document.report(node, path, f"{said}{hint}")


def _key(loc: tuple[int | str, ...]) -> str:
    """Return the key below which a value stands."""
    names = [step for step in loc if isinstance(step, str) and not step.startswith("<")]
    return names[-1] if names else ""


def _shape_hint(node: Node) -> str:
    """Return what is missing where a list or a mapping was expected."""
    if node.is_mapping:
        return next((hint for key in node.mapping if (hint := key_hint(key, ()))), "")
    return mapping_hint(node.literal) if node.literal and node.plain else ""


def _list_hint(node: Node) -> str:
    """Return what to write instead of what is not a list of the right length."""
    if node.is_mapping:
        return ": write it in square brackets"
    only = node.items[0] if len(node.items) == 1 else node
    if only.plain and isinstance(only.value, str):
        return list_hint(only.value)
    pieces = [entry.literal or "" for entry in node.items]
    cut = len(pieces) > 3 and all(piece.lstrip("+-").isdigit() for piece in pieces)
    return ": decimals have a point, not a comma" if cut else ""


def _scalar_hint(node: Node, key: str, said: str) -> str:
    """Return what to write instead of a scalar that broke a rule of its own."""
    if not isinstance(node.value, str) or "number" not in said:
        return ""
    return number_hint(node.value, key) if node.plain else unquoted_hint(node.value)


def _plain(node: Node) -> Any:
    """Return mappings and lists as such, without the user's own keys; scalars as nodes."""
    if node.is_mapping:
        return {key: _plain(value) for key, value in node.mapping.items() if not is_free(key)}
    if node.is_list:
        return [_plain(entry) for entry in node.items]
    return node
