"""What a motion answers as plain data: the only description of the file format ``cdpr-motion/1``."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction

import numpy as np

from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.mechanics.stability import Stability
from solvers.answers.data import Outcome, RobotIdentity, Solution, StopReason, Tool
from solvers.answers.fields import Cables, Count, Described, Matrix, OfCables, Triple, Vector
from solvers.answers.provenance import Provenance
from solvers.motions.trail import Span

FORMAT = "cdpr-motion/1"
Times = tuple[float, float]


class EventKind(StrEnum):
    """What happens to a pose.

    slack, taut: a cable becomes so. fold: proved that the pose ends, for the middles of the lengths. lost: it
    cannot be followed any further; whether it ends there is not proved.
    """

    SLACK = "slack"
    TAUT = "taut"
    FOLD = "fold"
    LOST = "lost"


@dataclass(frozen=True, eq=False)
class Tube(Described):
    """Where the pose is, for all times of a segment and all choices of the lengths in their ranges."""

    position: Vector
    """Platform origin in the base frame."""
    rotation: Matrix
    """Platform to base, row by row; the identity for a point mass."""
    tensions: OfCables
    """File order; [0, 0] for a slack cable. An end is null where nothing bounds it."""


@dataclass(frozen=True, eq=False)
class Segment(Described):
    """A span of time with the same cables taut, between two rows at most."""

    t: Times
    """When it begins and ends, the nearest doubles; where two segments meet either of them holds."""
    taut: Cables
    """The cables proved taut all along; in Python their indices in file order."""
    switching: Cables
    """Cables that are taut or slack, by the time and the choice of the lengths; all others are slack."""
    tube: Tube
    """Where the pose is."""


@dataclass(frozen=True, eq=False)
class PoseData(Described):
    """A static pose for the lengths at one time: of ranges, of lengths or data, for their middles."""

    taut: Cables
    """The cables proved taut."""
    position: Vector
    """Platform origin in the base frame."""
    rotation: Matrix
    """Platform to base."""
    tensions: OfCables
    """File order."""
    stability: Stability
    """Only in a stable pose the platform can hang."""


@dataclass(frozen=True, eq=False)
class Event(Described):
    """Something that happens to the pose between two times."""

    t: Times
    """Not before the first and not after the second time. Before the first time of a fold or a loss all is
    proved."""
    kind: EventKind
    """What happens."""
    cable: str | None
    """The cable that becomes slack or taut; null: the pose ends or is lost."""
    reason: str = ""
    """Of a fold or a loss, one sentence; else empty."""
    poses: tuple[PoseData, ...] = ()
    """After a fold or a loss: the poses found at the second time."""


@dataclass(frozen=True, eq=False)
class Track(Described):
    """One pose, followed from the start."""

    start: PoseData
    """The pose at the start."""
    segments: tuple[Segment, ...]
    """One after the other, without gaps, as far as the pose is followed."""
    events: tuple[Event, ...]
    """In the order of their times."""


@dataclass(frozen=True)
class MotionQuestion(Described):
    """What was asked, beside the robot."""

    command: str
    """The command that would ask the same."""
    file: str | None
    """The CSV file; null: the rows came from Python."""
    rows: Count
    """How many there are."""
    t: Times
    """The first and the last time."""
    tolerance: float
    """Every exact length counts as known to this."""
    step: float | None
    """Longest segment; null: from row to row."""
    near: Triple | None
    """The start is the stable pose nearest to here; null: every stable pose is followed."""


@dataclass(frozen=True, eq=False, kw_only=True)
class MotionData(Described):
    """The static pose of a cable robot along lengths over time; readers ignore keys they do not know.

    Guarantee: for all lengths that stay in their ranges and start with the first row, a platform that follows
    them slowly and starts as said is in the tube of a segment at every time of it.
    """

    tool: Tool
    """The program that wrote it."""
    robot: RobotIdentity
    """Which robot it is about: name and digest."""
    model: str
    """The class of the robot: point-mass or six-dof."""
    cables: tuple[str, ...]
    """Names, file order: the order of all lists of cables."""
    question: MotionQuestion
    """What was asked."""
    outcome: Outcome
    """Complete: every stable pose of the start (of ranges on a platform: of their middles), or the one asked
    for, is proved to the last time."""
    stop_reason: StopReason
    """Why it ended; exhausted means that nothing stopped it."""
    message: str
    """One sentence: how far the motion is proved."""
    start: PoseData | None
    """The pose at the start; null: there is none, or none is proved."""
    segments: tuple[Segment, ...]
    """Of the pose that is followed; of several, of the lowest at the start."""
    events: tuple[Event, ...]
    """Of the same pose."""
    others: tuple[Track, ...]
    """The other stable poses of the start, followed likewise; empty where one was asked for."""
    time: float
    """Wall time."""
    provenance: Provenance | None = None
    """Where the result comes from; the lengths are those of the first row."""


@dataclass(frozen=True)
class EventData:
    """An event with exact times."""

    begin: Fraction
    """s."""
    end: Fraction
    kind: EventKind
    cable: str | None = None
    reason: str = ""
    poses: tuple[PoseData, ...] = ()

    def rounded(self) -> Event:
        """Return the event in doubles, its times rounded outwards."""
        times = enclose(self.begin)[0], enclose(self.end)[1]
        return Event(times, self.kind, self.cable, self.reason, self.poses)


def pose_data(solution: Solution) -> PoseData:
    """Return a solution as a pose of a motion."""
    return PoseData(
        solution.taut, solution.position, solution.rotation, solution.tensions, solution.stability
    )


def segment_of(span: Span, is_last: bool = False) -> Segment:
    """Return a span as a segment: one behind which nothing is proved does not end after the span."""
    tube = span.tube
    tensions = np.maximum(tube.tensions, 0.0)
    times = float(span.begin), enclose(span.end)[0] if is_last else float(span.end)
    return Segment(times, tube.taut, tube.switching, Tube(tube.position, tube.rotation, tensions))
