"""Where a tracker is: the pose tracked last as its kernels need it, made of a start."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.errors import InputError
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.orientation import rotation_from_quaternion
from cdpr_interval.mechanics.rotation import chart_of, quaternion_of
from cdpr_interval.mechanics.six_dof.system import improve
from cdpr_interval.text.count import counted
from solvers.answers.data import Solution
from solvers.six_dof.cells.roots import GENERAL, GEOMETRY, system_of
from solvers.six_dof.estimate import Body, Estimate, Guess
from solvers.six_dof.track import NEWTON_STEPS, fill_data
from solvers.six_dof.way import Known, Way, spread

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FULL_SYSTEM = 6
"""Taut cables from which on the lengths alone fix the pose."""
SLACK_AT_START = 1.0 + 1e-6
"""Least length of a slack cable at a start, over its distance there."""
NEXT = 0.125
"""How far a pose next to a start's numbers may be from them, in u and in sizes of the platform."""
ANOTHER = 1e-6
"""How far, in sizes of the platform, the distances at a start's pose may lie outside its own."""


@dataclass
class Place:
    """The pose tracked last."""

    chart: int
    z: Floats
    """(6 + n,) u, p and t, middles."""
    order: Ints
    """(N,) the taut cables, then the others."""
    taut: Ints
    rows: Floats
    """(m - n, 6) combinations of the statics equations in the square system."""
    free: Ints
    """(m,) its unknowns."""
    halvings: int = 0
    """The region proved last had the first radius halved so often."""
    densities: Floats | None = None
    """(n,) of a start; of six cables they are no unknowns."""
    way: Way | None = None
    """What continuation knows of the pose; None at a start."""

    def take(self, known: Known) -> None:
        """Take over a pose with other taut cables, perhaps."""
        self.taut = np.array(sorted(known.taut), dtype=np.int64)
        n = len(known.taut)
        others = [i for i in range(len(known.lengths)) if i not in known.taut]
        self.order = np.array([*self.taut, *others], dtype=np.int64)
        system = system_of(GEOMETRY if n == FULL_SYSTEM else GENERAL, n)
        self.rows, self.free = system.rows, system.free[0].copy()
        self.z = np.zeros(6 + n)
        self.z[:6] = known.z[:6]
        self.z[6 : 6 + self.known] = known.z[6 + self.taut[: self.known]]

    @property
    def known(self) -> int:
        """How many of t are unknowns of the square system: all but those of six cables."""
        n = len(self.taut)
        return n if n < FULL_SYSTEM else 0


def place_of(body: Body, start: Any) -> Place:
    """Return the place of a start.

    Raises
    ------
    InputError
        It is no pose, none of this robot, not single, or an estimate that has not converged.
    """
    if isinstance(start, Estimate):
        return _of_estimate(body, start)
    start = single(start, len(body.exits), "a Solution of forward_kinematics or an Estimate")
    rotation = start.rotation.mean(axis=-1)
    centre = np.array(start.nominal.position) + rotation @ body.offset
    _require_own(body, start, centre, rotation)
    taut = list(start.taut)
    densities = start.tensions[taut].mean(axis=-1) / start.distances[taut].mean(axis=-1)
    return _place(body, centre, start.nominal.quaternion_wxyz, start.taut, densities)


