"""From the proved boxes of roots to the numbers that solutions report, compiled.

What this cannot decide (a tension or a slack near zero, stability over wide boxes) is left to the ball
arithmetic of ``solution``, which decides no less.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.kernels import interval, interval_matrix
from cdpr_interval.kernels.kernel import entry
from cdpr_interval.mechanics.rotation import model_rotation

Floats = NDArray[np.float64]

STABLE, UNSTABLE, OPEN = interval_matrix.POSITIVE, interval_matrix.NEGATIVE, interval_matrix.OPEN


class Cables(NamedTuple):
    """A robot and its load in bounds (lo, hi) of their exact values: m, N."""

    exits: Floats
    """(N, 3, 1, 2) exit points A_i, base frame."""
    arms: Floats
    """(N, 3, 1, 2) platform points B_i from the centre of mass, platform frame."""
    centre: Floats
    """(3, 1, 2) the centre of mass in the platform frame."""
    up: Floats
    """(1, 3, 2) unit vector against gravity, base frame."""
    load: Floats
    """(3, 1, 2) f."""


class FrameBounds(NamedTuple):
    """The way from the frames of a search back to the robot's."""

    plain: bool
    """The frames are the robot's own."""
    back: Floats
    """(3, 3, 2) rotation from the model's base frame to the robot's."""
    platform: Floats
    """(3, 3, 2) rotation from the robot's platform frame to the model's."""
    minus_origin: Floats
    """(3, 1, 2) minus the model's origin in the robot's base frame."""


class Fields(NamedTuple):
    """What roots report, one row for each: bounds (lo, hi) in the robot's frames."""

    rotation: Floats
    """(m, 3, 3, 2)."""
    position: Floats
    """(m, 3, 2) the platform origin."""
    height: Floats
    """(m, 2) of the centre of mass."""
    distances: Floats
    """(m, N, 2)."""
    densities: Floats
    """(m, n, 2) t = tension / length of the taut cables."""
    tensions: Floats
    """(m, N, 2); zero for the other cables."""
    verdicts: NDArray[np.int64]
    """(m,) ``STABLE``, ``UNSTABLE`` (where no tension or slack is zero) or ``OPEN``."""


@entry("void(f8[:, :, ::1], f8[:, :, ::1])")
def copy(a: Any, out: Any) -> None:
    """Copy the bounds a (k, l, 2) to out (k, l, 2), see ``box.copy``."""
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            out[i, j, 0] = a[i, j, 0]
            out[i, j, 1] = a[i, j, 1]


@entry("void(f8[:, :, ::1], f8[:, :, ::1], f8[:, :, ::1])")
def difference(a: Any, b: Any, out: Any) -> None:
    """Enclose a - b in out (3, 1, 2) for columns a, b (3, 1, 2)."""
    for k in range(3):
        out[k, 0, 0], out[k, 0, 1] = interval.sub(a[k, 0, 0], a[k, 0, 1], b[k, 0, 0], b[k, 0, 1])


@entry("UniTuple(f8, 2)(f8[:, :, ::1])")
def norm(e: Any) -> tuple[float, float]:
    """Enclose |e| of a column e (3, 1, 2)."""
    slo, shi = 0.0, 0.0
    for k in range(3):
        lo, hi = interval.sqr(e[k, 0, 0], e[k, 0, 1])
        slo, shi = interval.add(slo, shi, lo, hi)
    lo, hi = interval.sqrt(slo, shi)
    return lo, hi


@entry("void(f8[:, :, ::1], f8[:, :, ::1], f8[:, ::1])")
def wrench(e: Any, r: Any, out: Any) -> None:
    """Write the bounds of (e, r x e) to out (6, 2), for columns e, r (3, 1, 2)."""
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        out[k, 0], out[k, 1] = e[k, 0, 0], e[k, 0, 1]
        lo, hi = interval.mul(r[i, 0, 0], r[i, 0, 1], e[j, 0, 0], e[j, 0, 1])
        a, b = interval.mul(r[j, 0, 0], r[j, 0, 1], e[i, 0, 0], e[i, 0, 1])
        out[3 + k, 0], out[3 + k, 1] = interval.sub(lo, hi, a, b)


