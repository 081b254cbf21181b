"""Where cells remain, lengths are cut in halves: tubes of both halves that share their zeros are one tube."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Stop
from cdpr_interval.mechanics.rotation import rotation_at
from cdpr_interval.mechanics.six_dof.arrays import Model
from solvers.six_dof.cells.columns import POSE_COLUMNS
from solvers.six_dof.cells.roots import Root
from solvers.six_dof.cells.subset_search import RANGED_REASON, SubsetSearch, last_leaf
from solvers.six_dof.cells.tube import GluedTube, Tube, glued
from solvers.six_dof.cells.tube_prover import TubeProver

Floats = NDArray[np.float64]

MOST_CUTS = 6
"""How often lengths are halved, one after the other, where cells remain."""
FREE_CUTS = 3
"""Halvings after which what is left must grow fewer: a fold stays in some part, however small."""
MOST_CUT_CELLS = 20_000
"""More cells than this are no neighbourhoods of single tubes: halves would not settle them."""
MOST_GAPS = 6.0
"""A half width of lengths over what a cable's points may add to it, above which it is cut. With +-0.1 mm in
all data UC3 keeps its four regions, whether lengths are cut (20 s) or not (1.2 s)."""
WITHOUT_TUBES = 1e-3
"""What a share of a length counts where no tube is near: far less than what moves one."""


def cut_lengths(search: SubsetSearch, depth: int = 0) -> None:
    """Search the cells that are left with the lengths of one cable in two halves; nothing of exact data.

    What for one half is settled, excluded or proved need not be so for the whole: cells too near to a tube
    for all of its data, and zeros that have no tube in one piece.
    """
    ranged = isinstance(search.prover, TubeProver)
    if not (ranged and search.stop is Stop.EXHAUSTED and 0 < search.left <= MOST_CUT_CELLS):
        return
    cable = cable_to_cut(search)
    if depth == MOST_CUTS or cable is None:
        return
    before, leaf = search.left, last_leaf(search.model)
    halves = [
        SubsetSearch(half, search.reduction, search.budget, search.threads, search.report, first_leaf=leaf)
        for half in halved(search.model, cable)
    ]
    for half in halves:
        half.solve_cells(search.undecided, search.undecided_position)
        if depth < FREE_CUTS or half.left < before:
            cut_lengths(half, depth + 1)
        search.cells += half.cells
        search.pending += half.pending
        search.stop = search.stop if search.stop is not Stop.EXHAUSTED else half.stop
    lone = [cell_around(search.model, root) for root in put_halves_together(search, halves, cable)]
    search.undecided = together([half.undecided for half in halves])
    search.undecided_position = together([*(half.undecided_position for half in halves), *lone])
    search.reason = RANGED_REASON if search.left else ""


def together(cells: Sequence[Floats]) -> Floats:
    """Return all rows, each once."""
    return np.unique(np.concatenate(cells), axis=0)


def cable_to_cut(search: SubsetSearch) -> int | None:
    """Return the taut cable whose range moves the tubes near the cells left most, over their reach.

    None where all ranges are mostly those of the cables' points: what these do to forces stays as it is.
    """
    n = search.model.n_taut
    half = search.model.lengths_sq_err[:n] / (2.0 * search.model.lengths[:n, 1])
    wide = half > MOST_GAPS * search.model.gaps[:n]
    if not wide.any():
        return None
    worth = WITHOUT_TUBES * search.model.lengths_sq_err[:n] / search.model.lengths_sq[:n]
    for root in search.roots:
        for tube in root.parts:
            if near(tube, search.undecided) or near(tube, search.undecided_position):
                free = tube.reach > 0.0
                share = np.abs(tube.slopes[free, :n]) / tube.reach[free, None]
                worth = np.maximum(worth, share.max(axis=0))
    return int(np.argmax(np.where(wide, worth, 0.0)))


def near(tube: Tube, cells: Floats) -> bool:
    """Return True when the u of some cell (rows) comes within a tube's reach."""
    lo, hi = tube.near.T
    return bool(np.all((cells[:, 0:6:2] <= hi) & (cells[:, 1:6:2] >= lo), axis=1).any())


def halved(model: Model, cable: int) -> list[Model]:
    """Return models with the lower and the upper half of a cable's lengths."""
    middle, radius = model.lengths_sq[cable], model.lengths_sq_err[cable]
    at = float(np.sqrt(middle))
    found = []
    for side in (-1.0, 1.0):
        squares, radii, lengths = (x.copy() for x in (model.lengths_sq, model.lengths_sq_err, model.lengths))
        squares[cable] = middle + side * 0.5 * radius
        # The halves overlap by their rounding.
        radii[cable] = 0.5 * radius + 4e-16 * (middle + radius)
        lengths[cable, 1 if side < 0.0 else 0] = np.nextafter(at, side * -np.inf)
        found.append(model._replace(lengths=lengths, lengths_sq=squares, lengths_sq_err=radii))
    return found


def put_halves_together(search: SubsetSearch, halves: Sequence[SubsetSearch], cable: int) -> list[Root]:
    """Add the tubes that go through both halves of a cable's lengths; return those of one half alone."""
    n, whole = search.model.n_taut, [root for root in search.roots if isinstance(root, Tube)]
    first, second = (
        [root for root in tubes_of(half) if not any(t.holds(root, half.model.lengths_sq[:n]) for t in whole)]
        for half in halves
    )
    squares = search.model.lengths_sq[:n]
    lone: list[Root] = []
    for root in first:
        found = next(((g, other) for other in second if (g := glued(root, other, cable, squares))), None)
        if found is None:
            lone.append(root)
        else:
            search.roots.append(found[0])
            second.remove(found[1])
    return [*lone, *second]


def tubes_of(search: SubsetSearch) -> list[Tube | GluedTube]:
    """Return what the search of a half found; of data with ranges all is tubes."""
    return [root for root in search.roots if isinstance(root, Tube | GluedTube)]


def cell_around(model: Model, root: Root) -> Floats:
    """Return the (u, x) cell (1, width) around a root's box."""
    cell = np.zeros((1, POSE_COLUMNS.width))
    cell[0, :6] = root.box[:3].reshape(-1)
    pivot = model.orders[0, 0]
    arm = float(np.abs(model.arms[0, pivot]).sum())
    turned = np.empty((3, 3))
    rotation_at(root.core[:3].mean(axis=1), turned)
    middle = root.core.mean(axis=1)
    x = middle[3:6] - model.exits[pivot] + turned @ model.arms[root.chart, pivot]
    # |R(u) - R(u')| <= 2 |u - u'|.
    off = np.abs(root.box[:6] - middle[:6, None]).max(axis=1)
    off = (off[3:] + 2.0 * arm * off[:3].sum()) * (1.0 + 1e-9) + 1e-12 * (1.0 + np.abs(x).max())
    cell[0, 6:12] = np.stack([x - off, x + off], axis=1).reshape(-1)
    cell[0, POSE_COLUMNS.chart] = root.chart
    return cell
