"""Random six-dof robots with a static pose that is known exactly.

Everything but the lengths is rational, so the planted pose is an equilibrium exactly; the lengths are its
distances to 60 decimals. With t_i = tension / length fixed, the balance of forces and moments

    sum t_i (a_i - r_i) = -f,    sum t_i r_i x a_i = 0

is linear in the exit points a_i (seen from the centre of mass), and so are the conditions of the special
kinds (shared exit points, exit points on one line, coplanar cables). A random start is moved to the
nearest solution; the tensions are positive by construction.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from cdpr_interval.robots.cable_robot import Cable, Platform, Robot
from cdpr_interval.robots.numbers import exact, exact_point
from tests.support.planted.rational import (
    Matrix,
    Vector,
    apply,
    combine,
    cross,
    decimal,
    decimals,
    dot,
    project,
    root,
    rotation_of,
    transpose,
)

LengthRange = tuple[Fraction, Fraction]
ZERO: Vector = (Fraction(0), Fraction(0), Fraction(0))
UNITS: tuple[Vector, ...] = (
    (Fraction(1), Fraction(0), Fraction(0)),
    (Fraction(0), Fraction(1), Fraction(0)),
    (Fraction(0), Fraction(0), Fraction(1)),
)


@dataclass(frozen=True)
class Planted:
    """A problem with one of its answers."""

    kind: str
    robot: Robot
    lengths: tuple[LengthRange, ...]
    external_force: Vector
    taut: tuple[int, ...]
    rotation: Matrix
    """Platform to base."""
    position: Vector
    """Platform origin, m."""
    tensions: tuple[Fraction, ...]
    """N, file order."""

    @property
    def load(self) -> Vector:
        """The force on the platform, N, base axes."""
        mass, gravity = exact(self.robot.platform.mass), exact_point(self.robot.gravity)
        return combine((mass, gravity), (1, self.external_force))


@dataclass(frozen=True)
class Load:
    """Mass, gravity and external force, and what they add up to."""

    mass: Fraction
    gravity: Vector
    force: Vector

    @property
    def total(self) -> Vector:
        """The load f."""
        return combine((self.mass, self.gravity), (1, self.force))


@dataclass
class Sketch:
    """The taut cables of a robot at its pose, seen from the centre of mass in base axes."""

    load: Load
    arms: list[Vector]
    densities: list[Fraction]
    """t_i = tension / length."""
    shapes: list[list[Vector]] = field(default_factory=list)
    """Per cable: the vectors whose combination with the unknowns y is its exit point."""
    start: list[Fraction] = field(default_factory=list)
    """A first guess of y."""
    flat: Vector | None = None
    """A normal to which all cables are to be perpendicular."""
    reach: float = 4.0
    """Typical length of a cable."""

    def exits(self) -> list[Vector] | None:
        """Return exit points that balance the load; None where there are none."""
        f, t = self.load.total, self.densities
        pulled = combine(*zip(t, self.arms, strict=True), (-1, f))
        pulls = [combine(*((k, s[c]) for k, s in zip(t, self.shapes, strict=True))) for c in self.columns]
        rows = [[pull[x] for pull in pulls] for x in range(3)]
        moments = [
            combine(*((k, cross(r, s[c])) for k, r, s in zip(t, self.arms, self.shapes, strict=True)))
            for c in self.columns
        ]
        rows += [[moment[x] for moment in moments] for x in range(3)]
        right = [*pulled, *ZERO]
        if self.flat is not None:
            rows += [[dot(self.flat, s[c]) for c in self.columns] for s in self.shapes]
            right += [dot(self.flat, r) for r in self.arms]
        y = project(self.start, rows, right)
        return None if y is None else [combine(*zip(y, s, strict=True)) for s in self.shapes]

    @property
    def columns(self) -> range:
        """The indices of the unknowns."""
        return range(len(self.start))


Sketcher = Callable[[random.Random], Sketch | None]


def random_load(rng: random.Random) -> Load:
    """Return a weight along -z or anywhere, with or without an external force."""
    mass = decimal(rng, 1, 100, 1)
    gravity: Vector = (Fraction(0), Fraction(0), Fraction(-981, 100))
    if rng.random() < 0.4:
        gravity = decimals(rng, -8, 8)
    force = ZERO
    if rng.random() < 0.4:
        size = float(mass) * 5
        force = decimals(rng, -size, size)
    load = Load(mass, gravity, force)
    weight_sq = dot(load.total, load.total)
    return load if weight_sq > mass * mass and any(gravity) else random_load(rng)


def random_pose(rng: random.Random, on_face: bool) -> Matrix:
    """Return a rotation of a random chart, inside it or on one of its faces, edges or axes."""
    u = [decimal(rng, -1, 1, 2) for _ in range(3)]
    if on_face:
        for k in rng.sample(range(3), rng.choice((1, 1, 2, 3))):
            u[k] = Fraction(rng.choice((-1, 1)))
        if rng.random() < 0.3:
            u[rng.randrange(3)] = Fraction(0)
    return rotation_of(rng.randrange(4), (u[0], u[1], u[2]))


def unit_scale(f: Vector) -> Fraction:
    """Return a decimal near 1 / |f|."""
    return Fraction(round(1e6 / math.sqrt(float(dot(f, f)))), 10**6)


def sketch(rng: random.Random, n: int, arms: list[Vector], load: Load, reach: float = 4.0) -> Sketch:
    """Return a sketch with random densities that fit the load, exit points still to be shaped."""
    weight = 1 / unit_scale(load.total)
    densities = [weight * decimal(rng, 0.5, 2) / (n * Fraction(reach)) for _ in range(n)]
    return Sketch(load, arms, densities, reach=reach)


def wanted_spoke(rng: random.Random, load: Load, reach: float) -> Vector:
    """Return a random vector that leads up, mostly."""
    up = combine((-unit_scale(load.total) * Fraction(reach), load.total))
    return combine((decimal(rng, 0.5, 1.2), up), (1, decimals(rng, -0.6 * reach, 0.6 * reach)))


def shape_free(rng: random.Random, s: Sketch, groups: Sequence[int] | None = None) -> Sketch:
    """Let every exit point, or every group of cables with one exit point, be anywhere."""
    owner = list(groups) if groups is not None else list(range(len(s.arms)))
    count = 3 * (max(owner) + 1)
    s.start = [Fraction(0)] * count
    for i, group in enumerate(owner):
        first = owner.index(group) == i
        if first:
            s.start[3 * group : 3 * group + 3] = combine(
                (1, s.arms[i]), (1, wanted_spoke(rng, s.load, s.reach))
            )
        shape = [ZERO] * count
        shape[3 * group : 3 * group + 3] = UNITS
        s.shapes.append(shape)
    return s


def shape_vertical(rng: random.Random, s: Sketch) -> Sketch:
    """Put all exit points on one line parallel to the load: H + z_i f."""
    n, f = len(s.arms), s.load.total
    scale = unit_scale(f)
    s.start = [*wanted_spoke(rng, s.load, s.reach), *(scale * decimal(rng, -1.5, 1.5) for _ in range(n))]
    for i in range(n):
        shape = [*UNITS, *([ZERO] * n)]
        shape[3 + i] = f
        s.shapes.append(shape)
    return s


def shape_hook(s: Sketch, height: Fraction) -> Sketch:
    """Put all exit points in the point -height f above the centre of mass."""
    s.start = [-height]
    s.shapes = [[s.load.total] for _ in s.arms]
    return s


def general(n: int, reach: float = 4.0, size: float = 1.0) -> Sketcher:
    """Platform points and exit points anywhere."""

    def build(rng: random.Random) -> Sketch:
        arms = [decimals(rng, -size, size) for _ in range(n)]
        return shape_free(rng, sketch(rng, n, arms, random_load(rng), reach))

    return build


def shared_points(n: int) -> Sketcher:
    """Several cables at one platform point, exit points apart."""

    def build(rng: random.Random) -> Sketch:
        load = random_load(rng)
        # Two points must share a plane with the weight, three need not.
        points = in_plane(rng, 2, load) if n == 3 else [decimals(rng, -1, 1) for _ in range(n - 1 - (n > 4))]
        arms = [points[i % len(points)] for i in range(n)]
        return shape_free(rng, sketch(rng, n, arms, load))

    return build


def shared_exits(n: int) -> Sketcher:
    """Two cables from one exit point (three pairs for six cables, also paired on the platform)."""

    def build(rng: random.Random) -> Sketch:
        load = random_load(rng)
        arms = [decimals(rng, -1, 1) for _ in range(n)]
        if n == 6:
            arms = [arms[i] for i in (0, 1, 0, 2, 1, 2)]
        s = sketch(rng, n, arms, load)
        if n == 3:
            # Two exit points: the line between them, the weight and the pulls share a plane.
            pair = combine((s.densities[0], arms[0]), (s.densities[1], arms[1]))
            scale = unit_scale(load.total)
            s.arms[2] = combine(
                (decimal(rng, -0.5, 0.5) / max(s.densities), pair), (scale * decimal(rng, -1, 1), load.total)
            )
        groups = (0, 0, 1, 1, 2, 2) if n == 6 else (0, 0, *range(1, n - 1))
        return shape_free(rng, s, groups)

    return build


def planar(n: int, reach: float = 4.0) -> Sketcher:
    """Everything in one plane that holds the load: two cables always are."""

    def build(rng: random.Random) -> Sketch:
        load = random_load(rng)
        return shape_free(rng, sketch(rng, n, in_plane(rng, n, load), load, reach))

    return build


def in_plane(rng: random.Random, n: int, load: Load) -> list[Vector]:
    """Return arms in a random plane that holds the load."""
    side, scale = decimals(rng, -1, 1), unit_scale(load.total)
    return [combine((decimal(rng, -1, 1), side), (scale * decimal(rng, -1, 1), load.total)) for _ in range(n)]


def coplanar_spokes(n: int) -> Sketcher:
    """All cables parallel to one plane: sigma = 0 for every triple."""

    def build(rng: random.Random) -> Sketch:
        s = general(n)(rng)
        assert s is not None
        s.flat = cross(s.load.total, decimals(rng, -1, 1))
        return s

    return build


def swing(n: int, equal: bool) -> Sketcher:
    """Cables parallel to the load; with ``equal`` all as long: every c_i in one point at the pose."""

    def build(rng: random.Random) -> Sketch:
        load = random_load(rng)
        f, scale = load.total, unit_scale(load.total)
        shares = [decimal(rng, 0.2, 1) for _ in range(n)]
        total = sum(shares, Fraction(0))
        arms = [decimals(rng, -1, 1) for _ in range(n - 1)]
        # The pulls' centre lies above or below the centre of mass.
        below = combine(
            (scale * decimal(rng, -0.5, 0.5) * total, f),
            *((-k, r) for k, r in zip(shares, arms, strict=False)),
        )
        arms.append(combine((1 / shares[-1], below)))
        spokes = [Fraction(4) * scale * (1 if equal else decimal(rng, 0.5, 1.5)) for _ in range(n)]
        if equal:
            spokes = [spokes[0]] * n
        densities = [k / total / e for k, e in zip(shares, spokes, strict=True)]
        s = Sketch(load, arms, densities)
        s.start = [Fraction(1)]
        s.shapes = [[combine((1, r), (-e, f))] for r, e in zip(arms, spokes, strict=True)]
        return s

    return build


def vertical(n: int) -> Sketcher:
    """Family (a): exit points on one line parallel to the load."""

    def build(rng: random.Random) -> Sketch:
        load = random_load(rng)
        arms = in_plane(rng, n, load) if n == 2 else [decimals(rng, -1, 1) for _ in range(n)]
        return shape_vertical(rng, sketch(rng, n, arms, load))

    return build


def hook(n: int, rod: bool = False) -> Sketcher:
    """Family (a) with one exit point: slings to a platform, with ``rod`` to a rod."""

    def build(rng: random.Random) -> Sketch:
        load = random_load(rng)
        arms = rod_arms(rng, n) if rod else [decimals(rng, -1, 1) for _ in range(n)]
        s = sketch(rng, n, arms, load, 2.0)
        total = sum(s.densities, Fraction(0))
        height = 1 / total if rod else decimal(rng, 0.5, 1.5) / total
        pulled = combine(*zip(s.densities, arms, strict=True))
        rest = combine((1 - height * total, load.total), (-1, pulled))
        s.arms[-1] = combine((1, arms[-1]), (1 / s.densities[-1], rest))
        return shape_hook(s, height)

    return build


def rod_arms(rng: random.Random, n: int) -> list[Vector]:
    """Return arms along one random direction."""
    direction = decimals(rng, -1, 1)
    return [combine((decimal(rng, -1, 1), direction)) for _ in range(n)]


def rod(n: int) -> Sketcher:
    """Family (b): platform points and the centre of mass on one line."""

    def build(rng: random.Random) -> Sketch:
        return shape_free(rng, sketch(rng, n, rod_arms(rng, n), random_load(rng)))

    return build


def rod_vertical(n: int) -> Sketcher:
    """Families (a) and (b) at once: two free angles."""

    def build(rng: random.Random) -> Sketch:
        return shape_vertical(rng, sketch(rng, n, rod_arms(rng, n), random_load(rng)))

    return build


def at_centre(n: int) -> Sketcher:
    """Family (c): all taut cables at the centre of mass."""

    def build(rng: random.Random) -> Sketch:
        return shape_free(rng, sketch(rng, n, [ZERO] * n, random_load(rng)))

    return build


def one_point(n: int) -> Sketcher:
    """Family (d): all taut cables at one point above or below the centre of mass."""

    def build(rng: random.Random) -> Sketch:
        load = random_load(rng)
        arm = combine((rng.choice((-1, 1)) * unit_scale(load.total) * decimal(rng, 0.2, 1), load.total))
        return shape_free(rng, sketch(rng, n, [arm] * n, load))

    return build


@dataclass(frozen=True)
class Kind:
    """How robots of one kind are made."""

    name: str
    sketcher: Sketcher
    slack: tuple[int, int] = (0, 2)
    """Fewest and most slack cables."""
    on_face: bool = False
    """The rotation lies on a face, an edge or an axis of its chart."""
    tolerance: float = 0.0
    """Half width of the lengths, as a share."""
    tight: bool = False
    """The first slack cable is exactly tight: the pose stays, that cable's state does not."""
    all_round: bool = False
    """The slack cables are slack at every rotation."""


