"""What forward kinematics answers as plain data: certified poses, undecided regions and the bookkeeping.

This is the only description of the file format ``cdpr-result/1``: its keys are these fields in this order,
with a unit at the end (`fields.UNITS`), and its JSON Schema and its page have these docstrings. A field
without a default is a key that must be there. Bounds are float64 arrays whose last axis is (lo, hi).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Literal

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.text.count import counted
from solvers.answers.fields import (
    ANY,
    Cables,
    Count,
    Described,
    FloatOrRange,
    Interval,
    Matrix,
    Numbers,
    OfCables,
    OrUndecided,
    PerCable,
    Quadruple,
    Triple,
    Vector,
)
from solvers.answers.provenance import Provenance

FORMAT = "cdpr-result/1"

Axis = Annotated[Bounds, Numbers((3, 2), (2, 3, 2))]
"""One axis of a family, or the two of a torus."""
Arcs = Annotated[Bounds, Numbers((ANY, 2, 2))]


class CableState(StrEnum):
    """What is proved about one cable in one pose.

    taut: it carries load. slack: it carries none and is longer than its distance. switching: just taut or
    just slack, or taut for some lengths of the ranges and slack for others, with exactly one pose proved on
    either side. undecided: none of these is proved.
    """

    TAUT = "taut"
    SLACK = "slack"
    SWITCHING = "switching"
    UNDECIDED = "undecided"


class Certainty(StrEnum):
    """Whether a statement about an entry is proved for every choice of lengths and data in their ranges."""

    PROVED = "proved"
    UNDECIDED = "undecided"


class Proof(StrEnum):
    """The theorem behind a solution."""

    INTERVAL_NEWTON = "interval-newton"
    CONVEXITY = "convexity"
    FAMILY = "family"


class Outcome(StrEnum):
    """Whether the list of solutions is proved to be all of them (complete)."""

    COMPLETE = "complete"
    INCOMPLETE = "incomplete"


class StopReason(StrEnum):
    """Why the search ended.

    exhausted: it went to the end, nothing was left to look at; this is the good one. time_limit, cell_limit,
    interrupted: it was stopped, and ``pending`` cells were not looked at.
    """

    EXHAUSTED = "exhausted"
    TIME_LIMIT = "time_limit"
    CELL_LIMIT = "cell_limit"
    INTERRUPTED = "interrupted"


@dataclass(frozen=True)
class Family(Described):
    """A one- or more-parameter set of poses around the listed one: its rotations about an axis."""

    kind: Literal["rotation", "torus", "all-rotations"]
    """rotation: about one axis; torus: about two; all-rotations: about every axis."""
    axis_point: Axis | None
    """A point of the axis, base frame; for a torus one of each; null for all rotations."""
    axis_direction: Axis | None
    """Unit vector of the axis; for a torus one of each; null for all rotations."""
    angle_ranges: Arcs
    """For which angles the family's poses are static: [[start_lo, start_hi], [end_lo, end_hi]] each; 0 is
    the listed pose."""


@dataclass(frozen=True)
class Nominal(Described):
    """Plain floats near the certified pose; not certified."""

    position: Triple
    """Platform origin in the base frame."""
    quaternion_wxyz: Quadruple
    """Unit quaternion, scalar first, platform to base."""
    rpy: Triple
    """Roll, pitch, yaw: R = Rz(yaw) Ry(pitch) Rx(roll)."""


@dataclass(frozen=True, eq=False, repr=False)
class Solution(Described):
    """One static pose in a box: proved to hold exactly one (or one family) where both claims are."""

    taut: Cables
    """The cables proved taut; in Python their indices in file order."""
    cable_states: Annotated[tuple[CableState, ...], PerCable()]
    """What is proved of each cable, file order."""
    position: Vector
    """Platform origin in the base frame."""
    rotation: Matrix
    """Platform to base, row by row; the identity for a point mass."""
    height: Interval
    """Of the centre of mass, along up (the opposite of gravity)."""
    tensions: OfCables
    """File order; [0, 0] for a slack cable. An end is null where nothing bounds it."""
    distances: OfCables
    """From each exit point to its platform anchor, ||A_i - p - R B_i||, file order; over a pulley of a
    platform the length along the cable, from where it starts."""
    slack_respected: Annotated[bool | None, OrUndecided()]
    """True: every cable without tension is at least as long as its distance. False only with
    ``ignore_slack``. In Python None is undecided."""
    existence: Certainty
    """For every choice of lengths the box holds a static pose (or family)."""
    uniqueness: Certainty
    """For no choice of lengths does the box hold two."""
    proof: Proof
    """The theorem behind the entry."""
    stability: Stability
    """Only in a stable pose the platform can hang."""
    nominal: Nominal
    """The middle of the box, for pictures and for starting values."""
    family: Family | None
    """The set of poses that the entry stands for; null for a single pose."""
    note: str = ""
    """One sentence where the entry needs one (tensions not unique, end of a family, ...)."""
    tension_respected: Annotated[bool | None, OrUndecided()] = True
    """Undecided: a cable that may be taut may have a tension outside the limits that were asked for; left out
    where there are none, or all are kept. In Python None is undecided."""

    def __repr__(self) -> str:
        place = ", ".join(f"{x:.6g}" for x in self.nominal.position)
        doubt = "a cable undecided" if self.has_open_cable else "a tension undecided"
        proved = "proved" if self.is_decided else f"proved, {doubt}" if self.is_proved else "open"
        return f"<Solution {self.stability}, taut {self.taut}, near ({place}) m, {proved}>"

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
        return self.is_proved and not self.has_open_cable and self.tension_respected is not None

    @property
    def is_strict(self) -> bool:
        """True when every cable is proved taut or proved slack: none is open, none switches."""
        return all(state in (CableState.TAUT, CableState.SLACK) for state in self.cable_states)


@dataclass(frozen=True, eq=False, repr=False)
class Undecided(Described):
    """A connected cluster of cells that could be neither proved nor excluded: poses may be in it, or none."""

    taut: Cables
    """The subset of taut cables that was looked at."""
    cells: Count
    """How many cells of the search it is made of."""
    reason: str
    """One sentence: what could not be proved."""
    position: Vector
    """Hull of the platform's origins, base frame."""
    rotation: Matrix
    """Hull of the rotations, platform to base."""
    poses: tuple[int, int] | None = None
    """How many static poses of this subset it holds at least and at most, for each choice; null: unknown."""

    def __repr__(self) -> str:
        box = " x ".join(f"[{lo:.6g}, {hi:.6g}]" for lo, hi in self.position.tolist())
        return f"<Undecided taut {self.taut}, {counted(self.cells, 'cell')} in {box} m: {self.reason}>"


