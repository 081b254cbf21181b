"""A cable robot: frozen data in SI units, every number the exact rational of its source text.

Numbers that are given from Python are taken exactly: an int, `Decimal` or `Fraction` is itself, a float that
very double, a text the decimal that is written, a pair (lo, hi) every number in between.

A number that is given as a range stays one. What treats single numbers only takes each through `exact` or
`exact_point`, which refuse a range: none is ever replaced by its middle on the way to a solver.
"""

from __future__ import annotations

import dataclasses
import hashlib
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any, Self

from cdpr_interval.errors import InputError
from cdpr_interval.exact.decimals import plain_scalar
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.numbers import (
    Part,
    Point,
    Scalar,
    entries,
    exact,
    middle,
    middle_point,
    read_point,
    read_scalar,
)
from cdpr_interval.robots.pulley import Pulley
from cdpr_interval.robots.winch import Winch, WinchGroupSettings
from cdpr_interval.text.literal import LONGEST_NUMBER
from cdpr_interval.text.writing import unreadable, yaml_text

FORMAT = "cdpr-robot/1"
READER = "cdpr_interval.robots.formats.reader"
"""What makes robots of files and mappings. It is built on this module, which has to ask for it by name."""
POINT_MASS = "point-mass"
SIX_DOF = "six-dof"


@dataclass(frozen=True)
class Elasticity(Part):
    """How a cable stretches: exactly one of the two is given."""

    stiffness: Scalar | None = None
    """Spring constant k in N/m."""
    axial_stiffness: Scalar | None = None
    """EA in N; k = EA / (unstretched length)."""

    def __post_init__(self) -> None:
        """Take the numbers exactly."""
        for name in ("stiffness", "axial_stiffness"):
            if (value := getattr(self, name)) is not None:
                number = read_scalar(value, name)
                if (number.lo if isinstance(number, Range) else number) <= 0:
                    raise InputError(f"{name}: must be greater than 0, got {value}")
                self._keep(name, number)

    def middle(self) -> Elasticity:
        """Return it with every range replaced by its middle."""
        given = (self.stiffness, self.axial_stiffness)
        return Elasticity(*(None if value is None else middle(value) for value in given))

    def ends(self) -> tuple[Elasticity, ...]:
        """Return it with the range replaced by its lower and by its upper end; an exact one alone."""
        given = (self.stiffness, self.axial_stiffness)
        if not any(isinstance(value, Range) for value in given):
            return (self,)
        pairs = [value if isinstance(value, Range) else (value, value) for value in given]
        return tuple(Elasticity(*end) for end in zip(*pairs, strict=True))

    def to_dict(self) -> dict[str, Any]:
        """Return the block of a file."""
        keys = {"stiffness_N_per_m": self.stiffness, "axial_stiffness_N": self.axial_stiffness}
        return {key: plain_scalar(value) for key, value in keys.items() if value is not None}


NOT_OF_LEGS = ("elasticity", "tension_limits", "winch", "pulley")
"""What a cable may have and a leg has not."""


