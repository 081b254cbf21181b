"""A pose of the platform as a user gives it: position of the platform origin and orientation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from cdpr_interval.errors import InputError
from cdpr_interval.files.literal import quote, read_number
from cdpr_interval.mechanics.orientation import rotation_from_quaternion, rotation_from_rpy
from cdpr_interval.mechanics.statics import Pose


def read_pose(pose: str, quaternion: str | None = None) -> Pose:
    """Return the pose of ``--pose x,y,z[,roll,pitch,yaw]`` and ``--quaternion w,x,y,z``.

    Angles are in rad, or in degrees where an entry ends in ``deg``. A quaternion need not have
    norm one.

    Raises
    ------
    InputError
        One message per entry that is wrong.
    """
    errors: list[str] = []
    entries = pose.split(",")
    if len(entries) not in (3, 6):
        errors.append(f"--pose: must hold x,y,z or x,y,z,roll,pitch,yaw, got {len(entries)} entries")
    position = _floats("--pose", entries[:3], errors)
    angles = _floats("--pose", entries[3:], errors, start=3)
    rotation = np.eye(3)
    if quaternion is not None:
        if len(entries) > 3:
            errors.append("--quaternion: not together with roll, pitch and yaw in --pose")
        components = quaternion.split(",")
        if len(components) != 4:
            errors.append(f"--quaternion: must hold w,x,y,z, got {len(components)} entries")
        values = _floats("--quaternion", components, errors, angles_allowed=False)
        if not errors and not any(values):
            errors.append("--quaternion: must not be zero")
        if not errors:
            rotation = rotation_from_quaternion(values)
    elif not errors and len(angles) == 3:
        rotation = rotation_from_rpy(angles)
    if errors:
        raise InputError(*errors)
    return Pose(np.array(position), rotation)


def _floats(
    label: str, entries: Sequence[str], errors: list[str], start: int = 0, angles_allowed: bool = True
) -> list[float]:
    """Return the numbers, noting in ``errors`` the entries that are none; ``deg`` from entry 3 on."""
    values = []
    for index, entry in enumerate(entries, start):
        text = entry.strip()
        try:
            if text.endswith("deg"):
                if index < 3 or not angles_allowed:
                    raise ValueError(f"{quote(text)} is not a number (only angles are in deg)")
                values.append(math.radians(_float(text.removesuffix("deg").strip())))
            else:
                values.append(_float(text))
        except ValueError as error:
            errors.append(f"{label}[{index}]: {error}")
    return values


def _float(text: str) -> float:
    value: Fraction = read_number(text)
    return float(value)
