"""What a certificate says of one pose, checked on an enclosure of that pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from flint import arb, arb_mat, ctx

from certificates.arithmetic.balls import BITS, Vector, all_inside, column, hull, inside, minus, norm
from certificates.arithmetic.vectors import dot
from certificates.problem import Listed, Problem
from certificates.stability import check_stability, follows, rope_to, variation_of_ropes
from certificates.verdicts import NotProved


@dataclass(frozen=True)
class Pose:
    """Holds the pose in question, for every choice of lengths."""

    rotation: arb_mat
    """(3, 3), platform to base."""
    centre: arb_mat
    """(3, 1), of the centre of mass."""
    densities: dict[int, arb]
    """t = tension / distance of the cables that may carry."""
    tensions: dict[int, arb] = field(default_factory=dict)
    """Of cables that may carry, where they are known better than from t and the distance;"""
    distances: dict[int, arb] = field(default_factory=dict)
    """of the others, where they are known better than from rotation and centre."""
    middle: Pose | None = None
    """That for the middles of ranges, from which all others are reached without passing a singular one."""


def claimed(implied: bool, what: str) -> None:
    """Raise NotProved unless a claim is implied."""
    if not implied:
        raise NotProved(f"solution claims {what}: this does not follow")


def spoke(problem: Problem, pose: Pose, i: int) -> tuple[Vector, Vector]:
    """Return r_i = R b_i and e_i = A_i - p - r_i."""
    arm = pose.rotation * column(problem.points[i])
    return arm.entries(), minus(problem.exits[i], (pose.centre + arm).entries())


def check_pose(
    problem: Problem,
    listed: Listed,
    subset: Sequence[int],
    pose: Pose,
    motions: Sequence[Vector] = (),
) -> None:
    """Raise NotProved unless all that is claimed of a listed pose holds in a pose of the cables ``subset``.

    ``motions`` (v at the centre of mass, then omega) lead along the pose's family, of whose slackness
    nothing is checked here.
    """
    with ctx.workprec(BITS):
        claimed((listed.family is None) == (not motions), "another family")
        claimed(all_inside(pose.rotation.entries(), [b for row in listed.rotation for b in row]), "rotation")
        origin = pose.centre - pose.rotation * column(problem.centre)
        claimed(all_inside(origin.entries(), listed.position), "position")
        height = -dot(pose.centre.entries(), problem.gravity) / norm(problem.gravity)
        claimed(inside(height, listed.height), "height")
        distances = [distance_of(problem, pose, i) for i in range(len(problem.names))]
        for i, distance in enumerate(distances):
            tension = tension_of(problem, pose, i) if i in subset else None
            check_cable(problem, listed, i, tension, distance)
        taut = tuple(i for i, state in enumerate(listed.states) if state == "taut")
        claimed(listed.taut == taut, "other taut cables than states")
        if not motions:
            others = [i for i in range(len(problem.names)) if i not in subset]
            near = all(distances[i] < problem.lengths[i][0] for i in others)
            far = any(distances[i] > problem.lengths[i][1] for i in others)
            check_respected(problem, listed, near=near, far=far)
        if problem.is_routed:
            stable = is_routed_stability(problem, listed, subset, pose)
        else:
            # Where all carry along the way from the middle, no free motion becomes stable or unstable on it.
            holds = problem.ignore_tension_sign or all(pose.densities[i] > 0 for i in subset)
            at = pose.middle if pose.middle is not None and holds else pose
            chosen = [(*spoke(problem, at, i), at.densities[i]) for i in subset]
            stable = check_stability(problem, listed, chosen, motions)
        claimed(stable, f"stability {listed.stability}")


def distance_of(problem: Problem, pose: Pose, i: int) -> arb:
    """Enclose the length of a cable's way to its platform point."""
    return pose.distances[i] if i in pose.distances else path_length(problem, pose, i)


def path_length(problem: Problem, pose: Pose, i: int) -> arb:
    """Enclose the length of a cable from where it starts to its anchor."""
    if problem.is_routed:
        return rope_to(problem, i, anchor(problem, pose, i)).length
    return norm(spoke(problem, pose, i)[1])


def tension_of(problem: Problem, pose: Pose, i: int) -> arb:
    """Enclose the tension of a cable of the subset."""
    if i in pose.tensions:
        return pose.tensions[i]
    t = pose.densities[i]
    if problem.is_routed:
        return t * rope_to(problem, i, anchor(problem, pose, i)).free
    # Its length is its distance: a ball would be slightly wider than its range.
    is_elastic = problem.stiffness[i] is not None
    return t * (path_length(problem, pose, i) if is_elastic else hull(*problem.lengths[i]))


def anchor(problem: Problem, pose: Pose, i: int) -> Vector:
    """Enclose where a cable ends."""
    return list((pose.centre + pose.rotation * column(problem.points[i])).entries())


def is_routed_stability(problem: Problem, listed: Listed, subset: Sequence[int], pose: Pose) -> bool:
    """Return True when what is said about stability of cables over pulleys follows."""
    if listed.stability == "undecided":
        return True
    cables = {i: (spoke(problem, pose, i)[0], anchor(problem, pose, i), pose.densities[i]) for i in subset}
    all_hold = all(t > 0 for _, _, t in cables.values())
    return follows(listed, *variation_of_ropes(problem, cables), (), all_hold)


def check_cable(problem: Problem, listed: Listed, i: int, tension: arb | None, distance: arb) -> None:
    """Check state, tension and distance of a cable; ``tension`` None: it is not in the subset."""
    state, name, (lo, hi) = listed.states[i], problem.names[i], problem.lengths[i]
    low, high = listed.distances[i]
    if tension is None or problem.stiffness[i] is not None:
        claimed(inside(distance, listed.distances[i]), f"distance of {name}")
    else:
        claimed(arb(low) <= lo and arb(high) >= hi, f"distance of {name}")
    pull = arb(0) if tension is None else tension
    claimed(state == "undecided" or inside(pull, listed.tensions[i]), f"tension of {name}")
    if state == "taut":
        claimed(tension is not None and (problem.ignore_tension_sign or tension > 0), f"{name} taut")
    elif state == "slack":
        claimed(tension is None and (problem.ignore_slack or distance < lo), f"{name} slack")
    else:
        refuted = distance > hi and not problem.ignore_slack if tension is None else tension < 0
        claimed(state == "undecided" and (problem.ignore_tension_sign or not refuted), f"{name} {state}")


def check_respected(problem: Problem, listed: Listed, *, near: bool, far: bool) -> None:
    """Check what is said about the cables outside the subset together.

    ``near``: all are proved shorter than their lengths (in a family: at each of its poses); ``far``: one is
    proved to be longer (in a family: at some angle).
    """
    claimed(listed.slack_respected is not True or near, "slack respected")
    claimed(listed.slack_respected is not False or (problem.ignore_slack and far), "slack not respected")
