"""The static pose of a point mass by convexity: one compiled call, and what follows where that is not enough.

A robot here is any set of cables: all of them, or a subset that is looked at alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact.enclosure import Bounds
from solvers.point_mass.arrays import Cables, RobotArrays, is_range
from solvers.point_mass.entry import Fields, fields_of, hull, unpacked
from solvers.point_mass.fields import OPEN, SWITCHING
from solvers.point_mass.one_call import (
    DECIDED,
    NO_POSE,
    balls_pose,
    guess_elastic,
    guess_inextensible,
    middles,
    springs,
    springs_pose,
)
from solvers.point_mass.reach import reachable

PIECES = 64
"""Most parts a length range is cut into: the hull improves slowly after that."""
ELASTIC_PIECES = 16
"""The same for elastic cables, where a part that stays open costs tens of milliseconds."""
PARTLY = "for some lengths in the ranges the cables may have no common point"


@dataclass(frozen=True)
class NoPose:
    """Proved: the weighted balls have no common point, or only one, where nothing holds the load."""

    weights: Mapping[int, float | Fraction]
    touching: bool = False
    """The balls have one common point."""
    gap: float = 0.0
    """m, not certified: by how much the cables are too short, where that is next to nothing."""

    def reason(self, names: Sequence[str]) -> str:
        """Return the sentence that says so."""
        from solvers.point_mass.rationals.emptiness import apart_message, touching_message

        if self.touching:
            return touching_message(names, self.weights)
        return apart_message(names, self.weights) + (f", by some {self.gap:.1g} m" if self.gap else "")


@dataclass(frozen=True, eq=False)
class Unproved:
    """Neither a pose nor its absence is proved."""

    reason: str
    position: Bounds
    """(3, 2) m: where a pose would be."""


Finding = Fields | NoPose | Unproved
Exact = Sequence[Fraction] | None


def part_of(arrays: RobotArrays, chosen: Sequence[int]) -> RobotArrays:
    """Return the robot with some of its cables only; positions stay relative to the whole robot's A_0."""
    index = np.array(chosen, dtype=np.int64)
    cables = tuple(arrays.robot.cables[i] for i in chosen)
    return replace(
        arrays,
        robot=replace(arrays.robot, cables=cables),
        elastic=arrays.elastic[index],
        constant=arrays.constant[index],
        exit_bounds=arrays.exit_bounds[index],
        given=arrays.given[index],
    )


def scaled_cables(arrays: RobotArrays, lengths: Bounds) -> Cables:
    """Return the kernels' cables for lengths in m."""
    scaled = lengths / arrays.frame[0, 0]
    k, w = springs(arrays.elastic, arrays.constant, arrays.given, scaled)
    return arrays.elastic, arrays.exit_bounds, scaled, k, w


def quick_pose(arrays: RobotArrays, lengths: Bounds) -> tuple[int, Bounds, NDArray[np.int64]]:
    """Run the compiled path once.

    Returns
    -------
    status, bounds, states : int, (4 + 2 N, 2), (N,)
        As `solvers.point_mass.one_call.balls_pose`; meaningful when the status is ``DECIDED``.
    """
    count = len(lengths)
    bounds = np.empty((4 + 2 * count, 2))
    states: NDArray[np.int64] = np.empty(count, dtype=np.int64)
    a = arrays
    if a.is_elastic:
        status = springs_pose(a.constant, a.given, a.exit_bounds, lengths, a.load, a.frame, bounds, states)
    else:
        status = balls_pose(a.exit_bounds, lengths, a.load, a.frame, bounds, states)
    return status, bounds, states


def find_pose(arrays: RobotArrays, lengths: Bounds, exact: Exact = None) -> Finding:
    """Find the pose of a robot for all lengths (N, 2) in m, or prove that there is none.

    Parameters
    ----------
    arrays : RobotArrays
    lengths : (N, 2)
        m.
    exact : sequence of Fraction, optional
        The lengths in m, where they are no ranges: doubles may be too coarse to tell whether balls touch.

    Guarantee
    ---------
    Fields: for every choice of lengths in their ranges there is exactly one static pose, and the fields
    enclose it. NoPose: there is none for any choice.
    """
    status, bounds, states = quick_pose(arrays, lengths)
    if status == DECIDED:
        return unpacked(bounds, states)
    return after_quick(arrays, lengths, exact)


def after_quick(arrays: RobotArrays, lengths: Bounds, exact: Exact = None) -> Finding:
    """Find what `find_pose` finds, where `quick_pose` has decided nothing."""
    if is_range(lengths):
        return _over_ranges(arrays, lengths)
    return settle(arrays, lengths, exact)


def settle(arrays: RobotArrays, lengths: Bounds, exact: Exact = None) -> Finding:
    """Treat the cases the compiled path leaves open, without cutting ranges."""
    # Imported where it is needed: a process that asks one ordinary question starts sooner.
    from solvers.point_mass.degenerate import settle_balls
    from solvers.point_mass.elastic import settle_springs

    cables = scaled_cables(arrays, lengths)
    if arrays.is_elastic:
        enclosed = settle_springs(arrays, cables)
    else:
        if exact is None and (lengths[:, 0] == lengths[:, 1]).all():
            exact = [Fraction(x) for x in lengths[:, 0].tolist()]
        settled = settle_balls(arrays, cables, exact)
        if isinstance(settled, str):
            return _without_inner_point(arrays, cables, lengths, exact, settled)
        enclosed = settled
    return fields_of(cables, arrays.frame, enclosed.box, enclosed.tension, enclosed.states, enclosed.note)