KINDS: dict[str, Kind] = {
    kind.name: kind
    for kind in (
        *(Kind(f"general-{n}", general(n), (0, 8 - n)) for n in (3, 4, 5, 6)),
        *(Kind(f"chart-face-{n}", general(n), (0, 1), on_face=True) for n in (3, 4, 5, 6)),
        *(Kind(f"large-platform-{n}", general(n, 1.0, 1.0), (0, 1)) for n in (3, 4, 5, 6)),
        *(Kind(f"shared-points-{n}", shared_points(n)) for n in (3, 4, 5, 6)),
        *(Kind(f"shared-exits-{n}", shared_exits(n)) for n in (3, 4, 5, 6)),
        *(Kind(f"sigma-zero-{n}", coplanar_spokes(n)) for n in (3, 4)),
        Kind("sigma-zero-on-face-3", coplanar_spokes(3), on_face=True),
        *(Kind(f"interval-lengths-{n}", general(n), tolerance=1e-5) for n in (3, 4, 5, 6)),
        Kind("just-tight-3", general(3), (1, 2), tight=True),
        Kind("two-cables", planar(2), (0, 3)),
        Kind("two-cables-large-platform", planar(2, 1.0), (0, 2)),
        Kind("two-cables-on-face", planar(2), on_face=True),
        Kind("two-cables-interval-lengths", planar(2), tolerance=1e-5),
        Kind("two-parallel", swing(2, equal=False)),
        Kind("two-parallel-equal", swing(2, equal=True)),
        Kind("three-parallel", swing(3, equal=False)),
        Kind("three-parallel-equal", swing(3, equal=True)),
        *(Kind(f"a-vertical-line-{n}", vertical(n)) for n in (2, 3, 4, 5)),
        *(Kind(f"a-hook-{n}", hook(n)) for n in (2, 3)),
        *(Kind(f"b-rod-{n}", rod(n)) for n in (2, 3, 4, 5)),
        *(Kind(f"c-at-centre-{n}", at_centre(n), (1, 2)) for n in (1, 2, 3)),
        *(Kind(f"c-at-centre-free-{n}", at_centre(n), (1, 2), all_round=True) for n in (1, 2, 3)),
        *(Kind(f"d-one-point-{n}", one_point(n)) for n in (1, 2, 3)),
        *(Kind(f"ab-torus-{n}", rod_vertical(n)) for n in (2, 3)),
        Kind("ab-hook-and-rod-2", hook(2, rod=True)),
    )
}


