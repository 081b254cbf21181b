"""Rotations R(u) D_c, the Cayley rotation and the identity or a half turn, in numbers of any kind."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

HALF_TURNS = ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))
"""Diagonals of D_c."""


def scaled_rotation(chart: Any, u: Sequence[Any]) -> tuple[Any, list[list[Any]]]:
    """Return s = 1 + |u|^2 and s R(u) D_c, a polynomial; ``chart`` is one, or an array: of each cell."""
    x, y, z = u
    xx, yy, zz, yz, zx, xy = x * x, y * y, z * z, y * z, z * x, x * y
    rows = [
        [1 + xx - yy - zz, 2 * (xy - z), 2 * (zx + y)],
        [2 * (xy + z), 1 - xx + yy - zz, 2 * (yz - x)],
        [2 * (zx - y), 2 * (yz + x), 1 - xx - yy + zz],
    ]
    signs = HALF_TURNS[chart] if isinstance(chart, int) else np.array(HALF_TURNS)[chart].T
    return xx + yy + zz + 1, [[v * c for c, v in zip(signs, row, strict=True)] for row in rows]
