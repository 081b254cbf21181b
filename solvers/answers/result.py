"""The result of forward kinematics: its data, and what can be done with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from solvers.answers.data import ResultData
from solvers.answers.json_text import Json, dumps

if TYPE_CHECKING:
    from cdpr_interval.robots.cable_robot import Robot


@dataclass(frozen=True, eq=False)
class Result(ResultData):
    """The certified answer to one forward-kinematics question.

    Guarantee: with ``outcome`` COMPLETE every static pose of what was asked lies in the box of
    one of ``solutions``, and each of these boxes holds exactly one pose (or one family).
    """

    def to_dict(self) -> Json:
        """Return the ``cdpr-result/1`` document as plain lists and dictionaries."""
        from solvers.answers.document import result_to_dict

        return result_to_dict(self)

    def to_json(self) -> str:
        """Return the ``cdpr-result/1`` document as text; ``from_json`` restores every double."""
        return dumps(self.to_dict())

    @classmethod
    def from_json(cls, document: str | bytes | Mapping[str, Any]) -> Result:
        """Read a ``cdpr-result/1`` document; keys it does not know are ignored.

        Raises
        ------
        InputError
            The text is not JSON, has another format, or a key is missing or of a wrong kind.
        """
        from solvers.answers.document import result_from_json

        return result_from_json(document, cls)

    def verify(self, robot: Robot | None = None) -> list[str]:
        """Return every contradiction found in this result, without using a solver.

        Parameters
        ----------
        robot : Robot, optional
            The robot the result is about. With it the distances, heights, cable lengths and the
            equilibrium are recomputed over each box in exact rational interval arithmetic;
            without it the result is only compared with itself.

        Returns
        -------
        list of str
            One sentence per complaint; empty when nothing contradicts the result. The checks
            are necessary conditions, not a proof: for that there are certificates.
        """
        from solvers.answers.verification import complaints

        return complaints(self, robot)
