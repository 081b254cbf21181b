"""The polynomials behind a forward kinematics, their real roots, and whether the interval solver agrees.

Two independent ways to the same poses: eliminants in exact arithmetic (`cdpr_interval.symbolic`) and branch
and prune. For every static pose of the one there must be exactly one box of the other, in both directions.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb, arb_mat, fmpq, fmpz_poly

from cdpr_interval.errors import InputError, NotSupportedError
from cdpr_interval.exact import balls
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.cables.law import law_of
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.given import require_robot
from cdpr_interval.robots.numbers import exact_point
from cdpr_interval.symbolic import inextensible, planar
from cdpr_interval.symbolic.eliminant import MOST_CABLES, Eliminant, eliminant
from cdpr_interval.symbolic.elimination import Vanishes
from cdpr_interval.symbolic.statics import Statics
from cdpr_interval.text.count import counted
from solvers.answers.result import Result
from solvers.forward import answer_question, pose_problem
from solvers.point_mass import scope as point_mass
from solvers.questions.checked import mixed_cables, on_legs, over_pulleys, require_treated, uncertain_data
from solvers.questions.force import read_force
from solvers.questions.problem import Method, Options, Problem
from solvers.tensions import TensionProblem, height, solve_tensions, tension_problem

Exact = list[fmpq]
CURVES = ("P1", "P2", "P3", "Q")


@dataclass(frozen=True)
class Found:
    """A real solution: bounds that hold a pose's numbers, each (lo, hi)."""

    root: tuple[float, float]
    """Of the unknown of the eliminant."""
    position: Bounds | None
    """(3, 2) m; None for two cables of a platform."""
    height: tuple[float, float]
    """Of the centre of mass, m."""
    tensions: Bounds
    """(n, 2) N, of the taut cables."""
    is_static: bool
    """No cable pushes, and no distance is negative."""


@dataclass(frozen=True)
class Comparison:
    """What two solvers say about the same question."""

    agrees: bool | None
    """None: not decided."""
    text: str


@dataclass
class Report:
    """Everything that is printed about one question."""

    title: str
    unknown: str
    degrees: list[str] = field(default_factory=list)
    """How the elimination went."""
    factors: list[tuple[int, bool, str, fmpz_poly | None]] = field(default_factory=list)
    """Degree, whether true, why, and the polynomial if it is over the rationals."""
    roots: list[Found] = field(default_factory=list)
    comparison: Comparison = Comparison(None, "not compared")
    system: Statics | None = None

    def lines(self) -> list[str]:
        """Return the report as text."""
        found = [self.title, f"unknown: {self.unknown}", "elimination:"]
        found += [f"  {line}" for line in self.degrees]
        found.append("factors:")
        found += [f"  {self.factor_line(factor)}" for factor in self.factors]
        static = sum(root.is_static for root in self.roots)
        found.append(f"real solutions: {len(self.roots)}, of them {static} static")
        for root in self.roots:
            numbers = [f"{shown(root.root)}"]
            if root.position is not None:
                numbers.append("C = (" + ", ".join(shown(v) for v in root.position) + ") m")
            else:
                numbers.append(f"height {shown(root.height)} m")
            numbers.append("tensions " + ", ".join(shown(v) for v in root.tensions) + " N")
            found.append(f"  {'static    ' if root.is_static else 'not static'}  " + "  ".join(numbers))
        return [*found, f"agreement with fk: {self.comparison.text}"]

    def latex(self) -> str:
        """Return the derivation as a LaTeX document; raise `NotSupportedError` where there is none."""
        if self.system is None:
            raise NotSupportedError(
                "--latex: the derivation is written for elastic cables and given tensions"
            )
        from cdpr_interval.symbolic.derivation import latex

        return latex(self.system, [*self.degrees, *(self.factor_line(f) for f in self.factors)])

    @staticmethod
    def factor_line(factor: tuple[int, bool, str, fmpz_poly | None]) -> str:
        """Return what is said of a factor."""
        degree, is_true, reason, _ = factor
        return f"degree {degree:3d}  {'true      ' if is_true else 'extraneous'}  {reason}"

    def to_dict(self) -> dict[str, Any]:
        """Return the report as plain lists and dictionaries; coefficients from the constant on, as texts."""
        return {
            "format": "cdpr-polynomial/1",
            "title": self.title,
            "unknown": self.unknown,
            "elimination": self.degrees,
            "factors": [
                {
                    "degree": degree,
                    "true": is_true,
                    "reason": reason,
                    "coefficients": None if f is None else [str(c) for c in f.coeffs()],
                }
                for degree, is_true, reason, f in self.factors
            ],
            "real_solutions": [
                {
                    "root": list(root.root),
                    "position_m": None if root.position is None else root.position.tolist(),
                    "height_m": list(root.height),
                    "tensions_N": root.tensions.tolist(),
                    "static": root.is_static,
                }
                for root in self.roots
            ],
            "agreement": self.comparison.agrees,
            "comparison": self.comparison.text,
        }


