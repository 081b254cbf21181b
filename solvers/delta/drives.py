"""The drives that bring a Delta to a pose, both branches of each chain, in closed form and enclosed."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from flint import arb

from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import length_bounds
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.delta import Drives, delta_of, drives_at
from cdpr_interval.robots.delta import DeltaRobot
from solvers.answers.data import Outcome, RobotIdentity
from solvers.answers.tool import this_tool
from solvers.delta.data import DeltaQuestion, origin_of
from solvers.delta.given import require_delta
from solvers.delta.poses import beside_limits, bounds, range_text
from solvers.delta.result import DeltaIkResult
from solvers.questions.angles import read_triple
from solvers.questions.ranges import read_range
from solvers.questions.units import METRES

CHAINS = ("first", "second", "third")


def delta_drives(robot: DeltaRobot | str | os.PathLike[str], position: Any) -> DeltaIkResult:
    """Return the drives that bring the tool point of a Delta to a pose.

    Parameters
    ----------
    robot : DeltaRobot, str or PathLike
        Itself, its file, or the name of a shipped one.
    position : str or sequence of 3
        Of the tool point in the base frame, m; each also a range.

    Returns
    -------
    DeltaIkResult
        Angles of the arms (or positions of carriages) on the useful branch, and the other branch.

    Raises
    ------
    InputError
        With one message per error.

    Guarantee
    ---------
    With outcome COMPLETE each chain has these two drives and no other one, or the pose is out of reach, for
    every choice of pose and data in their ranges.

    Source: EPFL, *Les robots paralleles*, 1.3 (inverse model), without the 0/0 of its half tangent; the
    useful branch is told by the angle before it is brought into (-pi, pi].

    Examples
    --------
    >>> result = delta_drives("delta_580", ("0", "0.15", "-0.45"))
    >>> [round(float(a.mean()), 9) for a in result.angles]
    [1.088092721, 0.603357475, 1.468951256]
    """
    return answer_position(require_delta(robot), position)


def answer_position(robot: DeltaRobot, position: Any, label: Callable[[str], str] = str) -> DeltaIkResult:
    """Return the answer; ``label`` gives what messages call a parameter."""
    read = read_triple(position, label("position"), lambda v: Range(*read_range(v, METRES)), "coordinates")
    with balls.precision():
        delta = delta_of(robot)
        place = [balls.from_range(v) for v in read]
        centre = [p - t for p, t in zip(place, delta.tool, strict=True)]
        found = [drives_at(delta, i, centre) for i in range(3)]
        reach = _all(drive.reach for drive in found)
        useful, other = ([_enclosed(v) for v in pair] for pair in zip(*(d[:2] for d in found), strict=True))
        leans = elbows = kept = None
        if reach:
            leans, elbows, kept = beside_limits(robot, delta, centre, useful)
        reasons = tuple(
            f"whether the {CHAINS[i]} chain reaches the pose is not known: it may be at the end of its reach"
            for i, drive in enumerate(found)
            if drive.reach is None and reach is not False
        )
        if reach and kept is None:
            reasons += ("whether the pose keeps the limits is not known",)
        rows, others = (bounds(useful), bounds(other)) if reach else (None, None)
        linear = robot.is_linear
        return DeltaIkResult(
            tool=this_tool(),
            robot=RobotIdentity(robot.name, robot.sha256),
            model=robot.model,
            question=DeltaQuestion("ik", position=length_bounds(read)),
            outcome=Outcome.INCOMPLETE if reasons else Outcome.COMPLETE,
            message=_message(found, reach, kept, reasons),
            reachable=reach,
            position=tuple(float(v.mid) for v in read),  # type: ignore[arg-type]
            angles=None if linear else rows,
            other_branch=None if linear else others,
            positions=rows if linear else None,
            other_positions=others if linear else None,
            bar_angles=leans,
            elbow_angles=elbows,
            limits_respected=kept,
            undecided=reasons,
            provenance=origin_of(robot, tuple(range_text(v) for v in read)),  # type: ignore[arg-type]
        )


def _enclosed(value: arb | None) -> arb:
    """Return a drive; anything where there is none."""
    return arb(0, np.inf) if value is None else value


def _all(values: Any) -> bool | None:
    """Return whether all hold; None where that is not known."""
    seen = list(values)
    return False if False in seen else None if None in seen else True


def _message(found: Sequence[Drives], reach: bool | None, kept: bool | None, reasons: tuple[str, ...]) -> str:
    if reach is False:
        short = [CHAINS[i] for i, drive in enumerate(found) if drive.reach is False]
        chains = "chain does" if len(short) == 1 else "chains do"
        return f"out of reach: the {', '.join(short)} {chains} not get there"
    if reasons:
        return f"not proved: {reasons[0]}"
    return "all three chains reach the pose" + ("" if kept else ", beyond the limits")
