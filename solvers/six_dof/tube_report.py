"""What tubes report: bounds over all choices of the data, in the robot's frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from flint import arb
from numpy.typing import NDArray

from cdpr_interval.engine.per_thread import per_thread
from cdpr_interval.exact import balls
from cdpr_interval.kernels import interval
from cdpr_interval.kernels.lanes import LANES
from cdpr_interval.kernels.second_order import Symbols, width
from cdpr_interval.mechanics.loaded import LoadedRobot
from cdpr_interval.mechanics.rotation import best_chart, rotation_at
from cdpr_interval.mechanics.six_dof.arrays import Model
from cdpr_interval.mechanics.six_dof.fields import Cables, Fields
from cdpr_interval.mechanics.six_dof.frame import Frame, centred_cayley, coordinates, half_turn
from cdpr_interval.mechanics.six_dof.rows import MOST_TAUT
from cdpr_interval.mechanics.six_dof.tube import tube
from cdpr_interval.mechanics.six_dof.tube_fields import TABLE, fill_tube_fields
from solvers.six_dof.cells.own_tubes import own_tube
from solvers.six_dof.cells.roots import GENERAL, PLANAR, Root, pose_of, system_of
from solvers.six_dof.cells.tube import GluedTube, Tube, around
from solvers.six_dof.cells.tube_prover import forms_of_thread, symbols_of
from solvers.six_dof.prepared import Lengths, cables_of
from solvers.six_dof.reduction import Reduced
from solvers.six_dof.solution import empty_fields, fields_of

Floats = NDArray[np.float64]


def tube_fields(
    loaded: LoadedRobot, lengths: Lengths, taut: tuple[int, ...], reduced: Reduced, roots: Sequence[Root]
) -> Fields:
    """Return what the tubes of one search report, in bounds; tensions but for the load's factor.

    Whether a pose is stable is looked at for the data's middle. It is so for all of them: the system's
    Jacobian at a pose is, in other coordinates, the second derivative of the Lagrangian, bordered by the
    lengths' first ones, and regular along the tube, so that its inertia does not change. That of a planar
    search says nothing of motions out of its plane: there all data are looked at.
    """
    reported = [along_own_lengths(reduced, root) or root.parts for root in roots]
    parts = [part for own in reported for part in own]
    each = pieces(cables_of(loaded), lengths, taut, reduced, parts)
    fields = empty_fields(len(roots), len(taut), len(lengths.bounds))
    first = 0
    for m, own in enumerate(reported):
        last = first + len(own)
        for whole, piece in zip(fields[:-1], each[:-1], strict=True):
            whole[m, ..., 0] = piece[first:last, ..., 0].min(axis=0)
            whole[m, ..., 1] = piece[first:last, ..., 1].max(axis=0)
        first = last
    planar = reduced.reduction is PLANAR
    for m, (own, root) in enumerate(zip(reported, roots, strict=True)):
        one = own[0] if len(own) == 1 else root
        in_plane = planar and not (isinstance(one, Tube) and one.own_points)
        frame = Frame.plain() if planar and not in_plane else reduced.frame
        seen = one if in_plane else replace_box(one)
        cables = cables_of(loaded if in_plane else loaded.middle)
        fields.verdicts[m] = fields_of(cables, lengths, taut, frame, [seen]).verdicts[0]
    return fields


def replace_box(root: Root) -> Root:
    """Return a root that stands for the zero at the middle of the data."""
    return Root(root.chart, root.core, root.unique, root.core)


def along_own_lengths(reduced: Reduced, root: Root) -> tuple[Tube, ...]:
    """Return the narrower tube along the cables' own lengths, if there is one and it is the root's.

    Both have one zero for every choice, which moves continuously with it: the same one, if it is for one.
    That of a planar search is one in space.
    """
    if reduced.own is None or not isinstance(root, Tube | GluedTube):
        return ()
    model, n = reduced.own, reduced.own.n_taut
    squares = model.lengths_sq[:n]
    z, part = root.zero_at(squares)
    if reduced.middle is not None:
        return in_space(reduced, part, z)
    reduction = reduced.reduction
    if n == MOST_TAUT:
        z = z.copy()
        z[6:], reduction = float_tensions(model, root.chart, z), GENERAL
    found = own_tube(model, reduction, root.chart, z)
    if found is None or not part.holds(found_pose(found) if n == MOST_TAUT else found, squares):
        return ()
    return (found,)


def in_space(reduced: Reduced, part: Tube, z: Floats) -> tuple[Tube, ...]:
    """Return the tube in space that goes where z (6 + n,) of a planar one is, if it is the same.

    That is so when its pose for the middle of all data, which has a plane of its own, is in reach of the
    planar tube: off its polynomial, for the distances of the planar middle points there, by what points and
    load do.
    """
    assert reduced.own is not None and reduced.middle is not None
    pose = pose_of(Root(part.chart, around(z, 0.0 * z), part.unique, part.core), reduced.middle)
    chart = best_chart(balls.middle(pose.rotation))
    where = coordinates(pose, Frame.plain(), chart)
    if where is None:
        return ()
    start = np.array([*map(middle, [*where[0], *where[1]]), *z[6:]])
    found = own_tube(reduced.own, GENERAL, chart, start)
    if found is None:
        return ()
    core = pose_of(replace_box(found), Frame.plain())
    where = coordinates(core, reduced.middle, part.chart)
    return () if where is None or not is_reached(reduced.model, part, *where, core.densities) else (found,)


def is_reached(model: Model, part: Tube, u: list[arb], p: list[arb], t: Sequence[arb]) -> bool:
    """Return whether a zero (u, p, t) for some choice of points and load is proved to be a tube's."""
    rotation, n = centred_cayley(u) * half_turn(part.chart), model.n_taut
    squares, off = np.empty(n), np.empty(n)
    for i in range(n):
        arm = rotation * balls.vector([arb(x) for x in model.arms[0, i].tolist()])
        spoke = balls.vector([arb(x) for x in model.exits[i].tolist()]) - balls.vector(p) - arm
        square = balls.dot(spoke, spoke)
        squares[i] = middle(square)
        error = float(model.arms_err[i].sum() + model.exits_err[i].sum())
        low, high = balls.to_bounds(square)
        longest = float(np.sqrt(max(high, 0.0))) + error
        off[i] = max(high - squares[i], squares[i] - low) + 4.0 * error * longest
    ranged = part.radii_of_squares > 0.0
    if not (np.abs(squares - part.squares) + off <= part.radii_of_squares)[ranged].all():
        return False
    z, _ = part.zero_at(squares)
    shares = np.where(ranged, off / np.where(ranged, part.radii_of_squares, 1.0), 0.0)
    swayed = np.abs(part.sways).sum(axis=1)
    swayed += (np.abs(part.slopes[:, :n]) + 2.0 * part.rests[:, None]) @ shares
    room = part.reach - (swayed + 1e-12 * (1.0 + np.abs(z).max())) * (1.0 + 1e-12)
    bounds = np.array([balls.to_bounds(x) for x in (*u, *p, *t)])
    inside = (z - room < bounds[:, 0]) & (bounds[:, 1] < z + room)
    # What the plane fixes is so for every static pose, in one of its two mirrored frames.
    fixed = (bounds[:, 0] <= z) & (z <= bounds[:, 1])
    return bool(np.where(part.reach > 0.0, inside, fixed).all())


