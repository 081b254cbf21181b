"""A result of inverse kinematics as text: short numbers to read, then every digit to paste."""

from __future__ import annotations

from collections.abc import Sequence

from cdpr_interval.mechanics.orientation import rotation_from_quaternion, rpy_from_rotation
from solvers.answers.angles import shown_angles
from solvers.answers.inverse import IkData
from solvers.answers.pose_row import POINT_MASS

HEAD = ("cable", "distance m", "length m", "tension N")
OUTSIDE = "outside its limits"


def title_of(result: IkData) -> str:
    """Return the robot and the sentence of the result."""
    return f"{result.robot.name} ({result.model}): {result.message}"


def poses_of(result: IkData) -> list[tuple[str, str]]:
    """Return the pose that was asked for, and where it was settled, each after its name."""
    asked = result.question
    angles = rpy_from_rotation(rotation_from_quaternion(asked.quaternion))
    found = [("pose asked for", _place(result, asked.position, angles))]
    if _is_moved(result):
        found.append(("pose settled", _place(result, result.position, result.rpy)))
    return found


def outside_of(result: IkData) -> tuple[str, ...]:
    """Return the names of cables whose tension, and of legs whose length, is outside its limits."""
    return (*result.outside_tension_limits, *result.outside_length_limits)


def rows_of(result: IkData) -> list[tuple[str, str, str, str, str]]:
    """Return name, distance, length, tension and a remark of every cable."""
    rows, outside = [], outside_of(result)
    for i, name in enumerate(result.cables):
        length = "-" if result.lengths is None else f"{result.lengths[i]:.6f}"
        remark = OUTSIDE if name in outside else ""
        rows.append((name, f"{result.distances[i]:.6f}", length, f"{result.tensions[i]:.4f}", remark))
    return rows


def options_of(result: IkData) -> list[str]:
    """Return what can be pasted after a command: a settled pose, and the lengths."""
    options = [f"--pose {result.pose_option}"] if _is_moved(result) else []
    return options if result.lengths_option is None else [*options, f"--lengths {result.lengths_option}"]


def text_of(result: IkData) -> str:
    """Return the table as plain text."""
    lines = [title_of(result), *(f"{name:14} {place}" for name, place in poses_of(result))]
    width = max(len("cable"), *(len(name) for name in result.cables))
    for name, *cells, remark in ((*HEAD, ""), *rows_of(result)):
        lines.append("  ".join([name.ljust(width), *(cell.rjust(12) for cell in cells), remark]).rstrip())
    return "\n".join([*lines, *options_of(result)])


def _is_moved(result: IkData) -> bool:
    return result.settling is not None and result.settling.succeeded


def _place(result: IkData, position: Sequence[float], angles: Sequence[float]) -> str:
    place = f"({', '.join(f'{x:z.6f}' for x in position)}) m"
    return place if result.model == POINT_MASS else f"{place}, roll pitch yaw ({shown_angles(angles)})"
