"""Poses at which some taut cable may pull against the load: at all others nothing holds it.

With sum t_i e_i + f = 0 and no t_i < 0, sum t_i f . e_i = -|f|^2 < 0, so some taut cable has f . e_i < 0.
This is Gordan's test with y = f. The y that the search finds at a cell's centre may miss it, mostly with six
cables whose wrenches are nearly dependent. So what is left over is tested once more; in the search the test
costs more than the one or two per cent of cells it saves.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.mechanics.rotation import HALF_TURNS
from cdpr_interval.mechanics.six_dof.arrays import Model

Floats = NDArray[np.float64]

ROUNDING = 1e-13
"""Error of f . e over the sum of the sizes of its terms: some dozens of operations, of 2^-53 each, on terms
up to eight times as large (u reaches from -1 to 1)."""


def turned_arms(model: Model, charts: Floats, u: Floats, count: int) -> Floats:
    """Return R(u) D_c b_i (C, count, 3) of the first cables, for u (C, 3) and charts (C,), in floats."""
    arms = model.arms[0, :count] * HALF_TURNS[charts.astype(np.int64)][:, None, :]
    v = u[:, None, :]
    across = np.cross(v, arms)
    moved = 2.0 * (across + np.cross(v, across)) / (1.0 + (v * v).sum(axis=2, keepdims=True))
    return np.asarray(arms + moved)


def may_lift(model: Model, charts: Floats, poses: Floats) -> NDArray[np.bool_]:
    """Return which boxes of poses may hold one at which a taut cable pulls against the load.

    Parameters
    ----------
    model : Model
    charts : (C,)
        Charts of the boxes.
    poses : (C, 6, 2)
        Bounds of u, within [-1, 1], and of p (the unit of length of the model); NaN where there are none.

    Returns
    -------
    (C,)
        False: f . e_i >= 0 is proved for all taut cables at all poses of the box and for all data in their
        enclosures, so that no tensions >= 0 balance the load there. True throughout where tensions may have
        any sign.

    Guarantee: R(u) and R(v) differ by an angle of at most 2 |u - v|, which moves an arm b by at most
    2 |u - v| |b|. Over the box f . e_i so differs from its value at the middle by at most
    |f| . dp + 2 |f| |du| |b_i|.
    """
    n = model.n_taut
    if not model.statics:
        return np.ones(len(poses), dtype=np.bool_)
    with np.errstate(over="ignore", invalid="ignore"):
        unit = np.abs(model.load).max()
        f, f_err = model.load / unit, np.abs(model.load_err / unit).sum()
        middle = 0.5 * poses[:, :, 0] + 0.5 * poses[:, :, 1]
        radius = np.maximum(poses[:, :, 1] - middle, middle - poses[:, :, 0])
        arms = turned_arms(model, charts, middle[:, :3], n)
        pull = (model.exits[:n] - middle[:, None, 3:] - arms) @ f
        length = np.linalg.norm(model.arms[0, :n], axis=1)
        turn = np.linalg.norm(radius[:, :3], axis=1)
        change = (radius[:, 3:] @ np.abs(f))[:, None] + 2.0 * np.linalg.norm(f) * turn[:, None] * length
        far = np.abs(poses[:, 3:]).max(axis=2).sum(axis=1)
        size = np.abs(model.exits[:n]).sum(axis=1) + far[:, None] + length
        data = (model.exits_err[:n] + model.arms_err[:n] + model.exit_spread[:n]).sum(axis=1)
        data += model.arm_spread[:n]
        whole = np.abs(f).sum()
        error = (ROUNDING * whole + f_err) * size + ROUNDING * change + (whole + f_err) * data
        proved = pull - change - (1.0 + ROUNDING) * error >= 0.0
    return np.asarray(~proved.all(axis=1))
