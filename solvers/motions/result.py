"""The result of a motion: its data, and what can be done with it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from solvers.answers.document import from_document, to_document
from solvers.answers.json_text import Json, dumps
from solvers.motions.data import FORMAT, MotionData


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Motion(MotionData):
    """The static pose of a robot along lengths over time, proved piece by piece.

    ``print(result)`` shows the table; `to_csv` gives the tubes as rows, `plot` a picture, `to_json` the file.

    Guarantee: for all lengths that stay in their ranges and start with the first row, a platform that follows
    them slowly and starts as ``start`` says is in the tube of a segment at every time of it, with the taut
    cables of that segment.
    """

    def __repr__(self) -> str:
        return f"<Motion {self.robot.name}: {self.message}>"

    def __str__(self) -> str:
        """Return the table that the command line prints."""
        from solvers.motions.table import text_of

        return text_of(self)

    def to_dict(self) -> Json:
        """Return the ``cdpr-motion/1`` document as plain lists and dictionaries."""
        return to_document(self, FORMAT, self.cables)

    def to_json(self) -> str:
        """Return the document as text; ``from_json`` restores every double."""
        return dumps(self.to_dict())

    @classmethod
    def from_json(cls, document: str | bytes | Mapping[str, Any]) -> Motion:
        """Read a ``cdpr-motion/1`` document; keys it does not know are ignored.

        Raises
        ------
        InputError
            The text is not JSON, has another format, or a key is missing or of a wrong kind.
        """
        return from_document(document, cls, FORMAT, "motion")

    def to_csv(self) -> str:
        """Return a row for every segment: its times, its cables, and the bounds of its tube."""
        from solvers.motions.table import csv_of

        return csv_of(self)

    def plot(self, path: str | os.PathLike[str]) -> Path:
        """Draw the taut cables over time and the path in its tube; return the file.

        Raises
        ------
        InputError
            matplotlib is not installed, or the file cannot be written.
        """
        written: Path = import_module("solvers").motion_picture(self, path)
        return written