def middle(x: arb) -> float:
    """Return the middle of a ball."""
    return float(x.mid())


def pieces(
    cables: Cables, lengths: Lengths, taut: tuple[int, ...], reduced: Reduced, parts: Sequence[Tube]
) -> Fields:
    """Return what tubes in one piece report, verdicts left out."""
    n, count = len(taut), len(cables.exits)
    fields = empty_fields(len(parts), n, count)
    order = np.array([*taut, *(i for i in range(count) if i not in taut)], dtype=np.int64)
    symbols = symbols_of(reduced.model)
    forms = fields_forms(symbols)
    for m, part in enumerate(parts):
        # One along the own lengths has them.
        with_them = n < MOST_TAUT or part.reach[6:].any()
        seen = part if with_them else with_tensions(reduced.model, part)
        if seen is None:
            for array in fields[:-1]:
                array[m] = np.nan
            continue
        space = part.own_points and reduced.middle is not None
        frame = Frame.plain() if space else reduced.frame
        data = (reduced.own if space else reduced.model, cables, frame.bounds)
        tube_data = (part.chart, seen.polynomial, seen.sways, seen.radii)
        fill_tube_fields(forms, symbols, *data, *tube_data, order, fields, m)
    for j, i in enumerate(taut):
        lo, hi = lengths.bounds[i]
        for m in range(len(parts)):
            fields.tensions[m, i] = interval.mul(*fields.densities[m, j], lo, hi)
        # A taut cable is as long as it is.
        fields.distances[:, i, 0], fields.distances[:, i, 1] = lo, hi
    gaps = reduced.model.gaps
    for i, gap in zip(order[n:], gaps[n:], strict=True):
        if gap > 0.0:
            fields.distances[:, i, 0] = np.nextafter(fields.distances[:, i, 0] - gap, -np.inf).clip(0.0)
            fields.distances[:, i, 1] = np.nextafter(fields.distances[:, i, 1] + gap, np.inf)
    return fields


