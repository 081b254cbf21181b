"""The columns of the two kinds of cells: bounds of the variables first, the share of the search last."""

from __future__ import annotations

from typing import NamedTuple


class Columns(NamedTuple):
    """What the columns of a kind of cells mean; the variables' bounds come first, lo and hi of each."""

    variables: int
    """Search variables: u, then x where the position is one of them."""
    chart: int
    branch: int
    """Column of the branch (1, -1, or 0 for both); -1 where cells have none."""
    share: int
    """Share of the search volume."""
    width: int

    @property
    def in_position(self) -> bool:
        """Whether the position is a search variable."""
        return self.variables > 3


ROTATION_COLUMNS = Columns(variables=3, chart=6, branch=7, share=8, width=9)
"""Cells in u alone, on one branch of the position."""
POSE_COLUMNS = Columns(variables=6, chart=12, branch=-1, share=13, width=14)
"""Cells in (u, x); x = p + r_1 - A_1 of the pivot."""
