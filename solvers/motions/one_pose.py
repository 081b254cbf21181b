"""The pose of a robot that has at most one for every choice of lengths: its place along a way.

Which pose goes on is no question here: for all lengths on a part of the way there is exactly one, anywhere.
It moves continuously, since poses are bounded and their limits are poses.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from cdpr_interval.engine.budget import Budget
from cdpr_interval.errors import CdprError
from cdpr_interval.exact.enclosure import Bounds
from solvers.answers.data import CableState
from solvers.motions.stretch import Moved, Stretch, lengths_on

FINEST = 2.0**-14
"""Shortest part of a way that is asked for: where a cable switches is known as well as that."""
SHARP = 64.0
"""Of ranges: shortest parts over the way on which the lengths go as far as their ranges are wide."""
COARSEST = 2.0**-4
OVER = "the budget is over"
IDENTITY = np.repeat(np.eye(3)[:, :, None], 2, axis=2)


class OnePoseMover:
    """See `solvers.motions.stretch.Mover`; ``follow`` proves the pose for ranges of lengths (N, 2), m.

    Raises
    ------
    CdprError
        There is no pose for the first lengths, or none is proved.
    """

    finest = FINEST
    _budget: Budget | None

    def __init__(self, follow: Callable[[Bounds], Any], lengths: Bounds) -> None:
        self._follow, self._lengths, self._budget = follow, lengths, None
        pose = follow(lengths)
        if not pose.proved:
            raise CdprError(pose.reason)
        self._here = _stretch(pose, 0.0, 0.0)

    @property
    def here(self) -> Stretch:
        """Where it is now, for the last lengths."""
        return self._here

    def mark(self) -> object:
        """Return None: a shorter way would not help."""
        return None

    def back_to(self, place: Any) -> None:
        """Do nothing: there are no marks."""

    def go(self, lengths: Bounds, budget: Budget | None = None) -> Moved:
        """Prove the pose while the lengths go straight to new ones (N, 2), m, as far as that is proved."""
        self._budget = budget
        stretches: list[Stretch] = []
        here, step, reason = 0.0, 1.0, ""
        finest = self._finest(lengths)
        while here < 1.0:
            there = min(here + step, 1.0)
            found, reason = self._part(lengths, here, there)
            if found is not None and not found.switching:
                stretches.append(found)
                here, step = there, 2.0 * step
                continue
            if step > finest:
                step *= 0.5
                continue
            found, reason = self._switch(lengths, here, finest)
            if found is not None:
                stretches.append(found)
                here = found.last
            if reason:
                break
        self._go_to(lengths_on(self._lengths, lengths, here, here) if here < 1.0 else lengths, stretches)
        return Moved(here, tuple(stretches), reason)

    def _finest(self, lengths: Bounds) -> float:
        """Return the shortest part of a way to ask for: where ranges are wide, cables switch for long."""
        wide = float((lengths[:, 1] - lengths[:, 0]).max())
        way = float(np.abs(lengths - self._lengths).max())
        return min(max(self.finest, wide / (SHARP * way) if way else 1.0), COARSEST)

    def _go_to(self, lengths: Bounds, stretches: Sequence[Stretch]) -> None:
        """Be at lengths for which there is a pose, at the end of the last of some stretches."""
        pose = self._follow(lengths)
        self._lengths = lengths
        if pose.proved:
            self._here = _stretch(pose, 1.0, 1.0)
        elif stretches:
            self._here = stretches[-1]

    def _part(self, lengths: Bounds, first: float, last: float) -> tuple[Stretch | None, str]:
        """Return the pose on a part of the way, and why there is none; that may take a second."""
        if self._budget is not None and self._budget.stop() is not None:
            return None, OVER
        pose = self._follow(lengths_on(self._lengths, lengths, first, last))
        return (_stretch(pose, first, last), "") if pose.proved else (None, pose.reason)

    def _switch(self, lengths: Bounds, here: float, finest: float) -> tuple[Stretch | None, str]:
        """Return the part of the way from a place on at which cables may be taut or slack.

        As far as there is a pose; and why there is none after it.
        """
        end = self._open_until(lengths, here, finest)
        whole: Stretch | None = None
        step = end - here
        while here < end:
            there = min(here + step, end)
            found, reason = self._part(lengths, here, there)
            if found is not None:
                whole = found if whole is None else whole.joined(found)
                here, step = there, 2.0 * step
            elif step > finest:
                step *= 0.5
            else:
                return whole, reason
        return whole, ""

    def _open_until(self, lengths: Bounds, here: float, finest: float) -> float:
        """Return a place after this one where every cable is taut or slack again, or the end of the way."""

        def is_decided(share: float) -> bool:
            found, _ = self._part(lengths, share, share)
            return found is not None and not found.switching

        step = finest
        while here + step < 1.0 and not is_decided(here + step):
            step *= 2.0
        low, high = here + 0.5 * step, min(here + step, 1.0)
        while high - low > finest:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if is_decided(middle) else (middle, high)
        return high


def _stretch(pose: Any, first: float, last: float) -> Stretch:
    """Return what a proved pose says of a part of a way."""
    states = list(enumerate(pose.states))
    taut = tuple(i for i, state in states if state is CableState.TAUT)
    switching = tuple(i for i, state in states if state not in (CableState.TAUT, CableState.SLACK))
    position, tensions = np.array(pose.position), np.array(pose.tensions)
    return Stretch(first, last, taut, switching, position, IDENTITY, tensions)