def with_tensions(model: Model, part: Tube) -> Tube | None:
    """Return a tube of six cables with their tensions; None where these are not proved to be unique."""
    z = part.polynomial[:, 0].copy()
    z[6:] = float_tensions(model, part.chart, z)
    system = system_of(GENERAL, 6)
    C, w, hull = np.empty((12, 12)), np.empty(12), np.empty((12, 2))
    symbols = symbols_of(model)
    forms = forms_of_thread(symbols)
    rows, free = system.rows, np.ascontiguousarray(system.free[part.chart])
    squares, errors = model.lengths_sq.copy(), model.lengths_sq_err.copy()
    piece = model._replace(lengths_sq=squares, lengths_sq_err=errors, own_points=part.own_points)
    piece.lengths_sq[:6], piece.lengths_sq_err[:6] = part.squares, part.radii_of_squares
    if not (np.isfinite(z).all() and tube(forms, symbols, piece, part.chart, rows, free, z, C, w, hull)):
        return None
    terms = part.polynomial.shape[1]
    last = width(symbols) - 1
    sways = forms[:12, last - part.sways.shape[1] : last, 0].copy()
    found = replace(part, polynomial=forms[:12, :terms, 0].copy(), sways=sways, radii=w.copy())
    return found if part.holds(found_pose(found), part.squares) else None


def found_pose(found: Tube) -> Tube:
    """Return a tube without its tensions, to be compared with one of the pose alone."""
    polynomial, sways, radii = found.polynomial.copy(), found.sways.copy(), found.radii.copy()
    polynomial[6:], sways[6:], radii[6:] = 0.0, 0.0, 0.0
    return replace(found, polynomial=polynomial, sways=sways, radii=radii)


def float_tensions(model: Model, chart: int, z: Floats) -> Floats:
    """Return tension / length of six cables that balance the load at a pose, in floats."""
    turned = np.empty((3, 3))
    rotation_at(z[:3], turned)
    arms = model.arms[chart, :6] @ turned.T
    spokes = model.exits[:6] - z[3:6] - arms
    wrenches = np.concatenate([spokes, np.cross(arms, spokes)], axis=1).T
    return np.linalg.lstsq(wrenches, -np.concatenate([model.load, np.zeros(3)]), rcond=None)[0]


@per_thread
def fields_forms(symbols: Symbols) -> Floats:
    """Return a thread's forms for what tubes report."""
    return np.zeros((TABLE.height, width(symbols), LANES))
