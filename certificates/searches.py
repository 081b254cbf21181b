"""The searches of one subset of taut cables, one in each of its frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from certificates.arithmetic.forms import Array
from certificates.frames import settings
from certificates.leaves import Cells, check_cells
from certificates.literals import list_of
from certificates.problem import Listed, Problem
from certificates.search import RoutedSearch, Search
from certificates.subsets import Kind
from certificates.tree import Leaf, Node


@dataclass(frozen=True)
class Tally:
    """How many cells there are, and of how many of them nothing is claimed."""

    leaves: int
    pending: int
    undecided: int


class SubsetSearches:
    """All searches of one subset."""

    def __init__(
        self, problem: Problem, taut: tuple[int, ...], kind: Kind, entry: Any, solutions: list[Listed]
    ) -> None:
        if problem.is_routed:
            (given,) = list_of(entry, "searches", 1)
            self.searches: list[Search] = [RoutedSearch(problem, taut, given, len(solutions))]
            return
        frames = settings(problem, taut, kind)
        given = list_of(entry, "searches", len(frames))
        self.searches = [Search(problem, s, e, len(solutions)) for s, e in zip(frames, given, strict=True)]

    def leaves(self) -> Iterator[tuple[int, Leaf]]:
        """Yield which search, and a leaf of it."""
        for place, search in enumerate(self.searches):
            yield from ((place, leaf) for leaf in search.leaves())

    def tally(self) -> Tally:
        """Read all trees and count their leaves."""
        leaves = pending = undecided = 0
        for _, leaf in self.leaves():
            leaves += 1
            pending += leaf.node is Node.PENDING
            undecided += leaf.node is Node.UNDECIDED
        return Tally(leaves, pending, undecided)

    def check(self, place: int, cells: Cells, twice: Array) -> int:
        """Check leaves of one kind of a search, some twice; return the number of parts it took."""
        return check_cells(self.searches[place], cells, twice)
