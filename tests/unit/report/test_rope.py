"""Ropes over pulleys as they are drawn: along their way, on the wheel, as long as the model says."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.mechanics.statics import Pose, static_model
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.pulley import Pulley
from solvers.report.rope import ARC_POINTS, WHEEL_POINTS, course, wheel

X = np.array([0.5, -0.75, 2.0])
NOTHING = (Fraction(0), Fraction(0), Fraction(0))


def over(pulley: Pulley | None) -> Robot:
    robot = load_robot("paty_cdpr4")
    return robot.replace(cables=tuple(cable.replace(pulley=pulley) for cable in robot.cables))


PULLEYS = {
    "one joint": Pulley(radius="0.3", arm="0.4", lead_in=4),
    "snug": Pulley(radius="0.3"),
    "two joints": Pulley(radius="0.3", arm="0.4", lead_in=4, joints=2),
    "tilted": Pulley(radius="0.2", axis=(1, "0.5", 1), lead_in="0.5"),
}


@pytest.mark.parametrize("kind", PULLEYS)
def test_the_drawn_rope_is_as_long_as_its_way(kind: str) -> None:
    robot = over(PULLEYS[kind])
    lengths = static_model(robot, NOTHING).distances(Pose(X, np.eye(3)))
    for cable, length in zip(robot.cables, lengths, strict=True):
        points = course(cable, robot, X)
        drawn = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
        # Chords of the arc are a little shorter than it.
        assert length * (1 - 2e-3) < drawn <= length * (1 + 1e-12)
        assert points[-1].tolist() == X.tolist() and len(points) >= ARC_POINTS


@pytest.mark.parametrize("kind", PULLEYS)
def test_the_rope_touches_the_wheel(kind: str) -> None:
    robot = over(PULLEYS[kind])
    for cable in robot.cables:
        ring = wheel(cable, robot, X)
        assert ring.shape == (2 * WHEEL_POINTS, 3)
        centre = ring.reshape(-1, 2, 3)[:, 0].mean(axis=0)
        radius = float(PULLEYS[kind].radius)
        assert np.linalg.norm(ring - centre, axis=1) == pytest.approx(radius, abs=1e-9)
        away = np.linalg.norm(course(cable, robot, X)[1:-2] - centre, axis=1)
        assert away == pytest.approx(radius, abs=1e-9)


def test_a_fixed_exit_point_is_a_straight_line_without_a_wheel() -> None:
    robot = over(None)
    assert course(robot.cables[0], robot, X).tolist() == [[-2.5, -2.5, 5.0], X.tolist()]
    assert wheel(robot.cables[0], robot, X).size == 0
    plain = over(Pulley(radius=0))
    assert course(plain.cables[0], plain, X).tolist() == [[-2.5, -2.5, 5.0], X.tolist()]


def test_an_anchor_without_a_way_is_drawn_straight() -> None:
    robot = over(PULLEYS["one joint"])
    inside = np.array([-2.5, -2.5, 4.0])
    assert len(course(robot.cables[0], robot, inside)) == 2
