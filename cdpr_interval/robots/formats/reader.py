"""Robot files: a file of any known format, or the name of a robot that ships, becomes a `Robot`."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.files.document import Document, parse_document, read_bytes
from cdpr_interval.files.mapping import document_of
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats import robot_reader, schema
from cdpr_interval.robots.shipped import ROBOTS, SUFFIXES, shipped_robots
from cdpr_interval.text.literal import printable, quote

FORMATS: dict[str, Callable[[Document], Robot]] = {schema.ROBOT_FORMAT: robot_reader.robot}
"""Known formats by their word: what makes a robot of a document, reporting every error. A file without the
word, or with none that is known, is taken for the first."""


def load_robot(source: str | os.PathLike[str]) -> Robot:
    """Read a robot file, or a robot that ships with the package.

    Parameters
    ----------
    source : str or PathLike
        An existing file, else the name of a shipped robot, with or without ``.yaml``.

    Returns
    -------
    Robot
        Exact data, SI units.

    Raises
    ------
    InputError
        With one line per error; see `parse_robot`.
    """
    return parse_robot(*read_robot(source))


def read_robot(source: str | os.PathLike[str]) -> tuple[bytes, str]:
    """Return the contents of a robot file or of a shipped robot, and its name; see `load_robot`."""
    text = os.fspath(source)
    name = text.removesuffix(".yaml")
    shipped = shipped_robots()
    if name in shipped and not Path(text).is_file():
        file = f"{name}.yaml"
        return resources.files(ROBOTS).joinpath("library", file).read_bytes(), file
    if "\0" not in text and not os.path.lexists(text):
        raise InputError(_not_found(text, shipped))
    return read_bytes(text), text


def parse_robot(data: bytes | str, file: str = "<text>") -> Robot:
    """Read a robot from the contents of a file.

    Parameters
    ----------
    data : bytes or str
        The contents of a file of one of `FORMATS`.
    file : str
        The name shown in messages.

    Returns
    -------
    Robot
        Exact data, SI units.

    Raises
    ------
    InputError
        With one line per error, ``FILE:LINE:COLUMN: path: rule``, lines and columns from 1,
        indices in the path from 0.
    """
    return _read(parse_document(data, file))


def robot_of(data: Mapping[str, Any], label: str) -> Robot:
    """Return the robot of a mapping with the keys of a file; see `Robot.from_dict`."""
    return _read(document_of(data, label))


def _read(document: Document) -> Robot:
    """Return the robot of a document of any known format."""
    stated = document.root.mapping.get("format")
    first = next(iter(FORMATS))
    if stated is None or not document.root.is_mapping:
        return FORMATS[first](document)
    if isinstance(stated.value, str) and stated.value in FORMATS:
        return FORMATS[stated.value](document)
    # Another format, or another version: complaints about its keys would only mislead.
    document.report(stated, "format", f"must be {' or '.join(map(quote, FORMATS))}, got {stated.kind}")
    document.require_valid()
    raise AssertionError("a document with a complaint is not valid")


def _not_found(text: str, shipped: tuple[str, ...]) -> str:
    """Return the message for a source that is neither a file nor a shipped robot."""
    stem = Path(text).name
    for suffix in SUFFIXES:
        stem = stem.removesuffix(suffix)
    near = difflib.get_close_matches(stem.lower().replace("-", "_"), shipped, 3)
    hint = f"did you mean {' or '.join(map(quote, near))}?" if near else f"there are {', '.join(shipped)}"
    return f"{printable(text)}: no such file or shipped robot ({hint})"
