"""What a batch amounts to: counts by outcome and by taut subset, and the statistics of every quantity."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from cdpr_interval.robots.formats.reader import parse_robot
from solvers.batch.ledger import Ledger, Recorded
from solvers.batch.tables import Row, replacing
from solvers.batch.work import Status
from solvers.classes import class_of

FORMAT = "cdpr-batch-summary/1"
FILE = "summary.json"
PERCENTILES = (5, 25, 50, 75, 95)
POSITION = ("x_m", "y_m", "z_m", "height_m")
ORIENTATION = ("roll_deg", "pitch_deg", "yaw_deg")


@dataclass
class Group:
    """The jobs of one problem for one robot."""

    robot: str
    problem: int
    statuses: Counter[str] = field(default_factory=Counter)
    undecided: int = 0
    """Jobs that are done and left something open."""
    solutions_per_job: Counter[int] = field(default_factory=Counter)
    taut: Counter[str] = field(default_factory=Counter)
    """Solutions by taut subset."""
    stability: Counter[str] = field(default_factory=Counter)
    numbers: dict[str, list[float]] = field(default_factory=dict)
    """Of every solution; tensions of the cables that are not slack."""

    def add(self, job: Recorded, rows: Sequence[Row], cables: Sequence[str], turns: bool) -> None:
        """Count one job."""
        self.statuses[job.status.value] += 1
        if job.answer is None:
            return
        self.undecided += rows[0]["outcome"] != "complete"
        self.solutions_per_job[rows[0]["solutions"]] += 1
        for row in rows:
            if "solution" in row:
                self._count(row, cables, turns)

    def _count(self, row: dict[str, Any], cables: Sequence[str], turns: bool) -> None:
        self.taut[row["taut"]] += 1
        self.stability[row["stability"]] += 1
        titles = [*POSITION, *(ORIENTATION if turns else ())]
        for title in titles:
            numbers = self.numbers.setdefault(title, [])
            if row[title] is not None:
                numbers.append(row[title])
        for name in cables:
            numbers, tension = self.numbers.setdefault(f"tension_{name}_N", []), row[f"tension_{name}_N"]
            if tension:
                numbers.append(tension)

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
            "quantities": {title: statistics(values) for title, values in self.numbers.items() if values},
        }


def statistics(values: Sequence[float]) -> dict[str, float]:
    """Return count, mean, least, largest and percentiles."""
    found = {"count": len(values), "mean": math.fsum(values) / len(values)}
    found |= {"min": min(values), "max": max(values)}
    shares = np.percentile(np.array(values), PERCENTILES).tolist()
    return found | {f"p{percent}": value for percent, value in zip(PERCENTILES, shares, strict=True)}


class Summary:
    """The summary of a ledger, job by job."""

    def __init__(self, ledger: Ledger) -> None:
        self._ledger = ledger
        self._robots = {digest: parse_robot(data) for digest, (_, _, data) in ledger.robots().items()}
        self._groups: dict[tuple[int, str], Group] = {}

    def add(self, job: Recorded, rows: Sequence[Row]) -> None:
        """Count one job with its rows."""
        robot = self._robots[job.robot]
        group = self._groups.setdefault((job.problem, job.robot), Group(robot.name, job.problem))
        group.add(job, rows, robot.cable_names, class_of(robot).turns)

    def to_json(self) -> dict[str, Any]:
        """Return the ``cdpr-batch-summary/1`` document; independent of who solved the jobs, and when."""
        groups = list(self._groups.values())
        return {
            "format": FORMAT,
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
