"""A cable robot: frozen data in SI units, every number the exact rational of its source text.

A number that is given as a range stays one. What treats single numbers only takes each through `exact` or
`exact_point`, which refuse a range: none is ever replaced by its middle on the way to a solver.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property

from cdpr_interval.errors import NotSupportedError
from cdpr_interval.exact.range import Range
from cdpr_interval.exact.vector import Vector
from cdpr_interval.robots.winch import Winch, WinchGroupSettings

POINT_MASS = "point-mass"
SIX_DOF = "six-dof"

Scalar = Fraction | Range
"""A number, or the bounds between which it lies."""
Point = tuple[Scalar, Scalar, Scalar]


def exact(value: Scalar) -> Fraction:
    """Return a number that is known exactly.

    Raises
    ------
    NotSupportedError
        For a range.
    """
    if isinstance(value, Range):
        raise NotSupportedError(f"a range is not supported here yet: [{value.lo}, {value.hi}]")
    return value


def exact_point(point: Point) -> Vector:
    """Return a point of which every coordinate is known exactly; raises as `exact` does."""
    x, y, z = point
    return exact(x), exact(y), exact(z)


@dataclass(frozen=True)
class Elasticity:
    """How a cable stretches: exactly one of the two is given."""

    stiffness: Scalar | None = None
    """Spring constant k in N/m."""
    axial_stiffness: Scalar | None = None
    """EA in N; k = EA / (unstretched length)."""


@dataclass(frozen=True)
class Cable:
    """One cable: exit point A_i in the base frame, platform point B_i in the platform frame, in m."""

    name: str
    frame_anchor: Point
    platform_anchor: Point
    elasticity: Elasticity | None = None
    tension_limits: tuple[Fraction, Fraction] | None = None
    """In N; reported against, never a filter."""
    winch: Winch | None = None
    """What moves the cable; its tolerances are no uncertain scalars of the robot."""


@dataclass(frozen=True)
class Platform:
    """The load: mass in kg and centre of mass in the platform frame in m."""

    mass: Scalar
    centre_of_mass: Point = (Fraction(0), Fraction(0), Fraction(0))


@dataclass(frozen=True)
class Uncertain:
    """A scalar given as a range: its path in the file (``cables[1].frame_anchor_m[0]``) and bounds."""

    path: str
    lo: Fraction
    hi: Fraction


@dataclass(frozen=True)
class Robot:
    """A cable-driven parallel robot as read from a ``cdpr-robot/1`` file.

    A scalar given as a range is one here too; a solver that cannot treat ranges must refuse a robot whose
    ``uncertain`` is not empty.
    What follows from the data is computed once a robot: the data never change.
    """

    name: str
    platform: Platform
    cables: tuple[Cable, ...]
    gravity: Point = (Fraction(0), Fraction(0), Fraction(-981, 100))
    source: str | None = None
    sha256: str = ""
    """Hex digest of the file's bytes."""
    winches: WinchGroupSettings = field(default_factory=WinchGroupSettings)

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

    def _scalars(self) -> Iterator[tuple[str, Scalar]]:
        """Yield every scalar that may be a range, with its path in a file."""
        yield from _entries("gravity_m_s2", self.gravity)
        yield "platform.mass_kg", self.platform.mass
        yield from _entries("platform.centre_of_mass_m", self.platform.centre_of_mass)
        for i, cable in enumerate(self.cables):
            yield from _entries(f"cables[{i}].frame_anchor_m", cable.frame_anchor)
            yield from _entries(f"cables[{i}].platform_anchor_m", cable.platform_anchor)
            spring = cable.elasticity
            if spring is not None and spring.stiffness is not None:
                yield f"cables[{i}].elasticity.stiffness_N_per_m", spring.stiffness
            if spring is not None and spring.axial_stiffness is not None:
                yield f"cables[{i}].elasticity.axial_stiffness_N", spring.axial_stiffness

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
    def is_mixed(self) -> bool:
        """True when some cables stretch and others do not."""
        return self.is_elastic and any(cable.elasticity is None for cable in self.cables)


def _entries(path: str, point: Point) -> Iterator[tuple[str, Scalar]]:
    for i, value in enumerate(point):
        yield f"{path}[{i}]", value
