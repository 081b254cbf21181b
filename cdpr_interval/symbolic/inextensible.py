"""Static poses of a point mass on one to three inextensible cables, in closed form.

With A_1 as origin and K_i = (|a_i|^2 + l_1^2 - l_i^2) / 2 every pose is x = x_0 + s m, where x_0 and m are
rational and s^2 |m|^2 = l_1^2 - |x_0|^2:

- three cables: a_i . x_0 = K_i with x_0 in the plane of a_2 and a_3, m = a_2 x a_3 (three spheres);
- two: x_0 = K_2 a_2 / |a_2|^2, m the part of the load f across a_2 (the plane of both cables holds the
  load);
- one: x_0 = 0, m = f.
"""

from __future__ import annotations

from dataclasses import dataclass

from flint import arb, arb_mat, ctx, fmpq, fmpq_poly

from cdpr_interval.symbolic.elimination import Vanishes
from cdpr_interval.symbolic.poses import BITS
from cdpr_interval.symbolic.statics import Exact, dot

MOST_CABLES = 3


@dataclass(frozen=True)
class ClosedForm:
    """All poses of the cables, of any tension sign. Lengths in m, forces in N."""

    exits: list[Exact]
    load: Exact
    lengths: Exact
    foot: Exact
    """A_1 + x_0."""
    direction: Exact
    """m."""
    square: fmpq
    """s^2."""

    @property
    def eliminant(self) -> fmpq_poly:
        """The polynomial of degree 2 in s."""
        return fmpq_poly([-self.square, 0, 1])

    def poses(self) -> list[tuple[list[arb], list[arb]]]:
        """Enclose C (m) and the tensions (N) of the real poses: none, one (s = 0) or two."""
        with ctx.workprec(BITS):
            if self.square < 0:
                return []
            root = arb(self.square).sqrt()
            return [self.pose(s) for s in ([root] if self.square == 0 else [-root, root])]

    def pose(self, s: arb) -> tuple[list[arb], list[arb]]:
        """Enclose the pose at a root s."""
        centre = [arb(x) + s * arb(m) for x, m in zip(self.foot, self.direction, strict=True)]
        spokes = [[c - arb(x) for c, x in zip(centre, a, strict=True)] for a in self.exits]
        gram = arb_mat([[inner(e, d) for d in spokes] for e in spokes])
        pulls = arb_mat([[inner(e, [arb(f) for f in self.load])] for e in spokes])
        try:
            densities = gram.solve(pulls).entries()
        except ZeroDivisionError:
            return centre, [arb("nan")] * len(spokes)
        return centre, [t * arb(length) for t, length in zip(densities, self.lengths, strict=True)]


def closed_form(exits: list[Exact], load: Exact, lengths: Exact) -> ClosedForm:
    """Return the poses of one to three inextensible cables; raise `Vanishes` where they come in families."""
    if not 1 <= len(exits) <= MOST_CABLES:
        raise ValueError(f"1 to {MOST_CABLES} inextensible cables, not {len(exits)}")
    arms = [[x - y for x, y in zip(a, exits[0], strict=True)] for a in exits]
    levels = [(dot(a, a) + lengths[0] ** 2 - length**2) / 2 for a, length in zip(arms, lengths, strict=True)]
    foot, direction = [fmpq(0)] * 3, load
    if len(exits) > 1:
        a, square = arms[1], dot(arms[1], arms[1])
        if square == 0:
            raise Vanishes("two exit points coincide: every point of a sphere has both lengths, or none")
        foot = [levels[1] / square * x for x in a]
        direction = [square * f - dot(a, load) * x for f, x in zip(load, a, strict=True)]
    if len(exits) == 3:
        b, direction = arms[2], cross(arms[1], arms[2])
        area = dot(direction, direction)
        if area == 0:
            raise Vanishes("anchors collinear: the eliminant vanishes identically")
        weights = (
            (levels[1] * dot(b, b) - levels[2] * dot(a, b)) / area,
            (levels[2] * square - levels[1] * dot(a, b)) / area,
        )
        foot = [weights[0] * x + weights[1] * y for x, y in zip(a, b, strict=True)]
    size = dot(direction, direction)
    if size == 0:
        raise Vanishes("the anchors lie on a line along the load: the eliminant vanishes identically")
    height = (lengths[0] ** 2 - dot(foot, foot)) / size
    placed = [x + y for x, y in zip(exits[0], foot, strict=True)]
    return ClosedForm(exits, load, lengths, placed, direction, height)


def cross(a: Exact, b: Exact) -> Exact:
    """Return the vector product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def inner(a: list[arb], b: list[arb]) -> arb:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