def _without_inner_point(
    arrays: RobotArrays, cables: Cables, lengths: Bounds, exact: Exact, reason: str
) -> Finding:
    """Treat balls of which no common inner point is known."""
    from solvers.point_mass.touching import Deepest, Unheld, settle_touching

    weights = empty_weights(arrays, cables, lengths)
    if weights is not None:
        return NoPose(weights)
    found = None if exact is None else settle_touching(arrays, cables, exact)
    if isinstance(found, Fields):
        return found
    if isinstance(found, Unheld):
        return NoPose(found.weights, touching=True)
    if isinstance(found, Deepest):
        assert exact is not None
        shortest = min(exact[i] for i in found.weights)
        return NoPose(found.weights, gap=float(found.power / (2 * shortest)))
    return Unproved(reason, reachable(arrays, lengths))


def empty_weights(arrays: RobotArrays, cables: Cables, lengths: Bounds) -> dict[int, float] | None:
    """Return weights that prove, exactly, that no point is within reach of all cables; None without proof."""
    from solvers.point_mass.rationals.emptiness import deepest_point, proves_empty

    A, _, _, _ = middles(cables, arrays.load)
    weights, _ = deepest_point(A, np.ascontiguousarray(cables[2][:, 1]))
    longest = [Fraction(x) for x in lengths[:, 1].tolist()]
    return weights if proves_empty(weights, arrays.exits, longest) else None


def _over_ranges(arrays: RobotArrays, lengths: Bounds) -> Finding:
    """Cut the length ranges until the compiled path decides the parts, and return the hull."""
    todo, found, reasons = [lengths], list[Fields](), list[str]()
    empty: NoPose | None = None
    most = ELASTIC_PIECES if arrays.is_elastic else PIECES
    used = 0
    while todo:
        piece = todo.pop(0)
        status, bounds, states = quick_pose(arrays, piece)
        used += 1
        if status == DECIDED:
            found.append(unpacked(bounds, states))
            continue
        cut = _widest(arrays, piece) if used + len(todo) < most and status != NO_POSE else None
        if cut is not None:
            for half in ((piece[cut, 0], cut_at := piece[cut].mean()), (cut_at, piece[cut, 1])):
                part = piece.copy()
                part[cut] = half
                todo.append(part)
            continue
        finding = settle(arrays, piece)
        if isinstance(finding, Fields):
            found.append(finding)
        elif isinstance(finding, NoPose):
            empty = finding
        else:
            reasons.append(finding.reason)
    if not found and not reasons and empty is not None:
        # Different parts may be empty for different reasons; one proof for the whole range is best.
        weights = empty_weights(arrays, scaled_cables(arrays, lengths), lengths)
        return empty if weights is None else NoPose(weights)
    if reasons or empty is not None:
        reason = PARTLY if found or empty is not None else reasons[0]
        return Unproved(reason, reachable(arrays, lengths))
    return _with_switches(arrays, lengths, hull(found), [part.states for part in found])


def _with_switches(
    arrays: RobotArrays, lengths: Bounds, whole: Fields, parts: list[NDArray[np.int64]]
) -> Fields:
    """Say which open cables are taut for some lengths and slack for others, and what is to be noted."""
    from solvers.point_mass.degenerate import open_note
    from solvers.point_mass.switching import changing, choices, tensions_unique

    tight = list(whole.not_slack)
    if tensions_unique(arrays, lengths, tight):
        for i in np.flatnonzero(whole.states == OPEN).tolist():
            tried = (quick_pose(arrays, np.ascontiguousarray(one)) for one in choices(lengths, i))
            seen = [*parts, *(states for status, _, states in tried if status == DECIDED)]
            if changing(seen, i):
                whole.states[i] = SWITCHING
    return replace(whole, note=open_note(arrays, lengths, whole.states))


def _widest(arrays: RobotArrays, lengths: Bounds) -> int | None:
    """Return the cable whose length range matters most: the widest of those near the pose."""
    width = lengths[:, 1] - lengths[:, 0]
    wide = width > 1e-12 * lengths[:, 1]
    if not wide.any():
        return None
    cables = scaled_cables(arrays, lengths)
    A, L, k, f = middles(cables, arrays.load)
    taut, x = np.zeros(max(len(L), 4), dtype=np.int64), np.zeros(3 + max(len(L), 4))
    if arrays.is_elastic:
        guess_elastic(A, L, k, f, taut, x)
    else:
        guess_inextensible(A, L, f, taut, x)
    room = (L - np.linalg.norm(A - x[:3], axis=1)) * arrays.frame[0, 0]
    near = wide & (room < 2.0 * width.max())
    return int(np.where(near if near.any() else wide, width, -1.0).argmax())
