"""Where Newton starts: poses of leaves and tensions that go with them, in plain floats, proved elsewhere.

Arrays, for n taut cables: ``data`` (n + 1, 7, 2) a model's numbers in one chart, see ``system.fill_data``;
``order`` (n,) a row of ``Model.orders``; ``z`` (6 + n,) the start (u, p, t); ``u`` (3,); ``R`` (3, 3) is
R(u); ``leaf`` (width,), ``leaves`` (L, width), ``todo`` (L,) those left of them.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.kernel import entry
from cdpr_interval.mechanics.rotation import rotation_at
from solvers.six_dof.cells.columns import ROTATION_COLUMNS

REGULARISATION = 1e-13
"""Share of the trace added to the normal equations of the starting tensions: wrenches may be dependent."""


@entry("void(f8[::1], f8[::1], f8, f8, f8, f8, f8[::1])")
def branch_position(a: Any, b: Any, k2: float, k3: float, square: float, branch: float, z: Any) -> None:
    """Write x with a . x = k2, b . x = k3, |x|^2 = square on the side ``branch`` of a x b to z[3:6].

    ``a, b`` : (3,).
    """
    m = np.empty(3)
    for k in range(3):
        m[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]
    mm = max(m[0] * m[0] + m[1] * m[1] + m[2] * m[2], 1e-300)
    foot = 0.0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        x = (k2 * (b[i] * m[j] - b[j] * m[i]) + k3 * (m[i] * a[j] - m[j] * a[i])) / mm
        z[3 + k] = x
        foot += x * x
    height = branch * math.sqrt(max(square - foot, 0.0) / mm)
    for k in range(3):
        z[3 + k] += height * m[k]


@entry("void(f8[:, :, ::1], f8[:, ::1], i8, f8[::1])")
def centre_at(data: Any, R: Any, i: int, out: Any) -> None:
    """Write the centre c_i = A_i - R D_c b_i of a taut cable's sphere to out (3,), in floats."""
    for k in range(3):
        out[k] = 0.5 * (data[i, k, 0] + data[i, k, 1])
        for c in range(3):
            out[k] -= R[k, c] * 0.5 * (data[i, 3 + c, 0] + data[i, 3 + c, 1])


@entry("void(f8[:, :, ::1], i8[::1], b1, f8[::1], f8[:, ::1])")
def triple_at(data: Any, order: Any, planar: bool, u: Any, out: Any) -> None:
    """Write c_1 and the steps c_2 - c_1, c_3 - c_1 of a triple at u to the rows of out (3, 3), in floats.

    In a plane the third row is its normal.
    """
    R = np.empty((3, 3))
    rotation_at(u, R)
    for row in range(2 if planar else 3):
        centre_at(data, R, order[row], out[row])
    for k in range(3):
        out[1, k] -= out[0, k]
        if planar:
            out[2, k] = 1.0 if k == 1 else 0.0
        else:
            out[2, k] -= out[0, k]


@entry("void(f8[:, :, ::1], i8[::1], b1, f8, f8[::1])")
def position_on_branch(data: Any, order: Any, planar: bool, branch: float, z: Any) -> None:
    """Write p of one branch at u to z[3:6], in floats; branch 0 stands for the middle between both."""
    triple = np.empty((3, 3))
    triple_at(data, order, planar, z[:3], triple)
    half = np.zeros(2)
    square = 0.5 * (data[order[0], 6, 0] + data[order[0], 6, 1])
    for row in range(1 if planar else 2):
        i = order[1 + row]
        half[row] = square - 0.5 * (data[i, 6, 0] + data[i, 6, 1])
        for k in range(3):
            half[row] += triple[1 + row, k] * triple[1 + row, k]
    branch_position(triple[1], triple[2], 0.5 * half[0], 0.5 * half[1], square, branch, z)
    for k in range(3):
        z[3 + k] += triple[0, k]


