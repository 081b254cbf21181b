"""The blocks of a ``cdpr-robot/1`` file as pydantic models; also the source of its JSON Schema.

Every length in m, mass in kg, force in N.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Annotated, Any

from pydantic import AfterValidator, Field, PlainValidator, WithJsonSchema, model_validator

from cdpr_interval.exact.range import Range
from cdpr_interval.files.fields import (
    CABLE_NAME,
    SHAPES,
    Block,
    Flag,
    Pair,
    Positive,
    Quantity,
    Text,
    Tolerance,
    Vector,
    bounds,
    cable_name,
    integer,
    kind,
    lengths_rising,
    not_zero,
    one_line,
    one_of,
    schema_of,
    tension_limits,
    text,
)
from cdpr_interval.robots.cable_robot import FORMAT
from cdpr_interval.robots.pulley import BALANCES, EXACT, complaints
from cdpr_interval.text.literal import quote

ROBOT_FORMAT = FORMAT


def _format(value: object) -> str:
    if text(value) != ROBOT_FORMAT:
        raise ValueError(f"must be {quote(ROBOT_FORMAT)}, got {kind(value)}")
    return ROBOT_FORMAT


class ElasticityBlock(Block):
    """How a cable stretches: exactly one of the two."""

    stiffness_N_per_m: Positive | None = None
    """Spring constant k."""
    axial_stiffness_N: Positive | None = None
    """EA; k = EA / (unstretched length)."""

    @model_validator(mode="after")
    def _exactly_one(self) -> ElasticityBlock:
        if len(self.model_fields_set) != 1:
            raise ValueError("must hold exactly one of 'stiffness_N_per_m' and 'axial_stiffness_N'")
        return self


class PulleyBlock(Block):
    """A swivelling pulley; the cable's ``frame_anchor_m`` is the point A of the swivel axis."""

    radius_m: Quantity
    """Of the rope's centre line; 0 only without an arm."""
    joints: integer(1, 2) = 1  # type: ignore[valid-type]
    """1: turns about the axis; 2: universal joint at A."""
    arm_m: Quantity | None = None
    """From A to the pulley's centre, at least the radius; default the radius."""
    axis: Vector | None = None
    """Direction in which the rope arrives; default up."""
    lead_in_m: Quantity | None = None
    """The rope starts at A - lead_in_m axis; default 0."""
    balance: one_of(*BALANCES) = EXACT  # type: ignore[valid-type]
    """Two joints: the arm along the resultant of both legs, or on the bisector of the angle at A."""

    @model_validator(mode="after")
    def _rules(self) -> PulleyBlock:
        if broken := complaints(
            self.given(), ("radius_m", "arm_m", "axis", "lead_in_m", "joints", "balance")
        ):
            raise ValueError("; ".join(f"{key} {text}" for key, text in broken))
        return self

    def given(self) -> SimpleNamespace:
        """Return the numbers by the names of `cdpr_interval.robots.pulley.Pulley`."""

        def scalar(quantity: Any) -> Range | None:
            return None if quantity is None else Range(*bounds(quantity))

        axis = None if self.axis is None else tuple(map(scalar, self.axis))
        return SimpleNamespace(
            radius=scalar(self.radius_m),
            arm=scalar(self.arm_m),
            axis=axis,
            lead_in=scalar(self.lead_in_m) or Range.exact(0),
            joints=self.joints,
            balance=self.balance,
        )


class CableBlock(Block):
    """One cable."""

    name: Annotated[
        str,
        PlainValidator(cable_name),
        WithJsonSchema({"type": "string", "pattern": f"^{CABLE_NAME.pattern}$"}),
    ]
    """Unique in the file."""
    frame_anchor_m: Vector
    """Exit point A_i, base frame."""
    platform_anchor_m: Vector
    """Platform point B_i, platform frame."""
    elasticity: ElasticityBlock | None = None
    """Absent: inextensible."""
    pulley: PulleyBlock | None = None
    """Absent: a fixed exit point."""
    tension_limits_N: Annotated[Pair, AfterValidator(tension_limits)] | None = None
    """Reported against, never a filter."""
    leg: Flag = False
    """True: a strut that pushes and pulls; then every cable is one, without elasticity, pulley and winch."""
    length_limits_m: Annotated[Pair, AfterValidator(lengths_rising)] | None = None
    """Of a leg; reported against, never a filter."""


class PlatformBlock(Block):
    """The load."""

    mass_kg: Positive
    centre_of_mass_m: Vector | None = None
    """Platform frame; default the origin."""


class RobotBlock(Block):
    """A cable-driven parallel robot, SI units, the unit in the key."""

    format: Annotated[str, PlainValidator(_format), WithJsonSchema({"const": ROBOT_FORMAT})]
    name: Annotated[Text, AfterValidator(one_line)]
    source: Text | None = None
    """Where the numbers come from."""
    gravity_m_s2: Annotated[Vector, AfterValidator(not_zero)] | None = None
    """Base frame; default [0, 0, -9.81]. "Up" is its opposite."""
    platform: PlatformBlock
    cables: Annotated[list[CableBlock], Field(min_length=1)]


BLOCKS: dict[str, type[Block]] = {
    "": RobotBlock,
    "platform": PlatformBlock,
    "cables": CableBlock,
    "elasticity": ElasticityBlock,
    "pulley": PulleyBlock,
    SHAPES[1]: Tolerance,
}
"""Each block by the last name of its place, for suggestions."""


def json_schema(robot: type[RobotBlock]) -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of ``cdpr-robot/1``, from the model with all blocks."""
    schema = schema_of(robot, ROBOT_FORMAT)
    elasticity = schema["$defs"]["ElasticityBlock"]
    elasticity["oneOf"] = [{"required": [key]} for key in elasticity["properties"]]
    return schema
