"""From an entry of ``problems`` and a robot to its jobs, in an order that never changes."""

from __future__ import annotations

import random
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.exact.decimals import decimal_text
from cdpr_interval.exact.range import LengthRange
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import exact, exact_point
from cdpr_interval.text.literal import quote
from solvers.batch import job_schema
from solvers.batch.draws import Spread, text_of
from solvers.batch.job import Job, Settings, canonical, problem_of, range_text
from solvers.batch.length_table import read_table
from solvers.classes import class_of
from solvers.questions.checked import require_treated, uncertain_data
from solvers.questions.errors import InputErrors
from solvers.questions.lengths import read_lengths

OF_PLATFORMS = ("platform_anchors_m", "centre_of_mass_m")
"""What a point mass keeps where it is: moved, it would be another class of robot."""


@dataclass(frozen=True)
class Expansion(ABC):
    """The jobs of one problem for one robot."""

    problem: int
    """Number of the entry of ``problems``."""
    robot: Robot
    asked: dict[str, Any]
    """What all its jobs ask: subset and force, where given."""

    @property
    @abstractmethod
    def count(self) -> int:
        """Number of jobs."""

    @abstractmethod
    def inputs(self) -> Iterator[dict[str, Any]]:
        """Yield what each job asks beside ``asked``."""

    def jobs(self, settings: Settings) -> Iterator[Job]:
        """Yield the jobs, those of platforms with the parts that the settings ask for."""
        for item, own in enumerate(self.inputs()):
            asked = {**own, **self.asked}
            parts = self._parts(asked, settings)
            yield Job(self.robot.sha256, self.problem, item, canonical(asked), parts)

    def _parts(self, asked: dict[str, Any], settings: Settings) -> tuple[str, ...]:
        if settings.split is None or not class_of(self.robot).turns:
            return ()
        from solvers.six_dof.forward import subsets
        from solvers.six_dof.parts import parts_of
        from solvers.six_dof.scope import needs_real_cells

        if needs_real_cells(self.robot):
            return ()
        problem, options = problem_of(self.robot, asked, asked["lengths_m"], settings)
        parts = [
            part for taut in subsets(problem) for part in parts_of(problem, options, taut, settings.split)
        ]
        return tuple(canonical({**asked, "part": part.to_json()}) for part in parts)


@dataclass(frozen=True)
class Listed(Expansion):
    """Lists of lengths, written out or from a table."""

    rows: tuple[tuple[LengthRange, ...], ...]

    @property
    def count(self) -> int:
        """Number of jobs."""
        return len(self.rows)

    def inputs(self) -> Iterator[dict[str, Any]]:
        """Yield the lengths."""
        for row in self.rows:
            yield {"lengths_m": [range_text(bounds) for bounds in row]}


@dataclass(frozen=True)
class PoseGrid(Expansion):
    """Poses on a grid; the last axis runs fastest."""

    axes: tuple[tuple[Fraction, ...], ...]
    """x, y, z in m, roll, pitch, yaw in degrees."""
    settle: bool

    @property
    def count(self) -> int:
        """Number of jobs."""
        total = 1
        for axis in self.axes:
            total *= len(axis)
        return total

    def inputs(self) -> Iterator[dict[str, Any]]:
        """Yield the poses: doubles, for inverse kinematics is not certified."""
        for place in product(*self.axes):
            yield {"pose": [float(value) for value in place], "settle": self.settle}


