"""Roots of a search: what each box holds, and that it is what is listed, or no static pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from flint import arb, arb_mat

from certificates.arithmetic.balls import column, hull, unit
from certificates.arithmetic.floats import Floats
from certificates.arithmetic.jets import Jet
from certificates.claims import Pose, check_pose, distance_of, path_length
from certificates.clock import in_time
from certificates.problem import Listed
from certificates.roots import System
from certificates.search import Root, Search, half_turn
from certificates.searches import SubsetSearches
from certificates.turning import check_turning, never_slack, turned_about
from certificates.verdicts import NotProved

TOGETHER = 64
"""Roots whose boxes are looked at in one go."""
HALVINGS = 9
"""Of the ranges of lengths, one after another, for one root: at most 512 parts."""


def check_all_roots(searches: SubsetSearches, solutions: list[Listed]) -> set[int]:
    """Check all roots of a subset; return the solutions they prove."""
    return {k for search in searches.searches for k in check_roots(search, solutions)}


def check_roots(search: Search, solutions: list[Listed]) -> set[int]:
    """Check the roots of one search; return the solutions they prove."""
    found: set[int] = set()
    families: list[tuple[Root, Pose]] = []
    require_one_zero_at_most(search)
    for root in search.roots:
        in_time()
        pose = check_root(search, root, solutions)
        if root.pose is not None:
            found.add(root.pose)
            families += [(root, pose)] if pose is not None else []
    for (first, pose), (second, other) in combinations(families, 2):
        in_time()
        require_distinct(search, first, pose, second, other)
    return found


def require_distinct(search: Search, first: Root, pose: Pose, second: Root, other: Pose) -> None:
    """Raise NotProved unless two roots are listed as one family just when they are.

    A chart shows a family in one pose only: turned until the third entry of u is 0. So two families are the
    same just when the first, turned to where the second's chart shows it, is the second's pose; and they
    differ where something differs that turning does not change, as the tilt of the axes towards each other.
    """
    turned_pose = shown(search, pose, second.chart)
    if first.pose == second.pose:
        where = None
        if turned_pose is not None:
            where = search.coordinates(second.chart, turned_pose.rotation, turned_pose.centre)
        if where is None or not search.lies_in(where, second):
            raise NotProved("one family is listed for roots that may be two")
        return
    if not search.setting.planar and not tilt(search, pose).overlaps(tilt(search, other)):
        return
    if turned_pose is None or all(a.overlaps(b) for a, b in entries_of(turned_pose, other)):
        raise NotProved("a family may be listed twice")


def entries_of(one: Pose, other: Pose) -> list[tuple[arb, arb]]:
    """Return the entries of two poses in pairs."""
    first = [*one.rotation.entries(), *one.centre.entries()]
    return list(zip(first, [*other.rotation.entries(), *other.centre.entries()], strict=True))


def tilt(search: Search, pose: Pose) -> arb:
    """Return the cosine between the z axes of the frames, which turning about one does not change."""
    return (search.setting.base * pose.rotation * search.setting.platform.transpose())[2, 2]


def shown(search: Search, pose: Pose, chart: int) -> Pose | None:
    """Return the pose of a family that a chart shows; None where the chart may not show it.

    A plane shows it in one pose, in all charts: the other one, half a turn away, lies in the mirrored frame.
    """
    setting, problem = search.setting, search.problem
    if setting.planar:
        return pose
    sign = -1 if chart in (1, 2) else 1
    r = setting.base * pose.rotation * setting.platform.transpose() * half_turn(chart)
    along, across = r[1, 0] - r[0, 1], r[0, 0] + r[1, 1]
    if not (across > 0 or across < 0 or along > 0 or along < 0):
        return None
    behind = across.mid() < 0
    angle = arb.pi() + arb.atan2(-along, -across) if behind else arb.atan2(along, across)
    if setting.vertical:
        point, direction = column(problem.exits[search.order[0]]), column(unit([-v for v in problem.load]))
        return turned_about(pose, point, direction, -angle)
    arm = next(problem.points[i] for i in setting.taut if any(problem.points[i]))
    return turned_about(pose, pose.centre, pose.rotation * column(unit(arm)), -sign * angle)


def require_one_zero_at_most(search: Search) -> None:
    """Raise NotProved unless every root's box holds one pose at most."""
    for first in range(0, len(search.roots), TOGETHER):
        in_time()
        some = search.roots[first : first + TOGETHER]
        system = search.system(np.array([root.chart for root in some]))
        if not system.has_one_zero_at_most(np.moveaxis(np.array([root.box for root in some]), 0, -1)):
            raise NotProved("a root's box is not proved to hold at most one pose")


