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

from cdpr_interval.engine.scratch import Scratch
from cdpr_interval.mechanics.six_dof import system as newton
from solvers.six_dof import pose_cells as pose
from solvers.six_dof import rotation_cells as turn
from solvers.six_dof.columns import POSE_COLUMNS, ROTATION_COLUMNS
from solvers.six_dof.starts import across_rod, claim, leaf_pose, starting_tensions, triple_at

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
ROUNDING = 1e-15
"""Relative width of a length's bounds up to which it is one number, not a range."""
FEW_LEAVES = 64
"""So many leaves are looked at once more where the roots are found: cheaper than one more round of search."""
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

    turn: Scratch
    """For cells in u."""
    pose: Scratch
    """For cells in (u, x)."""
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


@njit(
    "b1(f8[:, :, ::1], f8[:, ::1], i8[::1], f8[:, ::1], f8[::1], f8[:, ::1], b1, f8[:, ::1])",
    cache=True,
    nogil=True,
)
def existence_box(data: Any, rows: Any, free: Any, C: Any, z: Any, f: Any, ranges: bool, box: Any) -> bool:
    """Grow a box around z until the Krawczyk operator maps it strictly into itself, and contract it.

    ``f`` (m, 2) are the residuals at z; without ``ranges`` of the data, only rounding is left after one step.

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
        inside = newton.krawczyk(data, rows, free, C, box, image)
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
        if not (smaller and ranges):
            return True
    return proved


@njit("f8(f8[:, ::1], f8[:, ::1], f8[::1])", cache=True, nogil=True)
def middle_position(box: Any, triple: Any, x: Any) -> float:
    """Write x = p - c_1 at the middle of a box; return x . (d_2 x d_3) there, whose sign is the branch."""
    side = 0.0
    for k in range(3):
        x[k] = 0.5 * (box[3 + k, 0] + box[3 + k, 1]) - triple[0, k]
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        side += x[k] * (triple[1, i] * triple[2, j] - triple[1, j] * triple[2, i])
    return side


@njit("void(f8[:, ::1], b1[::1], f8, f8[::1])", cache=True, nogil=True)
def sides_around(box: Any, frozen: Any, reach: float, cell: Any) -> None:
    """Write the bounds of u within ``reach`` of a box to a cell, all its other entries zero."""
    cell[:] = 0.0
    for k in range(3):
        pad = 0.0 if frozen[k] else reach
        cell[2 * k] = box[k, 0] - pad
        cell[2 * k + 1] = box[k, 1] + pad


@njit("void(f8[:, ::1], f8[::1], f8[::1], i8[::1], f8, f8, f8[:, ::1])", cache=True, nogil=True)
def widened(box: Any, lo: Any, hi: Any, free: Any, reach: float, size: float, out: Any) -> None:
    """Write the hull of a proved box and an enclosure, with a margin, in the free unknowns.

    The margin is at least a share of what ``reach`` in u moves the platform (of this size) and the tensions:
    near a fold the poses hardly differ in height, and a box that flat would hold no cell.
    """
    copy(box, out)
    most = 0.0
    for k in range(6, lo.shape[0]):
        most = max(most, abs(lo[k]), abs(hi[k]))
    for i in range(free.shape[0]):
        k = free[i]
        low, high = min(lo[k], box[k, 0]), max(hi[k], box[k, 1])
        scale = 1.0 if k < 3 else (size if k < 6 else most)
        grow = MARGIN * max(high - low, reach * scale)
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
    system: Any,
    bench: Any,
    count: int,
    leaves: Any,
    todo: Any,
    first: int,
    columns: Any,
    leaf_size: float,
) -> tuple[int, int]:
    """Start Newton from leaves spread over each cluster and prove what it finds.

    Parameters
    ----------
    bench
        Its first ``count`` rows hold the roots known.
    leaves, todo : (L, width), (L,)
        Leaves of one round, and those no start has spoken for; struck off here. When all are, those left to
        be searched: leaves whose equilibria do not all lie in one root's uniqueness box.
    first
        The leaf to go on with.
    columns
        The leaves' ``Columns``.

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
    in_position = columns.variables > 3
    z = np.empty(6 + model.n_taut)
    lo, hi = np.empty(z.shape[0]), np.empty(z.shape[0])
    trial, m = np.empty((z.shape[0], 2)), system.free.shape[1]
    rows, f = np.empty(system.rows.shape), np.empty((m, 2))
    J, C = np.empty((m, m, 2)), np.empty((m, m))
    data, triple, x = np.empty((model.n_taut + 1, 7, 2)), np.empty((3, 3)), np.empty(3)
    cell, wide_cell = np.empty(ROTATION_COLUMNS.width), np.empty(POSE_COLUMNS.width)
    ranges = False
    for i in range(model.n_taut):
        ranges = ranges or model.lengths[i, 1] - model.lengths[i, 0] > ROUNDING * model.lengths[i, 1]
    starts = 0
    for k in range(first, leaves.shape[0]):
        if not todo[k]:
            continue
        if starts == MOST_STARTS:
            return k, count
        starts += 1
        claim(leaves, todo, k, columns.chart, columns.branch, CLAIM * leaf_size)
        chart = int(leaves[k, columns.chart])
        free, frozen = system.free[chart], system.frozen[chart]
        newton.fill_data(model, chart, data)
        leaf_pose(data, model.orders[0], model.planar, leaves[k], in_position, frozen, z)
        z[6:] = 0.0
        if system.tensions:
            starting_tensions(data, model.size, z)
        for i in range(rows.shape[0]):
            for j in range(6):
                rows[i, j] = system.rows[i, j]
        if system.rod:
            across_rod(z[:3], rows)
        if not newton.newton(data, rows, free, z, C, NEWTON_STEPS):
            continue
        if max(abs(z[0]), abs(z[1]), abs(z[2])) >= FAR_OUT or known(bench, count, chart, z, z):
            continue
        if system.rod:
            across_rod(z[:3], rows)
        box, core, unique = bench.boxes[count], bench.cores[count], bench.unique[count]
        for i in range(z.shape[0]):
            box[i, 0] = z[i]
            box[i, 1] = z[i]
        newton.jacobian_over(data, rows, free, box, f, J)
        if not newton.inverse_at(J, C) or not np.isfinite(C).all():
            continue
        if not existence_box(data, rows, free, C, z, f, ranges, box):
            continue
        widest = 0.0
        for i in range(3):
            widest = max(widest, box[i, 1] - box[i, 0])
        if system.rod and widest > ROD_WIDTH:
            continue
        triple_at(data, model.orders[0], model.planar, z[:3], triple)
        branch = 1.0 if middle_position(box, triple, x) >= 0.0 else -1.0
        halving, proved = FIRST_HALVING, -1
        while halving >= 0:
            reach = LARGEST_REACH * 0.5**halving
            sides_around(box, frozen, reach, cell)
            cell[ROTATION_COLUMNS.chart], cell[ROTATION_COLUMNS.branch] = chart, branch
            bounded = turn.enclose_cell(bench.turn, model, cell, lo, hi)
            if not bounded:
                sides_around(box, frozen, reach, wide_cell)
                for i in range(3):
                    pad = 0.0 if i == 1 and model.planar else reach * model.size
                    wide_cell[6 + 2 * i], wide_cell[7 + 2 * i] = x[i] - pad, x[i] + pad
                wide_cell[POSE_COLUMNS.chart] = chart
                bounded = pose.enclose_cell(bench.pose, model, wide_cell, lo, hi)
            growth = math.inf
            if bounded:
                widened(box, lo, hi, free, reach, model.size, trial)
                growth = newton.growth(data, rows, free, C, trial)
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
            for i in range(model.n_taut):
                # One choice of the lengths: their squares in the middle of the ranges, exactly.
                data[i, 6, 0] = model.lengths_sq[i]
                data[i, 6, 1] = model.lengths_sq[i]
            newton.residual_at(data, rows, core, f)
            narrower = existence_box(data, rows, free, C, z, f, False, core)
        if not narrower:
            copy(box, core)
        for i in range(z.shape[0]):
            lo[i] = core[i, 0]
            hi[i] = core[i, 1]
        if not known(bench, count, chart, lo, hi):
            bench.charts[count] = chart
            count += 1
    for k in range(leaves.shape[0]):
        todo[k] = True
        if leaves.shape[0] > FEW_LEAVES:
            continue
        if in_position:
            for i in range(wide_cell.shape[0]):
                wide_cell[i] = leaves[k, i]
            bounded = pose.enclose_cell(bench.pose, model, wide_cell, lo, hi)
        else:
            for i in range(cell.shape[0]):
                cell[i] = leaves[k, i]
            bounded = turn.enclose_cell(bench.turn, model, cell, lo, hi)
        if bounded and known(bench, count, int(leaves[k, columns.chart]), lo, hi):
            todo[k] = False
    return leaves.shape[0], count
