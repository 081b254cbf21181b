"""Tubes as data: one zero for every choice of the lengths, in one piece or put together from halves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.mechanics.rotation import HALF_TURNS
from cdpr_interval.mechanics.six_dof.rows import ARM_SYMBOLS, LOAD_SYMBOLS, MOST_TAUT
from solvers.six_dof.cells.roots import Root

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Tube(Root):
    """One zero for every choice of the data, none other within its reach.

    ``box`` bounds all its zeros, ``core`` the zero at the middle of the data; ``unique`` is what is within
    reach there. Two tubes that share a zero for one choice share it for all: zeros move continuously with the
    data, and none leaves its tube. Where points or load have ranges, the lengths are distances of the middle
    points (see ``mechanics.six_dof.tube``) but with ``own_points``, and a choice of lengths here is one with
    the middle points.
    """

    squares: Floats
    """(n,) the middles of the squares of length, m2; symbol i is (l_i^2 - middle) / radius."""
    radii_of_squares: Floats
    """(n,)."""
    polynomial: Floats
    """(6 + n, TERMS) coefficients in the order of ``second_order``."""
    sways: Floats
    """(6 + n, k) its slopes in the symbols of points and load, where these have ranges; else k = 0.

    Those of arms are for the arms as the chart has them, after its half turn."""
    radii: Floats
    """(6 + n,) of the box around the polynomial in which the zero lies."""
    reach: Floats
    """(6 + n,) of the one in which no other zero lies."""
    own_points: bool = False
    """The lengths are those between the points of each choice."""

    @property
    def parts(self) -> tuple[Tube, ...]:
        """Itself: a tube in one piece."""
        return (self,)

    def zero_at(self, squares: Floats) -> tuple[Floats, Tube]:
        """Return the polynomial at squares of length (n,) in its ranges, in floats, and the tube it is of."""
        n = len(squares)
        delta = np.zeros(MOST_TAUT)
        ranged = self.radii_of_squares > 0.0
        delta[:n][ranged] = ((squares - self.squares)[ranged] / self.radii_of_squares[ranged]).clip(-1.0, 1.0)
        above = np.triu_indices(MOST_TAUT, 1)
        terms = np.concatenate([[1.0], delta, delta**2, np.outer(delta, delta)[above]])
        return self.polynomial @ terms, self

    def holds(self, other: Tube | GluedTube, squares: Floats) -> bool:
        """Return True when another tube's zero for these squares of length is proved to be this tube's."""
        mine, _ = self.zero_at(squares)
        theirs, part = other.zero_at(squares)
        slack = 1e-12 * (1.0 + np.abs(mine).max())
        near = np.abs(theirs - mine) + part.radii + slack < self.reach
        fixed = self.reach == 0.0
        return bool(other.chart == self.chart and (near | (fixed & (theirs == mine))).all())

    @property
    def near(self) -> Floats:
        """(3, 2) bounds of all u within reach."""
        return np.stack([self.box[:3, 0] - self.reach[:3], self.box[:3, 1] + self.reach[:3]], axis=1)

    @property
    def sways_of_cells(self) -> Floats:
        """(6 + n, k) the slopes with the symbols that cells have: of arms before the chart's half turn."""
        signs = np.ones(self.sways.shape[1])
        signs[ARM_SYMBOLS:LOAD_SYMBOLS] = np.resize(
            HALF_TURNS[self.chart], len(signs[ARM_SYMBOLS:LOAD_SYMBOLS])
        )
        return self.sways * signs

    @property
    def slopes(self) -> Floats:
        """(6 + n, 6) the polynomial's slopes in the symbols."""
        return self.polynomial[:, 1 : 1 + MOST_TAUT]

    @property
    def rests(self) -> Floats:
        """(6 + n,) bounds of its terms of second order."""
        return np.abs(self.polynomial[:, 1 + MOST_TAUT :]).sum(axis=1) * (1.0 + 1e-14)


@dataclass(frozen=True, eq=False)
class GluedTube(Root):
    """Tubes over two halves of the data that share their zeros where the halves meet: one for all choices.

    ``core`` and ``unique`` are those at the middle of the data, which both halves have.
    """

    halves: tuple[Tube | GluedTube, Tube | GluedTube]
    cable: int
    """Whose length was cut."""
    cut: float
    """Where, as a square of length."""

    @property
    def parts(self) -> tuple[Tube, ...]:
        """Its tubes in one piece."""
        first, second = self.halves
        return (*first.parts, *second.parts)

    def zero_at(self, squares: Floats) -> tuple[Floats, Tube]:
        """Return the polynomial at squares of length (n,), in floats, and the tube it is of."""
        return self.halves[int(squares[self.cable] > self.cut)].zero_at(squares)


def glued(first: Tube | GluedTube, second: Tube | GluedTube, cable: int, squares: Floats) -> GluedTube | None:
    """Return one tube over both halves of the data, if their zeros at the middle are proved the same.

    Parameters
    ----------
    first, second
        Below and above the cut.
    squares : (n,)
        The middles of the squares of length, where the data were cut.
    """
    _, left = first.zero_at(squares)
    _, right = second.zero_at(squares)
    if not (left.holds(right, squares) or right.holds(left, squares)):
        return None
    middle, _ = left.zero_at(squares)
    lowest = np.minimum(first.box[:, 0], second.box[:, 0])
    highest = np.maximum(first.box[:, 1], second.box[:, 1])
    return GluedTube(
        chart=first.chart,
        box=np.stack([lowest, highest], axis=1),
        unique=np.stack([middle - left.reach, middle + left.reach], axis=1),
        core=around(middle, left.radii),
        halves=(first, second),
        cable=cable,
        cut=float(squares[cable]),
    )


def around(middle: Floats, radii: Floats) -> Floats:
    """Return the bounds (k, 2) of a box; without radii the middle itself."""
    off = radii + 1e-15 * np.abs(middle)
    off[radii == 0.0] = 0.0
    return np.stack([middle - off, middle + off], axis=1)
