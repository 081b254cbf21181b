"""Orientations as rotation matrices, unit quaternions and roll-pitch-yaw angles, in plain floats.

R turns platform coordinates into base coordinates; R = Rz(yaw) Ry(pitch) Rx(roll); quaternions are
(w, x, y, z), scalar first. Nothing here is certified.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Matrix = NDArray[np.float64]
Quaternion = tuple[float, float, float, float]
Angles = tuple[float, float, float]


def rotation_from_quaternion(quaternion: Sequence[float]) -> Matrix:
    """Return the (3, 3) rotation of a non-zero quaternion of any norm."""
    norm = math.hypot(*quaternion)
    w, x, y, z = (component / norm for component in quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def rotation_from_rpy(angles: Sequence[float]) -> Matrix:
    """Return Rz(yaw) Ry(pitch) Rx(roll), (3, 3), for (roll, pitch, yaw) in rad."""
    (sr, sp, sy), (cr, cp, cy) = ([f(angle) for angle in angles] for f in (math.sin, math.cos))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def quaternion_from_rotation(rotation: ArrayLike) -> Quaternion:
    """Return the unit quaternion with w >= 0 of a rotation matrix, (3, 3)."""
    r = np.asarray(rotation, dtype=np.float64).tolist()
    # Four times the squares; dividing by the largest entry keeps every digit (Shepperd 1978).
    squares = [
        1 + r[0][0] + r[1][1] + r[2][2],
        1 + r[0][0] - r[1][1] - r[2][2],
        1 - r[0][0] + r[1][1] - r[2][2],
        1 - r[0][0] - r[1][1] + r[2][2],
    ]
    largest = squares.index(max(squares))
    a, b, c = r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]
    d, e, f = r[1][0] + r[0][1], r[0][2] + r[2][0], r[2][1] + r[1][2]
    rows = [[squares[0], a, b, c], [a, squares[1], d, e], [b, d, squares[2], f], [c, e, f, squares[3]]]
    row = rows[largest]
    scale = math.copysign(1.0, row[0]) / math.hypot(*row)
    # Adding zero turns -0.0 into 0.0.
    w, x, y, z = (scale * component + 0.0 for component in row)
    return w, x, y, z


def rpy_from_rotation(rotation: ArrayLike) -> Angles:
    """Return (roll, pitch, yaw) in rad; at a pitch of a quarter turn the roll is set to zero."""
    r = np.asarray(rotation, dtype=np.float64).tolist()
    cosine = math.hypot(r[0][0], r[1][0])
    pitch = math.atan2(-r[2][0], cosine)
    if cosine < 1e-9:
        return 0.0, pitch, math.atan2(-r[0][1], r[1][1])
    return math.atan2(r[2][1], r[2][2]), pitch, math.atan2(r[1][0], r[0][0])


def rotation_from_vector(vector: ArrayLike) -> Matrix:
    """Return the (3, 3) rotation by |v| rad about v (3,)."""
    x, y, z = np.asarray(vector, dtype=np.float64).tolist()
    angle = math.hypot(x, y, z)
    # sin(a/2)/a tends to 1/2; below 1e-8 the series' next term is under the rounding.
    factor = math.sin(angle / 2) / angle if angle > 1e-8 else 0.5
    return rotation_from_quaternion((math.cos(angle / 2), factor * x, factor * y, factor * z))


def vector_from_rotation(rotation: ArrayLike) -> NDArray[np.float64]:
    """Return the rotation vector (3,) in rad, of length at most pi."""
    w, x, y, z = quaternion_from_rotation(rotation)
    sine = math.hypot(x, y, z)
    factor = 2 * math.atan2(sine, w) / sine if sine > 1e-8 else 2.0
    return np.array([factor * x, factor * y, factor * z])
