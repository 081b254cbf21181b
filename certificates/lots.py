"""Lots of cells of one kind, of all that are to be checked, and the worker that checks them."""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict
from collections.abc import Container, Iterable, Iterator, Sequence

import numpy as np

from certificates.arithmetic.forms import Array
from certificates.certificate import Certificate, about
from certificates.leaves import Cells, kind_of
from certificates.searches import SubsetSearches
from certificates.tree import Leaf

MOST = 4096
"""Cells of a lot, and between two steps of the progress."""
Lot = tuple[int, int, Cells, Array]
"""A subset, its search, some cells of one kind, and which of them are checked in both arithmetics."""


def lots(
    certificate: Certificate, cells: Sequence[int], chosen: Sequence[int], twice: Container[int]
) -> Iterator[Lot]:
    """Yield the chosen cells of all subsets, of which there are so many each, those of one kind together."""
    first = 0
    for k, count in enumerate(cells):
        wanted = {i - first for i in chosen[bisect_left(chosen, first) : bisect_left(chosen, first + count)]}
        found = certificate.leaves(k) if wanted else ()
        leaves = ((i, *leaf) for i, leaf in enumerate(found) if i in wanted)
        for place, some in alike(leaves):
            places = np.array([i for i, _ in some])
            marked = np.array([first + i in twice for i in places])
            yield k, place, Cells.of([leaf for _, leaf in some], places), marked
        first += count


def alike(leaves: Iterable[tuple[int, int, Leaf]]) -> Iterator[tuple[int, list[tuple[int, Leaf]]]]:
    """Yield searches, and leaves with their numbers that can be checked together."""
    waiting: dict[tuple[int, ...], list[tuple[int, Leaf]]] = defaultdict(list)
    for i, place, leaf in leaves:
        kind = (place, *kind_of(leaf))
        waiting[kind].append((i, leaf))
        if len(waiting[kind]) == MOST:
            yield place, waiting.pop(kind)
    yield from ((kind[0], some) for kind, some in waiting.items())


class Worker:
    """Checks cells; the searches of the subset at hand are kept."""

    def __init__(self, certificate: Certificate) -> None:
        self.certificate = certificate
        self.at: tuple[int, SubsetSearches] | None = None

    def check(self, lot: Lot) -> int:
        """Check some cells; return the number of parts it took."""
        k, place, cells, twice = lot
        with about(self.certificate.name(k)):
            if self.at is None or self.at[0] != k:
                self.at = k, self.certificate.searches(k)
            return self.at[1].check(place, cells, twice)


def in_turn(certificate: Certificate, lots: Iterator[Lot]) -> Iterator[tuple[int, int]]:
    """Yield the size of each lot, and the number of parts, once it is checked."""
    one = Worker(certificate)
    for lot in lots:
        yield len(lot[2]), one.check(lot)
