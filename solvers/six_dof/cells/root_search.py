"""From leaves of the search to proved roots, compiled: Newton starts, existence boxes, uniqueness boxes.

``find_roots`` is the one entry. A pose is completed to z = (u, p, t), improved in floats, enclosed in a
box that the Krawczyk operator maps strictly into itself, and given the largest uniqueness box of a
series. Only the entry calls the enclosures of cells: numba compiles what a function calls once more
with every function above it, and those are the largest. ``from_leaves`` and ``largest_reach`` are the parts
that ``tube_search`` shares: what they are handed proves a zero, and how far it is the only one.

Arrays, for n taut cables and m equations: ``box`` (6 + n, 2) encloses (u, p, t), ``lo, hi`` (6 + n,) its
bounds; ``free`` (m,) a row of ``System.free``, ``frozen`` (3,) one of ``System.frozen``; ``cell`` (width,),
``leaves`` (L, width), ``todo`` (L,) those left of them; ``model`` is an ``arrays.Model``, ``system`` is a
``System``, ``bench`` is a ``Bench``, ``at`` is a ``Workplace``, ``columns`` are the ``Columns`` of the
leaves.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.krawczyk import preconditioner
from cdpr_interval.engine.scratch import Scratch
from cdpr_interval.kernels.box import copy, point
from cdpr_interval.kernels.kernel import entry, kernel, part
from cdpr_interval.mechanics.six_dof.system import (
    existence_box,
    fill_data,
    growth,
    improve,
    jacobian_over,
)
from solvers.six_dof.cells import pose_cells as pose
from solvers.six_dof.cells import rotation_cells as turn
from solvers.six_dof.cells.columns import POSE_COLUMNS, ROTATION_COLUMNS
from solvers.six_dof.cells.starts import across_rod, claim, leaf_pose, starting_tensions, triple_at

Floats = NDArray[np.float64]

NEWTON_STEPS = 40
FAR_OUT = 3.0
"""Newton may leave a chart's cube [-1, 1]^3; beyond this another chart finds the root better."""
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


class Workplace(NamedTuple):
    """One zero in the making, n taut cables and m equations."""

    z: Floats
    """(6 + n,) the zero in floats."""
    data: Floats
    """(n + 1, 7, 2) the numbers of the model, see ``system.fill_data``."""
    rows: Floats
    """(m - n, 6) the combinations of the statics equations."""
    f: Floats
    """(m, 2) residuals."""
    J: Floats
    """(m, m, 2) their derivatives."""
    C: Floats
    """(m, m) about the inverse of these."""
    lo: Floats
    """(6 + n,) lower bounds of a cell's equilibria."""
    hi: Floats
    """(6 + n,) upper bounds."""
    trial: Floats
    """(6 + n, 2) the uniqueness box that is tried."""


@entry("f8(f8[:, ::1], f8[:, ::1], f8[::1])")
def middle_position(box: Any, triple: Any, x: Any) -> float:
    """Write x = p - c_1 at the middle of a box; return x . (d_2 x d_3) there, whose sign is the branch.

    ``triple`` : (3, 3) as ``triple_at`` writes it; ``x`` : (3,).
    """
    side = 0.0
    for k in range(3):
        x[k] = 0.5 * (box[3 + k, 0] + box[3 + k, 1]) - triple[0, k]
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        side += x[k] * (triple[1, i] * triple[2, j] - triple[1, j] * triple[2, i])
    return side


@entry("void(f8[:, ::1], b1[::1], f8, f8[::1])")
def sides_around(box: Any, frozen: Any, reach: float, cell: Any) -> None:
    """Write the bounds of u within ``reach`` of a box to a cell, all its other entries zero."""
    cell[:] = 0.0
    for k in range(3):
        pad = 0.0 if frozen[k] else reach
        cell[2 * k] = box[k, 0] - pad
        cell[2 * k + 1] = box[k, 1] + pad