def plant(name: str, seed: int) -> Planted:
    """Return the robot of a kind and seed."""
    kind = KINDS[name]
    rng = random.Random(f"{name}/{seed}")
    while True:
        made = kind.sketcher(rng)
        exits = None if made is None else made.exits()
        if made is not None and exits is not None and is_reasonable(made, exits):
            return assemble(rng, kind, made, exits)


def is_reasonable(s: Sketch, exits: Sequence[Vector]) -> bool:
    """Return True when lengths and arms have usual sizes."""
    spokes = [combine((1, a), (-1, r)) for a, r in zip(exits, s.arms, strict=True)]
    lengths, arms = ([math.sqrt(float(dot(v, v))) for v in vectors] for vectors in (spokes, s.arms))
    return s.reach / 8 < min(lengths) and max(lengths) < 3 * s.reach and max(arms) < 3


def assemble(rng: random.Random, kind: Kind, s: Sketch, exits: Sequence[Vector]) -> Planted:
    """Return the robot of a sketch: slack cables added, moved, turned, its cables shuffled."""
    n = len(exits)
    count = n + rng.randint(*kind.slack)
    taut = sorted(rng.sample(range(count), n))
    rotation = random_pose(rng, kind.on_face)
    centre, com = decimals(rng, -3, 3), decimals(rng, -0.5, 0.5)
    back = transpose(rotation)
    cables: list[Cable] = []
    lengths: list[LengthRange] = []
    tensions: list[Fraction] = []
    tight = kind.tight
    for i in range(count):
        own = taut.index(i) if i in taut else None
        arm = decimals(rng, -1, 1) if own is None else s.arms[own]
        exit_point = combine((1, arm), (1, wanted_spoke(rng, s.load, s.reach))) if own is None else exits[own]
        spoke = combine((1, exit_point), (-1, arm))
        length = root(dot(spoke, spoke))
        tensions.append(Fraction(0) if own is None else s.densities[own] * length)
        if own is None and kind.all_round:
            length += 2 * root(dot(arm, arm))
        if own is None and not tight:
            length *= 1 + decimal(rng, 0.002, 0.6)
        tight = tight and own is not None
        half = length * Fraction(kind.tolerance)
        lengths.append((length - half, length + half))
        point = combine((1, com), (1, apply(back, arm)))
        cables.append(Cable(f"c{i + 1}", combine((1, centre), (1, exit_point)), point))
    robot = Robot(f"planted-{kind.name}", Platform(s.load.mass, com), tuple(cables), gravity=s.load.gravity)
    position = combine((1, centre), (-1, apply(rotation, com)))
    return Planted(
        kind.name, robot, tuple(lengths), s.load.force, tuple(taut), rotation, position, tuple(tensions)
    )