def shown(bounds: Sequence[float]) -> str:
    """Return a number near the middle of bounds; they are far narrower than what is shown."""
    return f"{0.5 * (bounds[0] + bounds[1]):.6f}"


def polynomial_report(
    robot: Robot | str | os.PathLike[str],
    lengths: Any = None,
    *,
    tensions: Any = None,
    taut: Any = None,
    external_force: Any = None,
    threads: int = 1,
) -> Report:
    """Derive the eliminant of a subset of taut cables, its roots and poses, and compare with `fk`.

    Parameters
    ----------
    robot : Robot, str or PathLike
        A point mass (elastic: 1 to 4 taut cables; inextensible: 1 to 3), or a platform on two cables.
    lengths : as in `forward_kinematics`
        Exact numbers, no ranges, m.
    tensions : as ``lengths``
        Instead of lengths: what is known of a point mass, N.
    taut : iterable of str or int, optional
        The taut cables; default: all.
    external_force : sequence of 3 numbers, optional
        N, base axes.
    threads : int
        Of the search that is compared with.

    Raises
    ------
    InputError, NotSupportedError
        A rule of the input is broken; a robot or number of cables without an eliminant here.

    Examples
    --------
    >>> report = polynomial_report("merlet_4_1", tensions=[300, 300, 300, 300])
    >>> len(report.roots), report.comparison.agrees
    (2, True)
    """
    robot = require_robot(robot)
    require_treated(robot, on_legs(robot, "polynomial"))
    require_treated(robot, over_pulleys(robot, "polynomial") or mixed_cables(robot, "polynomial"))
    require_treated(robot, uncertain_data(robot, asker="polynomial"))
    force = None if external_force is None else read_force(external_force)
    if (lengths is None) == (tensions is None):
        raise InputError("either lengths or tensions are needed")
    if tensions is not None:
        question = tension_problem(robot, tensions, taut, force)
        refuse_ranges(question.tensions, "tensions")
        return of_tensions(question)
    options = Options(ignore_slack=True, method=Method.SEARCH)
    problem = pose_problem(robot, lengths, taut, force, options)
    refuse_ranges(problem.lengths, "lengths")
    chosen = problem.taut if problem.taut is not None else tuple(range(len(robot.cables)))
    problem = Problem(robot, problem.lengths, problem.external_force, chosen)
    if not point_mass.accepts(robot):
        report = of_platform(problem, chosen)
    else:
        report = of_springs(problem, chosen) if robot.is_elastic else of_spheres(problem, chosen)
    report.comparison = compared(report, problem, chosen, threads)
    return report


def refuse_ranges(ranges: Sequence[tuple[Fraction, Fraction]], label: str) -> None:
    """Raise `InputError` where a number is a range: polynomials have exact coefficients."""
    if any(lo != hi for lo, hi in ranges):
        raise InputError(f"{label}: exact numbers are needed, not ranges")


def rational(x: Fraction) -> fmpq:
    """Return an exact number."""
    return fmpq(x.numerator, x.denominator)


def exits_of(robot: Robot, chosen: Sequence[int]) -> list[Exact]:
    """Return the exit points of some cables."""
    return [[rational(v) for v in exact_point(robot.cables[i].frame_anchor)] for i in chosen]


def named(robot: Robot, chosen: Sequence[int]) -> str:
    """Return the names of some cables."""
    return ", ".join(robot.cable_names[i] for i in chosen)


