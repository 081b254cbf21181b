"""From leaves of the search to proved tubes, compiled: Newton starts, tubes, how far they reach alone.

``find_tubes`` is the one entry; ``root_search.find_roots`` is its like for exact data. A zero at the middle
of the data becomes a tube (``mechanics.six_dof.tube``), which is given the largest reach of a series that
holds no second zero.

Arrays, for n taut cables and m equations: ``leaf`` (width,), ``z`` (6 + n,) a zero, ``off`` (6 + n,) offsets,
``radii`` (6 + n,), ``hull`` (6 + n, 2), ``free`` (m,) the free unknowns, ``w, v, out`` (m,) radii;
``model`` is an ``arrays.Model``, ``system`` is a ``System``, ``bench`` is a ``TubeBench``, ``tubes`` are
``Tubes``, ``at`` is a ``Workplace``, ``columns`` are the ``Columns`` of the leaves.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.scratch import Scratch
from cdpr_interval.kernels.kernel import entry, kernel, part
from cdpr_interval.kernels.second_order import Symbols
from cdpr_interval.mechanics.rotation import HALF_TURNS
from cdpr_interval.mechanics.six_dof.form_system import Z
from cdpr_interval.mechanics.six_dof.rows import ARM_SYMBOLS, LOAD_SYMBOLS, MOST_TAUT
from cdpr_interval.mechanics.six_dof.tube import LANE, alone_within, tube
from solvers.six_dof.cells import ranged_cells as ranged
from solvers.six_dof.cells.root_search import MARGIN, from_leaves, largest_reach
from solvers.six_dof.cells.starts import across_rod
from solvers.six_dof.cells.tube_offsets import Tubes, may_settle, within_reach

Floats = NDArray[np.float64]

TERMS = 1 + MOST_TAUT + MOST_TAUT * (MOST_TAUT + 1) // 2
"""Coefficients of a polynomial of degree two in the symbols of the data."""
SLOPES = 1 + MOST_TAUT
"""Of these the constant and the linear ones."""


class TubeBench(NamedTuple):
    """Scratch and results of ``find_tubes``."""

    turn: Scratch
    """For cells in u."""
    pose: Scratch
    """For cells in (u, x)."""
    symbols: Symbols
    """Of the forms of the data."""
    forms: Floats
    """(rows, columns of a form, LANES) for tubes."""
    tubes: Tubes
    """The tubes known, as cells see them; those found are appended."""
    polynomials: Floats
    """(capacity, 6 + n, TERMS) coefficients in the order of ``second_order``."""
    radii: Floats
    """(capacity, 6 + n) of the boxes around them."""
    hulls: Floats
    """(capacity, 6 + n, 2) bounds of all zeros."""


@kernel()
def same_zero(bench: Any, count: int, chart: int, z: Any) -> bool:
    """Return True when a zero z (6 + n,) for the middle of the data is one of the first ``count`` tubes'."""
    tubes = bench.tubes
    for k in range(count):
        inside = tubes.charts[k] == chart
        for c in range(z.shape[0]):
            inside = inside and abs(z[c] - tubes.centres[k, c]) <= tubes.reach[k, c]
        if inside:
            return True
    return False


@kernel()
def keep_tube(bench: Any, k: int, chart: int, free: Any, w: Any) -> None:
    """Write the tube that stands in the forms as tube ``k``, without its reach."""
    F, tubes, count = bench.forms, bench.tubes, bench.tubes.sways.shape[2]
    last = bench.forms.shape[1] - 1
    tubes.charts[k] = chart
    for c in range(bench.hulls.shape[1]):
        bench.radii[k, c] = 0.0
        for q in range(TERMS):
            bench.polynomials[k, c, q] = F[Z + c, q, LANE]
        rest = 0.0
        for q in range(SLOPES, TERMS):
            rest += abs(bench.polynomials[k, c, q])
        for q in range(count):
            # The last columns but that of their sum. Cells know the arms without the chart's half turn.
            turned = ARM_SYMBOLS <= q < LOAD_SYMBOLS
            sign = HALF_TURNS[chart, q % 3] if turned else 1.0
            tubes.sways[k, c, q] = sign * F[Z + c, last - count + q, LANE]
        tubes.centres[k, c] = bench.polynomials[k, c, 0]
        tubes.rests[k, c] = rest * (1.0 + 1e-14)
        for q in range(MOST_TAUT):
            tubes.slopes[k, c, q] = bench.polynomials[k, c, 1 + q]
        tubes.reach[k, c] = 0.0
    for i in range(free.shape[0]):
        bench.radii[k, free[i]] = w[i]


