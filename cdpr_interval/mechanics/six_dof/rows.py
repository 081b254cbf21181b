"""The rows of the scratch arrays that belong to a six-dof platform; see ``engine.rows``.

How many rows and columns a range has follows from the most cables, symbols and variables there can be: one
more symbol, or one more cable, is a change of these numbers.
"""

from __future__ import annotations

from cdpr_interval.engine import rows as engine
from cdpr_interval.engine.rows import MOST_DATA, MOST_SYMBOLS, MOST_VARIABLES, Table

U_SYMBOLS = 3
"""Symbols 0..2 are u."""
ERROR_SYMBOL = 3
"""Symbol of cells in u that carries the error of x along one direction."""
MOST_TAUT = 6
DIMENSIONS = 6
"""Of a wrench: force and moment."""


def moving_rows(symbols: int) -> int:
    """Return how many rows a vector has that varies over the cell: itself, then a slope for each symbol."""
    return 1 + symbols


EXIT_SYMBOLS = 0
"""Among the symbols of points and load: three of each cable's exit point,"""
ARM_SYMBOLS = EXIT_SYMBOLS + 3 * MOST_TAUT
"""three of each cable's arm, by its own doing,"""
CENTRE_SYMBOLS = ARM_SYMBOLS + 3 * MOST_TAUT
"""three of the centre of mass, which moves all arms, and"""
LOAD_SYMBOLS = CENTRE_SYMBOLS + 3
"""three of the load."""
POINT_SYMBOLS = LOAD_SYMBOLS + 3
"""How many there are."""

FORMS = Table(engine.FORMS.ranges)
"""Rows of F; see ``geometry`` for the symbols used here."""
ROTATION = FORMS.take("ROTATION", 9)
"""s R(u) D_c, row by row."""
SCALE = FORMS.take("SCALE")
"""s = 1 + |u|^2."""
POSITION = FORMS.take("POSITION", 3)
"""x."""
NORMAL = FORMS.take("NORMAL", 3)
"""s d_2 x s d_3."""
SIGMA = FORMS.take("SIGMA")
"""x . (s d_2 x s d_3)."""
BLOCK = 7
"""Rows of a cable; their places:"""
ARM, CENTRE, OFFSET = 0, 3, 6
"""s q_i (3 rows), s d_i (3 rows), s K_i."""
CABLE = FORMS.take("CABLE", BLOCK * MOST_TAUT)
"""The blocks of the taut cables, in their order; the pivot's is not used."""
SECOND = CABLE + BLOCK
"""Block of the second cable of the triple."""
SLACK_CABLE = FORMS.take("SLACK_CABLE", BLOCK)
"""Block of a cable outside the subset."""
PLANE = FORMS.take("PLANE", BLOCK)
"""Block that takes the third cable's place in a plane: its normal."""
ROOT_ARM = FORMS.take("ROOT_ARM", 3)
"""s r_1."""
WRENCH = FORMS.take("WRENCH", DIMENSIONS * MOST_TAUT)
"""s w_i of each taut cable, moments divided by the platform's size."""
LOAD = FORMS.take("LOAD", DIMENSIONS)
"""s w_0."""

WORK = Table(engine.WORK.ranges)
"""Rows of W."""
FOOT = WORK.take("FOOT", 1, 3)
"""x at the centre of a cell, at first the foot of its height over the centres' plane."""
UNIT_NORMAL = WORK.take("UNIT_NORMAL", 1, 3)
"""Unit normal of the centres' plane there."""
TRIPLE = WORK.take("TRIPLE", 3, 3)
"""The matrix with rows d_2, d_3, x there."""
TRIPLE_INVERSE = WORK.take("TRIPLE_INVERSE", 3, 3)
COLUMNS = WORK.take("COLUMNS", MOST_TAUT + 1, DIMENSIONS + 2)
"""Wrenches and load at the centre, normalised (0..5); then at the places:"""
NORM, RIGHT = DIMENSIONS, DIMENSIONS + 1
"""Their norms, right sides."""
Y = WORK.take("Y", moving_rows(MOST_SYMBOLS + MOST_DATA), DIMENSIONS)
"""y, then its slopes."""
KEPT_Y = WORK.take("KEPT_Y", 1, DIMENSIONS)
"""y of lanes that need no other."""
MOST_TENSION = WORK.take("MOST_TENSION", 1, MOST_TAUT + 1)
"""Upper bounds of t_i = tension_i / l_i."""
SOME_TENSION = WORK.take("SOME_TENSION", 1, MOST_TAUT)
"""Approximate t_i."""
BASIS = WORK.take("BASIS", DIMENSIONS, DIMENSIONS)
"""An orthonormal basis that starts with the wrenches' span."""
DUAL = WORK.take("DUAL", MOST_TAUT + 1, 2 * DIMENSIONS + 1)
"""The dual basis (0..5), then at the places:"""
STEP, INVERSE = DIMENSIONS, 2 * DIMENSIONS
"""The columns' coordinates in the orthonormal basis (six), the inverse of what was left of the column."""
LEFT_INVERSE = WORK.take("LEFT_INVERSE", MOST_TAUT, DIMENSIONS)
"""An approximate left inverse of the wrenches at the centre, or of their moments."""
HULL = WORK.take("HULL", MOST_TAUT + 1, (MOST_TAUT + 1) + 3 + (MOST_TAUT + 1))
"""The nearest point of the columns' hull, a column a row: products with the others (0..6); at the places:"""
WEIGHT, TRIAL, CHOSEN, CHOSEN_SYSTEM = range(MOST_TAUT + 1, MOST_TAUT + 5)
"""Weights, a step's weights, 1 where chosen, the system of those chosen (seven)."""
TRIED = WORK.take("TRIED")
"""1 in lanes that are tried with the nearest point."""
SHARES = WORK.take("SHARES", 1, MOST_TAUT)
"""Row sums of |I - C W| for the tensions' bounds."""
RESTS = WORK.take("RESTS", 1, MOST_TAUT)
"""Residuals |C (w_0 + W t)| for them."""
BOUNDS = WORK.take("BOUNDS", 2, 3)
"""Lower, then upper bounds of p."""
TENSIONS = WORK.take("TENSIONS", 2, MOST_TAUT)
"""The same of t, in the cell's order."""
OFFSETS = WORK.take("OFFSETS", 2, 6 + MOST_TAUT)
"""Lower, then upper bounds of (u, p, t) less a tube's polynomial, t in the cell's order."""
BEFORE = WORK.take("BEFORE", 1, 2 * MOST_VARIABLES)
"""The cell before a cut."""
MOVING = WORK.take("MOVING")
"""1 in lanes that are still being cut."""
PLACES = WORK.take("PLACES", 2, 3)
"""Passes lower and upper bounds of x."""
PASSED = WORK.take("PASSED", 1, 3)
"""Passes numbers of a test lane by lane; its places:"""
CENTRE_OF, CHANGE_OF, TIE = range(3)
"""A form's value, the sizes of its coefficients, 1 where other pivots might be chosen."""