def of_springs(problem: Problem, chosen: Sequence[int]) -> Report:
    """Report on elastic cables."""
    lengths = [problem.lengths[i][0] for i in chosen]
    cables = [problem.robot.cables[i] for i in chosen]
    constants = [law_of(c).spring_constant(x) for c, x in zip(cables, lengths, strict=True)]
    stiffness = [rational(k) for k in constants if k is not None]
    statics = Statics.elastic(
        exits_of(problem.robot, chosen),
        [rational(v) for v in problem.load],
        stiffness,
        [rational(x) for x in lengths],
    )
    report = Report(
        f"elastic point mass on {named(problem.robot, chosen)}, all taut",
        f"rho_1, the distance of {problem.robot.cable_names[chosen[0]]} in m",
        system=statics,
    )
    describe(report, statics, problem)
    return report


def of_tensions(question: TensionProblem) -> Report:
    """Report on given tensions."""
    chosen = question.chosen
    statics = Statics.given_tensions(
        exits_of(question.robot, chosen),
        [rational(v) for v in question.load],
        [rational(lo) for lo, _ in question.tensions],
    )
    report = Report(
        f"point mass on {named(question.robot, chosen)} with given tensions",
        f"rho_1, the distance of {question.robot.cable_names[chosen[0]]} in m",
        system=statics,
    )
    describe(report, statics, question)
    report.comparison = agreement(report, solve_tensions(question), chosen)
    return report


def describe(report: Report, statics: Statics, problem: Problem | TensionProblem) -> None:
    """Fill in degrees, factors and real solutions of an elimination."""
    if statics.count > MOST_CABLES:
        raise NotSupportedError(
            f"eliminants are derived of 1 to {MOST_CABLES} taut cables, not {statics.count}"
        )
    try:
        found = eliminant(statics)
    except Vanishes as error:
        raise NotSupportedError(f"no eliminant: {error}") from None
    report.degrees += degrees(found)
    report.factors += [(f.degree, f.is_true, f.reason, f.polynomial) for f in found.factors]
    for multiplicity, degree in sorted(found.refuted.items()):
        reason = f"(times {multiplicity}) not in a second eliminant, modulo {found.prime}"
        report.factors.append((degree, False, reason, None))
    with balls.precision():
        for root, zeros in found.real_solutions:
            for zero in zeros:
                centre = [v.real for v in zero.centre]
                report.roots.append(
                    Found(
                        balls.to_bounds(root.real),
                        bounds(centre),
                        balls.to_bounds(height(problem.robot, arb_mat([[c] for c in centre]))),
                        bounds([v.real for v in zero.tensions]),
                        zero.is_static,
                    )
                )
    open_roots = sum(not zeros for _, zeros in found.real_solutions)
    if open_roots:
        report.degrees.append(f"{open_roots} real roots with complex poses, or poses that were not found")


def degrees(found: Eliminant) -> list[str]:
    """Return how an elimination went."""
    lines = [f"degrees modulo {found.prime}"]
    for name, curve in zip(CURVES, found.curves, strict=False):
        lines.append(f"{name}: {curve.degrees[0]} in rho_1, {curve.degrees[1]} in rho_2")
    if found.curves:
        total = sum(m * degree for m, degree in found.multiplicities.items())
        parts = ", ".join(f"{d} (times {m})" for m, d in sorted(found.multiplicities.items()))
        lines.append(f"Res(P1, P2; rho_2): {total} in rho_1; degrees of its factors: {parts}")
    return [*lines, f"true degree over Q: {found.true_degree}"]


def bounds(values: Sequence[arb]) -> Bounds:
    """Return double bounds (n, 2)."""
    return np.array([balls.to_bounds(v) for v in values])


def of_spheres(problem: Problem, chosen: Sequence[int]) -> Report:
    """Report on inextensible cables of a point mass."""
    exits, load = exits_of(problem.robot, chosen), [rational(v) for v in problem.load]
    lengths = [rational(problem.lengths[i][0]) for i in chosen]
    if len(chosen) > inextensible.MOST_CABLES:
        raise NotSupportedError(
            f"inextensible cables: at most {inextensible.MOST_CABLES} taut, not {len(chosen)}"
        )
    try:
        form = inextensible.closed_form(exits, load, lengths)
    except Vanishes as error:
        raise NotSupportedError(f"no eliminant: {error}") from None
    report = Report(
        f"point mass on {named(problem.robot, chosen)}, inextensible, all taut",
        "s, where C = C_0 + s m with rational C_0 and m",
        [f"closed form: s^2 = {form.square}", "true degree over Q: 2"],
        [
            (
                2,
                True,
                "every root is a point at these distances, in the plane of balance",
                form.eliminant.numer(),
            )
        ],
    )
    with balls.precision():
        for sign, (centre, tensions) in zip((-1, 1), form.poses(), strict=False):
            level = height(problem.robot, arb_mat([[c] for c in centre]))
            static = all(t > 0 for t in tensions)
            root = balls.to_bounds(sign * arb(form.square).sqrt())
            report.roots.append(Found(root, bounds(centre), balls.to_bounds(level), bounds(tensions), static))
    return report


