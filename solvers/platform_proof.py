"""From leaves of the search to proved roots, compiled: Newton starts, existence boxes, uniqueness boxes.

``find_roots`` is the one entry. A pose is completed to z = (u, p, t), improved in floats, enclosed in a
box that the Krawczyk operator maps strictly into itself, and given the largest uniqueness box of a
series. Only the entry calls the enclosures of cells: numba compiles what a function calls once more
with every function above it, and those are the largest.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.second_order import ROTATION_ONLY, WHOLE_POSE
from solvers import platform_newton as newton
from solvers import platform_pose as pose
from solvers import platform_turn as turn
from solvers.platform_model import HALF_TURNS

Floats = NDArray[np.float64]

NEWTON_STEPS = 40
FAR_OUT = 3.0
"""Newton may leave a chart's cube [-1, 1]^3; beyond this another chart finds the root better."""
INFLATIONS = 15
"""Rounds of epsilon-inflation before a candidate counts as not provable."""
REFINEMENTS = 3
"""Most Krawczyk steps after the proof; each contracts quadratically down to rounding."""
REFINED = 0.9
"""A refinement that leaves every side at least this share of its width is the last."""
LARGEST_REACH = 0.25
"""Half width in u of the largest uniqueness box tried; the others are this times powers of 1/2."""
FIRST_HALVING, LAST_HALVING = 3, 27
"""Power of 1/2 tried first, and the last one: below it rounding alone fills the box."""
LARGER = 0.51
"""Growth below which twice the reach may be provable: it doubles at least with the reach."""
ROD_WIDTH = 0.1
"""Widest box in u about a rod: the two kept moments then stay independent of the rod's direction."""
MARGIN = 0.1
"""Share by which a uniqueness box exceeds the enclosure it was made from."""
CLAIM = 3.0
"""A Newton start speaks for the other leaves within this many leaf sizes in u."""
REGULARISATION = 1e-13
"""Share of the trace added to the normal equations of the starting tensions: wrenches may be dependent."""
MOST_STARTS = 32
"""Newton starts in one call of ``find_roots``: some milliseconds, after which budgets are looked at."""


class System(NamedTuple):
    """A reduced square system as the kernels see it."""

    free: NDArray[np.int64]
    """(4, m) the free unknowns of z by chart."""
    frozen: NDArray[np.bool_]
    """(4, 3) entries of u that are exactly 0."""
    rows: Floats
    """(k, 6) kept combinations of the statics equations; with ``rod`` the last two are filled in."""
    rod: bool
    """The kept moments are the two across the platform's z axis."""
    tensions: bool
    """The tensions are unknowns."""


class Bench(NamedTuple):
    """Scratch and results of ``find_roots``."""

    forms: Floats
    wide_forms: Floats
    work: Floats
    charts: NDArray[np.int64]
    """(capacity,) charts of the roots known; those found are appended."""
    unique: Floats
    """(capacity, 6 + n, 2) their uniqueness boxes."""
    boxes: Floats
    """(capacity, 6 + n, 2) boxes of the roots found."""
    cores: Floats
    """(capacity, 6 + n, 2) the zeros for one choice of the lengths."""


@njit("void(f8[:, ::1], f8[:, ::1])", cache=True, nogil=True)
def copy(a: Any, out: Any) -> None:
    """Copy bounds (k, 2); numba takes seconds to compile the checks of a slice's assignment."""
    for k in range(a.shape[0]):
        out[k, 0] = a[k, 0]
        out[k, 1] = a[k, 1]


@njit(cache=True, nogil=True)
def rotation_at(u: Any, chart: int, R: Any) -> None:
    """Write R(u) D_c (3, 3) in floats."""
    square = u[0] * u[0] + u[1] * u[1] + u[2] * u[2]
    g = 2.0 / (1.0 + square)
    for i in range(3):
        for j in range(3):
            if i == j:
                value = 1.0 + g * (u[i] * u[i] - square)
            elif (j - i) % 3 == 1:
                value = g * (u[i] * u[j] - u[3 - i - j])
            else:
                value = g * (u[i] * u[j] + u[3 - i - j])
            R[i, j] = value * HALF_TURNS[chart, j]


