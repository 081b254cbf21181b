"""A pose of a result as a row of text: proved digits, angles with their unit, tensions with names."""

from __future__ import annotations

from dataclasses import dataclass

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.stability import Stability
from solvers.answers.angles import rpy_enclosures
from solvers.answers.data import CableState, Certainty, ResultData, Solution
from solvers.answers.digits import proved_decimal, proved_significant
from solvers.answers.limits import doubtful

DECIMALS = 6
"""Of positions: a micrometre; the JSON holds every digit."""
ANGLE_DECIMALS = 4
TENSION_DIGITS = 6
POINT_MASS = "point-mass"


@dataclass(frozen=True)
class PoseRow:
    """One entry of ``solutions``."""

    number: int
    """Its place in the list, from 1."""
    stability: Stability
    is_proved: bool
    """False: an open entry."""
    taut: str
    """Names with commas."""
    position: tuple[str, ...]
    """x, y, z in m."""
    angles: tuple[str, ...]
    """Roll, pitch, yaw, each with ``deg``; empty for a point mass, ``?`` where not determined."""
    tensions: tuple[tuple[str, str], ...]
    """Name and tension in N of every cable that is not slack."""
    remarks: str

    @property
    def mark(self) -> str:
        """The stability: after a star where the platform can hang, after a question mark in open entries."""
        star = "*" if self.stability is Stability.STABLE else " "
        return f"{star if self.is_proved else '?'} {self.stability.value}"

    @property
    def tensions_text(self) -> str:
        """The tensions in one text."""
        return ", ".join(f"{name} {tension}" for name, tension in self.tensions)


def pose_rows(result: ResultData) -> list[PoseRow]:
    """Return a row for every solution, in the order of the result."""
    return [_row(number, solution, result) for number, solution in enumerate(result.solutions, 1)]


def names_of(result: ResultData, cables: tuple[int, ...]) -> str:
    """Return the names of cables with commas; a dash for none."""
    return ",".join(result.cables[i] for i in cables) or "-"


def position_text(bounds: Bounds) -> tuple[str, ...]:
    """Return the coordinates of a position (3, 2) in m as text."""
    return tuple(proved_decimal(lo, hi, DECIMALS) for lo, hi in bounds.tolist())


def angles_text(rotation: Bounds) -> tuple[str, ...]:
    """Return roll, pitch and yaw of rotations in bounds (3, 3, 2) as text with ``deg``; ``?`` where none."""
    return tuple(
        "?" if angle is None else f"{proved_decimal(*angle, ANGLE_DECIMALS)}deg"
        for angle in rpy_enclosures(rotation)
    )


def _row(number: int, solution: Solution, result: ResultData) -> PoseRow:
    angles = angles_text(solution.rotation) if result.model != POINT_MASS else ()
    tense = [i for i, state in enumerate(solution.cable_states) if state is not CableState.SLACK]
    return PoseRow(
        number,
        solution.stability,
        solution.is_proved,
        names_of(result, solution.taut),
        position_text(solution.position),
        angles,
        tuple((result.cables[i], _tension(solution, i)) for i in tense),
        _remarks(solution, result),
    )


def _tension(solution: Solution, cable: int) -> str:
    lo, hi = solution.tensions[cable].tolist()
    return proved_significant(lo, hi, TENSION_DIGITS)


def _remarks(solution: Solution, result: ResultData) -> str:
    remarks = []
    if not solution.is_proved:
        kinds = {"existence": solution.existence, "uniqueness": solution.uniqueness}
        unproved = " and ".join(kind for kind, value in kinds.items() if value is Certainty.UNDECIDED)
        remarks.append(f"{unproved} not proved")
    if names := _in_state(solution, result, CableState.UNDECIDED):
        remarks.append(f"taut or slack undecided: {names}")
    if names := _in_state(solution, result, CableState.SWITCHING):
        remarks.append(f"switching, one pose either way: {names}")
    if solution.slack_respected is False:
        remarks.append("other cables are not slack")
    if solution.tension_respected is None:
        limits = result.question.tension
        names = "" if limits is None else names_of(result, doubtful(solution, limits))
        remarks.append(f"within the tension limits undecided: {names or '-'}")
    if solution.family is not None:
        remarks.append(f"family: {solution.family.kind}")
    if solution.note:
        remarks.append(solution.note)
    return "; ".join(remarks)


def _in_state(solution: Solution, result: ResultData, state: CableState) -> str:
    states = zip(result.cables, solution.cable_states, strict=True)
    return ",".join(name for name, own in states if own is state)
