"""Entries "point" of certificates for tests: asked, written, and put to the checker."""

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Robot
from certificates.families import check_one_point_family
from certificates.point_mass import check_point
from certificates.problem import Listed, Problem
from solvers.answers.result import Result
from solvers.forward import answer_question, pose_problem
from solvers.proofs.listed import certificate_question, listed_solution, widened
from solvers.proofs.point import point_entry
from solvers.questions.problem import Options


@dataclass(frozen=True)
class Case:
    """What the checker is given of one subset."""

    problem: Problem
    taut: tuple[int, ...]
    entry: dict[str, Any]
    listed: list[Listed]
    result: Result

    def check(self) -> set[int]:
        check = check_point if self.problem.is_point_mass else check_one_point_family
        return check(self.problem, self.taut, self.entry, self.listed)

    def other(self, k: int = 0, **fields: Any) -> "Case":
        """Return the case with another solution k."""
        listed = list(self.listed)
        listed[k] = replace(listed[k], **fields)
        return replace(self, listed=listed)

    def asks(self, **fields: Any) -> "Case":
        """Return the case with another problem."""
        return replace(self, problem=replace(self.problem, **fields))


def case(
    robot: Robot, lengths: Any, taut: Any = None, subset: Any = None, force: Any = None, **options: Any
) -> Case:
    """Ask, and write the entry of one subset."""
    chosen = Options(**options)
    problem = pose_problem(robot, lengths, taut, force, chosen)
    result = answer_question(problem, chosen)
    ranges = any(lo < hi for lo, hi in problem.lengths)
    solutions = [widened(s, ranges) for s in result.solutions]
    subset = subset or problem.taut or tuple(range(len(robot.cables)))
    entry = point_entry(problem, chosen, subset, solutions)
    return Case(
        certificate_question(problem, chosen), subset, entry, [listed_solution(s) for s in solutions], result
    )


def vector(*numbers: float) -> tuple[Fraction, Fraction, Fraction]:
    x, y, z = (Fraction(repr(round(n, 4))) for n in numbers)
    return x, y, z


def robot(exits: Any, points: Any = None, mass: float = 10, stiffness: Any = None) -> Robot:
    """Return a robot; without points a point mass. ``stiffness``: N/m, or ("axial", N)."""
    cables = []
    for i, a in enumerate(exits):
        b = vector(*points[i]) if points else vector(0.0, 0.0, 0.0)
        elasticity = None
        if isinstance(stiffness, tuple):
            elasticity = Elasticity(axial_stiffness=Fraction(stiffness[1]))
        elif stiffness is not None:
            elasticity = Elasticity(stiffness=Fraction(stiffness))
        cables.append(Cable(f"c{i}", vector(*a), b, elasticity))
    return Robot(name="made", platform=Platform(Fraction(mass)), cables=tuple(cables))
