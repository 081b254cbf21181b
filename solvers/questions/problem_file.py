"""The reader of ``cdpr-problem/1``: cable lengths and an optional external force."""

from __future__ import annotations

import os
from collections.abc import Sequence

from cdpr_interval.exact.range import LengthRange
from cdpr_interval.files.document import Document, child, read_document
from cdpr_interval.files.fields import is_free
from cdpr_interval.files.validation import Models
from cdpr_interval.robots.numbers import Point
from cdpr_interval.text.count import counted
from cdpr_interval.text.literal import quote
from solvers.questions.lengths import match_names
from solvers.questions.problem_schema import PROBLEM_FORMAT, TAGS, ProblemBlock, length

MODELS = Models(ProblemBlock, {"": ProblemBlock}, TAGS)


def read_problem_file(
    path: str | os.PathLike[str], names: Sequence[str]
) -> tuple[tuple[LengthRange, ...], Point | None]:
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
    external_force : tuple of Fraction or Range, or None
        N, base axes; None when the file gives none.

    Raises
    ------
    InputError
        With one line per error, ``FILE:LINE:COLUMN: path: rule``.
    """
    document = read_document(path)
    stated = document.root.mapping.get("format")
    if stated is not None and stated.value != PROBLEM_FORMAT:
        # Another format: complaints about its keys would only mislead.
        document.report(stated, "format", f"must be {quote(PROBLEM_FORMAT)}, got {stated.kind}")
        document.require_valid()
    _check_names(document, names)
    block = MODELS.validated(document)
    if isinstance(block.lengths_m, list):
        return tuple(block.lengths_m), block.external_force_N
    named = {**_free(document), **block.lengths_m}
    document.require_valid()
    return tuple(named[name] for name in names), block.external_force_N


def _free(document: Document) -> dict[str, LengthRange]:
    """Return the lengths of cables whose names are like the user's own keys, which models never see."""
    found = {}
    for name, node in document.root.mapping["lengths_m"].mapping.items():
        if is_free(name):
            try:
                found[name] = length(node.value if isinstance(node.value, list | dict) else node)
            except ValueError as error:
                document.report(node, child("lengths_m", name), str(error))
    return found


def _check_names(document: Document, names: Sequence[str]) -> None:
    """Report lengths that are not one for each cable."""
    node = document.root.mapping.get("lengths_m")
    if node is None:
        return
    if node.is_mapping:
        errors: list[str] = []
        match_names(node.mapping.items(), names, "lengths_m", errors)
        for error in errors:
            document.report(node, "", error)
    elif not node.is_list:
        document.report(
            node, "lengths_m", f"must be a list, or a mapping from cable to length, got {node.kind}"
        )
    elif len(node.items) != len(names):
        given = counted(len(node.items), "length")
        document.report(node, "lengths_m", f"{given} for {counted(len(names), 'cable')} ({', '.join(names)})")
