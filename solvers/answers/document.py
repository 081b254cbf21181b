"""Results as ``cdpr-result/1`` documents and back, every double restored.

A bound that is infinite (a tension nothing bounds) is written as null.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from enum import StrEnum
from typing import Any, TypeVar

import numpy as np

from cdpr_interval.errors import InputError
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.stability import Stability
from solvers.answers.data import (
    FORMAT,
    CableState,
    Certainty,
    Family,
    Nominal,
    Outcome,
    Proof,
    Question,
    ResultData,
    RobotIdentity,
    Solution,
    Statistics,
    StopReason,
    SubsetReport,
    Tool,
    Undecided,
)
from solvers.answers.json_text import Json

T = TypeVar("T")
S = TypeVar("S", bound=StrEnum)
R = TypeVar("R", bound=ResultData)


def result_to_dict(result: ResultData) -> Json:
    """Return the document, its keys in the order of the format."""
    names = result.cables
    question = result.question
    return {
        "format": FORMAT,
        "tool": {"name": result.tool.name, "version": result.tool.version},
        "robot": {"name": result.robot.name, "sha256": result.robot.sha256},
        "model": result.model,
        "cables": list(names),
        "lengths_m": numbers(result.lengths),
        "question": {
            "command": question.command,
            "taut": None if question.taut is None else _names(question.taut, names),
            "ignore_slack": question.ignore_slack,
            "ignore_tension_sign": question.ignore_tension_sign,
            "method": str(question.method),
            "precision": question.precision,
            "external_force_N": list(question.external_force),
            **_given(question),
        },
        "outcome": result.outcome.value,
        "stop_reason": result.stop_reason.value,
        "message": result.message,
        "solutions": [_solution_to_dict(solution, names) for solution in result.solutions],
        "undecided": [
            {
                "taut": _names(cluster.taut, names),
                "cells": cluster.cells,
                "reason": cluster.reason,
                "position_m": numbers(cluster.position),
                "rotation": numbers(cluster.rotation),
            }
            for cluster in result.undecided
        ],
        "pending": result.pending,
        "subsets": [
            {
                "taut": _names(subset.taut, names),
                "outcome": subset.outcome.value,
                "solutions": subset.solutions,
                "cells": subset.cells,
                "time_s": subset.time,
            }
            for subset in result.subsets
        ],
        "statistics": {
            "cells": result.statistics.cells,
            "time_s": result.statistics.time,
            "threads": result.statistics.threads,
        },
    }


def _given(question: Question) -> Json:
    given = question.tensions_given
    return {} if given is None else {"tensions_given_N": [list(pair) for pair in given]}


def _solution_to_dict(solution: Solution, names: Sequence[str]) -> Json:
    document: Json = {
        "taut": _names(solution.taut, names),
        "cable_states": [state.value for state in solution.cable_states],
        "position_m": numbers(solution.position),
        "rotation": numbers(solution.rotation),
        "height_m": numbers(solution.height),
        "tensions_N": numbers(solution.tensions),
        "distances_m": numbers(solution.distances),
        "slack_respected": "undecided" if solution.slack_respected is None else solution.slack_respected,
        "existence": solution.existence.value,
        "uniqueness": solution.uniqueness.value,
        "proof": solution.proof.value,
        "stability": solution.stability.value,
        "nominal": {
            "position_m": [float(x) for x in solution.nominal.position],
            "quaternion_wxyz": [float(x) for x in solution.nominal.quaternion_wxyz],
            "rpy_rad": [float(x) for x in solution.nominal.rpy],
        },
        "family": None if solution.family is None else _family_to_dict(solution.family),
    }
    if solution.note:
        document["note"] = solution.note
    return document


def _family_to_dict(family: Family) -> Json:
    return {
        "kind": family.kind,
        "axis_point_m": None if family.axis_point is None else numbers(family.axis_point),
        "axis_direction": None if family.axis_direction is None else numbers(family.axis_direction),
        "angle_ranges_rad": numbers(family.angle_ranges),
    }


def _names(indices: Sequence[int], names: Sequence[str]) -> list[str]:
    return [names[index] for index in indices]


def numbers(bounds: Bounds) -> Any:
    """Return bounds as lists, with null for those that are infinite."""
    values = np.asarray(bounds, dtype=np.float64)
    return values.tolist() if np.isfinite(values).all() else _finite(values.tolist())


def _finite(value: Any) -> Any:
    if isinstance(value, list):
        return [_finite(entry) for entry in value]
    if math.isnan(value):
        raise ValueError("a bound of a result is NaN")
    return value if math.isfinite(value) else None


def result_from_json(source: str | bytes | Mapping[str, Any], kind: type[R]) -> R:
    """Return the result of class ``kind`` a ``cdpr-result/1`` document describes; unknown keys are ignored.

    Raises
    ------
    InputError
        The text is not JSON, has another format, or a key is missing or of a wrong kind.
    """
    root = _Reader(_parse(source), "result")
    if (found := root.value("format")) != FORMAT:
        raise InputError(f"result.format: must be '{FORMAT}', is {found!r}")
    names = tuple(str(name) for name in root.value("cables"))
    count = len(names)
    tool, robot, statistics = root.child("tool"), root.child("robot"), root.child("statistics")
    return kind(
        tool=Tool(tool.text("name"), tool.text("version")),
        robot=RobotIdentity(robot.text("name"), robot.text("sha256")),
        model=root.text("model"),
        cables=names,
        lengths=root.bounds("lengths_m", (count, 2)),
        question=_question(root.child("question"), names),
        outcome=root.status("outcome", Outcome),
        stop_reason=root.status("stop_reason", StopReason),
        message=root.text("message"),
        solutions=tuple(_solution(entry, names) for entry in root.children("solutions")),
        undecided=tuple(
            Undecided(
                taut=entry.cables("taut", names),
                cells=entry.integer("cells"),
                reason=entry.text("reason"),
                position=entry.bounds("position_m", (3, 2)),
                rotation=entry.bounds("rotation", (3, 3, 2)),
            )
            for entry in root.children("undecided")
        ),
        pending=root.integer("pending"),
        subsets=tuple(
            SubsetReport(
                taut=entry.cables("taut", names),
                outcome=entry.status("outcome", Outcome),
                solutions=entry.integer("solutions"),
                cells=entry.integer("cells"),
                time=entry.number("time_s"),
            )
            for entry in root.children("subsets")
        ),
        statistics=Statistics(
            statistics.integer("cells"), statistics.number("time_s"), statistics.integer("threads")
        ),
    )


def _parse(source: str | bytes | Mapping[str, Any]) -> Any:
    if isinstance(source, Mapping):
        return source
    try:
        return json.loads(source)
    except (ValueError, RecursionError) as error:
        raise InputError(f"result: not valid JSON: {error}") from None


def _question(entry: _Reader, names: Sequence[str]) -> Question:
    fx, fy, fz = entry.floats("external_force_N", 3)
    return Question(
        taut=None if entry.value("taut") is None else entry.cables("taut", names),
        ignore_slack=entry.boolean("ignore_slack"),
        ignore_tension_sign=entry.boolean("ignore_tension_sign"),
        method=entry.text("method"),
        precision=entry.number("precision"),
        external_force=(fx, fy, fz),
        command=entry.text("command"),
        tensions_given=_tensions_given(entry, len(names)),
    )


def _tensions_given(entry: _Reader, count: int) -> tuple[tuple[float, float], ...] | None:
    if not entry.has("tensions_given_N"):
        return None
    return tuple((lo, hi) for lo, hi in entry.bounds("tensions_given_N", (count, 2)).tolist())


def _solution(entry: _Reader, names: Sequence[str]) -> Solution:
    count = len(names)
    nominal = entry.child("nominal")
    (x, y, z), (roll, pitch, yaw) = nominal.floats("position_m", 3), nominal.floats("rpy_rad", 3)
    qw, qx, qy, qz = nominal.floats("quaternion_wxyz", 4)
    undecided_slack = entry.value("slack_respected") == "undecided"
    return Solution(
        taut=entry.cables("taut", names),
        cable_states=entry.statuses("cable_states", CableState),
        position=entry.bounds("position_m", (3, 2)),
        rotation=entry.bounds("rotation", (3, 3, 2)),
        height=entry.bounds("height_m", (2,)),
        tensions=entry.bounds("tensions_N", (count, 2)),
        distances=entry.bounds("distances_m", (count, 2)),
        slack_respected=None if undecided_slack else entry.boolean("slack_respected"),
        proof=entry.status("proof", Proof),
        stability=entry.status("stability", Stability),
        nominal=Nominal((x, y, z), (qw, qx, qy, qz), (roll, pitch, yaw)),
        family=None if entry.value("family") is None else _family(entry.child("family")),
        note=entry.text("note") if entry.has("note") else "",
        existence=entry.status("existence", Certainty),
        uniqueness=entry.status("uniqueness", Certainty),
    )


def _family(entry: _Reader) -> Family:
    kind = entry.text("kind")
    shape = (2, 3, 2) if kind == "torus" else (3, 2)
    has_axis = entry.value("axis_point_m") is not None
    return Family(
        kind=kind,
        axis_point=entry.bounds("axis_point_m", shape) if has_axis else None,
        axis_direction=entry.bounds("axis_direction", shape) if has_axis else None,
        angle_ranges=entry.bounds("angle_ranges_rad", (len(entry.value("angle_ranges_rad")), 2, 2)),
    )


class _Reader:
    """A JSON object and its path; every access checks the kind it asks for."""

    def __init__(self, document: Any, path: str) -> None:
        if not isinstance(document, Mapping):
            raise InputError(f"{path}: must be an object")
        self._document = document
        self._path = path

    def has(self, key: str) -> bool:
        return key in self._document

    def value(self, key: str) -> Any:
        try:
            return self._document[key]
        except KeyError:
            raise InputError(f"{self._path}.{key}: missing") from None

    def _checked(self, key: str, read: Callable[[Any], T], kind: str) -> T:
        try:
            return read(self.value(key))
        except (TypeError, ValueError, KeyError, OverflowError):
            raise InputError(f"{self._path}.{key}: must be {kind}") from None

    def child(self, key: str) -> _Reader:
        return _Reader(self.value(key), f"{self._path}.{key}")

    def children(self, key: str) -> list[_Reader]:
        entries = self._checked(key, _list, "a list")
        return [_Reader(entry, f"{self._path}.{key}[{i}]") for i, entry in enumerate(entries)]

    def text(self, key: str) -> str:
        return self._checked(key, _text, "a text")

    def boolean(self, key: str) -> bool:
        return self._checked(key, _boolean, "true or false")

    def integer(self, key: str) -> int:
        return self._checked(key, _integer, "a whole number")

    def number(self, key: str) -> float:
        return self._checked(key, _number, "a number")

    def floats(self, key: str, count: int) -> list[float]:
        def read(value: Any) -> list[float]:
            if len(_list(value)) != count:
                raise ValueError
            return [_number(entry) for entry in value]

        return self._checked(key, read, f"a list of {count} numbers")

    def bounds(self, key: str, shape: tuple[int, ...]) -> Bounds:
        return self._checked(key, lambda value: _bounds(value, shape), f"numbers in the shape {shape}")

    def status(self, key: str, kind: type[S]) -> S:
        return self._checked(key, kind, "one of " + ", ".join(kind))

    def statuses(self, key: str, kind: type[S]) -> tuple[S, ...]:
        return self._checked(key, lambda v: tuple(kind(e) for e in _list(v)), "a list of " + ", ".join(kind))

    def cables(self, key: str, names: Sequence[str]) -> tuple[int, ...]:
        return self._checked(key, lambda v: tuple(names.index(e) for e in _list(v)), "a list of cable names")


def _list(value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise TypeError
    return value


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError
    return value


def _boolean(value: Any) -> bool:
    if not isinstance(value, bool):
        raise TypeError
    return value


def _integer(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise TypeError
    return value


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError
    return float(value)


def _bounds(value: Any, shape: tuple[int, ...]) -> Bounds:
    """Return the array; null is an infinite bound, its sign given by its place in the pair."""

    def read(entry: Any, depth: int, place: int) -> Any:
        if depth < len(shape):
            if len(_list(entry)) != shape[depth]:
                raise ValueError
            return [read(e, depth + 1, i) for i, e in enumerate(entry)]
        if entry is None:
            return -math.inf if place == 0 else math.inf
        return _number(entry)

    return np.array(read(value, 0, 0), dtype=np.float64).reshape(shape)
