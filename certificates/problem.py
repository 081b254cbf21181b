"""The question of a certificate and the solutions it lists."""

from __future__ import annotations

from dataclasses import dataclass

from flint import fmpq

Bounds = tuple[float, float]
Exact = list[fmpq]


@dataclass(frozen=True)
class Problem:
    """A robot, its lengths and the question: all numbers exact."""

    names: tuple[str, ...]
    exits: list[Exact]
    points: list[Exact]
    centre: Exact
    lengths: list[tuple[fmpq, fmpq]]
    stiffness: list[tuple[fmpq, bool] | None]
    mass: fmpq
    gravity: Exact
    load: Exact
    taut: tuple[int, ...] | None
    ignore_slack: bool
    ignore_tension_sign: bool

    @property
    def is_point_mass(self) -> bool:
        """True when every platform anchor is the centre of mass."""
        return not any(x != 0 for point in self.points for x in point)

    @property
    def is_elastic(self) -> bool:
        """True when some cable stretches."""
        return any(entry is not None for entry in self.stiffness)


@dataclass(frozen=True)
class Turning:
    """The family of a solution."""

    kind: str
    axis_point: list[Bounds] | None
    axis_direction: list[Bounds] | None
    angle_ranges: list[tuple[Bounds, Bounds]]


@dataclass(frozen=True)
class Listed:
    """A solution as the certificate lists it."""

    taut: tuple[int, ...]
    states: tuple[str, ...]
    position: list[Bounds]
    rotation: list[list[Bounds]]
    height: Bounds
    tensions: list[Bounds]
    distances: list[Bounds]
    slack_respected: bool | None
    stability: str
    family: Turning | None


def entry_of(entry, what, keys):
    from certificates.verdicts import Malformed

    if set(entry) != set(keys):
        raise Malformed(what)
    return entry


def index_of(v, n, what):
    return v


def list_of(v, what, n=None):
    return v


def bounds_of(v, what):
    return (float.fromhex(v[0]), float.fromhex(v[1]))
