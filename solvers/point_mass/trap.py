"""A box around the pose of a point mass on springs when length ranges are too wide for Newton.

The energy has exactly one minimum for every choice of the lengths (see `solvers.point_mass.gradient`), so
the hull of the cells in which the gradient may vanish encloses all of them.
"""

from __future__ import annotations

import math

import numpy as np

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.kernels.interval import add, div, mul, sqr, sqrt, sub
from solvers.point_mass.arrays import Cables
from solvers.point_mass.cell_rows import WIDTH
from solvers.point_mass.fields import distance
from solvers.point_mass.one_call import guess_elastic, middles
from solvers.point_mass.spring_cells import run_cells

TRAP_CELLS = 4_000
"""Cells looked at: enough for a hull within a few percent, a few milliseconds."""
FINEST = 1.0 / 32.0
"""Smallest cell as a fraction of the hull found so far."""


def start_box(cables: Cables, load: Bounds) -> Bounds:
    """Bound the minimum of the energy of the given elastic cables, all lengths in their ranges.

    Proof. The minimum p has E(p) <= E(A_i). With r = |p - A_i| and c_i = E(A_i) + f . A_i, the sum over j of
    k_j / 2 max(0, |A_i - A_j| - l_j)^2, and because -f . p >= -f . A_i - |f| r, cable i alone gives
    k_i / 2 max(0, r - l_i)^2 - |f| r <= c_i. With s = r - l_i >= 0 this is the quadratic inequality
    k_i s^2 / 2 - |f| s <= c_i + |f| l_i, so s <= (|f| + sqrt(|f|^2 + 2 k_i (c_i + |f| l_i))) / k_i.
    """
    _, exits, lengths, stiffness, _ = cables
    flo, fhi = 0.0, 0.0
    for j in range(3):
        flo, fhi = add(flo, fhi, *sqr(load[j, 0], load[j, 1]))
    size = sqrt(flo, fhi)
    box = np.array([[-math.inf, math.inf]] * 3)
    for i in range(len(lengths)):
        c = (0.0, 0.0)
        for j in range(len(lengths)):
            near, far = distance(exits, j, exits[i])
            slo, shi = sub(near, far, *lengths[j])
            slo, shi = sqr(max(slo, 0.0), max(shi, 0.0))
            slo, shi = mul(0.5, 0.5, *mul(*stiffness[j], slo, shi))
            c = add(*c, slo, shi)
        k = stiffness[i]
        q = add(*c, *mul(*size, *lengths[i]))
        q = add(*sqr(*size), *mul(2.0, 2.0, *mul(*k, *q)))
        s = div(*add(*size, *sqrt(*q)), *k)
        reach = add(*s, *lengths[i])[1]
        for j in range(3):
            lo, hi = sub(*exits[i, j], -reach, reach)
            box[j] = max(box[j, 0], lo), min(box[j, 1], hi)
    return box


def low_point(cables: Cables, load: Bounds) -> tuple[Bounds, float]:
    """Return a point (3,) near the minimum, and a bound of its elastic energy for all lengths."""
    elastic, exits, lengths, stiffness, _ = cables
    low, ceiling, best = np.zeros(3), math.inf, math.inf
    if not elastic.all():
        return low, ceiling
    A, L, k, f = middles(cables, load)
    for ends in (L, np.ascontiguousarray(lengths[:, 0]), np.ascontiguousarray(lengths[:, 1])):
        x = np.zeros(3 + max(len(L), 4))
        guess_elastic(A, ends, k, f, np.zeros(max(len(L), 4), dtype=np.int64), x)
        if not np.isfinite(x[:3]).all():
            continue
        point = np.column_stack([x[:3], x[:3]])
        total = 0.0
        for i in range(len(L)):
            excess = max(sub(*distance(exits, i, point), *lengths[i])[1], 0.0)
            term = mul(0.5, 0.5, *mul(*stiffness[i], *sqr(0.0, excess)))
            total = add(total, total, *term)[1]
        energy = total - float(f @ x[:3])
        if energy < best:
            low, ceiling, best = x[:3].copy(), total, energy
    return low, ceiling


def trap(cables: Cables, load: Bounds) -> Bounds:
    """Return a box (3, 2) that holds the pose for all lengths in their ranges; all cables elastic."""
    box = start_box(cables, load)
    frame = np.empty((4, WIDTH))
    low, ceiling = low_point(cables, load)
    for _ in range(60):
        width = float((box[:, 1] - box[:, 0]).max())
        stack, leaves = np.empty((TRAP_CELLS, WIDTH)), np.empty((TRAP_CELLS, WIDTH))
        kinds = np.empty(TRAP_CELLS, dtype=np.int64)
        stack[0] = [*box.ravel(), 1.0]
        context = (cables, load, FINEST * width, low, ceiling)
        pending, found, _ = run_cells(context, stack, 1, leaves, kinds, frame, TRAP_CELLS)
        rows = np.concatenate([stack[:pending], leaves[:found]])
        if not len(rows):
            return box
        smaller = np.column_stack([rows[:, 0:6:2].min(axis=0), rows[:, 1:6:2].max(axis=0)])
        if (smaller[:, 1] - smaller[:, 0]).max() > 0.7 * width:
            return smaller
        box = smaller
    return box
