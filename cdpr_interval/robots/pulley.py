"""A swivelling pulley over which a cable leaves: frozen data, SI units, every number exact.

The pulley hangs on an arm from a point A (the cable's ``frame_anchor``) of the line along which the cable
arrives. With one joint it turns about that line; with two, a universal joint at A, the arm also rises and
falls.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.exact.decimals import plain_scalar
from cdpr_interval.exact.range import as_range
from cdpr_interval.robots.numbers import (
    Part,
    Point,
    Scalar,
    entries,
    middle,
    middle_point,
    read_point,
    read_scalar,
)

EXACT = "exact"
BISECTOR = "bisector"
BALANCES = (EXACT, BISECTOR)
TWO_LEGS = "must be above 0 with two joints: the arm hangs between two legs of the rope"


@dataclass(frozen=True)
class Pulley(Part):
    """A pulley between winch and platform; see ``pulley`` in the file format.

    Raises
    ------
    InputError
        A negative radius, an arm shorter than the radius, an arm without a pulley, an axis of length zero, or
        two joints where the cable does not arrive from somewhere.
    """

    radius: Scalar
    """Of the rope's centre line, m; 0 only without an arm: a plain exit point."""
    arm: Scalar | None = None
    """From A to the pulley's centre, m, at least the radius; None: the radius."""
    joints: int = 1
    """1: turns about the axis; 2: universal joint at A."""
    axis: Point | None = None
    """Direction in which the rope arrives, of any length but zero; None: up."""
    lead_in: Scalar = Fraction(0)
    """m: the rope starts at C = A - lead_in axis."""
    balance: str = EXACT
    """Two joints: ``exact``, the arm along the resultant of both legs of the rope; ``bisector``, the pulley's
    centre on the bisector of the angle at A."""

    def __post_init__(self) -> None:
        """Take the numbers exactly."""
        self._keep("radius", read_scalar(self.radius, "radius"))
        if self.arm is not None:
            self._keep("arm", read_scalar(self.arm, "arm"))
        if self.axis is not None:
            self._keep("axis", read_point(self.axis, "axis"))
        self._keep("lead_in", read_scalar(self.lead_in, "lead_in"))
        for field, text in complaints(self, ("radius", "arm", "axis", "lead_in", "joints", "balance")):
            raise InputError(f"{field}: {text}")

    @property
    def arm_length(self) -> Scalar:
        """From A to the pulley's centre, m."""
        return self.radius if self.arm is None else self.arm

    @property
    def is_plain(self) -> bool:
        """True where the radius is zero: the cable leaves through A."""
        return as_range(self.radius).hi == 0

    def middle(self) -> Pulley:
        """Return it with every range replaced by its middle."""
        return self.replace(
            radius=middle(self.radius),
            arm=None if self.arm is None else middle(self.arm),
            axis=None if self.axis is None else middle_point(self.axis),
            lead_in=middle(self.lead_in),
        )

    def scalars(self, path: str) -> Iterator[tuple[str, Scalar]]:
        """Yield every number, each with its path in a file; the pulley is at ``path``."""
        yield f"{path}.radius_m", self.radius
        if self.arm is not None:
            yield f"{path}.arm_m", self.arm
        if self.axis is not None:
            yield from entries(f"{path}.axis", self.axis)
        yield f"{path}.lead_in_m", self.lead_in

    def to_dict(self) -> dict[str, Any]:
        """Return the block of a file."""
        block: dict[str, Any] = {"joints": self.joints, "radius_m": plain_scalar(self.radius)}
        if self.arm is not None:
            block["arm_m"] = plain_scalar(self.arm)
        if self.axis is not None:
            block["axis"] = list(map(plain_scalar, self.axis))
        if as_range(self.lead_in).hi:
            block["lead_in_m"] = plain_scalar(self.lead_in)
        if self.balance != EXACT:
            block["balance"] = self.balance
        return block


def complaints(pulley: Any, keys: tuple[str, ...]) -> list[tuple[str, str]]:
    """Return the rules that a pulley breaks, as pairs of a key of ``keys`` and a text.

    Parameters
    ----------
    pulley
        Anything with the fields of `Pulley`.
    keys
        What radius, arm, axis, lead-in, joints and balance are called, in that order.
    """
    radius_key, arm_key, axis_key, lead_in_key, joints_key, balance_key = keys
    found: list[tuple[str, str]] = []
    radius = as_range(pulley.radius)
    arm = radius if pulley.arm is None else as_range(pulley.arm)
    if radius.lo < 0:
        found.append((radius_key, f"must not be negative, got {_short(radius.lo)}"))
    elif arm.lo < 0:
        found.append((arm_key, f"must not be negative, got {_short(arm.lo)}"))
    elif radius.lo == 0 and (radius.hi > 0 or arm.hi > 0):
        found.append((radius_key, "must be above 0 where there is an arm or a range, got 0"))
    elif pulley.arm is not None and arm.lo < radius.hi:
        found.append((arm_key, f"must be at least the radius {_short(radius.hi)}, got {_short(arm.lo)}"))
    if pulley.axis is not None and all(as_range(x).lo <= 0 <= as_range(x).hi for x in pulley.axis):
        found.append((axis_key, "must not be the zero vector"))
    if as_range(pulley.lead_in).lo < 0:
        found.append((lead_in_key, f"must not be negative, got {_short(as_range(pulley.lead_in).lo)}"))
    if type(pulley.joints) is not int or pulley.joints not in (1, 2):
        found.append((joints_key, f"must be 1 or 2, got {pulley.joints!r}"))
    elif pulley.joints == 2 and radius.hi > 0 and as_range(pulley.lead_in).lo <= 0:
        found.append((lead_in_key, TWO_LEGS))
    if pulley.balance not in BALANCES:
        found.append((balance_key, f"must be one of {', '.join(BALANCES)}, got {pulley.balance!r}"))
    elif pulley.balance != EXACT and pulley.joints == 1:
        found.append((balance_key, "only with two joints: one joint leaves the arm no choice"))
    return found


def _short(x: Fraction) -> str:
    return f"{float(x):.12g}"
