"""Whether balls have a common point: weights that prove there is none, or a point strictly inside all.

The point q with the smallest largest power max_i (|q - A_i|^2 - l_i^2) is q = sum lambda_i A_i, where
the weights lambda >= 0, sum 1, maximise phi(lambda) = sum lambda_i (|A_i|^2 - l_i^2) - |sum lambda_i A_i|^2.
For every lambda, phi is the smallest value over all points p of sum lambda_i (|p - A_i|^2 - l_i^2): where
it is positive, no point lies in all balls. By Helly's theorem four weights are enough. Where the largest
power is negative, q is strictly inside all balls (Slater's condition).

Floats find lambda and q; the two claims are then checked in exact rationals.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.exact.decimals import rounded_down
from cdpr_interval.exact.vector import Vector

Floats = NDArray[np.float64]

WEIGHT_ERROR = 1e-12
"""Weights above minus this count as non-negative: the exact check follows."""
GROWTHS = 8
"""Times that weights are found anew for larger balls: each time their proof reaches further, soon no more."""


def _equal_power(A: Floats, c: Floats, members: Sequence[int]) -> tuple[Floats, Floats] | None:
    """Return weights of ``members`` and the point of equal powers they span; None where singular."""
    n = len(members)
    chosen = A[list(members)]
    matrix = np.zeros((n + 1, n + 1))
    matrix[:n, :n] = 2.0 * (chosen @ chosen.T)
    matrix[:n, n] = matrix[n, :n] = 1.0
    try:
        weights = np.linalg.solve(matrix, np.append(c[list(members)], 1.0))[:n]
    except np.linalg.LinAlgError:
        return None
    if not np.isfinite(weights).all():
        return None
    return weights, weights @ chosen


def deepest_point(exits: Floats, lengths: Floats) -> tuple[dict[int, float], Floats]:
    """Find the point deepest inside all balls (or least outside).

    Parameters
    ----------
    exits, lengths : (N, 3), (N,)
        Centres and radii, best near one in size.

    Returns
    -------
    weights : dict
        Positive weights (floats, at most four), by ball.
    point : (3,)
        Their mean of the centres.
    """
    A = exits - exits.mean(axis=0)
    c = (A**2).sum(axis=1) - lengths**2
    powers = (A[0] ** 2).sum() - 2.0 * (A @ A[0]) + c
    basis: tuple[int, ...] = (0,)
    weights, point, value = np.ones(1), A[0], powers[0]
    for _ in range(20 + 10 * len(A)):
        powers = (point**2).sum() - 2.0 * (A @ point) + c
        worst = int(powers.argmax())
        if worst in basis or powers[worst] <= value + 1e-15 * (abs(value) + float(lengths.max()) ** 2):
            break
        best: tuple[float, tuple[int, ...], Floats, Floats, float] | None = None
        for size in range(min(4, len(basis) + 1)):
            for others in combinations(basis, size):
                members = (*others, worst)
                solved = _equal_power(A, c, members)
                if solved is None or solved[0].min() < -WEIGHT_ERROR:
                    continue
                q = solved[1]
                own = (q**2).sum() - 2.0 * (A[list({*basis, worst})] @ q) + c[list({*basis, worst})]
                level = float((q**2).sum() - 2.0 * (A[worst] @ q) + c[worst])
                excess = float(own.max()) - level
                if best is None or excess < best[0]:
                    best = excess, members, solved[0], q, level
        if best is None or not best[4] > value:
            break
        _, basis, weights, point, value = best
    kept = {i: max(0.0, float(w)) for i, w in zip(basis, weights, strict=True) if w > 0.0}
    return kept, point + exits.mean(axis=0)


def proves_empty(weights: dict[int, float], exits: Sequence[Vector], longest: Sequence[Fraction]) -> bool:
    """Check exactly that the weighted balls with the given radii have no common point.

    Guarantee
    ---------
    True: every point p has sum lambda_i (|p - A_i|^2 - l_i^2) > 0, so it is outside at least one ball.
    """
    smallest = _smallest_sum(weights, exits, longest)
    return smallest is not None and smallest > 0


def _smallest_sum(
    weights: Mapping[int, float], exits: Sequence[Vector], longest: Sequence[Fraction]
) -> Fraction | None:
    """Return the least of sum lambda_i (|p - A_i|^2 - l_i^2) over all points p; None: no weights."""
    exact = {i: Fraction(w) for i, w in weights.items()}
    total = sum(exact.values(), Fraction(0))
    if total <= 0 or min(exact.values()) < 0:
        return None
    mean = [sum((w * exits[i][j] for i, w in exact.items()), Fraction(0)) / total for j in range(3)]
    return sum((w * (_norm_squared(exits[i], mean) - longest[i] ** 2) for i, w in exact.items()), Fraction(0))


def shortfall(exits: Sequence[Vector], longest: Sequence[Fraction]) -> Decimal:
    """Return by how much all radii have to grow, alike, before balls can have a common point.

    Parameters
    ----------
    exits, longest
        Centres and radii, m.

    Returns
    -------
    Decimal
        m, three digits, rounded down; 0 where nothing is proved.

    Guarantee
    ---------
    With every radius larger by less than this, the balls have no common point.
    """
    found, weights = 0.0, dict[int, float]()
    A = np.array([[float(x) for x in a] for a in exits])
    lengths = np.array([float(x) for x in longest])
    with np.errstate(all="ignore"):
        for _ in range(GROWTHS):
            better, _ = deepest_point(A, lengths + found)
            few = list(better)
            share = np.array(list(better.values())) / sum(better.values())
            own = lengths[few]
            apart = share @ ((A[few] - share @ A[few]) ** 2).sum(axis=1)
            middle = share @ own
            growth = float(np.sqrt(max(middle**2 - share @ own**2 + apart, 0.0)) - middle)
            if not growth > found:
                break
            found, weights = growth, better
    if not weights:
        return Decimal(0)
    # The growth may be a short decimal, just missed by the floats.
    for wanted in (found * (1.0 + 1e-12), found * (1.0 - 1e-9)):
        short = rounded_down(Fraction(wanted))
        least = _smallest_sum(weights, exits, [length + Fraction(short) for length in longest])
        if least is not None and least >= 0:
            return short
    return Decimal(0)


def _norm_squared(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    return sum(((x - y) ** 2 for x, y in zip(a, b, strict=True)), Fraction(0))


def is_inside_all(point: Iterable[Fraction], exits: Sequence[Vector], shortest: Sequence[Fraction]) -> bool:
    """Check exactly that a point is strictly inside all balls with the given radii."""
    p = tuple(point)
    return all(_norm_squared(p, a) < s**2 for a, s in zip(exits, shortest, strict=True))


def apart_message(names: Sequence[str], cables: Collection[int]) -> str:
    """Return the sentence that says which cables cannot reach a common point."""
    where = "both" if len(cables) == 2 else "all"
    listed = _listed(names, cables)
    return f"cables {listed} cannot reach a common point: no point lies within {where} their lengths"


def short_message(short: Decimal) -> str:
    """Return the part of a sentence that says by how much cables are too short; empty for 0."""
    return f"; made longer alike, each needs at least {short.normalize():f} m more" if short else ""


def touching_message(names: Sequence[str], cables: Collection[int]) -> str:
    """Return the sentence that says which cables only touch, where nothing holds the load."""
    return f"cables {_listed(names, cables)} only just reach each other: no finite tensions hold the load"


def _listed(names: Sequence[str], cables: Collection[int]) -> str:
    return " and ".join(", ".join(names[i] for i in sorted(cables)).rsplit(", ", 1))
