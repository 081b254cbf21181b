"""Entries with cables that are only just tight: which of them are one pose, and what is proved of it.

Where more cables are just tight than carry load, several subsets give roots of their square systems at what
may be one pose, and the searches of larger subsets leave regions around it. They become one entry with the
cables' states as far as they are known; that it holds exactly one pose is proved (``switch``,
``valley``) or said not to be.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.exact.vector import cross, is_zero, minus
from cdpr_interval.mechanics.energy import classify
from cdpr_interval.mechanics.orientation import rotation_from_quaternion
from cdpr_interval.mechanics.six_dof.frame import Pose, upward
from cdpr_interval.mechanics.six_dof.tension_polytope import (
    are_independent,
    tension_bounds,
    tension_rays,
    wrench_matrix,
)
from cdpr_interval.mechanics.stability import Stability
from solvers.answers.data import CableState, Certainty, Nominal, Solution, Undecided
from solvers.questions.problem import Options, Problem
from solvers.six_dof.solution import Geometry, geometry, height, length_ball, nominal, origin
from solvers.six_dof.switch import Switch, platform_size, switch_at
from solvers.six_dof.valley import Floor, Neighbourhood, floor_of

Floats = NDArray[np.float64]

REACHES = (3e-3, 3e-4, 3e-5)
"""Neighbourhoods tried (over the platform's size), the largest first: it takes in more regions."""
BESIDE = 1e-5
"""Neighbourhood in which open entries of which nothing can be proved become one."""
NOT_PROVED = "whether it holds a pose, and one only, depends on which of them carry"


def settle(
    problem: Problem,
    options: Options,
    solutions: Sequence[Solution],
    undecided: Sequence[Undecided],
    complete: bool,
) -> tuple[list[Solution], list[Undecided]]:
    """Put open entries together and say what is proved of them.

    Parameters
    ----------
    solutions, undecided
        What all subsets gave.
    complete : bool
        No cell was left out: every static pose is in an entry or in a region.
    """
    done = [s for s in solutions if not open_cables(s)]
    left = [s for s in solutions if open_cables(s)]
    regions = list(undecided)
    if options.ignore_slack or options.ignore_tension_sign:
        # Each subset is a robot of its own, and whether the others are slack is another question.
        return [*done, *(s if carries(s) else nothing_claimed(problem, s) for s in left)], regions
    while left:
        groups, left, regions = gathered(problem, done, left, regions, complete)
        done += groups
    return done, regions


def carries(entry: Solution) -> bool:
    """Return True when no cable of the entry's own subset is open: those that are open have no tension."""
    return not any(entry.tensions[i].any() for i in open_cables(entry))


def gathered(
    problem: Problem,
    done: Sequence[Solution],
    left: Sequence[Solution],
    regions: Sequence[Undecided],
    complete: bool,
) -> tuple[list[Solution], list[Solution], list[Undecided]]:
    """Return the entry of the first open one and all that is proved to be the same, and what is left.

    No entry where it is one of ``done``.
    """
    first = left[0]
    switch = None if problem.taut is not None else switch_of(problem, first)
    entry = None if switch is None else switched(problem, first, switch)
    near = [] if entry is None else [e for e in done if meet(e, entry)]
    # Over ranges one subset's root may be decided and another's, of the same pose, not.
    known = [e for e in near if switch is not None and is_same(problem, switch, e)]
    if switch is not None and entry is not None and len(near) == len(known):
        return (
            [] if known else [entry],
            [s for s in left[1:] if not switch.holds(rotation_of(s), centre_of(problem, s))],
            [u for u in regions if not switch.holds(rotation_of(u), centre_of(problem, u))],
        )
    if complete:
        for reach in REACHES:
            where = neighbourhood(problem, first, reach)
            if where is None:
                break
            floor = floor_of(where, tight_cables(problem, where.everywhere()))
            if not floor.unique:
                continue
            inside, outside = parted(where, left)
            taken, others = parted(where, regions)
            around: list[Solution | Undecided] = [*outside, *others, *done]
            # The one pose may be anywhere inside: all that is there must be known to be inside or not.
            if not inside or inside[0] is not first or not all(is_apart(where, e) for e in around):
                continue
            return [proved(problem, where, floor, inside, taken)], outside, others
    group, others_left, regions_left = unproved(problem, left, regions)
    return [group], others_left, regions_left


def meet(one: Solution, other: Solution) -> bool:
    """Return True when the bounds of two entries' poses have a pose in common."""
    pairs = ((one.position, other.position), (one.rotation, other.rotation))
    return all(np.all((a[..., 0] <= b[..., 1]) & (b[..., 0] <= a[..., 1])) for a, b in pairs)


def is_same(problem: Problem, switch: Switch, entry: Solution) -> bool:
    """Return True when a proved entry is proved to be the pose of a switch."""
    single = entry.is_proved and entry.family is None
    return single and switch.holds(rotation_of(entry), centre_of(problem, entry))


def switch_of(problem: Problem, entry: Solution) -> Switch | None:
    """Return the proof that an entry is one pose with one cable just taut or just slack, if there is one."""
    if entry.family is not None:
        return None
    rotation, centre = rotation_of(entry), centre_of(problem, entry)
    tight = tight_cables(problem, geometry(problem, Pose(rotation, centre, ())))
    undecided = open_cables(entry)
    if len(undecided) != 1 or not set(undecided) <= set(tight):
        return None
    carrying = tuple(i for i in tight if i not in undecided)
    found = switch_at(problem, carrying, undecided[0], rotation, centre)
    if found is None:
        return None
    # The zero that was found may be another one than the entry's.
    return found if found.holds(rotation, centre) else None


def switched(problem: Problem, entry: Solution, switch: Switch) -> Solution:
    """Return the entry of a pose at which one cable switches."""
    found = described(problem, entry, switch.pose.rotation, switch.pose.centre)
    states = [CableState.SLACK] * len(found.cable_states)
    tensions = np.zeros((len(states), 2))
    for i, t in zip(switch.cables, switch.pose.densities, strict=True):
        states[i] = CableState.SWITCHING if i == switch.switching else CableState.TAUT
        tensions[i] = balls.to_bounds(t * length_ball(problem, i))
    tensions[:, 0] = np.maximum(tensions[:, 0], 0.0)
    return replace(
        found,
        taut=tuple(i for i, state in enumerate(states) if state is CableState.TAUT),
        cable_states=tuple(states),
        tensions=tensions,
        slack_respected=True,
        stability=stability_of(problem, switch),
    )


def stability_of(problem: Problem, switch: Switch) -> Stability:
    """Return the stability of a pose at which one cable switches, for both cases."""
    view = geometry(problem, switch.pose)
    densities = [t.nonnegative_part() for t in switch.pose.densities]
    spokes, arms = [view.spokes[i] for i in switch.cables], [view.arms[i] for i in switch.cables]
    return classify(spokes, arms, densities, [], True)


def rotation_of(entry: Solution | Undecided) -> arb_mat:
    """Return an entry's rotation as balls."""
    return arb_mat([[balls.from_bounds(*pair) for pair in row] for row in entry.rotation.tolist()])


def centre_of(problem: Problem, entry: Solution | Undecided) -> arb_mat:
    """Return an entry's centre of mass as balls, (3, 1)."""
    origin = balls.vector([balls.from_bounds(*pair) for pair in entry.position.tolist()])
    return origin + rotation_of(entry) * balls.ranges(problem.loaded.centre_ranges)


Entry = TypeVar("Entry", Solution, Undecided)


def parted(where: Neighbourhood, entries: Sequence[Entry]) -> tuple[list[Entry], list[Entry]]:
    """Return the entries that are proved to lie in a neighbourhood, and the others."""
    inside: list[Entry] = []
    outside: list[Entry] = []
    for entry in entries:
        is_inside = where.holds(rotation_of(entry), centre_of(where.problem, entry))
        (inside if is_inside else outside).append(entry)
    return inside, outside


def is_apart(where: Neighbourhood, entry: Solution | Undecided) -> bool:
    """Return True when an entry is proved to have no pose in a neighbourhood.

    An entry's family has none: a neighbourhood holds one pose, and in its own family one orbit.
    """
    return where.is_apart(rotation_of(entry), centre_of(where.problem, entry))


def neighbourhood(problem: Problem, entry: Solution, reach: float) -> Neighbourhood | None:
    """Return the neighbourhood of an entry; None for a family whose turning changes any cable's distance."""
    rotation = exact_rotation(entry.nominal.quaternion_wxyz)
    origin = balls.vector([arb(x) for x in entry.nominal.position])
    centre = origin + rotation * balls.ranges(problem.loaded.centre_ranges)
    pose = Pose(rotation, centre, ())
    size = platform_size(problem)
    if entry.family is None:
        return Neighbourhood(problem, pose, reach, size)
    if entry.family.kind != "rotation":
        return None
    if not problem.is_exact:
        return None
    exits, arms = problem.loaded.exits, problem.loaded.arms
    if all(is_zero(cross(minus(a, exits[0]), problem.load)) for a in exits):
        return Neighbourhood(problem, pose, reach, size, upward(problem.loaded.load_direction_ranges))
    if all(b == arms[0] for b in arms):
        return Neighbourhood(
            problem,
            pose,
            reach,
            size,
            upward(problem.loaded.load_direction_ranges),
            balls.fractions(arms[0]),
        )
    return None


def exact_rotation(quaternion: Sequence[float]) -> arb_mat:
    """Return the rotation of a quaternion of any norm, (w, x, y, z), without rounding its entries."""
    w, x, y, z = (arb(float(q)) for q in quaternion)
    norm = w * w + x * x + y * y + z * z
    rows = [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    return arb_mat([[entry / norm for entry in row] for row in rows])


def tight_cables(problem: Problem, view: Geometry) -> list[int]:
    """Return the cables that are not proved slack."""
    return [i for i, d in enumerate(view.distances) if not d < balls.from_fraction(problem.lengths[i][0])]


def unproved(
    problem: Problem, left: Sequence[Solution], regions: Sequence[Undecided]
) -> tuple[Solution, list[Solution], list[Undecided]]:
    """Return an entry for the first open one and all beside it, of which nothing is claimed, and the rest."""
    where = neighbourhood(problem, left[0], BESIDE)
    inside: list[Solution] = []
    if where is not None:
        inside, outside = parted(where, left)
    if where is None or not inside or inside[0] is not left[0]:
        return alone(problem, left[0]), list(left[1:]), list(regions)
    taken, others = parted(where, regions)
    return nothing_claimed(problem, together(problem, where, inside, taken)), outside, others


def alone(problem: Problem, entry: Solution) -> Solution:
    """Return an open entry of which nothing is claimed; a family's states, of all its angles, are kept."""
    if entry.family is not None:
        return nothing_claimed(problem, entry)
    return nothing_claimed(problem, described(problem, entry, rotation_of(entry), centre_of(problem, entry)))


def nothing_claimed(problem: Problem, entry: Solution) -> Solution:
    """Return an entry with neither existence nor uniqueness, and the reason."""
    names = ", ".join(problem.robot.cables[i].name for i in open_cables(entry))
    return replace(
        entry,
        stability=Stability.UNDECIDED,
        existence=Certainty.UNDECIDED,
        uniqueness=Certainty.UNDECIDED,
        note=joined(entry.note, f"cables {{{names}}} only just tight: {NOT_PROVED}"),
    )


def proved(
    problem: Problem,
    where: Neighbourhood,
    floor: Floor,
    inside: Sequence[Solution],
    taken: Sequence[Undecided],
) -> Solution:
    """Return the one entry of a neighbourhood with at most one static pose: the hull of all that is there."""
    found = replace(together(problem, where, inside, taken), stability=Stability.STABLE)
    # A subset asked for: the pose may be one of other cables.
    if floor.exists and problem.taut is None:
        return found
    reason = "there are not two poses here; whether there is one is not proved"
    return replace(found, existence=Certainty.UNDECIDED, note=joined(found.note, reason))


def together(
    problem: Problem, where: Neighbourhood, inside: Sequence[Solution], taken: Sequence[Undecided]
) -> Solution:
    """Return one entry in the hull of some that lie in a neighbourhood."""
    everything: list[Solution | Undecided] = [*inside, *taken]
    poses = [where.nearest(rotation_of(e), centre_of(problem, e)) for e in everything]
    rotation, centre = (joint([pose[k] for pose in poses]) for k in (0, 1))
    found = described(problem, inside[0], rotation, centre)
    if found.family is None or where.pivot is None:
        return found
    point = balls.bounds_array(where.point_of(rotation, centre))
    return replace(found, family=replace(found.family, axis_point=point))


def joint(matrices: Sequence[arb_mat]) -> arb_mat:
    """Return the hull of matrices, entry by entry."""
    found = matrices[0]
    for other in matrices[1:]:
        pairs = zip(found.entries(), other.entries(), strict=True)
        found = arb_mat(found.nrows(), found.ncols(), [a.union(b) for a, b in pairs])
    return found


def described(problem: Problem, entry: Solution, rotation: arb_mat, centre: arb_mat) -> Solution:
    """Return an entry for poses in these bounds, whichever of the cables that are not slack carry."""
    pose = Pose(rotation, centre, ())
    view = geometry(problem, pose)
    states = [CableState.SLACK] * len(problem.robot.cables)
    for i in tight_cables(problem, view):
        states[i] = CableState.UNDECIDED
    tight = [i for i in tight_cables(problem, view) if problem.taut is None or i in problem.taut]
    load = balls.ranges(problem.loaded.load_ranges)
    size = platform_size(problem)
    matrix = wrench_matrix([view.spokes[i] for i in tight], [view.arms[i] for i in tight], load, size)
    rays = tension_rays(matrix)
    tensions = np.zeros((len(states), 2))
    bounds = None if rays is None or not rays.parts else tension_bounds(matrix, rays)
    for k, i in enumerate(tight):
        if bounds is not None and rays is not None and rays.always(k):
            states[i] = CableState.TAUT
        tensions[i] = tension_of(problem, i, None if bounds is None else bounds[k])
    distances = np.array([balls.to_bounds(d) for d in view.distances])
    position = balls.bounds_array(origin(problem.robot, pose))
    turned = np.clip(balls.bounds_array(rotation), -1.0, 1.0).reshape(3, 3, 2)
    return replace(
        entry,
        taut=tuple(i for i, state in enumerate(states) if state is CableState.TAUT),
        cable_states=tuple(states),
        position=position,
        rotation=turned,
        height=height(problem.robot, centre),
        tensions=tensions,
        distances=distances,
        slack_respected=None if CableState.UNDECIDED in states else True,
        nominal=entry.nominal if is_inside(entry.nominal, position, turned) else nominal(problem.robot, pose),
        note=unique_note(problem, matrix, tight, bounds),
    )


def is_inside(nominal: Nominal, position: Floats, rotation: Floats) -> bool:
    """Return True when a pose in plain floats lies in bounds; the middle of wide ones need be no rotation."""
    matrix = rotation_from_quaternion(nominal.quaternion_wxyz)
    inside = ((np.array(nominal.position), position), (matrix, rotation))
    return all(bool(np.all((b[..., 0] <= a) & (a <= b[..., 1]))) for a, b in inside)


def tension_of(problem: Problem, i: int, bounds: tuple[arb, arb | None] | None) -> tuple[float, float]:
    """Return the bounds of a tension in N; infinite where none is known."""
    if bounds is None:
        return 0.0, np.inf
    low, high = bounds
    length = length_ball(problem, i)
    least = max(0.0, balls.to_bounds(low * length)[0])
    return least, np.inf if high is None else balls.to_bounds(high * length)[1]


def unique_note(
    problem: Problem,
    matrix: arb_mat,
    tight: Sequence[int],
    bounds: Sequence[tuple[arb, arb | None]] | None,
) -> str:
    """Return what to say of the tensions where the wrenches may be dependent."""
    if are_independent(matrix):
        return ""
    names = ", ".join(problem.robot.cables[i].name for i in tight)
    text = f"cables {{{names}}} tight, tensions not unique"
    if bounds is not None and any(high is None for _, high in bounds):
        text += " and without an upper bound: the cables can pull against each other (prestress)"
    return text


def open_cables(entry: Solution) -> list[int]:
    """Return the cables that may be taut or slack."""
    return [i for i, state in enumerate(entry.cable_states) if state is CableState.UNDECIDED]


def joined(*notes: str) -> str:
    """Return notes as one sentence."""
    return "; ".join(note for note in notes if note)
