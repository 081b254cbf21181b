"""How far the writing of a certificate is, told to whoever shows it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from cdpr_interval.engine.budget import Budget
from cdpr_interval.engine.search import REPORT_SECONDS
from solvers.questions.problem import Progress


class Account:
    """Tells of subsets that are done, and of the steps of the one at hand.

    How many steps a subset takes is not known before: each stands for half of what is left of it.

    Parameters
    ----------
    tell : callable, optional
        As `Options.progress`.
    budget : Budget
        Of the run; its cells are those told.
    weights : sequence of int
        What each subset will take, as a guess.
    """

    def __init__(
        self, tell: Callable[[Progress], None] | None, budget: Budget, weights: Sequence[int]
    ) -> None:
        self._tell, self._budget, self._weights = tell, budget, weights
        self._told = time.monotonic()
        self._done, self._left = 0, 1.0

    def subset(self, done: int) -> None:
        """Begin the next subset, after so many."""
        self._done, self._left = done, 1.0
        self.step(0.0)

    def next_step(self) -> None:
        """Begin the next step of a subset."""
        self._left *= 0.5

    def step(self, share: float) -> None:
        """Tell what share of the step is done, unless something was told a moment ago."""
        now = time.monotonic()
        if self._tell is None or now - self._told < REPORT_SECONDS:
            return
        self._told = now
        left = self._left * (1.0 - 0.5 * min(share, 1.0))
        ahead = left * self._weights[self._done] + sum(self._weights[self._done + 1 :])
        place = self._done, len(self._weights), 1.0 - ahead / sum(self._weights)
        self._tell(Progress(self._budget.cells, 0, left, 0, *place))

    def searched(self, cells: int, pending: int, volume_left: float) -> None:
        """Tell how far a search is; see `cdpr_interval.engine.search.search`."""
        self.step(1.0 - volume_left)
