"""The static pose of a point mass for given tensions instead of lengths (Merlet 2012, IV.C).

The pose is where V(C) = sum tau_i |C - A_i| - f . C is stationary. V is convex, and strictly so unless all
exit points lie on one line; then along that line only, which holds a stationary point only if the load is
along it too. So there is **one pose at most** unless the exit points lie on a line along the load. With sum
tau_i < |f| there is none. With sum tau_i > |f| V grows in all directions and has a minimum: a pose, unless
it lies in an exit point A_i, just where |sum_(j != i) tau_j u_j - f| <= tau_i, u_j being the unit vectors
from A_j.
"""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb, arb_mat, fmpq, fmpq_mat
from numpy.typing import NDArray

from cdpr_interval.errors import InputError, NotSupportedError
from cdpr_interval.exact import balls
from cdpr_interval.exact.range import as_range
from cdpr_interval.exact.vector import Vector, is_zero
from cdpr_interval.mechanics.cables.law import end_laws
from cdpr_interval.mechanics.loaded import LoadedRobot, loaded
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.given import require_robot
from cdpr_interval.robots.numbers import Point
from solvers.answers.data import (
    Answer,
    CableState,
    Certainty,
    Nominal,
    Proof,
    Solution,
    Undecided,
)
from solvers.answers.result import Result
from solvers.classes import require_supported
from solvers.forward import build_result
from solvers.point_mass import scope as point_mass
from solvers.point_mass.entry import IDENTITY
from solvers.questions.checked import on_legs, over_pulleys, require_treated
from solvers.questions.errors import InputErrors
from solvers.questions.force import ZERO, no_load, read_force_ranges
from solvers.questions.lengths import read_lengths
from solvers.questions.problem import Options, Problem
from solvers.questions.subset import read_subset
from solvers.questions.units import NEWTONS

Floats = NDArray[np.float64]
STEPS = 200
"""Most damped Newton steps from the start to the minimum."""
MOST_PARTS, MOST_PARTS_OF_DATA = 2000, 60
"""Parts into which ranges of tensions are cut at most; with ranges of other data, of which there are many."""
NARROW = 2.0**-40
"""Ranges of a smaller share of the largest number of their kind are not cut."""
WIDENINGS = 12
"""Boxes tried around a guess, each larger by half."""


@dataclass(frozen=True)
class TensionProblem:
    """A point mass whose cables ``chosen`` have tensions in given ranges (N); the others carry nothing."""

    robot: Robot
    chosen: tuple[int, ...]
    tensions: tuple[tuple[Fraction, Fraction], ...]
    external_force: Point

    @property
    def loaded(self) -> LoadedRobot:
        """The robot under its weight and the external force, kept between questions."""
        return loaded(self.robot, self.external_force)

    @property
    def load(self) -> Vector:
        """The force f on the mass, N, base axes."""
        return self.loaded.load


def tension_problem(
    robot: Robot | str | os.PathLike[str], tensions: Any, taut: Any = None, external_force: Any = None
) -> TensionProblem:
    """Return the checked question; ``tensions`` are written as lengths are, those of the taut cables."""
    robot, errors = require_robot(robot), InputErrors()
    names = robot.cable_names
    chosen = tuple(range(len(names))) if taut is None else errors.read(read_subset, taut, names, "taut")
    force = ZERO if external_force is None else errors.read(read_force_ranges, external_force) or ZERO
    ranges = None
    if chosen is not None:
        ranges = errors.read(read_tensions, tensions, [names[i] for i in chosen])
    errors.require_none()
    assert chosen is not None and ranges is not None
    require_treated(robot, on_legs(robot, "given tensions"))
    if not point_mass.accepts(robot):
        raise NotSupportedError(
            f"robot '{robot.name}': given tensions are for point masses, this is a platform"
        )
    require_treated(robot, over_pulleys(robot, "given tensions"))
    require_supported(robot)
    problem = TensionProblem(robot, chosen, ranges, force)
    if (complaint := no_load(problem.loaded)) is not None:
        errors.add(complaint)
    errors.require_none()
    return problem


def read_tensions(given: Any, names: Sequence[str]) -> tuple[tuple[Fraction, Fraction], ...]:
    """Return one exact range in N per cable, with the errors of `read_lengths` in the words of tensions."""
    try:
        return read_lengths(given, names, "tensions", NEWTONS)
    except InputError as error:
        lines = [line.replace(" lengths for ", " tensions for ") for line in error.messages]
        raise InputError(*lines) from None


