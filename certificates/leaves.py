"""What the leaves of a search tree say of their cells, confirmed or refused, many at a time.

Doubles first (`Floats`), a leaf bisected where it must be. What they do not confirm, and what is to be looked
at twice, is checked by `Integers` from the beginning.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from certificates.arithmetic.floats import Floats
from certificates.arithmetic.forms import Array, Form, Vector
from certificates.arithmetic.integers import Integers
from certificates.balance import unbalanced
from certificates.cells import Place, no_position, on_branch
from certificates.clock import in_time
from certificates.geometry import Rotated
from certificates.search import Search
from certificates.tree import Leaf, Node
from certificates.verdicts import NotProved

PIECES = 256
"""A leaf is bisected into at most so many parts."""
LANES = 1024
"""Cells in one go: their forms stay in the processor's cache, and a step of numpy is worth its call."""
POSITION_SHARE = 0.4
"""Width of x over the platform's size that counts as much as a width of u, where a cell is bisected."""


@dataclass(frozen=True)
class Cells:
    """Leaves of one kind, on one side, or parts of them."""

    node: Node
    side: int
    chart: Array
    """(N,)."""
    bounds: Array
    """(3 or 6, 2, N), of u or (u, x)."""
    owner: Array
    """(N,), which leaves they are, or are parts of."""
    data: Array
    """(6, N): y; a cable."""
    kept: Array
    """(3 or 6, 2, N), of a cut."""

    @staticmethod
    def of(leaves: Sequence[Leaf], owner: Array) -> Cells:
        """Return leaves of the same kind as cells."""
        first, kept = leaves[0], [v.kept for v in leaves if v.kept]
        return Cells(
            first.node,
            first.cell.side,
            np.array([v.cell.chart for v in leaves]),
            np.moveaxis(np.array([v.cell.bounds for v in leaves]), 0, -1),
            owner,
            np.array([v.data for v in leaves], dtype=float).T,
            np.moveaxis(np.array([v.bounds for v in kept]), 0, -1) if kept else np.zeros((0, len(leaves))),
        )

    def __len__(self) -> int:
        return len(self.owner)

    def at(self, chosen: Array) -> Cells:
        """Return some of them."""
        return self.with_arrays(lambda k: getattr(self, k)[..., chosen])

    def with_more(self, *others: Cells) -> Cells:
        """Return these and others of their kind."""
        return self.with_arrays(lambda k: np.concatenate([getattr(v, k) for v in (self, *others)], axis=-1))

    def with_arrays(self, of: Callable[[str], Array]) -> Cells:
        """Return cells with other arrays, given by their names."""
        parts = {"chart": of("chart"), "bounds": of("bounds"), "owner": of("owner"), "data": of("data")}
        return replace(self, **parts, kept=of("kept"))

    def halves(self, search: Search) -> tuple[Cells, Cells]:
        """Return the lower and the upper halves, split where they are longest."""
        k, cells = longest(search, self.bounds), np.arange(len(self))
        lower, upper = self.at(cells), self.at(cells)
        middle = 0.5 * (self.bounds[k, 0, cells] + self.bounds[k, 1, cells])
        lower.bounds[k, 1, cells] = upper.bounds[k, 0, cells] = middle
        return lower, upper


def longest(search: Search, bounds: Any) -> Array:
    """Return the entries in which cells with bounds (3 or 6, 2, ...) are bisected."""
    share = POSITION_SHARE * float(search.platform.per_unit)
    widths = np.asarray(bounds)[:, 1] - np.asarray(bounds)[:, 0]
    return np.argmax((widths.T * ([1.0] * 3 + [share] * 3)[: len(widths)]).T, axis=0)


def kind_of(leaf: Leaf) -> tuple[int, ...]:
    """Return what leaves must have in common to be checked together."""
    cable = leaf.data[0] if leaf.node is Node.TOO_LONG else 0
    return leaf.node, leaf.cell.side, len(leaf.cell.bounds), cable


def confirmed_at_once(search: Search, leaves: Sequence[Leaf]) -> Array:
    """Return which leaves and cuts are confirmed by doubles, none of them bisected."""
    found, kinds = np.zeros(len(leaves), dtype=bool), [kind_of(leaf) for leaf in leaves]
    for kind in set(kinds):
        some = [i for i, other in enumerate(kinds) if other == kind]
        found[some] = confirmed(search, Cells.of([leaves[i] for i in some], np.array(some)), Floats)
    return found


