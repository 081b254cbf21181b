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
    joints: Ints
    """(N,) of the pulley; 1 of straight cables."""
    axes: Floats
    """(N, 3) unit swivel axes k; of straight cables any unit vector."""
    radius: Floats
    """(N,) r."""
    arm: Floats
    """(N,) h >= r, from A to the pulley's centre."""
    simple: NDArray[np.bool_]
    """(N,) straight, or on its pulley wherever it is, and that on one joint."""
    is_simple: bool
    """All cables are."""
    rows: Floats
    """(N, ROW) some of these arrays once more, for kernels that a whole model is too much for."""
    sway: Floats
    """(N,) r, with two joints r + h / 2: the point T moves by at most that over sigma in the plane."""
    lead: Floats
    """(N,) the lead-in, from C to A."""
    fixed: Floats
    """(N,) |CK| + r theta_K: L = fixed - r psi + sigma while the rope touches the pulley; the lead-in with
    two joints."""
    before: Floats
    """(N,) how much of a rope that runs past its pulley counts as arriving: as much as where it lifts off."""
    lift_off: Floats
    """(N,) theta_K from below, with one joint: from there on psi the rope may run past the pulley, straight
    from C. In ``rows`` also from above, LIFT_ABOVE: beyond that it does, infinite where it never does."""
    foot_reach: Floats
    """(N,) how far from A the free part of the rope may begin."""
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
