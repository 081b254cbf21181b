"""What a ledger keeps of a result: no times, no host, nothing the job says; and the whole result again.

Two runs of one job give the same text, bit for bit.
"""

from __future__ import annotations

from typing import Any

from cdpr_interval.robots.cable_robot import Robot
from solvers.answers.data import FORMAT
from solvers.answers.json_text import Json
from solvers.answers.result import Result
from solvers.batch.job import canonical

SHARED = ("format", "tool", "robot", "model", "cables", "question", "statistics", "provenance")
"""Keys of a result that follow from the job, or that no two runs share."""
CERTAIN = {"existence": "proved", "uniqueness": "proved"}
"""Of nearly every solution: left out where it is so."""
POINT_MASS = "point-mass"
IDENTITY = [[[float(i == j)] * 2 for j in range(3)] for i in range(3)]
NO_TURN = {"quaternion_wxyz": [1.0, 0.0, 0.0, 0.0], "rpy_rad": [0.0, 0.0, 0.0]}


def answer_text(result: Result) -> str:
    """Return what is kept of a result."""
    document = result.to_dict()
    for key in SHARED:
        del document[key]
    document["subsets"] = [[list(s.taut), s.outcome.value, s.solutions, s.cells] for s in result.subsets]
    for solution in document["solutions"]:
        for key, usual in CERTAIN.items():
            if solution[key] == usual:
                del solution[key]
        if solution["family"] is None:
            del solution["family"]
        if result.model == POINT_MASS:
            del solution["rotation"]
            for key in NO_TURN:
                del solution["nominal"][key]
    for region in document["undecided"]:
        if result.model == POINT_MASS:
            del region["rotation"]
    return canonical(document)


def result_document(answer: Json, robot: Robot, question: Json, tool: Json, provenance: Json) -> Json:
    """Return the ``cdpr-result/1`` document of a kept answer; its times are 0.

    Parameters
    ----------
    answer : dict
        As `answer_text` wrote it.
    robot : Robot
        The robot of the job, perturbed where the job says so.
    question, tool, provenance : dict
        As they stand in the document.
    """
    model = robot.model
    solutions = [_solution(solution, model) for solution in answer["solutions"]]
    undecided = [{"rotation": IDENTITY, **region} for region in answer["undecided"]]
    names = list(robot.cable_names)
    subsets = [
        {
            "taut": [names[i] for i in taut],
            "outcome": outcome,
            "solutions": n,
            "cells": cells,
            "time_s": 0.0,
        }
        for taut, outcome, n, cells in answer["subsets"]
    ]
    cells = sum(subset["cells"] for subset in subsets)
    return {
        "format": FORMAT,
        "tool": tool,
        "robot": {"name": robot.name, "sha256": robot.sha256},
        "model": model,
        "cables": names,
        "question": question,
        **answer,
        "solutions": solutions,
        "undecided": undecided,
        "subsets": subsets,
        "statistics": {"cells": cells, "time_s": 0.0, "threads": 1},
        "provenance": provenance,
    }


def _solution(kept: Json, model: str) -> Json:
    solution: dict[str, Any] = {"family": None, **CERTAIN, **kept}
    if model == POINT_MASS:
        solution["rotation"] = IDENTITY
        solution["nominal"] = {**NO_TURN, **kept["nominal"]}
    return solution
