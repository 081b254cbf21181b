"""From leaves of the search to proved roots of platforms on real cables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.budget import Budget
from cdpr_interval.mechanics.rotation import HALF_TURNS, rotation_at
from solvers.six_dof.real.columns import REAL_COLUMNS
from solvers.six_dof.real.model import RealModel
from solvers.six_dof.real.system import Bench, existence_box, growth, improve, new_bench, system

Floats = NDArray[np.float64]

NEWTON_STEPS = 40
FAR_OUT = 3.0
"""Newton may leave a chart's cube [-1, 1]^3; beyond this another chart finds the root better."""
CLAIM = 3.0
"""A Newton start speaks for the other leaves within this many leaf sizes in u."""
MOST_STARTS = 400
"""Newton starts in one round."""
LARGEST_REACH = 0.25
HALVINGS = 24
LEAST_RANGE = 1e-9
"""Width of a range of lengths (over 1 and the length) from which on it is more than rounding."""


class RealRoot(NamedTuple):
    """A proved zero: exactly one in ``box``, no other one in ``unique``; (6 + n, 2) in (u, p, t).

    ``core`` holds the zero for one choice of the lengths in their ranges: by it zeros are told from each
    other, for two that are the same for one choice go on as one.
    """

    chart: int
    box: Floats
    unique: Floats
    core: Floats


def find_roots(
    real: RealModel, leaves: Floats, leaf_size: float, known: Sequence[RealRoot], budget: Budget
) -> list[RealRoot]:
    """Start Newton from leaves spread over each cluster and prove what it finds."""
    found: list[RealRoot] = []
    todo = np.ones(len(leaves), dtype=np.bool_)
    middle = 0.5 * (leaves[:, 0:12:2] + leaves[:, 1:12:2])
    for _ in range(MOST_STARTS):
        if not todo.any() or budget.stop() is not None:
            break
        k = int(np.argmax(todo))
        near = np.abs(middle[:, :3] - middle[k, :3]).max(axis=1) <= CLAIM * leaf_size
        near &= leaves[:, REAL_COLUMNS.chart] == leaves[k, REAL_COLUMNS.chart]
        near &= np.abs(middle[:, 3:] - middle[k, 3:]).max(axis=1) <= CLAIM * real.size * max(leaf_size, 0.01)
        todo &= ~near
        todo[k] = False
        root = root_near(real, int(leaves[k, REAL_COLUMNS.chart]), middle[k], [*known, *found])
        if root is not None:
            found.append(root)
    return found


def root_near(real: RealModel, chart: int, pose: Floats, known: Sequence[RealRoot]) -> RealRoot | None:
    """Return a proved root that Newton finds from a pose (6,) and that is not known."""
    n = real.n_taut
    bench = new_bench(real, chart)
    z = np.concatenate([pose, np.zeros(n)])
    f, J = np.empty((6 + n, 2)), np.empty((6 + n, 6 + n, 2))
    if not system(bench, np.repeat(z[:, None], 2, axis=1), f, J, True):
        return None
    wrenches = J[n:, 6:].mean(axis=2)
    load = np.concatenate([real.load, np.zeros(3)])
    z[6:] = np.linalg.lstsq(wrenches, -load, rcond=1e-8)[0]
    C = np.empty((6 + n, 6 + n))
    if not improve(bench, z, C, NEWTON_STEPS) or np.abs(z[:3]).max() >= FAR_OUT or not np.isfinite(z).all():
        return None
    if any(r.chart == chart and ((r.unique[:, 0] <= z) & (z <= r.unique[:, 1])).all() for r in known):
        return None
    box = np.empty((6 + n, 2))
    if not existence_box(bench, z, C, box):
        return None
    unique = largest_unique(real, bench, z, C, box)
    if unique is None:
        return None
    return RealRoot(chart, box, unique, core_of(bench, z, box))


def core_of(bench: Bench, z: Floats, box: Floats) -> Floats:
    """Return a box of the zero at the middle of the ranges of lengths; that of all where there are none."""
    real = bench.real
    lo, hi = real.lengths.T
    wide = hi - lo > LEAST_RANGE * (1.0 + hi)
    if not wide.any():
        return box
    middle = np.where(wide, 0.5 * (lo + hi), lo), np.where(wide, 0.5 * (lo + hi), hi)
    core, C = np.empty(box.shape), np.empty((len(box), len(box)))
    one = bench._replace(real=real._replace(lengths=np.ascontiguousarray(np.stack(middle, axis=1))))
    z = z.copy()
    if not (improve(one, z, C, NEWTON_STEPS) and existence_box(one, z, C, core)):
        return box
    # The zero of this choice in ``box`` is the one there, if the core is.
    inside = (box[:, 0] <= core[:, 0]) & (core[:, 1] <= box[:, 1])
    return core if inside.all() else box


def largest_unique(real: RealModel, bench: Bench, z: Floats, C: Floats, box: Floats) -> Floats | None:
    """Return the largest of a series of boxes around a root in which it is proved to be the only one."""
    n = real.n_taut
    f, J = np.empty((6 + n, 2)), np.empty((6 + n, 6 + n, 2))
    if not system(bench, np.repeat(z[:, None], 2, axis=1), f, J, True):
        return None
    J = J.mean(axis=2)
    # How p and t go with u along the lengths and the balance of forces, in floats.
    place = np.linalg.lstsq(J[:n, 3:6], -J[:n, :3], rcond=1e-6)[0]
    rest = J[n:, :3] + J[n:, 3:6] @ place
    pull = np.linalg.lstsq(J[n:, 6:], -rest, rcond=1e-6)[0]
    most = float(np.abs(z[6:]).max(initial=0.0))
    shape = np.concatenate(
        [
            np.ones(3),
            1.3 * np.abs(place).sum(axis=1) + 0.2 * real.size,
            1.3 * np.abs(pull).sum(axis=1) + 0.2 * most + 1e-6,
        ]
    )
    for halving in range(1, HALVINGS):
        half = LARGEST_REACH * 0.5**halving * shape
        # Cells near the border of ``box`` reach beyond it.
        unique = np.stack([box[:, 0] - half, box[:, 1] + half], axis=1)
        if growth(bench, C, np.ascontiguousarray(unique)) < 1.0:
            return unique
    return None


def rotation_of(chart: int, u: Floats) -> Floats:
    """Return R(u) D_c in floats."""
    R = np.empty((3, 3))
    rotation_at(np.ascontiguousarray(u), R)
    return np.asarray(R * HALF_TURNS[chart])
