"""The certificate of a result: whether it is about this very one, and what the independent checker says."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from flint import fmpq

from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.exact.range import LengthRange
from cdpr_interval.exact.vector import Vector
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.text.count import counted
from certificates.checker import check
from certificates.container import unpack
from certificates.problem import Listed, Problem, read_problem, read_solutions
from certificates.verdicts import Conclusion, Malformed, Verdict
from solvers.answers.data import Solution
from solvers.answers.result import Result
from solvers.proofs.listed import written_states
from solvers.proofs.text import robot_document
from solvers.questions.checked import uncertified_pulleys
from solvers.questions.force import ZERO

Json = dict[str, Any]
Bounds = Sequence[tuple[float, float]]


REFUSED = (Conclusion.NOT_PROVED, Conclusion.MALFORMED)
"""The checker says no."""
PLURAL = ("lengths", "tension limits")


@dataclass(frozen=True)
class Proof:
    """What is known of a result by its certificate."""

    verdict: Verdict
    is_complete: bool
    """With PROVED: the result's poses are all there are."""
    message: str

    @property
    def conclusion(self) -> Conclusion:
        """The verdict, and whether it leaves something open, in one word with an exit code."""
        return Conclusion.of(self.verdict, self.is_complete)

    @property
    def name(self) -> str:
        """The conclusion as it is printed."""
        return str(self.conclusion)

    @property
    def is_refused(self) -> bool:
        """Whether the checker says no."""
        return self.conclusion in REFUSED

    def __str__(self) -> str:
        return f"{self.name}: {self.message}"


@dataclass(frozen=True)
class Asked:
    """A question that a certificate is to be about."""

    lengths: Sequence[LengthRange] | None = None
    """None: whatever lengths."""
    external_force: Vector = ZERO
    """The verdict does not speak of it: none is meant where none is given."""
    taut: tuple[int, ...] | None = None
    """None: whatever subset, which the verdict names; so it does what is ignored."""
    ignore_slack: bool = False
    ignore_tension_sign: bool = False


def proof_of(
    robot: Robot,
    result: Result,
    content: bytes,
    time_limit: float | None = None,
    progress: Callable[[int, int], None] | None = None,
    threads: int = 1,
) -> Proof:
    """Check a certificate, and that it is about a result.

    Parameters
    ----------
    robot : Robot
        Of the result.
    result : Result
    content : bytes
        Of the certificate file.
    time_limit : float, optional
        s; a certificate that takes longer is out of time.
    progress : callable, optional
        Called with the numbers of cells checked and to be checked.
    threads : int
        Processes that check.

    Returns
    -------
    Proof
        NOT PROVED also where the certificate has another question than the result, or other poses.

    Guarantee
    ---------
    PROVED and complete: the question of the result has exactly the poses of the certificate, and each box
    of the result lies in the box of one of them, a different one for each.
    """
    try:
        differing = difference(robot, result, content)
    except Malformed as error:
        return Proof(Verdict.MALFORMED, False, str(error))
    if differing:
        return Proof(Verdict.NOT_PROVED, False, f"the certificate is not of this result: {differing}")
    report = check(content, time_limit=time_limit, progress=progress, threads=threads)
    return Proof(report.verdict, report.complete, report.message)


def difference(robot: Robot, result: Result, content: bytes) -> str:
    """Return in what a certificate differs from a result; empty when it does not. Nothing is checked.

    Raises
    ------
    Malformed
        The content is no certificate.
    """
    document = unpack(content)
    problem = read_problem(document)
    asked = result.question
    found = _differing(
        {
            "robot": (_with_robot(document, robot), problem),
            "lengths": ([_around(*pair) for pair in problem.lengths], result.lengths.tolist()),
            "external force": ([float(x) for x in _forces(document)], list(asked.external_force)),
            "subset": (problem.taut, asked.taut),
            "tension limits": (None, asked.tension),
            "--ignore-slack": (problem.ignore_slack, asked.ignore_slack),
            "--ignore-tension-sign": (problem.ignore_tension_sign, asked.ignore_tension_sign),
        }
    )
    return found or _missing(
        result.solutions, read_solutions(document, problem), len(document["not_certified"])
    )


def other_question(content: bytes, limit: int, robot: Robot, asked: Asked) -> str:
    """Return in what a certificate differs from a question for a robot; empty when it does not.

    Raises
    ------
    Malformed
        The content is no certificate.
    """
    document = unpack(content, limit)
    problem = read_problem(document)
    lengths = [(_fraction(lo), _fraction(hi)) for lo, hi in problem.lengths]
    return _differing(
        {
            "robot": (_with_robot(document, robot), problem),
            "lengths": (lengths, lengths if asked.lengths is None else list(asked.lengths)),
            "external force": (_forces(document), list(asked.external_force)),
            "subset": (problem.taut, problem.taut if asked.taut is None else asked.taut),
            "--ignore-slack": (problem.ignore_slack or not asked.ignore_slack, True),
            "--ignore-tension-sign": (problem.ignore_tension_sign or not asked.ignore_tension_sign, True),
        }
    )


def _differing(pairs: dict[str, tuple[Any, Any]]) -> str:
    """Return the first pair of two that are not equal."""
    for what, (one, other) in pairs.items():
        if one != other:
            return f"its {what} differ{'' if what in PLURAL else 's'}"
    return ""


def _with_robot(document: Json, robot: Robot) -> Problem | None:
    """Return the question of a document for another robot; None when it does not fit, or none can be."""
    if uncertified_pulleys(robot) is not None:
        return None
    try:
        return read_problem({**document, "robot": robot_document(robot)})
    except Malformed:
        return None


def _around(lo: fmpq, hi: fmpq) -> list[float]:
    """Return the tightest doubles around exact lengths."""
    return [enclose(_fraction(lo))[0], enclose(_fraction(hi))[1]]


def _fraction(x: fmpq) -> Fraction:
    return Fraction(int(x.p), int(x.q))


def _forces(document: Json) -> list[Fraction]:
    return [Fraction(text) for text in document["external_force_N"]]


def _missing(solutions: Sequence[Solution], listed: Sequence[Listed], left_out: int) -> str:
    """Return what is wrong unless each solution is another listed one, those left out excepted."""
    free = list(range(len(listed)))
    unknown = 0
    for solution in solutions:
        found = next((k for k in free if _holds(listed[k], solution)), None)
        if found is None:
            unknown += 1
        else:
            free.remove(found)
    if unknown > left_out:
        others = unknown - left_out
        return f"{others} of its poses {'is another' if others == 1 else 'are others'}"
    return f"it has {counted(len(free), 'more pose')}" if free else ""


def _holds(listed: Listed, solution: Solution) -> bool:
    """Return whether the box of a listed solution holds that of a solution, and their cables agree."""
    if listed.taut != solution.taut or listed.states != written_states(solution):
        return False
    return all(
        np.all(np.array(outer)[..., 0] <= inner[..., 0]) and np.all(inner[..., 1] <= np.array(outer)[..., 1])
        for outer, inner in ((listed.position, solution.position), (listed.rotation, solution.rotation))
    )
