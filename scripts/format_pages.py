"""Write the tables of keys in the pages about formats from their schemas.

What stands above the mark is written by hand.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from cdpr_interval.files.fields import schema_of as file_schema
from solvers.answers.data import FORMAT, ResultData
from solvers.answers.document import schema_of
from solvers.answers.inverse import FORMAT as IK_FORMAT
from solvers.answers.inverse import IkData
from solvers.motions.data import FORMAT as MOTION_FORMAT
from solvers.motions.data import MotionData
from solvers.questions.problem_schema import PROBLEM_FORMAT, ProblemBlock

Json = dict[str, Any]
ROOT = Path(__file__).parents[1]
MARK = "<!-- Below: written by scripts/format_pages.py from the models. -->\n"
KINDS = {
    "boolean": "true or false",
    "integer": "whole number",
    "null": "null",
    "number": "number",
    "object": "object",
    "string": "text",
}


def pages() -> dict[Path, str]:
    """Return the text of each page as it must be."""
    schemas = {
        "docs/result.md": schema_of(ResultData, FORMAT),
        "docs/ik-result.md": schema_of(IkData, IK_FORMAT),
        "docs/motion.md": schema_of(MotionData, MOTION_FORMAT),
        "docs/problem.md": file_schema(ProblemBlock, PROBLEM_FORMAT),
    }
    return {ROOT / name: page(ROOT / name, schema) for name, schema in schemas.items()}


def page(path: Path, schema: Json) -> str:
    """Return what is written by hand, and the tables of a schema."""
    head, mark, _ = path.read_text(encoding="utf-8").partition(MARK)
    if not mark:
        raise ValueError(f"{path}: the mark is missing")
    return head + mark + "\n" + "\n".join(_tables(schema))


def _tables(schema: Json) -> Iterator[str]:
    """Yield a section for the document and for each object and each list of words in it."""
    definitions = schema.get("$defs", {})
    yield f"## The document\n\n{_keys(schema)}"
    for name in _order(schema):
        one = definitions[name]
        body = _keys(one) if "properties" in one else _words(one)
        yield f"## {name}\n\n{_prose(one['description'])}\n\n{body}"


def _keys(schema: Json) -> str:
    required = schema.get("required", ())
    lines = ["| key | holds | meaning |", "|---|---|---|"]
    for key, rule in schema["properties"].items():
        absent = "" if key in required else " (may be absent)"
        lines.append(f"| `{key}` | {_kind(rule)}{absent} | {_prose(rule.get('description', ''))} |")
    return "\n".join(lines) + "\n"


def _words(schema: Json) -> str:
    return ", ".join(f"`{word}`" for word in schema["enum"]) + "\n"


def _order(schema: Json) -> list[str]:
    """Return the names of definitions in the order in which the document leads to them."""
    found: dict[str, None] = {}

    def visit(value: Any) -> None:
        if isinstance(value, list):
            for entry in value:
                visit(entry)
        elif isinstance(value, dict):
            if "$ref" in value:
                name = value["$ref"].rpartition("/")[2]
                if name not in found:
                    found[name] = None
                    visit(schema["$defs"][name].get("properties", {}))
            for entry in value.values():
                visit(entry)

    visit(schema["properties"])
    return list(found)


def _prose(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("``", "`")


def _kind(rule: Json) -> str:
    """Return what a value is, in a few words; a part with words of its own is these."""
    if "$ref" in rule:
        name = rule["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    if "const" in rule:
        return f"`{rule['const']}`"
    if "enum" in rule:
        return ", ".join(f"`{str(word).lower()}`" for word in rule["enum"])
    for several in ("anyOf", "oneOf"):
        if several in rule:
            return ", or ".join(dict.fromkeys(_kind(option) for option in rule[several]))
    if rule.get("type") == "array":
        return _list(rule)
    if isinstance(rule.get("additionalProperties"), dict):
        inner = rule["additionalProperties"]
        return f"mapping to {_part(inner)}"
    if "properties" in rule:
        return "{" + ", ".join(rule["properties"]) + "}"
    kinds = rule["type"] if isinstance(rule["type"], list) else [rule["type"]]
    return ", or ".join(KINDS[kind] for kind in kinds)


def _part(rule: Json) -> str:
    return f"({rule['description']})" if "description" in rule else _kind(rule)


def _list(rule: Json) -> str:
    if "prefixItems" in rule:
        fixed = rule["prefixItems"]
        (inner,) = {_kind(entry) for entry in fixed}
        return f"list of {len(fixed)} {inner}s" if inner == "number" else f"{len(fixed)} x {inner}"
    items, count = rule["items"], rule.get("minItems")
    if items == {"type": ["number", "null"]}:
        return "[lo, hi]"
    inner = _part(items)
    if count is None:
        return f"list of {inner}"
    return f"{count} x {inner}" if inner.endswith("]") else f"list of {count}: {inner}"


def main() -> None:
    """Write every page."""
    for path, text in pages().items():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