def pose_from_tensions(
    robot: Robot | str | os.PathLike[str], tensions: Any, *, taut: Any = None, external_force: Any = None
) -> Result:
    """Find and prove the static pose of a point mass whose tensions are known instead of its lengths.

    Parameters
    ----------
    robot : Robot, str or PathLike
        A point mass, its file or name; elastic or not, since its lengths do not matter.
    tensions : sequence, mapping or str
        One positive tension in N for each cable of ``taut``, written as lengths are: numbers or ranges.
    taut : iterable of str or int, optional
        The cables that carry; default: all.
    external_force : sequence of 3 numbers, optional
        N, base axes.

    Returns
    -------
    Result
        One solution (proof ``convexity``), none, or an undecided region. ``question.tensions_given``
        holds the tensions, ``lengths`` the lengths that follow.

    Examples
    --------
    >>> (pose,) = pose_from_tensions("merlet_4_1", [300, 300, 300, 300]).solutions
    >>> [round(x, 3) for x in pose.nominal.position]
    [2.0, 2.0, -2.445]
    """
    return solve_tensions(tension_problem(robot, tensions, taut, external_force))


def solve_tensions(problem: TensionProblem) -> Result:
    """Find and prove the static pose for given tensions.

    Guarantee: with outcome COMPLETE there is exactly one pose for every choice of the tensions, and of data
    that are ranges, in the only solution's box, or none for any choice.
    """
    start = time.perf_counter()
    with balls.precision():
        answer = answered(problem)
    whole = Problem(problem.robot, (), problem.external_force, problem.chosen)
    options = Options()
    result = build_result(whole, options, answer, time.perf_counter() - start)
    return with_tensions(result, problem)


def answered(problem: TensionProblem) -> Answer:
    """Return the pose, that there is none, or that this is open."""
    load = vector_of(problem.loaded.load_ranges)
    tensions = [balls.from_fraction(lo).union(balls.from_fraction(hi)) for lo, hi in problem.tensions]
    size, total = balls.norm(load), sum(tensions, arb(0))
    if total < size:
        return Answer((), message="no static pose: the tensions together are less than the load")
    if on_a_line_along_the_load(problem):
        return undecided(
            problem, "the exit points lie on a line along the load: tensions do not fix the pose"
        )
    exits = exits_of(problem)
    if total > size:
        for k, exit_point in enumerate(exits):
            others = [(t, a) for j, (t, a) in enumerate(zip(tensions, exits, strict=True)) if j != k]
            if all(balls.norm(exit_point - a) > 0 for _, a in others):
                pull = sum((((exit_point - a) * (t / balls.norm(exit_point - a))) for t, a in others), -load)
                if balls.norm(pull) < tensions[k]:
                    name = problem.robot.cable_names[problem.chosen[k]]
                    return Answer(
                        (), message=f"no static pose: the cables would pull the mass into the exit of {name}"
                    )
    most = MOST_PARTS if problem.loaded.is_exact else MOST_PARTS_OF_DATA
    proved = enclosed(exits, tensions, load, most)
    if proved is None:
        return undecided(problem, "no box around the lowest point could be proved")
    return Answer((entry(problem, proved, tensions),))


def vector_of(point: Point) -> arb_mat:
    """Return a point of numbers and ranges as a column of balls."""
    ends = map(as_range, point)
    return balls.vector([balls.from_fraction(lo).union(balls.from_fraction(hi)) for lo, hi in ends])


def exits_of(problem: TensionProblem) -> list[arb_mat]:
    """Return the exit points of the chosen cables, of ranges all choices."""
    return [vector_of(problem.robot.cables[i].frame_anchor) for i in problem.chosen]


def on_a_line_along_the_load(problem: TensionProblem) -> bool:
    """Return True where all exit points lie on one line parallel to the load (one point: always).

    Only where that is so for every choice: of ranges of directions it is not.
    """
    spread, middle = problem.loaded.spread, problem.loaded.middle
    if not (spread.points_are_exact and is_zero(spread.load)):
        return len(problem.chosen) == 1
    first, *others = [middle.exits[i] for i in problem.chosen]
    rows = [[fmpq(*(x - y).as_integer_ratio()) for x, y in zip(a, first, strict=True)] for a in others]
    rows.append([fmpq(*x.as_integer_ratio()) for x in middle.load])
    return bool(fmpq_mat(rows).rank() == 1)