@dataclass(frozen=True)
class Cable(Part):
    """One cable: exit point A_i in the base frame, platform point B_i in the platform frame, in m."""

    name: str
    frame_anchor: Point
    platform_anchor: Point
    elasticity: Elasticity | None = None
    tension_limits: tuple[Fraction, Fraction] | None = None
    """In N; reported against, never a filter."""
    winch: Winch | None = None
    """What moves the cable; its tolerances are no uncertain scalars of the robot."""
    pulley: Pulley | None = None
    """What the cable runs over; its arm is measured from ``frame_anchor``, the point A."""
    leg: bool = False
    """A strut of a Gough platform, which pushes and pulls, instead of a cable."""
    length_limits: tuple[Fraction, Fraction] | None = None
    """Of a leg, in m; reported against, never a filter."""

    def __post_init__(self) -> None:
        """Take the numbers exactly, and see that a leg has nothing that only cables have."""
        for name in ("frame_anchor", "platform_anchor"):
            self._keep(name, read_point(getattr(self, name), name))
        for name in ("tension_limits", "length_limits"):
            if (limits := getattr(self, name)) is not None:
                self._keep(name, _exact_pair(limits, name))
        if not isinstance(self.leg, bool):
            raise InputError(f"leg: must be true or false, got {self.leg!r}")
        if self.leg and (given := [name for name in NOT_OF_LEGS if getattr(self, name) is not None]):
            raise InputError(f"{given[0]}: a leg has none")
        if self.length_limits is not None:
            if not self.leg:
                raise InputError("length_limits: only of a leg")
            if not 0 < self.length_limits[0] < self.length_limits[1]:
                raise InputError("length_limits: must be two lengths above 0, the second larger")

    def middle(self) -> Cable:
        """Return it with every range replaced by its middle."""
        return dataclasses.replace(
            self,
            frame_anchor=middle_point(self.frame_anchor),
            platform_anchor=middle_point(self.platform_anchor),
            elasticity=None if self.elasticity is None else self.elasticity.middle(),
            pulley=None if self.pulley is None else self.pulley.middle(),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the block of a file."""
        block: dict[str, Any] = {
            "name": self.name,
            "frame_anchor_m": list(map(plain_scalar, self.frame_anchor)),
            "platform_anchor_m": list(map(plain_scalar, self.platform_anchor)),
        }
        if self.pulley is not None:
            block["pulley"] = self.pulley.to_dict()
        if self.elasticity is not None:
            block["elasticity"] = self.elasticity.to_dict()
        if self.tension_limits is not None:
            block["tension_limits_N"] = list(map(plain_scalar, self.tension_limits))
        if self.winch is not None:
            block["winch"] = self.winch.to_dict()
        if self.leg:
            block["leg"] = True
        if self.length_limits is not None:
            block["length_limits_m"] = list(map(plain_scalar, self.length_limits))
        return block


def _exact_pair(value: Any, name: str) -> tuple[Fraction, Fraction]:
    """Return two numbers that are known exactly."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise InputError(f"{name}: must be 2 numbers, got {value!r}")
    lo, hi = (exact(read_scalar(end, name)) for end in value)
    return lo, hi


@dataclass(frozen=True)
class Platform(Part):
    """The load: mass in kg and centre of mass in the platform frame in m."""

    mass: Scalar
    centre_of_mass: Point = (Fraction(0), Fraction(0), Fraction(0))

    def __post_init__(self) -> None:
        """Take the numbers exactly; a load without weight, which no file may hold, hangs by a force."""
        mass = read_scalar(self.mass, "mass")
        if (mass.lo if isinstance(mass, Range) else mass) < 0:
            raise InputError(f"mass: must not be negative, got {self.mass}")
        self._keep("mass", mass)
        self._keep("centre_of_mass", read_point(self.centre_of_mass, "centre_of_mass"))

    def middle(self) -> Platform:
        """Return it with every range replaced by its middle."""
        return Platform(middle(self.mass), middle_point(self.centre_of_mass))

    def to_dict(self) -> dict[str, Any]:
        """Return the block of a file."""
        centre = list(map(plain_scalar, self.centre_of_mass))
        return {"mass_kg": plain_scalar(self.mass), "centre_of_mass_m": centre}


@dataclass(frozen=True)
class Uncertain:
    """A scalar given as a range: its path in the file (``cables[1].frame_anchor_m[0]``) and bounds."""

    path: str
    lo: Fraction
    hi: Fraction


MOST_NAMED = 8
"""Cables whose names stand in the short text of a robot."""


@dataclass(frozen=True)
class Robot(Part):
    """A cable-driven parallel robot: what a ``cdpr-robot/1`` file says.

    A scalar given as a range is one here too; a solver that cannot treat ranges must refuse a robot whose
    ``uncertain`` is not empty.
    What follows from the data is computed once a robot: the data never change. Two robots of the same data
    are equal, whatever the files they come from.
    """

    name: str
    platform: Platform
    cables: tuple[Cable, ...]
    gravity: Point = (Fraction(0), Fraction(0), Fraction(-981, 100))
    source: str | None = None
    notes: str | None = None
    """What the file says in ``notes``, where that is a text or a list of texts."""
    winches: WinchGroupSettings = field(default_factory=WinchGroupSettings)
    file: bytes | None = field(default=None, init=False, repr=False, compare=False)
    """The file that the robot was read from; None for one made or changed in memory, whatever from."""

    def __repr__(self) -> str:
        names = [*self.cable_names[:MOST_NAMED], *["..."] * (len(self.cables) > MOST_NAMED)]
        return f"<Robot {self.name}: cables {', '.join(names)}>"

    def __post_init__(self) -> None:
        """Take the numbers exactly."""
        self._keep("gravity", read_point(self.gravity, "gravity"))
        self._keep("cables", tuple(self.cables))
        if not isinstance(self.platform, Platform):
            raise InputError(f"platform: must be a Platform, got {self.platform!r}")
        if not self.cables or not all(isinstance(cable, Cable) for cable in self.cables):
            raise InputError("cables: must be one Cable or more")
        if len(set(self.cable_names)) < len(self.cables):
            raise InputError(f"cables: names must differ, got {', '.join(self.cable_names)}")
        if len({cable.leg for cable in self.cables}) > 1:
            raise InputError("cables: either every cable is a leg or none is")

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], label: str = "robot") -> Robot:
        """Return the robot of a mapping with the keys of a robot file.

        Parameters
        ----------
        data : mapping
            As `to_dict` returns it, or as a YAML or JSON reader does. Numbers are exact: an int, `Decimal` or
            `Fraction` is itself, a text the decimal that is written (``"0.1"``), a float that very double, so
            0.1 is 0.1000000000000000055...: a reader that rounds decimals to doubles has done so before.
            Keys that begin with ``x_`` are free, and not kept.
        label : str
            What messages call it.

        Raises
        ------
        InputError
            With one line per error, ``robot: cables[1].frame_anchor_m: missing``, the rules those of files.

        Examples
        --------
        >>> robot = Robot.from_dict({
        ...     "format": "cdpr-robot/1", "name": "lamp", "platform": {"mass_kg": "2.5"},
        ...     "cables": [{"name": "c1", "frame_anchor_m": [0, 0, 3], "platform_anchor_m": [0, 0, 0]}],
        ... })
        >>> robot.platform.mass
        Fraction(5, 2)
        """
        robot: Robot = import_module(READER).robot_of(data, label)
        return robot

    def to_dict(self) -> dict[str, Any]:
        """Return the robot as a mapping with the keys of a robot file; `from_dict` returns it exactly.

        Numbers are ints and `Decimal` objects, and a `Fraction` where no finite decimal is the number.
        """
        winches = self.winches.to_dict()
        return {
            "format": FORMAT,
            "name": self.name,
            **({"source": self.source} if self.source is not None else {}),
            **({"notes": self.notes} if self.notes is not None else {}),
            "gravity_m_s2": list(map(plain_scalar, self.gravity)),
            "platform": self.platform.to_dict(),
            **({"winches": winches} if winches else {}),
            "cables": [cable.to_dict() for cable in self.cables],
        }

    def to_yaml(self) -> str:
        """Return the text of a robot file that is this robot, every number exactly.

        Of a robot that was read from a file and not changed it is that file, comments and all.

        Raises
        ------
        InputError
            Some number is no finite decimal (1/3), or has more than 1000 digits: no file can hold it.
        """
        if self.file is not None:
            return self.file.decode("utf-8")
        number = unreadable(self.to_dict())
        if number is not None:
            rule = f"{number} cannot be written: it is no decimal of at most {LONGEST_NUMBER} characters"
            raise InputError(f"robot '{self.name}': {rule}")
        return self._text

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write `to_yaml` to a file; the ``sha256`` of the robot is that of the file.

        Raises
        ------
        InputError
            As `to_yaml`, or the file cannot be written.
        """
        data = self.to_yaml().encode()
        try:
            Path(path).write_bytes(data)
        except OSError as error:
            raise InputError(f"{os.fspath(path)}: cannot be written: {error.strerror or error}") from None

    def read_from(self, data: bytes) -> Self:
        """Return the robot, marked as what a file says. For readers of files only."""
        self._keep("file", data)
        return self

    @cached_property
    def _text(self) -> str:
        return yaml_text(self.to_dict())

    @cached_property
    def sha256(self) -> str:
        """Hex digest of the file the robot was read from; else of the file that `to_yaml` would make of it.

        So no changed robot has the digest of a file that says something else.
        """
        return hashlib.sha256(self._text.encode() if self.file is None else self.file).hexdigest()

    @cached_property
    def cable_names(self) -> tuple[str, ...]:
        """Names in file order."""
        return tuple(cable.name for cable in self.cables)

    @cached_property
    def uncertain(self) -> tuple[Uncertain, ...]:
        """Every scalar that is a range, in the order gravity, platform, cables."""
        return tuple(
            Uncertain(path, value.lo, value.hi) for path, value in self._scalars() if isinstance(value, Range)
        )

    @property
    def is_exact(self) -> bool:
        """True when no scalar is a range."""
        return not self.uncertain

    def middle(self) -> Robot:
        """Return the robot with every range replaced by its middle; an exact robot is returned itself.

        It may be of another class: where ranges of anchors have the centre of mass in their middles, the
        middle robot is a point mass and this one is not.
        """
        return self._middle

    @cached_property
    def _middle(self) -> Robot:
        if self.is_exact:
            return self
        return dataclasses.replace(
            self,
            platform=self.platform.middle(),
            cables=tuple(cable.middle() for cable in self.cables),
            gravity=middle_point(self.gravity),
        )

    def _scalars(self) -> Iterator[tuple[str, Scalar]]:
        """Yield every scalar that may be a range, with its path in a file."""
        yield from entries("gravity_m_s2", self.gravity)
        yield "platform.mass_kg", self.platform.mass
        yield from entries("platform.centre_of_mass_m", self.platform.centre_of_mass)
        for i, cable in enumerate(self.cables):
            yield from entries(f"cables[{i}].frame_anchor_m", cable.frame_anchor)
            yield from entries(f"cables[{i}].platform_anchor_m", cable.platform_anchor)
            spring = cable.elasticity
            if spring is not None and spring.stiffness is not None:
                yield f"cables[{i}].elasticity.stiffness_N_per_m", spring.stiffness
            if spring is not None and spring.axial_stiffness is not None:
                yield f"cables[{i}].elasticity.axial_stiffness_N", spring.axial_stiffness
            if cable.pulley is not None:
                yield from cable.pulley.scalars(f"cables[{i}].pulley")

    @cached_property
    def is_point_mass(self) -> bool:
        """True when every platform anchor is the centre of mass, compared as decimals.

        A range is not known to equal anything, another range of the same bounds included: one in an anchor
        or in the centre of mass makes a platform.
        """
        centre = self.platform.centre_of_mass
        points = (centre, *(cable.platform_anchor for cable in self.cables))
        return not any(isinstance(x, Range) for point in points for x in point) and all(
            point == centre for point in points
        )

    @property
    def model(self) -> str:
        """The class of the robot, as results name it: ``point-mass`` or ``six-dof``."""
        return POINT_MASS if self.is_point_mass else SIX_DOF

    @cached_property
    def is_elastic(self) -> bool:
        """True when at least one cable stretches."""
        return any(cable.elasticity is not None for cable in self.cables)

    @cached_property
    def has_pulleys(self) -> bool:
        """True when at least one cable runs over a pulley."""
        return any(cable.pulley is not None for cable in self.cables)

    @property
    def has_legs(self) -> bool:
        """True for a Gough platform: its cables are legs, all of them."""
        return self.cables[0].leg

    @cached_property
    def is_mixed(self) -> bool:
        """True when some cables stretch and others do not."""
        return self.is_elastic and any(cable.elasticity is None for cable in self.cables)
