"""From a certified pose to a reported solution: distances, tensions, states, slackness, stability."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.energy import classify
from cdpr_interval.mechanics.orientation import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    rpy_from_rotation,
)
from cdpr_interval.mechanics.six_dof.fields import OPEN, STABLE, Cables, Fields, fill_fields
from cdpr_interval.mechanics.six_dof.frame import Frame, Pose
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import range_point
from solvers.answers.data import CableState, Certainty, Family, Nominal, Proof, Solution
from solvers.questions.problem import Options, Problem
from solvers.six_dof.cells.roots import Root
from solvers.six_dof.prepared import Lengths

Floats = NDArray[np.float64]

ONE = Range.exact(1)
NARROW = 1e-9
"""A matrix this near to a rotation is taken for one."""


@dataclass(frozen=True)
class Geometry:
    """A pose seen from all cables: arms r_i, spokes e_i and distances |e_i|."""

    arms: list[arb_mat]
    spokes: list[arb_mat]
    distances: list[arb]


def geometry(problem: Problem, pose: Pose) -> Geometry:
    """Compute arms, spokes and distances of all cables."""
    arms, spokes, distances = [], [], []
    for a, b in zip(problem.loaded.exit_ranges, problem.loaded.arm_ranges, strict=True):
        r = pose.rotation * balls.ranges(b)
        e = balls.ranges(a) - pose.centre - r
        arms.append(r)
        spokes.append(e)
        distances.append(balls.norm(e))
    return Geometry(arms, spokes, distances)


def length_ball(problem: Problem, i: int) -> arb:
    """Enclose l_i."""
    lo, hi = problem.lengths[i]
    return balls.from_fraction(lo).union(balls.from_fraction(hi)) if lo < hi else balls.from_fraction(lo)


@dataclass(frozen=True)
class Others:
    """What the cables that do not carry a pose do there."""

    states: tuple[CableState, ...]
    """Of all cables, file order."""
    respected: bool | None
    """None of them is longer than its length; None: undecided."""


def states_of(
    problem: Problem, view: Geometry, certain: dict[int, bool], slack_everywhere: dict[int, bool | None]
) -> Others:
    """Return the state of every cable; of the taut ones it is ``certain`` or not that they pull."""
    states: list[CableState] = []
    respected: bool | None = True
    for i in range(len(problem.robot.cables)):
        if i in certain:
            states.append(CableState.TAUT if certain[i] else CableState.UNDECIDED)
            continue
        slack = slack_everywhere[i] if i in slack_everywhere else is_slack(problem, view, i)
        states.append(CableState.UNDECIDED if slack is None else CableState.SLACK)
        if slack is False:
            respected = False
        elif slack is None and respected:
            respected = None
    return Others(tuple(states), respected)


def tensions_and_distances(
    problem: Problem, view: Geometry, densities: dict[int, arb], pushing: bool
) -> tuple[Floats, Floats]:
    """Return the bounds (N, 2) of tensions and distances; without ``pushing`` no tension is negative."""
    tensions = np.zeros((len(view.distances), 2))
    distances = np.array([balls.to_bounds(d) for d in view.distances])
    for i, t in densities.items():
        length = length_ball(problem, i)
        tensions[i] = balls.to_bounds(t * length)
        lo, hi = balls.to_bounds(length)
        distances[i] = max(distances[i, 0], lo), min(distances[i, 1], hi)
        if not pushing:
            tensions[i, 0] = max(tensions[i, 0], 0.0)
    return tensions, distances


def stability_of(
    view: Geometry, taut: tuple[int, ...], pose: Pose, motions: list[arb_mat], open_state: bool, pushing: bool
) -> Stability:
    """Return whether a pose is stable; with ``pushing`` tensions may be negative."""
    if pushing and any(not t > 0 for t in pose.densities):
        # Rigid legs: with a pushing leg the energy says nothing; six legs leave no freedom.
        return Stability.STABLE if len(taut) == 6 else Stability.UNDECIDED
    spokes, arms = [view.spokes[i] for i in taut], [view.arms[i] for i in taut]
    return classify(spokes, arms, list(pose.densities), motions, open_state)


def pose_solution(
    problem: Problem,
    options: Options,
    taut: tuple[int, ...],
    pose: Pose,
    *,
    proof: Proof = Proof.INTERVAL_NEWTON,
    family: Family | None = None,
    family_motions: list[arb_mat] | None = None,
    slack_everywhere: dict[int, bool | None] | None = None,
) -> Solution | None:
    """Return the solution of a proved pose, or None where it is proved to be none.

    ``slack_everywhere`` overrides the slack test for cables whose distance varies along a
    family: True slack, False too long, None undecided.
    """
    view = geometry(problem, pose)
    densities = dict(zip(taut, pose.densities, strict=True))
    pushing = options.ignore_tension_sign
    if not pushing and any(t < 0 for t in pose.densities):
        return None
    certain = {i: pushing or bool(t > 0) for i, t in densities.items()}
    others = states_of(problem, view, certain, slack_everywhere or {})
    if others.respected is False and not options.ignore_slack:
        return None
    states = others.states
    tensions, distances = tensions_and_distances(problem, view, densities, pushing)
    open_state = CableState.UNDECIDED in states
    return Solution(
        taut=tuple(i for i, s in enumerate(states) if s is CableState.TAUT),
        cable_states=states,
        position=balls.bounds_array(origin(problem.robot, pose)),
        rotation=np.clip(balls.bounds_array(pose.rotation), -1.0, 1.0).reshape(3, 3, 2),
        height=height(problem.robot, pose.centre),
        tensions=tensions,
        distances=distances,
        slack_respected=others.respected,
        existence=Certainty.PROVED,
        uniqueness=Certainty.PROVED,
        proof=proof,
        stability=stability_of(view, taut, pose, family_motions or [], open_state, pushing),
        nominal=nominal(problem.robot, pose),
        family=family,
    )


def empty_fields(m: int, n: int, count: int) -> Fields:
    """Return arrays for the fields of m roots, n of the cables taut."""
    return Fields(
        np.empty((m, 3, 3, 2)),
        np.empty((m, 3, 2)),
        np.empty((m, 2)),
        np.empty((m, count, 2)),
        np.empty((m, n, 2)),
        np.zeros((m, count, 2)),
        np.empty(m, dtype=np.int64),
    )


def fields_of(
    cables: Cables, lengths: Lengths, taut: tuple[int, ...], frame: Frame, roots: Sequence[Root]
) -> Fields:
    """Return what the roots of one search report, in bounds."""
    fields = empty_fields(len(roots), len(taut), len(cables.exits))
    if roots:
        boxes = np.array([root.box for root in roots])
        charts = np.array([root.chart for root in roots])
        indices = np.array(taut, dtype=np.int64)
        fill_fields(cables, frame.bounds, boxes, charts, indices, lengths.bounds, fields)
    return fields


def multiply_tensions(fields: Fields, factor: Range) -> None:
    """Multiply tensions by the factor of the load, a range of positive numbers."""
    if factor == ONE:
        return
    lo, hi = enclose(factor.lo)[0], enclose(factor.hi)[1]
    for bounds in (fields.densities, fields.tensions):
        ends = np.stack([bounds[..., k] * end for k in (0, 1) for end in (lo, hi)])
        bounds[..., 0] = np.nextafter(ends.min(axis=0), -np.inf)
        bounds[..., 1] = np.nextafter(ends.max(axis=0), np.inf)
        bounds[(ends == 0.0).all(axis=0)] = 0.0


def decided_solutions(
    options: Options, lengths: Lengths, taut: tuple[int, ...], fields: Fields
) -> list[tuple[bool, Solution | None]]:
    """Return for each root whether it is decided, and then its solution or, proved to be none, None.

    What is decided here is what ``pose_solution`` would decide.
    """
    densities, distances = fields.densities.tolist(), fields.distances.tolist()
    limits = lengths.bounds.tolist()
    others = [i for i in range(len(limits)) if i not in taut]
    finite = np.asarray(np.isfinite(fields.tensions).all(axis=(1, 2))).tolist()
    verdicts = fields.verdicts.tolist()
    positions, rotations = middles(fields.position).tolist(), middles(fields.rotation)
    states = tuple(CableState.TAUT if i in taut else CableState.SLACK for i in range(len(limits)))
    found: list[tuple[bool, Solution | None]] = []
    for k in range(len(verdicts)):
        signs = [1 if lo > 0.0 else -1 if hi < 0.0 else 0 for lo, hi in densities[k]]
        slack = [compared(distances[k][i], limits[i]) for i in others]
        if (-1 in signs and not options.ignore_tension_sign) or (-1 in slack and not options.ignore_slack):
            found.append((True, None))
            continue
        if 0 in signs or 0 in slack or verdicts[k] == OPEN or not finite[k]:
            found.append((False, None))
            continue
        x, y, z = positions[k]
        solution = Solution(
            taut=taut,
            cable_states=states,
            position=fields.position[k],
            rotation=fields.rotation[k],
            height=fields.height[k],
            tensions=fields.tensions[k],
            distances=fields.distances[k],
            slack_respected=-1 not in slack,
            existence=Certainty.PROVED,
            uniqueness=Certainty.PROVED,
            proof=Proof.INTERVAL_NEWTON,
            stability=Stability.STABLE if verdicts[k] == STABLE else Stability.UNSTABLE,
            nominal=nominal_pose((x, y, z), rotations[k]),
            family=None,
        )
        found.append((True, solution))
    return found


def compared(distance: list[float], length: list[float]) -> int:
    """Return 1 for bounds of a distance below those of a length, -1 above, 0 where they meet."""
    return 1 if distance[1] < length[0] else -1 if distance[0] > length[1] else 0


def middles(bounds: Floats) -> Floats:
    """Return the middles of bounds (..., 2)."""
    return np.asarray(0.5 * bounds[..., 0] + 0.5 * bounds[..., 1])


def is_slack(problem: Problem, view: Geometry, i: int) -> bool | None:
    """Return True: shorter than its length; False: longer; None: undecided."""
    length = length_ball(problem, i)
    if view.distances[i] < length:
        return True
    if view.distances[i] > length:
        return False
    return None


def origin(robot: Robot, pose: Pose) -> arb_mat:
    """Return the platform origin in the base frame."""
    return pose.centre - pose.rotation * balls.ranges(range_point(robot.platform.centre_of_mass))


def height(robot: Robot, centre: arb_mat) -> Floats:
    """Return the bounds of the centre of mass's height along up (against gravity)."""
    g = balls.ranges(range_point(robot.gravity))
    return np.array(balls.to_bounds(balls.dot(centre, g) * (-1 / balls.norm(g))))


