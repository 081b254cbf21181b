"""A platform on cables over pulleys as the compiled kernels see it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class RealModel(NamedTuple):
    """Arrays for the kernels; N cables of which the first n are taut, the others slack.

    A cable with radius 0 is straight from its exit point. Lengths in m, forces in N, or in powers of two
    of these.
    """

    n_taut: int
    statics: bool
    """Cells without an equilibrium of non-negative tensions are excluded."""
    slack: bool
    """Cells where a cable outside the subset would be too long are excluded."""
    exits: Floats
    """(N, 3) the points A: exit points, or where the swivel axis and the pulley's arm meet."""
    axes: Floats
    """(N, 3) unit swivel axes k; of straight cables any unit vector."""
    radius: Floats
    """(N,) r."""
    arm: Floats
    """(N,) h >= r, from A to the pulley's centre."""
    fixed: Floats
    """(N,) |CK| + r theta_K: L = fixed - r psi + sigma while the rope touches the pulley."""
    lift_off: Floats
    """(N,) theta_K from below: from there on psi the rope may run past the pulley, straight from C."""
    foot_reach: Floats
    """(N,) how far from A the rope may leave towards X: from the pulley, or, lifted off, from C."""
    least_excess: Floats
    """(N,) L - |X - A| is at least this, wherever X is;"""
    most_excess: Floats
    """(N,) and at most this."""
    shift: Floats
    """(N, 2) errors of the data: as a length that A, b and fixed may be off together, and as an angle of
    k."""
    arms: Floats
    """(N, 3) arms b."""
    arm_lengths: Floats
    """(N,) |b|, from above."""
    lengths: Floats
    """(N, 2) bounds of l."""
    paths: Floats
    """(N, 2) bounds of the path length L of a taut cable; of slack ones only the upper."""
    compliance: Floats
    """(N, 2) bounds of 1 / k, the stretch by 1 N; 0 of cables that do not stretch."""
    elastic: bool
    """Some taut cable stretches."""
    rigid: int
    """From this taut cable on all stretch."""
    load: Floats
    """(3,) f."""
    load_err: Floats
    """(3,)."""
    size: float
    """A length of the platform, by which moments are divided."""
    triple: Ints
    """(3,) the taut cables whose lengths fix the position best; any where there are fewer."""
