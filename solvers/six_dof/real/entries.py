"""From proved roots of platforms on real cables to reported solutions, in ball arithmetic."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.mechanics.cables.path import Balls, OffTheCable, Path
from cdpr_interval.mechanics.energy import has_negative_direction, on_kernel, positive_definite, skew
from cdpr_interval.mechanics.six_dof.frame import Frame, Pose
from cdpr_interval.mechanics.stability import Stability
from solvers.answers.data import CableState, Certainty, Proof, Solution, Undecided
from solvers.questions.problem import Options, Problem
from solvers.six_dof.cells.roots import Root, pose_of
from solvers.six_dof.clusters import connected
from solvers.six_dof.real.columns import REAL_COLUMNS
from solvers.six_dof.solution import height, length_ball, nominal, origin

Floats = NDArray[np.float64]

OFF_REASON = "the pose is proved, but one of its other cables has no path there"
MOST_CELLS = 5_000
"""More cells than this are one region."""


@dataclass(frozen=True)
class Seen:
    """A pose as one cable sees it."""

    arm: arb_mat
    """r = R b."""
    path: Path
    turning: arb_mat
    """The derivative (3, 3) of the direction by the anchor."""

    @property
    def direction(self) -> arb_mat:
        """Unit vector towards the anchor."""
        return balls.vector(list(self.path.direction))


def views(problem: Problem, pose: Pose) -> list[Seen] | None:
    """Return what each cable sees of a pose; None where some cable has no path to it."""
    found = []
    numbers = Balls()
    for arm, model in zip(problem.loaded.arm_ranges, problem.loaded.models, strict=True):
        r = pose.rotation * balls.ranges(arm)
        x, y, z = balls.entries(pose.centre + r)
        try:
            path = model.route.path((x, y, z), numbers)
        except OffTheCable:
            return None
        found.append(Seen(r, path, arb_mat(model.route.turning(path, (x, y, z), numbers))))
    return found


def solution_of(problem: Problem, options: Options, taut: tuple[int, ...], root: Root) -> Solution | None:
    """Return the solution of a proved root, or None where it is proved to be no static pose.

    Distances are those along the cables, from where each starts to its anchor.
    """
    pose = pose_of(root, Frame.plain())
    if any(t < 0 for t in pose.densities):
        return None
    view = views(problem, pose)
    if view is None:
        position, rotation = balls.bounds_array(origin(problem.robot, pose)), balls.bounds_array(pose.rotation)
        return Undecided(taut, 1, OFF_REASON, position, np.clip(rotation, -1.0, 1.0).reshape(3, 3, 2))
    densities = dict(zip(taut, pose.densities, strict=True))
    states: list[CableState] = []
    respected: bool | None = True
    for i, seen in enumerate(view):
        if i in densities:
            states.append(CableState.TAUT if densities[i] > 0 else CableState.UNDECIDED)
            continue
        length = length_ball(problem, i)
        is_slack = True if seen.path.length < length else False if seen.path.length > length else None
        states.append(CableState.UNDECIDED if is_slack is None else CableState.SLACK)
        if is_slack is False:
            respected = False
        elif is_slack is None and respected:
            respected = None
    if respected is False and not options.ignore_slack:
        return None
    tensions, distances = _numbers(problem, view, densities)
    return Solution(
        taut=tuple(i for i, state in enumerate(states) if state is CableState.TAUT),
        cable_states=tuple(states),
        position=balls.bounds_array(origin(problem.robot, pose)),
        rotation=np.clip(balls.bounds_array(pose.rotation), -1.0, 1.0).reshape(3, 3, 2),
        height=height(problem.robot, pose.centre),
        tensions=tensions,
        distances=distances,
        slack_respected=respected,
        existence=Certainty.PROVED,
        uniqueness=Certainty.PROVED,
        proof=Proof.INTERVAL_NEWTON,
        stability=stability_of(problem, view, densities, CableState.UNDECIDED in states),
        nominal=nominal(problem.robot, pose),
        family=None,
    )


def _numbers(problem: Problem, view: list[Seen], densities: dict[int, arb]) -> tuple[Floats, Floats]:
    """Return bounds (N, 2) of tensions and of lengths along the cables."""
    tensions = np.zeros((len(view), 2))
    distances = np.array([balls.to_bounds(seen.path.length) for seen in view])
    for i, t in densities.items():
        lo, hi = balls.to_bounds(t * view[i].path.free)
        tensions[i] = max(lo, 0.0), hi
        if not problem.loaded.models[i].law.stretches:
            lo, hi = balls.to_bounds(length_ball(problem, i))
            distances[i] = max(distances[i, 0], lo), min(distances[i, 1], hi)
    return tensions, distances


def stability_of(problem: Problem, view: list[Seen], densities: dict[int, arb], is_open: bool) -> Stability:
    """Return whether a pose is a strict minimum of the energy of load and springs.

    The second derivative along a motion (v, omega), dX = v + omega x r, is the sum over the taut cables of
    tension (dX . da/dX dX + a . (omega x (omega x r))), and k (a . dX)^2 of one that stretches; inextensible ones
    leave the motions with a . dX = 0.
    """
    form, rows = arb_mat(6, 6), []
    for i, t in densities.items():
        seen = view[i]
        a, r = seen.direction, seen.arm
        move = _beside(balls.identity(), skew(r) * arb(-1))
        tension = t * seen.path.free
        outer = (a * r.transpose() + r * a.transpose()) * arb(0.5)
        turned = (outer - balls.identity() * balls.dot(a, r)) * tension
        form += move.transpose() * seen.turning * move * tension + _corner(turned)
        pulled = move.transpose() * a
        constant = _spring(problem, i)
        if constant is not None:
            form += pulled * pulled.transpose() * constant
        elif t > 0:
            rows.append(balls.entries(pulled))
    if not all(x.is_finite() for x in form.entries()):
        return Stability.UNDECIDED
    form = (form + form.transpose()) * arb(0.5)
    try:
        reduced = on_kernel(form, arb_mat(rows)) if rows else form
    except ZeroDivisionError:
        return Stability.UNDECIDED
    if reduced is None or positive_definite(reduced):
        return Stability.STABLE
    return Stability.UNSTABLE if not is_open and has_negative_direction(reduced) else Stability.UNDECIDED


def _spring(problem: Problem, i: int) -> arb | None:
    """Return k of a cable of its length; None where it does not stretch."""
    constant = problem.loaded.models[i].law.spring_constant(problem.lengths[i][0])
    return None if constant is None else balls.from_fraction(constant)


def _beside(left: arb_mat, right: arb_mat) -> arb_mat:
    return arb_mat([[left[i, j] for j in range(3)] + [right[i, j] for j in range(3)] for i in range(3)])


def _corner(block: arb_mat) -> arb_mat:
    """Return the (6, 6) matrix with a block in its lower right corner."""
    zero = arb(0)
    rows = [[zero] * 6 for _ in range(3)]
    rows += [[zero] * 3 + [block[i, j] for j in range(3)] for i in range(3)]
    return arb_mat(rows)


def regions(problem: Problem, taut: tuple[int, ...], cells: Floats, reason: str) -> list[Undecided]:
    """Return one entry for each connected cluster of undecided cells."""
    if len(cells) > MOST_CELLS:
        return [_anywhere(problem, taut, cells, reason)]
    found = []
    for group in connected(cells, REAL_COLUMNS.chart):
        chart = int(cells[group[0], REAL_COLUMNS.chart])
        few = cells[group]
        lo, hi = few[:, 0:12:2].min(axis=0), few[:, 1:12:2].max(axis=0)
        box = np.stack([lo, hi], axis=1)
        box = np.concatenate([box, np.zeros((len(taut), 2))])
        pose = pose_of(Root(chart, box, box, box), Frame.plain())
        rotation = np.clip(balls.bounds_array(pose.rotation), -1.0, 1.0).reshape(3, 3, 2)
        found.append(
            Undecided(taut, len(few), reason, balls.bounds_array(origin(problem.robot, pose)), rotation)
        )
    return found


def _anywhere(problem: Problem, taut: tuple[int, ...], cells: Floats, reason: str) -> Undecided:
    """Return one entry for all cells, whatever the rotation."""
    centre = balls.norm(balls.ranges(problem.loaded.centre_ranges))
    lo, hi = cells[:, 6:12:2].min(axis=0), cells[:, 7:12:2].max(axis=0)
    far = balls.to_bounds(centre)[1]
    position = np.stack([np.nextafter(lo - far, -np.inf), np.nextafter(hi + far, np.inf)], axis=1)
    return Undecided(taut, len(cells), reason, position, np.tile(np.array([-1.0, 1.0]), (3, 3, 1)))
