"""Exact eliminants and the interval search find the same poses: both directions, random robots."""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Robot
from solvers import polynomial_report, pose_from_tensions
from solvers.polynomial import agreement

SEED = 20261123
ZERO = (Fraction(0), Fraction(0), Fraction(0))


def random_robot(generator: random.Random, count: int, elastic: bool) -> Robot:
    """Return a point mass under a ceiling that is not quite flat; numbers of one decimal."""

    def tenths(lo: int, hi: int) -> Fraction:
        return Fraction(generator.randint(lo, hi), 10)

    corners = [(-20, -20), (20, -20), (-20, 20), (20, 20)]
    cables = []
    for k in range(count):
        x, y = corners[k]
        exit_point = (tenths(x - 8, x + 8), tenths(y - 8, y + 8), tenths(0, 5))
        spring = Elasticity(stiffness=Fraction(generator.randint(5, 20) * 100)) if elastic else None
        cables.append(Cable(f"c{k + 1}", exit_point, ZERO, spring))
    gravity = (Fraction(0), Fraction(0), Fraction(-10))
    return Robot("random", Platform(Fraction(generator.randint(20, 80))), tuple(cables), gravity)


def random_lengths(generator: random.Random, robot: Robot) -> list[Fraction]:
    """Return lengths that more or less fit a pose under the exit points."""
    shares = np.array([generator.uniform(0.2, 1) for _ in robot.cables])
    exits = np.array([[float(v) for v in c.frame_anchor] for c in robot.cables])
    pose = shares / shares.sum() @ exits - [0, 0, generator.uniform(2, 4)]
    away = [np.linalg.norm(np.array([float(v) for v in c.frame_anchor]) - pose) for c in robot.cables]
    return [Fraction(round(1000 * d) - generator.randint(30, 50), 1000) for d in away]


@pytest.mark.parametrize(
    ("seed", "count", "elastic"),
    [(k, 2, True) for k in range(6)] + [(k, 3, True) for k in range(8)]
    + [pytest.param(k, 4, True, marks=pytest.mark.slow) for k in range(2)]
    + [(k, 2, False) for k in range(2)] + [(k, 3, False) for k in range(2)],
)  # fmt: skip
def test_every_root_is_in_one_box_and_every_box_holds_one_root(seed: int, count: int, elastic: bool):
    generator = random.Random(SEED + 100 * count + seed)
    robot = random_robot(generator, count, elastic)
    report = polynomial_report(robot, random_lengths(generator, robot))
    assert report.comparison.agrees, report.comparison.text
    true = sum(degree for degree, is_true, _, _ in report.factors if is_true)
    assert true == ({2: 6, 3: 22, 4: 80}[count] if elastic else 2)
    assert count == 4 or sum(root.is_static for root in report.roots) == 1


@pytest.mark.parametrize("seed", range(3))
def test_given_tensions_agree_with_their_eliminant(seed: int):
    generator = random.Random(SEED + seed)
    robot = random_robot(generator, 3, False)
    load = 10 * float(robot.platform.mass)
    tensions = [Fraction(round(load * generator.uniform(0.3, 0.7))) for _ in range(3)]
    report = polynomial_report(robot, tensions=tensions)
    assert report.comparison.agrees, report.comparison.text
    assert sum(degree for degree, is_true, _, _ in report.factors if is_true) == 14


def test_two_cables_of_a_platform_agree():
    report = polynomial_report(load_robot("uc2"), ["7.5", "8"])
    assert report.comparison.agrees and [f[0] for f in report.factors] == [12, 12]
    assert len(report.roots) == 12 and sum(root.is_static for root in report.roots) == 8


@pytest.mark.slow
def test_a_difference_is_noticed():
    """A report whose poses are not the solver's says so: one pose too few, one moved."""
    robot = load_robot("merlet_4_1")
    report = polynomial_report(robot, tensions="400,430,210,240")
    result = pose_from_tensions(robot, "400,430,210,240")
    assert report.comparison.agrees and agreement(report, result, range(4)).agrees
    other = pose_from_tensions(robot, "400,430,210,241")
    assert agreement(report, other, range(4)).agrees is False
    report.roots = []
    assert agreement(report, result, range(4)).agrees is False
