"""The pose of a point mass on routed cables in one compiled call, proved to be the only one.

Arrays: those of `solvers.routed_mass.balance` and `solvers.routed_mass.cells`; ``lengths`` (N, 2)
in m; ``bounds`` (4 + 2 N, 2) and ``states`` (N,) as `solvers.point_mass.one_call.balls_pose` has them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr_interval.kernels.interval import add, div, mul, sqr, sqrt
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.mechanics.cables.rows import LENGTH, WAY
from solvers.point_mass.cell_rows import WIDTH
from solvers.point_mass.fields import OPEN, SLACK, TAUT
from solvers.point_mass.one_call import DECIDED, UNCLEAR, anywhere
from solvers.routed_mass.balance import is_off, off_pulleys, prove_balance, pull, survey
from solvers.routed_mass.cells import all_beyond, first_cells, is_beyond, run_cells
from solvers.routed_mass.guess import guess

AMONG_OTHERS = 3
"""Status: the pose is proved, whether there is another one is not."""
QUICK_CELLS = 2_000
"""Cells of the search for other poses within one call: milliseconds; a dozen cells are usual."""
QUICK_ROWS = 512
"""Of its stack."""
SMALLEST = 1e-3
"""Smallest width of a cell in the kernels' units: what is left then is looked at outside of the call."""


@entry()
def springs_of(elastic: Any, constant: Any, given: Any, lengths: Any) -> Any:
    """Enclose the spring constants (N, 2), zero for inextensible cables, in the kernels' units."""
    k = np.zeros(lengths.shape)
    for i in range(lengths.shape[0]):
        if not elastic[i]:
            continue
        if constant[i]:
            k[i, 0], k[i, 1] = given[i, 0], given[i, 1]
        else:
            k[i, 0], k[i, 1] = div(given[i, 0], given[i, 1], lengths[i, 0], lengths[i, 1])
            k[i, 0] = max(k[i, 0], 0.0)
    return k


@entry()
def classify(data: Any, taut: Any, m: int, box: Any, states: Any, tension: Any, distance: Any) -> bool:
    """Decide the states (N,) of cables at a zero (3 + m, 2), with tensions and lengths of ways (N, 2).

    False: an inextensible cable that is to carry may not, one that is to be slack may be too short, or the
    zero may lie inside the pulley of a slack cable.
    """
    _, elastic, lengths, _, _ = data
    count = states.shape[0]
    ways, gradients = np.empty((count, WAY, 2)), np.empty((count, 3, 2))
    if not survey(data, box, ways, gradients) or not off_pulleys(data, ways):
        return False
    held = True
    for i in range(count):
        distance[i, 0], distance[i, 1] = ways[i, LENGTH, 0], ways[i, LENGTH, 1]
        states[i] = SLACK
        tension[i, 0], tension[i, 1] = 0.0, 0.0
        if elastic[i]:
            lo, hi, weight, _ = pull(data, i, ways[i])
            tension[i, 0], tension[i, 1] = lo, hi
            if hi > 0.0:
                states[i] = TAUT if weight == 1.0 else OPEN
        elif not distance[i, 1] < lengths[i, 0]:
            states[i] = OPEN
    for b in range(m):
        i = taut[b]
        states[i] = TAUT if box[3 + b, 0] > 0.0 else OPEN
        tension[i, 0], tension[i, 1] = max(box[3 + b, 0], 0.0), box[3 + b, 1]
        distance[i, 0], distance[i, 1] = (
            max(distance[i, 0], lengths[i, 0]),
            min(distance[i, 1], lengths[i, 1]),
        )
    for i in range(count):
        held = held and (elastic[i] or states[i] != OPEN)
    return held


@entry()
def fill(frame: Any, box: Any, tension: Any, distance: Any, bounds: Any) -> None:
    """Write the fields (4 + 2 N, 2) of a pose (>= 3, 2), tensions and lengths of ways (N, 2), in m and N."""
    count = tension.shape[0]
    unit = frame[0, 0]
    hlo, hhi = 0.0, 0.0
    for j in range(3):
        lo, hi = mul(unit, unit, box[j, 0], box[j, 1])
        bounds[j, 0], bounds[j, 1] = add(frame[2 + j, 0], frame[2 + j, 1], lo, hi)
        lo, hi = mul(lo, hi, frame[5 + j, 0], frame[5 + j, 1])
        hlo, hhi = add(hlo, hhi, lo, hi)
    bounds[3, 0], bounds[3, 1] = add(hlo, hhi, frame[8, 0], frame[8, 1])
    for i in range(count):
        lo, hi = mul(frame[1, 0], frame[1, 1], tension[i, 0], tension[i, 1])
        bounds[4 + i, 0], bounds[4 + i, 1] = max(lo, 0.0), hi if tension[i, 1] > 0.0 else 0.0
        lo, hi = mul(unit, unit, distance[i, 0], distance[i, 1])
        bounds[4 + count + i, 0], bounds[4 + count + i, 1] = max(lo, 0.0), hi


@kernel()
def leaves_outward(data: Any, box: Any) -> bool:
    """Return True when every cable is straight, leaves outward or hangs loose on a box (>= 3, 2)."""
    count = data[1].shape[0]
    ways, gradients = np.empty((count, WAY, 2)), np.empty((count, 3, 2))
    return survey(data, box, ways, gradients) and all_beyond(data, box[:3], ways)


