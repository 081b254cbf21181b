"""What the writing of a certificate may take: what is left of the run's budget, until it is interrupted."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager

from cdpr_interval.engine.budget import Budget, Stop
from certificates import clock

GRACE = 1.0
"""Seconds after the end of a run, by its time limit or an interrupt, in which the poses that it found are
still given their proofs: about ten of them. Trees are not recorded any more."""


class Allowance:
    """The budget of a run, as its certificate may use it.

    Parameters
    ----------
    budget
        Of the run; its cells and seconds go on to count.
    """

    def __init__(self, budget: Budget) -> None:
        self.budget = budget
        self._was_interrupted = budget.stop() is Stop.INTERRUPTED
        left = 0.0 if self._was_interrupted else budget.seconds_left()
        self._end = math.inf if left is None else time.monotonic() + max(left, 0.0) + GRACE

    @property
    def is_spent(self) -> bool:
        """Nothing more may be done."""
        return time.monotonic() >= self._end

    @contextmanager
    def spending(self) -> Iterator[None]:
        """Leave the block when time is up or an interrupt comes; what it has done by then stays.

        Elsewhere an interrupt throws nothing, see `Budget.listening`: it ends the next block.
        """
        if self.budget.stop() is Stop.INTERRUPTED and not self._was_interrupted:
            self._end = 0.0
        left = None if self._end == math.inf else self._end - time.monotonic()
        try:
            with clock.seconds(left), self.budget.raising():
                yield
        except clock.OutOfTime:
            pass
        except KeyboardInterrupt:
            self.budget.interrupt()
            self._end = 0.0