@njit(cache=True, nogil=True)
def centre_at(model: Any, chart: int, R: Any, i: int, out: Any) -> None:
    """Write the centre c_i = A_i - R b_i of a taut cable's sphere, in floats."""
    for k in range(3):
        out[k] = model.anchors[i, k]
        for c in range(3):
            # The half turns are in R already.
            out[k] -= R[k, c] * model.points[0, i, c]


@njit(cache=True, nogil=True)
def leaf_pose(model: Any, system: Any, leaf: Any, in_position: bool, z: Any) -> None:
    """Write u and p at the middle of a leaf to z, in floats; what the reduction fixes becomes exactly 0."""
    chart = int(leaf[pose.P_CHART if in_position else turn.CHART])
    R = np.empty((3, 3))
    first, second, third = np.empty(3), np.empty(3), np.zeros(3)
    for k in range(3):
        z[k] = 0.5 * (leaf[2 * k] + leaf[2 * k + 1])
    rotation_at(z, chart, R)
    order = 0 if in_position else int(leaf[turn.ORDER])
    i = model.orders[order, 0]
    centre_at(model, chart, R, i, first)
    if in_position:
        for k in range(3):
            z[3 + k] = first[k] + 0.5 * (leaf[6 + 2 * k] + leaf[7 + 2 * k])
    else:
        j = model.orders[order, 1]
        centre_at(model, chart, R, j, second)
        k2, k3 = model.lengths_sq[i] - model.lengths_sq[j], 0.0
        if model.planar:
            third[1] = 1.0
        else:
            j = model.orders[order, 2]
            centre_at(model, chart, R, j, third)
            k3 = model.lengths_sq[i] - model.lengths_sq[j]
            for k in range(3):
                third[k] -= first[k]
                k3 += third[k] * third[k]
        for k in range(3):
            second[k] -= first[k]
            k2 += second[k] * second[k]
        branch_position(second, third, 0.5 * k2, 0.5 * k3, model.lengths_sq[i], leaf[turn.BRANCH], z)
        for k in range(3):
            z[3 + k] += first[k]
    for k in range(3):
        if system.frozen[chart, k]:
            z[k] = 0.0
    if model.planar:
        z[4] = 0.0


@njit(cache=True, nogil=True)
def branch_position(a: Any, b: Any, k2: float, k3: float, square: float, branch: float, z: Any) -> None:
    """Write x with a . x = k2, b . x = k3, |x|^2 = square on the side ``branch`` of a x b to z[3:6]."""
    m = np.empty(3)
    for k in range(3):
        m[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]
    mm = max(m[0] * m[0] + m[1] * m[1] + m[2] * m[2], 1e-300)
    foot = 0.0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        x = (k2 * (b[i] * m[j] - b[j] * m[i]) + k3 * (m[i] * a[j] - m[j] * a[i])) / mm
        z[3 + k] = x
        foot += x * x
    height = branch * math.sqrt(max(square - foot, 0.0) / mm)
    for k in range(3):
        z[3 + k] += height * m[k]


@njit(cache=True, nogil=True)
def starting_tensions(model: Any, chart: int, z: Any) -> None:
    """Write t that balance the load best to z[6:], in floats (least squares by normal equations)."""
    n = model.n_taut
    R = np.empty((3, 3))
    rotation_at(z, chart, R)
    c = np.empty(3)
    wrenches = np.empty((n, 6))
    a = np.zeros((n, n + 1))
    trace = 0.0
    for i in range(n):
        centre_at(model, chart, R, i, c)
        for k in range(3):
            wrenches[i, k] = c[k] - z[3 + k]
        for k in range(3):
            p, q = (k + 1) % 3, (k + 2) % 3
            arm_p, arm_q = model.anchors[i, p] - c[p], model.anchors[i, q] - c[q]
            wrenches[i, 3 + k] = (arm_p * wrenches[i, q] - arm_q * wrenches[i, p]) / model.size
        for j in range(i + 1):
            for k in range(6):
                a[i, j] += wrenches[i, k] * wrenches[j, k]
            a[j, i] = a[i, j]
        trace += a[i, i]
        for k in range(3):
            a[i, n] -= wrenches[i, k] * model.load[k]
    for i in range(n):
        a[i, i] += REGULARISATION * trace
    solved = solve_in_place(a, n, 1)
    for i in range(n):
        z[6 + i] = a[i, n] if solved else 0.0


