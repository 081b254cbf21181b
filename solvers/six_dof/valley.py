"""The only static pose of a small neighbourhood, whichever cables carry load there: the floor of a valley.

Poses at which more cables are just tight than their wrenches have rank have no isolated tensions, so no
square system proves them. All static poses together are the critical points of the load's height under the
constraints |e_i| <= l_i of all cables, and two of them can be compared without knowing which cables carry.
Take poses 1 and 2 with tensions t^1, t^2 (over lengths). With delta = (p_2 - p_1, omega), omega the Cayley
vector of R_2 R_1^T, bars for means of the two poses and Delta_i = p_2 - p_1 + omega x r_i(bar), exactly

    |e_i(2)|^2 - |e_i(1)|^2 = -2 a_i,   a_i = e_i(bar) . Delta_i
    w_i(1) . delta = a_i + q_i(1) / 2,  w_i(2) . delta = a_i - q_i(2) / 2
    q_i(k) = |Delta_i|^2 - e_i(k) . (omega x (omega x r_i(bar)))

and the balances of both poses, times delta, give

    sum (t^1_i - t^2_i) a_i + 1/2 sum (t^1_i q_i(1) + t^2_i q_i(2)) = 0.

A cable that carries in one pose is not longer in the other, so the first sum is not negative. Where the
form sum t_i q_i is positive definite for all tensions of the neighbourhood, the poses are the same. Cables
that carry whatever the tensions have a_i = 0, and the form need be positive only there.

A static pose exists as well where the height, over the poses that all cables allow, is smaller somewhere
inside than on the border: its lowest point is static, because one motion shortens all cables there
(Mangasarian and Fromovitz), and L(q) = height + sum t_i (|e_i|^2 - l_i^2) / 2 with fixed t >= 0 bounds the
height from below.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.mechanics.energy import constraint_rows, positive_definite, quadratic_form
from cdpr_interval.mechanics.six_dof.frame import Pose, cayley
from cdpr_interval.mechanics.six_dof.tension_polytope import (
    TensionRays,
    nearest_direction,
    product,
    tension_rays,
    wrench_matrix,
)
from solvers.questions.problem import Problem
from solvers.six_dof.solution import Geometry, geometry

Floats = NDArray[np.float64]

STIFF = (0.0, 10.0, 1e3)
"""Weights, over the form's size, of motions that are ruled out; a large one makes their width count."""
LIFTS = (45, 40, 36, 32, 28, 24)
"""Powers of 1/2, over the platform's size, by which the centre is lifted to where all cables are slack."""


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """Poses with |p - centre|_k <= reach * size and R = cay(omega) R_c, |omega_k| <= 2 reach.

    In a family every pose stands for all that turning about the vertical makes of it, which changes no
    cable's distance, and omega has no vertical part.
    """

    problem: Problem
    centre: Pose
    """Without tensions."""
    reach: float
    size: float
    axis: arb_mat | None = None
    """The vertical in a family: a unit vector, base frame."""
    pivot: arb_mat | None = None
    """The axis passes through this platform point (from the centre of mass); None: through the exits."""

    @property
    def small_enough(self) -> bool:
        """Turning one of two poses until omega . axis = 0 between them leaves it within twice the reach."""
        if self.axis is None:
            return True
        way = balls.norm(self.centre.centre - self.point_of(self.centre.rotation, self.centre.centre))
        return bool(8 * arb(self.reach) * (way + arb(self.size)) < arb(self.size))

    def turns(self) -> arb_mat:
        """Return a rotation that holds all those of its poses against the centre's.

        In a family, two of its poses that are turned until they differ least lie within twice the reach.
        """
        wide = arb(0, self.reach if self.axis is None else 2 * self.reach)
        return cayley([wide, wide, wide])

    def everywhere(self) -> Geometry:
        """Return what all its poses have in common."""
        wide = arb(0, self.reach if self.axis is None else 2 * self.reach) * arb(self.size)
        place = balls.vector([wide] * 3)
        return geometry(
            self.problem, Pose(self.turns() * self.centre.rotation, self.centre.centre + place, ())
        )

    def nearest(self, rotation: arb_mat, centre: arb_mat) -> tuple[arb_mat, arb_mat]:
        """Return a pose that ``holds``, turned in its family to where it is nearest to the centre."""
        turned = self.aligned(rotation * self.centre.rotation.transpose(), centre)
        assert turned is not None
        return turned[0] * self.centre.rotation, turned[1]

    def holds(self, rotation: arb_mat, centre: arb_mat) -> bool:
        """Return True when a pose (after turning in its family) is proved to lie inside."""
        turned = self.aligned(rotation * self.centre.rotation.transpose(), centre)
        if turned is None:
            return False
        relative, place = turned
        trace = 1 + relative[0, 0] + relative[1, 1] + relative[2, 2]
        if not trace > 0:
            return False
        r, most = relative, arb(self.reach)
        u = [(r[2, 1] - r[1, 2]) / trace, (r[0, 2] - r[2, 0]) / trace, (r[1, 0] - r[0, 1]) / trace]
        moved = balls.entries(place - self.centre.centre)
        return all(abs(x) <= most for x in u) and all(abs(x) <= most * arb(self.size) for x in moved)

    def is_apart(self, rotation: arb_mat, centre: arb_mat) -> bool:
        """Return True when no pose in these bounds lies inside."""
        relative = rotation * self.centre.rotation.transpose()
        # R(u) turns n, across u, into a vector with the product (1 - |u|^2) / (1 + |u|^2) with n, whatever
        # the turn about n; its trace is 3 - 4 |u|^2 / (1 + |u|^2).
        far = 3 * arb(self.reach) * arb(self.reach)
        if self.axis is None:
            trace = relative[0, 0] + relative[1, 1] + relative[2, 2]
            if trace < 3 - 4 * far / (1 + far):
                return True
        elif balls.dot(self.axis, relative * self.axis) < (1 - far) / (1 + far):
            return True
        turned = self.aligned(relative, centre)
        if turned is None:
            return False
        most = arb(self.reach) * arb(self.size)
        return any(abs(x) > most for x in balls.entries(turned[1] - self.centre.centre))

    def aligned(self, relative: arb_mat, centre: arb_mat) -> tuple[arb_mat, arb_mat] | None:
        """Turn a pose in its family until omega has no part along the axis; None where that may fail."""
        if self.axis is None:
            return relative, centre
        r, n = relative, balls.entries(self.axis)
        trace = 1 + r[0, 0] + r[1, 1] + r[2, 2]
        along = n[0] * (r[2, 1] - r[1, 2]) + n[1] * (r[0, 2] - r[2, 0]) + n[2] * (r[1, 0] - r[0, 1])
        if not (trace > 0 or along > 0 or along < 0):
            return None
        half = arb.atan2(along, trace)
        back = balls.turn(self.axis, -2 * half)
        point = self.point_of(relative * self.centre.rotation, centre)
        return back * relative, point + back * (centre - point)

    def point_of(self, rotation: arb_mat, centre: arb_mat) -> arb_mat:
        """Return a point of a pose's axis."""
        if self.pivot is None:
            return balls.ranges(self.problem.loaded.exit_ranges[0])
        return centre + rotation * self.pivot


