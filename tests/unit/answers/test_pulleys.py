"""Results of robots with pulleys, contradicted without a solver."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cdpr_interval import load_robot
from solvers import forward_kinematics

LENGTHS = ["9.6545", "9.098", "9.9137", "10.9276"]


@pytest.fixture(scope="module")
def found():
    robot = load_robot("paty_cdpr4")
    return robot, forward_kinematics(robot, LENGTHS)


def changed(result, **fields):
    (entry,) = result.solutions
    return replace(result, solutions=(replace(entry, **fields),))


def test_a_right_result_is_not_contradicted(found) -> None:
    robot, result = found
    assert len(result.solutions) == 1 and result.verify(robot) == []


@pytest.mark.parametrize(
    ("field", "by", "said"),
    [
        ("distances", 1e-6, "not the length of the way over the pulley"),
        ("tensions", np.array([1.0, 0, 0, 0])[:, None], "no equilibrium over the box"),
        ("position", 1e-6, "not the length of the way over the pulley"),
    ],
)
def test_a_changed_number_is_seen(found, field, by, said) -> None:
    robot, result = found
    wrong = changed(result, **{field: getattr(result.solutions[0], field) + by})
    assert any(said in text for text in wrong.verify(robot))


def test_another_pulley_is_seen(found) -> None:
    robot, result = found
    wider = robot.replace(
        cables=tuple(c.replace(pulley=c.pulley.replace(radius="0.067")) for c in robot.cables)
    )
    assert any("way over the pulley" in text for text in result.verify(wider))