def check_root(search: Search, root: Root, solutions: list[Listed]) -> Pose | None:
    """Check a root and what is listed of its pose; return this pose where it is one of a family."""
    system = search.system(root.chart)
    if not search.setting.family:
        check_single(search, root, solutions, system)
        return None
    pose = pose_in(search, system, root, [hull(-1, 1)] * len(system.ranged))
    if root.pose is not None or not is_rejected(search, pose):
        check_family(search, root, pose, solutions)
    return pose


def check_single(search: Search, root: Root, solutions: list[Listed], system: System) -> None:
    """Check a root whose pose is alone, in parts of the ranges of lengths where it must be.

    The root's box holds one pose for each choice of lengths: what a part encloses there is that one.
    """
    listed = None if root.pose is None else solutions[root.pose]
    if listed is not None and listed.family is not None:
        raise NotProved("a single pose is listed as a family")
    middle = None
    if system.is_regular_all_along:
        middle = pose_in(search, system, root, [arb(0)] * len(system.ranged))
    waiting = [(0, [hull(-1, 1)] * len(system.ranged))]
    while waiting:
        in_time()
        depth, part = waiting.pop()
        try:
            pose = replace(pose_in(search, system, root, part), middle=middle)
            if listed is not None:
                check_pose(search.problem, listed, search.setting.taut, pose)
            elif not is_rejected(search, pose):
                raise NotProved("a root's pose is not listed and may be a solution")
        except NotProved:
            if depth == HALVINGS or not part:
                raise
            k = depth % len(part)
            ends = hull(part[k].lower(), part[k].mid()), hull(part[k].mid(), part[k].upper())
            waiting += [(depth + 1, [*part[:k], half, *part[k + 1 :]]) for half in ends]
    if listed is not None:
        check_alone(search, root, listed)


def pose_in(search: Search, system: System, root: Root, data: Sequence[arb]) -> Pose:
    """Return the pose of the zero in a root's box, for all lengths in a part of their ranges."""
    zero = system.zero_near([(lo + hi) / 2 for lo, hi in root.box], data)
    where = [v.value if isinstance(v, Jet) else v for v in system.jets(zero.entries())[:6]]
    if not search.lies_in(where, root):
        raise NotProved("the pose near a root's middle is not proved to lie in its box")
    rotation, way, densities, tensions, distances = system.pose(zero)
    centre = column(search.problem.exits[search.order[0]]) + way
    others = [i for i in range(len(search.problem.names)) if i not in search.order]
    return Pose(
        rotation,
        centre,
        dict(zip(search.order, densities, strict=True)),
        dict(zip(search.order, tensions, strict=False)),
        dict(zip(others, distances, strict=False)),
    )


def is_rejected(search: Search, pose: Pose) -> bool:
    """Return True for a pose proved not to be static: a cable would push, or another one is too long."""
    problem = search.problem
    for i in search.order if problem.is_routed else ():
        # Where a rope is not proved to lie on its pulley, the zero may be one of another turn of its angle.
        path_length(problem, pose, i)
    if not problem.ignore_tension_sign and any(t < 0 for t in pose.densities.values()):
        return True
    return any(
        distance_of(problem, pose, i) > hi
        for i, (_, hi) in enumerate(problem.lengths)
        if search.may_be_slack(i)
    )


def check_alone(search: Search, root: Root, listed: Listed) -> None:
    """Refuse a listed box that does not lie in its root's box: it might hold another pose.

    Two cables: a pose lies in the plane of one of the two mirrored frames when both carry. In the other
    frame it is a half turn away, where the chart does not reach (trace > 0 over the box).
    """
    rotation = arb_mat([[hull(*b) for b in row] for row in listed.rotation])
    centre = arb_mat([[hull(*b)] for b in listed.position]) + rotation * column(search.problem.centre)
    where = search.coordinates(root.chart, rotation, centre)
    if where is None or not search.lies_in(where, root):
        raise NotProved("a solution's box is not proved to hold one pose only")
    if not search.setting.planar:
        return
    t, radii, holds = search.system(root.chart).tensions([Floats.enclosing(v) for v in where])
    decided = [k for k, i in enumerate(search.order) if listed.states[i] != "undecided"]
    if not (holds.all() and all(abs(t[k, 0]) > radii[k, 0] for k in decided)):
        raise NotProved("a solution's box may hold poses at which a cable carries nothing")


def check_family(search: Search, root: Root, pose: Pose, solutions: list[Listed]) -> None:
    """Check a family by one of its poses."""
    problem, setting = search.problem, search.setting
    if setting.vertical and setting.rod:
        raise NotProved("families about two axes cannot be checked")
    point, direction = column(problem.exits[search.order[0]]), column(unit([-v for v in problem.load]))
    if setting.rod:
        arm = next(problem.points[i] for i in setting.taut if any(problem.points[i]))
        point, direction = pose.centre, pose.rotation * column(unit(arm))
    if root.pose is None:
        never_slack(problem, setting.taut, pose, point, direction)
    else:
        check_turning(problem, solutions[root.pose], setting.taut, pose, point, direction)
