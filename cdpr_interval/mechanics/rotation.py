"""Rotations in charts: R = R(u) D_c with the Rodrigues vector u and a half turn D_c, in floats and in bounds.

R(u) = I + 2 ([u]_x + [u]_x^2) / (1 + |u|^2) turns by the angle a about u where |u| = tan(a / 2); its
quaternion is (1, u) but for its norm. D_0 = I, and D_1, D_2, D_3 turn by pi about x, y, z. Every rotation has
a chart in which no entry of u is above 1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.kernels import interval
from cdpr_interval.kernels.kernel import entry
from cdpr_interval.mechanics.orientation import Quaternion

HALF_TURNS = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])
"""Diagonals of D_c for c = 0..3; chart c holds the unit quaternions whose entry c is largest."""


@entry("void(f8[::1], f8[:, ::1])")
def rotation_at(u: Any, R: Any) -> None:
    """Write R(u) to R (3, 3) for u (3,), in floats."""
    square = u[0] * u[0] + u[1] * u[1] + u[2] * u[2]
    g = 2.0 / (1.0 + square)
    for i in range(3):
        for j in range(3):
            if i == j:
                R[i, j] = 1.0 + g * (u[i] * u[i] - square)
            elif (j - i) % 3 == 1:
                R[i, j] = g * (u[i] * u[j] - u[3 - i - j])
            else:
                R[i, j] = g * (u[i] * u[j] + u[3 - i - j])


@entry("void(f8[:, ::1], f8[:, :, ::1], f8[:, :, :, ::1])")
def rotation_interval(z: Any, R: Any, dR: Any) -> None:
    """Enclose R(u) in R (3, 3, 2) and dR/du_k in dR[k], dR (3, 3, 3, 2), over a box z (>= 3, 2) of u."""
    slo, shi = 1.0, 1.0
    for k in range(3):
        a, b = interval.sqr(z[k, 0], z[k, 1])
        slo, shi = interval.add(slo, shi, a, b)
    glo, ghi = interval.div(2.0, 2.0, slo, shi)
    # N = [u]_x + u u^T - |u|^2 I and dN/du_k, exact products of the entries of u.
    for i in range(3):
        for j in range(3):
            if i == j:
                a, b = (i + 1) % 3, (i + 2) % 3
                qlo, qhi = interval.sqr(z[a, 0], z[a, 1])
                rlo, rhi = interval.sqr(z[b, 0], z[b, 1])
                nlo, nhi = interval.add(qlo, qhi, rlo, rhi)
                nlo, nhi = -nhi, -nlo
            else:
                k = 3 - i - j
                nlo, nhi = interval.mul(z[i, 0], z[i, 1], z[j, 0], z[j, 1])
                # [u]_x has -u_k at (i, j) when (i, j, k) is an even permutation, +u_k otherwise.
                if (j - i) % 3 == 1:
                    nlo, nhi = interval.sub(nlo, nhi, z[k, 0], z[k, 1])
                else:
                    nlo, nhi = interval.add(nlo, nhi, z[k, 0], z[k, 1])
            nlo, nhi = interval.mul(glo, ghi, nlo, nhi)
            for k in range(3):
                dlo, dhi = 0.0, 0.0
                if i == j:
                    if k != i:
                        dlo, dhi = -2.0 * z[k, 1], -2.0 * z[k, 0]
                else:
                    if k == i:
                        dlo, dhi = z[j, 0], z[j, 1]
                    elif k == j:
                        dlo, dhi = z[i, 0], z[i, 1]
                    elif (j - i) % 3 == 1:
                        dlo, dhi = -1.0, -1.0
                    else:
                        dlo, dhi = 1.0, 1.0
                # d(g N) = g dN - g u_k (g N), since dg/du_k = -g^2 u_k.
                tlo, thi = interval.mul(z[k, 0], z[k, 1], nlo, nhi)
                dlo, dhi = interval.sub(dlo, dhi, tlo, thi)
                dlo, dhi = interval.mul(glo, ghi, dlo, dhi)
                dR[k, i, j, 0] = dlo
                dR[k, i, j, 1] = dhi
            if i == j:
                nlo, nhi = interval.add(1.0, 1.0, nlo, nhi)
            # The entries of a rotation lie in [-1, 1].
            R[i, j, 0] = max(nlo, -1.0)
            R[i, j, 1] = min(nhi, 1.0)


@entry("void(f8[:, ::1], i8, f8[:, :, :, ::1], f8[:, :, ::1], f8[:, :, ::1])")
def model_rotation(box: Any, chart: int, slopes: Any, point: Any, out: Any) -> None:
    """Enclose R(u) D_c in out (3, 3, 2) over a box (>= 3, 2) of u.

    It is enclosed by R itself, and by R(m) + sum dR/du_k (u_k - m_k). The second keeps wide boxes (length
    ranges) from being overestimated, the first thin ones from rounding.
    ``slopes`` (3, 3, 3, 2) and ``point`` (3, 3, 2) are scratch.
    """
    middle = np.empty((3, 2))
    for k in range(3):
        middle[k, 0] = interval.mid(box[k, 0], box[k, 1])
        middle[k, 1] = middle[k, 0]
    rotation_interval(middle, point, slopes)
    rotation_interval(box, out, slopes)
    for i in range(3):
        for j in range(3):
            lo, hi = point[i, j, 0], point[i, j, 1]
            for k in range(3):
                a, b = interval.sub(box[k, 0], box[k, 1], middle[k, 0], middle[k, 1])
                a, b = interval.mul(slopes[k, i, j, 0], slopes[k, i, j, 1], a, b)
                lo, hi = interval.add(lo, hi, a, b)
            lo, hi = max(lo, out[i, j, 0]), min(hi, out[i, j, 1])
            if HALF_TURNS[chart, j] > 0.0:
                out[i, j, 0], out[i, j, 1] = lo, hi
            else:
                out[i, j, 0], out[i, j, 1] = -hi, -lo


def quaternion_of(chart: int, z: NDArray[np.float64]) -> Quaternion:
    """Return (w, x, y, z) of R(u) D_c for z = (u, ..), not normalised.

    Its entries are exactly 1 and those of u, signed.
    """
    x, y, z_ = z[:3].tolist()
    products = (
        (1.0, x, y, z_),
        (-x, 1.0, z_, -y),
        (-y, -z_, 1.0, x),
        (-z_, y, -x, 1.0),
    )
    return products[chart]


def chart_of(quaternion: Quaternion) -> tuple[int, tuple[float, float, float]]:
    """Return the chart c and u, all entries at most 1, with R(u) D_c near the rotation of a quaternion."""
    sizes = [abs(q) for q in quaternion]
    chart = sizes.index(max(sizes))
    return chart, u_in(chart, quaternion)


def u_in(chart: int, quaternion: Quaternion) -> tuple[float, float, float]:
    """Return u with R(u) D_c near the rotation of a quaternion; its entry c must not be 0."""
    w, x, y, z = (q / quaternion[chart] for q in quaternion)
    # The inverses of ``quaternion_of``.
    return ((x, y, z), (-w, -z, y), (z, -w, -x), (-y, x, -w))[chart]


def best_chart(rotation: NDArray[np.float64]) -> int:
    """Return the chart of a rotation (3, 3): the entry of its quaternion that is largest."""
    r = rotation
    squares = [
        1 + r[0, 0] + r[1, 1] + r[2, 2],
        1 + r[0, 0] - r[1, 1] - r[2, 2],
        1 - r[0, 0] + r[1, 1] - r[2, 2],
        1 - r[0, 0] - r[1, 1] + r[2, 2],
    ]
    return int(np.argmax(squares))
