"""The balance of forces with tensions as forms: cables that stretch say what they pull at a pose.

With D = |X - T0|, the path length is L = start + D + e, |e| <= LOOSE, and the free length sigma differs from
D by at most DRIFT. A taut cable has the density t = (L - l) / (c sigma), so that

    c t = 1 - rest / D + e',    rest = l - start,    |e'| <= (LOOSE + DRIFT |1 - rest / D|) / sigma,

a form of second order in the symbols of the cell. Such pulls are a part of the load on the cables that do not
stretch; where all stretch, the six rows of that load vanish at every pose. They say something also where
lengths bound nothing: where tensions may be anything.

Arrays: ``F``, ``W``, ``C`` as in ``cells.tests``, ``F`` with the rows of ``rows``; ``desk`` is a
``survey.Desk``, ``real`` is a ``RealModel``; ``spots`` (n, SPOT, LANES) are the desk's.
"""

from __future__ import annotations

from typing import Any

from cdpr_interval.engine.contraction import cannot_vanish, noise
from cdpr_interval.engine.rows import EQUATION, SCRATCH, SYSTEM
from cdpr_interval.kernels.dense import solve_definite
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LaneArray, Lanes, load, root, splat, store, where_less
from cdpr_interval.kernels.rounding import inflate_lanes
from cdpr_interval.kernels.second_order import (
    Forms,
    Symbols,
    add_product,
    add_scaled,
    bounds,
    combine6,
    largest,
    multiply,
    scale,
    widen,
)
from cdpr_interval.mechanics.six_dof.rows import DIMENSIONS, LOAD, MOST_TAUT, SCALE, WRENCH, Y
from solvers.six_dof.real.columns import (
    LENGTH_ERROR,
    REST,
    TURNED_SHARE,
)
from solvers.six_dof.real.rows import DENSITY, FROM_FOOT, MORE_WRENCH, ONE_OVER_SCALE
from solvers.six_dof.real.shape import square_row, wrench_row

ROUNDINGS = 1e-14
"""Relative error of a power in floats: some forty units, of about ten needed."""


@kernel()
def curved(F: Forms, out: int, a: int, f0: Lanes, f1: Lanes, low: Lanes, high: Lanes, S: Symbols) -> None:
    """Write f0 + f1 d + [low, high] d^2 to ``out``, d the row ``a`` less its centre; overwrites ``a``.

    f0 and f1 may be off by ROUNDINGS of them.
    """
    store(F, a, 0, 0.0)
    most = largest(F, a, S)
    middle, radius = 0.5 * (low + high), 0.5 * (high - low)
    multiply(F, out, a, a, 1.0, S)
    scale(F, out, out, middle, S)
    add_scaled(F, out, a, f1, S)
    store(F, out, 0, load(F, out, 0) + f0)
    off = ROUNDINGS * (abs(f0) + abs(f1) * most + (abs(middle) + radius) * most * most)
    widen(F, out, inflate_lanes(radius * most * most + off, splat(0.0), 8.0), S)


@kernel()
def inverse(F: Forms, out: int, a: int, S: Symbols) -> None:
    """Write 1 / a for a row ``a`` that is positive; overwrites it."""
    lo, hi = bounds(F, a, S)
    x = load(F, a, 0)
    # 1 / (x + d) = 1 / x - d / x^2 + d^2 / (x^2 (x + d))
    curved(F, out, a, 1.0 / x, -1.0 / (x * x), 1.0 / (x * x * hi), 1.0 / (x * x * lo), S)


@kernel()
def bend(d: Lanes, f: Lanes) -> Lanes:
    """Return what e^2 has as its factor in (x^2 + 2 e)^(-1/2) = d - d^3 e + .., d = 1 / x, where that is f.

    With r = 1 / f it is 2 (r + 2 x) / (x^3 r (r + x)^2); it falls with r.
    """
    both = d + f
    return 2.0 * d * d * d * d * (f * f) * (d + 2.0 * f) / (both * both)


@kernel()
def inverse_root(F: Forms, out: int, a: int, S: Symbols) -> None:
    """Write (2 a)^(-1/2) for a row ``a``, everything where it may not be positive; overwrites it."""
    lo, hi = bounds(F, a, S)
    positive = where_less(0.0, lo, where_less(hi, 1e300, splat(1.0), 0.0), 0.0)
    # Where not, any numbers: the error becomes infinite.
    lo = where_less(0.0, positive, lo, 0.5)
    hi = where_less(0.0, positive, hi, 0.5)
    x = 2.0 * where_less(0.0, positive, load(F, a, 0), 0.5)
    d = 1.0 / root(x)
    near, far = 1.0 / root(2.0 * lo), 1.0 / root(2.0 * hi)
    low, high = bend(d, far), bend(d, near)
    curved(F, out, a, d, -d * d * d, low, high, S)
    widen(F, out, where_less(0.0, positive, splat(0.0), 1e300), S)


