"""A pose of the platform as a user gives it: position of the platform origin and orientation."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

import numpy as np

from cdpr_interval.errors import InputError
from cdpr_interval.mechanics.orientation import rotation_from_quaternion, rotation_from_rpy
from cdpr_interval.mechanics.statics import Pose
from cdpr_interval.text.count import counted
from cdpr_interval.text.literal import quote, read_number
from cdpr_interval.text.number import exact_number
from solvers.questions.units import METRES, entries_of, read_metres, read_radians

Value = TypeVar("Value")

_WITH_TOLERANCE = re.compile(
    r"([^\s,]+?)\s*(?:\+/-|\+-|±)\s*([0-9.]+(?:[eE][-+]?[0-9]+)?)(?:\s*(mm|cm|m|deg|°|rad))?(?=[\s,]|$)"
)


def read_pose(pose: str, quaternion: str | None = None, label: str = "--pose") -> Pose:
    """Return the pose of ``--pose x,y,z[,roll,pitch,yaw]`` and ``--quaternion w,x,y,z``.

    Entries are parted by commas or spaces. A position is in m unless it says ``mm`` or ``cm``; an angle that
    is not zero says ``deg``, ``°`` or ``rad``. Of ``5.2964 +- 0.0010``, as tables show bounds, the middle is
    taken (`middles_of`). A quaternion need not have norm one.

    Parameters
    ----------
    pose, quaternion : str
    label : str
        What messages call the pose.

    Raises
    ------
    InputError
        One message per entry that is wrong.
    """
    errors: list[str] = []
    entries = entries_of(middles_of(pose, label), label)
    if len(entries) not in (3, 6):
        given = counted(len(entries), "entry", "entries")
        errors.append(f"{label}: must hold x,y,z or x,y,z,roll,pitch,yaw, got {given}")
    position = _read(label, entries[:3], lambda text: float(read_metres(text)), errors)
    angles = _read(label, entries[3:], read_radians, errors, start=3)
    rotation = np.eye(3)
    if quaternion is not None:
        if len(entries) > 3:
            errors.append(f"--quaternion: not together with roll, pitch and yaw in {label}")
        components = entries_of(quaternion, "--quaternion")
        if len(components) != 4:
            given = counted(len(components), "entry", "entries")
            errors.append(f"--quaternion: must hold w,x,y,z, got {given}")
        values = _read("--quaternion", components, lambda text: float(read_number(text)), errors)
        if not errors and not any(values):
            errors.append("--quaternion: must not be zero")
        if not errors:
            rotation = rotation_from_quaternion(values)
    elif not errors and len(angles) == 3:
        rotation = rotation_from_rpy(angles)
    if errors:
        raise InputError(*errors)
    return Pose(np.array(position), rotation)


def middles_of(pose: str, label: str = "--pose") -> str:
    """Return the text of a pose without tolerances: of ``5.2964 +- 0.0010, 5 +- 1deg`` ``5.2964, 5deg``.

    Raises
    ------
    InputError
        A length has its unit after the tolerance only: it could be that of the tolerance alone.
    """

    def middle(found: re.Match[str]) -> str:
        value, _, unit = found.groups("")
        if not unit or value[-1].isalpha() or value[-1] == "°":
            return value
        if unit in METRES:
            raise InputError(f"{label}: in {quote(found[0])} one number has a unit: give both one, or none")
        return value + unit

    return _WITH_TOLERANCE.sub(middle, pose)


def read_rpy(given: Iterable[Any], label: str = "rpy") -> tuple[float, float, float]:
    """Return (roll, pitch, yaw) in rad of numbers in rad, or of texts with a unit (``"5deg"``)."""
    try:
        values = list(given)
    except TypeError:
        raise InputError(f"{label}: must hold roll, pitch and yaw, got {given!r}") from None
    if isinstance(given, str) or len(values) != 3:
        raise InputError(f"{label}: must hold roll, pitch and yaw, got {given!r}")
    errors: list[str] = []
    angles = _read(label, values, _angle, errors)
    if errors:
        raise InputError(*errors)
    roll, pitch, yaw = angles
    return roll, pitch, yaw


def _angle(value: Any) -> float:
    return read_radians(value.strip()) if isinstance(value, str) else float(exact_number(value))


def _read(
    label: str, entries: Sequence[Any], reader: Callable[[Any], Value], errors: list[str], start: int = 0
) -> list[Value]:
    """Return what the reader makes of each entry, noting in ``errors`` the entries that it refuses."""
    values = []
    for index, entry in enumerate(entries, start):
        try:
            values.append(reader(entry))
        except ValueError as error:
            errors.append(f"{label}[{index}]: {error}")
    return values
