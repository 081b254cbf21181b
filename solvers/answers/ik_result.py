"""The result of inverse kinematics as users have it: shown, written and read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from solvers.answers.document import from_document, to_document
from solvers.answers.html import ik_html_of
from solvers.answers.ik_table import text_of
from solvers.answers.inverse import FORMAT, IkData
from solvers.answers.json_text import dumps


@dataclass(frozen=True, kw_only=True, repr=False)
class IkResult(IkData):
    """Distances, lengths and tensions at one pose, file order; plain floats, nothing is certified.

    ``print(result)`` shows the table, a notebook too.

    Examples
    --------
    >>> from solvers import inverse_kinematics
    >>> result = inverse_kinematics("merlet_4_1", (1, 1, -2))
    >>> result
    <IkResult merlet-4-1: the pose is static>
    >>> [round(length, 3) for length in result.lengths]
    [2.449, 3.742, 3.742, 4.69]
    """

    def __repr__(self) -> str:
        return f"<IkResult {self.robot.name}: {self.message}>"

    def __str__(self) -> str:
        """Return the table that the command line prints."""
        return text_of(self)

    def _repr_html_(self) -> str:
        """Return the table for a notebook."""
        return ik_html_of(self)

    def to_dict(self) -> dict[str, Any]:
        """Return the ``cdpr-ik-result/1`` document as plain lists and dictionaries."""
        return to_document(self, FORMAT, self.cables)

    def to_json(self) -> str:
        """Return the document as text; ``from_json`` restores every double."""
        return dumps(self.to_dict())

    @classmethod
    def from_json(cls, document: str | bytes | Mapping[str, Any]) -> IkResult:
        """Read a ``cdpr-ik-result/1`` document; keys it does not know are ignored.

        Raises
        ------
        InputError
            The text is not JSON, has another format, or a key is missing or of a wrong kind.
        """
        return from_document(document, cls, FORMAT, "ik result")
