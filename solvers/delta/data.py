"""What is answered about a Delta, as plain data: the only description of the two formats of its results.

``cdpr-delta-result/1`` holds all poses for given drives, ``cdpr-delta-ik-result/1`` the drives at a pose.
Bounds are float64 arrays whose last axis is (lo, hi).
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Annotated

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.robots.delta import DeltaRobot
from solvers.answers.data import Outcome, RobotIdentity, Tool
from solvers.answers.fields import ANY, Described, Numbers, OrUndecided, Triple, Vector
from solvers.answers.provenance import host, versions

FORMAT = "cdpr-delta-result/1"
IK_FORMAT = "cdpr-delta-ik-result/1"
Three = Annotated[Bounds, Numbers((3, 2))]
Rows = Annotated[Bounds, Numbers((ANY, 3, 2))]
Kept = Annotated[bool | None, OrUndecided()]


@dataclass(frozen=True)
class Origin(Described):
    """Where an answer comes from."""

    date: datetime
    """UTC: when the answer was ready."""
    host: str
    """Name of the machine."""
    versions: dict[str, str]
    """Of this package, of Python, and of the packages whose arithmetic the numbers come from."""
    asked: tuple[str, str, str]
    """The three numbers of the question, exactly, as the command line takes them."""
    robot: str
    """The text of the robot's file; of one made in memory, of the file it would be."""


@dataclass(frozen=True, eq=False)
class DeltaQuestion(Described):
    """What was asked."""

    command: str
    """The command that would ask the same."""
    angles: Three | None = None
    """Doubles that enclose the arms' angles; null for linear drives, and where a pose was given."""
    positions: Three | None = None
    """Doubles that enclose the carriages' positions; null for rotary drives, and where a pose was given."""
    position: Vector | None = None
    """Doubles that enclose the pose that was given; null where drives were."""


@dataclass(frozen=True, eq=False)
class DeltaPose(Described):
    """A pose of the platform, which never turns: proved to be there, and alone in its box."""

    position: Vector
    """Tool point in the base frame."""
    lower: Kept
    """True: it is the lower one of the two; undecided where the data do not tell."""
    bar_angles: Three
    """By how much the bars of each chain lean out of its plane."""
    elbow_angles: Three | None
    """At each knee from arm to bars, below half a turn on the useful branch; null for linear drives."""
    limits_respected: Kept
    """Of the angles that the robot's file states; true without any."""


@dataclass(frozen=True, eq=False, kw_only=True)
class DeltaResultData(Described):
    """All poses of a Delta for given drives.

    Guarantee: with outcome complete there are no other poses, for every choice of data in their ranges.
    """

    tool: Tool
    """The program that wrote it."""
    robot: RobotIdentity
    """Which robot it is about."""
    model: str
    """The class of the robot: delta."""
    question: DeltaQuestion
    """What was asked."""
    outcome: Outcome
    """Complete: the solutions are proved to be all there are."""
    message: str
    """One sentence: what was found and whether it is all."""
    solutions: tuple[DeltaPose, ...]
    """The lower one first."""
    undecided: tuple[str, ...]
    """What could not be proved, one sentence each."""
    provenance: Origin
    """Where the result comes from."""


@dataclass(frozen=True, eq=False, kw_only=True)
class DeltaIkData(Described):
    """The drives that bring the tool point of a Delta to a pose.

    Guarantee: with outcome complete the useful and the other branch of each chain are all that there are,
    for every choice of data in their ranges; they are null where the pose is out of reach.
    """

    tool: Tool
    """The program that wrote it."""
    robot: RobotIdentity
    """Which robot it is about."""
    model: str
    """The class of the robot: delta."""
    question: DeltaQuestion
    """What was asked."""
    outcome: Outcome
    """Complete: nothing is left open."""
    message: str
    """One sentence."""
    reachable: Kept
    """All three chains reach the pose."""
    position: Triple
    """Middle of the pose."""
    angles: Three | None
    """Of the arms, useful branch, within half a turn of 0; bounds around half a turn stay in one piece."""
    other_branch: Three | None
    """Of the arms, other branch, likewise."""
    positions: Three | None
    """Of carriages, useful branch: the one nearer to where the rail starts."""
    other_positions: Three | None
    """Of carriages, other branch."""
    bar_angles: Three | None
    """By how much the bars of each chain lean out of its plane, useful branch."""
    elbow_angles: Three | None
    """At each knee from arm to bars, useful branch; null for linear drives."""
    limits_respected: Kept
    """Of the angles that the robot's file states, useful branch; true without any."""
    undecided: tuple[str, ...]
    """What could not be proved, one sentence each."""
    provenance: Origin
    """Where the result comes from."""


def origin_of(robot: DeltaRobot, asked: tuple[str, str, str]) -> Origin:
    """Return where an answer that is ready now comes from."""
    now = datetime.fromtimestamp(int(time.time()), UTC)
    return Origin(now, host(), dict(versions()), asked, robot.text)
