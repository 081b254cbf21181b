"""A point mass that hangs on the first of two cables: its one pose is known in closed form."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np

from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.reader import parse_robot
from solvers.answers.data import (
    Answer,
    CableState,
    Certainty,
    Nominal,
    Outcome,
    Proof,
    Solution,
    StopReason,
    SubsetReport,
    Undecided,
)

TEXT = """\
format: cdpr-robot/1
name: hanging
platform: {mass_kg: 10}
cables:
  - {name: c1, frame_anchor_m: [0, 0, 0], platform_anchor_m: [0, 0, 0]}
  - {name: c2, frame_anchor_m: [4, 0, 0], platform_anchor_m: [0, 0, 0]}
"""
LENGTHS = ["2", "5"]
WEIGHT = 98.1


def robot() -> Robot:
    return parse_robot(TEXT, "hanging.yaml")


def around(values: object, width: float = 1e-9) -> np.ndarray:
    """Return bounds at a distance of half the width around each value."""
    middle = np.asarray(values, dtype=np.float64)
    return np.stack([middle - width / 2, middle + width / 2], axis=-1)


def solution() -> Solution:
    tensions = around([WEIGHT, 0.0])
    tensions[1] = 0.0
    return Solution(
        taut=(0,),
        cable_states=(CableState.TAUT, CableState.SLACK),
        position=around([0.0, 0.0, -2.0]),
        rotation=around(np.eye(3), 0.0),
        height=around(-2.0),
        tensions=tensions,
        distances=around([2.0, 20.0**0.5]),
        slack_respected=True,
        existence=Certainty.PROVED,
        uniqueness=Certainty.PROVED,
        proof=Proof.CONVEXITY,
        stability=Stability.STABLE,
        nominal=Nominal((0.0, 0.0, -2.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        family=None,
    )


def answer() -> Answer:
    subsets = tuple(
        SubsetReport(taut, Outcome.COMPLETE, int(taut == (0,)), 7, 0.25) for taut in ((0, 1), (1,), (0,))
    )
    return Answer((solution(),), subsets=subsets, cells=21)


def no_answer() -> Answer:
    return Answer((), message="cables c1 and c2 are too short to meet")


def open_answer() -> Answer:
    """Return one solution with an undecided cable, an undecided cluster and pending cells."""
    states = (CableState.TAUT, CableState.UNDECIDED)
    tensions = around([WEIGHT, 0.0])
    tensions[1] = (0.0, np.inf)
    entry = replace(
        solution(), cable_states=states, slack_respected=None, tensions=tensions, note="c2 is just taut"
    )
    cluster = Undecided((1, 0), 3, "singular", around([1 / 3, 0.0, -2.0]), around(np.eye(3), 0.0))
    return Answer((entry,), (cluster,), 12, stop_reason=StopReason.TIME_LIMIT, cells=100)


def exact(*numbers: str) -> list[tuple[Fraction, Fraction]]:
    return [(Fraction(number), Fraction(number)) for number in numbers]
