"""The terms of a tube's polynomial, and radii around it.

Arrays: ``F`` (rows, columns of a form, LANES) forms with the rows of ``tube.TABLE``; ``free`` (m,) the free
unknowns, ``v`` (m,) radii.
"""

from __future__ import annotations

from typing import Any

from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.mechanics.six_dof.form_system import Z
from cdpr_interval.mechanics.six_dof.rows import MOST_TAUT
from cdpr_interval.mechanics.six_dof.tube import LANE

LEVEL = 0.05
"""Least radius over the largest, in units of each unknown."""
QUADRATIC = 1 + MOST_TAUT
"""The column of a form where its coefficients of second order begin."""
TERMS = QUADRATIC + MOST_TAUT * (MOST_TAUT + 1) // 2


@kernel()
def column_of(i: int, j: int) -> int:
    """Return the column of the product of the symbols i <= j."""
    if i == j:
        return QUADRATIC + i
    return QUADRATIC + MOST_TAUT + i * MOST_TAUT - i * (i + 1) // 2 + j - i - 1


@kernel()
def levelled(F: Any, size: float, free: Any, v: Any) -> None:
    """Raise radii v (m,) that are small beside the others: what moves one unknown is in all equations."""
    most, reach = 0.0, 0.0
    for i in range(free.shape[0]):
        if free[i] >= 6:
            most = max(most, abs(F[Z + free[i], 0, LANE]))
    for i in range(free.shape[0]):
        scale = 1.0 if free[i] < 3 else (size if free[i] < 6 else most)
        if scale > 0.0:
            reach = max(reach, v[i] / scale)
    for i in range(free.shape[0]):
        scale = 1.0 if free[i] < 3 else (size if free[i] < 6 else most)
        v[i] = max(v[i], LEVEL * reach * scale)
