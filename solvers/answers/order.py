"""The order in which a result lists its entries, the same for any number of threads."""

from __future__ import annotations

from collections.abc import Iterable

from cdpr_interval.mechanics.stability import Stability
from solvers.answers.data import Solution, SubsetReport, Undecided

_RANK = {Stability.STABLE: 0, Stability.UNDECIDED: 1, Stability.UNSTABLE: 2}


def sort_solutions(solutions: Iterable[Solution]) -> tuple[Solution, ...]:
    """Return stable, undecided, unstable; then lowest first; then by taut cables; then by position."""
    return tuple(sorted(solutions, key=solution_key))


def solution_key(solution: Solution) -> tuple[int, list[float], tuple[int, ...], list[float], list[float]]:
    """Return the sort key of a solution; the rotation separates poses at the same place."""
    return (
        _RANK[solution.stability],
        solution.height.tolist(),
        solution.taut,
        solution.position.ravel().tolist(),
        solution.rotation.ravel().tolist(),
    )


def sort_undecided(undecided: Iterable[Undecided]) -> tuple[Undecided, ...]:
    """Return the undecided clusters by number of taut cables, taut cables, position and rotation."""
    return tuple(
        sorted(
            undecided,
            key=lambda u: (len(u.taut), u.taut, u.position.ravel().tolist(), u.rotation.ravel().tolist()),
        )
    )


def sort_subsets(subsets: Iterable[SubsetReport]) -> tuple[SubsetReport, ...]:
    """Return the subset reports by number of taut cables, then by their indices."""
    return tuple(sorted(subsets, key=lambda s: (len(s.taut), s.taut)))
