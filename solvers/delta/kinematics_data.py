"""The kinematics of a Delta at a pose and over a box, as plain data: ``cdpr-kinematics-result/1``."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from cdpr_interval.exact.enclosure import Bounds
from solvers.answers.data import Outcome, RobotIdentity, Tool
from solvers.answers.document import to_document
from solvers.answers.fields import Count, Described, Interval, Matrix, Numbers, Triple, Vector
from solvers.answers.json_text import dumps
from solvers.delta.data import Kept, Origin, Three

FORMAT = "cdpr-kinematics-result/1"
Each = tuple[Kept, Kept, Kept]
Speeds = Annotated[Bounds, Numbers((3, 2))]


@dataclass(frozen=True, eq=False)
class DeltaKinematicsQuestion(Described):
    """What was asked."""

    command: str
    """The command that would ask the same."""
    position: Vector
    """Doubles that enclose the pose that was given."""
    rates: Triple | None
    """Speeds of the drives, rad/s or m/s; null: the platform's velocity was given, or none."""
    velocity: Triple | None
    """Of the platform, m/s; null: the drives' speeds were given, or none."""
    box: Triple | None
    """Half widths in m of the box of poses."""


@dataclass(frozen=True)
class Singularity(Described):
    """How the bars and drives hold the platform at the pose."""

    singular: Kept
    """In any way; undecided where the data are not exact enough to tell 0 from nearly 0."""
    kinds: tuple[str, ...]
    """a: all bars parallel; b: those of two chains; c: two parallelograms in parallel planes; d: all three;
    and two that the source leaves out: coplanar bars, coplanar normals."""
    rank: int | None
    """Of the six bars; the platform gains 6 minus that many freedoms. Null: not known."""
    rank_of_bars: int | None
    """Of the directions of the three pairs of bars."""
    rank_of_normals: int | None
    """Of the normals of the three parallelograms."""
    drives_singular: Each
    """Of each chain: its joint cannot push the platform, and its two branches meet."""


@dataclass(frozen=True)
class FreeBox(Described):
    """What is proved over the box of poses."""

    free: Kept
    """True: no pose of it is singular in any way, and all are within reach."""
    cells: Count
    """Cells looked at."""
    reason: str
    """What could not be proved, and where; empty otherwise."""


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class DeltaKinematics(Described):
    """Jacobian, speeds and singularities of a Delta; bounds enclose for every choice of data in ranges."""

    tool: Tool
    """The program that wrote it."""
    robot: RobotIdentity
    """Which robot it is about."""
    model: str
    """The class of the robot: delta."""
    question: DeltaKinematicsQuestion
    """What was asked."""
    outcome: Outcome
    """Complete: nothing is left open."""
    message: str
    """One sentence."""
    drives: Three
    """Angles in rad or positions in m, useful branch."""
    jacobian_inverse: Matrix | None
    """From the platform's velocity to the drives' speeds, row by row; null where a drive may be singular."""
    bars: Matrix
    """Unit vectors along the bars, row by row: bars . velocity = pushes * speeds."""
    pushes: Three
    """How a drive moves its knee along the bars, m/rad or 1."""
    singular_values: Three | None
    """Of the inverse Jacobian, largest first."""
    condition: Interval | None
    """The largest over the smallest; null where it is not bounded."""
    velocity: Speeds | None
    """Of the platform, m/s."""
    rates: Speeds | None
    """Of the drives, rad/s or m/s."""
    singularity: Singularity
    """At the pose."""
    box: FreeBox | None
    """Over the box; null where none was asked for."""
    undecided: tuple[str, ...]
    """What could not be proved, one sentence each."""
    provenance: Origin
    """Where the result comes from."""

    def __repr__(self) -> str:
        return f"<DeltaKinematics {self.robot.name}: {self.message}>"

    def __str__(self) -> str:
        """Return the table that the command line prints."""
        return "\n".join(_lines(self))

    def to_dict(self) -> dict[str, Any]:
        """Return the ``cdpr-kinematics-result/1`` document as plain lists and dictionaries."""
        return to_document(self, FORMAT, ())

    def to_json(self) -> str:
        """Return the document as text."""
        return dumps(self.to_dict())


def _lines(result: DeltaKinematics) -> Iterator[str]:
    yield f"{result.robot.name}: {result.message}"
    if result.jacobian_inverse is not None:
        for k, row in enumerate(result.jacobian_inverse):
            name = "inverse Jacobian" if k == 0 else ""
            yield f"  {name:17}" + "  ".join(f"{float(x.mean()):10.4f}" for x in row)
    if result.singular_values is not None and result.condition is not None:
        values = ", ".join(f"{float(x.mean()):.4f}" for x in result.singular_values)
        yield f"  singular values  {values}; condition {float(result.condition.mean()):.4f}"
    for name, speeds in (("velocity", result.velocity), ("drive speeds", result.rates)):
        if speeds is not None:
            unit = " m/s" if name == "velocity" else ""
            yield f"  {name:17}" + ", ".join(f"{float(x.mean()):.6f}" for x in speeds) + unit
    of = result.singularity
    word = {True: "singular", False: "regular", None: "not known"}[of.singular]
    kinds = f" ({', '.join(of.kinds)})" if of.kinds else ""
    yield f"  pose             {word}{kinds}, rank {'not known' if of.rank is None else of.rank} of 6"
    if True in of.drives_singular:
        chains = ", ".join(str(k + 1) for k, value in enumerate(of.drives_singular) if value)
        yield f"  singular drives  of chains {chains}"
    if result.box is not None:
        free = {True: "proved free of singular poses", False: "not free", None: "not proved"}[result.box.free]
        yield f"  box              {free}, {result.box.cells} cells"
    yield from (f"  not proved: {reason}" for reason in result.undecided)
