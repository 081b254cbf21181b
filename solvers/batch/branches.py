"""Branches: which poses of many jobs are one pose that has moved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.mechanics.orientation import rotation_from_rpy
from solvers.batch.tables import Row

Points = NDArray[np.float64]
Kind = tuple[str, str]
"""Taut cables and stability."""
RANK = {"stable": 0, "undecided": 1, "unstable": 2}


@dataclass
class Branch:
    """Poses of different jobs with the same taut cables and the same stability, near each other."""

    number: int
    """From 1, in the order in which they were met."""
    taut: str
    """Names with spaces."""
    stability: str
    first: Points
    """(N, 3) m: the platform's anchors in the pose that the others are near to."""
    solutions: int = 0
    jobs: int = 0
    numbers: dict[str, list[float]] = field(default_factory=dict)
    """By quantity."""

    @property
    def title(self) -> str:
        """What it is called."""
        return f"branch {self.number}: {self.stability}, taut {self.taut or '-'}"

    @property
    def order(self) -> tuple[int, int, int]:
        """Sorts stable ones first, then those with most poses."""
        return RANK[self.stability], -self.solutions, self.number


class Branches:
    """The branches of one problem for one robot.

    Parameters
    ----------
    anchors : (N, 3) array
        m: of the platform.
    is_followed : bool
        Whether the jobs are deviations from one question. Then the poses of the first job begin a branch
        each, and a job's poses go to the nearest branches of their kind, at most one to each: what is left
        begins a new one. Otherwise all poses of a kind are one branch.
    """

    def __init__(self, anchors: Points, is_followed: bool) -> None:
        self._anchors, self._is_followed = anchors, is_followed
        self._known: dict[Kind, list[Branch]] = {}
        self._count = 0

    def assign(self, rows: Sequence[Row]) -> list[Branch]:
        """Return the branch of each pose of one job, and count it there."""
        kinds: dict[Kind, list[int]] = {}
        for place, row in enumerate(rows):
            kinds.setdefault((row["taut"], row["stability"]), []).append(place)
        found: dict[int, Branch] = {}
        for kind, places in kinds.items():
            found |= self._of_kind(kind, places, rows)
        for branch in {branch.number: branch for branch in found.values()}.values():
            branch.jobs += 1
        for branch in found.values():
            branch.solutions += 1
        return [found[place] for place in range(len(rows))]

    def sorted(self) -> list[Branch]:
        """Return all, stable ones first."""
        return sorted((one for some in self._known.values() for one in some), key=lambda one: one.order)

    def _of_kind(self, kind: Kind, places: Sequence[int], rows: Sequence[Row]) -> dict[int, Branch]:
        known = self._known.setdefault(kind, [])
        if known and not self._is_followed:
            return dict.fromkeys(places, known[0])
        found: dict[int, Branch] = {}
        if len(known) == len(places) == 1:
            found[places[0]] = known[0]
        elif known:
            first = np.array([branch.first for branch in known])
            pairs = sorted(
                (distance, place, k)
                for place in places
                for k, distance in enumerate(_distances(self._places(rows[place]), first))
            )
            taken: set[int] = set()
            for _, place, k in pairs:
                if place not in found and k not in taken:
                    found[place] = known[k]
                    taken.add(k)
        for place in places:
            if place not in found:
                found[place] = self._begun(kind, rows[place])
                if not self._is_followed:
                    return dict.fromkeys(places, found[place])
        return found

    def _begun(self, kind: Kind, row: Row) -> Branch:
        self._count += 1
        branch = Branch(self._count, *kind, self._places(row))
        self._known[kind].append(branch)
        return branch

    def _places(self, row: dict[str, Any]) -> Points:
        """Return the platform's anchors in a pose, (N, 3) m."""
        position = np.array([row["x_m"], row["y_m"], row["z_m"]])
        turn = rotation_from_rpy(np.radians([row["roll_deg"], row["pitch_deg"], row["yaw_deg"]]).tolist())
        return position + self._anchors @ turn.T


def _distances(one: Points, others: Points) -> list[float]:
    """Return how far anchors (N, 3) are from each of others (n, N, 3): the root of the mean square, in m."""
    found: list[float] = np.sqrt(np.mean(np.sum((others - one) ** 2, axis=2), axis=1)).tolist()
    return found
