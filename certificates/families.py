"""Subsets whose taut cables all end in one platform point: where it rests, and how the platform may lie.

At the centre of mass: the platform may turn freely. In another point: the centre of mass lies on the load's
line through it, the platform hanging under the point or balanced over it, and may turn about that line.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from flint import arb, arb_mat, ctx

from certificates.arithmetic.balls import BITS, Vector, column, minus, norm, unit
from certificates.arithmetic.vectors import cross
from certificates.claims import Pose, check_pose, check_respected, claimed, spoke
from certificates.point_mass import Point, lowest_points, pose_indices
from certificates.problem import Listed, Problem
from certificates.turning import check_turning, never_slack
from certificates.verdicts import NotProved


def check_one_point_family(
    problem: Problem, taut: Sequence[int], entry: Any, solutions: list[Listed]
) -> set[int]:
    """Check an entry of taut cables that end in one platform point; return the solutions it proves."""
    arm = problem.points[taut[0]]
    if any(problem.points[i] != arm for i in taut) or problem.is_elastic:
        raise NotProved("not inextensible cables that end in one platform point")
    free = not any(x != 0 for x in arm)
    chosen, proof = pose_indices(problem, entry, solutions, 1 if free else 2)
    claimed(chosen[0] is None or chosen[0] not in chosen[1:], "two families")
    with ctx.workprec(BITS):
        for part, found in lowest_points(problem, taut, proof):
            if found is None or any(i not in found[1] for i in taut):
                claimed(all(k is None for k in chosen), "a pose of cables that have none")
                continue
            for side, k in enumerate(chosen):
                listed = None if k is None else solutions[k]
                if free:
                    check_free(part, taut, found, listed)
                else:
                    check_hung(part, taut, found, listed, 1 - 2 * side)
    return {k for k in chosen if k is not None}


def check_free(problem: Problem, taut: Sequence[int], found: Point, listed: Listed | None) -> None:
    """Check the family of all rotations, listed at one of them, or that it has no slack pose.

    Its poses are the rotations at which the cables listed as slack are; with slackness ignored all of them.
    """
    point, densities = found
    others = [i for i in range(len(problem.names)) if i not in taut]
    reach = {i: (norm(minus(problem.exits[i], point.entries())), norm(problem.points[i])) for i in others}
    if listed is None:
        far = any(abs(d - arm) > problem.lengths[i][1] for i, (d, arm) in reach.items())
        if problem.ignore_slack or not far:
            raise NotProved("a family of all rotations is not excluded")
        return
    pose = Pose(rotation_near(listed), point, densities)
    motions = [[arb(int(i == k + 3)) for i in range(6)] for k in range(3)]
    check_pose(problem, listed, taut, pose, motions)
    family = listed.family
    kind = family is not None and family.kind == "all-rotations" and not family.angle_ranges
    claimed(kind, "another family")
    if problem.ignore_slack:
        near = all(d + arm < problem.lengths[i][0] for i, (d, arm) in reach.items())
    else:
        slack = {i: norm(spoke(problem, pose, i)[1]) < problem.lengths[i][0] for i in others}
        claimed(all(slack[i] for i in others if listed.states[i] == "slack"), "slack as listed")
        near = all(slack.values())
    far = any(d + arm > problem.lengths[i][1] for i, (d, arm) in reach.items())
    check_respected(problem, listed, near=near, far=far)


def rotation_near(listed: Listed) -> arb_mat:
    """Return a rotation near the middle of a listed one's bounds; that it lies in them is left to check."""
    first, second = ([arb(0.5 * lo + 0.5 * hi) for lo, hi in row] for row in listed.rotation[:2])
    if not norm(cross(first, second)) > 0:
        raise NotProved("no rotation is listed")
    x, z = unit(first), unit(cross(first, second))
    return arb_mat([x, cross(z, x), z])


def check_hung(problem: Problem, taut: Sequence[int], found: Point, listed: Listed | None, side: int) -> None:
    """Check the family that hangs (side 1) or is balanced (-1), or that it has no slack pose."""
    pose, up = hung(problem, taut[0], found, side), column(unit([-x for x in problem.load]))
    if listed is None:
        never_slack(problem, taut, pose, found[0], up)
    else:
        check_turning(problem, listed, taut, pose, found[0], up)


def hung(problem: Problem, cable: int, found: Point, side: int) -> Pose:
    """Return a pose whose centre of mass lies straight below (side 1) or above a cable's end at a point."""
    point, densities = found
    arm = problem.points[cable]
    rotation = any_frame([side * -x for x in unit(problem.load)]) * any_frame(unit(arm)).transpose()
    return Pose(rotation, point - rotation * column(arm), densities)


def any_frame(first: Vector) -> arb_mat:
    """Return a rotation whose first column is the given unit vector."""
    least = min(range(3), key=lambda k: abs(float(first[k])))
    second = unit(cross(first, [arb(int(k == least)) for k in range(3)]))
    return arb_mat([first, second, cross(first, second)]).transpose()
