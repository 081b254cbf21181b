"""The mobility of a mechanism: Gruebler's count over its loops, and the exact rank of what the loops demand.

Each joint adds screws (omega, v), about and at the origin of the base, times its speeds: an axis a through p
that turns gives (a, p x a), one that slides (0, a). The twist of a body is the sum along a way from the base,
and a joint beside the tree of these ways closes a loop: the sum around it is 0, six rows for each loop. All
numbers are rational.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from flint import fmpq, fmpq_mat

from cdpr_interval.exact.vector import Vector
from cdpr_interval.robots.mechanism import Joint, Mechanism

Step = tuple[int, int]
"""A joint, and 1 where it is passed from its first body to its second, else -1."""
UNITS: tuple[Vector, ...] = tuple(
    (Fraction(int(i == 0)), Fraction(int(i == 1)), Fraction(int(i == 2))) for i in range(3)
)


@dataclass(frozen=True)
class Loop:
    """One loop of an independent set."""

    bodies: tuple[str, ...]
    """In the order in which it passes them, the first one not repeated."""
    steps: tuple[Step, ...]
    """From each of these bodies to the next, and back to the first."""


@dataclass(frozen=True)
class Count:
    """Gruebler's formula."""

    bodies: int
    """n, with the base."""
    joints: int
    """k."""
    freedoms: int
    """Of all joints."""
    loops: tuple[Loop, ...]
    """b = k - n + 1."""

    @property
    def mobility(self) -> int:
        """Sum of freedoms - 6 b = 6 (n - k - 1) + sum of freedoms."""
        return self.freedoms - 6 * len(self.loops)


@dataclass(frozen=True)
class Freedom:
    """What is free at the pose that points and axes describe, for small motions."""

    rank: int
    """Of the rows of all loops."""
    mobility: int
    """Freedoms of the joints minus the rank."""
    redundant: int
    """Rows that follow from the others: 6 b - rank."""
    platform: int | None
    """Freedoms of the platform; None where none is named."""
    idle: int | None
    """Motions that leave the platform where it is: spins of bars, and what moves elsewhere."""
    idle_joints: tuple[str, ...]
    """The joints that move in them."""


def count(mechanism: Mechanism) -> Count:
    """Return Gruebler's count, with the loops."""
    freedoms = sum(joint.freedoms for joint in mechanism.joints)
    return Count(len(mechanism.bodies), len(mechanism.joints), freedoms, tuple(loops_of(mechanism)))


def ways_of(mechanism: Mechanism) -> dict[str, tuple[Step, ...]]:
    """Return a shortest way of joints from the base to each body."""
    found: dict[str, tuple[Step, ...]] = {mechanism.base: ()}
    waiting = [mechanism.base]
    for body in waiting:
        for k, joint in enumerate(mechanism.joints):
            if body in joint.bodies:
                sign = 1 if joint.bodies[0] == body else -1
                other = joint.bodies[1] if sign == 1 else joint.bodies[0]
                if other not in found:
                    found[other] = (*found[body], (k, sign))
                    waiting.append(other)
    return found


def loops_of(mechanism: Mechanism) -> list[Loop]:
    """Return the loop that each joint beside the ways closes."""
    ways = ways_of(mechanism)
    of_ways = {k for way in ways.values() for k, _ in way}
    found = []
    for k, joint in enumerate(mechanism.joints):
        if k not in of_ways:
            first, second = (list(ways[body]) for body in joint.bodies)
            while first and second and first[0] == second[0]:
                first, second = first[1:], second[1:]
            steps = [*first, (k, 1), *((i, -sign) for i, sign in reversed(second))]
            found.append(Loop(tuple(_passed(mechanism, steps)), tuple(steps)))
    return found


def _passed(mechanism: Mechanism, steps: list[Step]) -> list[str]:
    return [mechanism.joints[k].bodies[0 if sign == 1 else 1] for k, sign in steps]


def screws(joint: Joint) -> list[list[Fraction]]:
    """Return (omega, v) of each freedom of a joint."""
    still = [Fraction(0)] * 3
    axes = UNITS if joint.kind == "S" else joint.axes
    turns = [] if joint.kind == "P" else [[*a, *_cross(joint.point, a)] for a in axes]
    slides = [[*still, *a] for a in joint.axes] if joint.kind in ("P", "C") else []
    return turns + slides


def _cross(p: Vector | None, a: Vector) -> list[Fraction]:
    assert p is not None
    return [p[1] * a[2] - p[2] * a[1], p[2] * a[0] - p[0] * a[2], p[0] * a[1] - p[1] * a[0]]


def freedom(mechanism: Mechanism) -> Freedom:
    """Return what is free at the pose of the points and axes, exactly."""
    starts: list[int] = []
    columns: list[list[Fraction]] = []
    for joint in mechanism.joints:
        starts.append(len(columns))
        columns += screws(joint)
    loops = loops_of(mechanism)
    rows = [row for loop in loops for row in _sums(mechanism, loop.steps, starts, columns)]
    _, rank = _free(rows, len(columns))
    mobility = len(columns) - rank
    if mechanism.platform is None:
        return Freedom(rank, mobility, 6 * len(loops) - rank, None, None, ())
    twist = _sums(mechanism, ways_of(mechanism)[mechanism.platform], starts, columns)
    still, held = _free([*rows, *twist], len(columns))
    moving = {c for motion in still for c, speed in enumerate(motion) if speed != 0}
    names = tuple(
        joint.name
        for joint, start in zip(mechanism.joints, starts, strict=True)
        if any(c in moving for c in range(start, start + joint.freedoms))
    )
    idle = len(columns) - held
    return Freedom(rank, mobility, 6 * len(loops) - rank, mobility - idle, idle, names)


def _sums(
    mechanism: Mechanism, steps: tuple[Step, ...], starts: list[int], columns: list[list[Fraction]]
) -> list[list[Fraction]]:
    """Return the six rows of the sum of twists along some steps."""
    rows = [[Fraction(0)] * len(columns) for _ in range(6)]
    for k, sign in steps:
        for c in range(starts[k], starts[k] + mechanism.joints[k].freedoms):
            for i in range(6):
                rows[i][c] += sign * columns[c][i]
    return rows


def _free(rows: list[list[Fraction]], count: int) -> tuple[list[list[fmpq]], int]:
    """Return a basis of what rows annihilate, and their rank."""
    if not rows:
        return [[fmpq(int(i == j)) for j in range(count)] for i in range(count)], 0
    reduced, rank = fmpq_mat([[fmpq(x.numerator, x.denominator) for x in row] for row in rows]).rref()
    pivots = [next(j for j in range(count) if reduced[i, j] != 0) for i in range(rank)]
    basis = []
    for free in (j for j in range(count) if j not in pivots):
        motion = [fmpq(0)] * count
        motion[free] = fmpq(1)
        for i, pivot in enumerate(pivots):
            motion[pivot] = -reduced[i, free]
        basis.append(motion)
    return basis, rank