def of_platform(problem: Problem, chosen: Sequence[int]) -> Report:
    """Report on two cables of a platform."""
    if len(chosen) != 2:
        raise NotSupportedError(f"a platform: eliminants are derived of two taut cables, not {len(chosen)}")
    arms, load = problem.loaded.arms, [rational(v) for v in problem.load]
    data = planar.Planar(
        exits_of(problem.robot, chosen),
        [[rational(v) for v in arms[i]] for i in chosen],
        load,
        [rational(problem.lengths[i][0]) for i in chosen],
    )
    report = Report(
        f"platform on {named(problem.robot, chosen)}, both taut",
        "u, the tangent of half the platform's angle in the plane of cables and load",
    )
    try:
        for side in (1, -1):
            found = planar.eliminant_modulo(data, side)
            report.degrees.append(
                f"platform {'as it is' if side > 0 else 'mirrored'}: degree {found.degree()}"
            )
            reason = f"degree modulo {found.modulus()}, coefficients over Q with square roots"
            report.factors.append((int(found.degree()), True, reason, None))
            add_planar(report, problem, data, side)
    except Vanishes as error:
        raise NotSupportedError(f"no eliminant: {error}") from None
    return report


def add_planar(report: Report, problem: Problem, data: planar.Planar, side: int) -> None:
    """Add the real solutions of one of the mirrored planar problems."""
    with balls.precision():
        load = arb_mat([[arb(v)] for v in data.load])
        size = balls.norm(load)
        up = load * (-1 / size)
        span = arb_mat([[arb(v)] for v in data.span])
        across = span - up * balls.dot(up, span)
        across = across * (1 / balls.norm(across))
        first = arb_mat([[arb(v)] for v in data.exits[0]])
        for pose in planar.poses(data, side):
            pulls = [t * size * arb(length) for t, length in zip(pose.densities, data.lengths, strict=True)]
            level = height(problem.robot, first + across * pose.along + up * pose.height)
            static = all(t > 0 for t in pulls)
            report.roots.append(
                Found(balls.to_bounds(pose.u), None, balls.to_bounds(level), bounds(pulls), static)
            )


def compared(report: Report, problem: Problem, chosen: Sequence[int], threads: int) -> Comparison:
    """Compare with the interval search of the same subset, the other cables ignored."""
    method = Method.SEARCH if point_mass.accepts(problem.robot) else Method.AUTO
    options = Options(ignore_slack=True, method=method, threads=threads)
    return agreement(report, answer_question(problem, options), chosen)


def agreement(report: Report, result: Result, chosen: Sequence[int]) -> Comparison:
    """Return whether static poses and boxes belong together one by one."""
    static = [root for root in report.roots if root.is_static]
    if result.outcome != "complete":
        return Comparison(None, f"undecided: fk is not complete ({result.message})")
    holds = [[within(root, s, chosen) for s in result.solutions] for root in static]
    poses, boxes = len(static), len(result.solutions)
    found, places = counted(poses, "static pose"), counted(boxes, "box", "boxes")
    if (
        all(sum(row) == 1 for row in holds)
        and all(sum(c) == 1 for c in zip(*holds, strict=True))
        and poses == boxes
    ):
        return Comparison(True, f"yes, {found} in {places}, one in each")
    return Comparison(False, f"NO: {found}, {places}; boxes of each pose: {[sum(r) for r in holds]}")


def within(root: Found, solution: Any, chosen: Sequence[int]) -> bool:
    """Return True when a solution's box holds a pose (bounds meet: both enclose the same number)."""
    pairs = [(root.height, solution.height)]
    pairs += list(zip(root.tensions, (solution.tensions[i] for i in chosen), strict=True))
    if root.position is not None:
        pairs += list(zip(root.position, solution.position, strict=True))
    return all(a[0] <= b[1] and b[0] <= a[1] for a, b in pairs)
