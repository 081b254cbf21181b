"""Where the platform is, for lengths that winches measured: certified poses for whole ranges of lengths."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.orientation import Quaternion
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Robot
from solvers.answers.data import CableState, Solution, StopReason
from solvers.answers.fields import numbers
from solvers.classes import class_of
from solvers.forward import forward_kinematics
from solvers.questions.checked import on_legs, require_treated
from solvers.six_dof.scope import needs_real_cells
from solvers.six_dof.tracker import Tracker

MOST_PIECES = 20_000
"""Pieces into which the ranges of lengths are cut before a platform's pose counts as not enclosed."""
MOST_REAL_PIECES = 300
"""Likewise where cables run over pulleys or stretch: a proof takes milliseconds, one that fails some tens."""

Ranges = Sequence[tuple[float, float]]


@dataclass(frozen=True, eq=False)
class MeasuredPose:
    """One static pose for every choice of lengths in their ranges.

    Guarantee
    ---------
    For all lengths in the ranges there is a static pose in the box, with its tensions in their bounds. For a
    point mass it is the only one anywhere; for a platform the only one near the listed one.
    """

    taut: tuple[int, ...]
    position: Bounds
    """(3, 2) m: platform origin in the base frame."""
    rotation: Bounds
    """(3, 3, 2): platform to base."""
    tensions: Bounds
    """(N, 2) N."""
    states: tuple[CableState, ...]
    stability: Stability
    solution: Solution
    """The pose for lengths in the middle of their ranges."""

    @property
    def quaternion(self) -> Quaternion:
        """Return (w, x, y, z), not certified."""
        return self.solution.nominal.quaternion_wxyz

    @property
    def point(self) -> tuple[float, float, float]:
        """Middle of ``position``, not certified."""
        x, y, z = self.position.mean(axis=-1).tolist()
        return x, y, z

    @property
    def tight(self) -> tuple[int, ...]:
        """Cables that are not proved slack: taut, or taut for some choices of the lengths."""
        return tuple(i for i, state in enumerate(self.states) if state is not CableState.SLACK)

    @property
    def is_decided(self) -> bool:
        """True when every cable is proved taut or slack."""
        return self.tight == self.taut

    def to_json(self, names: Sequence[str]) -> dict[str, Any]:
        """Return plain data; the keys are those of ``cdpr-result/1``."""
        return {
            "taut": [names[i] for i in self.taut],
            "cable_states": [state.value for state in self.states],
            "position_m": self.position.tolist(),
            "rotation": self.rotation.tolist(),
            "tensions_N": numbers(self.tensions),
            "stability": self.stability.value,
            "nominal": {"position_m": list(self.point), "quaternion_wxyz": list(self.quaternion)},
        }


@dataclass(frozen=True)
class Whereabouts:
    """What measured lengths say."""

    poses: tuple[MeasuredPose, ...]
    message: str
    """One sentence; says what could not be proved."""
    is_complete: bool
    """True when every stable pose is enclosed."""
    lost: tuple[Solution, ...] = ()
    """Stable poses for the middles of the ranges, proved for those lengths, not enclosed for the others."""
    is_interrupted: bool = False
    """Ctrl-C has ended the search: there may be more."""


def whereabouts(robot: Robot, ranges: Ranges, threads: int = 1) -> Whereabouts:
    """Return the certified poses for measured lengths.

    Parameters
    ----------
    robot : Robot
    ranges : sequence of (lo, hi)
        m, file order.
    threads : int
        For the search of a platform's poses.
    """
    require_treated(robot, on_legs(robot, "winch where"))
    if class_of(robot).solves_ranges:
        result = forward_kinematics(robot, list(ranges), threads=threads)
        is_interrupted = result.stop_reason is StopReason.INTERRUPTED
        poses = tuple(measured(solution, solution) for solution in result.solutions)
        is_complete = bool(poses) and not (result.undecided or is_interrupted)
        return Whereabouts(poses, result.message, is_complete, is_interrupted=is_interrupted)
    middles = [0.5 * lo + 0.5 * hi for lo, hi in ranges]
    result = forward_kinematics(robot, middles, threads=threads)
    stable = [one for one in result.solutions if one.stability is Stability.STABLE]
    found = [enclosed(robot, one, ranges) for one in stable]
    poses = tuple(pose for pose in found if pose is not None)
    lost = tuple(one for one, pose in zip(stable, found, strict=True) if pose is None)
    count = f"{len(poses)} stable pose" + ("s" if len(poses) != 1 else "")
    message = f"{count} enclosed for all lengths in their ranges"
    if lost:
        message += f"; {len(lost)} at their middles could not be followed over the ranges"
    is_interrupted = result.stop_reason is StopReason.INTERRUPTED
    if is_interrupted:
        message += "; interrupted, there may be more"
    is_complete = bool(poses) and not (lost or result.undecided or is_interrupted)
    return Whereabouts(poses, message, is_complete, lost, is_interrupted)


def measured(solution: Solution, bounds: Any) -> MeasuredPose:
    """Return a pose with the bounds of a solution or of a tracked pose."""
    taut = tuple(i for i, state in enumerate(solution.cable_states) if state is CableState.TAUT)
    return MeasuredPose(
        taut,
        np.array(bounds.position),
        np.array(bounds.rotation),
        np.array(bounds.tensions),
        solution.cable_states,
        bounds.stability,
        solution,
    )


class Follower:
    """A platform's pose, followed over ranges of lengths piece by piece.

    Each piece is proved on its own (`Tracker`): one static pose near that of the piece before.
    """

    def __init__(self, robot: Robot, start: Solution) -> None:
        self._start = start
        self._tracker = Tracker(robot, start)
        self._most = MOST_REAL_PIECES if needs_real_cells(robot) else MOST_PIECES

    def pose(self, ranges: Ranges) -> MeasuredPose | None:
        """Return the pose for all lengths in their ranges; None when it is lost somewhere."""
        pieces = [np.array(ranges, dtype=np.float64)]
        hull: MeasuredPose | None = None
        for _ in range(self._most):
            if not pieces:
                return hull
            piece = pieces.pop()
            pose = self._tracker.update(piece)
            if not pose.tracked:
                pieces += halves(piece)
            elif pose.states != self._start.cable_states:
                return None
            else:
                here = measured(self._start, pose)
                hull = here if hull is None else _hull(hull, here)
        return None


def enclosed(robot: Robot, start: Solution, ranges: Ranges) -> MeasuredPose | None:
    """Return a platform's pose for all lengths in their ranges; None when it is open or lost somewhere."""
    if start.family is not None or not (start.is_strict and start.is_proved):
        return None
    return Follower(robot, start).pose(ranges)


def halves(piece: Bounds) -> list[Bounds]:
    """Return the two halves of a piece, (N, 2), across its widest range."""
    widest = int(np.argmax(piece[:, 1] - piece[:, 0]))
    middle = 0.5 * piece[widest, 0] + 0.5 * piece[widest, 1]
    lower, upper = piece.copy(), piece.copy()
    lower[widest, 1] = upper[widest, 0] = middle
    return [upper, lower]


def _hull(one: MeasuredPose, other: MeasuredPose) -> MeasuredPose:
    def around(a: Bounds, b: Bounds) -> Bounds:
        return np.stack([np.minimum(a[..., 0], b[..., 0]), np.maximum(a[..., 1], b[..., 1])], axis=-1)

    return MeasuredPose(
        one.taut,
        around(one.position, other.position),
        around(one.rotation, other.rotation),
        around(one.tensions, other.tensions),
        one.states,
        one.stability if one.stability is other.stability else Stability.UNDECIDED,
        one.solution,
    )
