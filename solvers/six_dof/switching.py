"""Open entries over ranges of lengths at which one cable switches: chains instead, and what they take in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Budget
from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.exact.vector import is_zero
from cdpr_interval.kernels import interval
from cdpr_interval.mechanics.energy import to_matrix
from cdpr_interval.mechanics.orientation import rotation_from_quaternion
from cdpr_interval.mechanics.rotation import best_chart
from cdpr_interval.mechanics.six_dof.arrays import Model
from cdpr_interval.mechanics.six_dof.fields import OPEN, STABLE, Fields
from cdpr_interval.mechanics.six_dof.frame import Frame, Pose, coordinates
from cdpr_interval.mechanics.six_dof.tube import SYMBOLS
from cdpr_interval.mechanics.six_dof.tube_fields import fill_tube_fields
from cdpr_interval.mechanics.stability import Stability
from solvers.answers.data import CableState, Certainty, Proof, Solution, Undecided
from solvers.questions.problem import Problem
from solvers.six_dof.cells.chain import Chain, ChainProver, Chains, model_of
from solvers.six_dof.cells.chain_cover import Carpet, Cover
from solvers.six_dof.cells.chain_parts import part_of, pieces
from solvers.six_dof.cells.columns import ROTATION_COLUMNS
from solvers.six_dof.cells.halves import cell_around
from solvers.six_dof.cells.roots import GENERAL, GEOMETRY, Root, lies_in, pose_of
from solvers.six_dof.cells.subset_search import SubsetSearch
from solvers.six_dof.cells.tube import Tube
from solvers.six_dof.clusters import clusters
from solvers.six_dof.prepared import cables_of, lengths_of
from solvers.six_dof.reduction import Reduced
from solvers.six_dof.solution import empty_fields, fields_of, middles, nominal_pose
from solvers.six_dof.switch import tensions_at
from solvers.six_dof.tube_report import fields_forms

Floats = NDArray[np.float64]

MOST_TAUT = 6
ROUNDED = 4e-16
"""Covers the rounding of a few operations, relative."""


@dataclass
class Searched:
    """What the search of one subset over ranges of lengths gave, in m and N."""

    taut: tuple[int, ...]
    reduced: Reduced
    search: SubsetSearch
    coarse: Floats
    """Cells in u that were left before lengths were cut; those left are parts of them."""
    roots: list[tuple[Root, Solution]] = field(default_factory=list)
    """Those that are entries."""
    regions: list[Undecided] = field(default_factory=list)

    @property
    def is_plain(self) -> bool:
        """The whole system in the robot's own frames was searched."""
        return self.reduced.reduction in (GENERAL, GEOMETRY)


@dataclass(frozen=True, eq=False)
class Found:
    """Chains, and the cables they are of: those that carry, then the one that may switch."""

    chains: Chain | Chains
    cables: tuple[int, ...]
    order: tuple[int, ...]
    """All cables as the chains have them."""

    def model(self, chain: Chain, reduced: Reduced, taut: tuple[int, ...]) -> Model:
        """Return the model of a subset's search for a chain's lengths."""
        model = reduced.model
        others = tuple(i for i in range(len(self.order)) if i not in taut)
        place = [self.order.index(i) for i in (*taut, *others)][: len(model.lengths)]
        lengths = chain.lengths
        lo, hi = np.nextafter(lengths[:, 0] ** 2, 0.0), np.nextafter(lengths[:, 1] ** 2, np.inf)
        middle = 0.5 * lo + 0.5 * hi
        off = np.nextafter(np.maximum(hi - middle, middle - lo), np.inf)
        # Where the chain has a symbol the model's is the same.
        n, first = len(self.cables) - 1, chain.tubes[0]
        middle[:n], off[:n] = first.squares[:n], first.radii_of_squares[:n]
        return model._replace(lengths=lengths[place], lengths_sq=middle[place], lengths_sq_err=off[place])

    def over(self, chain: Chain, tube: Tube, taut: tuple[int, ...]) -> Tube:
        """Return a tube of the subset with the cable over a chain's lengths, a part of its own."""
        first, lengths = chain.tubes[0], chain.lengths
        for symbol, i in enumerate(taut):
            j = self.order.index(i)
            square, off = float(first.squares[j]), float(first.radii_of_squares[j])
            if i == self.cables[-1]:
                lo, hi = lengths[j].tolist()
                square, off = 0.5 * (lo * lo + hi * hi), 0.5 * (hi * hi - lo * lo)
            own, radius = float(tube.squares[symbol]), float(tube.radii_of_squares[symbol])
            if radius > 0.0:
                size = np.abs(tube.polynomial[:, 1:]).sum(axis=1)
                moved = 8.0 * ROUNDED * (own + radius) / radius * size
                tube = part_of(tube, symbol, (square - own) / radius, off / radius)
                tube = replace(tube, radii=tube.radii + moved)
        return tube

    def carpet(self, chain: Chain, taut: tuple[int, ...]) -> Carpet:
        """Return a chain as cells of the subset with the cable see it."""
        return Carpet(chain, np.array([self.cables.index(i) for i in taut], dtype=np.int64))


