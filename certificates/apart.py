"""Listed solutions that are not one pose: without this their number would say nothing.

Where the state of a cable is undecided no number is claimed, and nothing is asked here: several subsets may
then have poses of their own in one box.
"""

from __future__ import annotations

from itertools import chain

from flint import arb_mat, ctx

from certificates.balls import BITS, column, hull
from certificates.clock import in_time
from certificates.problem import Listed, Problem
from certificates.verdicts import NotProved

Place = tuple[arb_mat, arb_mat]
"""Rotation (3, 3) and centre of mass (3, 1) of all poses in a listed box."""


def is_decided(listed: Listed) -> bool:
    """Return True for a solution that says of every cable whether it carries."""
    return "undecided" not in listed.states and listed.slack_respected is not None


def require_apart(problem: Problem, solutions: list[Listed]) -> None:
    """Raise NotProved where two solutions may be one pose, or one a pose of the other's family."""
    decided = [(k, s) for k, s in enumerate(solutions, 1) if is_decided(s)]
    require_boxes_apart([(k, s) for k, s in decided if s.family is None])
    with ctx.workprec(BITS):
        families = [(k, s, place(problem, s)) for k, s in decided if s.family is not None]
        others = [(k, place(problem, s)) for k, s in decided] if families else []
        for k, family, here in families:
            for j, there in others:
                in_time()
                if j != k and may_belong(family, here, there):
                    raise NotProved(f"solutions {min(j, k)} and {max(j, k)} may be the same")


def require_boxes_apart(single: list[tuple[int, Listed]]) -> None:
    """Raise NotProved where two boxes of numbered solutions meet."""
    boxes = sorted(([*s.position, *chain(*s.rotation)], k) for k, s in single)
    for n, (a, k) in enumerate(boxes):
        in_time()
        for b, j in boxes[n + 1 :]:
            if b[0][0] > a[0][1]:
                break
            if all(x[0] <= y[1] and y[0] <= x[1] for x, y in zip(a, b, strict=True)):
                raise NotProved(f"solutions {min(j, k)} and {max(j, k)} may be the same")


def place(problem: Problem, listed: Listed) -> Place:
    """Return what a listed box holds."""
    rotation = arb_mat([[hull(*b) for b in row] for row in listed.rotation])
    return rotation, column([hull(*b) for b in listed.position]) + rotation * column(problem.centre)


def may_belong(family: Listed, here: Place, there: Place) -> bool:
    """Return False when a place is proved to hold no pose of a family that is listed elsewhere.

    A pose (R, c) that turns about the axis through q along n keeps n . c, R^T n and the way from the axis
    to c as the body sees it, R^T (I - n n^T) (c - q). Of all rotations c alone is kept.
    """
    assert family.family is not None
    turning = family.family
    if turning.axis_point is None or turning.axis_direction is None:
        return overlap(here[1], there[1])
    n, q = (column([hull(*b) for b in v]) for v in (turning.axis_direction, turning.axis_point))

    def kept(pose: Place) -> list[arb_mat]:
        """Return what turning about the axis leaves as it is."""
        rotation, centre = pose
        body, along = rotation.transpose(), n.transpose() * centre
        return [along, body * n, body * (centre - q - n * (n.transpose() * (centre - q)))]

    return all(overlap(a, b) for a, b in zip(kept(here), kept(there), strict=True))


def overlap(a: arb_mat, b: arb_mat) -> bool:
    """Return False when two vectors or matrices differ in some entry."""
    return all(x.overlaps(y) for x, y in zip(a.entries(), b.entries(), strict=True))