@entry()
def is_outward(data: Any, box: Any) -> bool:
    """Return what `leaves_outward` does."""
    return leaves_outward(data, box)


@entry()
def others_outward(data: Any, box: Any, cable: int) -> bool:
    """Return what `leaves_outward` does of all cables but one."""
    count = data[1].shape[0]
    ways, gradients = np.empty((count, WAY, 2)), np.empty((count, 3, 2))
    if not survey(data, box, ways, gradients):
        return False
    for i in range(count):  # noqa: SIM110 - numba compiles no generator expressions
        if i != cable and not is_beyond(data, i, box, ways[i]):
            return False
    return True


@kernel()
def only_one(data: Any, taut: Any, box: Any, domain: Any) -> bool:
    """Prove that the pose in a box (3 + m, 2), alone in its domain, with m taut cables, is the only one."""
    context = (data, leaves_outward(data, box), taut, domain, -1, SMALLEST)
    stack, leaves = np.empty((QUICK_ROWS + data[1].shape[0], WIDTH)), np.empty((1, WIDTH))
    kinds, children = np.empty(1, dtype=np.int64), np.empty((4, WIDTH))
    count = first_cells(data, context[1], stack)
    count, found, _ = run_cells(context, stack, count, leaves, kinds, children, QUICK_CELLS)
    return count == 0 and found == 0


@entry()
def ways_at(data: Any, box: Any, distance: Any) -> bool:
    """Write the lengths of ways (N, 2) over a box (3, 2)."""
    count = data[1].shape[0]
    ways, gradients = np.empty((count, WAY, 2)), np.empty((count, 3, 2))
    if not survey(data, box, ways, gradients):
        return False
    for i in range(count):
        distance[i, 0], distance[i, 1] = ways[i, LENGTH, 0], ways[i, LENGTH, 1]
    return True


@entry()
def slack_around(data: Any, box: Any, cable: int, distance: Any) -> bool:
    """Return True when all cables but one are slack on a box (3, 2) outside of their pulleys.

    Lengths of ways (N, 2) are written.
    """
    count = data[1].shape[0]
    ways, gradients = np.empty((count, WAY, 2)), np.empty((count, 3, 2))
    if not survey(data, box, ways, gradients):
        return False
    for i in range(count):
        distance[i, 0], distance[i, 1] = ways[i, LENGTH, 0], ways[i, LENGTH, 1]
        if i == cable:
            continue
        if not distance[i, 1] < data[2][i, 0] or not is_off(data[0][i], ways[i]):
            return False
    return True


@entry()
def strength(data: Any) -> Any:
    """Enclose the load's size, (2,)."""
    found = np.empty(2)
    slo, shi = 0.0, 0.0
    for j in range(3):
        lo, hi = sqr(data[4][j, 0], data[4][j, 1])
        slo, shi = add(slo, shi, lo, hi)
    found[0], found[1] = sqrt(slo, shi)
    return found


@entry()
def data_of(
    routes: Any, elastic: Any, constant: Any, given: Any, load: Any, unit: float, lengths: Any
) -> Any:
    """Return the `solvers.routed_mass.data.Routed` for lengths (N, 2) in m."""
    scaled = np.empty(lengths.shape)
    for i in range(lengths.shape[0]):
        scaled[i, 0], scaled[i, 1] = lengths[i, 0] / unit, lengths[i, 1] / unit
    return routes, elastic, scaled, springs_of(elastic, constant, given, scaled), load


@entry()
def routed_pose(
    routes: Any,
    elastic: Any,
    constant: Any,
    given: Any,
    load: Any,
    frame: Any,
    lengths: Any,
    bounds: Any,
    states: Any,
) -> int:
    """Find the static pose and prove that it is the only one.

    Parameters
    ----------
    routes, elastic, constant, given, load, frame
        See `solvers.routed_mass.data.RoutedMass`.
    lengths : (N, 2)
        m.
    bounds, states : (4 + 2 N, 2), (N,)
        Written when DECIDED or AMONG_OTHERS.

    Returns
    -------
    int
        ``DECIDED``, ``AMONG_OTHERS`` or ``UNCLEAR``.

    Guarantee
    ---------
    DECIDED: for all data in their ranges there is exactly one static pose, and ``bounds`` encloses it; cables
    in state ``TAUT`` carry tension, those ``SLACK`` none, of elastic ones that are ``OPEN`` it is not known.
    AMONG_OTHERS: the same, but there may be more poses.
    """
    data = data_of(routes, elastic, constant, given, load, frame[0, 0], lengths)
    count = lengths.shape[0]
    taut, x = np.empty(count + 1, dtype=np.int64), np.empty(4 + count)
    m = guess(data, taut, x)
    if m < 0:
        return UNCLEAR
    box, domain = np.empty((3 + m, 2)), np.empty((3 + m, 2))
    if not prove_balance(data, taut, x[: 3 + m], anywhere(3 + m), box, domain):
        return UNCLEAR
    tension, distance = np.empty((count, 2)), np.empty((count, 2))
    if not classify(data, taut, m, box, states, tension, distance):
        return UNCLEAR
    fill(frame, box, tension, distance, bounds)
    return DECIDED if only_one(data, taut[:m], box, domain) else AMONG_OTHERS
