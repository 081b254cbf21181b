"""The certificate's entry "point" of a subset whose taut cables all end in one point, or of a point mass.

The checker's own functions try each proof before it is written: what it would refuse is left pending.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import combinations, product
from typing import Any

import numpy as np
from flint import arb, arb_mat, ctx, fmpq

from cdpr_interval.exact.enclosure import Bounds, length_bounds
from cdpr_interval.mechanics.loaded import loaded
from cdpr_interval.robots.cable_robot import Cable, Platform, Robot
from certificates import newton
from certificates.arithmetic.balls import BITS, column, minus
from certificates.families import check_one_point_family
from certificates.point_mass import System, check_point
from certificates.problem import Problem as Question
from certificates.verdicts import Malformed, NotProved
from solvers.answers.data import CableState, Solution
from solvers.point_mass import scope as point_mass
from solvers.point_mass.arrays import RobotArrays, robot_arrays
from solvers.point_mass.convex import NoPose, Unproved, find_pose, part_of
from solvers.point_mass.entry import Fields
from solvers.point_mass.rationals.emptiness import deepest_point
from solvers.proofs.listed import WIDENED, certificate_question, fraction, listed_solution, wider
from solvers.questions.problem import Options, Problem

Json = dict[str, Any]
MOST_PIECES = 64
"""Most parts into which ranges of lengths are cut, as many as the solver uses."""
STEP_BITS = range(140, 20, -10)
"""Steps 2^-k from the pose towards the deepest point that are tried to get strictly inside all balls."""
HOPELESS = "no proof of the lowest point passes the checker"


def point_entry(problem: Problem, options: Options, taut: Sequence[int], solutions: list[Solution]) -> Json:
    """Return the entry of a subset, or ``{"pending": reason}`` where the checker would not accept a proof.

    Parameters
    ----------
    problem, options
        The question.
    taut
        The subset; for a point mass without ``ignore_slack`` the one asked for, or all cables.
    solutions
        As listed in the certificate, in its order, `widened`.
    """
    question = certificate_question(problem, options)
    listed = [listed_solution(s) for s in solutions]
    everything = tuple(range(len(problem.robot.cables)))
    cables = tuple(taut) if options.ignore_slack or not point_mass.accepts(problem.robot) else everything
    writer = Writer(problem, cables)
    check = check_point if point_mass.accepts(problem.robot) else check_one_point_family

    def accepts(poses: list[int | None], part: Question, proof: Json) -> bool:
        """Return whether the checker accepts an entry."""
        try:
            check(part, taut, {"poses": poses, "proof": proof}, listed)
        except (NotProved, Malformed):
            return False
        return True

    with ctx.workprec(BITS):
        for poses in choices(problem, options, writer, solutions):
            proof = writer.proof(question, partial(accepts, poses), [MOST_PIECES])
            if proof is not None:
                return {"poses": poses, "proof": proof}
    return {"pending": HOPELESS}


def choices(
    problem: Problem, options: Options, writer: Writer, solutions: list[Solution]
) -> Iterator[list[int | None]]:
    """Yield what an entry may point to, likely ones first."""
    if point_mass.accepts(problem.robot):
        if not options.ignore_slack:
            yield [0] if solutions else [None]
            return
        finding = writer.finding(certificate_question(problem, options))
        if isinstance(finding, Fields):
            for k, s in enumerate(solutions):
                if meet(finding.position, s.position):
                    yield [k]
        yield [None]
        return
    cables = writer.cables
    fitting = [
        k
        for k, s in enumerate(solutions)
        if s.family is not None
        and set(s.taut) <= set(cables)
        and all(s.cable_states[i] is not CableState.SLACK for i in cables)
    ]
    one_point = any(problem.loaded.arms[cables[0]])
    sides = product([*fitting, None], repeat=2 if one_point else 1)
    yield from (list(side) for side in sides)


def meet(a: Bounds, b: Bounds) -> bool:
    """Return True when two boxes (3, 2) meet or nearly do."""
    grown = wider(a, 0.0, WIDENED)
    return bool((grown[:, 0] <= b[:, 1]).all() and (b[:, 0] <= grown[:, 1]).all())


class Writer:
    """Proof data for the common point of some cables."""

    def __init__(self, problem: Problem, cables: tuple[int, ...]) -> None:
        self.problem = problem
        self.cables = cables
        robot = problem.robot
        if point_mass.accepts(robot):
            self.arrays: RobotArrays = part_of(robot_arrays(problem.loaded), cables)
        else:
            zero = Fraction(0)
            part = Robot(
                name=robot.name,
                platform=Platform(robot.platform.mass),
                cables=tuple(
                    Cable(robot.cables[i].name, robot.cables[i].frame_anchor, (zero, zero, zero))
                    for i in cables
                ),
                gravity=robot.gravity,
            )
            self.arrays = robot_arrays(loaded(part, problem.external_force))

    def bounds(self, question: Question) -> Bounds:
        """Return the lengths of the cables as doubles, (n, 2)."""
        return length_bounds(
            [(fraction(lo), fraction(hi)) for lo, hi in map(question.lengths.__getitem__, self.cables)]
        )

    def finding(self, question: Question) -> Fields | NoPose | Unproved:
        """Return what the solver says of the cables."""
        ranges = [question.lengths[i] for i in self.cables]
        lengths = [fraction(lo) for lo, _ in ranges] if all(lo == hi for lo, hi in ranges) else None
        return find_pose(self.arrays, self.bounds(question), lengths)

    def proof(
        self, question: Question, accepts: Callable[[Question, Json], bool], pieces: list[int]
    ) -> Json | None:
        """Return an accepted proof, cutting length ranges in halves; None where there is none."""
        pieces[0] -= 1
        bounds, finding = self.bounds(question), self.finding(question)
        for proof in self.attempts(question, finding):
            if accepts(question, proof):
                return proof
        widest = self.widest(bounds, finding)
        if widest is None or pieces[0] < 1:
            return None
        lo, hi = question.lengths[widest]
        cut = (lo + hi) / 2
        halves = []
        for half in ((lo, cut), (cut, hi)):
            lengths = [*question.lengths[:widest], half, *question.lengths[widest + 1 :]]
            inner = self.proof(replace(question, lengths=lengths), accepts, pieces)
            if inner is None:
                return None
            halves.append(inner)
        return {"kind": "parts", "cable": widest, "at": str(cut), "parts": halves}

    def attempts(self, question: Question, finding: Fields | NoPose | Unproved) -> Iterator[Json]:
        """Yield proofs that may do."""
        if isinstance(finding, NoPose):
            weights = [Fraction(finding.weights.get(i, 0)) for i in range(len(self.cables))]
            yield {"kind": "weights", "weights": [str(w) for w in weights]}
            return
        if question.ignore_slack and point_mass.accepts(self.problem.robot) and question.taut is None:
            # Asked for alone, a subset cannot be settled by smaller ones: they are not examined.
            yield {"kind": "dependent"}
        if isinstance(finding, Unproved):
            return
        start = middles(finding.position) + [float(x) for x in self.arrays.centre]
        densities = middles(finding.tensions) / middles(finding.distances)
        elastic = question.stiffness[self.cables[0]] is not None
        numbers = [text(x) for x in [*start.tolist(), *densities.tolist()]]
        yield {"kind": "newton", "start": numbers, "scale": "1"}
        if not elastic:
            dual = self.duality(question, finding, start)
            if dual is not None:
                yield dual

    def duality(self, question: Question, finding: Fields, start: Bounds) -> Json | None:
        """Return multipliers of at most three cables that hold the pose, and a point strictly inside."""
        near = finding.not_slack
        exits = [question.exits[i] for i in self.cables]
        for size in (3, 2, 1):
            for few in combinations(near, size):
                found = self.held(question, [self.cables[k] for k in few], start)
                if found is None:
                    continue
                point, t = found
                inner = self.inside(question, point)
                if inner is None:
                    continue
                weights = [fmpq(0)] * len(self.cables)
                for k, value in zip(few, t, strict=True):
                    weights[k] = value
                arms = {k: minus(point, exits[k]) for k in near}
                normals = [normal(k, arms) if k in near else None for k in range(len(self.cables))]
                return {
                    "kind": "duality",
                    "inner": [str(x) for x in inner],
                    "densities": [str(x) for x in weights],
                    "normals": normals,
                }
        return None

    def held(self, question: Question, few: list[int], start: Bounds) -> tuple[list[fmpq], list[fmpq]] | None:
        """Return the point and multipliers of a few cables alone, in many digits; None unless all carry."""
        arms = np.array([[start[j] - float(fraction(question.exits[i][j])) for j in range(3)] for i in few]).T
        load = np.array([float(fraction(x)) for x in question.load])
        t = np.linalg.lstsq(arms, load, rcond=None)[0]
        try:
            start_at = [arb(v) for v in [*start.tolist(), *t.tolist()]]
            x = newton.zero(System(question, few, fmpq(1)).equations, start_at).entries()
        except (NotProved, ZeroDivisionError):
            return None
        values = [rational(v) for v in x]
        return (values[:3], values[3:]) if all(v > 0 for v in values[3:]) else None

    def inside(self, question: Question, point: list[fmpq]) -> list[fmpq] | None:
        """Return a point near the given one that is strictly inside all balls."""
        exits = np.array([[float(x) for x in a] for a in self.arrays.exits])
        shortest = [question.lengths[i][0] for i in self.cables]
        _, deep = deepest_point(exits, np.array([float(fraction(x)) for x in shortest]))
        towards = [fmpq(*float(d).as_integer_ratio()) - p for d, p in zip(deep, point, strict=True)]
        for bits in STEP_BITS:
            q = [p + d / 2**bits for p, d in zip(point, towards, strict=True)]
            squares = [
                sum(((x - a) ** 2 for x, a in zip(q, question.exits[i], strict=True)), fmpq(0))
                for i in self.cables
            ]
            if all(s < size**2 for s, size in zip(squares, shortest, strict=True)):
                return [rational(arb(x)) for x in q]
        return None

    def widest(self, bounds: Bounds, finding: Fields | NoPose | Unproved) -> int | None:
        """Return the cable with the widest range of those near the pose; None without a range."""
        width = bounds[:, 1] - bounds[:, 0]
        wide = width > WIDENED * bounds[:, 1]
        if isinstance(finding, Fields):
            near = np.abs(middles(finding.distances) - middles(bounds)) < 2.0 * width.max()
            wide = wide & near if (wide & near).any() else wide
        return self.cables[int(np.where(wide, width, -1.0).argmax())] if wide.any() else None


def normal(k: int, arms: dict[int, list[arb]]) -> list[str] | None:
    """Return the part of a cable's direction that is across all others; None where there is none."""
    basis: list[arb_mat] = []
    for i, arm in [*((i, a) for i, a in arms.items() if i != k), (k, arms[k])]:
        rest = column(arm)
        for _ in range(2):
            for b in basis:
                rest = (rest - b * (b.transpose() * rest)[0, 0]).mid()
        size = float((rest.transpose() * rest)[0, 0]) ** 0.5
        if size > 1e-9 * float(sum((x * x for x in arm), arb(0))) ** 0.5:
            rest = (rest * (1 / arb(size))).mid()
            if i == k:
                return [str(rational(x)) for x in rest.entries()]
            basis.append((rest * (1 / (rest.transpose() * rest)[0, 0].sqrt())).mid())
    return None


def rational(x: arb) -> fmpq:
    """Return the middle of a ball exactly."""
    mantissa, exponent = x.mid().man_exp()
    return fmpq(mantissa) * fmpq(2) ** int(exponent)


def text(x: float) -> str:
    """Return a double as the shortest decimal that restores it."""
    return repr(float(x))


def middles(bounds: Bounds) -> Bounds:
    """Return the middles of bounds (..., 2)."""
    return np.asarray(0.5 * bounds[..., 0] + 0.5 * bounds[..., 1])