def with_switching(
    problem: Problem,
    searched: Sequence[Searched],
    solutions: Sequence[Solution],
    regions: Sequence[Undecided],
    budget: Budget,
    threads: int,
) -> tuple[list[Solution], list[Undecided]]:
    """Return entries and regions where chains stand for the open entries at which one cable switches.

    A chain takes in the other entries that are proved to be its poses, and the regions of the subsets with
    the cable and without it as far as all their static poses are proved to be its own.
    """
    entries, left = list(solutions), list(regions)
    spread = problem.loaded.spread
    if not (spread.points_are_exact and is_zero(spread.load)):
        # Chains are proved for exact points and loads; a factor of the load moves no pose.
        return entries, left
    for own in searched:
        for _, solution in own.roots:
            if budget.stop() is not None:
                return entries, left
            if any(solution is e for e in entries) and CableState.UNDECIDED in solution.cable_states:
                entries, left = taken_in(problem, searched, solution, entries, left, budget, threads)
    return entries, left


def taken_in(
    problem: Problem,
    searched: Sequence[Searched],
    solution: Solution,
    entries: list[Solution],
    regions: list[Undecided],
    budget: Budget,
    threads: int,
) -> tuple[list[Solution], list[Undecided]]:
    """Return entries and regions after chains were tried from an open entry."""
    found = found_at(problem, solution)
    if found is None:
        return entries, regions
    entry = entry_of(problem, found.chains, found.cables, found.order, solution)
    if entry is None:
        return entries, regions
    subsets = {tuple(sorted(found.cables)), tuple(sorted(found.cables[:-1]))}
    near = [s for s in searched if s.taut in subsets]
    pairs = [(s, root, e) for s in near for root, e in s.roots if any(e is one for one in entries)]
    same = [
        e
        for s, root, e in pairs
        if is_same(found, s, root) or (meets(e, entry) and is_covered(found, s, root, budget, threads))
    ]
    if not any(e is solution for e in same):
        return entries, regions
    apart = [e for e in entries if not any(e is one for one in same)]
    if any(meets(e, entry) for e in apart):
        # One pose may not be listed twice.
        return entries, regions
    known = [e for e in same if e.is_decided]
    for own in near:
        own_regions = own.regions
        if not own_regions or not own.is_plain:
            continue
        own.search.undecided, own.search.undecided_position = left_of(found, own, budget, threads)
        own.regions = clusters(problem, own.taut, own.reduced, own.search, family=False)
        regions = [u for u in regions if not any(u is one for one in own_regions)] + own.regions
    return [*apart, *(known[:1] or [entry])], regions


def found_at(problem: Problem, solution: Solution) -> Found | None:
    """Return chains through the pose of an open entry for the middles of the lengths."""
    if solution.family is not None:
        return None
    opened = [i for i, state in enumerate(solution.cable_states) if state is CableState.UNDECIDED]
    for k in opened:
        carrying = (*solution.taut, *(i for i in opened if i != k and solution.tensions[i].any()))
        cables = (*sorted(i for i in carrying if i != k), k)
        if not 1 < len(cables) <= MOST_TAUT:
            continue
        start = start_at(problem, solution, cables)
        if start is None:
            continue
        prover = ChainProver(problem, cables, start[0])
        chains = prover.prove(start[1])
        if chains is not None:
            return Found(chains, cables, prover.order)
    return None


def start_at(problem: Problem, solution: Solution, cables: tuple[int, ...]) -> tuple[int, Floats] | None:
    """Return the chart and (u, p, t) (6 + n,) in floats of an entry's middle."""
    rotation = rotation_from_quaternion(solution.nominal.quaternion_wxyz)
    turned = to_matrix(rotation)
    origin = balls.vector([float(x) for x in solution.nominal.position])
    pose = Pose(turned, origin + turned * balls.ranges(problem.loaded.centre_ranges), ())
    chart = best_chart(rotation)
    where, t = coordinates(pose, Frame.plain(), chart), tensions_at(problem, cables, pose)
    if where is None or t is None:
        return None
    return chart, np.array([float(x.mid()) for x in (*where[0], *where[1], *t)])