@dataclass(frozen=True)
class MonteCarlo(Expansion):
    """Random deviations of lengths and robot."""

    lengths: tuple[LengthRange, ...]
    samples: int
    seed: int
    spreads: dict[str, Spread]

    @property
    def count(self) -> int:
        """Number of jobs."""
        return self.samples

    def inputs(self) -> Iterator[dict[str, Any]]:
        """Yield lengths and what the robot has instead of its own; every robot sees the same draws."""
        generator = random.Random(self.seed)
        for _ in range(self.samples):
            asked: dict[str, Any] = {"lengths_m": self._lengths(generator)}
            if "stiffness" in self.spreads:
                asked["stiffness"] = self._stiffness(generator)
            for key in ("frame_anchors_m", "platform_anchors_m"):
                if key in self.spreads:
                    asked[key] = self._anchors(key, generator)
            if "mass_kg" in self.spreads:
                asked["mass_kg"] = self._moved("mass_kg", self._nominal["mass_kg"], generator)
            if "centre_of_mass_m" in self.spreads:
                centre = self._nominal["centre_of_mass_m"]
                asked["centre_of_mass_m"] = self._point("centre_of_mass_m", centre, generator)
            yield asked

    @cached_property
    def _nominal(self) -> dict[str, Any]:
        """The numbers that are moved, as decimals."""
        cables = self.robot.cables
        found: dict[str, Any] = {"lengths_m": [tuple(map(_decimal, bounds)) for bounds in self.lengths]}
        if "stiffness" in self.spreads:
            found["stiffness"] = [_decimal(k) for k in stiffness_of(self.robot)]
        found["frame_anchors_m"] = [tuple(map(_decimal, exact_point(c.frame_anchor))) for c in cables]
        found["platform_anchors_m"] = [tuple(map(_decimal, exact_point(c.platform_anchor))) for c in cables]
        found["mass_kg"] = _decimal(exact(self.robot.platform.mass))
        found["centre_of_mass_m"] = tuple(map(_decimal, exact_point(self.robot.platform.centre_of_mass)))
        return found

    def _lengths(self, generator: random.Random) -> list[str | list[str]]:
        spread = self.spreads.get("lengths_m")
        if spread is None:
            return [range_text(bounds) for bounds in self.lengths]
        found: list[str | list[str]] = []
        for lo, hi in self._nominal["lengths_m"]:
            deviation = spread.draw(generator)
            low = text_of(spread.applied(lo, deviation))
            found.append(low if lo == hi else [low, text_of(spread.applied(hi, deviation))])
        return found

    def _moved(self, key: str, nominal: Decimal, generator: random.Random) -> str:
        """Return a number moved by a draw."""
        spread = self.spreads[key]
        return text_of(spread.applied(nominal, spread.draw(generator)))

    def _stiffness(self, generator: random.Random) -> list[str]:
        return [self._moved("stiffness", k, generator) for k in self._nominal["stiffness"]]

    def _anchors(self, key: str, generator: random.Random) -> list[list[str]]:
        return [self._point(key, anchor, generator) for anchor in self._nominal[key]]

    def _point(self, key: str, nominal: tuple[Decimal, ...], generator: random.Random) -> list[str]:
        """Return a point, each of the coordinates that are to be moved by a draw of its own."""
        axes = zip(nominal, self.spreads[key].axes, strict=True)
        return [self._moved(key, x, generator) if moves else text_of(x) for x, moves in axes]


def _decimal(value: Fraction) -> Decimal:
    return Decimal(decimal_text(value))


def stiffness_of(robot: Robot) -> list[Fraction]:
    """Return k in N/m or EA in N of every cable, as its file gives it."""
    found = []
    for cable in robot.cables:
        assert cable.elasticity is not None
        k = cable.elasticity.stiffness
        given = cable.elasticity.axial_stiffness if k is None else k
        assert given is not None
        found.append(exact(given))
    return found


def expansion_of(
    index: int, block: job_schema.ProblemBlock, robot: Robot, settings: Settings, base: Path
) -> Expansion:
    """Return the jobs of a problem for a robot.

    Parameters
    ----------
    index : int
        Number of the problem in the job file.
    block : ProblemBlock
    robot : Robot
    settings : Settings
        The question must make sense with them.
    base : Path
        Folder to which names of files are relative.

    Raises
    ------
    InputError
        With one message per error.
    """
    asked: dict[str, Any] = {}
    if block.taut is not None:
        asked["taut"] = block.taut
    if block.external_force_N is not None:
        asked["external_force_N"] = [decimal_text(x) for x in block.external_force_N]
    if block.tension_N is not None:
        asked["tension_N"] = [decimal_text(x) for x in block.tension_N]
    found = _expansion(index, block, robot, asked, base)
    # Subset, force and options are wrong for all jobs or for none: any lengths will do.
    problem_of(robot, asked, [1.0] * len(robot.cables), settings)
    if settings.split is not None and isinstance(found, PoseGrid) and class_of(robot).turns:
        raise InputError("options.split: not for poses, whose lengths are known to the workers only")
    return found