@entry("b1(f8[:, :, ::1], f8[:, :, ::1], f8[:, ::1])")
def densities_by_balance(wrenches: Any, load: Any, t: Any) -> bool:
    """Enclose t (6, 2) of six taut cables with wrenches (6, 6, 2) that balance the load (3, 1, 2)."""
    A = np.zeros((6, 7, 2))
    X = np.empty((6, 1, 2))
    for i in range(6):
        for k in range(6):
            A[k, i, 0], A[k, i, 1] = wrenches[i, k, 0], wrenches[i, k, 1]
    for k in range(3):
        A[k, 6, 0], A[k, 6, 1] = -load[k, 0, 1], -load[k, 0, 0]
    if not interval_matrix.solve(A, X):
        return False
    for i in range(6):
        t[i, 0], t[i, 1] = X[i, 0, 0], X[i, 0, 1]
    return True


@entry("void(f8[:, :, :, ::1], f8[:, :, :, ::1], f8[:, ::1], f8[:, :, ::1])")
def quadratic_form(spokes: Any, arms: Any, t: Any, Q: Any) -> None:
    """Enclose the form Q (6, 6, 2) of ``stability`` in (v, omega).

    ``spokes, arms`` : (n, 3, 1, 2) e_i and r_i; ``t`` : (n, 2). With q = e + r the part in omega is
    t (q . r I - (q r^T + r q^T) / 2).
    """
    Q[:, :, :] = 0.0
    q = np.empty((3, 2))
    for c in range(t.shape[0]):
        r, e = arms[c], spokes[c]
        dlo, dhi = 0.0, 0.0
        for k in range(3):
            q[k, 0], q[k, 1] = interval.add(e[k, 0, 0], e[k, 0, 1], r[k, 0, 0], r[k, 0, 1])
            a, b = interval.mul(q[k, 0], q[k, 1], r[k, 0, 0], r[k, 0, 1])
            dlo, dhi = interval.add(dlo, dhi, a, b)
            Q[k, k, 0], Q[k, k, 1] = interval.add(Q[k, k, 0], Q[k, k, 1], t[c, 0], t[c, 1])
        for i in range(3):
            for j in range(3):
                lo, hi = interval.mul(q[i, 0], q[i, 1], r[j, 0, 0], r[j, 0, 1])
                a, b = interval.mul(q[j, 0], q[j, 1], r[i, 0, 0], r[i, 0, 1])
                lo, hi = interval.add(lo, hi, a, b)
                lo, hi = -0.5 * hi, -0.5 * lo
                if i == j:
                    lo, hi = interval.add(lo, hi, dlo, dhi)
                lo, hi = interval.mul(lo, hi, t[c, 0], t[c, 1])
                Q[3 + i, 3 + j, 0], Q[3 + i, 3 + j, 1] = interval.add(
                    Q[3 + i, 3 + j, 0], Q[3 + i, 3 + j, 1], lo, hi
                )
                if i == j:
                    continue
                # v . (omega x r) = -v . [r]_x omega, and [r]_x has -r_k at (i, j) for even (i, j, k).
                k = 3 - i - j
                lo, hi = interval.mul(r[k, 0, 0], r[k, 0, 1], t[c, 0], t[c, 1])
                if (j - i) % 3 != 1:
                    lo, hi = -hi, -lo
                Q[i, 3 + j, 0], Q[i, 3 + j, 1] = interval.add(Q[i, 3 + j, 0], Q[i, 3 + j, 1], lo, hi)
                Q[3 + j, i, 0], Q[3 + j, i, 1] = Q[i, 3 + j, 0], Q[i, 3 + j, 1]


@entry("i8(f8[:, :, :, ::1], f8[:, :, :, ::1], f8[:, ::1], f8[:, :, ::1])")
def stability(spokes: Any, arms: Any, t: Any, wrenches: Any) -> int:
    """Return ``STABLE``, ``UNSTABLE`` or ``OPEN``, given that all tensions of the taut cables are positive.

    ``spokes, arms`` : (n, 3, 1, 2); ``t`` : (n, 2); ``wrenches`` : (n, 6, 2).

    Guarantee: what the form of ``cdpr_interval.mechanics.stability`` proves on the kernel of the wrenches.
    """
    n = t.shape[0]
    if n >= 6:
        return STABLE
    Q = np.empty((6, 6, 2))
    basis = np.empty((6, 6 - n, 2))
    reduced = np.empty((6 - n, 6 - n, 2))
    if not interval_matrix.kernel_basis(wrenches, basis):
        return OPEN
    quadratic_form(spokes, arms, t, Q)
    interval_matrix.congruence(basis, Q, reduced)
    verdict = interval_matrix.definiteness(reduced)
    return verdict


