"""What a result says more than once: its message, its subsets and its entries must agree about each other."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.text.count import counted
from solvers.answers.data import CableState, Proof, ResultData, Solution, SubsetReport
from solvers.answers.limits import breaking, doubtful
from solvers.answers.message import miscounted

ROUNDED = 4
"""Widest enclosure of one exact length, in units of its last place."""


def contradictions(result: ResultData) -> Iterator[str]:
    """Yield what in a result contradicts its own entries."""
    if wrong := miscounted(result.message, result.solutions, result.outcome):
        yield f"message: {wrong}"
    listed: set[tuple[int, ...]] = set()
    for number, subset in enumerate(result.subsets):
        if subset.taut in listed:
            yield f"subsets[{number}]: listed before"
        listed.add(subset.taut)
        yield from (f"subsets[{number}]: {text}" for text in _miscounted_subset(result, subset))
    yield from _listed_twice(result)


def _miscounted_subset(result: ResultData, subset: SubsetReport) -> Iterator[str]:
    """Check the number of poses of a subset against the entries it can be about."""
    chosen = set(subset.taut)
    own = [s for s in result.solutions if set(s.taut) <= chosen <= set(not_slack(s))]
    surely = sum(s.is_strict for s in own)
    # Entries outside the limits are counted, but not listed.
    all_listed = result.question.tension is None
    if subset.solutions < 0 or (all_listed and subset.solutions > 0 and not own):
        yield f"solutions: {subset.solutions}, but no entry with these cables taut"
    elif subset.solutions < surely:
        exactly = counted(surely, "entry", "entries")
        yield f"solutions: {subset.solutions}, but {exactly} with exactly these taut"
    elif all_listed and surely == len(own) < subset.solutions and not any(s.family for s in own):
        # Open entries may stand for several poses, and one family may be seen from several starts.
        yield f"solutions: {subset.solutions}, but only {counted(surely, 'entry', 'entries')} with these taut"


def not_slack(solution: Solution) -> tuple[int, ...]:
    """Return the cables that may be taut."""
    return tuple(i for i, state in enumerate(solution.cable_states) if state is not CableState.SLACK)


def _listed_twice(result: ResultData) -> Iterator[str]:
    """Yield pairs of entries one of which lies in the box of the other that holds one pose only."""
    if result.question.ignore_slack or result.question.ignore_tension_sign:
        # There each subset is a robot of its own.
        return
    single = [k for k, s in enumerate(result.solutions) if s.is_proved and s.family is None]
    for k, j in combinations(single, 2):
        one, other = result.solutions[k], result.solutions[j]
        if _inside(one, other) or _inside(other, one):
            yield f"solutions[{k}] and [{j}]: one lies in the other's box, which is said to hold one pose"


def _inside(inner: Solution, outer: Solution) -> bool:
    return _within(inner.position, outer.position) and _within(inner.rotation, outer.rotation)


def _within(inner: Bounds, outer: Bounds) -> bool:
    return bool(np.all(outer[..., 0] <= inner[..., 0]) and np.all(inner[..., 1] <= outer[..., 1]))


def claims(result: ResultData, solution: Solution) -> Iterator[str]:
    """Yield what contradicts the claims of one entry: existence, uniqueness, switching."""
    if not solution.is_proved and not solution.note:
        yield "existence, uniqueness: undecided without a reason in the note"
    if solution.tension_respected is False:
        yield "tension_respected: false, though the entry is listed"
    if (limits := result.question.tension) is not None:
        if solution.is_proved and (outside := breaking(solution, limits)):
            yield f"tensions_N[{outside[0]}]: outside the limits that were asked for"
        elif solution.tension_respected and (unclear := doubtful(solution, limits)):
            yield f"tensions_N[{unclear[0]}]: not proved to be within the limits that were asked for"
    for i, state in enumerate(solution.cable_states):
        if state is CableState.SWITCHING:
            if not solution.is_proved:
                yield f"cable_states[{i}]: 'switching' although exactly one pose is not proved"
            if solution.tensions[i, 0] > 0.0:
                yield f"tensions_N[{i}]: positive for all lengths although the cable is switching"
            if solution.distances[i, 1] < result.lengths[i, 0]:
                yield f"distances_m[{i}]: shorter than the cable for all lengths although it is switching"
        elif state is CableState.UNDECIDED and _needs_states(result, solution):
            # A root of a square system is a pose only where its tensions are not negative.
            yield f"existence, uniqueness: proved although cable_states[{i}] is undecided over ranges"


def _needs_states(result: ResultData, solution: Solution) -> bool:
    """Return whether exactly one pose can only be proved by deciding each cable's state.

    Convexity proves one pose of a point mass whatever is taut; nothing else does so over ranges.
    """
    widths = result.lengths[:, 1] - result.lengths[:, 0]
    ranges = bool((widths > ROUNDED * np.spacing(np.abs(result.lengths[:, 1]))).any())
    is_root = solution.proof is Proof.INTERVAL_NEWTON and result.model == "six-dof"
    return ranges and is_root and solution.is_proved
