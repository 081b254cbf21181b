"""Tubes of data with ranges of points, along the cables' own lengths: narrow, but not for cells to see.

The search sees the points of cables only in the middle, and takes for lengths the distances between these
(``mechanics.six_dof.tube``). Along the lengths between the points of each choice a tube is narrower and may
be proved where the other is not, but how far a cell's equilibria are from it is not known: it settles none.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Stop
from cdpr_interval.kernels.second_order import width
from cdpr_interval.mechanics.six_dof.arrays import Model
from cdpr_interval.mechanics.six_dof.form_system import MOST_UNKNOWNS
from cdpr_interval.mechanics.six_dof.tube import alone_within, tube
from solvers.six_dof.cells.roots import Reduction, system_of
from solvers.six_dof.cells.subset_search import SubsetSearch
from solvers.six_dof.cells.tube import GluedTube, Tube, around
from solvers.six_dof.cells.tube_prover import SpreadProver, forms_of_thread, symbols_of
from solvers.six_dof.cells.tube_search import TERMS

Floats = NDArray[np.float64]

WIDER = (64.0, 16.0, 4.0, 1.5)
"""Reaches that are tried, over the radii of a tube."""
LEAST_REACH = 1e-9
"""Of an unknown, over the largest of its kind: above rounding."""


def own_tube(model: Model, reduction: Reduction, chart: int, z: Floats) -> Tube | None:
    """Prove the tube through a zero z (6 + n,) for the middle of the data, or return None.

    ``model`` has the cables' own lengths (``own_points``); no family of poses.
    """
    n = model.n_taut
    system, symbols = system_of(reduction, n), symbols_of(model)
    forms, free = forms_of_thread(symbols), np.ascontiguousarray(system.free[chart])
    m = len(free)
    C, w, hull = np.empty((m, m)), np.empty(m), np.empty((6 + n, 2))
    z = z.copy()
    fixed = np.setdiff1d(np.arange(6 + n), free)
    z[fixed] = 0.0
    if not tube(forms, symbols, model, chart, system.rows, free, z, C, w, hull):
        return None
    polynomial, last = forms[: 6 + n, :, 0].copy(), width(symbols) - 1
    for factor in WIDER:
        v = factor * w + LEAST_REACH * np.abs(polynomial[:, 0]).max()
        if alone_within(forms, symbols, model, chart, system.rows, free, v) < 1.0:
            break
    else:
        return None
    radii, reach = np.zeros(6 + n), np.zeros(6 + n)
    radii[free], reach[free] = w, v
    middle = polynomial[:, 0]
    return Tube(
        chart=chart,
        box=hull,
        unique=np.stack([middle - reach, middle + reach], axis=1),
        core=around(middle, radii),
        squares=model.lengths_sq[:n].copy(),
        radii_of_squares=model.lengths_sq_err[:n].copy(),
        polynomial=polynomial[:, :TERMS],
        sways=polynomial[:, last - (len(symbols.data) - MOST_UNKNOWNS) : last],
        radii=radii,
        reach=reach,
        own_points=True,
    )


def add_own_tubes(search: SubsetSearch, own: Model) -> None:
    """Add tubes along the cables' own lengths where cells are left: of zeros that no tube known goes through.

    ``own`` is the search's model with those lengths. The zeros are those of the middle of all data.
    """
    if search.left == 0 or search.stop is not Stop.EXHAUSTED or search.model.planar:
        # Of a plane the model with those lengths has other frames.
        return
    if not isinstance(search.prover, SpreadProver):
        # Only cables outside the subset have ranges: its roots are as they are.
        return
    middle = SubsetSearch(middle_of(own), search.reduction, search.budget, search.threads)
    middle.solve()
    search.cells += middle.cells
    squares = own.lengths_sq[: own.n_taut]
    for root in middle.roots:
        z = root.core.mean(axis=1)
        if any(isinstance(t, Tube | GluedTube) and is_on(t, root.chart, z, squares) for t in search.roots):
            continue
        found = own_tube(own, search.reduction, root.chart, z)
        if found is not None:
            search.roots.append(found)


def middle_of(model: Model) -> Model:
    """Return a model of the middles of all data."""
    lengths = np.sqrt(model.lengths_sq)
    return model._replace(
        lengths=np.stack([lengths * (1.0 - 1e-15), lengths * (1.0 + 1e-15)], axis=1),
        lengths_sq_err=1e-15 * model.lengths_sq,
        load_err=1e-15 * np.abs(model.load),
        exit_spread=np.zeros_like(model.exit_spread),
        arm_spread=np.zeros_like(model.arm_spread),
        gaps=np.zeros_like(model.gaps),
        anchor_sides=np.zeros_like(model.anchor_sides),
        centre_sides=np.zeros_like(model.centre_sides),
        vague=False,
        own_points=False,
    )


def is_on(known: Tube | GluedTube, chart: int, z: Floats, squares: Floats) -> bool:
    """Return True where a zero z (6 + n,) for these squares of length is a tube's, in floats."""
    there, part = known.zero_at(squares)
    return bool(known.chart == chart and (np.abs(there - z) <= part.reach).all())