@entry()
def fill_fields(
    cables: Any, frame: Any, boxes: Any, charts: Any, taut: Any, lengths: Any, fields: Any
) -> None:
    """Fill ``fields`` for the roots with these boxes (m, 6 + n, 2) and charts (m,).

    Parameters
    ----------
    cables
        ``Cables``.
    frame
        ``FrameBounds``.
    taut : (n,)
        Indices of the taut cables, in the boxes' order.
    lengths : (N, 2)
        Bounds of all lengths.
    fields
        ``Fields``, written.

    Guarantee
    ---------
    Encloses the fields of every pose (and tensions) in a box; entries are NaN where that failed.
    """
    n, count = taut.shape[0], cables.exits.shape[0]
    R, half = np.empty((3, 3, 2)), np.empty((3, 3, 2))
    slopes = np.empty((3, 3, 3, 2))
    p, centre, moved = np.empty((3, 1, 2)), np.empty((3, 1, 2)), np.empty((3, 1, 2))
    upward = np.empty((1, 1, 2))
    spokes, arms = np.empty((count, 3, 1, 2)), np.empty((count, 3, 1, 2))
    own_spokes, own_arms = np.empty((n, 3, 1, 2)), np.empty((n, 3, 1, 2))
    wrenches = np.empty((n, 6, 2))
    for m in range(boxes.shape[0]):
        rotation, t = fields.rotation[m], fields.densities[m]
        model_rotation(boxes[m], charts[m], slopes, half, R)
        for k in range(3):
            p[k, 0, 0], p[k, 0, 1] = boxes[m, 3 + k, 0], boxes[m, 3 + k, 1]
        if frame.plain:
            copy(R, rotation)
            copy(p, centre)
        else:
            interval_matrix.multiply(frame.back, R, half)
            interval_matrix.multiply(half, frame.platform, rotation)
            interval_matrix.multiply(frame.back, p, centre)
            difference(centre, frame.minus_origin, centre)
        interval_matrix.multiply(cables.up, centre, upward)
        fields.height[m, 0], fields.height[m, 1] = upward[0, 0, 0], upward[0, 0, 1]
        interval_matrix.multiply(rotation, cables.centre, moved)
        difference(centre, moved, p)
        for k in range(3):
            fields.position[m, k, 0], fields.position[m, k, 1] = p[k, 0, 0], p[k, 0, 1]
        for i in range(count):
            interval_matrix.multiply(rotation, cables.arms[i], arms[i])
            difference(cables.exits[i], centre, spokes[i])
            difference(spokes[i], arms[i], spokes[i])
            fields.distances[m, i, 0], fields.distances[m, i, 1] = norm(spokes[i])
        for j in range(n):
            copy(spokes[taut[j]], own_spokes[j])
            copy(arms[taut[j]], own_arms[j])
            wrench(own_spokes[j], own_arms[j], wrenches[j])
            t[j, 0], t[j, 1] = boxes[m, 6 + j, 0], boxes[m, 6 + j, 1]
        if n == 6 and not densities_by_balance(wrenches, cables.load, t):
            t[:, :] = np.nan
        for j in range(n):
            i = taut[j]
            lo, hi = lengths[i, 0], lengths[i, 1]
            fields.tensions[m, i, 0], fields.tensions[m, i, 1] = interval.mul(t[j, 0], t[j, 1], lo, hi)
            # A taut cable is as long as it is.
            fields.distances[m, i, 0] = max(fields.distances[m, i, 0], lo)
            fields.distances[m, i, 1] = min(fields.distances[m, i, 1], hi)
        fields.verdicts[m] = stability(own_spokes, own_arms, t, wrenches)
        # The entries of a rotation lie in [-1, 1].
        for i in range(3):
            for j in range(3):
                rotation[i, j, 0] = max(rotation[i, j, 0], -1.0)
                rotation[i, j, 1] = min(rotation[i, j, 1], 1.0)