def known_at(body: Body, place: Place, cables: Floats, lengths: Bounds, load: Bounds) -> Known:
    """Return what is known at the place of a start, from where it goes on to ``lengths`` (N, 2).

    The taut cables have the start's own distances; slack ones are as long as they are to be, or longer where
    that would be too short. ``cables`` (N, 6, 2) and ``load`` (3, 2) are those of `Way.go`; the start may be
    of another load, and is improved where the pose of this one is next to it.
    """
    assert place.densities is not None
    taut = tuple(place.taut.tolist())
    rotation = rotation_from_quaternion(quaternion_of(place.chart, place.z))
    distances = body.distances(place.z[3:6], rotation)[:, None]
    own = np.maximum(lengths, SLACK_AT_START * distances)
    own[place.taut] = distances[place.taut]
    z = np.concatenate([place.z[:6], place.densities])
    data, system = np.empty((len(taut) + 1, 7, 2)), system_of(GENERAL, len(taut))
    fill_data(cables, load, own, place.taut, data)
    improved, count = z.copy(), len(system.free[0])
    if improve(data, system.rows, system.free[0].copy(), improved, np.empty((count, count)), NEWTON_STEPS):
        # Newton's method may go to quite another pose, which is not next to the start.
        moved = np.abs(improved - z)
        z = improved if moved[:3].max() <= NEXT and moved[3:6].max() <= NEXT * body.size else z
    z = spread(z, taut, len(lengths))
    return Known(taut, z, own, load, z, np.zeros(len(z)))


def single(start: Any, count: int, wanted: str) -> Solution:
    """Return a start that is one pose of a robot with so many cables.

    Raises
    ------
    InputError
        It is none; the message says what is wanted.
    """
    if not isinstance(start, Solution):
        hint = ": take one of its solutions" if hasattr(start, "solutions") else ""
        raise InputError(f"start: must be {wanted}, got {type(start).__name__}{hint}")
    if len(start.cable_states) != count:
        raise InputError(f"start: has {counted(len(start.cable_states), 'cable')}, the robot {count}")
    if not is_single(start):
        raise InputError("start: must be one pose, with every cable proved taut or slack")
    return start


def is_single(solution: Solution) -> bool:
    """Return True for one pose (no family) with every cable's state decided."""
    return solution.family is None and solution.is_proved and solution.is_strict


def guess_of(place: Place) -> Guess:
    """Return a place as a guess in plain floats."""
    taut = tuple(place.taut.tolist())
    rotation = rotation_from_quaternion(quaternion_of(place.chart, place.z))
    densities = place.z[6:].copy()
    return Guess(place.z[3:6].copy(), rotation, taut, densities)


def _of_estimate(body: Body, start: Estimate) -> Place:
    if len(start.tensions) != len(body.exits):
        raise InputError(f"start: has {counted(len(start.tensions), 'cable')}, the robot {len(body.exits)}")
    if not start.converged or any(start.tensions[i] <= 0.0 for i in start.taut):
        raise InputError("start: the estimate has not converged to a pose whose taut cables carry")
    centre = np.array(start.position) + start.rotation @ body.offset
    taut = list(start.taut)
    densities = start.tensions[taut] / body.distances(centre, start.rotation)[taut]
    return _place(body, centre, start.quaternion, start.taut, densities)


def _require_own(body: Body, start: Solution, centre: Floats, rotation: Floats) -> None:
    """Raise `InputError` where the robot's cables are not as long at a pose as the pose says."""
    found = body.distances(centre, rotation)
    margin = ANOTHER * body.size + start.distances[:, 1] - start.distances[:, 0]
    outside = (found < start.distances[:, 0] - margin) | (found > start.distances[:, 1] + margin)
    if outside.any():
        i = int(np.argmax(outside))
        raise InputError(
            f"start: is a pose of another robot: the distance of cable {body.names[i]} is"
            f" {start.distances[i].mean():.6g} m there, {found[i]:.6g} m here"
        )


def _place(body: Body, centre: Floats, quaternion: Any, taut: tuple[int, ...], densities: Floats) -> Place:
    n, count = len(taut), len(body.exits)
    system = system_of(GEOMETRY if n == FULL_SYSTEM else GENERAL, n)
    chart, u = chart_of(quaternion)
    z = np.zeros(6 + n)
    z[:3], z[3:6] = u, centre
    if n < FULL_SYSTEM:
        z[6:] = densities
    others = np.array([i for i in range(count) if i not in taut], dtype=np.int64)
    carrying = np.array(taut, dtype=np.int64)
    order = np.concatenate([carrying, others])
    return Place(chart, z, order, carrying, system.rows, system.free[0].copy(), densities=densities)
