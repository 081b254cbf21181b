"""What a prepared point-mass solver answers: one light object, its parts made when they are asked for."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from solvers.answers.result import Bounds, CableState
from solvers.point_mass.entry import STATES
from solvers.point_mass.fields import OPEN, SLACK, TAUT


class PoseStatus(StrEnum):
    """What is proved for all lengths in their ranges."""

    PROVED = "proved"
    """There is exactly one static pose in all of space, and the bounds enclose it."""
    NO_POSE = "no-pose"
    """There is no static pose: no point is in reach of all cables, or only one, where nothing holds it."""
    UNPROVED = "unproved"
    """Neither of the two; ``reason`` says why."""


@dataclass(frozen=True, eq=False, slots=True)
class PointMassPose:
    """The static pose of a point mass, as `PointMass.solve` returns it.

    Bounds are float64 arrays whose last axis is (lo, hi).

    Guarantee
    ---------
    With status PROVED the robot has exactly one static pose for every choice of lengths in their ranges,
    wherever in space, and ``position``, ``height``, ``tensions`` and ``distances`` enclose it; the cables
    in ``taut`` are proved to carry tension, those that are SLACK to carry none within their lengths.
    With NO_POSE there is none for any choice. With UNPROVED nothing is claimed.
    """

    status: PoseStatus
    bounds: Bounds
    """(4 + 2 N, 2), in rows: position, height, tensions, distances. NaN with NO_POSE; with UNPROVED the
    position is where a pose would be, and nothing is known of the rest."""
    kernel_states: NDArray[np.int64]
    """(N,) states as the compiled kernels number them; ``states`` has their names."""
    reason: str = ""
    """Empty with PROVED; else one sentence: which cables cannot reach, or what is not decided."""
    note: str = ""
    """With PROVED, one sentence where a cable's state is undecided."""

    @property
    def proved(self) -> bool:
        """True when the pose exists, is the only one, and lies in the bounds."""
        return self.status is PoseStatus.PROVED

    @property
    def complete(self) -> bool:
        """True when nothing is open: there is no pose, or it is proved and so is every cable's state."""
        if self.status is PoseStatus.PROVED:
            return not (self.kernel_states == OPEN).any()
        return self.status is PoseStatus.NO_POSE

    @property
    def position(self) -> Bounds:
        """(3, 2) m: platform origin in the base frame."""
        return self.bounds[:3]

    @property
    def point(self) -> tuple[float, float, float]:
        """Middle of ``position`` in m; plain floats, not certified."""
        (xlo, xhi), (ylo, yhi), (zlo, zhi) = self.bounds[:3].tolist()
        return 0.5 * xlo + 0.5 * xhi, 0.5 * ylo + 0.5 * yhi, 0.5 * zlo + 0.5 * zhi

    @property
    def height(self) -> Bounds:
        """(2,) m: of the centre of mass, along up."""
        return self.bounds[3]

    @property
    def tensions(self) -> Bounds:
        """(N, 2) N, file order; [0, 0] for a slack cable."""
        return self.bounds[4 : 4 + len(self.kernel_states)]

    @property
    def distances(self) -> Bounds:
        """(N, 2) m: from the exit points to the platform."""
        return self.bounds[4 + len(self.kernel_states) :]

    @property
    def states(self) -> tuple[CableState, ...]:
        """What is proved about each cable, file order; UNDECIDED throughout unless the pose is PROVED."""
        return tuple([STATES[state] for state in self.kernel_states.tolist()])

    @property
    def taut(self) -> tuple[int, ...]:
        """Indices of the cables proved taut."""
        return tuple([i for i, state in enumerate(self.kernel_states.tolist()) if state == TAUT])

    @property
    def not_slack(self) -> tuple[int, ...]:
        """Indices of the cables that may be taut."""
        return tuple([i for i, state in enumerate(self.kernel_states.tolist()) if state != SLACK])
