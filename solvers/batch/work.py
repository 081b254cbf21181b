"""What a worker does: the jobs of a chunk, one after the other, each to an outcome.

Imports nothing heavy before the first chunk; everything a job needs travels with it.
"""

from __future__ import annotations

import json
import socket
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from cdpr_interval.errors import CdprError
from cdpr_interval.robots.cable_robot import Robot

if TYPE_CHECKING:
    from solvers.answers.result import Result
    from solvers.batch.job import Settings
    from solvers.six_dof.parts import Parts


class Status(StrEnum):
    """How far a job is."""

    PENDING = "pending"
    DONE = "done"
    """Answered; what the search left open stands in the answer."""
    NO_POSE = "no-pose"
    """Answered: proved that there is no static pose."""
    NONE_FOUND = "none-found"
    """Inverse kinematics found no lengths for the pose that was asked for, which proves nothing."""
    FAILED = "failed"
    """The solver refused it, or raised an exception."""
    CRASHED = "crashed"
    """It killed its worker, alone too."""


_SOLVING = threading.Lock()
"""The precision of ball arithmetic belongs to the whole process: threads of one solve one after the other."""


@dataclass(frozen=True)
class Task:
    """One job of a chunk."""

    number: int
    """Of the job in its ledger."""
    input: str
    parts: tuple[tuple[str, str], ...] = ()
    """Input and answer of the parts into which it was split: they are put together."""


@dataclass(frozen=True)
class Chunk:
    """Some jobs of one robot, as they travel."""

    robot: bytes
    """The robot's file."""
    settings: str
    tasks: tuple[Task, ...]
    is_retry: bool = False
    """True: one job, which killed its worker before or was with one that did."""


@dataclass(frozen=True)
class JobOutcome:
    """What came out of one job."""

    number: int
    status: Status
    answer: str | None
    """Text of `answer.answer_text`."""
    message: str
    started: float
    """s since 1970."""
    seconds: float
    """Wall time."""
    host: str
    certificate: bytes | None = None
    claim: str = ""
    """What the checker says of the certificate, as `certificates.verdicts.Conclusion`."""
    checked: str = ""
    """Its sentence."""


def solve_chunk(chunk: Chunk) -> list[JobOutcome]:
    """Return the outcome of every job; never raises for a job. Other threads of the process wait."""
    with _SOLVING:
        return _outcomes(chunk)


def _outcomes(chunk: Chunk) -> list[JobOutcome]:
    from solvers.batch.job import Settings

    solve = _solver(chunk.robot, Settings.from_json(chunk.settings))
    host = socket.gethostname()
    outcomes = []
    for task in chunk.tasks:
        started, begun = time.time(), time.perf_counter()
        try:
            answered = solve(task)
        except CdprError as error:
            answered = Answered(Status.FAILED, message=" ".join(str(error).split()))
        except Exception as error:
            text = " ".join(f"{type(error).__name__}: {error}".split())
            answered = Answered(Status.FAILED, message=f"internal error: {text}")
        seconds = time.perf_counter() - begun
        outcomes.append(
            JobOutcome(
                task.number, answered.status, answered.answer, answered.message, started, seconds, host,
                answered.certificate, answered.claim, answered.checked,
            )
        )  # fmt: skip
    return outcomes


@dataclass(frozen=True)
class Answered:
    """What the solver says of one job."""

    status: Status
    answer: str | None = None
    message: str = ""
    certificate: bytes | None = None
    claim: str = ""
    checked: str = ""

    @classmethod
    def of(cls, result: Result, **proof: Any) -> Answered:
        """Return what is said of a job with this result."""
        from solvers.answers.data import Outcome
        from solvers.batch.answer import answer_text

        is_empty = result.outcome is Outcome.COMPLETE and not result.solutions
        return cls(Status.NO_POSE if is_empty else Status.DONE, answer_text(result), **proof)


def _solver(data: bytes, settings: Settings) -> Callable[[Task], Answered]:
    from solvers.batch.job import canonical, perturbed, problem_of
    from solvers.forward import answer_question
    from solvers.six_dof.parts import Part, solve_part
    from solvers.six_dof.record import Record

    robot = _robot(data)

    def solve(task: Task) -> Answered:
        asked = json.loads(task.input)
        lengths: Any
        if "pose" in asked:
            lengths, message = _lengths_at(perturbed(robot, asked), asked)
            if lengths is None:
                return Answered(Status.NONE_FOUND, message=message)
        else:
            lengths = asked["lengths_m"]
        problem, options = problem_of(robot, asked, lengths, settings)
        if "part" in asked:
            found = solve_part(problem, options, Part.from_json(asked["part"]))
            return Answered(Status.DONE, canonical(found.to_json()))
        if task.parts:
            options = replace(options, parts=_together(task.parts))
        if not settings.certificates:
            return Answered.of(answer_question(problem, options))
        from solvers.proofs.check import proof_of
        from solvers.proofs.document import certificate_of

        options = replace(options, record=Record())
        result = answer_question(problem, options)
        certificate, _ = certificate_of(problem, options, result)
        proof = proof_of(problem.robot, result, certificate, settings.time_limit_s)
        if proof.is_refused:
            return Answered(Status.FAILED, message=f"internal error: its certificate is {proof}")
        return Answered.of(
            result, certificate=certificate, claim=proof.conclusion.value, checked=proof.message
        )

    return solve


def _together(parts: Sequence[tuple[str, str]]) -> Parts:
    """Return what the parts of a job found, by subset and frame.

    Raises
    ------
    CdprError
        Not all parts of a search are there: poses would be lost.
    """
    from solvers.six_dof.parts import Part, PartFound

    found: dict[tuple[tuple[int, ...], int], list[PartFound]] = {}
    counts: dict[tuple[tuple[int, ...], int], int] = {}
    for asked, answer in parts:
        part = Part.from_json(json.loads(asked)["part"])
        before = found.setdefault((part.taut, part.frame), [])
        if part.number != len(before):
            raise CdprError(f"part {len(before)} of {part.of} is missing")
        before.append(PartFound.from_json(json.loads(answer)))
        counts[part.taut, part.frame] = part.of
    for search, some in found.items():
        if len(some) != counts[search]:
            raise CdprError(f"part {len(some)} of {counts[search]} is missing")
    return dict(found)


@lru_cache(maxsize=64)
def _robot(data: bytes) -> Robot:
    from cdpr_interval.robots.formats.reader import parse_robot

    return parse_robot(data)


def _lengths_at(robot: Robot, asked: dict[str, Any]) -> tuple[tuple[float, ...] | None, str]:
    """Return the lengths that inverse kinematics gives for a pose, or why there are none."""
    import math

    from cdpr_interval.mechanics.orientation import rotation_from_rpy
    from solvers.kinematics.inverse import inverse_kinematics

    rotation = rotation_from_rpy([math.radians(angle) for angle in asked["pose"][3:]])
    found = inverse_kinematics(
        robot,
        asked["pose"][:3],
        rotation,
        taut=asked.get("taut"),
        settle=asked["settle"],
        external_force=asked.get("external_force_N"),
    )
    if found.lengths is None:
        return None, found.message
    return tuple(found.lengths), ""
