"""Family poses: the axis of each family, where the other cables are slack, and where it ends."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.mechanics.arcs import Arc, ArcEnd, Circle, circle, common_arcs
from cdpr_interval.mechanics.six_dof.families import Classification, Kind
from cdpr_interval.mechanics.six_dof.frame import Pose, upward
from solvers.answers.data import Family, Proof, Solution
from solvers.questions.problem import Options, Problem
from solvers.six_dof.hanging import slack_rotation
from solvers.six_dof.solution import length_ball, pose_solution, turning

Floats = NDArray[np.float64]

TORUS_STEPS = 256
"""Pieces into which the second angle of a torus is cut to look at the other cables."""


@dataclass(frozen=True)
class Axis:
    """A line about which a pose may turn: a point and a unit direction, base frame."""

    point: arb_mat
    direction: arb_mat


@dataclass(frozen=True)
class FamilyEnd:
    """A pose of a family at which one more cable is exactly tight, with zero tension."""

    taut: tuple[int, ...]
    cable: int
    pose: Pose


def turned(pose: Pose, axis: Axis, angle: arb) -> Pose:
    """Return the pose turned about the axis."""
    r = balls.turn(axis.direction, angle)
    return Pose(r * pose.rotation, axis.point + r * (pose.centre - axis.point), pose.densities)


def axes_of(problem: Problem, taut: tuple[int, ...], kind: Classification, pose: Pose) -> list[Axis]:
    """Return the axes of a pose's family: none, one, or two for a torus."""
    found: list[Axis] = []
    if kind.kind is not Kind.ONE_POINT and not (kind.vertical or kind.rod):
        return found
    up = upward(problem.loaded.load_direction_ranges)
    if kind.kind is Kind.ONE_POINT:
        b = balls.ranges(problem.loaded.arm_ranges[taut[0]])
        found.append(Axis(pose.centre + pose.rotation * b, up))
    if kind.vertical:
        found.append(Axis(balls.ranges(problem.loaded.exit_ranges[taut[0]]), up))
    if kind.rod:
        arms = (problem.loaded.arm_ranges[i] for i in taut)
        direction = next(balls.ranges(arm) for arm in arms if any(map(any, arm)))
        found.append(Axis(pose.centre, pose.rotation * direction * (1 / balls.norm(direction))))
    return found


def circles(problem: Problem, taut: tuple[int, ...], pose: Pose, axis: Axis) -> list[Circle]:
    """Return the squared distances of all other cables when the pose turns about the axis."""
    found = []
    for j, exit_point in enumerate(problem.loaded.exit_ranges):
        if j in taut:
            continue
        point = pose.centre + pose.rotation * balls.ranges(problem.loaded.arm_ranges[j])
        found.append(
            circle(
                j,
                balls.ranges(exit_point),
                point,
                axis.point,
                axis.direction,
                length_ball(problem, j),
            )
        )
    return found


def turning_solutions(
    problem: Problem, options: Options, taut: tuple[int, ...], pose: Pose, axis: Axis
) -> tuple[list[Solution], list[FamilyEnd]]:
    """Return a one-axis family (one entry, or none where no angle leaves the others slack) and its ends."""
    around = circles(problem, taut, pose, axis)
    ends = [FamilyEnd(taut, c.cable, turned(pose, axis, angle)) for c in around for angle in crossings(c)]
    full = [Arc(ArcEnd(-arb.pi(), None), ArcEnd(arb.pi(), None))]
    arcs: list[Arc] | None
    touching: list[Arc] = []
    states: dict[int, bool | None]
    if options.ignore_slack:
        # A full turn; another cable is not slack when it is too long at some angle.
        arcs, states = full, {c.cable: always(c) for c in around}
    else:
        common = common_arcs(around)
        arcs = None if common is None else [arc for arc in common if arc.width > 0]
        touching = [] if common is None else [arc for arc in common if not arc.width > 0]
        states = {c.cable: True for c in around}
        if arcs is None:
            arcs = full
            states = {c.cable: everywhere(c) for c in around}
            if any(s is False for s in states.values()):
                return [], ends
            states = {c: s or None for c, s in states.items()}
    single = [touching_solution(problem, options, taut, pose, axis, arc, around) for arc in touching]
    apart = [solution for solution in single if solution is not None]
    if not arcs:
        return apart, ends
    longest = max(arcs, key=lambda a: float(a.width.mid()))
    zero = ((longest.start.angle + longest.end.angle) / 2).mid()
    if arcs is not full and any(a.start.cable is not None for a in arcs):
        pose = turned(pose, axis, zero)
    else:
        zero = arb(0)
    family = Family(
        kind="rotation",
        axis_point=balls.bounds_array(axis.point),
        axis_direction=balls.bounds_array(axis.direction),
        angle_ranges=np.array(
            [[balls.to_bounds(a.start.angle - zero), balls.to_bounds(a.end.angle - zero)] for a in arcs]
        ),
    )
    motion = turning(axis.point, axis.direction, pose.centre)
    found = pose_solution(
        problem,
        options,
        taut,
        pose,
        proof=Proof.FAMILY,
        family=family,
        family_motions=[motion],
        slack_everywhere=states,
    )
    return apart + ([] if found is None else [found]), ends


