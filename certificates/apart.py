"""Listed solutions that are not one pose: without this their number would say nothing.

Where the state of a cable is undecided no number is claimed, and nothing is asked here: several subsets may
then have poses of their own in one box.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

from flint import arb_mat, ctx

from certificates.arithmetic.balls import BITS, column, hull
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
    for j, k in meeting(problem, solutions):
        raise NotProved(f"solutions {min(j, k) + 1} and {max(j, k) + 1} may be the same")


def meeting(problem: Problem, solutions: list[Listed]) -> Iterator[tuple[int, int]]:
    """Yield the pairs of decided solutions that may be the same.

    With slackness asked for, a family differs from all solutions with other taut cables: a cable that is taut
    in one is slack in the other.
    """
    decided = [(k, s) for k, s in enumerate(solutions) if is_decided(s)]
    yield from meeting_boxes([(k, s) for k, s in decided if s.family is None])
    with ctx.workprec(BITS):
        families = [(k, s, place(problem, s)) for k, s in decided if s.family is not None]
        others = [(k, s, place(problem, s)) for k, s in decided] if families else []
        for k, family, here in families:
            for j, other, there in others:
                in_time()
                asked = problem.ignore_slack or family.taut == other.taut
                if j != k and asked and may_belong(family, here, there):
                    yield k, j


def meeting_boxes(single: list[tuple[int, Listed]]) -> Iterator[tuple[int, int]]:
    """Yield the pairs of numbered solutions whose boxes meet."""
    boxes = sorted(([*s.position, *chain(*s.rotation)], k) for k, s in single)
    for n, (a, k) in enumerate(boxes):
        in_time()
        for b, j in boxes[n + 1 :]:
            if b[0][0] > a[0][1]:
                break
            if all(x[0] <= y[1] and y[0] <= x[1] for x, y in zip(a, b, strict=True)):
                yield k, j


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
