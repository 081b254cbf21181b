"""A robot in a JSON document, exactly, and back: what was really solved.

A robot that was read from a file is the text of that file, so its digest is kept, and ``jq -r`` gives the
file back. One that was made or changed in memory is a ``cdpr-robot/1`` document whose numbers are texts: JSON
readers round numbers to doubles.
"""

from __future__ import annotations

import re
from decimal import Decimal
from fractions import Fraction
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.exact.decimals import exact_text
from cdpr_interval.robots.cable_robot import Robot
from solvers.answers.json_text import Json

LONGEST = 1000
"""Digits of a decimal: as many as readers take."""
WORDS = ("format", "name", "source", "notes")
"""Keys whose texts are no numbers."""
_QUOTIENT = re.compile(r"-?[0-9]+/[1-9][0-9]*")


def robot_to_json(robot: Robot) -> str | Json:
    """Return the file of a robot, or its data: decimals in texts, p/q where no decimal is exact."""
    if robot.file is not None:
        return robot.file.decode("utf-8")
    document: Json = _texts(robot.to_dict())
    return document


def robot_from_json(data: Any) -> Robot:
    """Return the robot of a file's text or of data; `ValueError` where they are none."""
    if not isinstance(data, str | dict):
        raise ValueError("must be the text of a robot file, or the data of a robot")
    # Files are read by pydantic, which a result that was just computed does without.
    from cdpr_interval.robots.formats.reader import parse_robot

    try:
        return parse_robot(data, "file") if isinstance(data, str) else Robot.from_dict(_numbers(data))
    except InputError as error:
        raise ValueError(f"must be a robot ({'; '.join(error.messages)})") from None


def _texts(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _texts(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_texts(entry) for entry in value]
    if isinstance(value, int | Decimal | Fraction) and not isinstance(value, bool):
        return exact_text(Fraction(value), LONGEST)
    return value


def _numbers(value: Any) -> Any:
    """Return the data with quotients as fractions; other texts are read as decimals."""
    if isinstance(value, dict):
        return {key: entry if key in WORDS else _numbers(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_numbers(entry) for entry in value]
    return Fraction(value) if isinstance(value, str) and _QUOTIENT.fullmatch(value) else value
