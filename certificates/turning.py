"""Poses that may turn about an axis: which angles keep every other cable slack.

With c on the axis n, a = A - c and w the way from c to a cable's platform point, the squared distance is
|a|^2 + |w|^2 - 2 (a.n)(w.n) - 2 (a.w - (a.n)(w.n)) cos(theta) - 2 (a . n x w) sin(theta).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from flint import arb, arb_mat, ctx

from certificates.arithmetic.balls import BITS, all_inside, column, hull, minus, norm
from certificates.arithmetic.vectors import cross, dot
from certificates.claims import Pose, check_pose, check_respected, claimed
from certificates.clock import in_time
from certificates.problem import Listed, Problem
from certificates.verdicts import NotProved

MOST_PIECES = 5000
"""Most pieces into which one range of angles is cut; two cables that change roles need about a hundred."""


SHARP = 1e-6
"""Widest bounds of a rotation from which angles are counted, lengths being exact."""


@dataclass(frozen=True)
class Circle:
    """The excess |e|^2 - l^2 = constant - cosine cos(theta) - sine sin(theta) of one cable."""

    constant: arb
    cosine: arb
    sine: arb

    def over(self, lo: arb, hi: arb) -> arb:
        """Enclose the excess over a range of angles by the mean value theorem."""
        angle, middle = hull(lo, hi), ((lo + hi) / 2).mid()
        slope = self.cosine * angle.sin() - self.sine * angle.cos()
        value = self.constant - self.cosine * middle.cos() - self.sine * middle.sin()
        return value + slope * (angle - middle)

    def most(self) -> arb:
        """Enclose the largest excess of all angles."""
        return self.constant + norm([self.cosine, self.sine])


def circle(problem: Problem, i: int, pose: Pose, point: arb_mat, direction: arb_mat) -> Circle:
    """Return how far a cable is too long when the pose turns about the axis."""
    n, c = direction.entries(), point.entries()
    w = minus((pose.centre + pose.rotation * column(problem.points[i])).entries(), c)
    a = minus(problem.exits[i], c)
    along = dot(a, n) * dot(w, n)
    length = hull(*problem.lengths[i])
    constant = dot(a, a) + dot(w, w) - 2 * along - length**2
    return Circle(constant, 2 * (dot(a, w) - along), 2 * dot(a, cross(n, w)))


def turned_about(pose: Pose, point: arb_mat, direction: arb_mat, angle: arb) -> Pose:
    """Return the pose turned about an axis (unit direction)."""
    x, y, z = direction.entries()
    k = arb_mat([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    r = arb_mat([[1, 0, 0], [0, 1, 0], [0, 0, 1]]) + k * angle.sin() + k * k * (1 - angle.cos())
    return Pose(r * pose.rotation, point + r * (pose.centre - point), pose.densities)


def check_turning(
    problem: Problem, listed: Listed, subset: Sequence[int], pose: Pose, point: arb_mat, direction: arb_mat
) -> None:
    """Raise NotProved unless the pose, turned about the axis, is the listed family."""
    with ctx.workprec(BITS):
        sharp = all(hi - lo <= SHARP for row in listed.rotation for lo, hi in row)
        claimed(sharp or any(lo < hi for lo, hi in problem.lengths), "no rotation from which angles count")
        here = turned_about(pose, point, direction, angle_between(pose, listed, direction))
        n = direction.entries()
        motion = [*cross(n, (here.centre - point).entries()), *n]
        check_pose(problem, listed, subset, here, [motion])
        family = listed.family
        claimed(family is not None and family.kind == "rotation", "another family")
        assert family is not None
        axis = family.axis_point is not None and all_inside(point.entries(), family.axis_point)
        claimed(axis, "the axis to be elsewhere")
        axis = family.axis_direction is not None and all_inside(n, family.axis_direction)
        claimed(axis, "another direction of the axis")
        circles = others(problem, subset, here, point, direction)
        # Ignoring slackness every angle is static: without circles only a full turn passes.
        check_ranges(listed, {} if problem.ignore_slack else circles)
        ranges = family.angle_ranges if listed.slack_respected else []
        near = all(slack(circles.values(), arb(start[1]), arb(end[0])) for start, end in ranges)
        check_respected(problem, listed, near=near, far=any(c.most() > 0 for c in circles.values()))


def others(
    problem: Problem, subset: Sequence[int], pose: Pose, point: arb_mat, direction: arb_mat
) -> dict[int, Circle]:
    """Return the circles of all cables outside the subset."""
    count = len(problem.names)
    return {i: circle(problem, i, pose, point, direction) for i in range(count) if i not in subset}


def angle_between(pose: Pose, listed: Listed, direction: arb_mat) -> arb:
    """Return a double near the angle that turns the pose into the listed one: a guess."""
    rows = [[(lo + hi) / 2 for lo, hi in row] for row in listed.rotation]
    m = arb_mat(rows) * pose.rotation.mid().transpose()
    twice = [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]
    return arb(math.atan2(float(dot(twice, direction.entries())), float(m.trace()) - 1.0))


def check_ranges(listed: Listed, circles: dict[int, Circle]) -> None:
    """Check that cables are slack inside the listed ranges, and one too long outside all of them."""
    assert listed.family is not None
    ranges = sorted(listed.family.angle_ranges)
    claimed(bool(ranges), "a family without angles")
    decided = [c for i, c in circles.items() if listed.states[i] != "undecided"]
    starts = [arb(start[0]) for start, _ in ranges[1:]] + [(2 * arb.pi() + ranges[0][0][0]).upper()]
    for (start, end), following in zip(ranges, starts, strict=True):
        claimed(start[0] <= start[1] <= end[0] <= end[1], "an angle range in the wrong order")
        claimed(slack(decided, arb(start[1]), arb(end[0])), "slack cables in an angle range")
        claimed(too_long(circles.values(), arb(end[1]), following), "a cable too long outside the ranges")


def slack(circles: Iterable[Circle], lo: arb, hi: arb) -> bool:
    """Return True when at every angle of a range all cables are slack."""
    every = list(circles)
    return everywhere(lambda a, b: all(c.over(a, b) < 0 for c in every), lo, hi)


def too_long(circles: Iterable[Circle], lo: arb, hi: arb) -> bool:
    """Return True when at every angle of a range some cable is too long."""
    every = list(circles)
    return everywhere(lambda a, b: any(c.over(a, b) > 0 for c in every), lo, hi)


def everywhere(holds: Callable[[arb, arb], bool], lo: arb, hi: arb) -> bool:
    """Return True when a statement is proved on each of the pieces into which [lo, hi] is cut."""
    left = [] if lo > hi else [(lo, hi)]
    for _ in range(MOST_PIECES):
        in_time()
        if not left:
            return True
        a, b = left.pop()
        if not holds(a, b):
            middle = ((a + b) / 2).mid()
            left += [(a, middle), (middle, b)]
    return False


def never_slack(
    problem: Problem, subset: Sequence[int], pose: Pose, point: arb_mat, direction: arb_mat
) -> None:
    """Raise NotProved unless some cable outside the subset is too long at every angle."""
    with ctx.workprec(BITS):
        circles = others(problem, subset, pose, point, direction)
        if problem.ignore_slack or not too_long(circles.values(), arb(0), arb(7)):
            raise NotProved("a family is not excluded at every angle")
