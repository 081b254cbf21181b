"""Cables over random pulleys of all kinds, points of their ranges, and anchors near and far."""

from __future__ import annotations

import math
from fractions import Fraction as F
from random import Random

import numpy as np
from flint import arb
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.exact.range import Range
from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.cables.law import Route, model_of
from cdpr_interval.robots.cable_robot import Cable, Platform, Robot
from cdpr_interval.robots.numbers import Point, Scalar
from cdpr_interval.robots.pulley import BISECTOR, EXACT, Pulley

ORIGIN: Vector = (F(0), F(0), F(0))
KINDS = ((1, EXACT), (2, EXACT), (2, BISECTOR))
"""Joints and balance."""


def robot_of(pulley: Pulley | None, point: Point) -> Robot:
    """Return a robot of one cable with its point A."""
    return Robot("r", Platform(1), (Cable("c", point, ORIGIN, pulley=pulley),))


def route_of(pulley: Pulley | None, point: Point = ORIGIN) -> Route:
    """Return the route of a cable with its point A."""
    robot = robot_of(pulley, point)
    return model_of(robot.cables[0], robot.gravity).route


def random_point(rng: Random) -> Vector:
    """Return a point A, m."""
    return F(rng.randint(-3000, 3000), 1000), F(rng.randint(-3000, 3000), 1000), F(rng.randint(0, 5000), 1000)


def random_pulley(rng: Random, kind: tuple[int, str] | None = None, roomy: bool = False) -> Pulley:
    """Return a pulley of a kind, of any without one; ``roomy``: the rope arrives from far below."""
    joints, balance = kind or rng.choice(KINDS)
    radius = F(rng.randint(5, 100), 1000)
    longer = rng.choice(
        [None, F(rng.randint(0, 60), 1000), F(rng.randint(0, 60), 1000), F(rng.randint(0, 999), 1000)]
    )
    axis = (F(rng.randint(-5, 5), 7), F(rng.randint(-5, 5), 3), F(rng.randint(1, 5) * rng.choice([-1, 1]), 2))
    lead_in = F(rng.randint(1000, 5000), 1000)
    if not roomy:
        lead_in = rng.choice([lead_in, F(rng.randint(1, 400), 1000), F(0) if joints == 1 else F(1, 5)])
    arm = None if longer is None else radius + longer
    if roomy and arm is not None:
        arm = radius + (arm - radius) / 10
    return Pulley(radius, arm, joints, rng.choice([None, axis]), lead_in, balance)


def with_ranges(pulley: Pulley, rng: Random) -> Pulley:
    """Return it with ranges around some of its numbers."""

    def around(x: F, least: F | None = None) -> Scalar:
        half = F(10 ** rng.uniform(-9, -3)).limit_denominator(10**12)
        lo = x - half if least is None else max(x - half, least)
        return x if rng.random() < 0.4 else Range(lo, max(x + half, lo))

    tiny = pulley.radius / 2
    radius = around(pulley.radius, tiny)
    top = radius.hi if isinstance(radius, Range) else radius
    arm = None if pulley.arm is None else around(max(pulley.arm, top), top)
    axis = None if pulley.axis is None else (around(pulley.axis[0]), around(pulley.axis[1]), pulley.axis[2])
    lead_in = pulley.lead_in if pulley.lead_in == 0 else around(pulley.lead_in, pulley.lead_in / 2)
    return Pulley(radius, arm, pulley.joints, axis, lead_in, pulley.balance)


def pick(value: Scalar, rng: Random) -> F:
    """Return a number of a range: an end of it or one between."""
    if not isinstance(value, Range):
        return value
    return value.lo + (value.hi - value.lo) * rng.choice([F(0), F(1), F(rng.randint(0, 100), 100)])


def sample(pulley: Pulley, rng: Random) -> Pulley:
    """Return one with numbers of the ranges."""
    axis = pulley.axis
    return Pulley(
        pick(pulley.radius, rng),
        None if pulley.arm is None else pick(pulley.arm, rng),
        pulley.joints,
        None if axis is None else (pick(axis[0], rng), pick(axis[1], rng), pick(axis[2], rng)),
        pick(pulley.lead_in, rng),
        pulley.balance,
    )


def unit_axis(pulley: Pulley) -> NDArray[np.float64]:
    """Return k in floats."""
    k = np.array([float(x) for x in pulley.middle().axis or (0, 0, 1)])
    return np.asarray(k / np.linalg.norm(k))


def anchor_at(pulley: Pulley, point: Vector, x: float, y: float, rng: Random) -> NDArray[np.float64]:
    """Return an anchor at a distance x > 0 from the axis and y along it from A, m, in any direction."""
    k = unit_axis(pulley)
    v = np.array([rng.gauss(0, 1) for _ in range(3)])
    across = v - (v @ k) * k
    return np.array([float(a) for a in point]) + x * across / np.linalg.norm(across) + y * k


def near_or_far(pulley: Pulley, rng: Random) -> tuple[float, float]:
    """Return a place in the plane of the cable: next to the pulley, next to the axis or anywhere."""
    r, h = float(pulley.middle().radius), float(pulley.middle().arm_length)
    case = rng.random()
    if case < 0.35:
        delta = math.pi / 2 if pulley.joints == 1 else rng.uniform(0, 2)
        turn, distance = rng.uniform(-math.pi, math.pi), r * (1 + 10 ** rng.uniform(-6, 0.5))
        x = h * math.sin(delta) + distance * math.cos(turn)
        return abs(x), -h * math.cos(delta) + distance * math.sin(turn)
    if case < 0.55:
        return 10 ** rng.uniform(-8, 0), rng.uniform(-3, 3) * rng.choice([0.1, 1])
    return rng.uniform(0.001, 4), rng.uniform(-4, 2)


def as_balls(x: NDArray[np.float64]) -> tuple[arb, arb, arb]:
    """Return a point of doubles exactly."""
    a, b, c = (balls.from_fraction(F(float(v))) for v in x)
    return a, b, c