def touching_solution(
    problem: Problem,
    options: Options,
    taut: tuple[int, ...],
    pose: Pose,
    axis: Axis,
    arc: Arc,
    around: list[Circle],
) -> Solution | None:
    """Return the pose of an arc that may be empty or a single angle, where two cables just become tight."""
    at = turned(pose, axis, arc.start.angle.union(arc.end.angle))
    ends = (arc.start.cable, arc.end.cable)
    states = {c.cable: None if c.cable in ends else True for c in around}
    return pose_solution(problem, options, taut, at, slack_everywhere=states)


def everywhere(c: Circle) -> bool | None:
    """Return True where a cable is slack at every angle, False where it is too long at every one."""
    arc = c.arc()
    return arc if isinstance(arc, bool) else None


def always(c: Circle) -> bool | None:
    """Return True where a cable is slack at every angle, False where it is too long at some."""
    arc = c.arc()
    return False if isinstance(arc, Arc) else arc


def crossings(c: Circle) -> list[arb]:
    """Return the angles at which a cable is exactly tight."""
    arc = c.arc()
    return [arc.start.angle, arc.end.angle] if isinstance(arc, Arc) else []


def torus_solutions(
    problem: Problem, options: Options, taut: tuple[int, ...], pose: Pose, axes: list[Axis]
) -> list[Solution]:
    """Return a two-axis family as one entry; cables slack only for some of its angles stay undecided."""
    states: dict[int, bool | None] = {}
    step = 2 * arb.pi() / TORUS_STEPS
    for piece in range(TORUS_STEPS):
        angle = (step * piece).union(step * (piece + 1))
        for c in circles(problem, taut, turned(pose, axes[1], angle), axes[0]):
            seen = everywhere(c)
            states[c.cable] = seen if piece == 0 or states[c.cable] == seen else None
    if not options.ignore_slack and any(s is False for s in states.values()):
        return []
    whole = [balls.to_bounds(-arb.pi()), balls.to_bounds(arb.pi())]
    family = Family(
        kind="torus",
        axis_point=np.array([balls.bounds_array(a.point) for a in axes]),
        axis_direction=np.array([balls.bounds_array(a.direction) for a in axes]),
        angle_ranges=np.array([whole, whole]),
    )
    motions = [turning(a.point, a.direction, pose.centre) for a in axes]
    found = pose_solution(
        problem,
        options,
        taut,
        pose,
        proof=Proof.FAMILY,
        family=family,
        family_motions=motions,
        slack_everywhere=states,
    )
    return [] if found is None else [found]


def free_turning_solution(
    problem: Problem, options: Options, taut: tuple[int, ...], pose: Pose
) -> Solution | None:
    """Return the family of all rotations about the centre of mass at which the other cables are slack.

    It is listed at the identity, or where that leaves a cable too short at another rotation.
    """
    states: dict[int, bool | None] = {}
    for j, exit_point in enumerate(problem.loaded.exit_ranges):
        if j in taut:
            continue
        far = balls.norm(balls.ranges(exit_point) - pose.centre)
        arm = balls.norm(balls.ranges(problem.loaded.arm_ranges[j]))
        length = length_ball(problem, j)
        # With slackness ignored all rotations are listed, and one at which a cable is too long says so.
        least = far + arm if options.ignore_slack else abs(far - arm)
        states[j] = True if far + arm < length else False if least > length else None
    partly = [j for j, slack in states.items() if slack is None]
    note = ""
    if partly and not options.ignore_slack and all(slack is not False for slack in states.values()):
        rotation = slack_rotation(problem, pose.centre, partly)
        if rotation is False:
            return None
        if not isinstance(rotation, bool):
            pose = replace(pose, rotation=rotation)
            states.update(dict.fromkeys(partly, True))
            names = ", ".join(problem.robot.cable_names[j] for j in partly)
            verb = "is" if len(partly) == 1 else "are"
            note = f"of all rotations those at which {names} {verb} slack, or just tight without tension"
    family = Family("all-rotations", None, None, np.zeros((0, 2, 2)))
    unit = balls.identity()
    motions = [balls.vector([0, 0, 0, *(unit[i, k] for i in range(3))]) for k in range(3)]
    found = pose_solution(
        problem,
        options,
        taut,
        pose,
        proof=Proof.FAMILY,
        family=family,
        family_motions=motions,
        slack_everywhere=states,
    )
    return found if found is None or not note else replace(found, note=note)
