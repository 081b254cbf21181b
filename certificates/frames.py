"""The frames in which a subset of taut cables is searched."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flint import arb, arb_mat, ctx, fmpq

from certificates.arithmetic.balls import BITS, column, hull, unit
from certificates.arithmetic.vectors import cross, dot, minus
from certificates.geometry import Platform
from certificates.subsets import Exact, Kind

if TYPE_CHECKING:
    from certificates.problem import Problem

UNIT = [[fmpq(int(i == j)) for j in range(3)] for i in range(3)]


def axes_along(given: dict[int, Exact]) -> arb_mat:
    """Return the rotation to the frame with two axes (of 0, 1, 2) along rational vectors at right angles."""
    with ctx.workprec(BITS):
        axes = {k: unit(v) for k, v in given.items()}
        third = 3 - sum(axes)
        axes[third] = cross(axes[(third + 1) % 3], axes[(third + 2) % 3])
        return arb_mat([axes[k] for k in range(3)])


def across(v: Exact) -> Exact:
    """Return a rational vector at right angles to one that is not zero."""
    most = max(range(3), key=lambda k: abs(v[k]))
    return cross(v, UNIT[(most + 1) % 3])


@dataclass(frozen=True)
class Setting:
    """One search: the frames of base and platform, and what the subset's symmetry takes out."""

    taut: tuple[int, ...]
    base: arb_mat
    """Rotation to the frame."""
    platform: arb_mat
    planar: bool
    """All happens in the plane y = 0 of both frames."""
    vertical: bool
    """The pose may be turned about the base's z axis."""
    rod: bool
    """The platform may be turned about its z axis (its x axis where planar)."""

    @property
    def family(self) -> bool:
        """Poses come in families."""
        return self.vertical or self.rod

    def frozen(self, chart: int) -> tuple[int, ...] | None:
        """Return the entries of u that are 0 in a chart, or None where the chart is not needed.

        Turning about y alone: quaternions (w, 0, y, 0). A turn about z before or after turns (w, z) and (x,
        y) each in its plane: of the longer one the second entry can be made 0, and its first is then the
        largest of all four. D_c moves the entries: u = (x, y, z) / w, (w, z, y) / x up to signs.
        """
        if self.planar:
            return (0, 2) if chart in (0, 2) else None
        if self.family:
            return (2,) if chart < 2 else None
        return ()

    def cables(self, problem: Problem, order: tuple[int, ...]) -> Platform:
        """Return the platform with the taut cables in an order, then the others."""
        first = order[0]
        everyone = [*order, *(i for i in range(len(problem.names)) if i not in order)]
        exits = [minus(problem.exits[i], problem.exits[first]) for i in everyone]
        points = [minus(problem.points[i], problem.points[first]) for i in everyone]
        taut = len(order)
        squares = [hull(*problem.lengths[i]) ** 2 for i in everyone]
        # A range that is narrower than a ball is a range.
        ends = [[v**2 for v in problem.lengths[i]] for i in order]
        squares[:taut] = [arb(lo + hi) / 2 for lo, hi in ends]
        return Platform(
            exits=[self.coordinates(self.base, a, k < taut) for k, a in enumerate(exits)],
            points=[self.coordinates(self.platform, b, k < taut) for k, b in enumerate(points)],
            halves=[
                (dot(a, a) + dot(b, b) - square) / 2
                for a, b, square in zip(exits, points, squares, strict=True)
            ],
            swings=[arb(hi - lo) / 4 for lo, hi in ends],
            arm=self.coordinates(self.platform, problem.points[first]),
            load=self.coordinates(self.base, problem.load),
            per_unit=1 / arb(max(sum(map(abs, problem.points[i]), fmpq(0)) for i in order)),
            taut=taut,
            planar=self.planar,
        )

    def coordinates(self, frame: arb_mat, v: Exact, taut: bool = True) -> list[arb]:
        """Return the coordinates of a rational vector in a frame: y of taut cables is 0 in a plane."""
        x, y, z = (frame * column(v)).entries()
        return [x, arb(0) if self.planar and taut else y, z]


def settings(problem: Problem, taut: tuple[int, ...], kind: Kind) -> list[Setting]:
    """Return the searches that together find all poses of a subset, or one pose of each family."""
    exits, points = [problem.exits[i] for i in taut], [problem.points[i] for i in taut]
    vertical, rod = kind in (Kind.VERTICAL, Kind.BOTH), kind in (Kind.ROD, Kind.BOTH)
    planar = len(taut) == 2 or kind is Kind.BOTH
    base = platform = axes_along({0: UNIT[0], 2: UNIT[2]})
    if planar or vertical:
        up = [-v for v in problem.load]
        step = cross(up, cross(minus(exits[-1], exits[0]), up))
        base = axes_along({0: step if any(step) else across(up), 2: up})
    first = next((b for b in points if any(b)), UNIT[0])
    if rod:
        names = (0, 2) if planar else (2, 0)
        platform = axes_along({names[0]: first, names[1]: across(first)})
    elif planar:
        third = cross(first, cross(points[0], points[1]))
        frames = [axes_along({0: first, 2: v}) for v in (third, [-x for x in third])]
        return [Setting(taut, base, f, True, vertical, False) for f in frames[: 1 if vertical else 2]]
    return [Setting(taut, base, platform, planar, vertical, rod)]
