"""The reader of ``cdpr-problem/1``: cable lengths and an optional external force."""

from __future__ import annotations

import os
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from cdpr_interval.exact.range import LengthRange
from cdpr_interval.exact.vector import Vector
from cdpr_interval.files.document import Document, Node, child, read_document
from cdpr_interval.files.literal import quote
from solvers.questions.lengths import match_names, read_length

FORMAT = "cdpr-problem/1"
_KEYS = ("format", "lengths_m", "external_force_N")


def read_problem_file(
    path: str | os.PathLike[str], names: Sequence[str]
) -> tuple[tuple[LengthRange, ...], Vector | None]:
    """Read a problem file for a robot with the given cables.

    Parameters
    ----------
    path : str or PathLike
        A YAML or JSON file.
    names : sequence of str
        The robot's cables, file order.

    Returns
    -------
    lengths : tuple of (Fraction, Fraction)
        Exact (lo, hi) in m, file order.
    external_force : tuple of Fraction or None
        N, base axes; None when the file gives none.

    Raises
    ------
    InputError
        With one line per error, ``FILE:LINE:COLUMN: path: rule``.
    """
    document = read_document(path)
    root = document.root
    if not root.is_mapping:
        document.report(root, "", f"must be a mapping, got {root.kind}")
        document.require_valid()
    stated = root.mapping.get("format")
    if stated is not None and stated.value != FORMAT:
        # Another format: complaints about its keys would only mislead.
        document.report(stated, "format", f"must be {quote(FORMAT)}, got {stated.kind}")
        document.require_valid()
    for key in ("format", "lengths_m"):
        if key not in root.mapping:
            document.report(root, key, "missing")
    for key, node in root.mapping.items():
        if key not in _KEYS and key != "notes" and not key.startswith("x_"):
            document.report_unknown_key(node, key, _KEYS)
    lengths = _lengths(document, root.mapping.get("lengths_m"), names)
    force = _force(document, root.mapping.get("external_force_N"))
    document.require_valid()
    return lengths, force


def _lengths(document: Document, node: Node | None, names: Sequence[str]) -> tuple[LengthRange, ...]:
    if node is None:
        return ()
    label = "lengths_m"
    if node.is_mapping:
        errors: list[str] = []
        match_names(node.mapping.items(), names, label, errors)
        for error in errors:
            document.report(node, "", error)
        entries = [(child(label, name), node.mapping[name]) for name in names if name in node.mapping]
    elif node.is_list:
        entries = [(child(label, index), entry) for index, entry in enumerate(node.items)]
        if len(entries) != len(names):
            given = f"{len(entries)} length" + ("s" if len(entries) != 1 else "")
            document.report(node, label, f"{given} for {len(names)} cables ({', '.join(names)})")
    else:
        document.report(node, label, f"must be a list, or a mapping from cable to length, got {node.kind}")
        entries = []
    ranges = []
    for path, entry in entries:
        try:
            ranges.append(read_length(_value(entry)))
        except ValueError as error:
            document.report(entry, path, str(error))
    return tuple(ranges)


def _value(node: Node) -> Any:
    """Return what `read_length` reads: a Fraction, a text, or a pair of Fractions."""
    if isinstance(node.value, Fraction | str):
        return node.value
    if node.is_list and len(node.items) == 2:
        return tuple(_number(entry) for entry in node.items)
    if set(node.mapping) == {"value", "tolerance"}:
        value, tolerance = _number(node.mapping["value"]), _number(node.mapping["tolerance"])
        if tolerance < 0:
            raise ValueError("the tolerance is negative")
        return value - tolerance, value + tolerance
    raise ValueError(f"must be a length such as 2.69, 2.69+-0.01 or [2.68, 2.70], got {node.kind}")


def _number(node: Node) -> Fraction:
    if not isinstance(node.value, Fraction):
        raise ValueError(f"must hold numbers, got {node.kind}")
    return node.value


def _force(document: Document, node: Node | None) -> Vector | None:
    if node is None:
        return None
    try:
        if len(node.items) != 3:
            raise ValueError(f"must be a list of 3 numbers, got {node.kind}")
        x, y, z = (_number(entry) for entry in node.items)
    except ValueError as error:
        document.report(node, "external_force_N", str(error))
        return None
    return x, y, z
