"""The proof of one subset of cables over pulleys: cells of (u, p), by the checker's tests.

The checker's own tests, on many cells at once, are the search here: what they confirm becomes a leaf or a
cut, what they do not is halved. Nothing here needs to be trusted: what is written is checked.
"""

from __future__ import annotations

import base64
import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.mechanics.rotation import rotation_at
from certificates.arithmetic import guess
from certificates.arithmetic.floats import Floats
from certificates.arithmetic.forms import stacked
from certificates.arithmetic.guess import usable
from certificates.arithmetic.rotations import HALF_TURNS
from certificates.balance import unbalanced
from certificates.cells import Place
from certificates.leaves import LANES
from certificates.problem import Listed
from certificates.problem import Problem as Question
from certificates.root_claims import check_root
from certificates.search import Root as Claimed
from certificates.search import RoutedSearch
from certificates.tree import Node
from certificates.verdicts import NotProved
from solvers.proofs.account import Account
from solvers.proofs.allowance import Allowance
from solvers.proofs.claims import NEAR, root_entry
from solvers.six_dof.cells.roots import Root

Array = NDArray[np.float64]

FIRST, LAST = -4, -16
"""Powers of two: half widths of root boxes that are tried, in u and over the platform's size in p."""
BEYOND = 1.5
"""Roots with entries of u up to this are claimed in a chart: their boxes may reach into it."""
POSITION_SHARE = 0.3
"""Width of p over the platform's size that counts as much as a width of u, where a cell is bisected."""
SMALLEST = 1e-4
"""Width at which a cell is written as undecided."""
MOST_UNDECIDED = 2_000
MOST_CELLS = 4_000_000
"""Of one search, after which no more is tried."""
USEFUL_CUT = 0.7
"""A cut is made when some entry keeps at most this share of its width."""
WIDER, ROUNDING = 1e-9, 2.0**-40
"""A kept interval is widened by this share of its width, and of itself, so that the checker confirms it."""
LARGEST = 2.0**30
"""Of the integers of a direction."""

UNKNOWN: tuple[bytes, tuple[int, ...]] = b"", ()


