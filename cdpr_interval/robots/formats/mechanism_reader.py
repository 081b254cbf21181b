"""The reader of ``mechanism/1``: a file, or the name of a mechanism that ships, becomes a `Mechanism`."""

from __future__ import annotations

import os
from collections import Counter
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.files.document import Document, parse_document, read_bytes
from cdpr_interval.files.validation import Models
from cdpr_interval.robots.formats import mechanism_schema
from cdpr_interval.robots.formats.robot_reader import notes_of
from cdpr_interval.robots.mechanism import Joint, Mechanism, complaints
from cdpr_interval.robots.shipped import ROBOTS
from cdpr_interval.text.literal import printable


def shipped_mechanisms() -> dict[str, Traversable]:
    """Return the files of the mechanisms that ship, by name, in alphabetical order."""
    files = resources.files(ROBOTS).joinpath("library", "mechanisms").iterdir()
    return {f.name.removesuffix(".yaml"): f for f in sorted(files, key=lambda f: f.name)}


def load_mechanism(source: str | os.PathLike[str]) -> Mechanism:
    """Read a mechanism: an existing file, else the name of one that ships.

    Raises
    ------
    InputError
        With one line per error, ``FILE:LINE:COLUMN: path: rule``.
    """
    text = os.fspath(source)
    shipped = shipped_mechanisms()
    if text in shipped and not Path(text).is_file():
        return mechanism(parse_document(shipped[text].read_bytes(), f"{text}.yaml"))
    if "\0" not in text and not os.path.lexists(text):
        there = ", ".join(shipped)
        raise InputError(f"{printable(text)}: no such file or shipped mechanism (there are {there})")
    return mechanism(parse_document(read_bytes(text), text))


def mechanism(document: Document) -> Mechanism:
    """Check the tree against the schema and build the mechanism, or raise with every error."""
    models = Models(
        mechanism_schema.MechanismBlock, mechanism_schema.BLOCKS, (), word=mechanism_schema.MECHANISM_FORMAT
    )
    block = models.validated(document)
    given: dict[str, Any] = {
        "name": block.name,
        "bodies": tuple(block.bodies),
        "joints": tuple(_joints(block.joints)),
        "base": block.bodies[0] if block.base is None else block.base,
        "platform": block.platform,
        "source": block.source,
        "notes": notes_of(document),
    }
    entries = document.root.mapping["joints"].items
    for k, joint in enumerate(block.joints):
        if joint.axis is not None and joint.axes is not None:
            document.report(entries[k], f"joints[{k}].axes", "not together with axis")
    for path, rule in complaints(SimpleNamespace(**given)):
        where = document.root.mapping.get(path.partition("[")[0], document.root)
        if path.startswith("joints["):
            place, _, key = path.partition("]")
            entry = entries[int(place[7:])]
            where = entry.mapping.get(key.strip(".").partition("[")[0], entry)
        document.report(where, path, rule)
    document.require_valid()
    return Mechanism(**given)


def _joints(blocks: list[mechanism_schema.JointBlock]) -> list[Joint]:
    seen: Counter[str] = Counter()
    found = []
    for block in blocks:
        seen[block.kind] += 1
        axes: Any = block.axes if block.axis is None else [block.axis]
        name = f"{block.kind}{seen[block.kind]}" if block.name is None else block.name
        found.append(Joint(name, block.kind, block.bodies, block.point_m, tuple(axes or ())))
    return found
