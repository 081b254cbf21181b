"""What the columns of arrays mean here: cells, cables seen from a cell, what is kept of a cell."""

from __future__ import annotations

from typing import NamedTuple


class RealColumns(NamedTuple):
    """What the columns of a cell mean; the bounds of u and of the centre of mass come first."""

    variables: int
    chart: int
    share: int
    """Share of the search volume."""
    width: int


DENSITIES = 13
"""Bounds of t_i = tension / free length of the taut cables, lo and hi of each; only of elastic ones."""
MOST_CARRYING = 8
"""Most taut cables, if those behind the sixth stretch."""
SHARE = DENSITIES + 2 * MOST_CARRYING
REAL_COLUMNS = RealColumns(variables=6, chart=12, share=SHARE, width=SHARE + 1)
"""Cells in (u, p): bounds of u, then bounds of the centre of mass, which are any box that holds it."""

EXIT, AXIS, RADIUS, ARM, LEAD, BEFORE, SWAY, LIFT_OFF, LIFT_ABOVE, SHIFT, JOINTS = 0, 3, *range(6, 14), 15
"""Of a cable over a pulley what ``RealModel`` has of it, exit, axis and shift in three, three and two
columns."""
ROW = 16
"""How many there are."""

PATH, FREE, SIDE, HEIGHT, RHO = range(5)
"""Of a cable at one anchor position X0: path length L, free length sigma, x, y and rho of the pulley's
plane;"""
ALONG, FOOT, ACROSS, ASIDE = 5, 8, 11, 14
"""the unit vector a, the tangent point T, the normal n and the swivel direction w, three columns each;"""
WRAP, SIZE, OFF_LENGTH, OFF_POINT, AWAY = range(17, 22)
"""psi, with two joints the wrap, the size of all terms, rounding of L and of T, |X0 - A|;"""
REACH, LEAST_FREE, LEAST_SIDE, LOOSE, DRIFT = range(22, 27)
"""how far X may be from X0, the least sigma and x there, the error of the path length as that of a sphere
about T0, how far T may be from T0;"""
HUB, NEAREST, FARTHEST = 27, 30, 31
"""A - R(u_c) b, and bounds of how far from it the centre of mass is;"""
LOWEST, HIGHEST = 32, 33
"""bounds of the path length, by length and stretch;"""
WAY = 34
"""X0 - A."""
STATE = 37
"""STRAIGHT from the exit point, PRESSED on the pulley, or PAST it; within a reach also BOTH of these;"""
STRAIGHT, PRESSED, PAST, BOTH = 0.0, 1.0, 2.0, 3.0
TURN, OUT, LEAN = 38, 39, 40
"""only with two joints: kappa, T_u, and h beta f in the base frame, three columns."""
SEEN = 43
"""How many there are."""

CENTRE, BOX, NEXT, FORMED, TIGHTER = 0, 3, 9, 10, 11
"""Of a lane's cell: the centre of its positions p_c (3), bounds of p (6), the variable to bisect (-1: not
chosen), 1 while the cell's columns 6..11 bound p - p_c instead of p, 1 where densities lost much."""
HELD = 12
"""How many there are."""

TO_FOOT, LEVEL, LEVEL_ERROR, POINT_ERROR = 0, 3, 4, 5
"""Of a cable for the forms of a batch: T0 - p_c (3), (|T0 - p_c|^2 + |b|^2 - s^2) / 2 and its error, the
error of T0."""
SQUARE, SQUARE_ERROR = 6, 7
"""(|T0 - p_c|^2 + |b|^2) / 2 and its error;"""
REST, LENGTH_ERROR, TURNED_SHARE = 8, 9, 10
"""l - (L0 - sigma0), the errors of the path length and of the free length, both over the least sigma."""
SPOT = 11
"""How many there are."""
