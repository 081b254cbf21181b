"""What a run keeps of its searches, for a certificate."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from solvers.six_dof.reduction import Reduced
    from solvers.six_dof.roots import Root
    from solvers.six_dof.subset_search import SubsetSearch


@dataclass(frozen=True, eq=False)
class Searched:
    """One search of a run: what it was, and what it found."""

    reduced: Reduced
    roots: tuple[Root, ...]
    whole: bool
    """Nothing is pending."""


@dataclass
class Record:
    """The searches of a run, by taut subset, in the order of the subset's frames."""

    searches: dict[tuple[int, ...], list[Searched]] = field(default_factory=dict)

    def keep(self, taut: tuple[int, ...], reduced: Reduced, subset: SubsetSearch) -> None:
        """Remember a search that has ended."""
        found = Searched(reduced, tuple(subset.roots), subset.pending == 0)
        self.searches.setdefault(taut, []).append(found)
