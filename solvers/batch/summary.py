"""What a batch amounts to: counts by outcome and taut subset, and statistics of every quantity by branch."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from cdpr_interval.exact.range import Range
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.reader import parse_robot
from solvers.batch.branches import Branch, Branches, Points
from solvers.batch.job_file import block_of
from solvers.batch.job_schema import MonteCarloBlock
from solvers.batch.ledger import Ledger, Recorded
from solvers.batch.statistics import circular_statistics, statistics, unwrapped
from solvers.batch.tables import Row, replacing
from solvers.batch.work import Status
from solvers.classes import class_of

FORMAT = "cdpr-batch-summary/1"
FILE = "summary.json"
POSITION = ("x_m", "y_m", "z_m", "height_m")
ORIENTATION = ("roll_deg", "pitch_deg", "yaw_deg")


@dataclass
class Group:
    """The jobs of one problem for one robot."""

    robot: str
    problem: int
    branches: Branches
    statuses: Counter[str] = field(default_factory=Counter)
    undecided: int = 0
    """Jobs that are done and left something open."""
    solutions_per_job: Counter[int] = field(default_factory=Counter)
    taut: Counter[str] = field(default_factory=Counter)
    """Solutions by taut subset."""
    stability: Counter[str] = field(default_factory=Counter)

    def add(self, job: Recorded, rows: Sequence[Row], cables: Sequence[str], turns: bool) -> None:
        """Count one job."""
        self.statuses[job.status.value] += 1
        if job.answer is None:
            return
        self.undecided += rows[0]["outcome"] != "complete"
        self.solutions_per_job[rows[0]["solutions"]] += 1
        poses = [row for row in rows if "solution" in row]
        for row, branch in zip(poses, self.branches.assign(poses), strict=True):
            row["branch"] = branch.number
            self.taut[row["taut"]] += 1
            self.stability[row["stability"]] += 1
            _count(row, branch.numbers, cables, turns)

    def numbers(self) -> dict[str, list[float]]:
        """Return the numbers of all branches together."""
        found: dict[str, list[float]] = {}
        for branch in self.branches.sorted():
            for title, numbers in branch.numbers.items():
                found.setdefault(title, []).extend(numbers)
        return found

    def to_json(self) -> dict[str, Any]:
        """Return the group as plain data."""
        return {
            "robot": self.robot,
            "problem": self.problem,
            "jobs": {status.value: self.statuses[status.value] for status in Status},
            "jobs_with_undecided": self.undecided,
            "solutions_per_job": {str(n): self.solutions_per_job[n] for n in sorted(self.solutions_per_job)},
            "taut_subsets": dict(sorted(self.taut.items(), key=lambda entry: (-entry[1], entry[0]))),
            "stability": dict(sorted(self.stability.items())),
            "quantities": _quantities(self.numbers()),
            "branches": [_branch(branch) for branch in self.branches.sorted()],
        }


def _count(row: Row, counted: dict[str, list[float]], cables: Sequence[str], turns: bool) -> None:
    """Add what is known of a pose to the numbers of its branch; tensions of the cables that are not slack."""
    for title in (*POSITION, *(ORIENTATION if turns else ())):
        numbers = counted.setdefault(title, [])
        if row[title] is not None:
            numbers.append(row[title])
    for name in cables:
        numbers, tension = counted.setdefault(f"tension_{name}_N", []), row[f"tension_{name}_N"]
        if tension:
            numbers.append(tension)


def _quantities(numbers: dict[str, list[float]]) -> dict[str, dict[str, float]]:
    return {
        title: circular_statistics(values) if title in ORIENTATION else statistics(values)
        for title, values in numbers.items()
        if values
    }


def contiguous(numbers: dict[str, list[float]]) -> dict[str, list[float]]:
    """Return the numbers there are, to be drawn: angles beside each other also around half a turn."""
    return {
        title: unwrapped(values) if title in ORIENTATION else values
        for title, values in numbers.items()
        if values
    }


def _branch(branch: Branch) -> dict[str, Any]:
    return {
        "branch": branch.number,
        "stability": branch.stability,
        "taut": branch.taut,
        "solutions": branch.solutions,
        "jobs": branch.jobs,
        "quantities": _quantities(branch.numbers),
    }


def _anchors(robot: Robot) -> Points:
    """Return the platform anchors (N, 3) in m; of a range its middle."""
    anchors = [cable.platform_anchor for cable in robot.cables]
    return np.array([[float(x.mid if isinstance(x, Range) else x) for x in anchor] for anchor in anchors])


class Summary:
    """The summary of a ledger, job by job."""

    def __init__(self, ledger: Ledger) -> None:
        self._ledger = ledger
        self._robots = {digest: parse_robot(data) for digest, (_, _, data) in ledger.robots().items()}
        self._block = block_of(ledger.fact("job_file"))
        self._groups: dict[tuple[int, str], Group] = {}

    @property
    def name(self) -> str | None:
        """What the job file calls the batch."""
        return self._block.name

    @property
    def groups(self) -> list[Group]:
        """By problem and robot, in the order of the jobs."""
        return list(self._groups.values())

    def add(self, job: Recorded, rows: Sequence[Row]) -> None:
        """Count one job with its rows, and write into them to which branch they belong."""
        robot = self._robots[job.robot]
        group = self._groups.get((job.problem, job.robot))
        if group is None:
            is_followed = isinstance(self._block.problems[job.problem], MonteCarloBlock)
            group = Group(robot.name, job.problem, Branches(_anchors(robot), is_followed))
            self._groups[job.problem, job.robot] = group
        group.add(job, rows, robot.cable_names, class_of(robot).turns)

    def to_json(self) -> dict[str, Any]:
        """Return the ``cdpr-batch-summary/1`` document; independent of who solved the jobs, and when."""
        groups = self.groups
        return {
            "format": FORMAT,
            "name": self.name,
            "version": self._ledger.fact("version"),
            "jobs": {status.value: count for status, count in self._ledger.counts().items()},
            "jobs_with_undecided": sum(group.undecided for group in groups),
            "certificates": self._ledger.claims(),
            "groups": [group.to_json() for group in groups],
        }


def write_summary(folder: Path, document: dict[str, Any]) -> Path:
    """Write ``summary.json`` into the batch's folder."""
    text = json.dumps(document, indent=2) + "\n"
    with replacing(folder / FILE) as part:
        part.write_text(text, encoding="utf-8")
    return folder / FILE
