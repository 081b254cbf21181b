"""Inverse kinematics: distances, cable lengths and tensions for a pose."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr_interval.kernels.nonnegative import (
    RANK_TOLERANCE,
    nonnegative_least_squares,
    smallest_nonnegative_solution,
)
from cdpr_interval.mechanics.cables.law import law_of
from cdpr_interval.mechanics.orientation import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_rpy,
    rpy_from_rotation,
)
from cdpr_interval.mechanics.statics import Pose, StaticModel, static_model
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.given import require_robot
from solvers.answers.data import RobotIdentity
from solvers.answers.ik_result import IkResult
from solvers.answers.inverse import (
    IkPose,
    IkQuestion,
    Residual,
    Settling,
    lengths_option,
)
from solvers.answers.provenance import provenance
from solvers.answers.tool import this_tool
from solvers.kinematics.settle import nearby
from solvers.kinematics.settle import settle as settle_pose
from solvers.questions.arguments import check_positive, is_number, require_flags, shown
from solvers.questions.checked import not_on_six_legs, require_treated, uncertain_data
from solvers.questions.errors import InputErrors
from solvers.questions.force import NO_LOAD, ZERO, read_force
from solvers.questions.pose import read_rpy
from solvers.questions.strokes import names_beyond
from solvers.questions.subset import read_subset

Floats = NDArray[np.float64]

SLACK_MARGIN = 0.05
"""Default share by which cables outside the taut subset are longer than their distance."""
WRENCH_TOLERANCE = 1e-6
"""Default residual, as a share of the load, up to which a pose counts as static."""
ORTHOGONAL = 1e-6
"""How far R^T R of a given matrix may be from the identity."""


def inverse_kinematics(
    robot: Robot | str | os.PathLike[str],
    position: ArrayLike,
    rotation: ArrayLike | None = None,
    *,
    rpy: Iterable[float | str] | None = None,
    quaternion: Sequence[float] | None = None,
    taut: str | Iterable[str | int] | None = None,
    slack_margin: float = SLACK_MARGIN,
    settle: bool = False,
    settle_within: float | None = None,
    static: bool = False,
    wrench_tolerance: float = WRENCH_TOLERANCE,
    external_force: Sequence[Any] | None = None,
) -> IkResult:
    """Return distances, cable lengths and tensions at a pose, in plain floats.

    Parameters
    ----------
    robot : Robot, str or PathLike
        Itself, its file, or the name of a shipped robot.
    position : (3,) array
        Platform origin in the base frame, m.
    rotation : (3, 3) array, optional
        Platform to base; the default is the identity.
    rpy : (roll, pitch, yaw), optional
        Instead of ``rotation``: R = Rz(yaw) Ry(pitch) Rx(roll), in rad; a text has its unit
        (``"5deg"``, ``"0.1rad"``).
    quaternion : (w, x, y, z), optional
        Instead of ``rotation``; of any non-zero norm.
    taut : iterable of str or int, optional
        The cables that may carry tension (names or indices from 0); the default is all of them.
    slack_margin : float
        Every other cable is longer than its distance by this fraction.
    settle : bool
        First move to the nearest static pose of the taut cables.
    settle_within : float, optional
        m: no point of the platform may move further than that. The default is the platform's size (largest
        distance of an anchor from the centre of mass); for a point mass a tenth of the mean distance to
        the exit points.
    static : bool
        Recorded in the result: the caller wants a static pose or nothing.
    wrench_tolerance : float
        The pose counts as static when the residual force, and the residual moment divided by the
        platform's radius, are at most this share of the load.
    external_force : sequence of 3 numbers, optional
        Constant force at the centre of mass in N, base axes, added to the weight.

    Examples
    --------
    >>> result = inverse_kinematics("uc2", (5, 0, -7), rpy=("0", "2deg", "0"), settle=True)
    >>> result.is_static, len(result.lengths)
    (True, 2)

    Returns
    -------
    IkResult
        The tensions are the non-negative ones of least norm when the pose is static, else those that
        balance the load best; the forces of legs have any sign. Where settling found no static pose, or
        none near enough, the result is about the pose that was given and has no lengths; ``settling`` says
        how far away the found one is.

    Raises
    ------
    InputError
        With one message per error.
    NotSupportedError
        For a robot with uncertain scalars.
    """
    require_flags(settle=settle, static=static)
    errors, robot = InputErrors(), require_robot(robot)
    pose = errors.read(_pose, position, rotation, rpy, quaternion)
    answer = errors.read(
        answer_pose,
        robot,
        pose,
        taut=taut,
        slack_margin=slack_margin,
        settle=settle,
        settle_within=settle_within,
        static=static,
        wrench_tolerance=wrench_tolerance,
        external_force=external_force,
    )
    errors.require_none()
    assert answer is not None
    return answer


def answer_pose(
    robot: Robot,
    pose: Pose | None,
    *,
    taut: Any,
    slack_margin: float,
    settle: bool,
    settle_within: float | None,
    static: bool,
    wrench_tolerance: float,
    external_force: Any,
    label: Callable[[str], str] = str,
) -> IkResult | None:
    """Return the answer at a pose; with ``pose`` None only check the other arguments.

    Parameters
    ----------
    robot, pose, taut, slack_margin, settle, settle_within, static, wrench_tolerance, external_force
        As `inverse_kinematics`.
    label : callable
        From a parameter's name to what messages call it.

    Raises
    ------
    InputError
        With one message per rule that is broken.
    NotSupportedError
        For a robot with uncertain scalars.
    """
    require_treated(robot, not_on_six_legs(robot) or uncertain_data(robot, asker="ik"))
    errors = InputErrors()
    subset = None if taut is None else errors.read(read_subset, taut, robot.cable_names, label("taut"))
    force = ZERO if external_force is None else errors.read(read_force, external_force)
    if not (is_number(slack_margin) and slack_margin >= 0.0):
        errors.add(f"{label('slack_margin')}: must not be negative, got {shown(slack_margin)}")
    if wrench_tolerance is None:
        errors.add(f"{label('wrench_tolerance')}: must be a positive number, got None")
    check_positive(errors, label, wrench_tolerance=wrench_tolerance)
    if settle_within is not None and not settle:
        errors.add(f"{label('settle_within')}: only with {label('settle')}")
    else:
        check_positive(errors, label, settle_within=settle_within)
    for text in _complaints_of_legs(robot, subset, slack_margin, settle, label):
        errors.add(text)
    model = static_model(robot, force or ZERO)
    if pose is not None and model.rows == 3 and np.abs(pose.rotation - np.eye(3)).max() > ORTHOGONAL:
        errors.add(f"{label('pose')}: this robot is a point mass, which has no orientation")
    if not model.load.any():
        errors.add(NO_LOAD)
    errors.require_none()
    if pose is None:
        return None
    assert force is not None
    if settle and settle_within is None:
        settle_within = nearby(model, pose)
    fx, fy, fz = (float(component) for component in force)
    question = IkQuestion(
        command="ik",
        position=_triple(pose.position),
        quaternion_wxyz=quaternion_from_rotation(pose.rotation),
        taut=None if subset is None else tuple(robot.cable_names[i] for i in subset),
        slack_margin=slack_margin,
        settle=settle,
        settle_within=settle_within,
        static=static,
        wrench_tolerance=wrench_tolerance,
        external_force=(fx, fy, fz),
    )
    found = _answer(robot, model, pose, subset, question)
    return replace(found, provenance=provenance(robot, (), force))


def _complaints_of_legs(
    robot: Robot,
    taut: tuple[int, ...] | None,
    slack_margin: float,
    settle: bool,
    label: Callable[[str], str],
) -> Iterator[str]:
    """Yield what a question about a Gough platform may not ask; nothing for cables."""
    if not robot.has_legs:
        return
    if taut is not None and len(taut) != len(robot.cables):
        yield f"{label('taut')}: all {len(robot.cables)} legs carry, got {len(taut)}"
    if slack_margin != SLACK_MARGIN:
        yield f"{label('slack_margin')}: is for cables, legs are never slack"
    if settle:
        yield f"{label('settle')}: is for cables, legs hold the pose that is asked for"


def _pose(
    position: ArrayLike,
    rotation: ArrayLike | None,
    rpy: Iterable[float | str] | None,
    quaternion: Sequence[float] | None,
) -> Pose:
    """Return the pose, or raise `InputError` with all that is wrong with it."""
    errors = InputErrors()
    place = _floats(position)
    matrix = np.eye(3) if rotation is None else _floats(rotation)
    if place.shape != (3,) or not np.isfinite(place).all():
        errors.add(f"position: must be 3 finite numbers, got {shown(position)}")
    if rpy is not None:
        if rotation is not None or quaternion is not None:
            errors.add("rpy: not together with a rotation matrix or a quaternion")
        elif (angles := errors.read(read_rpy, rpy)) is not None:
            matrix = rotation_from_rpy(angles)
    if quaternion is not None:
        if rotation is not None:
            errors.add("quaternion: not together with a rotation matrix")
        elif (four := _floats(quaternion)).shape != (4,) or not 0.0 < np.linalg.norm(four) < math.inf:
            errors.add(f"quaternion: must be 4 finite numbers, not all zero, got {shown(quaternion)}")
        else:
            matrix = rotation_from_quaternion(four.tolist())
    if matrix.shape != (3, 3) or not np.abs(matrix.T @ matrix - np.eye(3)).max() <= ORTHOGONAL:
        errors.add("rotation: must be an orthogonal 3 x 3 matrix")
    elif np.linalg.det(matrix) < 0.0:
        errors.add("rotation: is a reflection, its determinant is -1")
    errors.require_none()
    return Pose(place, matrix)


def _floats(given: Any) -> Floats:
    """Return numbers as an array; an empty one of what holds none."""
    try:
        return np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        return np.empty(0)


def _answer(
    robot: Robot, model: StaticModel, given: Pose, subset: tuple[int, ...] | None, question: IkQuestion
) -> IkResult:
    taut = tuple(range(len(robot.cables))) if subset is None else subset
    pose, settling = given, None
    if question.settle:
        settled = settle_pose(model, given, taut)
        assert question.settle_within is not None
        near = settled.is_static and settled.travel <= question.settle_within
        settling = Settling(near, settled.is_static, settled.distance, settled.angle, settled.travel)
        pose = settled.pose if near else given
    distances = model.distances(pose)
    tensions, residual, is_static = (_leg_forces if robot.has_legs else _tensions)(
        model, pose, taut, question.wrench_tolerance
    )
    lengths, short = _lengths(robot, distances, tensions, taut, question.slack_margin)
    needs_tensions = any(law_of(robot.cables[i]).stretches for i in taut)
    if short or (needs_tensions and not is_static) or (settling is not None and not settling.succeeded):
        lengths = None
    moment = np.zeros(3) if model.rows == 3 else model.radius * residual[3:]
    rows = [_triple(row) for row in pose.rotation]
    return IkResult(
        tool=this_tool(),
        robot=RobotIdentity(robot.name, robot.sha256),
        model=robot.model,
        cables=robot.cable_names,
        question=question,
        pose=IkPose(
            _triple(pose.position),
            (rows[0], rows[1], rows[2]),
            quaternion_from_rotation(pose.rotation),
            rpy_from_rotation(pose.rotation),
        ),
        distances=tuple(distances.tolist()),
        lengths=lengths,
        lengths_option=lengths_option(lengths),
        tensions=tuple(tensions.tolist()),
        static=is_static,
        residual=Residual(_triple(residual[:3]), _triple(moment)),
        settled=settling,
        outside_tension_limits=_outside_limits(robot, tensions, taut),
        outside_length_limits=names_beyond(robot, [(length, length) for length in distances.tolist()]),
        message=_message(model, question, residual, is_static, settling, short, _idle(model, tensions, taut))
        + _singular(robot, model, pose),
    )


def _tensions(
    model: StaticModel, pose: Pose, taut: tuple[int, ...], tolerance: float
) -> tuple[Floats, Floats, bool]:
    """Return tensions (N,), the scaled residual wrench (N) and whether it is within the tolerance."""
    size = float(np.linalg.norm(model.load))
    columns = model.wrenches(pose)[:, taut]
    load = model.load_wrench
    tensions = np.zeros(len(model.names))
    for solve in (smallest_nonnegative_solution, nonnegative_least_squares):
        fitted = solve(columns, -load / size)
        residual = size * (columns @ fitted) + load
        is_static = _within(residual, tolerance * size)
        if is_static:
            break
    tensions[list(taut)] = size * fitted
    return tensions, residual, is_static


def _leg_forces(
    model: StaticModel, pose: Pose, taut: tuple[int, ...], tolerance: float
) -> tuple[Floats, Floats, bool]:
    """Return what `_tensions` does, with forces of any sign: the least ones where several would do."""
    size = float(np.linalg.norm(model.load))
    columns, load = model.wrenches(pose)[:, taut], model.load_wrench
    forces = np.zeros(len(model.names))
    forces[list(taut)] = size * np.linalg.lstsq(columns, -load / size, rcond=RANK_TOLERANCE)[0]
    residual = columns @ forces[list(taut)] + load
    return forces, residual, _within(residual, tolerance * size)


def _within(residual: Floats, limit: float) -> bool:
    parts = (residual[:3], residual[3:])
    return all(float(np.linalg.norm(part)) <= limit for part in parts)


def _lengths(
    robot: Robot, distances: Floats, tensions: Floats, taut: tuple[int, ...], slack_margin: float
) -> tuple[tuple[float, ...] | None, tuple[str, ...]]:
    """Return the lengths and the cables that would need one that is not positive."""
    lengths, short = [], []
    for index, cable in enumerate(robot.cables):
        distance, tension = float(distances[index]), float(tensions[index])
        if index not in taut:
            length = distance * (1.0 + slack_margin)
        else:
            length = law_of(cable).unstretched(distance, tension, float)
        if not length > 0.0:
            short.append(cable.name)
        lengths.append(length)
    return tuple(lengths), tuple(short)


def _outside_limits(robot: Robot, tensions: Floats, taut: tuple[int, ...]) -> tuple[str, ...]:
    outside = []
    for index in taut:
        limits = robot.cables[index].tension_limits
        if limits is not None and not float(limits[0]) <= tensions[index] <= float(limits[1]):
            outside.append(robot.cables[index].name)
    return tuple(outside)


def _idle(model: StaticModel, tensions: Floats, taut: tuple[int, ...]) -> tuple[str, ...]:
    """Return the taut cables, or the legs, that carry nothing."""
    return tuple(model.names[i] for i in taut if abs(tensions[i]) <= 1e-9 * float(np.linalg.norm(model.load)))


def _message(
    model: StaticModel,
    question: IkQuestion,
    residual: Floats,
    is_static: bool,
    settling: Settling | None,
    short: tuple[str, ...],
    idle: tuple[str, ...],
) -> str:
    """Return one sentence that says whether the pose is static and what was done to it."""
    force = float(np.linalg.norm(residual[:3]))
    moment = 0.0 if model.rows == 3 else model.radius * float(np.linalg.norm(residual[3:]))
    if is_static:
        text = "the pose is static"
    else:
        text = f"the pose is not static: {force:.3g} N and {moment:.3g} N m are not balanced"
    if settling is not None and settling.succeeded:
        text += f"; moved by {settling.distance:.3g} m and {math.degrees(settling.angle):.3g} deg"
    elif settling is not None:
        text += f"; no static pose of these cables was found within {question.settle_within:.3g} m"
        if settling.found:
            turned = f"{settling.distance:.3g} m and {math.degrees(settling.angle):.3g} deg"
            text += f": the nearest found is {settling.travel:.3g} m away, moved by {turned}"
    if is_static and idle:
        text += f"; without tension: {', '.join(idle)}"
    if short:
        text += f"; the stretch exceeds the distance: {', '.join(short)}"
    return text


def _singular(robot: Robot, model: StaticModel, pose: Pose) -> str:
    """Return what is said of legs that do not hold the platform at a pose; nothing of others."""
    if not robot.has_legs:
        return ""
    values = np.linalg.svd(model.wrenches(pose), compute_uv=False)
    is_singular = values[-1] <= RANK_TOLERANCE * values[0]
    return "; the legs are singular there: they hold it no more" if is_singular else ""


def _triple(values: Floats) -> tuple[float, float, float]:
    x, y, z = (float(value) + 0.0 for value in values)
    return x, y, z
