"""A file's tree checked against pydantic models, every error at its place in the file."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from cdpr_interval.files.document import Document, Node, child
from cdpr_interval.files.fields import Block, is_free, kind

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
            document.report(node, path, "missing")
        elif rule == "too_short":
            least = detail["ctx"]["min_length"]
            document.report(node, path, f"must hold at least {least} entr" + ("y" if least == 1 else "ies"))
        elif rule in ("model_type", "list_type"):
            wanted = "a list" if rule == "list_type" else "a mapping"
            document.report(node, path, f"must be {wanted}, got {kind(detail['input'])}")
        else:
            document.report(node, path, str(detail["ctx"]["error"]))


def _plain(node: Node) -> Any:
    """Return mappings and lists as such, without the user's own keys; scalars as nodes."""
    if node.is_mapping:
        return {key: _plain(value) for key, value in node.mapping.items() if not is_free(key)}
    if node.is_list:
        return [_plain(entry) for entry in node.items]
    return node
