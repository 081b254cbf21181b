"""Solutions of a point mass as results list them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.stability import Stability
from solvers.answers.data import CableState, Certainty, Nominal, Proof, Solution
from solvers.point_mass.arrays import Cables
from solvers.point_mass.fields import OPEN, SLACK, TAUT, report

IDENTITY: Bounds = np.repeat(np.eye(3)[:, :, None], 2, axis=2)
IDENTITY.setflags(write=False)

STATES = (CableState.SLACK, CableState.TAUT, CableState.UNDECIDED, CableState.SWITCHING)
"""By the kernels' state number."""


@dataclass(frozen=True, eq=False)
class Fields:
    """What a solution reports about one pose, in the units of the robot file."""

    position: Bounds
    height: Bounds
    tensions: Bounds
    distances: Bounds
    states: NDArray[np.int64]
    note: str = ""

    @property
    def taut(self) -> tuple[int, ...]:
        """Cables proved taut."""
        return tuple([i for i, state in enumerate(self.states.tolist()) if state == TAUT])

    @property
    def not_slack(self) -> tuple[int, ...]:
        """Cables that may be taut."""
        return tuple([i for i, state in enumerate(self.states.tolist()) if state != SLACK])

    @property
    def is_open(self) -> bool:
        """True when some cable's state is undecided."""
        return bool((self.states == OPEN).any())


def unpacked(bounds: Bounds, states: NDArray[np.int64]) -> Fields:
    """Return what `solvers.point_mass.one_call.balls_pose` has written as fields, without copying."""
    middle = 4 + len(states)
    return Fields(bounds[:3], bounds[3], bounds[4:middle], bounds[middle:], states)


def fields_of(
    cables: Cables, frame: Bounds, box: Bounds, tension: Bounds, states: NDArray[np.int64], note: str = ""
) -> Fields:
    """Turn enclosures in the kernels' units into reported fields."""
    count = len(states)
    fields = Fields(np.empty((3, 2)), np.empty(2), np.empty((count, 2)), np.empty((count, 2)), states, note)
    report(
        cables, frame, box, tension, states, fields.position, fields.height, fields.tensions, fields.distances
    )
    return fields


def hull(parts: list[Fields]) -> Fields:
    """Return the hull of several poses; a state holds if it does in all, else it is open."""
    first = parts[0]
    states = first.states.copy()
    for part in parts[1:]:
        states[states != part.states] = OPEN

    def join(arrays: list[Bounds]) -> Bounds:
        lows = np.min([a[..., 0] for a in arrays], axis=0)
        return np.stack([lows, np.max([a[..., 1] for a in arrays], axis=0)], axis=-1)

    return Fields(
        join([p.position for p in parts]),
        join([p.height for p in parts]),
        join([p.tensions for p in parts]),
        join([p.distances for p in parts]),
        states,
    )


def both(one: Fields, other: Fields) -> Fields:
    """Return what two enclosures of one pose say together; a state that one leaves open is the other's."""
    return Fields(
        meet(one.position, other.position),
        meet(one.height, other.height),
        meet(one.tensions, other.tensions),
        meet(one.distances, other.distances),
        np.where(one.states == OPEN, other.states, one.states),
    )


def meet(a: Bounds, b: Bounds) -> Bounds:
    """Return what two arrays of bounds have in common."""
    return np.stack([np.maximum(a[..., 0], b[..., 0]), np.minimum(a[..., 1], b[..., 1])], axis=-1)


def solution(fields: Fields, slack_respected: bool | None, proof: Proof = Proof.CONVEXITY) -> Solution:
    """Return the entry of a proved pose; every static pose of a point mass is a strict minimum.

    The equilibrium with tensions >= 0 of a set of cables minimises the energy of these cables under their
    length constraints. That problem is convex, and strictly so where a tension is positive.
    """
    states = fields.states.tolist()
    (xlo, xhi), (ylo, yhi), (zlo, zhi) = fields.position.tolist()
    return Solution(
        taut=tuple([i for i, state in enumerate(states) if state == TAUT]),
        cable_states=tuple([STATES[state] for state in states]),
        position=fields.position,
        rotation=IDENTITY,
        height=fields.height,
        tensions=fields.tensions,
        distances=fields.distances,
        slack_respected=slack_respected,
        existence=Certainty.PROVED,
        uniqueness=Certainty.PROVED,
        proof=proof,
        stability=Stability.STABLE,
        nominal=Nominal(
            (0.5 * xlo + 0.5 * xhi, 0.5 * ylo + 0.5 * yhi, 0.5 * zlo + 0.5 * zhi),
            (1.0, 0.0, 0.0, 0.0),
            (0.0, 0.0, 0.0),
        ),
        family=None,
        note=fields.note,
    )


def with_states(fields: Fields, states: NDArray[np.int64], note: str = "") -> Fields:
    """Return the same pose with other states of the cables."""
    return replace(fields, states=states, note=note or fields.note)
