"""Robot files: a file of any known format, or the name of a robot that ships, becomes a robot.

`load_machine` reads all of them; `load_robot` and `load_delta` those of one kind, and refuse the others.
"""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from cdpr_interval.errors import InputError, NotSupportedError
from cdpr_interval.files.document import Document, parse_document, read_bytes
from cdpr_interval.files.mapping import document_of
from cdpr_interval.robots.cable_robot import FORMAT as ROBOT_FORMAT
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.delta import FORMAT as DELTA_FORMAT
from cdpr_interval.robots.delta import DeltaRobot
from cdpr_interval.robots.formats import robot_reader
from cdpr_interval.robots.shipped import SUFFIXES, file_of, shipped_machines
from cdpr_interval.text.literal import printable, quote

Machine = Robot | DeltaRobot
"""A robot of any format."""


def _delta(document: Document) -> DeltaRobot:
    """Read a Delta; its models take time to build, and most files are others."""
    from cdpr_interval.robots.formats import delta_reader

    return delta_reader.delta(document)


FORMATS: dict[str, Callable[[Document], Machine]] = {ROBOT_FORMAT: robot_reader.robot, DELTA_FORMAT: _delta}
"""Known formats by their word: what makes a robot of a document, reporting every error. A file without the
word, or with none that is known, is taken for the first."""


def load_robot(source: str | os.PathLike[str]) -> Robot:
    """Read the file of a cable robot, or one that ships with the package.

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
    NotSupportedError
        It is another machine.
    """
    return with_cables(load_machine(source))


def load_delta(source: str | os.PathLike[str]) -> DeltaRobot:
    """Read the file of a Delta, or one that ships; as `load_robot`."""
    found = load_machine(source)
    if not isinstance(found, DeltaRobot):
        raise NotSupportedError(f"robot '{found.name}': is no Delta, but a robot with cables")
    return found


def load_machine(source: str | os.PathLike[str]) -> Machine:
    """Read a robot of any format; as `load_robot`."""
    data, file = read_robot(source)
    return _read(parse_document(data, file))


def stated_format(source: str | os.PathLike[str]) -> str | None:
    """Return what a robot file says in ``format``, nothing else of it checked; None where it says nothing."""
    word = parse_document(*read_robot(source)).root.mapping.get("format")
    return word.value if word is not None and isinstance(word.value, str) else None


def with_cables(machine: Machine) -> Robot:
    """Return a robot that has cables; `NotSupportedError` for another one."""
    if not isinstance(machine, Robot):
        raise NotSupportedError(f"robot '{machine.name}': is a Delta, which has no cables")
    return machine


def read_robot(source: str | os.PathLike[str]) -> tuple[bytes, str]:
    """Return the contents of a robot file or of a shipped robot, and its name; see `load_robot`."""
    text = os.fspath(source)
    name = text.removesuffix(".yaml")
    shipped = shipped_machines()
    if name in shipped and not Path(text).is_file():
        return file_of(name).read_bytes(), f"{name}.yaml"
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
    return with_cables(_read(parse_document(data, file)))


def robot_of(data: Mapping[str, Any], label: str) -> Robot:
    """Return the robot of a mapping with the keys of a file; see `Robot.from_dict`."""
    return with_cables(_read(document_of(data, label)))


def _read(document: Document) -> Machine:
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
