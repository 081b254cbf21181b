"""What a result leaves undecided as text: each region with its name and size, the reasons, and what helps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from cdpr_interval.exact.enclosure import Bounds
from solvers.answers.data import ResultData, StopReason, Undecided
from solvers.answers.digits import at_most
from solvers.answers.pose_row import POINT_MASS, angles_text, names_of, position_text

PAGE = "docs/undecided.md"
RELATIVE_RANGE = 1e-15
"""Bounds of a length that are nearer to each other, relatively, enclose one decimal number."""
ROUNDING = 1e-12
"""More than a dozen operations in doubles err, relatively."""


@dataclass(frozen=True)
class RegionRow:
    """One entry of ``undecided``."""

    name: str
    """``u1`` is the first of the list, also in JSON and reports."""
    taut: str
    cells: int
    metres: str
    """The longest side of its box, rounded up."""
    degrees: str
    """No two orientations in it differ by more, rounded up; empty for a point mass."""
    position: tuple[str, ...]
    """x, y, z in m: centre and half width."""
    angles: tuple[str, ...]
    """Roll, pitch, yaw of all its orientations, likewise; empty for a point mass, ``?`` where not bounded."""
    reason: str

    @property
    def size(self) -> str:
        """Both sizes in one text."""
        return f"{self.metres} m, {self.degrees} deg" if self.degrees else f"{self.metres} m"


def region_rows(result: ResultData) -> list[RegionRow]:
    """Return a row for every undecided region, in the order of the result."""
    turns = result.model != POINT_MASS
    return [_row(f"u{number}", one, result, turns) for number, one in enumerate(result.undecided, 1)]


def _row(name: str, one: Undecided, result: ResultData, turns: bool) -> RegionRow:
    side = max(hi - lo for lo, hi in one.position.tolist())
    return RegionRow(
        name,
        names_of(result, one.taut),
        one.cells,
        at_most(side) if math.isfinite(side) else "unbounded",
        at_most(largest_turn(one.rotation)) if turns else "",
        position_text(one.position),
        angles_text(one.rotation) if turns else (),
        one.reason,
    )


def largest_turn(rotation: Bounds) -> float:
    """Return an angle in degrees that no two rotations in bounds (3, 3, 2) of their entries exceed.

    Two rotations that differ by the angle t are 2 sqrt(2) sin(t / 2) apart in the Frobenius norm.
    """
    norm = math.sqrt(sum((hi - lo) ** 2 for row in rotation.tolist() for lo, hi in row))
    half = (1.0 + ROUNDING) * norm / (2.0 * math.sqrt(2.0))
    return 180.0 if half >= 1.0 else math.degrees(2.0 * math.asin(half))


def reasons(rows: Sequence[RegionRow]) -> dict[str, str]:
    """Return every reason once, with the names of its regions."""
    found: dict[str, list[int]] = {}
    for number, row in enumerate(rows, 1):
        found.setdefault(row.reason, []).append(number)
    return {_names(numbers): reason for reason, numbers in found.items()}


def _names(numbers: Sequence[int]) -> str:
    """Return names of regions, three and more in a row as ``u1 to u5``."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    texts = [f"u{run[0]} to u{run[-1]}" if len(run) > 2 else ", ".join(f"u{n}" for n in run) for run in runs]
    return ", ".join(texts)


def advice(result: ResultData) -> list[str]:
    """Return what can be asked instead, so that less is left open; empty when nothing is."""
    found = []
    if result.pending:
        cause = {
            StopReason.TIME_LIMIT: "a longer --time-limit",
            StopReason.CELL_LIMIT: "a larger --cell-limit",
        }.get(result.stop_reason, "the same question to its end")
        found.append(f"{cause}: what was not looked at is not undecided")
    if result.undecided:
        found.append(_of_regions(result))
        if len({one.taut for one in result.undecided}) > 1:
            found.append("--taut LIST where you know which cables are taut: only their regions remain")
    if any(solution.has_open_cable for solution in result.solutions):
        found.append(
            "slack for the cables that are not to carry load (`ik --taut LIST --slack-margin 0.05`), "
            "or --taut LIST here"
        )
    if any(solution.tension_respected is None for solution in result.solutions):
        found.append("other --tension limits: those are within the bounds of a pose's tension")
    return found


def _of_regions(result: ResultData) -> str:
    widest = max((hi - lo) / max(abs(hi), 1.0) for lo, hi in result.lengths.tolist())
    if widest > RELATIVE_RANGE:
        return "narrower ranges of lengths: then regions shrink, and most become poses or vanish"
    return "slightly other lengths: exactly where poses meet or wrenches are dependent, nothing can be proved"