@dataclass(frozen=True)
class Floor:
    """What is proved of the static poses of a neighbourhood."""

    unique: bool
    """There are not two of them."""
    exists: bool
    """There is one."""


def floor_of(where: Neighbourhood, tight: Sequence[int]) -> Floor:
    """Prove what can be proved of the static poses of a neighbourhood.

    Parameters
    ----------
    where
        The neighbourhood.
    tight : sequence of int
        The cables that are not proved slack all over it.

    Guarantee
    ---------
    With ``unique`` it holds at most one static pose (of a family: one orbit) for each choice of lengths in
    their ranges, over all subsets of taut cables; with ``exists`` at least one.
    """
    view = where.everywhere()
    spokes, arms = [view.spokes[i] for i in tight], [view.arms[i] for i in tight]
    load = balls.ranges(where.problem.loaded.load_ranges)
    rays = tension_rays(wrench_matrix(spokes, arms, load, where.size))
    if not where.small_enough or rays is None or not rays.parts:
        return Floor(False, False)
    if not all(is_valley(where, spokes, arms, rays, corner) for part in rays.parts for corner in part):
        return Floor(False, False)
    return Floor(True, has_lowest_point(where, tight, spokes, arms))


def is_valley(
    where: Neighbourhood,
    spokes: Sequence[arb_mat],
    arms: Sequence[arb_mat],
    rays: TensionRays,
    corner: tuple[arb, ...],
) -> bool:
    """Return True when sum t_i q_i is positive definite on all motions between two static poses."""
    form = scaled(quadratic_form(list(spokes), list(arms), list(corner[:-1])), where.size)
    rows = constraint_rows(list(spokes), list(arms))
    held = [row for i, row in enumerate(rows) if rays.always(i)] + gauge(where)
    return any(positive_definite(form + stiffened(held, form, where.size, w)) for w in STIFF)


