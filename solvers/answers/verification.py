"""What can be wrong with a result, found without a solver: exact rational interval arithmetic.

Every check is a necessary condition: two enclosures of one quantity must have a point in common.
The arithmetic is on `Fraction`, so no rounding enters and no complaint is a rounding error.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import pairwise

from cdpr_interval.errors import NotSupportedError
from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.exact.irrational import root_bounds
from cdpr_interval.exact.range import Range, as_range, hull_of
from cdpr_interval.mechanics.cables.law import end_laws, model_of
from cdpr_interval.mechanics.cables.path import Balls, OffTheCable
from cdpr_interval.robots.cable_robot import Cable, Robot
from cdpr_interval.robots.numbers import Point
from cdpr_interval.text.count import counted
from solvers.answers.consistency import claims, contradictions
from solvers.answers.data import CableState, Outcome, ResultData, Solution, StopReason
from solvers.answers.fields import FloatOrRange
from solvers.answers.order import solution_key

NOUGHT = Range.exact(0)
ANY_SQUARE = Range(Fraction(0), Fraction(10) ** 600)

NOMINAL_MARGIN = 1e-6
"""How far (relative to 1 + the box's width) the uncertified nominal pose may lie outside its box."""


def complaints(result: ResultData, robot: Robot | None) -> list[str]:
    """Return every contradiction in the result; see `solvers.answers.result.Result.verify`."""
    found = list(_bookkeeping(result))
    if robot is not None:
        found += _identity(result, robot)
    for number, solution in enumerate(result.solutions):
        own = list(_solution(result, solution))
        if not own and robot is not None and len(robot.cables) == len(result.cables):
            own = list(_mechanics(result, solution, robot))
        found += [f"solutions[{number}]: {text}" for text in own]
    return found


def _bookkeeping(result: ResultData) -> Iterator[str]:
    finished = not (
        result.undecided
        or result.pending
        or result.stop_reason is not StopReason.EXHAUSTED
        or not all(solution.is_decided for solution in result.solutions)
    )
    if finished != (result.outcome is Outcome.COMPLETE):
        yield f"outcome: '{result.outcome}' contradicts what is undecided, pending or cut short"
    if any(subset.outcome is Outcome.INCOMPLETE for subset in result.subsets) and finished:
        yield "outcome: 'complete' although a subset is incomplete"
    if any(solution_key(a) > solution_key(b) for a, b in pairwise(result.solutions)):
        yield "solutions: not in the order stability, height, taut, position"
    least = 0.0 if result.question.tensions_given is None else -1.0
    if not _ordered(result.lengths) or not (result.lengths[:, 0] > least).all():
        yield "lengths_m: not all positive ranges"
    if len(result.lengths) != len(result.cables):
        yield f"lengths_m: {counted(len(result.lengths), 'range')} for {counted(len(result.cables), 'cable')}"
    asked = result.question.taut
    for number, solution in enumerate(result.solutions):
        if asked is not None and not set(solution.taut) <= set(asked):
            yield f"solutions[{number}]: taut cables outside the subset that was asked for"
    origin = result.provenance
    if origin is not None and origin.robot.sha256 != result.robot.sha256:
        yield "provenance: holds another robot than the one that is named (its digest differs)"
    yield from contradictions(result)


def _identity(result: ResultData, robot: Robot) -> Iterator[str]:
    if not result.is_about(robot):
        yield f"robot: the result is about another file ({result.robot.name}, this is {robot.name})"
    if result.cables != robot.cable_names:
        yield "cables: not the cables of this robot"
    if result.model != robot.model:
        yield f"model: '{result.model}', but this robot is a {robot.model}"


def _solution(result: ResultData, solution: Solution) -> Iterator[str]:
    """Check one entry against itself."""
    boxes = {
        "position_m": solution.position,
        "rotation": solution.rotation,
        "height_m": solution.height,
        "tensions_N": solution.tensions,
        "distances_m": solution.distances,
    }
    bad = [name for name, box in boxes.items() if not _ordered(box)]
    if bad:
        yield f"{bad[0]}: not ranges lo <= hi of numbers"
        return
    taut = tuple(i for i, state in enumerate(solution.cable_states) if state is CableState.TAUT)
    if taut != solution.taut:
        yield "taut: not the cables whose state is 'taut'"
    signed = not result.question.ignore_tension_sign
    for i, state in enumerate(solution.cable_states):
        lo, hi = solution.tensions[i]
        if state is CableState.TAUT and signed and not hi > 0.0:
            yield f"tensions_N[{i}]: not positive although the cable is taut"
        if state is CableState.SLACK and (lo != 0.0 or hi != 0.0):
            yield f"tensions_N[{i}]: not zero although the cable is slack"
        if state is not CableState.TAUT and solution.slack_respected and _far(result, solution, i):
            yield f"distances_m[{i}]: longer than the cable although slackness is respected"
    yield from claims(result, solution)
    yield from _orthogonality(solution.rotation)
    yield from _nominal(solution)


def _far(result: ResultData, solution: Solution, cable: int) -> bool:
    """Return whether a cable without tension is certainly too short to reach its anchor."""
    return solution.tensions[cable, 1] <= 0.0 and bool(
        solution.distances[cable, 0] > result.lengths[cable, 1]
    )


def _ordered(bounds: Bounds) -> bool:
    return bool((bounds[..., 0] <= bounds[..., 1]).all())


def _orthogonality(rotation: Bounds) -> Iterator[str]:
    rows = [[_interval(rotation[i, j]) for j in range(3)] for i in range(3)]
    for i in range(3):
        for j in range(i, 3):
            if int(i == j) not in _dot(rows[i], rows[j]):
                yield f"rotation: rows {i} and {j} are not orthonormal"
    if 1 not in _dot(rows[0], _cross(rows[1], rows[2])):
        yield "rotation: the determinant is not 1"


def _nominal(solution: Solution) -> Iterator[str]:
    nominal = solution.nominal
    if _outside(solution.position, nominal.position):
        yield "nominal: position outside position_m"
    w, x, y, z = nominal.quaternion_wxyz
    from_quaternion = (
        (w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )
    (sr, sp, sy), (cr, cp, cy) = (tuple(f(a) for a in nominal.rpy) for f in (math.sin, math.cos))
    from_angles = (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )
    for name, matrix in (("quaternion_wxyz", from_quaternion), ("rpy_rad", from_angles)):
        if any(_outside(solution.rotation[i], matrix[i]) for i in range(3)):
            yield f"nominal: {name} outside rotation"


def _outside(bounds: Bounds, values: Iterable[float]) -> bool:
    """Return whether a value is further outside its range than the nominal pose may be."""
    return not all(
        lo - _margin(lo, hi) <= value <= hi + _margin(lo, hi)
        for (lo, hi), value in zip(bounds.tolist(), values, strict=True)
    )


def _margin(lo: float, hi: float) -> float:
    return NOMINAL_MARGIN * (1.0 + hi - lo)


def _mechanics(result: ResultData, solution: Solution, robot: Robot) -> Iterator[str]:
    """Check distances, height, taut lengths and the equilibrium over the solution's box."""
    rotation = [[_interval(solution.rotation[i, j]) for j in range(3)] for i in range(3)]
    origin = [_interval(x) for x in solution.position]

    def in_base(vector: Sequence[Range]) -> list[Range]:
        return [_dot(row, vector) for row in rotation]

    inside = _ranges(robot.platform.centre_of_mass)
    arm = in_base(inside)
    centre = [p + a for p, a in zip(origin, arm, strict=True)]
    yield from _height(solution, robot, centre)
    mass = as_range(robot.platform.mass)
    force = [_force(component) for component in result.question.external_force]
    load = [mass * g + f for g, f in zip(_ranges(robot.gravity), force, strict=True)]
    wrench = [*load, NOUGHT, NOUGHT, NOUGHT]
    for i, cable in enumerate(robot.cables):
        r = in_base([b - g for b, g in zip(_ranges(cable.platform_anchor), inside, strict=True)])
        anchor = [p + x for p, x in zip(centre, r, strict=True)]
        distance, tension = _interval(solution.distances[i]), _interval(solution.tensions[i])
        away, square = _way(cable, robot, anchor)
        if distance.lo < 0 or not square.meets(distance * distance):
            what = (
                "distance from the exit point"
                if cable.pulley is None
                else "length of the way over the pulley"
            )
            yield f"distances_m[{i}]: not the {what}"
            return
        length = _interval(result.lengths[i])
        stretch = hull_of(law.stretch(length, tension, Range.exact) for law in end_laws(cable))
        if solution.cable_states[i] is CableState.TAUT and not distance.meets(length + stretch):
            yield f"distances_m[{i}]: not the length of the taut cable"
        if tension.lo == tension.hi == 0:
            continue
        if away is None:
            # Nothing bounds the direction of a cable whose box touches its exit point or its pulley.
            return
        wrench = [
            total + tension * part for total, part in zip(wrench, [*away, *_cross(r, away)], strict=True)
        ]
    axes = ("force x", "force y", "force z", "moment x", "moment y", "moment z")
    for axis, total in zip(axes, wrench, strict=True):
        if 0 not in total:
            yield f"tensions_N: no equilibrium over the box ({axis})"


def _way(cable: Cable, robot: Robot, anchor: list[Range]) -> tuple[list[Range] | None, Range]:
    """Return the unit vector along a cable from its anchor, where it is bounded, and its squared length."""
    if cable.pulley is not None:
        return _way_over_pulley(cable, robot, anchor)
    e = [a - x for a, x in zip(_ranges(cable.frame_anchor), anchor, strict=True)]
    square = sum((x.squared() for x in e), NOUGHT)
    lo, hi = root_bounds(square.lo)[0], root_bounds(square.hi)[1]
    return None if lo == 0 else [x / Range(lo, hi) for x in e], square


def _way_over_pulley(cable: Cable, robot: Robot, anchor: list[Range]) -> tuple[list[Range] | None, Range]:
    """Return what `_way` does, in balls; what holds of any way where numbers of the pulley are ranges."""
    try:
        with balls.precision():
            x, y, z = map(balls.from_range, anchor)
            path = model_of(cable, robot.gravity).route.path((x, y, z), Balls())
            known = [-u for u in path.direction], path.length * path.length
            if not all(u.is_finite() for u in (*known[0], known[1])):
                return None, ANY_SQUARE
            return [balls.to_range(u) for u in known[0]], balls.to_range(known[1])
    except (OffTheCable, NotSupportedError):
        return None, ANY_SQUARE


def _height(solution: Solution, robot: Robot, centre: Sequence[Range]) -> Iterator[str]:
    # Up is opposite to gravity; h |g| = -g . centre is compared squared-free by clearing the norm.
    gravity = _ranges(robot.gravity)
    along = -_dot(gravity, centre)
    square = sum((g.squared() for g in gravity), NOUGHT)
    lo, hi = (Fraction(math.sqrt(end)) for end in square)
    if not along.meets(_interval(solution.height) * Range(lo - lo / 2**48, hi + hi / 2**48)):
        yield "height_m: not the height of the centre of mass"


def _ranges(point: Point) -> list[Range]:
    return [as_range(x) for x in point]


def _force(component: FloatOrRange) -> Range:
    """Return a recorded force: the nearest double, of which half a unit in the last place may be missing."""
    ends = component if isinstance(component, tuple) else (component, component)
    lo, hi = map(Fraction, ends)
    return Range(lo - abs(lo) / 2**52, hi + abs(hi) / 2**52)


def _interval(bounds: Bounds) -> Range:
    """Return the exact interval; an infinite bound becomes one no computation here reaches."""
    lo, hi = (max(-1e300, min(1e300, float(x))) for x in bounds)
    return Range(Fraction(lo), Fraction(hi))


def _dot(a: Sequence[Range], b: Sequence[Range]) -> Range:
    return sum((x * y for x, y in zip(a, b, strict=True)), NOUGHT)


def _cross(a: Sequence[Range], b: Sequence[Range]) -> list[Range]:
    return [a[j] * b[k] - a[k] * b[j] for j, k in ((1, 2), (2, 0), (0, 1))]
