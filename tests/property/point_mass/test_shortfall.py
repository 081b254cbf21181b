"""By how much lengths are too short: never more than they are, and not much less."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdpr_interval.robots.cable_robot import Cable, Platform, Robot
from solvers.point_mass.rationals.emptiness import deepest_point, proves_empty, shortfall
from solvers.questions.problem import Problem
from solvers.six_dof.reach import all_too_short, reach_message, too_short

COORDINATE = st.integers(-50, 50).map(lambda n: Fraction(n, 7))
POINT = st.tuples(COORDINATE, COORDINATE, COORDINATE)
BALLS = st.lists(st.tuples(POINT, st.integers(1, 30).map(lambda n: Fraction(n, 11))), min_size=2, max_size=6)


@given(BALLS, POINT)
def test_no_point_is_nearer_than_the_shortfall_says(balls, point):
    """At any point the worst ball is missed by the shortfall at least: exact, without a solver."""
    exits, radii = [ball[0] for ball in balls], [ball[1] for ball in balls]
    short = Fraction(shortfall(exits, radii))
    assert short >= 0
    distances = [sum(((x - y) ** 2 for x, y in zip(point, a, strict=True)), Fraction(0)) for a in exits]
    if short:
        assert any(d >= (r + short) ** 2 for d, r in zip(distances, radii, strict=True))


@given(BALLS)
def test_the_shortfall_is_sharp_to_three_digits(balls):
    """With a little more than that there is a common point."""
    exits, radii = [ball[0] for ball in balls], [ball[1] for ball in balls]
    short = Fraction(shortfall(exits, radii))
    A, lengths = np.array(exits, dtype=float), np.array(radii, dtype=float)
    weights, _ = deepest_point(A, lengths)
    if not short:
        assert not proves_empty(weights, exits, radii) or float(proven_gap(A, lengths)) < 1e-9
        return
    longer = lengths + float(short) * 1.011
    _, point = deepest_point(A, longer)
    assert (np.linalg.norm(A - point, axis=1) <= longer + 1e-9).all()


def proven_gap(A, lengths):
    """Return in floats by how much the worst ball is missed at the best point."""
    _, point = deepest_point(A, lengths)
    return (np.linalg.norm(A - point, axis=1) - lengths).max()


@pytest.mark.parametrize(("gap", "short"), [("10", "2.00"), ("6.5", "0.250"), ("6", "0"), ("5", "0")])
def test_two_equal_balls(gap: str, short: str):
    exits = [(Fraction(0),) * 3, (Fraction(gap), Fraction(0), Fraction(0))]
    assert str(shortfall(exits, [Fraction(3)] * 2)) == short


def platform(lengths, taut=None) -> Problem:
    """Return three cables to a platform; every two of them can reach it, all three cannot."""
    exits = [(0, 0, 0), (10, 0, 0), (5, 8, 0)]
    anchors = [(-0.5, 0, 0), (0.5, 0, 0), (0, 0.5, 0)]
    cables = tuple(Cable(f"c{i}", a, b) for i, (a, b) in enumerate(zip(exits, anchors, strict=True)))
    bounds = tuple((Fraction(x), Fraction(x)) for x in lengths)
    return Problem(Robot("three", Platform(1), cables), bounds, taut=taut)


def test_cables_of_a_platform_that_are_too_short_all_together():
    problem = platform([4.6, 4.6, 4.6])
    assert all(too_short(problem, i, j) is None for i, j in ((0, 1), (0, 2), (1, 2)))
    short = all_too_short(problem, (0, 1, 2))
    assert 0 < short < 1
    said = "no pose: the cables are too short to reach the platform together; made longer alike, each needs"
    assert reach_message(problem).startswith(said)
    assert all_too_short(platform([6, 6, 6]), (0, 1, 2)) == 0


def test_many_pairs_are_counted():
    corners = [(x, y, z) for x in (0, 9) for y in (0, 9) for z in (0, 9)]
    cables = tuple(Cable(f"c{i}", a, (0, 0, i)) for i, a in enumerate(corners))
    problem = Problem(Robot("box", Platform(1), cables), ((Fraction(1, 10),) * 2,) * 8)
    message = reach_message(problem)
    assert message.count("by at least") == 5 and " and 23 more pairs are too short" in message
