"""A cable that is taut or slack as one row of a square system: exactly one zero, whichever it is.

The unknowns are z = (u, p, t), the equations f = (f_1 .. f_n, balance) of n taut cables, of which f_k > 0
where cable k is too short. With h = -f_k what is solved is min(t_k, h) = 0 in the row of cable k, and the
others. Over a box with enclosures of all derivatives let A be the system's matrix with the row of t_k in
place of that of f_k, and x the solution of A x = (0, .., 1, .., 0), the way the pose moves with a given
tension t_k. Two points of the box differ by a matrix whose row k is a mixture of that row and of grad h (mean
value theorem, also for min), with the determinant det A ((1 - s) + s grad h . x): regular for all s in [0, 1]
when A is and grad h . x > 0. So there are not two zeros. Equivalently the determinants of the systems with
and without cable k have one sign.

There is one for every choice of data: the system with given t_k = tau has a zero z(tau) in the box for all
tau in [0, most] (Krawczyk), h(z(tau)) grows by grad h . x, and either is not negative at 0, where k is slack,
or reaches 0 before ``most``, where it carries.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.mechanics.energy import to_matrix

Floats = NDArray[np.float64]

STEPS = 20
"""Most rounds of Newton, and of growing a box until it is mapped into itself."""
GROW = 0.125
"""Share by which a box exceeds the image it was made from."""


class System(Protocol):
    """A square system in (u, p, t), the lengths of n cables first."""

    def at(self, box: Floats) -> tuple[arb_mat, arb_mat]:
        """Return the equations and their derivatives over a box (6 + n, 2)."""


def with_given_tension(J: arb_mat, k: int) -> arb_mat:
    """Return the system's matrix with the row of cable k's tension instead of its length."""
    m = J.nrows()
    rows = [[J[i, j] for j in range(m)] for i in range(m)]
    rows[k] = [arb(int(j == 6 + k)) for j in range(m)]
    return arb_mat(rows)


def improved(system: System, z: Floats, k: int) -> Floats | None:
    """Return the zero with t_k = 0 by Newton steps in floats; None where they do not converge."""
    z = z.copy()
    for _ in range(STEPS):
        values, J = system.at(np.column_stack([z, z]))
        f = balls.middle(values)[:, 0]
        f[k] = z[6 + k]
        try:
            step = np.linalg.solve(balls.middle(with_given_tension(J, k)), f)
        except np.linalg.LinAlgError:
            return None
        z -= step
        if not np.isfinite(z).all():
            return None
        if np.all(np.abs(step) <= 1e-13 * (1.0 + np.abs(z))):
            return z
    return z


def either_way(system: System, z: Floats, k: int) -> Floats | None:
    """Return a box (6 + n, 2) that holds a zero of min(t_k, h) = 0 and the others, for every choice of data.

    ``z`` is the zero with t_k = 0, in floats. None where the proof fails.
    """
    box = enclosed(system, z, k, 0.0)
    if box is None:
        return None
    values, _ = system.at(box)
    rise = slope(system, box, k)
    lowest = -values[k, 0].upper()
    if rise is None:
        return None
    most = 0.0 if lowest >= 0 else float((-2 * lowest / rise.lower()).upper())
    if most > 0.0:
        first, box = box, enclosed(system, z, k, most)
        if box is None:
            return None
        # Also: the zero with t_k = 0 that was bounded is the one that z(tau) starts from.
        rise = slope(system, hull(first, box), k)
        if rise is None or not lowest + rise.lower() * arb(most) >= 0:
            return None
    return box


def hull(one: Floats, other: Floats) -> Floats:
    """Return the box (m, 2) around two boxes."""
    return np.column_stack([np.minimum(one[:, 0], other[:, 0]), np.maximum(one[:, 1], other[:, 1])])


def slope(system: System, box: Floats, k: int) -> arb | None:
    """Return grad h . x over a box where A is regular and that is proved positive, else None."""
    _, J = system.at(box)
    m = J.nrows()
    A = with_given_tension(J, k)
    try:
        # Near the identity elimination loses little of what is known.
        C = to_matrix(np.asarray(np.linalg.inv(balls.middle(A))))
        x = (C * A).solve(C * balls.vector([int(i == k) for i in range(m)]))
    except (ZeroDivisionError, np.linalg.LinAlgError):
        return None
    rise = -sum((J[k, j] * x[j, 0] for j in range(m)), arb(0))
    return rise if rise > 0 else None


def enclosed(system: System, z: Floats, k: int, most: float) -> Floats | None:
    """Return a box (6 + n, 2) that holds z(tau) for all tau in [0, most] and data in their ranges.

    The image of the Krawczyk operator of the system with t_k = tau lies strictly inside it.
    """
    m = len(z)
    centre = z.copy()
    centre[6 + k] = 0.5 * most
    values, J = system.at(np.column_stack([centre, centre]))
    try:
        C = to_matrix(np.asarray(np.linalg.inv(balls.middle(with_given_tension(J, k)))))
    except np.linalg.LinAlgError:
        return None
    rows = balls.entries(values)
    rows[k] = arb(0, 0.5 * most)
    at_centre = C * balls.vector(rows)
    radius = np.array([float(abs(x).upper()) for x in at_centre.entries()])
    unit = balls.identity(m)
    for _ in range(STEPS):
        radius = (1.0 + GROW) * radius + 1e-15 * (1.0 + np.abs(centre))
        box = np.column_stack([centre - radius, centre + radius])
        _, J = system.at(box)
        E = unit - C * with_given_tension(J, k)
        sides = zip(box.tolist(), centre.tolist(), strict=True)
        moves = balls.vector([balls.from_bounds(lo, hi) - arb(c) for (lo, hi), c in sides])
        image = [arb(c) + x for c, x in zip(centre, (E * moves - at_centre).entries(), strict=True)]
        if all(lo < x < hi for x, (lo, hi) in zip(image, box.tolist(), strict=True)):
            return np.array([balls.to_bounds(x) for x in image])
        radius = np.array([float(abs(x - arb(c)).upper()) for x, c in zip(image, centre, strict=True)])
        if not np.isfinite(radius).all():
            return None
    return None
