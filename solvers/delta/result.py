"""The answers about a Delta as users have them: shown, written and read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import degrees
from typing import Any

from solvers.answers.document import from_document, to_document
from solvers.answers.json_text import dumps
from solvers.delta.data import FORMAT, IK_FORMAT, DeltaIkData, DeltaPose, DeltaResultData


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class DeltaResult(DeltaResultData):
    """All poses of a Delta for given drives; ``print(result)`` shows the table."""

    def __repr__(self) -> str:
        return f"<DeltaResult {self.robot.name}: {self.message}>"

    def __str__(self) -> str:
        """Return the table that the command line prints."""
        return "\n".join(_poses(self))

    def to_dict(self) -> dict[str, Any]:
        """Return the ``cdpr-delta-result/1`` document as plain lists and dictionaries."""
        return to_document(self, FORMAT, ())

    def to_json(self) -> str:
        """Return the document as text; ``from_json`` restores every double."""
        return dumps(self.to_dict())

    @classmethod
    def from_json(cls, document: str | bytes | Mapping[str, Any]) -> DeltaResult:
        """Read a ``cdpr-delta-result/1`` document; `InputError` for what is none."""
        return from_document(document, cls, FORMAT, "result")


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class DeltaIkResult(DeltaIkData):
    """The drives that bring a Delta to a pose; ``print(result)`` shows the table."""

    def __repr__(self) -> str:
        return f"<DeltaIkResult {self.robot.name}: {self.message}>"

    def __str__(self) -> str:
        """Return the table that the command line prints."""
        return "\n".join(_drives(self))

    def to_dict(self) -> dict[str, Any]:
        """Return the ``cdpr-delta-ik-result/1`` document as plain lists and dictionaries."""
        return to_document(self, IK_FORMAT, ())

    def to_json(self) -> str:
        """Return the document as text; ``from_json`` restores every double."""
        return dumps(self.to_dict())

    @classmethod
    def from_json(cls, document: str | bytes | Mapping[str, Any]) -> DeltaIkResult:
        """Read a ``cdpr-delta-ik-result/1`` document; `InputError` for what is none."""
        return from_document(document, cls, IK_FORMAT, "ik result")


def _poses(result: DeltaResult) -> Iterator[str]:
    yield f"{result.robot.name}: {result.message}"
    for pose in result.solutions:
        yield _place(pose)
        yield f"    bars lean by {_turns(pose.bar_angles)}"
        if pose.elbow_angles is not None:
            yield f"    elbows       {_turns(pose.elbow_angles)}"
        yield f"    limits       {KEPT[pose.limits_respected]}"
    yield from (f"  not proved: {reason}" for reason in result.undecided if reason not in result.message)


KEPT = {True: "kept", False: "exceeded", None: "not known"}


def _place(pose: DeltaPose) -> str:
    which = {True: "lower", False: "upper", None: "one of two"}[pose.lower]
    return f"  {which:10}  " + ", ".join(_number(b, 6) for b in pose.position) + " m"


def _drives(result: DeltaIkResult) -> Iterator[str]:
    yield f"{result.robot.name}: {result.message}"
    for name, angles in (("angles", result.angles), ("other branch", result.other_branch)):
        if angles is not None:
            yield f"  {name:13} {_turns(angles)}"
    for name, places in (("positions", result.positions), ("other branch", result.other_positions)):
        if places is not None:
            yield f"  {name:13} " + ", ".join(_number(b, 6) for b in places) + " m"
    if result.bar_angles is not None:
        yield f"  bars lean by  {_turns(result.bar_angles)}"
        if result.elbow_angles is not None:
            yield f"  elbows        {_turns(result.elbow_angles)}"
        yield f"  limits        {KEPT[result.limits_respected]}"


def _turns(rows: Any) -> str:
    return ", ".join(_number([degrees(end) for end in bounds], 4) for bounds in rows) + " deg"


def _number(bounds: Sequence[float], digits: int) -> str:
    """Return the middle of bounds, with what they leave open where that shows."""
    lo, hi = (float(end) for end in bounds)
    middle, half = 0.5 * lo + 0.5 * hi, 0.5 * hi - 0.5 * lo
    text = f"{middle + 0.0:.{digits}f}"
    return text if half < 0.5 * 10**-digits else f"{text} +- {half:.2g}"
