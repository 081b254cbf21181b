"""What is proved of a pose while lengths go straight from one row to another: parts of that way."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from cdpr_interval.engine.budget import Budget
from cdpr_interval.exact.enclosure import Bounds

ROUNDED = 4e-16
"""Covers the rounding of a few operations, relative."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """A part of a straight way of the lengths, with exactly one continued pose for every choice."""

    first: float
    """Share of the way where it begins, 0 to 1,"""
    last: float
    """and where it ends."""
    taut: tuple[int, ...]
    """Cables proved taut all along."""
    switching: tuple[int, ...]
    """Cables that are taut for some times and choices, and slack for others; all the rest are slack."""
    position: Bounds
    """(3, 2) m: of the platform origin, for all times and choices."""
    rotation: Bounds
    """(3, 3, 2)."""
    tensions: Bounds
    """(N, 2) N."""

    def joined(self, other: Stretch) -> Stretch:
        """Return both as one, from the beginning of the earlier one to the end of the other."""
        taut = tuple(i for i in self.taut if i in other.taut)
        tight = {*self.taut, *self.switching, *other.taut, *other.switching}
        return replace(
            self,
            first=min(self.first, other.first),
            last=max(self.last, other.last),
            taut=taut,
            switching=tuple(sorted(tight.difference(taut))),
            position=hull(self.position, other.position),
            rotation=hull(self.rotation, other.rotation),
            tensions=hull(self.tensions, other.tensions),
        )

    def is_like(self, other: Stretch) -> bool:
        """Return True when the same cables are taut, and the same switch."""
        return self.taut == other.taut and self.switching == other.switching

    def is_apart(self, other: Stretch) -> bool:
        """Return True when no pose lies in the boxes of both."""
        return any(
            bool(((a[..., 1] < b[..., 0]) | (b[..., 1] < a[..., 0])).any())
            for a, b in ((self.position, other.position), (self.rotation, other.rotation))
        )


class Moved(NamedTuple):
    """What came of a way."""

    share: float
    """Of the way that the pose has gone, 0 to 1: all before is proved."""
    stretches: tuple[Stretch, ...]
    """One after the other, from share 0 to ``share``."""
    reason: str
    """Why it goes no further, one sentence; empty at the end of the way."""


class Mover(Protocol):
    """One static pose that goes along with its lengths."""

    finest: float
    """Least share of a way that it tries on its own."""

    @property
    def here(self) -> Stretch:
        """Where it is now, for the last lengths."""

    def mark(self) -> object:
        """Return what `back_to` takes; None where a shorter way would not help."""

    def back_to(self, place: Any) -> None:
        """Be again where and how the pose was at a mark."""

    def go(self, lengths: Bounds, budget: Budget | None = None) -> Moved:
        """Follow the pose while the lengths go straight from the last ones to these (N, 2), m.

        A way of many proofs ends when the ``budget`` does.

        Guarantee
        ---------
        As far as that is proved, the pose has gone. For every choice of the lengths before and of those after
        it has moved continuously, at any share of the way within the stretch of that share.
        """


def hull(one: Bounds, other: Bounds) -> Bounds:
    """Return bounds that hold both."""
    return np.stack([np.minimum(one[..., 0], other[..., 0]), np.maximum(one[..., 1], other[..., 1])], axis=-1)


def lengths_on(before: Bounds, after: Bounds, first: float, last: float) -> Bounds:
    """Return bounds (N, 2) of the lengths on a part of the way from ``before`` to ``after``."""
    one, other = (before + share * (after - before) for share in (first, last))
    slack = 4.0 * ROUNDED * (before[:, 1] + after[:, 1])
    lo = np.minimum(one[:, 0], other[:, 0]) - slack
    hi = np.maximum(one[:, 1], other[:, 1]) + slack
    return np.stack([lo, hi], axis=-1)