@njit(cache=True, nogil=True)
def statics_rows(system: Any, chart: int, z: Any, rows: Any) -> None:
    """Write the kept combinations of the statics equations near the pose z."""
    for i in range(rows.shape[0]):
        for k in range(6):
            rows[i, k] = system.rows[i, k]
    if not system.rod:
        return
    R = np.empty((3, 3))
    rotation_at(z, chart, R)
    # Two unit vectors across the axis (the third column).
    least = 0
    for k in range(3):
        if abs(R[k, 2]) < abs(R[least, 2]):
            least = k
    norm = 0.0
    for k in range(3):
        x = (1.0 if k == least else 0.0) - R[least, 2] * R[k, 2]
        rows[3, 3 + k] = x
        norm += x * x
    for k in range(3):
        rows[3, 3 + k] /= math.sqrt(norm)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        rows[4, 3 + k] = R[i, 2] * rows[3, 3 + j] - R[j, 2] * rows[3, 3 + i]


@njit(cache=True, nogil=True)
def existence_box(model: Any, chart: int, rows: Any, free: Any, C: Any, z: Any, f: Any, box: Any) -> bool:
    """Grow a box around z until the Krawczyk operator maps it strictly into itself, and contract it.

    ``f`` (m, 2) are the residuals at z.

    Guarantee: where True is returned, ``box`` (6 + n, 2) holds exactly one zero for every choice of data.
    """
    m = free.shape[0]
    image = np.empty(box.shape)
    most = 0.0
    for k in range(z.shape[0]):
        box[k, 0] = z[k]
        box[k, 1] = z[k]
        if k < 6:
            most = max(most, abs(z[k]))
    for i in range(m):
        radius = 0.0
        for j in range(m):
            radius += abs(C[i, j]) * max(abs(f[j, 0]), abs(f[j, 1]))
        image[free[i], 0] = z[free[i]] - radius
        image[free[i], 1] = z[free[i]] + radius
    proved = False
    for step in range(INFLATIONS + REFINEMENTS):
        if step >= INFLATIONS and not proved:
            return False
        if not proved:
            for i in range(m):
                k = free[i]
                if not (image[k, 1] - image[k, 0] < math.inf):
                    return False
                slack = MARGIN * (image[k, 1] - image[k, 0]) + 1e-15 * (abs(z[k]) + most)
                box[k, 0] = image[k, 0] - slack
                box[k, 1] = image[k, 1] + slack
        inside = newton.krawczyk(model, chart, rows, free, C, box, image)
        if not (proved or inside):
            continue
        # The zero lies in the box and, once that is proved, in every image.
        smaller = not proved
        proved = True
        for i in range(m):
            k = free[i]
            lo, hi = max(box[k, 0], image[k, 0]), min(box[k, 1], image[k, 1])
            smaller = smaller or hi - lo < REFINED * (box[k, 1] - box[k, 0])
            box[k, 0] = lo
            box[k, 1] = hi
        if not smaller:
            return True
    return proved


@njit(cache=True, nogil=True)
def cell_around(system: Any, model: Any, chart: int, box: Any, reach: float, cell: Any) -> None:
    """Write a cell in u of half width ``reach`` around a proved box, on the branch of its middle."""
    cell[:] = 0.0
    u, R = np.empty(3), np.empty((3, 3))
    for k in range(3):
        pad = 0.0 if system.frozen[chart, k] else reach
        cell[2 * k] = box[k, 0] - pad
        cell[2 * k + 1] = box[k, 1] + pad
        u[k] = 0.5 * (box[k, 0] + box[k, 1])
    rotation_at(u, chart, R)
    first, second, third = np.empty(3), np.empty(3), np.zeros(3)
    order = model.orders[0]
    centre_at(model, chart, R, order[0], first)
    centre_at(model, chart, R, order[1], second)
    if model.planar:
        third[1] = 1.0
    else:
        centre_at(model, chart, R, order[2], third)
        for k in range(3):
            third[k] -= first[k]
    side = 0.0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        x = 0.5 * (box[3 + k, 0] + box[3 + k, 1]) - first[k]
        side += x * ((second[i] - first[i]) * third[j] - (second[j] - first[j]) * third[i])
    cell[turn.CHART] = chart
    cell[turn.BRANCH] = 1.0 if side >= 0.0 else -1.0


