"""Where a platform may be when its pose is not proved: Newton's method in plain floats, for controllers.

Nothing here is certified. The cables that carry are found along the way: one whose tension would be negative
is let go, one that would be too short takes hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.mechanics.orientation import (
    Quaternion,
    quaternion_from_rotation,
    rotation_from_vector,
    rpy_from_rotation,
)
from cdpr_interval.mechanics.six_dof.arrays import platform_size
from cdpr_interval.robots.cable_robot import Robot

Floats = NDArray[np.float64]

STEPS = 40
"""Of Newton's method for one set of taut cables."""
LONGEST_STEP = 0.5
"""Of one step: rad, or sizes of the platform; larger ones leave what the derivatives describe."""
CONVERGED = 1e-9
"""Residual, in sizes of the platform and in loads, at which the pose is one in floats."""
TIGHT = 1e-7
"""How much too short, in sizes of the platform, a cable outside the taut ones may seem by rounding."""
MOST_TAUT = 6


@dataclass(frozen=True)
class Estimate:
    """A pose in plain floats: **not certified**, it may not exist, or be another one than the platform's.

    Attributes
    ----------
    status : str
        Always ``estimate``.
    converged : bool
        The equations of the taut cables hold up to rounding; False: this is the best that was found, and
        ``residual`` says how good that is.
    residual : float
        Largest error of a taut cable's length in m.
    taut : tuple of int
        The cables taken to carry, file order.
    position : (x, y, z)
        Platform origin in the base frame, m.
    rotation : (3, 3) array
        Platform to base.
    tensions : (N,) array
        N, file order; 0 for a cable that is not taut. Negative ones mean that this is no static pose.
    """

    converged: bool
    residual: float
    taut: tuple[int, ...]
    position: tuple[float, float, float]
    rotation: Floats
    tensions: Floats
    status: Literal["estimate"] = "estimate"

    @property
    def point(self) -> tuple[float, float, float]:
        """The position, in the word of `TrackedPose`."""
        return self.position

    @property
    def quaternion(self) -> Quaternion:
        """Unit quaternion (w, x, y, z), platform to base."""
        return quaternion_from_rotation(self.rotation)

    @property
    def rpy(self) -> tuple[float, float, float]:
        """Roll, pitch, yaw in rad: R = Rz(yaw) Ry(pitch) Rx(roll)."""
        return rpy_from_rotation(self.rotation)

    def __repr__(self) -> str:
        place = ", ".join(f"{x:.6g}" for x in self.position)
        how = "" if self.converged else f", not converged, lengths differ by {self.residual:.3g} m"
        return f"<Estimate ({place}) m, taut {self.taut}, not certified{how}>"


@dataclass
class Guess:
    """A pose and densities (tension / length) that Newton's method improves."""

    centre: Floats
    """(3,) m: the centre of mass, base frame."""
    rotation: Floats
    """(3, 3)."""
    taut: tuple[int, ...]
    densities: Floats
    """(n,) N/m."""


class Body:
    """A platform in plain floats."""

    def __init__(self, robot: Robot) -> None:
        view = loaded(robot).middle
        self.names = robot.cable_names
        self.exits = np.array([[float(x) for x in a] for a in view.exits])
        self.arms = np.array([[float(x) for x in b] for b in view.arms])
        self.offset = np.array([float(x) for x in view.centre])
        """(3,) m: the centre of mass in the platform frame."""
        self.size = platform_size(self.arms)

    def distances(self, centre: Floats, rotation: Floats) -> Floats:
        """Return the distances (N,) from the exit points to the platform's points, m."""
        found: Floats = np.linalg.norm(self.exits - centre - self.arms @ rotation.T, axis=1)
        return found


def estimate(body: Body, guess: Guess, lengths: Floats, load: Floats) -> tuple[Estimate, Guess]:
    """Return a static pose near a guess, and as a guess for the next call.

    Parameters
    ----------
    body, guess
        The platform, and where to start.
    lengths : (N,) array
        m.
    load : (3,) array
        Force at the centre of mass, N.
    """
    tried: set[tuple[int, ...]] = set()
    converged, error = False, np.inf
    while guess.taut not in tried:
        tried.add(guess.taut)
        guess, converged, error = _newton(body, guess, lengths, load)
        following = _other_cables(body, guess, lengths)
        if not converged or following is None:
            break
        guess = following
    tensions = np.zeros(len(lengths))
    tensions[list(guess.taut)] = guess.densities * lengths[list(guess.taut)]
    x, y, z = (guess.centre - guess.rotation @ body.offset).tolist()
    return Estimate(converged, float(error), guess.taut, (x, y, z), guess.rotation, tensions), guess


