"""What the leaves of a search tree say of their cells, confirmed or refused."""

from __future__ import annotations

from fractions import Fraction

from certificates.arithmetic.forms import UNIT, Vector, box_forms
from certificates.balance import unbalanced
from certificates.cells import Place, no_position, on_branch
from certificates.clock import in_time
from certificates.geometry import Turned
from certificates.search import Search
from certificates.tree import Cell, Leaf, Node
from certificates.verdicts import NotProved

PIECES = 256
"""A leaf is bisected into at most so many parts."""
POSITION_SHARE = 0.4
"""Width of x over the platform's size that counts as much as a width of u, where a cell is bisected."""


def check_leaf(search: Search, leaf: Leaf) -> int:
    """Check a leaf, bisected where it must be; return the number of parts."""
    if leaf.node in (Node.PENDING, Node.UNDECIDED):
        return 0
    waiting, parts = [leaf.cell], 0
    while waiting:
        in_time()
        cell = waiting.pop()
        if confirmed(search, leaf, cell):
            parts += 1
            continue
        if leaf.node is Node.CUT or parts + len(waiting) >= PIECES:
            raise NotProved(f"{leaf.node.reason} is not confirmed in chart {cell.chart}, {cell.bounds}")
        waiting += cell.halves(longest(search, cell))
    return parts


def longest(search: Search, cell: Cell) -> int:
    """Return the entry in which a cell is bisected."""
    share = POSITION_SHARE * float(search.platform.per_unit)
    widths = [(hi - lo) * (1.0 if k < 3 else share) for k, (lo, hi) in enumerate(cell.bounds)]
    return widths.index(max(widths))


def confirmed(search: Search, leaf: Leaf, cell: Cell) -> bool:
    """Return True when what is said of a leaf is proved over a part of it."""
    entries = box_forms(cell.bounds)
    turned = Turned(search.forms, cell.chart, entries[:3])
    if cell.placed:
        return holds(search, leaf, cell, turned, entries[3:])
    if leaf.node is Node.NO_POSITION:
        return no_position(turned)
    return all(on_side(search, leaf, cell, turned, side) for side in ((cell.side,) if cell.side else (1, -1)))


def on_side(search: Search, leaf: Leaf, cell: Cell, turned: Turned, side: int) -> bool:
    """Return True when what is said of a leaf in u is proved on one side."""
    x = on_branch(turned, side)
    if x is not None and holds(search, leaf, cell, turned, x):
        return True
    return no_position(turned)


def holds(search: Search, leaf: Leaf, cell: Cell, turned: Turned, x: Vector) -> bool:
    """Return True when what is said of a leaf is proved for an enclosed position x.

    One branch for each kind of leaf; all of them speak of poses at which the taut cables have their lengths.
    """
    if leaf.node is Node.ROOT:
        place = [(Fraction(v.lowest(), UNIT), Fraction(v.highest(), UNIT)) for v in x]
        return any(root.holds(cell.chart, [*cell.bounds[:3], *place]) for root in search.roots)
    over = Place(turned, x, not cell.placed)
    if leaf.node is Node.NO_LENGTH:
        return over.no_length()
    if leaf.node is Node.CUT:
        assert leaf.kept is not None
        return all(
            over.cut_to(k, old, new)
            for k, (old, new) in enumerate(zip(cell.bounds, leaf.kept.bounds, strict=True))
        )
    if leaf.node is Node.TOO_LONG:
        cable = leaf.data[0]
        return search.may_be_slack(cable) and over.positive(turned.excess(search.place_of(cable), x))
    if search.problem.ignore_tension_sign:
        return False
    # Part of such a leaf may lie beside all poses with the right lengths, where balance says nothing.
    return (len(over.equations) > 1 and over.no_length()) or unbalanced(over, leaf.data)