@dataclass(frozen=True)
class SubsetReport(Described):
    """What was done for one subset of taut cables."""

    taut: Cables
    """The subset."""
    outcome: Outcome
    """Complete: its poses are all listed."""
    solutions: Count
    """Entries found, also those outside the tension limits of the question."""
    cells: Count
    """Cells looked at."""
    time: float
    """Wall time."""


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
class Tool(Described):
    """The program that wrote a file."""

    name: str
    """Of the package."""
    version: str
    """Of the package; between releases with the commit."""


@dataclass(frozen=True)
class RobotIdentity(Described):
    """Which robot a result is about."""

    name: str
    """As in its file."""
    sha256: str
    """Digest of its file, in hexadecimal; of a robot made or changed in memory, of the file it would be."""


@dataclass(frozen=True, kw_only=True)
class Question(Described):
    """What was asked, as far as it changes the answer."""

    command: str
    """The command that would ask the same."""
    taut: Cables | None
    """One subset of taut cables; null for all subsets."""
    ignore_slack: bool
    """Poses at which a cable outside the taut ones is too short to be slack were kept."""
    ignore_tension_sign: bool
    """Six taut cables were treated as rigid legs."""
    method: str
    """How a point mass is solved: auto, search or convex."""
    precision: float
    """Target width of the position (m) and of the rotation's entries of a solution."""
    external_force: tuple[FloatOrRange, FloatOrRange, FloatOrRange]
    """Constant force at the centre of mass, base axes, added to the weight: the nearest doubles; [lo, hi]
    where a range was given."""
    tension: tuple[float, float] | None = None
    """Only poses were asked for whose taut cables all have a tension within [lo, hi] (the nearest doubles);
    slack cables are not judged. Null: poses with any tensions."""
    tensions_given: Annotated[tuple[tuple[float, float], ...], PerCable()] | None = None
    """What was known instead of lengths: [lo, hi] of each cable, file order; left out otherwise."""


@dataclass(frozen=True)
class Statistics(Described):
    """What the run cost."""

    cells: Count
    """Cells looked at."""
    time: float
    """Wall time."""
    threads: Count
    """The solutions do not depend on them."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ResultData(Described):
    """Certified static poses of a cable robot; readers ignore keys they do not know.

    Guarantee: with outcome complete every static pose of what was asked lies in the box of one of the
    solutions, and each of these boxes holds exactly one pose (or one family).
    """

    tool: Tool
    """The program that wrote it."""
    robot: RobotIdentity
    """Which robot it is about: name and digest; in Python `source_robot` is the robot itself."""
    model: str
    """The class of the robot: point-mass or six-dof."""
    cables: tuple[str, ...]
    """Names, file order: the order of all lists of cables."""
    lengths: OfCables
    """Doubles that enclose the exact lengths, which are in ``provenance``; unstretched for elastic cables."""
    question: Question
    """What was asked."""
    outcome: Outcome
    """Complete: the solutions are proved to be all there are."""
    stop_reason: StopReason
    """Why the search ended; exhausted means that it went to the end."""
    message: str
    """One sentence: what was found and whether it is all; without a pose, why there is none."""
    solutions: tuple[Solution, ...]
    """Stable, undecided, unstable; then lowest first; then by taut cables; then by position."""
    undecided: tuple[Undecided, ...]
    """What the search worked on to the end and could not decide."""
    pending: Count
    """Cells not looked at."""
    subsets: tuple[SubsetReport, ...]
    """What was done for each subset of taut cables, smallest first."""
    statistics: Statistics
    """Cells, time and threads of the whole run."""
    provenance: Provenance | None = None
    """Where the result comes from; left out of results written before there was one."""

    def is_about(self, robot: Robot) -> bool:
        """Return whether this is the robot that was solved: the same data, in whatever file."""
        if self.provenance is not None:
            return self.provenance.robot == robot
        return self.robot.sha256 == robot.sha256