@njit(cache=True, nogil=True)
def wide_cell_around(system: Any, model: Any, chart: int, box: Any, reach: float, cell: Any) -> None:
    """Write a cell in (u, x) of half width ``reach`` (times the platform's size) around a proved box."""
    cell[:] = 0.0
    u, R, first = np.empty(3), np.empty((3, 3)), np.empty(3)
    for k in range(3):
        pad = 0.0 if system.frozen[chart, k] else reach
        cell[2 * k] = box[k, 0] - pad
        cell[2 * k + 1] = box[k, 1] + pad
        u[k] = 0.5 * (box[k, 0] + box[k, 1])
    rotation_at(u, chart, R)
    centre_at(model, chart, R, model.orders[0, 0], first)
    for k in range(3):
        pad = 0.0 if k == 1 and model.planar else reach * model.size
        x = 0.5 * (box[3 + k, 0] + box[3 + k, 1]) - first[k]
        cell[6 + 2 * k] = x - pad
        cell[7 + 2 * k] = x + pad
    cell[pose.P_CHART] = chart


@njit(cache=True, nogil=True)
def widened(box: Any, lo: Any, hi: Any, free: Any, out: Any) -> None:
    """Write the hull of a proved box and an enclosure, with a margin, in the free unknowns."""
    copy(box, out)
    for i in range(free.shape[0]):
        k = free[i]
        low, high = min(lo[k], box[k, 0]), max(hi[k], box[k, 1])
        grow = MARGIN * (high - low)
        out[k, 0] = low - grow
        out[k, 1] = high + grow


@njit(cache=True, nogil=True)
def known(bench: Any, count: int, chart: int, lo: Any, hi: Any) -> bool:
    """Return True when the box [lo, hi] lies in a known uniqueness box of this chart."""
    for r in range(count):
        inside = bench.charts[r] == chart
        for k in range(lo.shape[0]):
            inside = inside and bench.unique[r, k, 0] <= lo[k] and hi[k] <= bench.unique[r, k, 1]
        if inside:
            return True
    return False


@njit(cache=True, nogil=True)
def claim(leaves: Any, todo: Any, k: int, chart: int, branch: int, reach: float) -> None:
    """Strike leaf k and those it speaks for off the list; ``branch`` is its column, -1 for none."""
    for i in range(k, leaves.shape[0]):
        near = todo[i] and leaves[i, chart] == leaves[k, chart]
        near = near and (branch < 0 or leaves[i, branch] == leaves[k, branch])
        for c in range(3):
            apart = leaves[i, 2 * c] + leaves[i, 2 * c + 1] - leaves[k, 2 * c] - leaves[k, 2 * c + 1]
            near = near and 0.5 * abs(apart) <= reach
        if near:
            todo[i] = False


@njit("i8(i8, i8, f8)", cache=True, nogil=True)
def next_halving(halving: int, proved: int, growth: float) -> int:
    """Return which power of 1/2 to try after ``halving`` gave this growth; -1 when the search is over.

    ``proved`` is the smallest power proved so far, -1 for none. The growth at least doubles with the reach.
    """
    if growth < 1.0:
        return halving - 1 if growth < LARGER else -1
    if proved >= 0 or halving == LAST_HALVING:
        return -1
    steps = 1
    while steps < 8 and growth < math.inf and growth > 2.0**steps:
        steps += 1
    return min(halving + steps, LAST_HALVING)


