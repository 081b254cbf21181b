"""All data of a point mass within their ranges, as one box: lengths, exit points, springs and load.

A row of ``bounds`` is one number in the kernels' units, (lo, hi) in doubles that enclose its range: N
lengths, 3 N coordinates of exit points, N springs (k or EA; zero where a cable does not stretch), 3
components of what the scaled middle load leaves, and the scale of the middle load (see
`cdpr_interval.mechanics.spread`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact.enclosure import Bounds, enclose
from cdpr_interval.exact.range import Range

FIXED = 2.0**-40
"""Ranges of a smaller share of the largest length of the box count as single numbers: they are never cut."""


@dataclass(frozen=True, eq=False)
class Choices:
    """A box of choices of all data."""

    arrays: Any
    """The kernels' arrays (`RobotArrays`) of the middle robot under the middle load."""
    bounds: Bounds
    """(5 N + 4, 2)."""

    @property
    def count(self) -> int:
        """The number N of cables."""
        return len(self.arrays.elastic)

    @property
    def wide(self) -> NDArray[np.bool_]:
        """(5 N + 4,) which numbers are ranges."""
        size = np.abs(self.bounds).max(axis=1)
        return np.asarray(self.bounds[:, 1] - self.bounds[:, 0] > FIXED * np.maximum(size, 1.0))

    @property
    def lengths(self) -> Bounds:
        """(N, 2) m."""
        return np.asarray(self.bounds[: self.count] * self.arrays.frame[0, 0])

    def kernel_arrays(self) -> Any:
        """Return the arrays that enclose the data of every choice."""
        n = self.count
        scale = Range(*map(Fraction, self.bounds[5 * n + 3].tolist()))
        load = []
        for middle, rest in zip(
            self.arrays.load.tolist(), self.bounds[5 * n : 5 * n + 3].tolist(), strict=True
        ):
            total = Range(*map(Fraction, middle)) * scale + Range(*map(Fraction, rest))
            load.append((enclose(total.lo)[0], enclose(total.hi)[1]))
        return replace(
            self.arrays,
            exit_bounds=np.ascontiguousarray(self.bounds[n : 4 * n].reshape(n, 3, 2)),
            given=np.ascontiguousarray(self.bounds[4 * n : 5 * n]),
            load=np.array(load),
        )

    def halves(self, number: int) -> tuple[Choices, Choices]:
        """Return the two halves of the box, cut in one number."""
        lo, hi = self.bounds[number].tolist()
        return self.within(number, lo, 0.5 * (lo + hi)), self.within(number, 0.5 * (lo + hi), hi)

    def within(self, number: int, lo: float, hi: float) -> Choices:
        """Return the part of the box with one number in a part of its range."""
        bounds = self.bounds.copy()
        bounds[number] = lo, hi
        return Choices(self.arrays, bounds)


def around_middles(choices: Choices) -> tuple[Any, Bounds]:
    """Return a robot of exact exit points, and lengths (N, 2) in m with which it reaches what a choice does.

    |p - A| <= l for some A of its range: |p - A_mid| <= l + |A - A_mid|, taken in the 1-norm.
    """
    n = choices.count
    exits = choices.bounds[n : 4 * n].reshape(n, 3, 2)
    middle = exits.mean(axis=2)
    # Doubled roundings of a few subtractions are far below this share.
    away = np.abs(exits - middle[:, :, None]).max(axis=2).sum(axis=1) * (1.0 + 1e-12)
    lengths = choices.bounds[:n].copy()
    lengths[:, 1] = (lengths[:, 1] + away) * (1.0 + 1e-15)
    bounds = choices.bounds.copy()
    bounds[n : 4 * n] = np.repeat(middle.reshape(-1, 1), 2, axis=1)
    arrays = Choices(choices.arrays, bounds).kernel_arrays()
    return arrays, np.asarray(lengths * choices.arrays.frame[0, 0])