@kernel()
def wider(model: Any, free: Any, off: Any, hull: Any, radii: Any, reach: float, v: Any) -> None:
    """Write radii v (m,) that hold the offsets and the tube's own ``radii`` (6 + n,) with a margin.

    The margin is at least a share of what ``reach`` in u moves the platform and the tensions.
    """
    most = 0.0
    for c in range(6, off.shape[0]):
        most = max(most, abs(hull[c, 0]), abs(hull[c, 1]))
    for i in range(free.shape[0]):
        c = free[i]
        scale = 1.0 if c < 3 else (model.size if c < 6 else most)
        own = max(off[c], radii[c])
        v[i] = own + MARGIN * max(own, reach * scale)


@part()
def turn_offsets(model: Any, bench: Any, k: int, cell: Any, at: Any) -> bool:
    """Bound how far equilibria of a cell in u (width,) are from tube ``k``; False where that fails."""
    return ranged.turn_offsets(bench.turn, model, cell, bench.tubes, k, at.hi)


@part()
def pose_offsets(model: Any, bench: Any, k: int, cell: Any, at: Any) -> bool:
    """Bound how far equilibria of a cell in (u, x) (width,) are from tube ``k``; False where that fails."""
    return ranged.pose_offsets(bench.pose, model, cell, bench.tubes, k, at.hi)


@part()
def try_around(model: Any, system: Any, bench: Any, k: int, chart: int, at: Any, reach: float) -> float:
    """Return the growth over the neighbourhood of the last offsets, kept as reach where it is below 1."""
    free, hull, tubes = system.free[chart], bench.hulls[k], bench.tubes
    v = np.empty(free.shape[0])
    wider(model, free, at.hi, hull, bench.radii[k], reach, v)
    ratio = alone_within(bench.forms, bench.symbols, model, chart, at.rows, free, v)
    if ratio < 1.0:
        for i in range(free.shape[0]):
            tubes.reach[k, free[i]] = v[i]
        for c in range(3):
            tubes.near[k, c, 0] = hull[c, 0] - tubes.reach[k, c]
            tubes.near[k, c, 1] = hull[c, 1] + tubes.reach[k, c]
    return ratio


@part()
def prove_tube(model: Any, system: Any, bench: Any, k: int, chart: int, at: Any) -> bool:
    """Write the tube through the zero in ``at`` as tube ``k``; False where none is proved."""
    free = system.free[chart]
    w, hull = np.empty(free.shape[0]), bench.hulls[k]
    if system.rod:
        across_rod(at.z[:3], at.rows)
    if not tube(bench.forms, bench.symbols, model, chart, at.rows, free, at.z, at.C, w, hull):
        return False
    keep_tube(bench, k, chart, free, w)
    return largest_reach(
        turn_offsets, pose_offsets, try_around, model, system, bench, k, chart, at, hull, 1.0
    )


@part()
def settled_by_tube(model: Any, bench: Any, count: int, leaf: Any, columns: Any, at: Any) -> bool:
    """Return True when a leaf's equilibria are all within the reach of one tube known."""
    tubes = bench.tubes
    for k in range(count):
        if not may_settle(tubes, k, leaf, int(leaf[columns.chart])):
            continue
        if columns.variables > 3:
            inside = pose_offsets(model, bench, k, leaf, at)
        else:
            inside = turn_offsets(model, bench, k, leaf, at)
        if inside and within_reach(tubes, k, at.hi):
            return True
    return False


@entry()
def find_tubes(
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
    """Start Newton from leaves and prove tubes; see ``from_leaves``. ``bench`` is a ``TubeBench``.

    Guarantee
    ---------
    Each tube appended is proved: for every choice of data exactly one zero within its radii of its
    polynomial, none other within its reach, and it is not one of the tubes known before.
    """
    return from_leaves(
        same_zero, prove_tube, settled_by_tube,
        model, system, bench, count, leaves, todo, first, columns, leaf_size,
    )  # fmt: skip
