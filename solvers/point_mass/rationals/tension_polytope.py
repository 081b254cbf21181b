"""All tensions that hold a point mass at a point known exactly: the polyhedron's corners and its free rays.

The multipliers t >= 0 of the tight cables balance the load, sum t_i (p - A_i) = f. Every such t is a mean of
corners, which live on cables with independent directions, plus a sum of rays: r >= 0, sum r_i (p - A_i) = 0,
cables that pull against each other (prestress). A cable in a ray has no largest tension.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations

from cdpr_interval.exact.vector import Vector, dot, minus

MOST_TIGHT = 12
"""Most cables whose corners are listed: three of twelve are 220 small systems, a hundredth of a second."""

Multipliers = dict[int, Fraction]


@dataclass(frozen=True)
class Tensions:
    """The multipliers that hold the load, as corners and rays."""

    corners: tuple[Multipliers, ...]
    """Empty: nothing holds the load."""
    rays: tuple[Multipliers, ...]

    def least(self, cable: int) -> Fraction:
        """Return the smallest multiplier of a cable."""
        return min(corner.get(cable, Fraction(0)) for corner in self.corners)

    def most(self, cable: int) -> Fraction | None:
        """Return the largest multiplier of a cable; None where there is none."""
        if any(cable in ray for ray in self.rays):
            return None
        return max(corner.get(cable, Fraction(0)) for corner in self.corners)


def tensions_at(point: Vector, exits: dict[int, Vector], load: Vector) -> Tensions:
    """Return all multipliers >= 0 with which the cables of ``exits`` balance the load at a point."""
    spokes = {i: minus(point, a) for i, a in exits.items()}
    corners = [t for few in _sets(spokes, 1, 3) if (t := _positive(spokes, few, load)) is not None]
    rays = []
    for few in _sets(spokes, 2, 4):
        *others, last = few
        against = minus((Fraction(0),) * 3, spokes[last])
        if (r := _positive(spokes, tuple(others), against)) is not None:
            rays.append({**r, last: Fraction(1)})
    return Tensions(tuple(corners), tuple(rays))


def _sets(spokes: dict[int, Vector], least: int, most: int) -> Iterator[tuple[int, ...]]:
    for size in range(least, most + 1):
        yield from combinations(sorted(spokes), size)


def _positive(spokes: dict[int, Vector], few: tuple[int, ...], load: Vector) -> Multipliers | None:
    """Return positive multipliers of up to three cables with independent directions that balance a load."""
    columns = [spokes[i] for i in few]
    gram = [[dot(a, b) for b in columns] for a in columns]
    t = solved(gram, [dot(a, load) for a in columns])
    if t is None or min(t) <= 0:
        return None
    total = [sum((x * a[j] for x, a in zip(t, columns, strict=True)), Fraction(0)) for j in range(3)]
    return dict(zip(few, t, strict=True)) if total == list(load) else None


def solved(matrix: Sequence[Sequence[Fraction]], right: Sequence[Fraction]) -> list[Fraction] | None:
    """Solve a small system exactly by elimination; None where it is singular."""
    rows = [[*row, b] for row, b in zip(matrix, right, strict=True)]
    n = len(rows)
    for k in range(n):
        pivot = next((i for i in range(k, n) if rows[i][k] != 0), None)
        if pivot is None:
            return None
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(n):
            if i != k and rows[i][k] != 0:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [row[n] for row in rows]
