"""A Delta robot: frozen data in SI units, every number exact or a range.

Conventions (EPFL, *Les robots paralleles*, 1.3): chain i stands at the angle theta_i about z. Its shoulder
A_i is at the base radius R_A, its ball joint B_i at the platform radius R_B from the platform's centre P, in
the same direction; the platform never turns. With rotary drives the arm of length L_A turns by alpha about
the tangent at A_i, 0 outwards, positive downwards. With linear drives a carriage runs along a rail through
A_i. The bars of length L_B lead from the knee or carriage to the platform.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any, Self

from cdpr_interval.errors import InputError
from cdpr_interval.exact.angle import Angle
from cdpr_interval.exact.decimals import plain_scalar
from cdpr_interval.exact.range import Range, as_range
from cdpr_interval.robots.numbers import Part, Point, Scalar, entries, read_point, read_scalar
from cdpr_interval.text.writing import yaml_text

FORMAT = "delta-robot/1"
DELTA = "delta"
ROTARY, LINEAR = "rotary", "linear"
DRIVES = (ROTARY, LINEAR)
REGULAR = (Angle.degrees(0), Angle.degrees(120), Angle.degrees(240))
ORIGIN: Point = (Fraction(0), Fraction(0), Fraction(0))
LIMITS = ("gamma_max", "elbow_min", "elbow_max")
"""Angles that a pose is reported against, each optional."""


@dataclass(frozen=True)
class DeltaRobot(Part):
    """A Delta robot with three chains; see ``delta-robot/1``.

    Raises
    ------
    InputError
        A length is not positive, rails are missing or have no direction, or an angle is out of order.
    """

    name: str
    base_radius: Scalar
    """R_A, m."""
    platform_radius: Scalar
    """R_B, m."""
    bar: Scalar
    """L_B, m."""
    arm: Scalar | None = None
    """L_A, m; needed with rotary drives, without meaning with linear ones."""
    arm_angles: tuple[Angle, Angle, Angle] = REGULAR
    """theta_i."""
    drives: str = ROTARY
    rail_directions: tuple[Point, Point, Point] | None = None
    """Linear drives: where a carriage's position grows, base axes, of any length but zero."""
    bar_spacing: Scalar | None = None
    """Between the two bars of a chain, m; nothing about positions depends on it."""
    tool_offset: Point = ORIGIN
    """From the platform's centre to the point whose position is meant, m."""
    gamma_max: Angle | None = None
    """Most that a bar may lean out of the plane of its chain."""
    elbow_min: Angle | None = None
    """Least interior angle between arm and bars at the knee."""
    elbow_max: Angle | None = None
    """Largest interior angle; half a turn is a stretched chain."""
    source: str | None = None
    notes: str | None = None
    file: bytes | None = field(default=None, init=False, compare=False, repr=False)
    """What it was read from."""

    model = DELTA
    cable_names = ()

    def __post_init__(self) -> None:
        """Take the numbers exactly, and refuse what is no Delta."""
        for name in ("base_radius", "platform_radius", "bar", "arm", "bar_spacing"):
            if getattr(self, name) is not None:
                self._keep(name, read_scalar(getattr(self, name), name))
        self._keep("tool_offset", read_point(self.tool_offset, "tool_offset"))
        if self.rail_directions is not None:
            rails = tuple(read_point(v, f"rail_directions[{i}]") for i, v in enumerate(self.rail_directions))
            self._keep("rail_directions", rails)
        if broken := list(complaints(self)):
            raise InputError(*(f"{key}: {text}" for key, text in broken))

    @property
    def is_linear(self) -> bool:
        """True where carriages on rails drive the chains."""
        return self.drives == LINEAR

    @property
    def limits(self) -> dict[str, Angle]:
        """The limits that the file states."""
        return {name: getattr(self, name) for name in LIMITS if getattr(self, name) is not None}

    def scalars(self) -> Iterator[tuple[str, Scalar]]:
        """Yield every number that may be a range, each with its path in a file."""
        named = {
            "base_radius_m": self.base_radius,
            "platform_radius_m": self.platform_radius,
            "arm_m": self.arm,
            "bar_m": self.bar,
        }
        yield from ((key, value) for key, value in named.items() if value is not None)
        for i, direction in enumerate(self.rail_directions or ()):
            yield from entries(f"rail_directions[{i}]", direction)
        yield from entries("tool_offset_m", self.tool_offset)

    @cached_property
    def uncertain(self) -> tuple[str, ...]:
        """Paths of the numbers that are ranges."""
        return tuple(path for path, value in self.scalars() if isinstance(value, Range))

    def to_dict(self) -> dict[str, Any]:
        """Return the robot as a mapping with the keys of a file."""
        texts = {"source": self.source, "notes": self.notes}
        found: dict[str, Any] = {"format": FORMAT, "name": self.name}
        found |= {key: text for key, text in texts.items() if text is not None}
        found |= {"base_radius_m": self.base_radius, "platform_radius_m": self.platform_radius}
        found |= {"arm_m": self.arm, "bar_m": self.bar, "bar_spacing_m": self.bar_spacing}
        found = {k: v if isinstance(v, str) else plain_scalar(v) for k, v in found.items() if v is not None}
        if self.arm_angles != REGULAR:
            found["arm_angles_rad"] = list(map(str, self.arm_angles))
        if self.rail_directions is not None:
            rails = [list(map(plain_scalar, direction)) for direction in self.rail_directions]
            found |= {"drives": self.drives, "rail_directions": rails}
        if self.tool_offset != ORIGIN:
            found["tool_offset_m"] = list(map(plain_scalar, self.tool_offset))
        return found | {f"{name}_rad": str(angle) for name, angle in self.limits.items()}

    def read_from(self, data: bytes) -> Self:
        """Return the robot, marked as what a file says. For readers of files only."""
        self._keep("file", data)
        return self

    @cached_property
    def text(self) -> str:
        """The text of the file it was read from; else of the file that `to_dict` would make."""
        return yaml_text(self.to_dict()) if self.file is None else self.file.decode("utf-8")

    @cached_property
    def sha256(self) -> str:
        """Hex digest of that file."""
        return hashlib.sha256(self.text.encode() if self.file is None else self.file).hexdigest()


