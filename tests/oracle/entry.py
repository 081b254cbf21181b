"""One entry of a ``cdpr-result/1`` document: which poses it holds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import mpmath
import numpy as np

from .family import FamilyFit, fit_family, members
from .model import Case
from .starts import rotation_of
from .statics import DIGITS, Pose, System, number, wrenches
from .subsets import StaticPose

SLOP = mpmath.mpf(10) ** -38
"""What 50 digits may be off, relative to the units of the problem."""

MEMBERS = 1000
"""So many members of a family are tried where a cable is open."""


@dataclass(frozen=True)
class Entry:
    """An entry and its place in the list."""

    number: int
    document: dict[str, Any]
    case: Case

    @property
    def states(self) -> list[str]:
        """States of the cables, file order."""
        return list(self.document["cable_states"])

    @property
    def proved(self) -> bool:
        """True where the entry claims that its pose exists."""
        return bool(self.document["existence"] == "proved")

    @property
    def family(self) -> Any:
        """The family's block, or None."""
        return self.document["family"]

    def subsets(self) -> Iterator[tuple[int, ...]]:
        """Yield the taut subsets that the states allow, those with fewer cables first."""
        certain = {i for i, s in enumerate(self.states) if s == "taut"}
        open_cables = [i for i, s in enumerate(self.states) if s in ("undecided", "switching")]
        for extra in range(len(open_cables) + 1):
            for chosen in combinations(open_cables, extra):
                subset = tuple(sorted(certain | set(chosen)))
                if 0 < len(subset) <= (6 if not self.case.point_mass or self.case.stiffness else 3):
                    yield subset

    def start(self, system: System, subset: tuple[int, ...]) -> Pose:
        """Return the nominal pose in the units of a system.

        The tensions are those that balance the load best there (what is listed may be the hull of
        many), of elastic cables the middle of their bounds, on which the lengths depend.
        """
        nominal = self.document["nominal"]
        rotation = rotation_of(np.array(nominal["quaternion_wxyz"])) if system.turns else np.eye(3)
        origin = np.array(nominal["position_m"]) / float(system.unit_m)
        tensions = [middle(self.document["tensions_N"][i]) / float(system.unit_N) for i in subset]
        pose = Pose(origin + rotation @ system.centre, rotation, np.array(tensions))
        if self.case.stiffness is not None:
            return pose
        columns = wrenches(system, pose, np.array(subset))
        load = np.concatenate([system.load, np.zeros(len(columns) - 3)])
        return Pose(pose.p, rotation, np.linalg.lstsq(columns, -load, rcond=None)[0])

    def starts(self, system: System, subset: tuple[int, ...]) -> Iterator[Pose]:
        """Yield the nominal pose and, where a family leaves cables open, the member with most slack."""
        first = self.start(system, subset)
        yield first
        if self.family is None or set(self.states) <= {"taut", "slack"}:
            return
        others = np.array([i for i in range(system.count) if i not in subset], dtype=int)
        unit = float(system.unit_m)

        def slack(pose: Pose) -> float:
            e = system.exits[others] - pose.p - system.arms[others] @ pose.rotation.T
            return float((system.lengths[others] - np.linalg.norm(e, axis=1)).min(initial=np.inf))

        turned = members(self.family, first.p * unit, first.rotation, MEMBERS)
        yield max((Pose(p / unit, rotation, first.tensions) for p, rotation in turned), key=slack)

    def fit(self, pose: StaticPose) -> FamilyFit | None:
        """Return how a pose lies in the entry's family; None where it does not."""
        # A box's middle is as good as its float bounds.
        rotation = np.array(self.document["rotation"]).mean(axis=-1)
        origin = np.array(self.document["position_m"]).mean(axis=-1)
        centre = np.array([float(c) for c in self.case.centre])
        width = float(np.ptp(self.document["rotation"], axis=-1).max())
        width = max(
            width, float(np.ptp(self.document["position_m"], axis=-1).max()) / float(max(pose.distances))
        )
        return fit_family(self.family, origin + rotation @ centre, rotation, width, pose)

    def misfit(self, pose: StaticPose) -> str | None:
        """Return why a pose is not one of this entry; None where it is, ``elsewhere`` for another place."""
        if self.family is not None:
            return self._family_misfit(pose)
        with mpmath.workdps(DIGITS + 10):
            length = SLOP * max(number(hi) for _, hi in self.case.lengths)
            if not inside(self.document["position_m"], pose.position, length):
                return "elsewhere"
            if not inside(self.document["rotation"], pose.rotation, SLOP):
                return "elsewhere"
            weight = SLOP * max(number(abs(x)) for x in self.case.load)
            if not inside(self.document["tensions_N"], pose.tensions, weight):
                return f"its tensions {floats(pose.tensions)} are outside {self.document['tensions_N']}"
            if not inside(self.document["distances_m"], pose.distances, length):
                return f"its distances {floats(pose.distances)} are outside {self.document['distances_m']}"
        return self._state_misfit(pose)

    def _state_misfit(self, pose: StaticPose) -> str | None:
        for i, state in enumerate(self.states):
            if state == "taut" and not pose.tensions[i] > 0:
                return f"c{i + 1} is listed taut, its tension is {float(pose.tensions[i]):.3g} N"
            if state == "slack" and (i in pose.taut or pose.margins[i] == 0):
                return f"c{i + 1} is listed slack and carries"
        claimed = self.document["slack_respected"]
        if claimed in (True, False) and claimed != pose.slack_respected and self.family is None:
            return f"slack_respected is {claimed}, the oracle finds {pose.slack_respected}"
        return None

    def _family_misfit(self, pose: StaticPose) -> str | None:
        fit = self.fit(pose)
        if fit is None or fit.place == "outside":
            return "elsewhere"
        scale = max(float(abs(x)) for x in self.case.load)
        for i, bounds in enumerate(self.document["tensions_N"]):
            lo, hi = (float("inf") if b is None else b for b in bounds)
            if not lo - 1e-6 * scale <= float(pose.tensions[i]) <= hi + 1e-6 * scale:
                return f"tension {float(pose.tensions[i]):.9g} N of c{i + 1} is outside {bounds}"
        return None if fit.place == "edge" or not pose.clear else self._state_misfit(pose)


def middle(bounds: list[float | None]) -> float:
    """Return the middle of bounds; their lower one where nothing bounds from above."""
    lo, hi = bounds
    return float(lo or 0.0) if hi is None else 0.5 * (float(lo or 0.0) + float(hi))


def floats(values: Any) -> list[float]:
    """Return mpmath numbers as floats."""
    return [float(x) for x in np.ravel(values)]


def inside(bounds: Any, values: Any, slop: Any) -> bool:
    """Return True where every value lies in its bounds (..., 2); null is no bound."""
    rows = np.array(bounds, dtype=object).reshape(-1, 2)
    pairs = zip(rows, np.ravel(values), strict=True)
    return all(
        (lo is None or x >= number(lo) - slop) and (hi is None or x <= number(hi) + slop)
        for (lo, hi), x in pairs
    )
