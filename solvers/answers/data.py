"""What forward kinematics answers as plain data: certified poses, undecided regions and the bookkeeping.

The layout follows the file format ``cdpr-result/1``. Bounds are float64 arrays whose last
axis is (lo, hi).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.stability import Stability

FORMAT = "cdpr-result/1"


class CableState(StrEnum):
    """What is proved about one cable in one pose."""

    TAUT = "taut"
    SLACK = "slack"
    SWITCHING = "switching"
    """Just taut or just slack, or taut for some lengths of the ranges and slack for others, with exactly one
    pose proved on either side."""
    UNDECIDED = "undecided"


class Certainty(StrEnum):
    """Whether a statement about an entry is proved for every choice of lengths in their ranges."""

    PROVED = "proved"
    UNDECIDED = "undecided"


class Proof(StrEnum):
    """The theorem behind a solution."""

    INTERVAL_NEWTON = "interval-newton"
    CONVEXITY = "convexity"
    FAMILY = "family"


class Outcome(StrEnum):
    """COMPLETE: the list of solutions is proved to be all of them."""

    COMPLETE = "complete"
    INCOMPLETE = "incomplete"


class StopReason(StrEnum):
    """Why the search ended."""

    EXHAUSTED = "exhausted"
    TIME_LIMIT = "time_limit"
    CELL_LIMIT = "cell_limit"
    INTERRUPTED = "interrupted"


@dataclass(frozen=True)
class Family:
    """A one- or more-parameter set of poses around the listed one."""

    kind: str
    """``rotation``, ``torus`` or ``all-rotations``."""
    axis_point: Bounds | None
    """(3, 2) m, base frame; for a torus (2, 3, 2); None for all rotations."""
    axis_direction: Bounds | None
    """(3, 2) unit vector; for a torus (2, 3, 2)."""
    angle_ranges: Bounds
    """(m, 2, 2): m ranges, each [[start_lo, start_hi], [end_lo, end_hi]] in rad; 0 = listed pose."""


@dataclass(frozen=True)
class Nominal:
    """Plain floats near the certified pose; not certified."""

    position: tuple[float, float, float]
    quaternion_wxyz: tuple[float, float, float, float]
    rpy: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Solution:
    """One static pose in a box: proved to hold exactly one (or one family) where both claims are."""

    taut: tuple[int, ...]
    """Indices of the cables proved taut."""
    cable_states: tuple[CableState, ...]
    position: Bounds
    """(3, 2) m: platform origin in the base frame."""
    rotation: Bounds
    """(3, 3, 2): platform to base."""
    height: Bounds
    """(2,) m: of the centre of mass, along up."""
    tensions: Bounds
    """(N, 2) N, file order; [0, 0] for a slack cable."""
    distances: Bounds
    """(N, 2) m: ||A_i - p - R B_i||."""
    slack_respected: bool | None
    """None: undecided."""
    proof: Proof
    stability: Stability
    nominal: Nominal
    family: Family | None = None
    note: str = ""
    """One sentence where the entry needs one (tensions not unique, end of a family, ...)."""
    existence: Certainty = Certainty.PROVED
    """For every choice of lengths the box holds a static pose (or family)."""
    uniqueness: Certainty = Certainty.PROVED
    """For no choice of lengths does the box hold two."""

    @property
    def is_proved(self) -> bool:
        """True when exactly one pose (or family) in the box is proved for every choice of lengths."""
        return self.existence is Certainty.PROVED and self.uniqueness is Certainty.PROVED

    @property
    def has_open_cable(self) -> bool:
        """True when it is not known whether some cable is taut or slack, or near enough to be slack."""
        return CableState.UNDECIDED in self.cable_states or self.slack_respected is None

    @property
    def is_decided(self) -> bool:
        """True when nothing about the entry is open; a switching cable is not."""
        return self.is_proved and not self.has_open_cable

    @property
    def is_strict(self) -> bool:
        """True when every cable is proved taut or proved slack: none is open, none switches."""
        return all(state in (CableState.TAUT, CableState.SLACK) for state in self.cable_states)


@dataclass(frozen=True, eq=False)
class Undecided:
    """A connected cluster of cells that could be neither proved nor excluded."""

    taut: tuple[int, ...]
    cells: int
    reason: str
    position: Bounds
    """(3, 2) m, hull."""
    rotation: Bounds
    """(3, 3, 2), hull."""


@dataclass(frozen=True)
class SubsetReport:
    """What was done for one subset of taut cables."""

    taut: tuple[int, ...]
    outcome: Outcome
    solutions: int
    cells: int
    time: float
    """Seconds."""


@dataclass(frozen=True)
class Answer:
    """What a solver hands to the dispatcher, in any order."""

    solutions: tuple[Solution, ...]
    undecided: tuple[Undecided, ...] = ()
    pending: int = 0
    subsets: tuple[SubsetReport, ...] = ()
    stop_reason: StopReason = StopReason.EXHAUSTED
    cells: int = 0
    message: str = ""
    """With no solution and nothing undecided: why (which cables cannot reach)."""

    @property
    def outcome(self) -> Outcome:
        """COMPLETE unless something is undecided or pending, an entry or a cable's state included."""
        decided = all(solution.is_decided for solution in self.solutions)
        if self.undecided or self.pending or not decided or self.stop_reason != "exhausted":
            return Outcome.INCOMPLETE
        return Outcome.COMPLETE


@dataclass(frozen=True)
class Tool:
    """The program that wrote a result."""

    name: str
    version: str


@dataclass(frozen=True)
class RobotIdentity:
    """Which robot a result is about: its name and the digest of its file."""

    name: str
    sha256: str


@dataclass(frozen=True)
class Question:
    """What was asked, as far as it changes the answer."""

    taut: tuple[int, ...] | None
    """One subset of cable indices, or None for all subsets."""
    ignore_slack: bool = False
    ignore_tension_sign: bool = False
    method: str = "auto"
    precision: float = 1e-9
    external_force: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """N, base axes: the doubles nearest to the exact force."""
    command: str = "fk"
    tensions_given: tuple[tuple[float, float], ...] | None = None
    """What is known instead of lengths: (lo, hi) of each cable in N, file order."""


@dataclass(frozen=True)
class Statistics:
    """What the run cost."""

    cells: int
    time: float
    """Seconds of wall time."""
    threads: int


@dataclass(frozen=True, eq=False)
class ResultData:
    """The fields of a `solvers.Result`.

    Guarantee: with ``outcome`` COMPLETE every static pose of what was asked lies in the box of
    one of ``solutions``, and each of these boxes holds exactly one pose (or one family).
    """

    tool: Tool
    robot: RobotIdentity
    model: str
    """``point-mass`` or ``six-dof``."""
    cables: tuple[str, ...]
    """Names, file order."""
    lengths: Bounds
    """(N, 2) m: doubles that enclose the exact lengths."""
    question: Question
    outcome: Outcome
    stop_reason: StopReason
    message: str
    solutions: tuple[Solution, ...]
    """Stable, undecided, unstable; then lowest first; then taut; then position."""
    undecided: tuple[Undecided, ...] = ()
    pending: int = 0
    """Cells not looked at."""
    subsets: tuple[SubsetReport, ...] = ()
    statistics: Statistics = Statistics(0, 0.0, 1)