class RoutedRecorder:
    """Makes the search of one subset, and writes it."""

    def __init__(
        self, question: Question, taut: tuple[int, ...], roots: Sequence[Root], listed: list[Listed]
    ) -> None:
        entry = {"order": list(taut), "roots": [], "trees": [None] * 4}
        self.search = RoutedSearch(question, taut, entry, len(listed))
        self.found, self.listed = roots, listed
        self.platform: Any = self.search.over(Floats)
        self.unit = 1.0 / float(self.search.platform.per_unit)
        self.nodes: list[tuple[bytes, tuple[int, ...]]] = [UNKNOWN] * 4
        """What is known of each cell, and the cells it leaves; the first four are the charts."""
        self.undecided = 0

    def claim_roots(self, allowance: Allowance, account: Account) -> None:
        """Add what the checker confirms about the roots, until the allowance is spent."""
        for root in self.found:
            for chart, middle in seen_in_charts(root):
                if allowance.is_spent:
                    return
                with allowance.spending():
                    account.step(0.0)
                    found = self.claim(chart, middle)
                    if found is not None:
                        self.search.roots.append(found)

    def claim(self, chart: int, middle: Array) -> Claimed | None:
        """Return a claim about a root that the checker confirms, in the largest box that is tried, if any."""
        halves = [2.0**k for k in range(FIRST, LAST, -1)]
        reach = np.array([1.0] * 3 + [self.unit] * 3)
        boxes = np.array(
            [[(m - h * r, m + h * r) for m, r in zip(middle, reach, strict=True)] for h in halves]
        )
        holds = self.search.system(chart).one_zero(np.moveaxis(boxes, 0, -1), Floats)
        if not holds.any():
            return None
        box = [(float(lo), float(hi)) for lo, hi in boxes[int(np.argmax(holds))]]
        turned = rotation(chart, middle)
        near = [
            k for k, s in enumerate(self.listed) if np.all(abs(turned - np.mean(s.rotation, axis=-1)) < NEAR)
        ]
        for pose in (*near, None):
            claimed = Claimed(chart, box, pose)
            try:
                check_root(self.search, claimed, self.listed)
            except NotProved:
                continue
            return claimed
        return None

    def complete(self, allowance: Allowance, account: Account, threads: int) -> None:
        """Search until every cell is settled, or the budget is spent."""
        starts = [self.search.start(chart, ()).bounds for chart in range(4)]
        waiting = Waiting(np.arange(4), np.moveaxis(np.array(starts), 0, -1), np.arange(4))
        account.next_step()
        with allowance.spending(), np.errstate(all="ignore"):
            while len(waiting) and allowance.budget.stop() is None:
                if self.undecided > MOST_UNDECIDED or len(self.nodes) > MOST_CELLS:
                    return
                some, waiting = waiting.at(slice(-LANES, None)), waiting.at(slice(None, -LANES))
                account.step(0.0)
                waiting = waiting.with_more(*self.parts(*self.looked(some)))

    def looked(self, some: Waiting) -> tuple[Waiting, Array]:
        """Settle cells; return those that are not, and bounds (6, 2, N) of the poses in them."""
        left, kept = np.arange(len(some)), some.bounds.copy()
        for view in self.search.views:
            cells = some.at(left)
            entries = [Floats.between(lo, hi, k) for k, (lo, hi) in enumerate(cells.bounds)]
            rotated = view(self.platform, cells.chart, entries[:3])
            place = Place(rotated, entries[3:], False)
            found = np.zeros(len(cells), dtype=bool)
            for holds, nodes in self.reasons(cells, place):
                for i in np.flatnonzero(holds & ~found).tolist():
                    self.nodes[cells.number[i]] = nodes(i), ()
                found |= holds
            cut = bounds_kept(place, cells.bounds)
            confirmed = [place.cut_to(k, *pair) for k, pair in enumerate(zip(cells.bounds, cut, strict=True))]
            cut = np.where(np.all(confirmed, axis=0), cut, cells.bounds)
            better = volumes(cut) < volumes(kept[..., left])
            kept[..., left] = np.where(better, cut, kept[..., left])
            left = left[~found]
            if not len(left):
                break
        return some.at(left), kept[..., left]

    def reasons(self, cells: Waiting, place: Place) -> Iterator[tuple[Any, Callable[[int], bytes]]]:
        """Yield where a leaf may be written, and the leaf of each cell, for one reason after the other."""
        search, rotated = self.search, place.rotated
        yield place.no_length(), partial(always, bytes([Node.NO_LENGTH]))
        for root in search.roots:
            yield root.holds(cells.chart, cells.bounds[:3], place.x), partial(always, bytes([Node.ROOT]))
        for cable in range(len(search.problem.names)):
            if search.may_be_slack(cable):
                excess = rotated.excess(search.place_of(cable), place.x)
                node = bytes([Node.TOO_LONG, cable])
                yield place.positive(excess), partial(always, node)
        y = directions(rotated.wrenches(place.x))
        yield unbalanced(place, y), lambda i: struct.pack("<B6i", Node.UNBALANCED, *map(int, y[:, i]))

    def parts(self, cells: Waiting, kept: Array) -> list[Waiting]:
        """Return what is left of cells, cut or halved."""
        widths = (kept[:, 1] - kept[:, 0]).T * ([1.0] * 3 + [POSITION_SHARE / self.unit] * 3)
        entry, is_small = np.argmax(widths, axis=1), np.max(widths, axis=1) < SMALLEST
        is_cut = np.any(kept != cells.bounds, axis=(0, 1)) & ~is_small
        is_halved = ~is_cut & ~is_small
        for i, number in enumerate(cells.number):
            if is_small[i]:
                self.undecided += 1
                self.nodes[number] = bytes([Node.UNDECIDED]), ()
                continue
            first = len(self.nodes)
            below = (first,) if is_cut[i] else (first, first + 1)
            node = cut_node(cells.bounds[..., i], kept[..., i]) if is_cut[i] else bytes([entry[i]])
            # In one step each: an interrupt may come between two.
            self.nodes += [UNKNOWN] * len(below)
            self.nodes[number] = node, below
        first_of = np.array([(*self.nodes[number][1], 0)[0] for number in cells.number], dtype=int)
        cut = Waiting(cells.chart[is_cut], kept[..., is_cut], first_of[is_cut])
        lower, k, numbers = kept[..., is_halved].copy(), entry[is_halved], np.arange(int(is_halved.sum()))
        upper, chart = lower.copy(), cells.chart[is_halved]
        lower[k, 1, numbers] = upper[k, 0, numbers] = 0.5 * (lower[k, 0, numbers] + lower[k, 1, numbers])
        halves = [Waiting(chart, half, first_of[is_halved] + j) for j, half in enumerate((lower, upper))]
        return [cut, *halves]

    def entry(self) -> dict[str, Any]:
        """Return the search as the document has it."""
        trees = [base64.b64encode(self.encoded(chart)).decode("ascii") for chart in range(4)]
        return {
            "order": list(self.search.order),
            "roots": [root_entry(r) for r in self.search.roots],
            "trees": trees,
        }

    def encoded(self, start: int) -> bytes:
        """Return a chart's tree; what was not looked at is pending."""
        found, waiting = [], [start]
        while waiting:
            number = waiting.pop()
            node, below = self.nodes[number]
            found.append(node or bytes([Node.PENDING]))
            waiting += reversed(below)
        return b"".join(found)


