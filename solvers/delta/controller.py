"""Poses and drives of a Delta in one call each, for controllers: no documents, bounds only."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from flint import arb

from cdpr_interval.errors import InputError
from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.delta import Vector, delta_of, drives_at, meeting, narrowed
from cdpr_interval.robots.delta import DeltaRobot
from solvers.delta.given import require_delta


class DeltaPoses(NamedTuple):
    """What one call says about the poses."""

    lower: Bounds | None
    """(3, 2) m: tool point of the lower pose; None where there is none, or it is not known which is lower."""
    upper: Bounds | None
    """(3, 2) m."""
    proved: bool
    """These are all poses, or there is none."""


class DeltaAngles(NamedTuple):
    """What one call says about the drives at a pose."""

    useful: Bounds | None
    """(3, 2) rad or m; None where the pose is out of reach, or that is not known."""
    other: Bounds | None
    """(3, 2) rad or m."""
    proved: bool
    """These are all drives, or the pose is proved to be out of reach."""


class Delta:
    """A Delta for controllers; a call takes about a tenth of a millisecond.

    Parameters
    ----------
    robot : DeltaRobot, str or PathLike
        Itself, its file, or the name of a shipped one.

    Examples
    --------
    >>> delta = Delta("delta_580")
    >>> poses = delta.solve((0.1, 0.3, 0.5))
    >>> poses.proved, bool(poses.lower[2, 1] < poses.upper[2, 0])
    (True, True)
    """

    def __init__(self, robot: DeltaRobot | str | os.PathLike[str]) -> None:
        self.robot = require_delta(robot)
        with balls.precision():
            self._delta = delta_of(self.robot)

    def solve(self, drives: Sequence[float]) -> DeltaPoses:
        """Return both poses for angles in rad (or positions in m), each that very double.

        Guarantee: with ``proved`` there are no other poses, for every choice of data in their ranges.
        """
        with balls.precision():
            given = _balls(drives)
            centres = [self._delta.knee(i, drive) for i, drive in enumerate(given)]
            found = meeting(centres, self._delta.bar)
            if not (found.poses and found.is_ordered):
                return DeltaPoses(None, None, found.is_decided and not found.poses)
            lower, upper = (
                _bounds(
                    [
                        x + t
                        for x, t in zip(narrowed(centres, self._delta.bar, p), self._delta.tool, strict=True)
                    ]
                )
                for p in found.poses
            )
            return DeltaPoses(lower, upper, True)

    def drives(self, position: Sequence[float]) -> DeltaAngles:
        """Return the drives at a pose of the tool point in m, each coordinate that very double."""
        with balls.precision():
            centre = [x - t for x, t in zip(_balls(position), self._delta.tool, strict=True)]
            found = [drives_at(self._delta, i, centre) for i in range(3)]
            if any(drive.reach is not True for drive in found):
                return DeltaAngles(None, None, any(drive.reach is False for drive in found))
            useful = [drive.useful for drive in found if drive.useful is not None]
            other = [drive.other for drive in found if drive.other is not None]
            return DeltaAngles(_bounds(useful), _bounds(other), True)


def _balls(values: Sequence[float]) -> Vector:
    numbers = [float(value) for value in values]
    if len(numbers) != 3 or not all(map(np.isfinite, numbers)):
        raise InputError(f"must be 3 finite numbers, got {values!r}")
    return [arb(value) for value in numbers]


def _bounds(values: Vector) -> Bounds:
    return np.array([balls.to_bounds(x) for x in values])