@njit(cache=True, nogil=True)
def find_roots(
    model: Any,
    one_choice: Any,
    system: Any,
    bench: Any,
    count: int,
    leaves: Any,
    todo: Any,
    first: int,
    in_position: bool,
    leaf_size: float,
) -> tuple[int, int]:
    """Start Newton from leaves spread over each cluster and prove what it finds.

    Parameters
    ----------
    model, one_choice
        The model, and the same with its lengths' squares exact.
    bench
        Its first ``count`` rows hold the roots known.
    leaves, todo : (L, width), (L,)
        Leaves of one round, and those no start has spoken for; struck off here.
    first
        The leaf to go on with.

    Returns
    -------
    next, count
        The leaf to go on with (L: none is left) after at most ``MOST_STARTS`` starts, and the number
        of roots known then.

    Guarantee
    ---------
    Each root appended is proved: for every choice of data exactly one zero in its box, none other in its
    uniqueness box, and it is not one of the roots known before.
    """
    chart_column = pose.P_CHART if in_position else turn.CHART
    branch_column = -1 if in_position else turn.BRANCH
    z = np.empty(6 + model.n_taut)
    lo, hi = np.empty(z.shape[0]), np.empty(z.shape[0])
    trial, m = np.empty((z.shape[0], 2)), system.free.shape[1]
    rows, f = np.empty(system.rows.shape), np.empty((m, 2))
    J, C = np.empty((m, m, 2)), np.empty((m, m))
    cell, wide_cell = np.empty(turn.WIDTH), np.empty(pose.P_WIDTH)
    ranges = False
    for i in range(model.n_taut):
        ranges = ranges or model.lengths[i, 0] < model.lengths[i, 1]
    starts = 0
    for k in range(first, leaves.shape[0]):
        if not todo[k]:
            continue
        if starts == MOST_STARTS:
            return k, count
        starts += 1
        claim(leaves, todo, k, chart_column, branch_column, CLAIM * leaf_size)
        chart = int(leaves[k, chart_column])
        free = system.free[chart]
        leaf_pose(model, system, leaves[k], in_position, z)
        z[6:] = 0.0
        if system.tensions:
            starting_tensions(model, chart, z)
        statics_rows(system, chart, z, rows)
        if not newton.newton(model, chart, rows, free, z, NEWTON_STEPS):
            continue
        if max(abs(z[0]), abs(z[1]), abs(z[2])) >= FAR_OUT or known(bench, count, chart, z, z):
            continue
        statics_rows(system, chart, z, rows)
        box, core, unique = bench.boxes[count], bench.cores[count], bench.unique[count]
        for i in range(z.shape[0]):
            box[i, 0] = z[i]
            box[i, 1] = z[i]
        newton.jacobian_over(model, chart, rows, free, box, f, J)
        if not newton.inverse_at(J, C) or not np.isfinite(C).all():
            continue
        if not existence_box(model, chart, rows, free, C, z, f, box):
            continue
        widest = 0.0
        for i in range(3):
            widest = max(widest, box[i, 1] - box[i, 0])
        if system.rod and widest > ROD_WIDTH:
            continue
        halving, proved = FIRST_HALVING, -1
        while halving >= 0:
            reach = LARGEST_REACH * 0.5**halving
            cell_around(system, model, chart, box, reach, cell)
            bounded = turn.enclose_cell(bench.forms, bench.work, model, cell, ROTATION_ONLY, lo, hi)
            if not bounded:
                wide_cell_around(system, model, chart, box, reach, wide_cell)
                bounded = pose.enclose_cell(
                    bench.wide_forms, bench.work, model, wide_cell, WHOLE_POSE, lo, hi
                )
            growth = math.inf
            if bounded:
                widened(box, lo, hi, free, trial)
                growth = newton.growth(model, chart, rows, free, C, trial)
            if growth < 1.0:
                proved = halving
                copy(trial, unique)
            halving = next_halving(halving, proved, growth)
        if proved < 0:
            continue
        # One choice of the lengths: a smaller box, to tell roots apart by.
        narrower = False
        if ranges:
            for i in range(z.shape[0]):
                core[i, 0] = z[i]
                core[i, 1] = z[i]
            newton.residual_at(one_choice, chart, rows, free, core, f)
            narrower = existence_box(one_choice, chart, rows, free, C, z, f, core)
        if not narrower:
            copy(box, core)
        for i in range(z.shape[0]):
            lo[i] = core[i, 0]
            hi[i] = core[i, 1]
        if not known(bench, count, chart, lo, hi):
            bench.charts[count] = chart
            count += 1
    return leaves.shape[0], count
