"""Platforms on pulleys with planted equilibria, and their cables' paths in plain floats, written anew."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solvers.six_dof.real.build import RealCable, build
from solvers.six_dof.real.model import RealModel

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class FloatCable:
    """A cable over a pulley (radius 0: straight), SI units."""

    exit: Floats
    axis: Floats
    radius: float
    arm: float
    lead_in: float
    joints: int = 1

    def path(self, x: Floats) -> tuple[float, Floats, float]:
        """Return length, direction and free length to an anchor."""
        g = x - self.exit
        if self.radius == 0.0:
            away = float(np.linalg.norm(g))
            return away, g / away, away
        k = self.axis / np.linalg.norm(self.axis)
        y = float(g @ k)
        across = g - y * k
        side = float(np.linalg.norm(across))
        u = across / side
        hub, arrives = (self.arm, 0.0), self.arrival(self.arm, 0.0)
        if self.joints == 2:
            delta = self.balance(side, y)
            hub = (self.arm * np.sin(delta), -self.arm * np.cos(delta))
            arrives = self.arrival(*hub)
        before, theta = arrives
        rho = np.hypot(side - hub[0], y - hub[1])
        free = float(np.sqrt(rho**2 - self.radius**2))
        psi = np.arctan2(y - hub[1], side - hub[0]) + np.arccos(self.radius / rho)
        if theta < psi and (self.arm > self.radius or self.joints == 2):
            # Past the pulley, straight from the start; what counts as free begins where the rope lifts off.
            start = x - self.exit + self.lead_in * k
            whole = float(np.linalg.norm(start))
            return whole, start / whole, whole - self.arriving()
        length = float(before + self.radius * (theta - psi) + free)
        return length, np.sin(psi) * u - np.cos(psi) * k, free

    def arrival(self, hub: float, lower: float) -> tuple[float, float]:
        """Return the piece that arrives at a pulley, and the angle where it does."""
        start = np.hypot(hub, self.lead_in + lower)
        before = float(np.sqrt(max(start**2 - self.radius**2, 0.0)))
        angle = np.pi + np.arctan2(self.lead_in + lower, hub) - np.arccos(min(self.radius / start, 1.0))
        return before, float(angle)

    def arriving(self) -> float:
        """Return the piece that arrives where the rope lifts off."""
        if self.joints == 1:
            return float(np.sqrt(self.lead_in**2 + self.arm**2 - self.radius**2))
        return float(np.sqrt(self.lead_in**2 - (self.arm - self.radius) ** 2))

    def balance(self, side: float, y: float) -> float:
        """Return the angle of an arm on two joints by bisection, of a contraction's fixed point."""

        def off(delta: float) -> float:
            hub = (self.arm * np.sin(delta), -self.arm * np.cos(delta))
            rho = np.hypot(side - hub[0], y - hub[1])
            psi = np.arctan2(y - hub[1], side - hub[0]) + np.arccos(self.radius / rho)
            return float(delta - 0.5 * (psi + self.arrival(*hub)[1]) + 0.5 * np.pi)

        low, high = -2.0, 4.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if off(middle) < 0.0 else (low, middle)
        return 0.5 * (low + high)


@dataclass(frozen=True)
class Planted:
    """A platform in equilibrium, seen from its centre of mass."""

    cables: tuple[FloatCable, ...]
    arms: Floats
    load: Floats
    lengths: Floats
    position: Floats
    rotation: Floats
    tensions: Floats

    def real(self, compliance: float | Sequence[float] = 0.0) -> RealModel:
        """Return its arrays, all cables taut; cables that stretch are shorter by that (m/N)."""
        given = np.broadcast_to(np.asarray(compliance, dtype=float), (len(self.cables),))
        return build(
            [
                RealCable(
                    exact(cable.exit),
                    exact(arm),
                    (Fraction(float(length)) - Fraction(float(c)) * Fraction(float(tension)),) * 2,
                    Fraction(cable.radius),
                    Fraction(cable.arm),
                    exact(cable.axis),
                    Fraction(cable.lead_in),
                    cable.joints,
                    (Fraction(float(c)),) * 2,
                )
                for cable, arm, length, tension, c in zip(
                    self.cables, self.arms, self.lengths, self.tensions, given, strict=True
                )
            ],
            exact(self.load),
            len(self.cables),
        )


def exact(v: Any) -> tuple[Fraction, Fraction, Fraction]:
    """Return the numbers that three floats are."""
    x, y, z = (Fraction(float(x)) for x in v)
    return x, y, z


