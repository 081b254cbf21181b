"""Bookkeeping of taut subsets of a point mass: which there are, and what the result says about each."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from itertools import combinations
from math import comb

from solvers.answers.result import Outcome, SubsetReport

MOST_ROWS = 1024
"""Most subsets a result lists one by one; beyond that only those that carry an entry (ten elastic cables
have 1023 subsets, and a list of millions helps nobody)."""


def subsets(count: int, largest: int) -> Iterator[tuple[int, ...]]:
    """Yield all sets of 1 .. ``largest`` of ``count`` cables, small ones first."""
    for size in range(1, largest + 1):
        yield from combinations(range(count), size)


def subset_count(count: int, largest: int) -> int:
    """Return how many subsets `subsets` yields."""
    return sum(comb(count, size) for size in range(1, largest + 1))


@lru_cache(maxsize=64)
def rows(
    count: int,
    largest: int,
    surely: tuple[int, ...],
    possibly: tuple[int, ...],
    found: bool,
    decided: bool,
) -> tuple[SubsetReport, ...]:
    """Return one row per subset for a claim made at once for all of them.

    Parameters
    ----------
    count, largest
        Number of cables and the size of the largest subset.
    surely, possibly
        Cables proved taut, and those that may be (ascending; the second contains the first).
    found
        Whether there is a pose.
    decided
        Whether nothing is open; else subsets between ``surely`` and ``possibly`` are incomplete.
    """
    if subset_count(count, largest) <= MOST_ROWS:
        listed = list(subsets(count, largest))
    else:
        listed = [possibly] if possibly else []
    sure, candidates = set(surely), set(possibly)
    result = []
    given = False
    for taut in listed:
        concerned = bool(candidates) and sure <= set(taut) <= candidates
        has = concerned and found and not given
        given = given or has
        outcome = Outcome.INCOMPLETE if concerned and not decided else Outcome.COMPLETE
        result.append(SubsetReport(taut, outcome, int(has), 0, 0.0))
    return tuple(result)