def undecided(problem: TensionProblem, reason: str) -> Answer:
    """Return an answer that leaves everything open."""
    everywhere = np.tile([-np.inf, np.inf], (3, 1))
    return Answer((), undecided=(Undecided(problem.chosen, 1, reason, everywhere, IDENTITY),), message=reason)


def enclosed(exits: Sequence[arb_mat], tensions: list[arb], load: arb_mat, most: int) -> arb_mat | None:
    """Return a box of the poses for every choice; ranges are halved where they are too wide."""
    found: list[arb_mat] = []
    waiting = [Choice(list(exits), tensions, load)]
    while waiting:
        part = waiting.pop()
        box = enclosure(part.exits, part.tensions, part.load)
        if box is not None:
            found.append(box)
            continue
        if len(found) + len(waiting) > most or (halves := part.halves()) is None:
            return None
        waiting += halves
    first, *others = found
    for other in others:
        first = arb_mat([[a.union(b)] for a, b in zip(first.entries(), other.entries(), strict=True)])
    return first


@dataclass(frozen=True, eq=False)
class Choice:
    """A box of choices: exit points, tensions and load."""

    exits: list[arb_mat]
    tensions: list[arb]
    load: arb_mat

    def halves(self) -> list[Choice] | None:
        """Return the two halves, cut where the range is widest for its size; None where all are narrow."""
        size = max(float(balls.norm(self.load).upper()), *(float(t.upper()) for t in self.tensions))
        span = max(float(abs(x).upper()) for a in self.exits for x in a.entries()) or 1.0
        flat = [x for a in self.exits for x in a.entries()]
        numbers = [*flat, *self.tensions, *self.load.entries()]
        scales = [span] * len(flat) + [size] * (len(self.tensions) + 3)
        shares = [float(x.rad()) / scale for x, scale in zip(numbers, scales, strict=True)]
        widest = max(range(len(numbers)), key=shares.__getitem__)
        if shares[widest] < NARROW:
            return None
        lo, hi = balls.to_range(numbers[widest])
        middle = balls.from_fraction((lo + hi) / 2)
        found = []
        for end in (lo, hi):
            half = [*numbers]
            half[widest] = balls.from_fraction(end).union(middle)
            points = [balls.vector(half[3 * i : 3 * i + 3]) for i in range(len(self.exits))]
            pulls, load = half[len(flat) : -3], balls.vector(half[-3:])
            found.append(Choice(points, pulls, load))
        return found


def gradient(
    exits: Sequence[arb_mat], tensions: Sequence[arb], load: arb_mat, c: arb_mat
) -> tuple[arb_mat, arb_mat]:
    """Return the gradient and the Hessian of V at (or over) C."""
    slope, bend = -load, arb_mat(3, 3)
    for a, t in zip(exits, tensions, strict=True):
        e = c - a
        rho = balls.norm(e)
        slope += e * (t / rho)
        bend += (balls.identity() - e * e.transpose() * (1 / (rho * rho))) * (t / rho)
    return slope, bend


def enclosure(exits: Sequence[arb_mat], tensions: Sequence[arb], load: arb_mat) -> arb_mat | None:
    """Return a box in which V has exactly one stationary point for every choice of tensions, or None."""
    guess = lowest(exits, tensions, load)
    if guess is None:
        return None
    c = arb_mat([[float(v)] for v in guess])
    points, pulls, force = [a.mid() for a in exits], [t.mid() for t in tensions], load.mid()
    try:
        for _ in range(8):
            slope, bend = gradient(points, pulls, force, c)
            c = (c - bend.mid().solve(slope.mid())).mid()
        slope, bend = gradient(points, pulls, force, c)
        inverse = bend.mid().inv().mid()
        # What one number does to the three components stays together.
        step = inverse * slope + inverse * (force - load)
        for a, t, a0, t0 in zip(exits, tensions, points, pulls, strict=True):
            e = c - a
            rho = balls.norm(e)
            step += inverse * e * ((t - t0) / rho)
            turn = inverse * (balls.identity() - e * e.transpose() * (1 / (rho * rho)))
            step += turn * (a0 - a) * (t0 / rho)
        reach = [
            2 * abs(v).upper() + (1 + abs(w)).mid() * arb(2) ** -100
            for v, w in zip(step.entries(), c.entries(), strict=True)
        ]
        for _ in range(WIDENINGS):
            box = arb_mat([[r.mid().union(-r.mid())] for r in reach])
            moved = (balls.identity() - inverse * gradient(exits, tensions, load, c + box)[1]) * box - step
            if all(abs(m) < r.mid() for m, r in zip(moved.entries(), reach, strict=True)):
                return c + moved
            reach = [1.5 * abs(m).upper() for m in moved.entries()]
            if not all(r.is_finite() for r in reach):
                return None
    except ZeroDivisionError:
        pass
    return None


