"""The equations of a taut subset, for floats and for 50 digits alike.

Everything here is written with elementwise operations, ``@`` and sums, so that the same lines run on
float64 batches (leading axes) and on numpy object arrays of mpmath numbers. Units are those of
`System`: lengths over ``unit_m``, forces over ``unit_N``.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import log10
from typing import Any

import mpmath
import numpy as np

from .model import Case

DIGITS = 50
Array = Any
"""A numpy array of float64, or of mpmath numbers."""


@dataclass(frozen=True)
class System:
    """An exact question in its own units, centre of mass at the platform's origin."""

    exits: Array
    arms: Array
    """Platform anchors from the centre of mass, (N, 3)."""
    lengths: Array
    load: Array
    compliance: Array
    """1/stiffness, zero for an inextensible cable."""
    centre: Array
    turns: bool
    """False for a point mass."""
    unit_m: Fraction
    unit_N: Fraction

    @property
    def count(self) -> int:
        """Number of cables."""
        return len(self.lengths)


@dataclass(frozen=True)
class Pose:
    """Centre of mass (..., 3), rotation (..., 3, 3) and tensions of the taut cables (..., n)."""

    p: Array
    rotation: Array
    tensions: Array


def system_of(case: Case, *, precise: bool = False) -> System:
    """Return the system of an exact question in floats or, precise, in mpmath numbers."""
    if not case.exact:
        raise ValueError("the lengths are ranges: choose some first")
    unit_m = Fraction(10) ** round(log10(max(lo for lo, _ in case.lengths)))
    unit_N = max(abs(x) for x in case.load)
    stiffness = case.stiffness
    arms = [[b - c for b, c in zip(row, case.centre, strict=True)] for row in case.points]

    def numbers(values: Any, unit: Fraction) -> Array:
        fractions = np.array(values, dtype=object) / unit
        if not precise:
            return fractions.astype(np.float64)
        return np.array([number(x) for x in fractions.ravel()], dtype=object).reshape(fractions.shape)

    soft = [Fraction(0)] * case.count if stiffness is None else [1 / k for k in stiffness]
    return System(
        exits=numbers([list(a) for a in case.exits], unit_m),
        arms=numbers(arms, unit_m),
        lengths=numbers([lo for lo, _ in case.lengths], unit_m),
        load=numbers(list(case.load), unit_N),
        compliance=numbers(soft, unit_m / unit_N),
        centre=numbers(list(case.centre), unit_m),
        turns=not case.point_mass,
        unit_m=unit_m,
        unit_N=unit_N,
    )


def number(x: Any) -> Any:
    """Return a fraction or float as an mpmath number of 50 digits and more."""
    with mpmath.workdps(DIGITS + 10):
        if isinstance(x, Fraction):
            return mpmath.mpf(x.numerator) / x.denominator
        return mpmath.mpf(x)


def cross(a: Array, b: Array) -> Array:
    """Return a x b along the last axis."""
    x = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    y = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    z = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return np.stack([x, y, z], axis=-1)


def skew(a: Array) -> Array:
    """Return the matrices [a]x with [a]x b = a x b."""
    zero = a[..., 0] * 0
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def identity(like: Array) -> Array:
    """Return the unit matrix in the kind of numbers of an array."""
    return (
        np.eye(3)
        if like.dtype != object
        else np.array([[number(int(i == j)) for j in range(3)] for i in range(3)], dtype=object)
    )


def cayley(omega: Array) -> Array:
    """Return the rotation (I - [w/2])^-1 (I + [w/2]): exactly orthogonal, and exp([w]) up to third order."""
    a = omega / 2
    s = skew(a)
    square = (a * a).sum(axis=-1)[..., None, None]
    return identity(omega) + (s + s @ s) * (2 / (1 + square))


def moved(pose: Pose, step: Array, turns: bool) -> Pose:
    """Return the pose after a step (v, omega, change of tensions)."""
    k = 6 if turns else 3
    rotation = cayley(step[..., 3:6]) @ pose.rotation if turns else pose.rotation
    return Pose(pose.p + step[..., :3], rotation, pose.tensions + step[..., k:])


def spokes(system: System, pose: Pose, cables: Any) -> tuple[Array, Array]:
    """Return the arms r_i and the spokes e_i = A_i - p - r_i of some cables, (..., n, 3)."""
    r = (pose.rotation[..., None, :, :] * system.arms[cables][:, None, :]).sum(axis=-1)
    return r, system.exits[cables] - pose.p[..., None, :] - r


def stretched(system: System, pose: Pose, taut: Any) -> Array:
    """Return the lengths of the taut cables under their tensions."""
    return system.lengths[taut] + system.compliance[taut] * pose.tensions


def residual(system: System, pose: Pose, taut: Any) -> Array:
    """Return (lengths, force, moment) of a taut subset, zero at a solution.

    A length's residual is about |e| - l: divided by l, so that short cables count as well.
    """
    r, e = spokes(system, pose, taut)
    rho = stretched(system, pose, taut)
    q = (pose.tensions / rho)[..., None]
    parts = [
        ((e * e).sum(axis=-1) - rho * rho) / (2 * system.lengths[taut]),
        (q * e).sum(axis=-2) + system.load,
    ]
    if system.turns:
        parts.append((q * cross(r, e)).sum(axis=-2))
    return np.concatenate(parts, axis=-1)


def jacobian(system: System, pose: Pose, taut: Any) -> Array:
    """Return the derivatives of `residual` by (v, omega, tensions)."""
    r, e = spokes(system, pose, taut)
    rho = stretched(system, pose, taut)
    q = (pose.tensions / rho)[..., None, None]
    by_tension = (system.lengths[taut] / (rho * rho))[..., None]
    moments = cross(r, e)
    n = len(taut)
    diagonal = np.zeros((*rho.shape, n), dtype=rho.dtype)
    if rho.dtype == object:
        diagonal = diagonal + number(0)
    for i in range(n):
        diagonal[..., i, i] = -rho[..., i] * (system.compliance / system.lengths)[taut][i]
    short = system.lengths[taut][:, None]
    arms = skew(r)
    force_v = -(q * identity(e)).sum(axis=-3)
    force_t = np.swapaxes(by_tension * e, -1, -2)
    if not system.turns:
        rows = [[-e / short, diagonal], [force_v, force_t]]
    else:
        coupling = (q * arms).sum(axis=-3)
        turning = (q * ((skew(e) + arms) @ arms)).sum(axis=-3)
        rows = [
            [-e / short, -moments / short, diagonal],
            [force_v, coupling, force_t],
            [-coupling, turning, np.swapaxes(by_tension * moments, -1, -2)],
        ]
    return np.concatenate([np.concatenate(row, axis=-1) for row in rows], axis=-2)


def wrenches(system: System, pose: Pose, taut: Any) -> Array:
    """Return the unit wrenches of the taut cables as columns, (6 or 3, n)."""
    r, e = spokes(system, pose, taut)
    columns = np.concatenate([e, cross(r, e)], axis=-1) if system.turns else e
    return (columns / stretched(system, pose, taut)[..., None]).T
