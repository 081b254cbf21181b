"""Directed rounding without switching the processor's rounding mode: the only file that rounds.

Every IEEE operation here runs in round-to-nearest. For the result ``r`` of one correctly
rounded operation (+, -, *, /, sqrt) on finite or infinite operands the exact value lies in
``[down(r), up(r)]``.

Argument. With u = 2^-53 and eta = 2^-1074, the exact value x of an operation satisfies
|x - r| <= max(u |r|, eta / 2) when r is finite (u |r| holds for normal r; a subnormal r is
off by at most half of eta, and sums are exact there). Rump, Zimmermann, Boldo and Melquiond
("Computing predecessor and successor in rounding to nearest", BIT 49, 2009, algorithm 1)
show that with phi = u (1 + 2u) the floating-point number ``r - (phi |r| + eta)``, evaluated in
round-to-nearest, is at most the predecessor of r, and never more than two units away. The
predecessor of r bounds x from below, since r is the nearest number to x. Overflow: a result of
+inf stands for any exact value above the largest finite number, so its lower bound is that
number; -inf as a lower bound stays. NaN stays NaN and must be treated by the caller.
"""

from __future__ import annotations

import math

from numba import float64

from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.lanes import Lanes, lanes, where_less

PHI = 2.0**-53 * (1.0 + 2.0**-52)
"""u (1 + 2 u): relative step that reaches the neighbouring number."""
ETA = 5e-324
"""Smallest positive double."""
LARGEST = 1.7976931348623157e308
"""Largest finite double."""
UNIT = 2.0**-53
"""Unit roundoff u."""


@entry()
def down(r: float) -> float:
    """Return a number below every exact value that rounds to ``r``; at most two units below ``r``."""
    if r == math.inf:
        return LARGEST
    return r - (PHI * abs(r) + ETA)


@entry()
def up(r: float) -> float:
    """Return a number above every exact value that rounds to ``r``; at most two units above ``r``."""
    if r == -math.inf:
        return -LARGEST
    return r + (PHI * abs(r) + ETA)


@entry()
def inflate(error: float, magnitude: float, operations: float) -> float:
    """Return an upper bound of ``error`` plus the rounding errors of a short computation.

    ``error`` is a non-negative bound that was itself computed in round-to-nearest with at most
    ``operations`` operations on non-negative numbers; ``magnitude`` bounds (up to the same
    relative error) the sum over all operations of the magnitudes of their results.

    Guarantee: for operations <= 1000, the exact error plus u times the exact sum of magnitudes
    is at most the value returned. Each of k non-negative operations loses at most a factor
    (1 - u), and (1 - u)^-k <= 1 + 2 k u for k u < 1/2 (Higham, Accuracy and Stability of
    Numerical Algorithms, 2nd ed., lemma 3.1); factors are doubled for the final roundings.
    Underflow: each operation loses at most eta/2, covered by the last summand.
    """
    slop = 1.0 + 4.0 * operations * UNIT
    return (error * slop + 2.0 * UNIT * slop * magnitude) + 2.0 * operations * ETA


@kernel([lanes(lanes)])
def down_lanes(r: Lanes) -> Lanes:
    """``down`` in every lane."""
    return where_less(LARGEST, r, LARGEST, r - (PHI * abs(r) + ETA))


@kernel([lanes(lanes)])
def up_lanes(r: Lanes) -> Lanes:
    """``up`` in every lane."""
    return where_less(r, -LARGEST, -LARGEST, r + (PHI * abs(r) + ETA))


@kernel([lanes(lanes, lanes, float64)])
def inflate_lanes(error: Lanes, magnitude: Lanes, operations: float) -> Lanes:
    """``inflate`` in every lane."""
    slop = 1.0 + 4.0 * operations * UNIT
    return (error * slop + 2.0 * UNIT * slop * magnitude) + 2.0 * operations * ETA