def is_same(found: Found, own: Searched, root: Root) -> bool:
    """Return True when a root without the cable is proved to be the chains', for all lengths.

    The chains have a tube of its system over all lengths; here both zeros are the same for their middles.
    """
    if len(own.taut) == len(found.cables):
        return False
    boxes = np.array([part.lengths for part in found.chains.parts])
    squares = 0.5 * boxes[:, :, 0].min(axis=0) ** 2 + 0.5 * boxes[:, :, 1].max(axis=0) ** 2
    slack = found.chains.at(np.sqrt(squares)).slack
    at, _ = slack.zero_at(squares[: len(own.taut)])
    reach = slack.reach - 1e-12 * (1.0 + np.abs(at).max())
    unique = np.stack([at - reach, at + reach], axis=1)
    pose = pose_of(replace(root, box=root.core), own.reduced.frame)
    return bool((reach > 0.0).all()) and lies_in(
        pose, Frame.plain(), Root(slack.chart, unique, unique, unique)
    )


def is_covered(found: Found, own: Searched, root: Root, budget: Budget, threads: int) -> bool:
    """Return True when all static poses in a root's bounds, the cable taut, are proved to be the chains'."""
    if not own.is_plain or len(own.taut) < len(found.cables):
        return False
    if isinstance(root, Tube) and len(own.taut) < MOST_TAUT:
        chains, taut = found.chains.parts, own.taut
        return all(found.carpet(c, taut).has_tube(found.over(c, root, taut)) for c in chains)
    nothing = np.empty((0, ROTATION_COLUMNS.width))
    cell = cell_around(own.reduced.model, root)
    for chain in found.chains.parts:
        cover = Cover(found.model(chain, own.reduced, own.taut), own.reduced.reduction, budget, threads)
        if any(len(cells) for cells in cover.left(nothing, cell, found.carpet(chain, own.taut))):
            return False
    return True


def left_of(found: Found, own: Searched, budget: Budget, threads: int) -> tuple[Floats, Floats]:
    """Return the cells of a subset that may hold static poses which are not the chains'."""
    search = own.search
    coarse = containing(own.coarse, search.undecided)
    inside = contained(search.undecided, coarse)
    rest, kept = search.undecided[~inside], [np.empty((0, search.undecided.shape[1]))]
    in_position = [np.empty((0, search.undecided_position.shape[1]))]
    for chain in found.chains.parts:
        cover = Cover(found.model(chain, own.reduced, own.taut), own.reduced.reduction, budget, threads)
        if len(own.taut) == len(found.cables):
            carpet = found.carpet(chain, own.taut)
        else:
            carpet, cover.search.roots = None, [chain.slack]
        cells, positions = cover.left(np.concatenate([coarse, rest]), search.undecided_position, carpet)
        kept.append(cells)
        in_position.append(positions)
    left = np.unique(np.concatenate(kept), axis=0)
    return search.undecided[touching(search.undecided, left)], np.unique(np.concatenate(in_position), axis=0)


def containing(coarse: Floats, cells: Floats) -> Floats:
    """Return the coarse cells that contain one of the others."""
    if len(coarse) == 0 or len(cells) == 0:
        return coarse[:0]
    return coarse[[bool(contained(cells, one[None]).any()) for one in coarse]]


def contained(cells: Floats, coarse: Floats) -> NDArray[np.bool_]:
    """Return which cells in u (rows) lie in some coarse one."""
    found = np.zeros(len(cells), dtype=np.bool_)
    for one in coarse:
        inside = (one[0:6:2] <= cells[:, 0:6:2]) & (cells[:, 1:6:2] <= one[1:6:2])
        same = (cells[:, 6] == one[6]) & ((cells[:, 7] == one[7]) | (one[7] == 0.0))
        found |= inside.all(axis=1) & same
    return found


def touching(cells: Floats, others: Floats) -> NDArray[np.bool_]:
    """Return which cells in u (rows) touch one of the others."""
    found = np.zeros(len(cells), dtype=np.bool_)
    for one in others:
        near = (cells[:, 0:6:2] <= one[1:6:2]) & (one[0:6:2] <= cells[:, 1:6:2])
        found |= near.all(axis=1) & (cells[:, 6] == one[6])
    return found