def nominal(robot: Robot, pose: Pose) -> Nominal:
    """Return plain floats in the middle of the pose."""
    x, y, z = balls.middle(origin(robot, pose))[:, 0].tolist()
    return nominal_pose((x, y, z), balls.middle(pose.rotation))


def nominal_pose(position: tuple[float, float, float], rotation: Floats) -> Nominal:
    """Return a pose in plain floats, its rotation as quaternion and angles."""
    quaternion = quaternion_from_rotation(rotation)
    nearest = rotation_from_quaternion(quaternion)
    # The middle of wide bounds is no rotation: near a pitch of a quarter turn its own angles are far off.
    narrow = np.abs(nearest - rotation).max() < NARROW
    return Nominal(position, quaternion, rpy_from_rotation(rotation if narrow else nearest))


def solve_densities(problem: Problem, taut: tuple[int, ...], pose: Pose) -> Pose | None:
    """Fill in t of six taut cables by a linear solve over the pose's box; None where it may be singular."""
    view = geometry(problem, pose)
    rows = [
        [*balls.entries(view.spokes[i]), *balls.entries(balls.cross(view.arms[i], view.spokes[i]))]
        for i in taut
    ]
    load = balls.ranges(problem.loaded.load_ranges)
    right = balls.vector([-x for x in balls.entries(load)] + [arb(0)] * 3)
    try:
        t = arb_mat(rows).transpose().solve(right)
    except ZeroDivisionError:
        return None
    return replace(pose, densities=tuple(balls.entries(t)))


def turning(axis_point: arb_mat, axis: arb_mat, centre: arb_mat) -> arb_mat:
    """Return the motion (v at the centre, omega) of turning about an axis."""
    v = balls.cross(axis, centre - axis_point)
    return balls.vector([*balls.entries(v), *balls.entries(axis)])