@entry("void(f8[:, :, ::1], i8[::1], b1, f8[::1], b1, b1[::1], f8[::1])")
def leaf_pose(data: Any, order: Any, planar: bool, leaf: Any, in_position: bool, frozen: Any, z: Any) -> None:
    """Write u and p at the middle of a leaf to z; what the reduction fixes becomes exactly 0.

    ``frozen`` : (3,) the entries of u that it fixes.
    """
    for k in range(3):
        z[k] = 0.5 * (leaf[2 * k] + leaf[2 * k + 1])
    if in_position:
        triple = np.empty((3, 3))
        triple_at(data, order, planar, z[:3], triple)
        for k in range(3):
            z[3 + k] = triple[0, k] + 0.5 * (leaf[6 + 2 * k] + leaf[7 + 2 * k])
    else:
        position_on_branch(data, order, planar, leaf[ROTATION_COLUMNS.branch], z)
    for k in range(3):
        if frozen[k]:
            z[k] = 0.0
    if planar:
        z[4] = 0.0


@entry("void(f8[:, :, ::1], f8, f8[::1])")
def starting_tensions(data: Any, size: float, z: Any) -> None:
    """Write t that balance the load best to z[6:], in floats (least squares by normal equations).

    ``size`` divides the moments.
    """
    n = data.shape[0] - 1
    R = np.empty((3, 3))
    rotation_at(z[:3], R)
    c = np.empty(3)
    wrenches = np.empty((n, 6))
    a = np.zeros((n, n + 1))
    trace = 0.0
    for i in range(n):
        centre_at(data, R, i, c)
        for k in range(3):
            wrenches[i, k] = c[k] - z[3 + k]
        for k in range(3):
            p, q = (k + 1) % 3, (k + 2) % 3
            # r x e = (A - c) x e.
            wrenches[i, 3 + k] = (
                (data[i, p, 0] - c[p]) * wrenches[i, q] - (data[i, q, 0] - c[q]) * wrenches[i, p]
            ) / size
        for j in range(i + 1):
            for k in range(6):
                a[i, j] += wrenches[i, k] * wrenches[j, k]
            a[j, i] = a[i, j]
        trace += a[i, i]
        for k in range(3):
            a[i, n] -= wrenches[i, k] * data[n, k, 0]
    for i in range(n):
        a[i, i] += REGULARISATION * trace
    solved = solve_in_place(a, n, 1)
    for i in range(n):
        z[6 + i] = a[i, n] if solved else 0.0


@entry("void(f8[::1], f8[:, ::1])")
def across_rod(u: Any, rows: Any) -> None:
    """Fill the last two combinations of the statics, of rows (5, 6): moments across the platform's z axis."""
    R = np.empty((3, 3))
    rotation_at(u, R)
    # The half turns only change the sign of the axis, the third column. Two unit vectors across it:
    least = 0
    for k in range(3):
        if abs(R[k, 2]) < abs(R[least, 2]):
            least = k
    norm = 0.0
    for k in range(3):
        x = (1.0 if k == least else 0.0) - R[least, 2] * R[k, 2]
        rows[3, 3 + k] = x
        norm += x * x
    for k in range(3):
        rows[3, 3 + k] /= math.sqrt(norm)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        rows[4, 3 + k] = R[i, 2] * rows[3, 3 + j] - R[j, 2] * rows[3, 3 + i]


@entry("void(f8[:, ::1], b1[::1], i8, i8, i8, f8)")
def claim(leaves: Any, todo: Any, k: int, chart: int, branch: int, reach: float) -> None:
    """Strike leaf k and those it speaks for off the list; ``branch`` is its column, -1 for none."""
    for i in range(k, leaves.shape[0]):
        near = todo[i] and leaves[i, chart] == leaves[k, chart]
        near = near and (branch < 0 or leaves[i, branch] == leaves[k, branch])
        for c in range(3):
            apart = leaves[i, 2 * c] + leaves[i, 2 * c + 1] - leaves[k, 2 * c] - leaves[k, 2 * c + 1]
            near = near and 0.5 * abs(apart) <= reach
        if near:
            todo[i] = False
