"""The result of forward kinematics: its data, and what can be done with it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cdpr_interval.errors import InputError
from solvers.answers.data import ResultData
from solvers.answers.json_text import Json, dumps

if TYPE_CHECKING:
    from cdpr_interval.robots.cable_robot import Robot


@dataclass(frozen=True, eq=False, repr=False)
class Result(ResultData):
    """The certified answer to one forward-kinematics question.

    ``print(result)`` shows the table, a notebook too; `to_rows` and `to_dataframe` give numbers, `plot` and
    `report` pictures, `to_json` and `certificate` files.

    Guarantee: with ``outcome`` COMPLETE every static pose of what was asked lies in the box of
    one of ``solutions``, and each of these boxes holds exactly one pose (or one family).

    Examples
    --------
    >>> from solvers import forward_kinematics
    >>> result = forward_kinematics("merlet_4_1", ["3.1", "3.2", "3.3", "3.4"])
    >>> result
    <Result merlet-4-1: 1 static pose, proved to be all>
    >>> (pose,) = result.solutions
    >>> [result.cables[i] for i in pose.taut]
    ['c1', 'c2', 'c3']
    >>> pose.position.shape  # three bounds (lo, hi) in m
    (3, 2)
    >>> result.to_rows()[0]["stability"]
    'stable'
    """

    def __repr__(self) -> str:
        return f"<Result {self.robot.name}: {self.message}>"

    def __str__(self) -> str:
        """Return the table that the command line prints."""
        from solvers.answers.table import text_of

        return text_of(self).rstrip("\n")

    def _repr_html_(self) -> str:
        """Return the table for a notebook."""
        from solvers.answers.html import html_of

        return html_of(self)

    @property
    def source_robot(self) -> Robot:
        """The robot that was solved, exactly, also of a result that was read from a file.

        (``robot`` is its name and the digest of its file, as in JSON.)

        Raises
        ------
        InputError
            The result was written before results had their robot in them.
        """
        if self.provenance is None:
            raise InputError(f"result: the data of robot '{self.robot.name}' are not in it")
        return self.provenance.robot

    def to_rows(self) -> list[dict[str, Any]]:
        """Return a dictionary of plain numbers for every solution; undecided regions are not in it.

        The keys are the columns of a batch's ``solutions.csv``: middles of the bounds, angles in degrees;
        ``solution`` counts from 1, as the printed table does: row k is ``solutions[k - 1]``.
        """
        from solvers.answers.rows import rows

        return rows(self)

    def to_dataframe(self) -> Any:
        """Return `to_rows` as a pandas ``DataFrame``.

        Raises
        ------
        CdprError
            pandas is not installed.
        """
        from solvers.answers.rows import data_frame

        return data_frame(self)

    def plot(self, robot: Robot | None = None) -> Any:
        """Return the robot in 3-D with every solution, as a plotly figure; a notebook shows it.

        Parameters
        ----------
        robot : Robot, optional
            The default is `source_robot`.

        Raises
        ------
        InputError
            plotly is not installed; or the result does not hold its robot and none was given.
        """
        return _of_the_package("result_figure")(self, robot)

    def report(
        self,
        path: str | os.PathLike[str],
        certificate: str | os.PathLike[str] | None = None,
        robot: Robot | None = None,
    ) -> Path:
        """Write the report, one HTML file that needs nothing else, and return where it is.

        Parameters
        ----------
        path : str or PathLike
            The file; an older one is replaced.
        certificate : str or PathLike, optional
            A certificate of this result: it is checked, and the report says what came out.
        robot : Robot, optional
            The default is `source_robot`.

        Raises
        ------
        InputError
            plotly is not installed, a file cannot be read or written, or there is no robot.
        """
        found: Path = _of_the_package("write_report")(self, path, certificate, robot)
        return found

    def certificate(self, path: str | os.PathLike[str], time_limit: float | None = None) -> Path:
        """Write a certificate for the independent checker, and return where it is.

        The question is **solved again**, exactly as it is in ``provenance``, since the record of a search is
        too large to be kept with every result; writing the proof takes longer still.

        Parameters
        ----------
        path : str or PathLike
            The file; an older one is replaced.
        time_limit : float, optional
            s for the search and the writing: a certificate that is cut short is partial.

        Warns
        -----
        UserWarning
            The certificate is partial: it does not prove that these poses are all there are.

        Raises
        ------
        InputError
            The result does not hold its question, or the file cannot be written.
        NotSupportedError
            Tensions were given instead of lengths, or limited.
        """
        found: Path = _of_the_package("write_certificate")(self, path, time_limit)
        return found

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

    def verify(self, robot: Robot | str | os.PathLike[str] | None = None) -> list[str]:
        """Return every contradiction found in this result, without using a solver.

        Parameters
        ----------
        robot : Robot, str or PathLike, optional
            The robot the result is about, its file or name. With it the distances, heights, cable lengths
            and the equilibrium are recomputed over each box in exact rational interval arithmetic;
            without it the result is only compared with itself.

        Returns
        -------
        list of str
            One sentence per complaint; empty when nothing contradicts the result. The checks
            are necessary conditions, not a proof: for that there are certificates.
        """
        from cdpr_interval.robots.formats.given import require_robot
        from solvers.answers.verification import complaints

        return complaints(self, None if robot is None else require_robot(robot))


def _of_the_package(name: str) -> Any:
    """Return a public function of this package, as any user finds it.

    What draws, searches and certifies stands above results and is loaded when it is asked for.
    """
    return getattr(import_module("solvers"), name)