def check_cells(search: Search, cells: Cells, twice: Array) -> int:
    """Check leaves, those marked in both arithmetics; return the number of parts.

    Raises `NotProved` that names the first leaf that is not confirmed.
    """
    if cells.node in (Node.PENDING, Node.UNDECIDED):
        return 0
    refused, parts = bisected(search, cells, Floats)
    again = np.flatnonzero(refused | twice)
    failed = again[bisected(search, cells.at(again), Integers)[0]]
    if len(failed):
        i = failed[0]
        doubt = "" if refused[i] else " by integers, but by doubles"
        where = [tuple(b) for b in cells.bounds[..., i].tolist()]
        what = f"cell {cells.owner[i] + 1}: {cells.node.reason} is not confirmed{doubt}"
        raise NotProved(f"{what} in chart {cells.chart[i]}, {where}")
    return parts


def bisected(search: Search, cells: Cells, kind: type[Form]) -> tuple[Array, int]:
    """Return which cells are not confirmed, whole or in parts, and how many parts were."""
    pieces, parts = np.ones(len(cells), dtype=int), 0
    refused = np.zeros(len(cells), dtype=bool)
    waiting = replace(cells, owner=np.arange(len(cells)))
    while len(waiting):
        in_time()
        some, waiting = waiting.at(slice(LANES)), waiting.at(slice(LANES, None))
        is_one = confirmed(search, some, kind)
        parts += int(is_one.sum())
        left = some.at(~is_one)
        np.add.at(pieces, left.owner, 1)
        refused |= pieces > PIECES
        if cells.node is Node.CUT:
            refused[left.owner] = True
        left = left.at(~refused[left.owner])
        waiting = waiting.with_more(*left.halves(search)) if len(left) else waiting
    return refused, parts


@np.errstate(all="ignore")
def confirmed(search: Search, cells: Cells, kind: type[Form]) -> Array:
    """Return of which cells is proved what their leaves say; what overflows is no proof."""
    if len(cells.bounds) == 6:
        return in_some_view(search, cells, kind)
    entries: Vector = [kind.between(lo, hi, k) for k, (lo, hi) in enumerate(cells.bounds)]
    rotated = Rotated(search.over(kind), cells.chart, entries)
    if cells.node is Node.NO_POSITION:
        return no_position(rotated)
    found = np.ones(len(cells), dtype=bool)
    for side in (cells.side,) if cells.side else (1, -1):
        found &= on_side(search, cells, rotated, side)
    return found


def in_some_view(search: Search, cells: Cells, kind: type[Form]) -> Array:
    """Return of which cells in (u, x) is proved what their leaves say, by one set of equations or another."""
    found = np.zeros(len(cells), dtype=bool)
    for view in search.views:
        left = np.flatnonzero(~found)
        if not len(left):
            break
        some = cells.at(left)
        entries: Vector = [kind.between(lo, hi, k) for k, (lo, hi) in enumerate(some.bounds)]
        rotated = view(search.over(kind), some.chart, entries[:3])
        found[left] = holds(search, some, rotated, entries[3:])
    return found


def on_side(search: Search, cells: Cells, rotated: Rotated, side: int) -> Array:
    """Return of which cells in u is proved, on one side, what their leaves say."""
    x, is_enclosed = on_branch(rotated, side)
    found = is_enclosed & holds(search, cells, rotated, x)
    return found if found.all() else found | no_position(rotated)


def holds(search: Search, cells: Cells, rotated: Rotated, x: Vector) -> Array:
    """Return of which cells is proved what their leaves say, for an enclosed position x.

    One branch for each kind of leaf; all of them speak of poses at which the taut cables have their lengths.
    """
    found = np.zeros(len(cells), dtype=bool)
    if cells.node is Node.ROOT:
        for root in search.roots:
            found |= root.holds(cells.chart, cells.bounds[:3], x)
        return found
    over = Place(rotated, x, len(cells.bounds) == 3)
    if cells.node is Node.NO_LENGTH:
        return over.no_length()
    if cells.node is Node.CUT:
        each = enumerate(zip(cells.bounds, cells.kept, strict=True))
        return np.all([over.cut_to(k, old, new) for k, (old, new) in each], axis=0)
    if cells.node is Node.TOO_LONG:
        cable = int(cells.data[0, 0])
        if not search.may_be_slack(cable):
            return found
        found = over.positive(rotated.excess(search.place_of(cable), x))
    elif search.problem.ignore_tension_sign:
        return found
    else:
        found = unbalanced(over, cells.data)
    # Part of such a leaf may lie beside all poses with the right lengths, where neither says anything.
    if len(over.equations) > 1 and not found.all():
        found |= over.no_length()
    return found