def _expansion(
    index: int, block: job_schema.ProblemBlock, robot: Robot, asked: dict[str, Any], base: Path
) -> Expansion:
    names = robot.cable_names
    if isinstance(block, job_schema.LengthsBlock):
        errors = InputErrors()
        rows = [
            errors.read(read_lengths, row, names, f"lengths_m[{i}]") or ()
            for i, row in enumerate(block.lengths_m)
        ]
        errors.require_none()
        return Listed(index, robot, asked, tuple(rows))
    if isinstance(block, job_schema.CsvBlock):
        return Listed(index, robot, asked, read_table(base / block.file, block.file, names))
    # What follows draws around exact numbers, or asks `ik`, which takes no others.
    require_treated(robot, uncertain_data(robot, asker="poses and perturbations"))
    if isinstance(block, job_schema.PosesBlock):
        if block.settle and robot.has_legs:
            raise InputError("settle: is for cables, legs hold the pose that is asked for")
        return PoseGrid(index, robot, asked, _axes(block, robot), bool(block.settle))
    assert isinstance(block, job_schema.MonteCarloBlock)
    lengths = read_lengths(block.lengths_m, names, "lengths_m")
    spreads = {key: Spread.of(spread) for key, spread in block.perturb if spread is not None}
    _check_spreads(spreads, robot, lengths)
    return MonteCarlo(index, robot, asked, lengths, block.samples, block.seed, spreads)


def _axes(block: job_schema.PosesBlock, robot: Robot) -> tuple[tuple[Fraction, ...], ...]:
    position, orientation = block.position_m, block.orientation_deg
    if orientation is not None and not class_of(robot).turns:
        raise InputError("orientation_deg: a point mass has none")
    turns = [None] * 3 if orientation is None else [orientation.roll, orientation.pitch, orientation.yaw]
    return tuple(_places(axis) for axis in (position.x, position.y, position.z, *turns))


def _places(axis: Fraction | job_schema.AxisBlock | None) -> tuple[Fraction, ...]:
    if not isinstance(axis, job_schema.AxisBlock):
        return (axis or Fraction(0),)
    step = (axis.end - axis.start) / max(axis.count - 1, 1)
    return tuple(axis.start + k * step for k in range(axis.count))


def _check_spreads(spreads: dict[str, Spread], robot: Robot, lengths: tuple[LengthRange, ...]) -> None:
    """Raise `InputError` for what cannot be drawn for a robot, or could become zero."""
    errors = []
    if "stiffness" in spreads:
        if not robot.is_elastic:
            errors.append(f"perturb.stiffness: the cables of {quote(robot.name)} do not stretch")
        if not spreads["stiffness"].is_relative:
            errors.append("perturb.stiffness: needs a relative width")
        elif spreads["stiffness"].furthest >= 1:
            errors.append("perturb.stiffness: could become zero")
    for key in ("frame_anchors_m", *OF_PLATFORMS):
        if key in spreads and spreads[key].is_relative:
            errors.append(f"perturb.{key}: needs an absolute width")
    for key in OF_PLATFORMS:
        if key in spreads and not class_of(robot).turns:
            errors.append(f"perturb.{key}: {quote(robot.name)} is a point mass")
    if "lengths_m" in spreads and any(spreads["lengths_m"].reaches_zero(lo) for lo, _ in lengths):
        errors.append("perturb.lengths_m: a length could become zero")
    if "mass_kg" in spreads and spreads["mass_kg"].reaches_zero(exact(robot.platform.mass)):
        errors.append("perturb.mass_kg: could become zero")
    if errors:
        raise InputError(*errors)