@kernel()
def density_row(F: Forms, real: Any, i: int, spots: LaneArray, S: Symbols) -> None:
    """Write the density of cable ``i`` to DENSITY. Needs ONE_OVER_SCALE and the rows of ``product_rows``."""
    square_row(F, DENSITY, real, i, spots, S)
    # Without what it has at the middle of the cell, the error of 1 / s counts for little.
    middle = load(F, DENSITY, 0) / load(F, SCALE, 0)
    add_scaled(F, DENSITY, SCALE, -middle, S)
    multiply(F, FROM_FOOT, DENSITY, ONE_OVER_SCALE, 1.0, S)
    store(F, FROM_FOOT, 0, load(F, FROM_FOOT, 0) + middle)
    widen(F, FROM_FOOT, ROUNDINGS * (abs(middle) + abs(load(F, FROM_FOOT, 0))), S)
    inverse_root(F, DENSITY, FROM_FOOT, S)
    scale(F, DENSITY, DENSITY, -load(spots, i, REST), S)
    store(F, DENSITY, 0, load(F, DENSITY, 0) + 1.0)
    most = largest(F, DENSITY, S)
    off = load(spots, i, LENGTH_ERROR) + load(spots, i, TURNED_SHARE) * most + ROUNDINGS * (1.0 + most)
    low, high = 1.0 / real.compliance[i, 1], 1.0 / real.compliance[i, 0]
    stiffness, range_of = 0.5 * (low + high), 0.5 * (high - low)
    scale(F, DENSITY, DENSITY, splat(stiffness), S)
    error = stiffness * off + (range_of + ROUNDINGS * stiffness) * (most + off)
    widen(F, DENSITY, inflate_lanes(error, splat(0.0), 8.0), S)


@kernel()
def add_pulls(F: Forms, real: Any, spots: LaneArray, S: Symbols) -> None:
    """Add s t_i w_i of all cables that stretch to the rows LOAD. Needs ``wrench_rows``."""
    scale(F, DENSITY, SCALE, splat(1.0), S)
    inverse(F, ONE_OVER_SCALE, DENSITY, S)
    for i in range(real.rigid, real.n_taut):
        density_row(F, real, i, spots, S)
        row = WRENCH + DIMENSIONS * i
        if i >= MOST_TAUT:
            row = MORE_WRENCH
            wrench_row(F, row, real, i, spots, S)
        for k in range(DIMENSIONS):
            add_product(F, LOAD + k, DENSITY, row + k, 1.0, S)


@kernel()
def choose_weights(F: Forms, W: LaneArray, first: int, S: Symbols) -> None:
    """Write to Y what weights the six rows EQUATION + first .. so that their sum stays farthest from zero.

    With c the centres, l_k the slopes and n what else the rows vary by, y = (sum l_k l_k^T + diag(n)^2)^-1 c.
    """
    for a in range(DIMENSIONS):
        row = EQUATION + first + a
        for b in range(a, DIMENSIONS):
            total = splat(0.0)
            for k in range(len(S.noise)):
                total += load(F, row, 1 + k) * load(F, EQUATION + first + b, 1 + k)
            store(W, SYSTEM + a, b, total)
            store(W, SYSTEM + b, a, total)
        rest = noise(F, row, S)
        own = load(W, SYSTEM + a, a) + rest * rest
        # A row of zeros stays out of the way.
        store(W, SYSTEM + a, a, where_less(0.0, own, own, 1.0))
        store(W, SYSTEM + a, DIMENSIONS, load(F, row, 0))
    solve_definite(W, SYSTEM, DIMENSIONS, 1)
    for a in range(DIMENSIONS):
        store(W, Y, a, load(W, SYSTEM + a, DIMENSIONS))


@kernel()
def cannot_balance(F: Forms, W: LaneArray, first: int, S: Symbols) -> Lanes:
    """Return 1 where some weighted sum of the six rows EQUATION + first .. is zero nowhere, else 0."""
    choose_weights(F, W, first, S)
    combine6(F, SCRATCH, EQUATION + first, W, Y, S)
    return cannot_vanish(F, SCRATCH, S)
