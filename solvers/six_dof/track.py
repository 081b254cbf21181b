"""One static pose within a region around the last one, compiled: the region, and what is proved over it.

The region X around a reference pose holds every pose whose centre of mass lies within ``radius`` of the
reference's and whose rotation differs by at most ``radius / size`` rad. Over all of X, at once:

1. every cable outside the taut subset is shorter than its length, so it carries nothing;
2. the tensions that balance the load on the others are enclosed, and positive: in X a static pose has
   exactly this taut subset, and solves its square system;
3. the Krawczyk operator, with an enclosure E of I - C J over X and T, the tensions of 2, maps a small box
   strictly into itself: the system has a zero there, for every choice of the lengths. With r > 0 the
   box's half widths |E| r < r, so every matrix in C J is regular and there is no other zero in X and T; and
4. the box lies in the region itself, not only in the bounds X of its u and p.

A region too large for one of these is halved.

Arrays, for n taut cables of N and m equations: ``z`` (6 + n,) is (u, p, t), see ``system``, and ``X`` (6 +
n, 2) bounds it; ``R`` (3, 3, 2) encloses R(u) over the region; ``data`` (n + 1, 7, 2) holds A_i, D_c b_i
and l_i^2, in its last row the load; ``free`` (m,) are the unknowns.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from cdpr_interval.engine.krawczyk import Tries, correction, growth, inflated, stretched
from cdpr_interval.kernels import interval, interval_matrix
from cdpr_interval.kernels.box import accumulate, contains, gather, meet, point, scatter, spread
from cdpr_interval.kernels.kernel import entry, kernel, part
from cdpr_interval.kernels.rounding import down, up
from cdpr_interval.mechanics.rotation import rotation_interval
from cdpr_interval.mechanics.six_dof import system as newton

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

TRACKED, NO_ROOT, MOVED, TIGHT, LOOSE, SINGULAR, SEVERAL, BROAD, GONE, OTHER, FORCED = range(11)
"""What ``track`` says: proved; Newton found no pose; it lies outside the region; a slack cable may be tight;
a taut one may be loose; the tensions are not bounded; there may be more than one root; the roots for all
lengths may not fit in. Of poses that are followed (`continuation`) besides: no tube is proved; the tube may
be
one of another pose; the last pose is one under another force."""
NEWTON_STEPS = 16
"""The reference is near: more steps mean that the pose has gone."""
TRIES = Tries(boxes=12, growth=1.1, kept=0.0)
"""The enclosure of the derivative stays, so radii may follow their images down as well as up."""
REFINEMENTS = 3
"""Applications of the operator after that; each takes away most of what the inflation added."""
ROUNDING = 1e-15
"""Width of the first box over the largest unknown, at least."""
WIDEST_TURN = 0.5
"""Largest tan(angle / 2) |u| of a region: the bound of u has no pole near."""
OUTWARD = 1.0 + 1e-12
"""Makes up for the rounding of a tangent and of a few operations."""


REGIONS = 4
"""Numbers that say which regions are tried: a length of the platform in m, the largest radius in m, the first
and the last power of 1/2 of it. A larger one than the first comes first where the pose has left that."""


array, index = types.float64, types.int64


@entry("b1(f8[::1], f8, f8, f8[:, ::1])")
def region(z: Any, radius: float, size: float, X: Any) -> bool:
    """Write the bounds of u and p in the region around z to X; False where its rotations are too many.

    With v the Rodrigues vector of the turn from R(u) to R(u'), of norm tan(angle / 2),
    u' - u = (v + v x u + (u . v) u) / (1 - u . v), of norm at most |v| (1 + |u|^2) / (1 - |u| |v|).
    """
    tangent = math.tan(0.5 * radius / size) * OUTWARD
    norm = math.sqrt(z[0] * z[0] + z[1] * z[1] + z[2] * z[2]) * OUTWARD
    if not (0.5 * radius / size < 1.0 and tangent * norm < WIDEST_TURN):
        return False
    reach = tangent * (1.0 + norm * norm) / (1.0 - tangent * norm) * OUTWARD
    for k in range(3):
        X[k, 0], X[k, 1] = down(z[k] - reach), up(z[k] + reach)
        X[3 + k, 0], X[3 + k, 1] = down(z[3 + k] - radius), up(z[3 + k] + radius)
    return True


@entry("void(f8[:, :, ::1], f8[:, ::1], f8[:, ::1], i8[::1], f8[:, :, ::1])")
def fill_data(cables: Any, load: Any, lengths: Any, chosen: Any, data: Any) -> None:
    """Write A_i, D_c b_i and l_i^2 of the chosen cables, and the load, to ``data`` (n + 1, 7, 2).

    ``cables, load, lengths, chosen`` : (N, 6, 2), (3, 2), (N, 2), (n,).
    """
    n = chosen.shape[0]
    for i in range(n):
        for k in range(6):
            data[i, k, 0], data[i, k, 1] = cables[chosen[i], k, 0], cables[chosen[i], k, 1]
        data[i, 6, 0], data[i, 6, 1] = interval.sqr(lengths[chosen[i], 0], lengths[chosen[i], 1])
    for k in range(3):
        data[n, k, 0], data[n, k, 1] = load[k, 0], load[k, 1]


@entry("void(f8[:, :, ::1], i8, f8[:, :, ::1], f8[:, ::1], f8[:, ::1], f8[:, ::1])")
def arm_and_spoke(data: Any, i: int, R: Any, X: Any, r: Any, e: Any) -> None:
    """Enclose r_i in r (3, 2) and e_i in e (3, 2) of a cable over the region."""
    newton.matrix_point(R, data, i, r)
    for k in range(3):
        lo, hi = interval.sub(data[i, k, 0], data[i, k, 1], X[3 + k, 0], X[3 + k, 1])
        e[k, 0], e[k, 1] = interval.sub(lo, hi, r[k, 0], r[k, 1])


@entry("i8(f8[:, :, ::1], f8[:, :, ::1], f8[:, ::1])")
def tight_cable(others: Any, R: Any, X: Any) -> int:
    """Return a cable of ``others`` that may be as long as its length somewhere in the region, else -1.

    ``others`` : (N - n + 1, 7, 2) their numbers, as ``data``.
    """
    r, e = np.empty((3, 2)), np.empty((3, 2))
    for i in range(others.shape[0] - 1):
        arm_and_spoke(others, i, R, X, r, e)
        slo, shi = 0.0, 0.0
        for k in range(3):
            lo, hi = interval.sqr(e[k, 0], e[k, 1])
            slo, shi = interval.add(slo, shi, lo, hi)
        if not shi < others[i, 6, 0]:
            return i
    return -1


@entry("b1(f8[:, :, ::1], f8[:, :, ::1], f8[:, ::1], f8, f8[:, :, ::1])")
def tensions(data: Any, R: Any, X: Any, size: float, T: Any) -> bool:
    """Enclose all t in T (n, 1, 2) that balance the load somewhere in the region; False where that fails.

    W t = -f with the wrenches W (6, n) implies B W t = -B f for any B (n, 6); B is the transpose of the
    middle of W, its moments divided by the square of ``size``.
    """
    n = data.shape[0] - 1
    r, e = np.empty((3, 2)), np.empty((3, 2))
    W = np.empty((n, 6, 2))
    for i in range(n):
        arm_and_spoke(data, i, R, X, r, e)
        for k in range(3):
            a, b = (k + 1) % 3, (k + 2) % 3
            W[i, k, 0], W[i, k, 1] = e[k, 0], e[k, 1]
            lo, hi = interval.mul(r[a, 0], r[a, 1], e[b, 0], e[b, 1])
            lo2, hi2 = interval.mul(r[b, 0], r[b, 1], e[a, 0], e[a, 1])
            W[i, 3 + k, 0], W[i, 3 + k, 1] = interval.sub(lo, hi, lo2, hi2)
    A = np.zeros((n, n + 1, 2))
    for i in range(n):
        for k in range(6):
            weight = 0.5 * (W[i, k, 0] + W[i, k, 1])
            if k >= 3:
                weight /= size * size
            for j in range(n):
                lo, hi = interval.scale(weight, W[j, k, 0], W[j, k, 1])
                accumulate(A, i, j, lo, hi)
            if k < 3:
                lo, hi = interval.scale(-weight, data[n, k, 0], data[n, k, 1])
                accumulate(A, i, n, lo, hi)
    return bool(interval_matrix.solve(A, T))


@part()
def everywhere(context: Any, box: Any, E: Any) -> None:
    """Leave E (m, m, 2), which encloses I - C J over all of X, as it is for any box (m, 2) in X."""


@entry("b1(f8[:, ::1], f8[:, :, ::1], i8[::1], f8[:, ::1], f8[::1], f8[:, ::1], f8[:, ::1])")
def box_around(f: Any, E: Any, free: Any, C: Any, z: Any, X: Any, box: Any) -> bool:
    """Write a box around z that the Krawczyk operator maps strictly into itself, contracted.

    ``z`` (6 + n,), ``free`` (m,), ``X`` and ``box`` (6 + n, 2), ``C`` (m, m). ``f`` (m, 2) are the residuals
    at z for every choice of data, ``E`` (m, m, 2) encloses I - C J over all of X.

    Guarantee: with True the box lies in X, and for every choice of data it holds exactly one zero, the only
    one in X.
    """
    m, size = free.shape[0], newton.largest(z)
    x, first, radius, image = np.empty(m), np.empty(m), np.empty(m), np.empty(m)
    shift, part, room = np.empty((m, 2)), np.empty((m, 2)), np.empty((m, 2))
    correction(C, f, shift)
    for i in range(m):
        x[i] = z[free[i]]
        first[i] = interval.mag(shift[i, 0], shift[i, 1])
        radius[i] = TRIES.growth * first[i] + ROUNDING * (abs(x[i]) + size)
    if not inflated(everywhere, 0, x, first, TRIES, radius, image, E, part):
        return False
    # E holds for the box only inside X. Also False for NaN.
    gather(X, free, room)
    if not contains(room, part, m):
        return False
    for _ in range(REFINEMENTS):
        for i in range(m):
            radius[i] = min(radius[i], image[i])
        stretched(E, radius, first, image)
    spread(x, radius, part)
    scatter(part, free, box)
    return True


@entry("b1(f8[:, :, ::1], i8[::1], f8[:, ::1])")
def lone(E: Any, free: Any, X: Any) -> bool:
    """Return True when E (m, m, 2) proves that X (6 + n, 2) holds at most one zero."""
    room = np.empty((free.shape[0], 2))
    gather(X, free, room)
    return growth(E, room) < 1.0


@part()
def contract(data: Any, rows: Any, free: Any, C: Any, box: Any) -> None:
    """Intersect a box (6 + n, 2) with its image under the Krawczyk operator, which holds all its zeros."""
    image = np.empty(box.shape)
    newton.krawczyk(data, rows, free, C, box, image)
    meet(image, box)


@entry("b1(f8[::1], f8[:, ::1], f8, f8)")
def holds(z: Any, box: Any, radius: float, size: float) -> bool:
    """Return True when every pose of a box (>= 6, 2) lies in the region around z; also False for NaN.

    With d = u' - u the Rodrigues vector of the turn from R(u) to R(u') is (d - d x u) / (1 + u . u').
    """
    d = np.empty((3, 2))
    clo, chi = 1.0, 1.0
    plo, phi, vlo, vhi = 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        d[k, 0], d[k, 1] = interval.sub(box[k, 0], box[k, 1], z[k], z[k])
        lo, hi = interval.scale(z[k], box[k, 0], box[k, 1])
        clo, chi = interval.add(clo, chi, lo, hi)
        lo, hi = interval.sub(box[3 + k, 0], box[3 + k, 1], z[3 + k], z[3 + k])
        lo, hi = interval.sqr(lo, hi)
        plo, phi = interval.add(plo, phi, lo, hi)
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        lo, hi = interval.scale(z[b], d[a, 0], d[a, 1])
        lo, hi = interval.sub(d[k, 0], d[k, 1], lo, hi)
        lo2, hi2 = interval.scale(z[a], d[b, 0], d[b, 1])
        lo, hi = interval.add(lo, hi, lo2, hi2)
        lo, hi = interval.sqr(lo, hi)
        vlo, vhi = interval.add(vlo, vhi, lo, hi)
    most = down(math.tan(0.5 * radius / size) / OUTWARD * clo)
    return clo > 0.0 and phi <= down(radius * radius) and vhi <= down(most * most)


@kernel("b1(f8[:, ::1], i8[::1])")
def ranged(lengths: Any, chosen: Any) -> bool:
    """Return True when one of the chosen (n,) lengths (N, 2) is a range."""
    for i in range(chosen.shape[0]):  # noqa: SIM110 - numba compiles no generator expressions
        if lengths[chosen[i], 0] < lengths[chosen[i], 1]:
            return True
    return False


@kernel("b1(f8[:, :, ::1])")
def vague(data: Any) -> bool:
    """Return True when a point of a cable in ``data`` is known to a range, not only to rounding."""
    for i in range(data.shape[0] - 1):
        for k in range(6):
            if data[i, k, 1] - data[i, k, 0] > ROUNDING * (1.0 + abs(data[i, k, 0])):
                return True
    return False


@part()
def loads(far: Any, data: Any, taut: Any, others: Any, size: float, X: Any) -> tuple[int, int]:
    """Prove over a region that the cables ``taut`` (n,) carry and the ``others`` (N - n,) do not.

    ``data`` (n + 1, 7, 2) and ``far`` (N - n + 1, 7, 2) are their numbers, see ``fill_data``. X (6 + n, 2)
    bounds u and p, and is given the bounds of t. Returns ``TRACKED`` and -1, or why not and the cable it
    hangs on, -1 for none.
    """
    n = taut.shape[0]
    T, R, slopes = np.empty((n, 1, 2)), np.empty((3, 3, 2)), np.empty((3, 3, 3, 2))
    rotation_interval(X, R, slopes)
    cable = tight_cable(far, R, X)
    if cable >= 0:
        return TIGHT, others[cable]
    if not tensions(data, R, X, size, T):
        return SINGULAR, -1
    for i in range(n):
        if not T[i, 0, 0] > 0.0:
            cable = taut[i]
        X[6 + i, 0], X[6 + i, 1] = T[i, 0, 0], T[i, 0, 1]
    return (LOOSE, cable) if cable >= 0 else (TRACKED, -1)


@entry(
    types.UniTuple(types.int64, 3)(
        array[:, :, ::1],
        array[:, ::1],
        array[:, ::1],
        index[::1],
        array[:, ::1],
        index[::1],
        array[::1],
        array[::1],
        array[::1],
        array[:, ::1],
    )
)
def track(
    cables: Any,
    load: Any,
    lengths: Any,
    order: Any,
    rows: Any,
    free: Any,
    regions: Any,
    z: Any,
    root: Any,
    box: Any,
) -> tuple[int, int, int]:
    """Prove the one static pose in the region around the pose of z.

    Parameters
    ----------
    cables, load, lengths : (N, 6, 2), (3, 2), (N, 2)
        A_i and D_c b_i, in the chart c of z, the load, and the lengths.
    order, rows, free, regions : (N,), (m - n, 6), (m,), (4,)
        The n taut cables, then the others; combinations of the statics equations and unknowns of their square
        system; see `REGIONS`. Passed apart: NamedTuples cost a tracker 2 us a call.
    z, root : (6 + n,)
        Reference pose, and where Newton starts with its tensions; written: the pose found, in floats.
    box : (6 + n, 2)
        Where tracked, the enclosure of the pose; for n < 6 also of t.

    Returns
    -------
    status, k, cable
        ``TRACKED`` with the region's k, or why it failed at the last k tried; the cable at fault, or -1.

    Guarantee
    ---------
    With TRACKED, for every choice of the lengths the robot has exactly one static pose in the region;
    it lies in the box, and the taut cables are those that carry load.
    """
    n, m = z.shape[0] - 6, free.shape[0]
    taut, others = order[:n], order[n:]
    size, radius, first, last = regions[0], regions[1], int(regions[2]), int(regions[3])
    data, far = np.empty((n + 1, 7, 2)), np.empty((others.shape[0] + 1, 7, 2))
    fill_data(cables, load, lengths, taut, data)
    fill_data(cables, load, lengths, others, far)
    C, E, f = np.empty((m, m)), np.empty((m, m, 2)), np.empty((m, 2))
    root[:] = z
    if not newton.improve(data, rows, free, root, C, NEWTON_STEPS):
        return NO_ROOT, first, -1
    X = np.empty((6 + n, 2))
    point(root, X)
    point(root, box)
    newton.residual_at(data, rows, box, f)
    # A step may leave the region that was right for the one before.
    while first > 0 and not holds(z, box, radius * 0.5**first, size):
        first -= 1
    status, cable, k = MOVED, -1, first
    for k in range(first, last + 1):
        if not region(z, radius * 0.5**k, size, X):
            continue
        if not holds(z, box, radius * 0.5**k, size):
            return status, k, cable
        status, cable = loads(far, data, taut, others, size, X)
        if status != TRACKED:
            continue
        newton.krawczyk_matrix(data, rows, free, C, X, E)
        if box_around(f, E, free, C, root, X, box) and holds(z, box, radius * 0.5**k, size):
            if ranged(lengths, taut) or vague(data):
                # The derivative over the box itself gives narrower bounds than the one over the region.
                contract(data, rows, free, C, box)
            return TRACKED, k, -1
        status = BROAD if lone(E, free, X) else SEVERAL
    return status, k, cable