def _other_cables(body: Body, guess: Guess, lengths: Floats) -> Guess | None:
    """Return the guess with the cables that should carry instead; None when these are right."""
    densities = dict(zip(guess.taut, guess.densities.tolist(), strict=True))
    excess = body.distances(guess.centre, guess.rotation) - lengths
    excess[list(guess.taut)] = 0.0
    worst = int(np.argmax(excess))
    weakest = min(densities, key=lambda i: densities[i])
    if densities[weakest] < 0.0 and len(densities) > 1:
        del densities[weakest]
    elif excess[worst] > TIGHT * body.size and len(densities) < MOST_TAUT:
        densities[worst] = 0.0
    else:
        return None
    taut = tuple(sorted(densities))
    return Guess(guess.centre, guess.rotation, taut, np.array([densities[i] for i in taut]))


def _newton(body: Body, guess: Guess, lengths: Floats, load: Floats) -> tuple[Guess, bool, float]:
    """Return the pose of a set of taut cables, whether it holds up to rounding, and the error of lengths."""
    taut = list(guess.taut)
    exits, arms, wanted = body.exits[taut], body.arms[taut], lengths[taut]
    unit = float(np.linalg.norm(load))
    centre, rotation = guess.centre.copy(), guess.rotation.copy()
    t = guess.densities * np.mean(wanted) / unit
    best: tuple[float, float, Guess] | None = None
    for _ in range(STEPS):
        f, jacobian = _equations(exits, arms, wanted, load / unit, centre, rotation, t, body.size)
        merit, error = float(np.abs(f).max()), float(np.abs(f[: len(taut)]).max()) * body.size
        if best is None or merit < best[0]:
            densities = t * unit / np.mean(wanted)
            best = merit, error, Guess(centre, rotation, guess.taut, densities)
        if merit < CONVERGED * 1e-3:
            break
        step = np.linalg.lstsq(jacobian, -f, rcond=None)[0]
        if not np.isfinite(step).all():
            break
        step *= min(1.0, LONGEST_STEP / max(float(np.abs(step[:6]).max()), 1e-300))
        turn = rotation_from_vector(step[:3])
        rotation, centre, t = turn @ rotation, centre + body.size * step[3:6], t + step[6:]
    assert best is not None
    return best[2], best[0] < CONVERGED, best[1]


def _equations(
    exits: Floats, arms: Floats, lengths: Floats, load: Floats, centre: Floats, rotation: Floats,
    t: Floats, size: float,
) -> tuple[Floats, Floats]:  # fmt: skip
    """Return the n + 6 equations and their derivatives by turn, centre / size and t, all near 1.

    Lengths over ``size``, forces in loads with t_i the tension per mean length, moments over ``size``.
    """
    n, mean = len(lengths), np.mean(lengths)
    r = arms @ rotation.T
    e = exits - centre - r
    distance = np.linalg.norm(e, axis=1)
    f, jacobian = np.empty(n + 6), np.zeros((n + 6, n + 6))
    f[:n] = (distance - lengths) / size
    pulls, moments = e / mean, np.cross(r, e) / (mean * size)
    f[n : n + 3], f[n + 3 :] = t @ pulls + load, t @ moments
    directions = e / np.maximum(distance, 1e-300)[:, None]
    jacobian[:n, :3] = np.cross(directions, r) / size
    jacobian[:n, 3:6] = -directions
    for i in range(n):
        x, y = _cross_matrix(r[i]), _cross_matrix(e[i])
        jacobian[n : n + 3, :3] += t[i] * x / mean
        jacobian[n : n + 3, 3:6] -= t[i] * np.eye(3) * size / mean
        jacobian[n + 3 :, :3] += t[i] * (y @ x + x @ x) / (mean * size)
        jacobian[n + 3 :, 3:6] -= t[i] * x / mean
    jacobian[n : n + 3, 6:], jacobian[n + 3 :, 6:] = pulls.T, moments.T
    return f, jacobian


def _cross_matrix(v: Floats) -> Floats:
    """Return the matrix of the cross product with v."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