def complaints(robot: Any) -> Iterator[tuple[str, str]]:
    """Yield the rules that a Delta, or anything with its fields, breaks: pairs of a field and a text."""
    linear = robot.drives == LINEAR
    for name in ("base_radius", "platform_radius", "arm", "bar", "bar_spacing"):
        value = getattr(robot, name)
        least = None if value is None else as_range(value).lo
        if least is not None and (least < 0 or (least == 0 and name in ("arm", "bar"))):
            bound = "greater than 0" if name in ("arm", "bar") else "at least 0"
            yield name, f"must be {bound}, got {float(least):.12g}"
    if robot.drives not in DRIVES:
        yield "drives", f"must be one of {', '.join(DRIVES)}, got {robot.drives!r}"
    elif linear and robot.rail_directions is None:
        yield "rail_directions", "missing: linear drives need three"
    elif not linear and robot.arm is None:
        yield "arm", "missing: rotary drives turn arms"
    elif not linear and robot.rail_directions is not None:
        yield "rail_directions", "only with drives: linear"
    for i, direction in enumerate(robot.rail_directions or ()):
        if all(as_range(x).lo <= 0 <= as_range(x).hi for x in direction):
            yield f"rail_directions[{i}]", "must not be the zero vector"
    if linear:
        for name in LIMITS[1:]:
            if getattr(robot, name) is not None:
                yield name, "not with linear drives, which have no elbows"
    yield from _of_limits(robot)
    if not all(angle.is_exact for angle in robot.arm_angles):
        yield "arm_angles", "must be exact: tolerances are known to lengths only"


def _of_limits(robot: Any) -> Iterator[tuple[str, str]]:
    """Yield the rules that limits break."""
    ends = {}
    for name in LIMITS:
        angle = getattr(robot, name)
        if angle is not None:
            turn = 360 if angle.in_degrees else Fraction(math.tau)
            ends[name] = tuple(float(end / turn) for end in angle.bounds)
            if not 0 <= ends[name][0] <= ends[name][1] <= 1:
                yield name, f"must be an angle from 0 to a whole turn, got {angle}"
    if "elbow_min" in ends and "elbow_max" in ends and ends["elbow_min"][0] > ends["elbow_max"][1]:
        yield "elbow_min", f"must not be above elbow_max, got {robot.elbow_min} and {robot.elbow_max}"
