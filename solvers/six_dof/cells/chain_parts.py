"""Chains in parts: tubes over halves of their data, whose bounds together are sharper than the whole's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.mechanics.six_dof.rows import MOST_TAUT
from solvers.six_dof.cells.chain import Chain, at_start, tube_of
from solvers.six_dof.cells.tube import Tube

Floats = NDArray[np.float64]


def pieces(chain: Chain) -> list[tuple[Floats, Tube]]:
    """Return a chain's tubes in parts with its lengths, and the poses without the cable."""
    first = chain.tubes[0]
    slack = tube_of(
        first.chart, at_start(first.polynomial), first.radii + 1e-15 * np.abs(first.polynomial).sum(axis=1),
        first.reach, first.squares, np.append(first.radii_of_squares[:-1], 0.0),
    )  # fmt: skip
    found = [(chain.lengths, part) for tube in (slack, *chain.tubes) for part in halved(tube)]
    return found


def halved(tube: Tube) -> list[Tube]:
    """Return a tube over the halves of all its data, each with the box that holds its zeros."""
    ranged = [i for i in range(len(tube.squares)) if np.any(tube.polynomial[:, 1 + i])]
    found = [tube]
    for symbol in ranged:
        found = [half for one in found for half in (part_of(one, symbol, -0.5), part_of(one, symbol, 0.5))]
    return found


def part_of(tube: Tube, symbol: int, middle: float, half: float = 0.5) -> Tube:
    """Return a tube's polynomial and radii for one symbol in a part of its range, about ``middle``."""
    constant, slopes, squares, mixed = (x.copy() for x in split_terms(tube.polynomial))
    constant += middle * (slopes[:, symbol] + middle * squares[:, symbol])
    slopes += middle * mixed[:, symbol]
    slopes[:, symbol] = half * (slopes[:, symbol] + 2.0 * middle * squares[:, symbol])
    squares[:, symbol] *= half * half
    mixed[:, symbol] *= half
    mixed[:, :, symbol] *= half
    above = np.triu_indices(MOST_TAUT, 1)
    polynomial = np.column_stack([constant, slopes, squares, mixed[:, above[0], above[1]]])
    radii = tube.radii + 1e-15 * np.abs(tube.polynomial).sum(axis=1)
    return replace(tube, polynomial=polynomial, radii=radii)


def split_terms(polynomial: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return constants (m,), slopes (m, 6), squares (m, 6) and mixed terms (m, 6, 6) of a polynomial."""
    P = MOST_TAUT
    mixed = np.zeros((len(polynomial), P, P))
    above = np.triu_indices(P, 1)
    mixed[:, above[0], above[1]] = mixed[:, above[1], above[0]] = polynomial[:, 1 + 2 * P :]
    return polynomial[:, 0], polynomial[:, 1 : 1 + P], polynomial[:, 1 + P : 1 + 2 * P], mixed
