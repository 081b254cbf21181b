"""Point masses on random routed cables, and their static poses in plain floats, apart from the package.

Lengths and directions follow the formulas of the file format, written again with numpy; nothing here is
shared with what it checks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from fractions import Fraction as F
from random import Random

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Robot
from cdpr_interval.robots.pulley import Pulley
from solvers.routed_mass.data import RoutedMass, routed_mass

Array = NDArray[np.float64]
FIXED, ONE, EXACT, BISECTOR = "fixed", "one", "exact", "bisector"
GRID = np.linspace(-0.5 * math.pi, 1.5 * math.pi, 241)[:-1] + 1e-3
WEIGHT = 9.80665


@dataclass
class Line:
    """A cable in floats."""

    kind: str
    point: Array
    axis: Array = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    radius: float = 0.0
    arm: float = 0.0
    lead: float = 0.0
    k: float = 0.0
    """Spring constant; 0 for a cable that does not stretch."""

    @property
    def wide(self) -> float:
        return self.arm + self.radius

    def flat(self, x: Array) -> tuple[Array, Array, float, float]:
        """Return u, k and both coordinates of a point in the plane of the cable."""
        k = self.axis / np.linalg.norm(self.axis)
        g = x - self.point
        y = float(g @ k)
        across = g - y * k
        s = float(np.linalg.norm(across))
        return across / max(s, 1e-300), k, s, y


def turned(angle: float, cut: float) -> float:
    """Return an angle between a cut and the next."""
    return (angle - cut) % (2 * math.pi) + cut


def held(line: Line, s: float, y: float, delta: float) -> tuple[float, float, float] | None:
    """Return length, wrap and psi of a rope over a pulley with its arm at an angle from straight down."""
    cut = -0.75 * math.pi if line.kind == ONE else -0.5 * math.pi
    hx, hy = line.arm * math.sin(delta), -line.arm * math.cos(delta)
    r = line.radius
    legs = []
    for qx, qy, side in ((-hx, -line.lead - hy, -1), (s - hx, y - hy, 1)):
        rho = math.hypot(qx, qy)
        if rho < r * (1 - 1e-12) or (side == 1 and rho <= r):
            return None
        free = math.sqrt(max(rho * rho - r * r, 0.0))
        legs.append((free, turned(math.atan2(qy, qx) + side * math.acos(min(1.0, r / rho)), cut)))
    wrap = legs[0][1] - legs[1][1]
    return legs[0][0] + r * wrap + legs[1][0], wrap, legs[1][1]


def slope(line: Line, s: float, y: float, delta: float) -> tuple[float, float] | None:
    """Return dl/ddelta over h, and the pull along the arm."""
    hx, hy = line.arm * math.sin(delta), -line.arm * math.cos(delta)
    pull = np.zeros(2)
    for qx, qy, side in ((-hx, -line.lead - hy, -1), (s - hx, y - hy, 1)):
        rho = math.hypot(qx, qy)
        if rho <= line.radius:
            return None
        angle = math.atan2(qy, qx) + side * math.acos(line.radius / rho)
        pull += side * np.array([math.sin(angle), -math.cos(angle)])
    along = np.array([math.sin(delta), -math.cos(delta)])
    turn = np.array([math.cos(delta), math.sin(delta)])
    return -float(turn @ pull), float(along @ pull)


def hung(line: Line, s: float, y: float) -> float | None:
    """Return the arm in exact balance that the rope presses on, None without one."""
    found = []
    values = [slope(line, s, y, d) for d in GRID]
    for i in range(len(GRID)):
        one, two = values[i], values[(i + 1) % len(GRID)]
        if one is None or two is None or not (one[0] <= 0.0 < two[0]) or max(one[1], two[1]) <= 0.0:
            continue
        lo, hi = GRID[i], GRID[i] + 2 * math.pi / len(GRID)
        for _ in range(60):
            middle = 0.5 * (lo + hi)
            value = slope(line, s, y, middle)
            if value is None:
                break
            lo, hi = (lo, middle) if value[0] > 0.0 else (middle, hi)
        value, way = slope(line, s, y, lo), held(line, s, y, lo)
        if value and way and value[1] > 1e-9 and way[1] > 0.0:
            found.append((way[0], lo))
    return min(found)[1] if found else None


def way(line: Line, x: Array) -> tuple[float, Array] | None:
    """Return length and direction of a cable to a point; None inside its pulley."""
    if line.kind == FIXED:
        g = x - line.point
        free = float(np.linalg.norm(g))
        return free + line.lead, g / free
    u, k, s, y = line.flat(x)
    if not s > 1e-12:
        return None
    delta: float | None = 0.5 * math.pi
    if line.kind == BISECTOR:
        delta = 0.5 * math.atan2(s, -y)
    elif line.kind == EXACT:
        delta = hung(line, s, y)
        if delta is None and (line.arm - line.radius) * math.hypot(s, y + line.lead) < line.lead * s:
            # The arm can hang on neither side of the straight line.
            return None
    if delta is not None:
        found = held(line, s, y, delta)
        if found is None:
            return None
        length, wrap, psi = found
        if line.kind == ONE and line.arm == line.radius:
            if wrap < -1e-9:
                return None
            wrap = max(wrap, 0.0)
        if wrap >= 0.0:
            return length, math.sin(psi) * u - math.cos(psi) * k
    free = math.hypot(s, y + line.lead)
    return free, (s * u + (y + line.lead) * k) / free


@dataclass
class Made:
    """A robot, its load and lengths, and a pose that it was made for."""

    lines: list[Line]
    load: Array
    lengths: Array
    pose: Array | None = None

    def robot(self) -> Robot:
        return Robot(
            "r",
            Platform(1),
            tuple(self._cable(i, line) for i, line in enumerate(self.lines)),
            gravity=(F(0), F(0), -F(WEIGHT)),
        )

    def _cable(self, i: int, line: Line) -> Cable:
        pulley = None
        if line.kind != FIXED:
            pulley = Pulley(
                F(line.radius),
                None if line.arm == line.radius else F(line.arm),
                1 if line.kind == ONE else 2,
                tuple(map(F, line.axis.tolist())),  # type: ignore[arg-type]
                F(line.lead),
                "bisector" if line.kind == BISECTOR else "exact",
            )
        point = tuple(map(F, line.point.tolist()))
        elasticity = Elasticity(stiffness=F(line.k)) if line.k else None
        return Cable(f"c{i}", point, (F(0), F(0), F(0)), elasticity=elasticity, pulley=pulley)  # type: ignore[arg-type]

    def mass(self) -> RoutedMass:
        x, y, z = self.load.tolist()
        return routed_mass(loaded(self.robot(), (F(x), F(y), F(z) + F(WEIGHT))))

    def bounds(self, spread: float = 0.0) -> Array:
        return np.stack([self.lengths - spread, self.lengths + spread], axis=1)

    def replace_lengths(self, lengths: Array) -> Made:
        return replace(self, lengths=lengths)

    def forces(self, x: Array) -> tuple[Array, Array, Array] | None:
        """Return what springs leave of the load at x, and all lengths and directions."""
        ways = [way(line, x) for line in self.lines]
        if any(one is None for one in ways):
            return None
        lengths = np.array([one[0] for one in ways if one])
        along = np.array([one[1] for one in ways if one])
        rest = -self.load.copy()
        for i, line in enumerate(self.lines):
            if line.k:
                rest += line.k * max(lengths[i] - self.lengths[i], 0.0) * along[i]
        return rest, lengths, along

    def residual(self, z: Array, taut: tuple[int, ...]) -> Array | None:
        found = self.forces(z[:3])
        if found is None:
            return None
        rest, lengths, along = found
        pulled = rest + sum((t * along[i] for t, i in zip(z[3:], taut, strict=True)), np.zeros(3))
        return np.concatenate([pulled, [lengths[i] - self.lengths[i] for i in taut]])

    def settle(self, x: Array, taut: tuple[int, ...], steps: int = 25) -> tuple[Array, Array] | None:
        """Return a static pose and the tensions of these taut cables that Newton steps find, or None."""
        found = self.forces(x)
        if found is None:
            return None
        tensions = np.zeros(0)
        if taut:
            tensions = np.linalg.lstsq(found[2][list(taut)].T, -found[0], rcond=None)[0]
        z = np.concatenate([x, tensions])
        value = self.residual(z, taut)
        for _ in range(steps):
            if value is None or not np.abs(value).max() < 1e6:
                return None
            if np.abs(value).max() < 1e-10:
                break
            columns = []
            for r in range(len(z)):
                step = np.zeros(len(z))
                step[r] = 1e-6
                plus, minus = self.residual(z + step, taut), self.residual(z - step, taut)
                if plus is None or minus is None:
                    return None
                columns.append((plus - minus) / 2e-6)
            try:
                move = np.linalg.solve(np.array(columns).T, -value)
            except np.linalg.LinAlgError:
                return None
            share = min(1.0, 0.5 / max(np.abs(move[:3]).max(), 1e-30))
            best = None
            while share > 1e-3:
                best = self.residual(z + share * move, taut)
                if best is not None and np.abs(best).max() < np.abs(value).max():
                    break
                share *= 0.5
            z, value = z + share * move, best
        if value is None or np.abs(value).max() > 1e-8 or (z[3:] < 1e-7).any():
            return None
        there = self.forces(z[:3])
        assert there is not None
        for i, line in enumerate(self.lines):
            if not line.k and i not in taut and there[1][i] > self.lengths[i] - 1e-7:
                return None
        return z[:3], z[3:]


def random_line(rng: Random, kind: str, stretch: float = 0.0) -> Line:
    """Return a cable of a kind; ``stretch`` is a spring constant, 0 for none."""
    point = np.array([rng.uniform(-3, 3), rng.uniform(-3, 3), rng.choice([4.0, 5.0, 4.0, -1.0])])
    if kind == FIXED:
        return Line(kind, point, k=stretch)
    axis = np.array([0.0, 0.0, 1.0])
    if rng.random() < 0.4:
        axis = np.array([rng.uniform(-1, 1), rng.uniform(-1, 1), rng.choice([-1.0, 1.0, 0.3])])
    radius = rng.choice([0.05, 0.2, 0.5])
    arm = radius + rng.choice([0.0, 0.0, 0.05, 0.4])
    lead = rng.choice([0.0, 0.5, 2.0]) if kind == ONE else rng.choice([0.8, 2.0])
    return Line(kind, point, axis, radius, arm, lead, stretch)


def random_place(rng: Random, line: Line, near: bool) -> Array:
    """Return a point, or one near the axis of a pulley."""
    if not near or line.kind == FIXED:
        return np.array([rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(0, 4.5)])
    k = line.axis / np.linalg.norm(line.axis)
    side = np.cross(k, [rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)])
    side /= np.linalg.norm(side)
    x = line.wide * rng.uniform(0.05, 1.1)
    return line.point + x * side + k * rng.choice([-1, 1]) * rng.uniform(0.2, 2.5) * (line.wide + 0.3)


def planted(rng: Random, kinds: list[str], near: bool = False, stretchy: float = 0.5) -> Made | None:
    """Return a robot made for a pose at which some cables carry; None where the draw has none."""
    lines = [
        random_line(rng, kind, rng.choice([30.0, 200.0, 2000.0]) if rng.random() < stretchy else 0.0)
        for kind in kinds
    ]
    x = random_place(rng, rng.choice(lines), near)
    ways = [way(line, x) for line in lines]
    if any(one is None for one in ways):
        return None
    load, lengths, held_by = np.zeros(3), np.zeros(len(lines)), 0
    for i, line in enumerate(lines):
        one = ways[i]
        assert one is not None
        carries = rng.random() < 0.75 and (bool(line.k) or held_by < 3)
        tension = rng.uniform(2.0, 30.0) if carries else 0.0
        load += tension * one[1]
        lengths[i] = one[0]
        if line.k:
            lengths[i] -= tension / line.k if carries else -rng.uniform(0.01, 1.0)
        elif carries:
            held_by += 1
        else:
            lengths[i] += rng.uniform(0.01, 1.0)
    if np.linalg.norm(load) < 1.0 or (lengths <= 0.01).any():
        return None
    return Made(lines, load, lengths, x)
