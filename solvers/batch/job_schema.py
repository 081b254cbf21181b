"""The blocks of a ``cdpr-batch/1`` file as pydantic models: robots, problems, options, outputs.

Lengths in m, angles in degrees, forces in N.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Annotated, Any

from pydantic import Discriminator, Field, PlainValidator, Tag, WithJsonSchema, model_validator

from cdpr_interval.files.document import Node
from cdpr_interval.files.fields import (
    Block,
    Flag,
    Name,
    Number,
    Pair,
    PositiveNumber,
    Text,
    constant,
    integer,
    kind,
    known_type,
    list_of,
    one_of,
    type_tag,
)
from cdpr_interval.files.validation import Models
from cdpr_interval.text.literal import quote
from solvers.questions.problem import Method

BATCH_FORMAT = "cdpr-batch/1"
MOST_SAMPLES = 10_000_000
LARGEST_SEED = 2**63 - 1
AXES = ("x", "y", "z")
MOST_PARTS = 4096
MOST_PLACES = 1_000_000
"""Of one axis of a pose grid."""


def _format(value: object) -> str:
    if not (isinstance(value, Node) and value.value == BATCH_FORMAT):
        raise ValueError(f"must be {quote(BATCH_FORMAT)}, got {kind(value)}")
    return BATCH_FORMAT


def _entry(value: object) -> Any:
    """Return one length as its reader takes it: a fraction, a text, or a pair of fractions."""
    if isinstance(value, Node) and isinstance(value.value, Fraction | str):
        return value.value
    if isinstance(value, list) and len(value) == 2:
        ends = [entry.value for entry in value if isinstance(entry, Node)]
        if len(ends) == 2 and all(isinstance(end, Fraction) for end in ends):
            return tuple(ends)
    raise ValueError(f"must be a length such as 2.69, 2.69+-0.01 or [2.68, 2.70], got {kind(value)}")


def _lengths(value: object) -> list[Any] | dict[str, Any]:
    if isinstance(value, dict):
        return {name: _entry(entry) for name, entry in value.items()}
    if isinstance(value, list):
        return [_entry(entry) for entry in value]
    raise ValueError(f"must be a list, or a mapping from cable to length, got {kind(value)}")


Lengths = Annotated[Any, PlainValidator(_lengths), WithJsonSchema({"type": ["array", "object"]})]


class RobotFolder(Block):
    """Every robot file of a folder, in the order of their names."""

    folder: Text


def _robot(value: object) -> Any:
    return "<folder>" if isinstance(value, dict) else "<robot>"


RobotSource = Annotated[
    Annotated[Text, Tag("<robot>")] | Annotated[RobotFolder, Tag("<folder>")], Discriminator(_robot)
]


class SpreadBlock(Block):
    """How a number is drawn around its nominal value."""

    distribution: one_of("uniform", "normal")  # type: ignore[valid-type]
    half_width: PositiveNumber | None = None
    """Of a uniform distribution, in the unit of the number."""
    relative_half_width: PositiveNumber | None = None
    """The same as a share of the nominal value."""
    sigma: PositiveNumber | None = None
    """Of a normal distribution, in the unit of the number."""
    relative_sigma: PositiveNumber | None = None
    """The same as a share of the nominal value."""
    cut: PositiveNumber | None = None
    """A normal distribution ends at so many sigma; default 4."""

    @model_validator(mode="after")
    def _one_width(self) -> SpreadBlock:
        kinds = {"uniform": ("half_width", "relative_half_width"), "normal": ("sigma", "relative_sigma")}
        wanted = kinds[self.distribution]
        given = [name for names in kinds.values() for name in names if getattr(self, name) is not None]
        if len(given) != 1 or given[0] not in wanted:
            raise ValueError(f"a {self.distribution} distribution has exactly one of {' and '.join(wanted)}")
        if self.cut is not None and self.distribution != "normal":
            raise ValueError("cut is for a normal distribution")
        return self


class AnchorSpreadBlock(SpreadBlock):
    """How the coordinates of points are drawn."""

    axes: Annotated[list[one_of(*AXES)], Field(min_length=1)] | None = None  # type: ignore[valid-type]
    """The coordinates that are moved; default all three."""


class PerturbBlock(Block):
    """What is drawn; every number on its own."""

    lengths_m: SpreadBlock | None = None
    stiffness: SpreadBlock | None = None
    """Of elastic cables (k or EA), relative widths only."""
    frame_anchors_m: AnchorSpreadBlock | None = None
    """Each coordinate, absolute widths only."""
    platform_anchors_m: AnchorSpreadBlock | None = None
    """The same, for platforms."""
    mass_kg: SpreadBlock | None = None
    """Of the platform or the point mass."""
    centre_of_mass_m: AnchorSpreadBlock | None = None
    """Of a platform, each coordinate, absolute widths only."""

    @model_validator(mode="after")
    def _something(self) -> PerturbBlock:
        if not self.model_fields_set:
            raise ValueError(f"must hold at least one of {', '.join(type(self).model_fields)}")
        return self


class AxisBlock(Block):
    """Places on one axis, evenly spaced, both ends among them."""

    start: Annotated[Number, Field(alias="from")]
    end: Annotated[Number, Field(alias="to")]
    count: integer(1, MOST_PLACES)  # type: ignore[valid-type]

    @model_validator(mode="after")
    def _apart(self) -> AxisBlock:
        if (self.count == 1) != (self.start == self.end):
            raise ValueError("'from' and 'to' differ exactly when count is above 1")
        return self


def _axis(value: object) -> str:
    return "<axis>" if isinstance(value, dict) else "<place>"


Axis = Annotated[
    Annotated[Number, Tag("<place>")] | Annotated[AxisBlock, Tag("<axis>")], Discriminator(_axis)
]


class PositionBlock(Block):
    """Platform origin in the base frame, m."""

    x: Axis
    y: Axis
    z: Axis


class OrientationBlock(Block):
    """Rotation Rz(yaw) Ry(pitch) Rx(roll), degrees."""

    roll: Axis | None = None
    pitch: Axis | None = None
    yaw: Axis | None = None


class ProblemBlock(Block):
    """What every kind of problem may say."""

    robots: Annotated[list[Name], Field(min_length=1)] | None = None
    """Names of the robots that are asked; default all."""
    taut: Annotated[list[Name], Field(min_length=1)] | None = None
    """One subset of taut cables instead of all."""
    external_force_N: Annotated[tuple[Number, Number, Number], list_of(3, "3 numbers")] | None = None
    """At the centre of mass, base axes, added to the weight."""
    tension_N: Pair | None = None
    """Only poses whose taut cables all have a tension within these limits."""


class LengthsBlock(ProblemBlock):
    """Lists of lengths, written out."""

    type: constant("lengths")  # type: ignore[valid-type]
    lengths_m: Annotated[list[Lengths], Field(min_length=1)]


class CsvBlock(ProblemBlock):
    """Lists of lengths in a table whose head names the cables."""

    type: constant("csv")  # type: ignore[valid-type]
    file: Text


class PosesBlock(ProblemBlock):
    """A grid of poses, whose lengths follow from inverse kinematics."""

    type: constant("poses")  # type: ignore[valid-type]
    position_m: PositionBlock
    orientation_deg: OrientationBlock | None = None
    settle: Flag | None = None
    """Move each pose to the nearest static one first; default false."""


class MonteCarloBlock(ProblemBlock):
    """Random perturbations of one list of lengths, and of the robot."""

    type: constant("monte-carlo")  # type: ignore[valid-type]
    lengths_m: Lengths
    """Nominal lengths."""
    samples: integer(1, MOST_SAMPLES)  # type: ignore[valid-type]
    seed: integer(0, LARGEST_SEED)  # type: ignore[valid-type]
    perturb: PerturbBlock


PROBLEMS: dict[str, type[Block]] = {
    "<lengths>": LengthsBlock,
    "<csv>": CsvBlock,
    "<poses>": PosesBlock,
    "<monte-carlo>": MonteCarloBlock,
}
"""Each kind of problem by its tag in pydantic's error locations."""

