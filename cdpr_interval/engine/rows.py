"""The rows of the scratch arrays that belong to the engine, the tables of all rows, and the states of lanes.

For a batch of cells kernels fill two arrays (``engine.scratch``): ``F`` holds forms, ``W`` plain floats. Who
needs rows of them takes them from a table under a name; that name is the only way to say where they are. A
robot's table goes on where the engine's ends. No two ranges share rows, so no kernel can destroy what
another one left, whatever is called in which order.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations
from typing import NamedTuple

from cdpr_interval.kernels.second_order import POSE_AND_ALL_DATA

EMPTY, OPEN, SMALLER, WIDE, UNSMOOTH, BOTH = range(6)
"""States of a lane. EMPTY: it holds no cell, or one without a solution; OPEN: nothing is known yet; SMALLER:
its cell was cut and is its own child; WIDE: its cell is too wide to be contracted; UNSMOOTH: what is
eliminated is no smooth function over its cell; BOTH: its cell stands for two branches."""
NO_POSITION, NO_LENGTH, NOT_SLACK, UNBALANCED, SETTLED, UNLOADED = range(BOTH + 1, BOTH + 7)
"""States of lanes proved empty, by reason: the triple's spheres have no common point, a taut cable's length
cannot hold, another cable would be too long, no tensions balance the load, all is in one root's box, only
cables at the centre of mass have tension (these poses are a smaller subset's)."""
SMALL, FOLDED = 1, 2
"""Kinds of leaves: smaller than the leaf size; without smooth branches, to be searched in all variables."""

MOST_VARIABLES = 6
"""Most variables of a search."""
MOST_SYMBOLS = len(POSE_AND_ALL_DATA.noise)
"""Most noise symbols of a form."""
MOST_DATA = len(POSE_AND_ALL_DATA.data)
"""Most symbols of data."""
MOST_EQUATIONS = 12
"""Most forms that vanish at every solution: six lengths and six balances."""
MOST_PIVOTS = 6
"""Most equations that are solved for one symbol each."""


class Rows(NamedTuple):
    """A range of rows of an array, and how many of their columns are used."""

    name: str
    first: int
    height: int
    columns: int

    @property
    def end(self) -> int:
        """The row behind the last one."""
        return self.first + self.height


class Table:
    """Ranges of rows, one behind another."""

    def __init__(self, ranges: Iterable[Rows] = ()) -> None:
        self.ranges = list(ranges)

    def take(self, name: str, height: int = 1, columns: int = 1) -> int:
        """Add a range behind all others; return its first row, a constant for kernels."""
        first = self.height
        self.ranges.append(Rows(name, first, height, columns))
        return first

    @property
    def height(self) -> int:
        """Rows that an array needs."""
        return max((rows.end for rows in self.ranges), default=0)

    @property
    def columns(self) -> int:
        """Columns that an array needs."""
        return max((rows.columns for rows in self.ranges), default=0)

    def overlaps(self) -> list[tuple[str, str]]:
        """Return the names of ranges that share a row."""
        pairs = combinations(self.ranges, 2)
        return [(a.name, b.name) for a, b in pairs if a.first < b.end and b.first < a.end]


FORMS = Table()
"""Rows of F. How many columns a form has depends on its symbols, see ``second_order.width``."""
SCRATCH = FORMS.take("SCRATCH", 7)
"""Rows used inside one function."""
EQUATION = FORMS.take("EQUATION", MOST_EQUATIONS)
"""Forms that vanish at every solution."""
PIVOT = FORMS.take("PIVOT", MOST_PIVOTS)
"""Such forms, solved for one symbol each."""

WORK = Table()
"""Rows of W."""
FLAGS = WORK.take("FLAGS", 1, 4)
"""Passes what was proved lane by lane between lanes and single numbers; its places:"""
COVERED, MARKED, NEEDED, BOUNDED = range(4)
VERDICTS = WORK.take("VERDICTS")
"""What a contraction did to the cells: EMPTY, OPEN (little) or SMALLER. Set it to OPEN before; a lane that is
EMPTY is left alone."""
PIVOTS = WORK.take("PIVOTS", 1, MOST_PIVOTS)
"""The symbol of each pivot; -1 where a lane has fewer."""
TABLEAU = WORK.take("TABLEAU", MOST_PIVOTS, MOST_SYMBOLS + MOST_PIVOTS)
"""Gauss-Jordan elimination, an equation a row: slopes in the symbols, then multipliers of the equations."""
CUT = WORK.take("CUT", 1, 2)
"""What a variable is cut to; its places:"""
LOW, HIGH = range(2)
WEIGHTS = WORK.take("WEIGHTS", 1, MOST_EQUATIONS)
"""Weights of the equations, where they are useful."""
SYSTEM = WORK.take("SYSTEM", MOST_VARIABLES, MOST_VARIABLES + MOST_EQUATIONS)
"""Normal equations of a contraction: the matrix, then a right side for each equation."""
