"""Jacobian, speeds and singularities of a Delta at a pose, and boxes of poses proved free of these."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb, arb_mat

from cdpr_interval.engine.budget import Budget
from cdpr_interval.errors import InputError, NotSupportedError
from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import length_bounds
from cdpr_interval.exact.range import Range
from cdpr_interval.exact.singular_values import singular_values
from cdpr_interval.mechanics.delta import (
    Delta,
    Vector,
    delta_of,
    dot,
    drive_of_knee,
    drives_at,
    minus,
    scalar,
)
from cdpr_interval.mechanics.delta_singular import (
    Bars,
    Ranks,
    ball_is_zero,
    cross,
    determinant,
    exact_bars,
    ranks_of,
    surd_is_zero,
)
from cdpr_interval.robots.delta import DeltaRobot
from cdpr_interval.robots.numbers import exact_point
from solvers.answers.data import Outcome, RobotIdentity
from solvers.answers.tool import this_tool
from solvers.delta.data import origin_of
from solvers.delta.given import require_delta
from solvers.delta.kinematics_data import (
    DeltaKinematics,
    DeltaKinematicsQuestion,
    FreeBox,
    Singularity,
)
from solvers.delta.poses import bounds, range_text
from solvers.questions.angles import read_triple
from solvers.questions.ranges import read_range
from solvers.questions.units import METRES, Units

MOST_CELLS = 100_000
"""Of a box of poses: seconds; a box that needs more is near a singular pose, or holds one."""


def delta_kinematics(
    robot: DeltaRobot | str | os.PathLike[str],
    position: Any,
    *,
    velocity: Sequence[float] | None = None,
    rates: Sequence[float] | None = None,
    box: Any = None,
    time_limit: float | None = None,
) -> DeltaKinematics:
    """Return Jacobian, conditioning, speeds and singularities of a Delta at a pose, all of it enclosed.

    Parameters
    ----------
    robot : DeltaRobot, str or PathLike
        Itself, its file, or the name of a shipped one.
    position : str or sequence of 3
        Of the tool point in the base frame, m; each also a range. The arms are on their useful branch.
    velocity, rates : sequence of 3, optional
        Of the platform in m/s, or of the drives in rad/s (m/s): the other one is returned.
    box : str or sequence of 3, optional
        Half widths in m of a box of poses to be proved free of singular poses.
    time_limit : float, optional
        Seconds of wall time for the box.

    Raises
    ------
    InputError
        With one message per error; also where the pose is out of reach.
    NotSupportedError
        Where it is not known whether the pose is within reach.

    Guarantee
    ---------
    A pose is called singular, or regular, only where that is proved: exactly where pose and data are exact,
    all angles multiples of 30 degrees, else by balls. With ``box.free`` no pose of the box is singular.

    Examples
    --------
    >>> result = delta_kinematics("delta_580", ("0", "0", "-0.4"), box=("0.02", "0.02", "0.02"))
    >>> result.singularity.singular, result.box.free
    (False, True)
    """
    given = require_delta(robot)
    return answer_kinematics(given, position, velocity=velocity, rates=rates, box=box, time_limit=time_limit)


def answer_kinematics(
    robot: DeltaRobot,
    position: Any,
    *,
    velocity: Any = None,
    rates: Any = None,
    box: Any = None,
    time_limit: float | None = None,
    label: Callable[[str], str] = str,
) -> DeltaKinematics:
    """Return the answer; ``label`` gives what messages call a parameter."""
    read = read_triple(position, label("position"), lambda v: Range(*read_range(v, METRES)), "coordinates")
    if velocity is not None and rates is not None:
        raise InputError(f"{label('velocity')}: not together with {label('rates')}")
    speeds = {"velocity": velocity, "rates": rates}
    found = {
        name: None if value is None else read_triple(value, label(name), lambda v: _number(v, {}), "speeds")
        for name, value in speeds.items()
    }
    half = None
    if box is not None:
        half = read_triple(box, label("box"), lambda v: _number(v, METRES), "half widths")
        if not all(h > 0 for h in half):
            raise InputError(f"{label('box')}: half widths must be greater than 0")
    with balls.precision():
        return _answer(robot, read, found, half, time_limit)


def _number(value: Any, units: Units) -> Fraction:
    lo, hi = read_range(value, units)
    if lo != hi:
        raise ValueError("must be one number")
    return lo


def _answer(
    robot: DeltaRobot,
    read: tuple[Range, Range, Range],
    speeds: dict[str, tuple[Fraction, Fraction, Fraction] | None],
    half: tuple[Fraction, Fraction, Fraction] | None,
    time_limit: float | None,
) -> DeltaKinematics:
    delta = delta_of(robot)
    centre = minus([balls.from_range(v) for v in read], delta.tool)
    exact = _exact(robot, read)
    drives = _drives(delta, centre, exact)
    bars, pushes = bars_at(delta, centre, drives)
    inverse = None
    if not any(p.contains(arb(0)) for p in pushes):
        inverse = arb_mat([[x / p for x in u] for u, p in zip(bars, pushes, strict=True)])
    values = None if inverse is None else singular_values(inverse)
    if exact is None:
        ranks = ranks_of(_balls(robot, delta, bars, pushes), ball_is_zero)
    else:
        ranks = ranks_of(exact, surd_is_zero)
    reasons = [] if ranks.is_singular is not None else ["whether the pose is singular: it may be, or nearly"]
    velocity, rates = _speeds(bars, pushes, speeds, reasons)
    free = None
    if half is not None:
        around = [Range(v.lo - h, v.hi + h) for v, h in zip(read, half, strict=True)]
        free = free_of_singular_poses(delta, around, time_limit)
        reasons += [free.reason] if free.reason else []
    asked = {k: None if v is None else tuple(map(float, v)) for k, v in {**speeds, "box": half}.items()}
    return DeltaKinematics(
        tool=this_tool(),
        robot=RobotIdentity(robot.name, robot.sha256),
        model=robot.model,
        question=DeltaKinematicsQuestion("kinematics", length_bounds(read), **asked),  # type: ignore[arg-type]
        outcome=Outcome.INCOMPLETE if reasons else Outcome.COMPLETE,
        message=_message(ranks, free),
        drives=bounds(drives),
        jacobian_inverse=None if inverse is None else _rows(inverse),
        bars=_rows(arb_mat(bars)),
        pushes=bounds(pushes),
        singular_values=None if values is None else bounds(values),
        condition=_condition(values),
        velocity=None if velocity is None else bounds(velocity),
        rates=None if rates is None else bounds(rates),
        singularity=Singularity(
            ranks.is_singular, ranks.kinds, ranks.six, ranks.bars, ranks.normals,
            (ranks.drives[0], ranks.drives[1], ranks.drives[2]),
        ),
        box=free,
        undecided=tuple(reasons),
        provenance=origin_of(robot, (range_text(read[0]), range_text(read[1]), range_text(read[2]))),
    )  # fmt: skip


def _exact(robot: DeltaRobot, read: tuple[Range, Range, Range]) -> Bars | None:
    """Return the bars in exact numbers, where pose and data are such."""
    if robot.uncertain or any(v.lo != v.hi for v in read):
        return None
    tool = exact_point(robot.tool_offset)
    return exact_bars(robot, (read[0].lo - tool[0], read[1].lo - tool[1], read[2].lo - tool[2]))


def _drives(delta: Delta, centre: Vector, exact: Bars | None) -> list[arb]:
    if exact is not None:
        # Also at the end of a chain's reach, which balls do not tell from beyond.
        return [
            drive_of_knee(delta, i, minus(centre, [x.ball() for x in u])) for i, u in enumerate(exact.along)
        ]
    found = [drives_at(delta, i, centre) for i in range(3)]
    if any(drive.reach is False for drive in found):
        raise InputError("the pose is out of reach: it has no kinematics")
    drives = [drive.useful for drive in found if drive.useful is not None]
    if len(drives) < 3:
        raise NotSupportedError("the pose may be at the end of a chain's reach: its drives are not enclosed")
    return drives


def bars_at(delta: Delta, centre: Vector, drives: Sequence[arb]) -> tuple[list[Vector], Vector]:
    """Return the unit vectors along the bars, and how each drive moves its knee along them."""
    ways = [minus(centre, delta.knee(i, drive)) for i, drive in enumerate(drives)]
    bars = [[x / delta.bar for x in way] for way in ways]
    return bars, [dot(u, delta.knee_rate(i, drives[i])) for i, u in enumerate(bars)]


def _balls(robot: DeltaRobot, delta: Delta, bars: list[Vector], pushes: Vector) -> Bars:
    """Return the bars of the pose in balls."""
    radius = scalar(robot.platform_radius)
    normals = [cross(chain.tangent, u) for chain, u in zip(delta.chains, bars, strict=True)]
    return Bars(bars, normals, [[radius * x for x in chain.outward] for chain in delta.chains], list(pushes))


def _speeds(
    bars: list[Vector], pushes: Vector, speeds: dict[str, Any], reasons: list[str]
) -> tuple[Vector | None, Vector | None]:
    """Return velocity and rates, of which one was given."""
    if speeds["velocity"] is not None:
        v = [balls.from_fraction(x) for x in speeds["velocity"]]
        if any(p.contains(arb(0)) for p in pushes):
            reasons.append("drive speeds: a drive may be singular")
            return v, None
        return v, [dot(u, v) / p for u, p in zip(bars, pushes, strict=True)]
    if speeds["rates"] is not None:
        q = [balls.from_fraction(x) for x in speeds["rates"]]
        try:
            moved = arb_mat(bars).solve(balls.vector([p * x for p, x in zip(pushes, q, strict=True)]))
        except ZeroDivisionError:
            reasons.append("velocity: the bars may be in a singular pose")
            return None, q
        return list(moved.entries()), q
    return None, None


def _condition(values: Sequence[arb] | None) -> np.ndarray | None:
    if values is None or not values[-1] > 0:
        return None
    return np.array(balls.to_bounds(values[0] / values[-1]))


def _rows(matrix: arb_mat) -> np.ndarray:
    return balls.bounds_array(matrix).reshape(matrix.nrows(), matrix.ncols(), 2)


def _message(ranks: Ranks, free: FreeBox | None) -> str:
    if free is not None and free.free:
        return "no pose of the box is singular"
    word = {True: "a singular pose", False: "a regular pose", None: "a pose that may be singular"}
    return word[ranks.is_singular]


def free_of_singular_poses(
    delta: Delta, around: Sequence[Range], time_limit: float | None = None, most: int = MOST_CELLS
) -> FreeBox:
    """Prove that no pose of a box is singular: cells whose determinants are not 0, halved where they may be.

    Parameters
    ----------
    delta : Delta
        Under `balls.precision`.
    around : sequence of 3 Range
        The box, m.
    time_limit : float, optional
        Seconds of wall time.
    most : int
        Cells.
    """
    budget, cells = Budget(time_limit), 0
    waiting = [tuple(around)]
    while waiting:
        cell = waiting.pop()
        cells += 1
        centre = minus([balls.from_range(v) for v in cell], delta.tool)
        if is_regular(delta, centre):
            continue
        if cells >= most or budget.stop() is not None:
            where = ", ".join(f"{float(v.mid):.6g}" for v in cell)
            return FreeBox(None, cells, f"the box: a pose near ({where}) m may be singular, or out of reach")
        k = max(range(3), key=lambda j: cell[j].width)
        middle = cell[k].mid
        for part in (Range(cell[k].lo, middle), Range(middle, cell[k].hi)):
            waiting.append((*cell[:k], part, *cell[k + 1 :]))
    return FreeBox(True, cells, "")


def is_regular(delta: Delta, centre: Vector) -> bool:
    """Return True where all platform centres in a box are within reach and regular in every way."""
    bars, normals = [], []
    for i, chain in enumerate(delta.chains):
        drive = drives_at(delta, i, centre).useful
        if drive is None:
            return False
        way = minus(centre, delta.knee(i, drive))
        push = dot(way, delta.knee_rate(i, drive))
        if not (push > 0 or push < 0):
            return False
        bars.append(way)
        normals.append(cross(chain.tangent, way))
    return all(x > 0 or x < 0 for x in (determinant(bars), determinant(normals)))