AnyProblem = Annotated[
    Annotated[LengthsBlock, Tag("<lengths>")]
    | Annotated[CsvBlock, Tag("<csv>")]
    | Annotated[PosesBlock, Tag("<poses>")]
    | Annotated[MonteCarloBlock, Tag("<monte-carlo>")],
    Discriminator(type_tag),
]


class OptionsBlock(Block):
    """How each problem is solved: the options of ``fk``."""

    ignore_slack: Flag | None = None
    ignore_tension_sign: Flag | None = None
    method: one_of(*Method) | None = None  # type: ignore[valid-type]
    precision: PositiveNumber | None = None
    time_limit_s: PositiveNumber | None = None
    """A result that stopped there depends on the machine."""
    cell_limit: integer(1, 2**62) | None = None  # type: ignore[valid-type]
    split: integer(2, MOST_PARTS) | None = None  # type: ignore[valid-type]
    """Search every larger taut subset of a platform in so many parts, each a job of its own."""
    certificates: Flag | None = None
    """Keep the proof of every job in the ledger."""


class OutputsBlock(Block):
    """Tables written at the end beside ``summary.json``."""

    csv: Flag | None = None
    """``solutions.csv``; default true."""
    jsonl: Flag | None = None
    """``results.jsonl``; default true."""
    parquet: Flag | None = None
    """``solutions.parquet``, needs the extra ``cluster``; default false."""


class BatchBlock(Block):
    """Many problems for one or more robots."""

    format: Annotated[str, PlainValidator(_format), WithJsonSchema({"const": BATCH_FORMAT})]
    name: Name | None = None
    robots: Annotated[list[RobotSource], Field(min_length=1)]
    """Names of shipped robots, files or folders; relative to the job file."""
    problems: Annotated[
        list[Annotated[AnyProblem, known_type(PROBLEMS)]],
        Field(min_length=1),
    ]
    options: OptionsBlock | None = None
    outputs: OutputsBlock | None = None


BLOCKS: dict[str, type[Block]] = {
    "": BatchBlock,
    "robots": RobotFolder,
    "<folder>": RobotFolder,
    **PROBLEMS,
    "perturb": PerturbBlock,
    "position_m": PositionBlock,
    "orientation_deg": OrientationBlock,
    "options": OptionsBlock,
    "outputs": OutputsBlock,
    "<axis>": AxisBlock,
    "lengths_m": SpreadBlock,
    "stiffness": SpreadBlock,
    "frame_anchors_m": AnchorSpreadBlock,
    "platform_anchors_m": AnchorSpreadBlock,
    "mass_kg": SpreadBlock,
    "centre_of_mass_m": AnchorSpreadBlock,
}
"""Each block by the last name of its place, for suggestions."""
TAGS = (*PROBLEMS, "<robot>", "<folder>", "<axis>", "<place>")
"""They occur in pydantic's error locations only."""

MODELS = Models(BatchBlock, BLOCKS, TAGS, word=BATCH_FORMAT)
"""What a job file is checked against."""