def gauge(where: Neighbourhood) -> list[list[arb]]:
    """Return the motion's part along a family's axis as a row, which is 0; nothing without a family."""
    return [] if where.axis is None else [[arb(0)] * 3 + balls.entries(where.axis)]


def scaled(form: arb_mat, size: float) -> arb_mat:
    """Return the form in (v, size omega)."""
    per_size = [arb(1)] * 3 + [arb(1) / arb(size)] * 3
    return arb_mat([[form[i, j] * per_size[i] * per_size[j] for j in range(6)] for i in range(6)])


def stiffened(rows: Sequence[Sequence[arb]], form: arb_mat, size: float, stiff: float) -> arb_mat:
    """Return a form that vanishes where all rows (m, 6) do, and is large across."""
    total = arb_mat(6, 6)
    weight = stiff * float(np.abs(balls.middle(form)).max())
    for row in rows:
        own = [x / (1 if k < 3 else arb(size)) for k, x in enumerate(row)]
        norm_sq = sum(float(x.mid()) ** 2 for x in own)
        if norm_sq > 0.0:
            factor = arb(weight / norm_sq)
            total += arb_mat([[a * b * factor for b in own] for a in own])
    return total


def has_lowest_point(
    where: Neighbourhood, tight: Sequence[int], spokes: Sequence[arb_mat], arms: Sequence[arb_mat]
) -> bool:
    """Return True when the height has a lowest point among the allowed poses inside the neighbourhood."""
    problem, size = where.problem, where.size
    load = balls.ranges(problem.loaded.load_ranges)
    matrix = wrench_matrix(spokes, arms, load, size)
    middle = balls.middle(matrix)
    count = len(tight)
    lift = nearest_direction(middle[:, :count] / np.linalg.norm(middle[:, :count], axis=0))
    if lift is None or not all(product(lift, matrix, k) > 0 for k in range(count)):
        return False
    t = some_tensions(middle)
    centre = geometry(problem, where.centre)
    squares = [balls.dot(centre.spokes[i], centre.spokes[i]) for i in tight]
    longest = [balls.from_fraction(problem.lengths[i][1]) for i in tight]
    # L at the centre over the height there, for the longest cables.
    terms = zip(t, squares, longest, strict=True)
    gain = sum((arb(x) * (square - most * most) / 2 for x, square, most in terms), arb(0))
    own = wrench_matrix([centre.spokes[i] for i in tight], [centre.arms[i] for i in tight], load, size)
    rest = balls.norm(own * balls.vector([*(arb(x) for x in t), arb(1)]))
    form = scaled(quadratic_form(list(spokes), list(arms), [arb(x) for x in t]), size)
    form += stiffened(gauge(where), form, size, STIFF[1])
    least = arb(0.5 * float(np.linalg.eigvalsh(symmetric(balls.middle(form))).min()))
    if not positive_definite(form - least * balls.identity(6)):
        return False
    border = arb(where.reach) * arb(size)
    if not (least * border > rest):
        return False
    rise = gain + least * border * border / 2 - rest * border
    for power in LIFTS:
        moved = lifted(where, lift, 2.0**-power)
        view = geometry(problem, moved)
        if all(view.distances[i] < balls.from_fraction(problem.lengths[i][0]) for i in tight):
            work = balls.dot(load, moved.centre - where.centre.centre)
            return bool(-work < rise)
    return False


def lifted(where: Neighbourhood, direction: Floats, share: float) -> Pose:
    """Return the centre moved a little along a direction in (v, size omega)."""
    v = balls.vector([arb(share * where.size * float(x)) for x in direction[:3]])
    turn = cayley([arb(0.5 * share * float(x)) for x in direction[3:]])
    return Pose(turn * where.centre.rotation, where.centre.centre + v, ())


def some_tensions(middle: Floats) -> list[float]:
    """Return tensions t >= 0 (over lengths) that about balance, as many positive as possible."""
    count = middle.shape[1] - 1
    t = np.linalg.lstsq(middle[:, :count], -middle[:, count], rcond=None)[0]
    for _ in range(200):
        t = np.maximum(t, 0.0)
        t = t + np.linalg.lstsq(middle[:, :count], -middle[:, count] - middle[:, :count] @ t, rcond=None)[0]
        if t.min() >= 0.0:
            break
    return [max(float(x), 0.0) for x in t]


def symmetric(a: Floats) -> Floats:
    """Return the symmetric part."""
    return np.asarray(0.5 * (a + a.T))