def lowest(exits: Sequence[arb_mat], tensions: Sequence[arb], load: arb_mat) -> Floats | None:
    """Return a point near the minimum of V in plain floats, or None."""
    a = np.array([balls.middle(v).ravel() for v in exits])
    t = np.array([float(v.mid()) for v in tensions])
    f = balls.middle(load).ravel()
    span = float(np.ptp(a, axis=0).max()) or 1.0

    def value(c: Floats) -> float:
        return float(t @ np.linalg.norm(c - a, axis=1) - f @ c)

    c = a.mean(axis=0) + span * f / np.linalg.norm(f)
    for _ in range(STEPS):
        e = c - a
        rho = np.linalg.norm(e, axis=1)
        if not rho.all():
            return None
        u = e / rho[:, None]
        slope = t @ u - f
        bend = np.einsum("i,ijk->jk", t / rho, np.eye(3) - u[:, :, None] * u[:, None, :])
        step = np.linalg.solve(bend + 1e-14 * np.trace(bend) * np.eye(3), slope)
        share = 1.0
        while share > 1e-12 and value(c - share * step) > value(c) - 1e-4 * share * float(slope @ step):
            share *= 0.5
        c = c - share * step
        if np.abs(step).max() <= 1e-14 * span or share <= 1e-12:
            break
    return c if np.isfinite(c).all() else None


def height(robot: Robot, c: arb_mat) -> arb:
    """Return how high a point is, against gravity."""
    gravity = vector_of(robot.gravity)
    return -balls.dot(c, gravity) / balls.norm(gravity)


def entry(problem: TensionProblem, c: arb_mat, tensions: Sequence[arb]) -> Solution:
    """Return the pose as results list it."""
    count = len(problem.robot.cables)
    pulls, distances = np.zeros((count, 2)), np.zeros((count, 2))
    for i, cable in enumerate(problem.robot.cables):
        distances[i] = balls.to_bounds(balls.norm(c - vector_of(cable.frame_anchor)))
    for i, t in zip(problem.chosen, tensions, strict=True):
        pulls[i] = balls.to_bounds(t)
    position = balls.bounds_array(c)
    x, y, z = position.mean(axis=1).tolist()
    return Solution(
        taut=problem.chosen,
        cable_states=tuple(
            CableState.TAUT if i in problem.chosen else CableState.SLACK for i in range(count)
        ),
        position=position,
        rotation=IDENTITY,
        height=np.array(balls.to_bounds(height(problem.robot, c))),
        tensions=pulls,
        distances=distances,
        slack_respected=True,
        existence=Certainty.PROVED,
        uniqueness=Certainty.PROVED,
        proof=Proof.CONVEXITY,
        stability=Stability.STABLE,
        nominal=Nominal((x, y, z), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        family=None,
        note="tensions are given; a cable outside them carries nothing, whatever its length",
    )


def with_tensions(result: Result, problem: TensionProblem) -> Result:
    """Return the result with the tensions in its question, and the lengths that follow."""
    given = np.zeros((len(problem.robot.cables), 2))
    for i, (lo, hi) in zip(problem.chosen, problem.tensions, strict=True):
        given[i] = balls.to_bounds(balls.from_fraction(lo))[0], balls.to_bounds(balls.from_fraction(hi))[1]
    lengths = np.tile([0.0, np.inf], (len(problem.robot.cables), 1))
    with balls.precision():
        for solution in result.solutions:
            for i in problem.chosen:
                rho, tau = (balls.from_bounds(*row) for row in (solution.distances[i], solution.tensions[i]))
                laws = end_laws(problem.robot.cables[i])
                ends = [balls.to_bounds(law.unstretched(rho, tau, balls.from_fraction)) for law in laws]
                lengths[i] = min(lo for lo, _ in ends), max(hi for _, hi in ends)
    question = replace(result.question, tensions_given=tuple((lo, hi) for lo, hi in given.tolist()))
    return replace(result, lengths=lengths, question=question)
