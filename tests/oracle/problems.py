"""Random questions of every kind that people ask, and of the kinds that solvers find hard."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from .model import Case, Range, Vector
from .newton import solve
from .starts import rotation_of
from .statics import Pose
from .subsets import StaticPose, find_poses, question_of

Rng = np.random.Generator


def decimal(x: float, digits: int) -> Fraction:
    """Return a float rounded to so many decimals, exactly."""
    return Fraction(f"{x:.{digits}f}")


def vector(v: Any, digits: int = 3) -> Vector:
    x, y, z = (decimal(float(c), digits) for c in v)
    return x, y, z


def exactly(lengths: Any, digits: int = 4) -> tuple[Range, ...]:
    return tuple((x, x) for x in (decimal(float(v), digits) for v in lengths))


def pose_of(rng: Rng, tilt: float = 1.0) -> tuple[Any, Any]:
    """Return a random place and rotation; a small ``tilt`` is nearly level."""
    q = rng.normal(size=4) * np.array([1.0, tilt, tilt, tilt])
    return rng.uniform([-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]), rotation_of(q)


def distances(exits: Any, points: Any, p: Any, rotation: Any) -> Any:
    return np.linalg.norm(np.asarray(exits) - p - np.asarray(points) @ rotation.T, axis=1)


def ring(rng: Rng, n: int, radius: float, height: float) -> Any:
    """Return exit points spread around, above the origin."""
    angles = np.sort(rng.uniform(0, 2 * np.pi, n))
    r = radius * rng.uniform(0.6, 1.3, n)
    return np.stack([r * np.cos(angles), r * np.sin(angles), height + rng.uniform(-0.5, 0.5, n)], axis=1)


def case_at(
    rng: Rng,
    name: str,
    exits: Any,
    points: Any,
    *,
    slack: int = 0,
    tilt: float = 1.0,
    digits: int = 4,
    place: int = 3,
) -> Case:
    """Return a case whose lengths are the distances at a random pose, the last ``slack`` cables longer."""
    exact_exits, exact_points = (tuple(vector(v, place) for v in rows) for rows in (exits, points))
    p, rotation = pose_of(rng, tilt)
    lengths = distances(exits, points, p, rotation)
    lengths[len(lengths) - slack :] *= 1 + rng.uniform(0, 0.3, slack)
    return Case(name, exact_exits, exact_points, exactly(np.maximum(lengths, 0.05), digits))


def general(rng: Rng) -> Case:
    n = int(rng.choice([1, 2, 3, 4, 5], p=[0.05, 0.3, 0.35, 0.25, 0.05]))
    return case_at(
        rng,
        f"general-{n}",
        ring(rng, n, 3.0, 3.0),
        rng.uniform(-1, 1, (n, 3)),
        tilt=0.5,
        slack=int(rng.integers(0, n)),
    )


def large(rng: Rng) -> Case:
    """A platform as large as its base."""
    n = int(rng.integers(2, 4))
    return case_at(rng, f"large-{n}", ring(rng, n, 1.0, 2.0), rng.uniform(-1.5, 1.5, (n, 3)), tilt=0.3)


def symmetric(rng: Rng) -> Case:
    """A square or triangular platform on equal cables."""
    n = int(rng.choice([2, 3, 3, 4]))
    angles = 2 * np.pi * np.arange(n) / n + (np.pi / 4 if n == 4 else 0.0)
    circle = np.stack([np.cos(angles), np.sin(angles), np.zeros(n)], axis=1)
    exits = circle * rng.uniform(0.5, 3.0) + [0, 0, 3]
    points = circle * rng.uniform(0.1, 1.0) + [0, 0, rng.choice([-0.2, 0.0, 0.3])]
    exits, points = np.round(exits, 3), np.round(points, 3)
    length = float(np.linalg.norm(exits[0] - points[0]) * rng.uniform(0.5, 1.2)) + 0.2
    return Case(
        f"symmetric-{n}",
        tuple(vector(a) for a in exits),
        tuple(vector(b) for b in points),
        exactly([length] * n, 2),
    )


def ik_rounded(rng: Rng) -> Case:
    """A box on four cables, its lengths as a level pose gives them, in few or in all digits."""
    w, h = rng.uniform(1, 3, 2)
    a, b = rng.uniform(0.1, 0.6, 2)
    corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
    exits = np.round(np.column_stack([corners * [w, h], np.full(4, 3.0)]), 2)
    points = np.round(np.column_stack([corners * [a, b], np.full(4, 0.2)]), 2)
    p = np.array([*rng.uniform(-0.4, 0.4, 2), 0.5])
    digits = int(rng.choice([2, 4, 8]))
    return Case(
        "ik-rounded",
        tuple(vector(x) for x in exits),
        tuple(vector(x) for x in points),
        exactly(distances(exits, points, p, np.eye(3)), digits),
    )


def planar(rng: Rng) -> Case:
    """Everything in one vertical plane."""
    n = int(rng.integers(2, 5))
    exits, points = ring(rng, n, 2.0, 2.0), rng.uniform(-0.6, 0.6, (n, 3))
    exits[:, 1] = points[:, 1] = 0.0
    case = case_at(rng, f"planar-{n}", exits, points, tilt=0.0)
    return case


def parallel(rng: Rng) -> Case:
    """Equal cables that hang parallel at one pose."""
    n = int(rng.integers(2, 5))
    points = np.round(rng.uniform(-0.8, 0.8, (n, 3)), 3)
    exits = points + np.array([0.0, 0.0, 3.0])
    return Case(
        f"parallel-{n}",
        tuple(vector(a) for a in exits),
        tuple(vector(b) for b in points),
        exactly([float(rng.uniform(0.5, 2.5))] * n, 3),
    )


def at_centre(rng: Rng) -> Case:
    """One cable or more at the centre of mass."""
    n = int(rng.integers(1, 5))
    points = rng.uniform(-0.7, 0.7, (n, 3))
    points[: int(rng.integers(1, n + 1))] = 0.0
    return case_at(
        rng, f"at-centre-{n}", ring(rng, n, 2.0, 2.0), points, tilt=0.5, slack=int(rng.integers(0, n))
    )


def one_point(rng: Rng) -> Case:
    """All cables, or all but one, at one point that is not the centre of mass."""
    n = int(rng.integers(2, 5))
    points = np.tile(rng.uniform(-0.7, 0.7, 3), (n, 1))
    if rng.random() < 0.5:
        points[-1] = rng.uniform(-0.7, 0.7, 3)
    return case_at(
        rng, f"one-point-{n}", ring(rng, n, 2.0, 2.0), points, tilt=0.5, slack=int(rng.integers(0, 2))
    )


def hook(rng: Rng) -> Case:
    """Slings on one hook, or exits over each other: the platform turns about the vertical."""
    n = int(rng.integers(2, 4))
    exits = np.tile([0.2, -0.3, 3.0], (n, 1))
    if rng.random() < 0.4:
        exits[:, 2] += rng.uniform(-0.5, 0.5, n)
    points = rng.uniform(-0.7, 0.7, (n, 3))
    if rng.random() < 0.5:
        exits = np.vstack([exits, [1.5, 0.5, 2.5]])
        points = np.vstack([points, rng.uniform(-0.5, 0.5, 3)])
    return case_at(rng, f"hook-{len(exits)}", exits, points, tilt=0.3, slack=len(exits) - n)


def rod(rng: Rng) -> Case:
    """Platform points on a line through the centre of mass: the platform turns about it."""
    n = int(rng.integers(2, 4))
    line = np.round(rng.uniform(-0.5, 0.5, 3), 1)
    points = np.outer(np.array([-2.0, 1.0, 3.0])[:n], line)
    exits = ring(rng, n, 1.5, 2.0)
    if rng.random() < 0.3:
        exits[:, :2] = exits[0, :2]
    if rng.random() < 0.5:
        exits = np.vstack([exits, [1.5, 0.5, 2.5]])
        points = np.vstack([points, rng.uniform(-0.5, 0.5, 3)])
    return case_at(rng, f"rod-{len(exits)}", exits, points, tilt=0.3, slack=len(exits) - n)


def dependent(rng: Rng) -> Case:
    """Two cables that coincide, or a bundle of four at one point."""
    case = general(rng)
    if case.count < 2:
        return case
    exits, points, lengths = list(case.exits), list(case.points), list(case.lengths)
    exits[-1], points[-1] = exits[0], points[0]
    if rng.random() < 0.5:
        lengths[-1] = lengths[0]
    return replace(
        case, name=f"dependent-{case.count}", exits=tuple(exits), points=tuple(points), lengths=tuple(lengths)
    )


def near_fold(rng: Rng) -> Case:
    """Two poses about to meet: one length is moved until Newton loses the pose, and back a little."""
    n = int(rng.integers(2, 4))
    case = case_at(rng, f"near-fold-{n}", ring(rng, n, 3.0, 3.0), rng.uniform(-1, 1, (n, 3)), tilt=0.5)
    case = replace(case, taut=tuple(range(n)))
    poses = [p for p in find_poses(case, rng, 40) if p.free == 0]
    if not poses:
        return case
    cable, way = int(rng.integers(n)), int(rng.choice([-1, 1]))
    return _to_the_fold(rng, case, poses[int(rng.integers(len(poses)))], cable, way)


def _to_the_fold(rng: Rng, case: Case, pose: StaticPose, cable: int, way: int) -> Case:
    question = question_of(case)
    scale = float(question.coarse.unit_m)
    at = Pose(
        pose.centre.astype(float)[None] / scale,
        pose.rotation.astype(float)[None],
        pose.tensions.astype(float)[None] / float(question.coarse.unit_N),
    )
    length, step = case.lengths[cable][0], Fraction(1, 10)
    while step > Fraction(1, 10**8):
        trial = length + way * step
        moved = case.at([trial if i == cable else lo for i, (lo, _) in enumerate(case.lengths)])
        system = question_of(moved).coarse
        here = Pose(at.p * scale / float(system.unit_m), at.rotation, at.tensions)
        found = solve(system, here, np.arange(case.count))
        if (
            len(found.p)
            and np.abs(found.rotation - here.rotation).max() < 0.3
            and trial > case.lengths[cable][0] / 4
            and (trial - case.lengths[cable][0] < 3)
        ):
            length, at, scale = trial, found, float(system.unit_m)
        else:
            step /= 4
    back = Fraction(1, 10 ** int(rng.integers(2, 8)))
    length = decimal(float(length - way * back), 10)
    return case.at([length if i == cable else lo for i, (lo, _) in enumerate(case.lengths)])


def six(rng: Rng) -> Case:
    """Five or six taut cables asked for alone."""
    n = int(rng.integers(5, 7))
    case = case_at(rng, f"asked-{n}", ring(rng, n, 3.0, 3.0), rng.uniform(-1, 1, (n, 3)), tilt=0.3)
    return replace(case, taut=tuple(range(n)))


def asked(rng: Rng) -> Case:
    """One subset, with or without a look at the other cables."""
    n = int(rng.integers(3, 9))
    case = case_at(
        rng, f"subset-{n}", ring(rng, n, 3.0, 3.0), rng.uniform(-1, 1, (n, 3)), tilt=0.4, slack=n - 2
    )
    chosen = sorted(rng.choice(n, size=int(rng.integers(1, 4)), replace=False).tolist())
    return replace(case, taut=tuple(chosen), ignore_slack=bool(rng.random() < 0.5))


def point_mass(rng: Rng) -> Case:
    n = int(rng.integers(1, 9))
    case = case_at(
        rng, f"point-mass-{n}", ring(rng, n, 2.0, 2.0), np.zeros((n, 3)), slack=int(rng.integers(0, n))
    )
    return case


def elastic(rng: Rng) -> Case:
    n = int(rng.integers(1, 6))
    case = case_at(
        rng, f"elastic-{n}", ring(rng, n, 2.0, 2.0), np.zeros((n, 3)), slack=int(rng.integers(0, n))
    )
    stiffness = tuple(decimal(10 ** rng.uniform(1.5, 5), 1) for _ in range(n))
    return replace(case, stiffness=stiffness)


def ranges(rng: Rng) -> Case:
    """Lengths that are known to a micrometre, or to a centimetre."""
    case = [general, point_mass, elastic, planar, large][int(rng.integers(5))](rng)
    width = Fraction(1, 10 ** int(rng.integers(2, 7)))
    which = rng.random(case.count) < 0.7
    lengths = tuple(
        (max(lo - width, lo / 2), hi + width) if wide else (lo, hi)
        for (lo, hi), wide in zip(case.lengths, which, strict=True)
    )
    return replace(case, name=f"range-{case.name}", lengths=lengths)


KINDS: dict[str, Callable[[Rng], Case]] = {
    kind.__name__: kind
    for kind in (
        general, large, symmetric, ik_rounded, planar, parallel, at_centre, one_point, hook, rod, dependent,
        near_fold, six, asked, point_mass, elastic, ranges,
    )
}  # fmt: skip


def problem(kind: str, seed: int) -> Case:
    """Return the random question of that kind and seed."""
    rng = np.random.default_rng([sum(kind.encode()), seed])
    case = KINDS[kind](rng)
    for change in (tilted, pushed, shifted, in_millimetres):
        if rng.random() < 0.2:
            case = change(rng, case)
    return case


def tilted(rng: Rng, case: Case) -> Case:
    """Gravity in any direction: everything is turned by a quarter or half turn, exactly, or gravity leans."""
    if case.name.startswith(("planar", "hook", "rod", "range-planar")) or rng.random() < 0.5:
        order = [1, 2, 0]

        def cycled(v: Vector) -> Vector:
            x, y, z = (v[k] for k in order)
            return x, y, z

        return replace(
            case,
            exits=tuple(cycled(a) for a in case.exits),
            gravity=cycled(case.gravity),
            force=cycled(case.force),
        )
    return replace(case, gravity=vector(rng.normal(size=3) * 3 + [0, 0, -7], 2))


def pushed(rng: Rng, case: Case) -> Case:
    """An external force, across or up."""
    weight = float(case.mass * max(abs(g) for g in case.gravity))
    return replace(case, force=vector(rng.normal(size=3) * weight * 0.3, 2))


def shifted(rng: Rng, case: Case) -> Case:
    """The platform's frame somewhere else: another origin, the same body."""
    offset = vector(rng.uniform(-1, 1, 3), 2)

    def moved(v: Vector) -> Vector:
        x, y, z = (a + b for a, b in zip(v, offset, strict=True))
        return x, y, z

    return replace(case, points=tuple(moved(b) for b in case.points), centre=moved(case.centre))


def in_millimetres(rng: Rng, case: Case) -> Case:
    """The same robot in other units: lengths a thousand times larger or smaller, a mass of any size."""
    factor = Fraction(1000) if rng.random() < 0.7 else Fraction(1, 1000)
    mass = Fraction(10) ** int(rng.integers(-3, 4))

    def scaled(v: Vector) -> Vector:
        x, y, z = (c * factor for c in v)
        return x, y, z

    stiffness = None if case.stiffness is None else tuple(k * mass / factor for k in case.stiffness)
    force = tuple(f * mass for f in case.force)
    return replace(
        case,
        exits=tuple(scaled(a) for a in case.exits),
        points=tuple(scaled(b) for b in case.points),
        centre=scaled(case.centre),
        lengths=tuple((lo * factor, hi * factor) for lo, hi in case.lengths),
        mass=case.mass * mass,
        force=(force[0], force[1], force[2]),
        stiffness=stiffness,
    )
