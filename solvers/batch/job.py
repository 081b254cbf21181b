"""A job: one question of a batch as canonical text, its key, and the problem it stands for.

Every number of a job is an exact decimal in the text, so a job means the same on every machine, and its
lengths can be given to ``cdpr-solve fk`` as they are.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, replace
from typing import Any

from cdpr_interval.exact.decimals import decimal_text
from cdpr_interval.exact.range import LengthRange
from cdpr_interval.exact.vector import Vector
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Robot
from cdpr_interval.text.literal import read_number
from solvers.questions.checked import require_certifiable
from solvers.questions.problem import Method, Options, Problem, asked_of

Question = tuple[str, int, int, str]
"""Robot, problem, item and input of a job."""
PERTURBED = ("stiffness", "frame_anchors_m", "platform_anchors_m", "mass_kg", "centre_of_mass_m")
"""Keys of a job's input that change the robot."""


@dataclass(frozen=True)
class Settings:
    """How every problem of a batch is solved, as far as it may change an answer."""

    ignore_slack: bool = False
    ignore_tension_sign: bool = False
    method: str = Method.AUTO.value
    precision: float = 1e-9
    time_limit_s: float | None = None
    cell_limit: int | None = None
    split: int | None = None
    """Number of parts of the search of a larger subset; budgets hold for each of them."""
    certificates: bool = False

    def to_json(self) -> str:
        """Return the canonical text."""
        return canonical(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> Settings:
        """Return the settings of such a text."""
        return cls(**json.loads(text))

    def options(self) -> Options:
        """Return the options of the solver."""
        return Options(
            ignore_slack=self.ignore_slack,
            ignore_tension_sign=self.ignore_tension_sign,
            method=Method(self.method),
            precision=self.precision,
            time_limit=self.time_limit_s,
            cell_limit=self.cell_limit,
        )


@dataclass(frozen=True)
class Job:
    """One question."""

    robot: str
    """SHA-256 of the robot's file."""
    problem: int
    """Number of the entry of ``problems`` it comes from."""
    item: int
    """Its number there, for this robot."""
    input: str
    """Canonical text of what is asked; see docs/batch.md."""
    parts: tuple[str, ...] = ()
    """The same of the parts into which it is split."""

    def of_parts(self) -> list[Job]:
        """Return its parts as jobs."""
        return [Job(self.robot, self.problem, self.item, text) for text in self.parts]


def canonical(document: Any) -> str:
    """Return JSON without spaces, keys sorted."""
    return json.dumps(document, sort_keys=True, separators=(",", ":"))


def key_of(job: Job, prefix: bytes) -> str:
    """Return the job's key: the hash of solver version and settings (see `key_prefix`), robot and input."""
    return hashlib.sha256(prefix + f"{job.robot}\n{job.input}".encode()).hexdigest()


def key_prefix(version: str, settings: Settings) -> bytes:
    """Return what the keys of one batch have in common."""
    return f"cdpr-interval {version}\n{settings.to_json()}\n".encode()


def range_text(bounds: LengthRange) -> str | list[str]:
    """Return a length as canonical text: one decimal, or two for a range."""
    lo, hi = bounds
    return decimal_text(lo) if lo == hi else [decimal_text(lo), decimal_text(hi)]


def problem_of(
    robot: Robot, asked: dict[str, Any], lengths: Any, settings: Settings
) -> tuple[Problem, Options]:
    """Return the checked problem and the options of a job, for the perturbed robot; see `pose_problem`."""
    from solvers.forward import pose_problem

    own, force = perturbed(robot, asked), asked.get("external_force_N")
    options = asked_of(own, settings.options())
    problem = pose_problem(own, lengths, asked.get("taut"), force, options, tension=asked.get("tension_N"))
    if settings.certificates:
        require_certifiable(problem)
    return problem, options


def is_perturbed(asked: dict[str, Any]) -> bool:
    """Return whether the robot of a job differs from its file."""
    return any(key in asked for key in PERTURBED)


def perturbed(robot: Robot, asked: dict[str, Any]) -> Robot:
    """Return the robot that a job is about; its digest is that of the file `Robot.to_yaml` makes of it."""
    if not is_perturbed(asked):
        return robot
    cables = list(robot.cables)
    for i, cable in enumerate(cables):
        cables[i] = replace(
            cable,
            frame_anchor=_vector(asked, "frame_anchors_m", i) or cable.frame_anchor,
            platform_anchor=_vector(asked, "platform_anchors_m", i) or cable.platform_anchor,
            elasticity=_elasticity(cable, asked, i),
        )
    platform = robot.platform
    if "mass_kg" in asked:
        platform = replace(platform, mass=read_number(asked["mass_kg"]))
    if "centre_of_mass_m" in asked:
        platform = replace(platform, centre_of_mass=_exact(asked["centre_of_mass_m"]))
    return replace(robot, platform=platform, cables=tuple(cables))


def _vector(asked: dict[str, Any], key: str, cable: int) -> Vector | None:
    return _exact(asked[key][cable]) if key in asked else None


def _exact(texts: list[str]) -> Vector:
    x, y, z = map(read_number, texts)
    return x, y, z


def _elasticity(cable: Cable, asked: dict[str, Any], index: int) -> Elasticity | None:
    """Return the cable's elasticity with the number the job gives for it."""
    if "stiffness" not in asked or cable.elasticity is None:
        return cable.elasticity
    given = read_number(asked["stiffness"][index])
    if cable.elasticity.stiffness is not None:
        return Elasticity(stiffness=given)
    return Elasticity(axial_stiffness=given)