@entry("void(f8[:, ::1], f8[::1], f8[::1], i8[::1], f8, f8, f8[:, ::1])")
def widened(box: Any, lo: Any, hi: Any, free: Any, reach: float, size: float, out: Any) -> None:
    """Write the hull of a proved box and an enclosure, with a margin, to the free unknowns of out (6 + n, 2).

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


@kernel("b1(i8[::1], f8[:, :, ::1], i8, i8, f8[::1], f8[::1])")
def known(charts: Any, unique: Any, count: int, chart: int, lo: Any, hi: Any) -> bool:
    """Return True when the box [lo, hi] (6 + n,) lies in a uniqueness box of this chart.

    The first ``count`` of ``charts`` (r,) and ``unique`` (r, 6 + n, 2) are known.
    """
    for r in range(count):
        inside = charts[r] == chart
        for k in range(lo.shape[0]):
            inside = inside and unique[r, k, 0] <= lo[k] and hi[k] <= unique[r, k, 1]
        if inside:
            return True
    return False


@entry("i8(i8, i8, f8)")
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


@kernel("b1(f8[:, ::1])")
def finite(C: Any) -> bool:
    """Return True when all entries of C (m, m) are finite."""
    for i in range(C.shape[0]):
        for j in range(C.shape[1]):
            if not math.isfinite(C[i, j]):
                return False
    return True


@kernel("void(f8[:, ::1], f8[::1], f8[::1])")
def ends(box: Any, lo: Any, hi: Any) -> None:
    """Write the lower bounds lo (k,) and the upper bounds hi (k,) of a box (k, 2)."""
    for i in range(lo.shape[0]):
        lo[i] = box[i, 0]
        hi[i] = box[i, 1]


# Inlined, as the next ones: numba takes long to compile a function that takes a whole model, and what calls
# the enclosures of cells is compiled with them.
@part()
def seed(model: Any, system: Any, chart: int, leaf: Any, in_position: bool, at: Any) -> None:
    """Write the pose in the middle of a leaf (width,), tensions that go with it, and the system there."""
    fill_data(model, chart, at.data)
    leaf_pose(at.data, model.orders[0], model.planar, leaf, in_position, system.frozen[chart], at.z)
    for i in range(6, at.z.shape[0]):
        at.z[i] = 0.0
    if system.tensions:
        starting_tensions(at.data, model.size, at.z)
    for i in range(at.rows.shape[0]):
        for j in range(6):
            at.rows[i, j] = system.rows[i, j]
    if system.rod:
        across_rod(at.z[:3], at.rows)


@part()
def enclosed(system: Any, free: Any, at: Any, box: Any) -> bool:
    """Write a box (6 + n, 2) around the zero that holds exactly one; False where that is not proved."""
    if system.rod:
        across_rod(at.z[:3], at.rows)
    point(at.z, box)
    jacobian_over(at.data, at.rows, free, box, at.f, at.J)
    if not (preconditioner(at.J, at.C) and finite(at.C)):
        return False
    if not existence_box(at.data, at.rows, free, at.C, at.z, at.f, box):
        return False
    widest = 0.0
    for i in range(3):
        widest = max(widest, box[i, 1] - box[i, 0])
    return not (system.rod and widest > ROD_WIDTH)


@part()
def turn_bounds(model: Any, bench: Any, k: int, cell: Any, at: Any) -> bool:
    """Enclose (u, p, t) of every equilibrium in a cell in u (width,); False where t is not bounded."""
    return turn.enclose_cell(bench.turn, model, cell, at.lo, at.hi)


@part()
def pose_bounds(model: Any, bench: Any, k: int, cell: Any, at: Any) -> bool:
    """Enclose (u, p, t) of every equilibrium in a cell in (u, x) (width,); False where t is not bounded."""
    return pose.enclose_cell(bench.pose, model, cell, at.lo, at.hi)


@part()
def largest_reach(
    in_turn: Any,
    in_pose: Any,
    try_reach: Any,
    model: Any,
    system: Any,
    bench: Any,
    k: int,
    chart: int,
    at: Any,
    box: Any,
    share: float,
) -> bool:
    """Keep the largest neighbourhood of a series in which zero ``k`` is proved to be the only one.

    Parameters
    ----------
    in_turn, in_pose
        ``in_turn(model, bench, k, cell, at)`` bounds the equilibria of a cell in u in ``at``, or returns
        False; the other one those of a cell in (u, x).
    try_reach
        ``try_reach(model, system, bench, k, chart, at, reach)`` returns the growth over what these bounds and
        ``reach`` in u make of a neighbourhood; below 1 it has kept it.
    box : (6 + n, 2)
        Of the zero.
    share
        By which share of the box's width a cell in (u, x) is larger than by ``reach``.

    Returns
    -------
    bool
        False: nothing is proved.
    """
    triple, x = np.empty((3, 3)), np.empty(3)
    turn_cell, pose_cell = np.empty(ROTATION_COLUMNS.width), np.empty(POSE_COLUMNS.width)
    triple_at(at.data, model.orders[0], model.planar, at.z[:3], triple)
    branch = 1.0 if middle_position(box, triple, x) >= 0.0 else -1.0
    halving, proved = FIRST_HALVING, -1
    while halving >= 0:
        reach = LARGEST_REACH * 0.5**halving
        sides_around(box, system.frozen[chart], reach, turn_cell)
        turn_cell[ROTATION_COLUMNS.chart], turn_cell[ROTATION_COLUMNS.branch] = chart, branch
        bounded = in_turn(model, bench, k, turn_cell, at)
        if not bounded:
            sides_around(box, system.frozen[chart], reach, pose_cell)
            for i in range(3):
                pad = reach * model.size + share * (box[3 + i, 1] - box[3 + i, 0])
                if i == 1 and model.planar:
                    pad = 0.0
                pose_cell[6 + 2 * i], pose_cell[7 + 2 * i] = x[i] - pad, x[i] + pad
            pose_cell[POSE_COLUMNS.chart] = chart
            bounded = in_pose(model, bench, k, pose_cell, at)
        ratio = math.inf
        if bounded:
            ratio = try_reach(model, system, bench, k, chart, at, reach)
        if ratio < 1.0:
            proved = halving
        halving = next_halving(halving, proved, ratio)
    return proved >= 0


@part()
def try_box(model: Any, system: Any, bench: Any, k: int, chart: int, at: Any, reach: float) -> float:
    """Return the growth over the box of the last bounds; below 1 it is kept as uniqueness box."""
    widened(bench.boxes[k], at.lo, at.hi, system.free[chart], reach, model.size, at.trial)
    ratio = growth(at.data, at.rows, system.free[chart], at.C, at.trial)
    if ratio < 1.0:
        copy(at.trial, bench.unique[k])
    return ratio


@part()
def known_root(bench: Any, count: int, chart: int, z: Any) -> bool:
    """Return True when a point z (6 + n,) lies in a known root's uniqueness box."""
    return known(bench.charts, bench.unique, count, chart, z, z)


