"""Cells in (u, p): six search variables, for the places where sigma cannot fix the position.

Where the centres c_i of all triples may lie on one line (equal parallel cables: all in one point)
the position is searched directly, in the intersection of the boxes c_i + [-l_i, l_i]^3. The tests
are those of the (u, sigma) search.

A cell is a row ``u (3 x lo, hi), p (3 x lo, hi), chart, share``.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from cdpr_interval.engine.depth_first import depth_first
from cdpr_interval.kernels import affine
from cdpr_interval.kernels.rounding import down, inflate, up
from solvers.platform_contract import EMPTY, SMALLER, contract, statics_equations
from solvers.platform_forms import (
    BLOCK,
    CABLE,
    EQUATION,
    POSITION,
    SCRATCH,
    centre_forms,
    moment_forms,
    rotated_point,
    rotation_forms,
    statics_excluded,
    tension_bounds,
)
from solvers.platform_sigma import SMALL, copy_cell, halve, leaf

P_LO, P_CHART, P_SHARE = 6, 12, 13
P_WIDTH = 14


@njit(cache=True, nogil=True)
def spoke_forms(F: Any, out: int, r: int, model: Any, chart: int, i: int) -> None:
    """Write r_i to the rows from ``r`` and e_i = c_i - p to the rows from ``out``."""
    rotated_point(F, r, model, chart, i)
    centre_forms(F, SCRATCH, model, i, r)
    for k in range(3):
        affine.subtract(F, out + k, SCRATCH + k, POSITION + k)


@njit(cache=True, nogil=True)
def contract_position(F: Any, model: Any, cell: Any, i: int, e: int) -> bool:
    """Cut p to c_i + [-l_i, l_i]^3, given e_i's rows (c_i = e_i + p); False when nothing is left."""
    length = model.lengths[i, 1]
    for k in range(3):
        affine.add(F, SCRATCH, e + k, POSITION + k)
        lo, hi = affine.bounds(F, SCRATCH)
        j = P_LO + 2 * k
        cell[j] = max(cell[j], down(lo - length))
        cell[j + 1] = min(cell[j + 1], up(hi + length))
        if cell[j] > cell[j + 1]:
            return False
    return True


@njit(cache=True, nogil=True)
def write_position(F: Any, cell: Any) -> None:
    """Write p on the symbols 4..6."""
    for k in range(3):
        affine.variable(F, POSITION + k, 4 + k, cell[P_LO + 2 * k], cell[P_LO + 2 * k + 1])


@njit(cache=True, nogil=True)
def sphere_gap(F: Any, model: Any, i: int, e: int) -> tuple[float, float]:
    """Bound |e_i|^2 - l_i^2."""
    affine.dot(F, SCRATCH, e, e, 3)
    last = F.shape[1] - 1
    a = F[SCRATCH, 0]
    b = model.lengths_sq[i]
    F[SCRATCH, 0] = a - b
    F[SCRATCH, last] = inflate(F[SCRATCH, last] + model.lengths_sq_err[i], abs(a) + abs(b), 4.0)
    return affine.bounds(F, SCRATCH)


@njit(cache=True, nogil=True)
def enclose_position_cell(F: Any, W: Any, model: Any, cell: Any, lo: Any, hi: Any) -> bool:
    """Enclose (u, p, t) of every equilibrium of the taut cables in the cell; False if t is not bounded."""
    chart = int(cell[P_CHART])
    if not rotation_forms(F, cell):
        return False
    write_position(F, cell)
    for i in range(model.n_taut):
        r = CABLE + BLOCK * i
        spoke_forms(F, r + 3, r, model, chart, i)
    return finish_position(F, W, model, cell, lo, hi)


@njit(cache=True, nogil=True)
def finish_position(F: Any, W: Any, model: Any, cell: Any, lo: Any, hi: Any) -> bool:
    """Write (u, p, t) bounds, given the cables' forms."""
    for k in range(6):
        lo[k] = cell[2 * k]
        hi[k] = cell[2 * k + 1]
    if model.n_taut == 6:
        # Six lengths alone fix the pose; t is not an unknown then and stands as 0 in the roots.
        lo[6:] = 0.0
        hi[6:] = 0.0
        return True
    moment_forms(F, model)
    return tension_bounds(F, W, model, lo[6:], hi[6:])


