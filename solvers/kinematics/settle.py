"""Moving a pose that is not quite static to a static pose near it.

At a pose the taut cables can pull with every non-negative combination of their wrenches. What of the
load they cannot balance is the residual of a non-negative least-squares fit, and a pose is static when it
vanishes. Two phases: Gauss-Newton steps of least norm make the residual vanish; then steps along the
set of static poses come as near to the given pose as that set allows (distance: translation of the centre
of mass, and rotation times the platform's radius).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.errors import InputError
from cdpr_interval.kernels.nonnegative import RANK_TOLERANCE, nonnegative_least_squares
from cdpr_interval.mechanics.statics import Pose, StaticModel

Floats = NDArray[np.float64]

SETTLED = 1e-11
"""Residual, as a share of the load, below which a pose counts as static: far below any wrench
tolerance in use, a hundred times the rounding of the wrenches."""
MOST_STEPS = 200
"""Steps of the first phase; near a static pose it needs about five."""
MOST_SLIDES = 60
"""Steps of the second phase, which converges linearly."""
MOST_RETURNS = 12
"""Steps back to the static poses after a slide; a slide that needs more was too long."""
NEAR = 0.1
"""Of the mean distance to the exit points: what a point mass has in place of a size."""
LONGEST_STEP = 0.2
"""Longest step as a share of the mean cable length: longer ones leave the range of the linearisation."""


@dataclass(frozen=True, eq=False)
class Settled:
    """Where settling ended."""

    pose: Pose
    is_static: bool
    distance: float
    """Translation of the centre of mass, m."""
    angle: float
    """Rotation, rad."""
    travel: float
    """Way of the point of the platform that moves most, m."""


@dataclass(frozen=True, eq=False)
class _Balance:
    """The linearised balance at a pose."""

    residual: float
    """As a share of the load."""
    gap: Floats
    """(k,) what the load lacks in the directions no taut cable with tension pulls in, share of the load."""
    jacobian: Floats
    """(k, 3 or 6) its derivative by the pose, 1/m."""


def settle(model: StaticModel, start: Pose, taut: tuple[int, ...]) -> Settled:
    """Return the static pose of the taut cables near a given pose.

    Parameters
    ----------
    model : StaticModel
    start : Pose
    taut : tuple of int
        Indices of the cables that may carry tension.

    Returns
    -------
    Settled
        With ``is_static`` False where no static pose was found; the pose is then the best one.
    """
    pose = _balance_load(model, start, taut)
    is_static = _balance(model, pose, taut).residual <= SETTLED
    if is_static:
        pose = _slide_back(model, start, pose, taut)
    step = model.displacement(start, pose)
    angle = 0.0 if model.rows == 3 else float(np.linalg.norm(step[3:])) / model.radius
    return Settled(pose, is_static, float(np.linalg.norm(step[:3])), angle, model.travel(start, pose))


def nearby(model: StaticModel, pose: Pose) -> float:
    """Return how far from a pose a static one still counts as near it, m.

    A platform's size (largest distance of an anchor from the centre of mass: a turn on the spot by 60
    deg); for a point mass `NEAR` of the mean distance to the exit points.
    """
    return model.radius if model.rows == 6 else NEAR * float(np.mean(model.distances(pose)))


def _balance(model: StaticModel, pose: Pose, taut: tuple[int, ...]) -> _Balance:
    size = float(np.linalg.norm(model.load))
    load = model.load_wrench / size
    columns = model.wrenches(pose)[:, taut]
    tensions = nonnegative_least_squares(columns, -load)
    full = np.zeros(len(model.names))
    full[list(taut)] = tensions
    used = columns[:, tensions > 0.0]
    left, singular, _ = np.linalg.svd(used)
    rank = int(np.sum(singular > RANK_TOLERANCE * singular.max(initial=0.0)))
    free = left[:, rank:].T
    residual = float(np.linalg.norm(columns @ tensions + load))
    return _Balance(residual, free @ load, free @ model.wrench_derivative(pose, full))


def _balance_load(model: StaticModel, pose: Pose, taut: tuple[int, ...], most: int = MOST_STEPS) -> Pose:
    """Lower the residual by damped Gauss-Newton steps until it vanishes or no step lowers it."""
    reach = LONGEST_STEP * float(np.mean(model.distances(pose)))
    balance = _balance(model, pose, taut)
    for _ in range(most):
        if balance.residual <= SETTLED / 100:
            break
        step = -_least_norm(balance.jacobian, balance.gap)
        length = float(np.linalg.norm(step))
        share = min(1.0, reach / length) if length > 0.0 else 0.0
        while share > 1e-6:
            trial = model.moved(pose, share * step)
            better = _balance_or_none(model, trial, taut)
            if better is not None and better.residual < balance.residual * (1.0 - 1e-4 * share):
                pose, balance = trial, better
                break
            share /= 2.0
        else:
            break
    return pose


def _least_norm(matrix: Floats, target: Floats) -> Floats:
    return np.asarray(np.linalg.lstsq(matrix, target, rcond=RANK_TOLERANCE)[0], dtype=np.float64)


def _balance_or_none(model: StaticModel, pose: Pose, taut: tuple[int, ...]) -> _Balance | None:
    try:
        return _balance(model, pose, taut)
    except InputError:
        # The trial step ran an anchor into its exit point or pulley.
        return None


def _slide_back(model: StaticModel, start: Pose, pose: Pose, taut: tuple[int, ...]) -> Pose:
    """Move along the static poses towards the start as long as that shortens the way."""
    away = model.displacement(start, pose)
    for _ in range(MOST_SLIDES):
        jacobian = _balance(model, pose, taut).jacobian
        normal = _least_norm(jacobian, jacobian @ away)
        slide = normal - away
        distance = float(np.linalg.norm(away))
        if np.linalg.norm(slide) <= 1e-9 * distance or distance <= 1e-15:
            break
        share = 1.0
        while share > 1e-3:
            try:
                trial = _balance_load(model, model.moved(pose, share * slide), taut, MOST_RETURNS)
            except InputError:
                # The slide ran an anchor into its exit point or pulley.
                share /= 2.0
                continue
            shorter = model.displacement(start, trial)
            if (
                np.linalg.norm(shorter) < distance * (1.0 - 1e-12)
                and _balance(model, trial, taut).residual <= SETTLED
            ):
                pose, away = trial, shorter
                break
            share /= 2.0
        else:
            break
    return pose
