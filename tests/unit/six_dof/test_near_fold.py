"""Two poses close together: both are proved, and nothing between them stays open."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval.exact.vector import Vector
from cdpr_interval.robots.cable_robot import Cable, Platform, Robot
from solvers import forward_kinematics
from solvers.answers.data import Outcome


def vector(text: str) -> Vector:
    x, y, z = (Fraction(v) for v in text.split())
    return (x, y, z)


TWO = (("8.69 6.73 -0.9", "-0.85 -0.28 -0.03"), ("3.58 1.32 0.55", "1.33 0.83 0.15"))
THREE = (
    ("7.71 9.7 0.91", "0.98 -0.73 -0.72"),
    ("4.95 9.9 0.55", "0.04 -0.74 1.07"),
    ("0.78 3.12 -0.25", "0.13 0.19 0.48"),
)


@pytest.mark.parametrize(
    ("cables", "lengths", "count", "gap"),
    [
        (TWO, ("8.47", "11.6719199729"), 4, 4e-3),
        (THREE, ("7.84", "7.6767643335", "3.65"), 5, 1e-3),
    ],
)
def test_poses_near_a_fold_are_proved_to_be_all(
    cables: tuple[tuple[str, str], ...], lengths: tuple[str, ...], count: int, gap: float
) -> None:
    made = tuple(Cable(f"c{k}", vector(a), vector(b)) for k, (a, b) in enumerate(cables))
    robot = Robot("near fold", Platform(Fraction(1)), made, vector("0 0 -9.81"))
    result = forward_kinematics(robot, lengths, taut=range(len(cables)))
    assert result.outcome is Outcome.COMPLETE
    assert len(result.solutions) == count
    places = np.array([s.position.mean(axis=1) for s in result.solutions])
    apart = np.linalg.norm(places[:, None] - places[None], axis=2) + 1e3 * np.eye(count)
    assert apart.min() < gap