@njit(cache=True, nogil=True)
def position_settled(F: Any, W: Any, model: Any, roots: Any, cell: Any, lo: Any, hi: Any) -> bool:
    """Return True when every equilibrium in the cell lies in one root's uniqueness box."""
    size = 6 + model.n_taut
    for k in range(roots.shape[0]):
        near = int(roots[k, 0]) == int(cell[P_CHART])
        for c in range(6):
            near = near and roots[k, 1 + c] <= cell[2 * c] and cell[2 * c + 1] <= roots[k, 1 + size + c]
        if not near:
            continue
        if not finish_position(F, W, model, cell, lo, hi):
            return False
        for c in range(6, size):
            near = near and roots[k, 1 + c] <= lo[c] and hi[c] <= roots[k, 1 + size + c]
        if near:
            return True
    return False


@njit(cache=True, nogil=True)
def newton_contract_position(F: Any, W: Any, model: Any, cell: Any, lo: Any, hi: Any) -> int:
    """Contract the cell by the lengths of the taut cables and the statics."""
    for i in range(model.n_taut):
        sphere_gap(F, model, i, CABLE + BLOCK * i + 3)
        for k in range(F.shape[1]):
            F[EQUATION + i, k] = F[SCRATCH, k]
    equations = model.n_taut
    if model.n_taut < 6:
        moment_forms(F, model)
        if tension_bounds(F, W, model, lo[6:], hi[6:]):
            equations += statics_equations(F, W, model, EQUATION + equations, lo[6:], hi[6:])
    return contract(F, W, cell, equations)


@njit(cache=True, nogil=True)
def process_position(context: Any, cell: Any, children: Any) -> int:
    """Exclude, contract, settle or split one (u, p) cell; see ``engine.depth_first``."""
    model, roots, leaf_size, reach, F, W, lo, hi = context
    chart = int(cell[P_CHART])
    if not rotation_forms(F, cell):
        return leaf(cell, children, SMALL)
    write_position(F, cell)
    for i in range(model.n_taut):
        r = CABLE + BLOCK * i
        spoke_forms(F, r + 3, r, model, chart, i)
        if not contract_position(F, model, cell, i, r + 3):
            return 0
    write_position(F, cell)
    for i in range(model.n_taut):
        r = CABLE + BLOCK * i
        spoke_forms(F, r + 3, r, model, chart, i)
        glo, ghi = sphere_gap(F, model, i, r + 3)
        if glo > 0.0 or ghi < 0.0:
            return 0
    if model.slack:
        for i in range(model.n_taut, model.lengths.shape[0]):
            spoke_forms(F, SCRATCH + 6, SCRATCH + 3, model, chart, i)
            if sphere_gap(F, model, i, SCRATCH + 6)[0] > 0.0:
                return 0
    if model.statics and statics_excluded(F, W, model):
        return 0
    if position_settled(F, W, model, roots, cell, lo, hi):
        return 0
    verdict = newton_contract_position(F, W, model, cell, lo, hi)
    if verdict == EMPTY:
        return 0
    if verdict == SMALLER:
        copy_cell(cell, children)
        return 1
    widest = 0
    width = -1.0
    for k in range(6):
        w = cell[2 * k + 1] - cell[2 * k]
        if k >= 3:
            w /= reach
        if w > width:
            width = w
            widest = k
    if width <= leaf_size:
        return leaf(cell, children, SMALL)
    return halve(cell, children, 2 * widest)


@njit(cache=True, nogil=True)
def run_position(
    model: Any,
    roots: Any,
    leaf_size: float,
    reach: float,
    F: Any,
    W: Any,
    lo: Any,
    hi: Any,
    stack: Any,
    count: int,
    leaves: Any,
    kinds: Any,
    children: Any,
    cell_limit: int,
) -> tuple[int, int, int]:
    """Search (u, p) cells depth first; ``reach`` (m) weighs p against u when bisecting."""
    context = (model, roots, leaf_size, reach, F, W, lo, hi)
    return depth_first(process_position, context, stack, count, leaves, kinds, children, cell_limit)