@part()
def prove_root(model: Any, system: Any, bench: Any, k: int, chart: int, at: Any) -> bool:
    """Write the root around the zero in ``at`` as root ``k``; False where none is proved, or it is known."""
    box = bench.boxes[k]
    if not enclosed(system, system.free[chart], at, box):
        return False
    if not largest_reach(turn_bounds, pose_bounds, try_box, model, system, bench, k, chart, at, box, 0.0):
        return False
    ends(box, at.lo, at.hi)
    if known(bench.charts, bench.unique, k, chart, at.lo, at.hi):
        return False
    bench.charts[k] = chart
    return True


@part()
def settled_by_root(model: Any, bench: Any, count: int, leaf: Any, columns: Any, at: Any) -> bool:
    """Return True when a leaf's equilibria all lie in the uniqueness box of one root known."""
    if columns.variables > 3:
        bounded = pose_bounds(model, bench, 0, leaf, at)
    else:
        bounded = turn_bounds(model, bench, 0, leaf, at)
    return bounded and known(bench.charts, bench.unique, count, int(leaf[columns.chart]), at.lo, at.hi)


@part()
def workplace(model: Any, system: Any) -> Any:
    """Return the arrays in which one zero after the other is found."""
    k, m = 6 + model.n_taut, system.free.shape[1]
    return Workplace(
        np.empty(k),
        np.empty((model.n_taut + 1, 7, 2)),
        np.empty(system.rows.shape),
        np.empty((m, 2)),
        np.empty((m, m, 2)),
        np.empty((m, m)),
        np.empty(k),
        np.empty(k),
        np.empty((k, 2)),
    )


@part()
def from_leaves(
    is_known: Any,
    prove: Any,
    settles: Any,
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
    is_known
        ``is_known(bench, count, chart, z)`` : whether z is one of the first ``count`` zeros of ``bench``.
    prove
        ``prove(model, system, bench, k, chart, at)`` writes the zero in ``at`` as zero ``k``, or returns
        False.
    settles
        ``settles(model, bench, count, leaf, columns, at)`` : whether all equilibria of a leaf are one zero.
    leaves, todo : (L, width), (L,)
        Leaves of one round, and those no start has spoken for; struck off here. When all are, those left to
        be searched: leaves whose equilibria are not all one zero. Of many leaves none is looked at for that.
    first
        The leaf to go on with.
    columns
        The leaves' ``Columns``.

    Returns
    -------
    next, count
        The leaf to go on with (L: none is left) after at most ``MOST_STARTS`` starts, and the number
        of zeros known then.
    """
    at = workplace(model, system)
    starts = 0
    for k in range(first, leaves.shape[0]):
        if not todo[k]:
            continue
        if starts == MOST_STARTS:
            return k, count
        starts += 1
        claim(leaves, todo, k, columns.chart, columns.branch, CLAIM * leaf_size)
        chart = int(leaves[k, columns.chart])
        z = at.z
        seed(model, system, chart, leaves[k], columns.variables > 3, at)
        if not improve(at.data, at.rows, system.free[chart], z, at.C, NEWTON_STEPS):
            continue
        far = max(abs(z[0]), abs(z[1]), abs(z[2])) >= FAR_OUT
        if far or is_known(bench, count, chart, z):
            continue
        if prove(model, system, bench, count, chart, at):
            count += 1
    for k in range(leaves.shape[0]):
        todo[k] = True
        if leaves.shape[0] <= FEW_LEAVES and settles(model, bench, count, leaves[k], columns, at):
            todo[k] = False
    return leaves.shape[0], count


@entry()
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
    """Start Newton from leaves and prove roots; see ``from_leaves``. ``bench`` is a ``Bench``.

    Guarantee
    ---------
    Each root appended is proved: for every choice of data exactly one zero in its box, none other in its
    uniqueness box, and it is not one of the roots known before.
    """
    return from_leaves(
        known_root, prove_root, settled_by_root,
        model, system, bench, count, leaves, todo, first, columns, leaf_size,
    )  # fmt: skip
