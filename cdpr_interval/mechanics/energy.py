"""The energy around a static pose: the Hessian of the Lagrangian on the motions the taut cables leave.

With t_i = tension_i / l_i and a motion (v, omega) at the centre of mass, the quadratic form is
Q = sum t_i (|v + omega x r_i|^2 - e_i . (omega x (omega x r_i))), on the directions with
e_i . (v + omega x r_i) = 0 for every taut cable. Positive definite: the pose is a strict minimum of
the height of the load. Motions that only follow a family are taken out first.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.mechanics.stability import Stability

Floats = NDArray[np.float64]


def skew(v: arb_mat) -> arb_mat:
    """Return [v]_x."""
    x, y, z = balls.entries(v)
    return arb_mat([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def quadratic_form(spokes: list[arb_mat], arms: list[arb_mat], densities: list[arb]) -> arb_mat:
    """Return the symmetric matrix (6, 6) of Q in (v, omega) for spokes e_i and arms r_i."""
    top_left = arb_mat(3, 3)
    top_right = arb_mat(3, 3)
    bottom = arb_mat(3, 3)
    for e, r, t in zip(spokes, arms, densities, strict=True):
        k = skew(r)
        # v + omega x r = v - [r]_x omega; e . (omega x (omega x r)) = (omega.e)(omega.r) - |omega|^2 e.r.
        outer = e * r.transpose()
        symmetric = (outer + outer.transpose()) * arb(0.5)
        top_left += balls.identity() * t
        top_right += k * (-t)
        bottom += (k.transpose() * k - symmetric + balls.identity() * balls.dot(e, r)) * t
    rows = [[top_left[i, j] for j in range(3)] + [top_right[i, j] for j in range(3)] for i in range(3)]
    rows += [[top_right[j, i] for j in range(3)] + [bottom[i, j] for j in range(3)] for i in range(3)]
    return arb_mat(rows)


def constraint_rows(spokes: list[arb_mat], arms: list[arb_mat]) -> list[list[arb]]:
    """Return the wrenches (e_i, r_i x e_i) as rows: they annihilate the motions left free."""
    return [[*balls.entries(e), *balls.entries(balls.cross(r, e))] for e, r in zip(spokes, arms, strict=True)]


def classify(
    spokes: list[arb_mat],
    arms: list[arb_mat],
    densities: list[arb],
    family_motions: list[arb_mat],
    slack_open: bool,
) -> Stability:
    """Classify a proved pose.

    Parameters
    ----------
    spokes, arms, densities
        e_i, r_i (3, 1) and t_i of the taut cables.
    family_motions
        Motions (6, 1) along the pose's family; the form is taken across them.
    slack_open
        A tension or a slack is only just zero: then a direction of descent of Q may be blocked,
        and "unstable" is not claimed. A cable without a proved tension blocks nothing for "stable".
    """
    form = quadratic_form(spokes, arms, densities)
    # A cable whose tension may be zero can let go: it holds no motion back.
    holding = [k for k, t in enumerate(densities) if t > 0]
    rows = constraint_rows([spokes[k] for k in holding], [arms[k] for k in holding])
    rows += [balls.entries(m) for m in family_motions]
    if not rows or not all(x.is_finite() for row in (*rows, form.entries()) for x in row):
        return Stability.UNDECIDED
    try:
        reduced = on_kernel(form, arb_mat(rows))
    except ZeroDivisionError:
        return Stability.UNDECIDED
    if reduced is None or positive_definite(reduced):
        return Stability.STABLE
    if not slack_open and has_negative_direction(reduced):
        return Stability.UNSTABLE
    return Stability.UNDECIDED


def on_kernel(form: arb_mat, constraints: arb_mat) -> arb_mat | None:
    """Return the form on the kernel of ``constraints`` (m, 6); None where the kernel is zero.

    With Z a float basis of the middle's kernel and Y of its row space, a kernel vector is
    Z y + Y s with (G Y) s = -G Z y. Raises ZeroDivisionError where G may lose rank.
    """
    m = constraints.nrows()
    if m >= 6:
        return None
    right = np.linalg.svd(balls.middle(constraints))[2]
    y = to_matrix(right[:m].T)
    z = to_matrix(right[m:].T)
    basis = z - y * (constraints * y).solve(constraints * z)
    return basis.transpose() * form * basis


def to_matrix(values: NDArray[np.floating[Any]]) -> arb_mat:
    """Return exact balls of a float matrix."""
    return arb_mat([[arb(float(x)) for x in row] for row in values])


def positive_definite(form: arb_mat) -> bool:
    """Return True when every symmetric matrix in the ball matrix is proved positive definite.

    After a congruence with the float eigenvectors, strict diagonal dominance with a positive
    diagonal is enough (Gershgorin).
    """
    n = form.nrows()
    vectors = to_matrix(np.linalg.eigh(0.5 * (balls.middle(form) + balls.middle(form).T))[1])
    turned = vectors.transpose() * form * vectors
    for i in range(n):
        others = sum((turned[i, j].abs_upper() for j in range(n) if j != i), arb(0))
        if not turned[i, i] > others:
            return False
    return True


def has_negative_direction(form: arb_mat) -> bool:
    """Return True when one direction is proved to make the form negative."""
    values, vectors = np.linalg.eigh(0.5 * (balls.middle(form) + balls.middle(form).T))
    v = to_matrix(vectors[:, [int(np.argmin(values))]])
    return bool((v.transpose() * form * v)[0, 0] < 0)