def entry_of(
    problem: Problem,
    chains: Chain | Chains,
    cables: tuple[int, ...],
    order: tuple[int, ...],
    solution: Solution,
) -> Solution | None:
    """Return the entry of chains on ``cables``, the last of which switches; None where a bound fails.

    ``solution`` : an entry at the same pose, for what both have.
    """
    parts = [part for chain in chains.parts for part in pieces(chain)]
    fields = fields_over(problem, order, len(cables), [tube for _, tube in parts])
    k, n = cables[-1], len(cables)
    limits = lengths_of(problem).bounds
    lengths = np.array([chain[order.index(k)] for chain, _ in parts])
    # Where the cable is taut it is as long as it is; slack it is longer than its distance.
    too_far = fields.distances[:, k, 0] > lengths[:, 1]
    carries = np.array([tube.radii_of_squares[-1] > 0.0 for _, tube in parts])
    kept = ~(too_far | (carries & (fields.distances[:, k, 1] < lengths[:, 0])))
    if not kept.any() or not all(np.isfinite(x[kept]).all() for x in fields[:-1]):
        return None
    position, rotation, height, distances, densities = (
        hull(x[kept])
        for x in (fields.position, fields.rotation, fields.height, fields.distances, fields.densities)
    )
    tensions = np.zeros((len(order), 2))
    factor = enclose(problem.loaded.load_factor.lo)[0], enclose(problem.loaded.load_factor.hi)[1]
    for j, i in enumerate(cables):
        tensions[i] = interval.mul(*interval.mul(*densities[j], *limits[i]), *factor)
        if i != k:
            distances[i] = limits[i]
    tensions[k, 0] = 0.0
    tensions[:, 0] = np.maximum(tensions[:, 0], 0.0)
    distances[k, 1] = min(distances[k, 1], limits[k, 1])
    states = [CableState.TAUT if i in cables else CableState.SLACK for i in range(len(order))]
    states[k] = CableState.SWITCHING
    x, y, z = middles(position).tolist()
    return replace(
        solution,
        taut=tuple(sorted(cables[: n - 1])),
        cable_states=tuple(states),
        position=position,
        rotation=rotation,
        height=height,
        tensions=tensions,
        distances=distances,
        slack_respected=True,
        existence=Certainty.PROVED,
        uniqueness=Certainty.PROVED,
        proof=Proof.INTERVAL_NEWTON,
        stability=stability_of(problem, chains.parts[0], cables[: n - 1]),
        nominal=nominal_pose((x, y, z), middles(rotation)),
        note="",
    )


def stability_of(problem: Problem, chain: Chain, carrying: tuple[int, ...]) -> Stability:
    """Return the stability of the poses of chains, looked at for one without the cable that switches.

    Along the chains the derivative of the system with that tension given is regular: its inertia, that of the
    energy's second derivative bordered by the lengths', does not change. With the cable's length as one more
    border the number of negative directions is the same, as more tension draws the platform nearer.
    """
    tube = chain.slack
    taut = tuple(sorted(carrying))
    rows = np.array([*range(6), *(6 + carrying.index(i) for i in taut)])
    root = Root(tube.chart, tube.core[rows], tube.unique[rows], tube.core[rows])
    verdict = fields_of(cables_of(problem.loaded), lengths_of(problem), taut, Frame.plain(), [root]).verdicts[
        0
    ]
    if verdict == OPEN:
        return Stability.UNDECIDED
    return Stability.STABLE if verdict == STABLE else Stability.UNSTABLE


def hull(bounds: Floats) -> Floats:
    """Return the hull of bounds (m, .., 2) over the first axis."""
    return np.stack([bounds[..., 0].min(axis=0), bounds[..., 1].max(axis=0)], axis=-1)


def fields_over(problem: Problem, order: tuple[int, ...], n: int, tubes: list[Tube]) -> Fields:
    """Return what tubes report, verdicts and tensions left out."""
    fields = empty_fields(len(tubes), n, len(order))
    model, cables, frame = model_of(problem, order, n), cables_of(problem.loaded), Frame.plain().bounds
    forms, places = fields_forms(SYMBOLS), np.array(order, dtype=np.int64)
    for m, tube in enumerate(tubes):
        data = (tube.chart, tube.polynomial, tube.sways, tube.radii)
        fill_tube_fields(forms, SYMBOLS, model, cables, frame, *data, places, fields, m)
    return fields


def meets(one: Solution, other: Solution) -> bool:
    """Return True when the bounds of two entries' poses have a pose in common."""
    pairs = ((one.position, other.position), (one.rotation, other.rotation))
    return all(np.all((a[..., 0] <= b[..., 1]) & (b[..., 0] <= a[..., 1])) for a, b in pairs)
