"""What is known of the cables between two runs: ``cdpr-winch-state/1``, written whole or not at all."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

from cdpr_interval.driver.reference import Known, Reference, ReferenceState
from cdpr_interval.driver.winch import WinchModel
from cdpr_interval.errors import InputError
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.cable_robot import Robot

STATE_FORMAT = "cdpr-winch-state/1"
LARGEST_FILE = 1_000_000
"""Bytes."""


def write_state(path: Path, robot: Robot, known: Sequence[Known | None]) -> None:
    """Write what is known of all cables.

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    cables: dict[str, Any] = {}
    for name, one in zip(robot.cable_names, known, strict=True):
        if one is not None:
            reference = one.reference
            cables[name] = {
                "state": one.state.value,
                "source": reference.source,
                "zero_counts": reference.model.zero,
                "reference_counts": reference.counts,
                "reference_length_m": [str(reference.length.lo), str(reference.length.hi)],
                "counts": one.reading,
            }
    content = {
        "format": STATE_FORMAT,
        "robot": {"name": robot.name, "sha256": robot.sha256},
        "cables": cables,
    }
    scratch = path.with_name(path.name + ".new")
    try:
        with scratch.open("w", encoding="utf-8") as stream:
            stream.write(json.dumps(content, indent=1) + "\n")
            stream.flush()
            os.fsync(stream.fileno())
        scratch.replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None


def read_state(path: Path, robot: Robot) -> list[Known | None]:
    """Return what is known of all cables; None where nothing is.

    Raises
    ------
    InputError
        When the file is none, or that of another robot or another version of its file.
    """
    try:
        with path.open("rb") as stream:
            root = json.loads(stream.read(LARGEST_FILE))
        if root["format"] != STATE_FORMAT:
            raise InputError(f"{path}: format: must be '{STATE_FORMAT}', got {root['format']!r}")
        if root["robot"]["sha256"] != robot.sha256:
            raise InputError(f"{path}: is of another robot file ({root['robot']['name']}): home again")
        return [_known(robot, i, root["cables"].get(name)) for i, name in enumerate(robot.cable_names)]
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    except (ValueError, KeyError, TypeError, AttributeError, ZeroDivisionError) as error:
        raise InputError(f"{path}: is no state of winches: {type(error).__name__}: {error}") from None


def _known(robot: Robot, i: int, given: Any) -> Known | None:
    winch = robot.cables[i].winch
    if given is None or winch is None:
        return None
    model = replace(WinchModel(winch), zero=int(given["zero_counts"]))
    lo, hi = (Fraction(text) for text in given["reference_length_m"])
    if not Fraction(0) < lo <= hi:
        raise ValueError("reference_length_m must be positive and ascending")
    reference = Reference(model, int(given["reference_counts"]), Range(lo, hi), str(given["source"]))
    return Known(reference, ReferenceState(given["state"]), int(given["counts"]))