def turned(v: Floats) -> Floats:
    """Return the rotation about a vector by its length."""
    angle = float(np.linalg.norm(v))
    x, y, z = v / angle
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k)


def random_cable(rng: np.random.Generator, angle: float) -> FloatCable:
    """Return a cable from a frame of radius 1.5 m; the rope arrives from outside, along it or up."""
    out = np.array([np.cos(angle), np.sin(angle), 0.0])
    axes = (out, np.array([out[1], -out[0], 0.0]), np.array([0.0, 0.0, 1.0]))
    axis = axes[rng.integers(3)] + 0.1 * rng.normal(size=3)
    radius = float(rng.choice([0.0, 0.02, 0.04, 0.06]))
    arm = radius * float(rng.choice([1.0, 1.5]))
    lead_in = 0.0 if radius == 0.0 or rng.random() < 0.5 else 0.3
    return FloatCable(1.5 * out + [0.0, 0.0, 2.0 + 0.2 * rng.normal()], axis, radius, arm, lead_in)


def any_cable(rng: np.random.Generator, angle: float) -> FloatCable:
    """Return a cable straight, over one joint or two, on its pulley or past it; as `random_cable`.

    A rope that arrives towards the platform may lift off.
    """
    plain = random_cable(rng, angle)
    kind = rng.integers(4)
    if kind == 0:
        return plain
    radius = float(rng.choice([0.01, 0.02, 0.04]))
    arm = radius * float(rng.choice([1.0, 1.5, 3.0]))
    lead_in = float(rng.choice([0.6, 1.5, 4.0])) if kind > 1 else float(rng.choice([0.0, 0.1, 0.5]))
    axis = plain.axis
    if kind in (1, 3):
        # To somewhere about the platform, so that the rope is nearly straight.
        axis = np.array([0.0, 0.0, 0.9]) + 0.15 * rng.normal(size=3) - plain.exit
        arm = max(arm, 1.5 * radius)
    if kind == 3 and rng.random() < 0.5:
        radius, arm, lead_in = 0.02, 0.15, 0.6
    return FloatCable(plain.exit, axis, radius, arm, lead_in, 1 if kind == 1 else 2)


def plant(
    seed: int, count: int, cable: Callable[[np.random.Generator, float], FloatCable] = random_cable
) -> Planted:
    """Return a platform whose cables balance its load: one tension is chosen so that the rest is a force."""
    rng = np.random.default_rng(seed)
    while True:
        angles = 2.0 * np.pi * (np.arange(count) + 0.15 * rng.normal(size=count)) / count
        cables = tuple(cable(rng, angle) for angle in angles)
        position, rotation = 0.4 * rng.uniform(-1, 1, 3) + [0.0, 0.0, 0.7], turned(0.4 * rng.normal(size=3))
        turn = 2.0 * np.pi * (np.arange(count) + 0.2 * rng.normal(size=count)) / count
        local = np.stack([0.25 * np.cos(turn), 0.25 * np.sin(turn), 0.1 + 0.15 * rng.normal(size=count)], 1)
        anchors = position + local @ rotation.T
        seen = [one.path(x) for one, x in zip(cables, anchors, strict=True)]
        pulls = -np.array([direction for _, direction, _ in seen])
        moments = np.cross(anchors, pulls)
        tensions = rng.uniform(5.0, 30.0, count)
        # (F0 + x f) . (M0 + x m) = 0: then the wrench is a force alone.
        first = tensions.copy()
        first[0] = 0.0
        force, moment = first @ pulls, first @ moments
        roots = np.roots([pulls[0] @ moments[0], force @ moments[0] + moment @ pulls[0], force @ moment])
        good = [float(x.real) for x in roots if abs(x.imag) < 1e-12 and 1.0 < x.real < 60.0]
        if not good:
            continue
        tensions[0] = good[0]
        force, moment = tensions @ pulls, tensions @ moments
        centre = np.cross(force, moment) / (force @ force)
        along = force / np.linalg.norm(force)
        centre = centre + along * ((anchors.mean(axis=0) - centre) @ along)
        if np.linalg.norm(centre - anchors.mean(axis=0)) < 0.4:
            arms = (anchors - centre) @ rotation
            lengths = np.array([length for length, _, _ in seen])
            return Planted(cables, arms, -force, lengths, centre, rotation, tensions)
