"""From the enclosure of a pose to the fields a solution reports, in the units of the robot file.

Arrays: ``cables`` is an ``arrays.Cables`` of N cables, ``exits`` (N, 3, 2) are theirs.
"""

from __future__ import annotations

from typing import Any

from cdpr_interval.kernels.interval import add, mul, sqr, sqrt, sub
from cdpr_interval.kernels.kernel import entry

SLACK, TAUT, OPEN, SWITCHING = 0, 1, 2, 3
"""States of a cable: proved slack, proved taut, undecided, switching (no kernel gives that one)."""


@entry()
def distance(exits: Any, c: int, box: Any) -> tuple[float, float]:
    """Enclose |p - A_c| for p in a box (>= 3, 2)."""
    slo, shi = 0.0, 0.0
    for j in range(3):
        lo, hi = sub(box[j, 0], box[j, 1], exits[c, j, 0], exits[c, j, 1])
        lo, hi = sqr(lo, hi)
        slo, shi = add(slo, shi, lo, hi)
    return sqrt(slo, shi)


@entry()
def report(
    cables: Any,
    frame: Any,
    box: Any,
    tension: Any,
    states: Any,
    position: Any,
    height: Any,
    tensions: Any,
    distances: Any,
) -> None:
    """Turn a pose in the solver's units into the reported fields.

    Parameters
    ----------
    frame : (9, 2)
        Rows: unit of length (m), unit of force (N), A_0 minus the centre of mass (3 rows, m), up (3
        rows), height of A_0 (m). Both units are powers of two.
    box : (>= 3, 2)
        Pose relative to A_0.
    tension : (N, 2)
        Tensions in units of force.
    states : (N,)
        ``SLACK``, ``TAUT`` or ``OPEN``.
    position, height, tensions, distances : (3, 2), (2,), (N, 2), (N, 2)
        Written, m and N: platform origin, height of the centre of mass, tensions, distances.
    """
    elastic, exits, lengths, _, _ = cables
    unit = frame[0, 0]
    hlo, hhi = 0.0, 0.0
    for j in range(3):
        lo, hi = mul(unit, unit, box[j, 0], box[j, 1])
        position[j, 0], position[j, 1] = add(frame[2 + j, 0], frame[2 + j, 1], lo, hi)
        lo, hi = mul(lo, hi, frame[5 + j, 0], frame[5 + j, 1])
        hlo, hhi = add(hlo, hhi, lo, hi)
    height[0], height[1] = add(hlo, hhi, frame[8, 0], frame[8, 1])
    for c in range(lengths.shape[0]):
        lo, hi = distance(exits, c, box)
        if states[c] == TAUT and not elastic[c]:
            lo, hi = max(lo, lengths[c, 0]), min(hi, lengths[c, 1])
        distances[c, 0], distances[c, 1] = mul(unit, unit, lo, hi)
        distances[c, 0] = max(distances[c, 0], 0.0)
        tensions[c, 0], tensions[c, 1] = 0.0, 0.0
        if states[c] != SLACK:
            lo, hi = mul(frame[1, 0], frame[1, 1], tension[c, 0], tension[c, 1])
            tensions[c, 0], tensions[c, 1] = max(lo, 0.0), hi
