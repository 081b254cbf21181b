"""What a run keeps of its searches, for a certificate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from cdpr_interval.engine.budget import Budget, Stop

if TYPE_CHECKING:
    from solvers.six_dof.cells.noted import NotedTurns
    from solvers.six_dof.cells.roots import Root
    from solvers.six_dof.cells.subset_search import SubsetSearch
    from solvers.six_dof.reduction import Reduced


@dataclass(frozen=True, eq=False)
class Searched:
    """One search of a run: what it was, what it found, and what became of its cells in u."""

    reduced: Reduced
    roots: tuple[Root, ...]
    notes: NotedTurns


@dataclass
class Record:
    """The searches of a run, by taut subset, in the order of the subset's frames."""

    searches: dict[tuple[int, ...], list[Searched]] = field(default_factory=dict)
    roots: dict[tuple[int, ...], list[Root]] = field(default_factory=dict)
    """Of cables over pulleys: the roots found with each taut subset, ascending."""
    budget: Budget = field(default_factory=Budget)
    """What the run may spend: the certificate has what is left of it."""

    def observer(self) -> NotedTurns:
        """Return the observer of a search."""
        # Its kernels are loaded when a certificate is asked for, never before.
        from solvers.six_dof.cells.noted import NotedTurns

        return NotedTurns()

    def keep(self, taut: tuple[int, ...], reduced: Reduced, subset: SubsetSearch, notes: NotedTurns) -> None:
        """Remember a search that has ended."""
        self.searches.setdefault(taut, []).append(Searched(reduced, tuple(subset.roots), notes))

    def keep_roots(self, taut: tuple[int, ...], roots: Sequence[Root]) -> None:
        """Remember the roots of a taut subset of cables over pulleys."""
        self.roots[tuple(sorted(taut))] = list(roots)

    @property
    def is_interrupted(self) -> bool:
        """Whether the run, or the writing of its certificate, was interrupted."""
        return self.budget.stop() is Stop.INTERRUPTED
