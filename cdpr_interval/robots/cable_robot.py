"""A cable robot: frozen data in SI units, every number the exact rational of its source text."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property

from cdpr_interval.exact.vector import Vector
from cdpr_interval.robots.winch import Winch, WinchGroupSettings

POINT_MASS = "point-mass"
SIX_DOF = "six-dof"


@dataclass(frozen=True)
class Elasticity:
    """How a cable stretches: exactly one of the two is given."""

    stiffness: Fraction | None = None
    """Spring constant k in N/m."""
    axial_stiffness: Fraction | None = None
    """EA in N; k = EA / (unstretched length)."""


@dataclass(frozen=True)
class Cable:
    """One cable: exit point A_i in the base frame, platform point B_i in the platform frame, in m."""

    name: str
    frame_anchor: Vector
    platform_anchor: Vector
    elasticity: Elasticity | None = None
    tension_limits: tuple[Fraction, Fraction] | None = None
    """In N; reported against, never a filter."""
    winch: Winch | None = None
    """What moves the cable; its tolerances are no uncertain scalars of the robot."""


@dataclass(frozen=True)
class Platform:
    """The load: mass in kg and centre of mass in the platform frame in m."""

    mass: Fraction
    centre_of_mass: Vector = (Fraction(0), Fraction(0), Fraction(0))


@dataclass(frozen=True)
class Uncertain:
    """A scalar given as a range: its path in the file (``cables[1].frame_anchor_m[0]``) and bounds."""

    path: str
    lo: Fraction
    hi: Fraction


@dataclass(frozen=True)
class Robot:
    """A cable-driven parallel robot as read from a ``cdpr-robot/1`` file.

    A scalar given as a range enters as its midpoint and is listed in ``uncertain``;
    a solver that cannot treat ranges must refuse a robot whose ``uncertain`` is not empty.
    What follows from the data is computed once a robot: the data never change.
    """

    name: str
    platform: Platform
    cables: tuple[Cable, ...]
    gravity: Vector = (Fraction(0), Fraction(0), Fraction(-981, 100))
    source: str | None = None
    sha256: str = ""
    """Hex digest of the file's bytes."""
    uncertain: tuple[Uncertain, ...] = field(default=())
    winches: WinchGroupSettings = field(default_factory=WinchGroupSettings)

    @cached_property
    def cable_names(self) -> tuple[str, ...]:
        """Names in file order."""
        return tuple(cable.name for cable in self.cables)

    @cached_property
    def is_point_mass(self) -> bool:
        """True when every platform anchor is the centre of mass, compared as decimals."""
        centre = self.platform.centre_of_mass
        return all(cable.platform_anchor == centre for cable in self.cables)

    @property
    def model(self) -> str:
        """The class of the robot, as results name it: ``point-mass`` or ``six-dof``."""
        return POINT_MASS if self.is_point_mass else SIX_DOF

    @cached_property
    def is_elastic(self) -> bool:
        """True when at least one cable stretches."""
        return any(cable.elasticity is not None for cable in self.cables)

    @cached_property
    def is_mixed(self) -> bool:
        """True when some cables stretch and others do not."""
        return self.is_elastic and any(cable.elasticity is None for cable in self.cables)