@dataclass(frozen=True)
class Waiting:
    """Cells that are to be looked at."""

    chart: Any
    """(N,)."""
    bounds: Array
    """(6, 2, N)."""
    number: Any
    """(N,)."""

    def __len__(self) -> int:
        return len(self.chart)

    def at(self, chosen: Any) -> Waiting:
        """Return some of them."""
        return Waiting(self.chart[chosen], self.bounds[..., chosen], self.number[chosen])

    def with_more(self, *others: Waiting) -> Waiting:
        """Return these and others."""
        some = (self, *others)
        return Waiting(
            np.concatenate([c.chart for c in some]),
            np.concatenate([c.bounds for c in some], axis=-1),
            np.concatenate([c.number for c in some]),
        )


def always(node: bytes, cell: int) -> bytes:
    """Return the same node for every cell."""
    return node


def volumes(bounds: Array) -> Array:
    """Return the volumes of boxes (6, 2, N)."""
    return np.asarray(np.prod(bounds[:, 1] - bounds[:, 0], axis=0))


def cut_node(old: Array, new: Array) -> bytes:
    """Return the node that cuts a cell (6, 2) to new bounds."""
    changed = [k for k in range(6) if np.any(old[k] != new[k])]
    return struct.pack(
        f"<BB{2 * len(changed)}d", Node.CUT, sum(1 << k for k in changed), *new[changed].ravel()
    )


def bounds_kept(place: Place, bounds: Array) -> Array:
    """Return bounds (6, 2, N) that poses in cells probably keep, the same where that is no use."""
    found = bounds.copy()
    cells = np.arange(bounds.shape[-1])
    for e, columns in enumerate(place.columns):
        form = Floats.combine(place.inverse[e], place.equations)
        chosen = np.flatnonzero(columns >= 0)
        k = columns[chosen]
        slopes = np.broadcast_to(form.slopes, (len(form.slopes), bounds.shape[-1]))
        a = slopes[k, chosen]
        rest = np.broadcast_to(form.change(), cells.shape)[chosen] - abs(a)
        value = np.broadcast_to(form.value, cells.shape)[chosen]
        lo, hi = bounds[k, 0, chosen], bounds[k, 1, chosen]
        middle, radius = 0.5 * (lo + hi), 0.5 * (hi - lo) / a
        tighten(found, k, chosen, middle - radius * (value + rest), middle + radius * (rest - value))
    return found


def tighten(bounds: Array, k: Any, cells: Any, low: Array, high: Array) -> None:
    """Cut entries ``k`` of ``cells`` to bounds and a little more, where that is of use."""
    lo, hi = bounds[k, 0, cells], bounds[k, 1, cells]
    slack = WIDER * (hi - lo) + ROUNDING * np.maximum(1.0, np.maximum(abs(lo), abs(hi)))
    low, high = np.maximum(lo, low - slack) + 0.0, np.minimum(hi, high + slack) + 0.0
    use = (low < high) & (high - low <= USEFUL_CUT * (hi - lo))
    bounds[k[use], 0, cells[use]], bounds[k[use], 1, cells[use]] = low[use], high[use]


def directions(wrenches: Sequence[Sequence[Any]]) -> Array:
    """Return directions (6, N) of integers, short ones along which all wrenches pull."""
    values = stacked([stacked([v.doubles() for v in w]) for w in wrenches])
    y = usable(guess.direction(values, np.ones(values.shape[::2]))[0])
    size = np.max(abs(y), axis=0)
    return np.rint(y * (LARGEST / np.where(size > 0.0, size, 1.0)))


def rotation(chart: int, middle: Array) -> Array:
    """Return R(u) D_c."""
    found = np.empty((3, 3))
    rotation_at(middle[:3].copy(), found)
    return found * np.array(HALF_TURNS[chart])


def seen_in_charts(root: Root) -> Iterator[tuple[int, Array]]:
    """Yield charts, and the middle of a root (u, p) in them, that show it within or not far beyond."""
    middle = root.core.mean(axis=1)
    r = rotation(root.chart, middle)
    for chart in range(4):
        turned = r * np.array(HALF_TURNS[chart])
        size = 1.0 + np.trace(turned)
        if size > 1e-9:
            skew = [turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]]
            u = np.array(skew) / size
            if np.max(abs(u)) < BEYOND:
                yield chart, np.array([*u, *middle[3:6]])
