"""Motions held against exact answers: lengths of sampled times and choices, solved on their own."""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np

from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.robots.cable_robot import Robot
from solvers import forward_kinematics
from solvers.answers.data import Solution
from solvers.motions.course import Course
from solvers.motions.data import Segment


def chosen(course: Course, rng: random.Random) -> Course:
    """Return a course of exact lengths: one choice from the ranges of every row."""
    rows = [
        type(row)(row.time, tuple((x, x) for x in (_between(*ends, rng) for ends in row.lengths)))
        for row in course.rows
    ]
    return Course(tuple(rows))


def _between(lo: Fraction, hi: Fraction, rng: random.Random) -> Fraction:
    return lo + (hi - lo) * Fraction(rng.choice((0, 1, rng.random())))


def stable(robot: Robot, lengths: Sequence[Fraction]) -> list[Solution]:
    """Return the stable poses of exact lengths, all of them."""
    result = forward_kinematics(robot, lengths)
    assert not result.undecided and not result.pending
    return [s for s in result.solutions if s.stability == "stable"]


def meet(one: Bounds, other: Bounds, slack: float = 1e-12) -> bool:
    """Return whether bounds have something in common, up to rounding."""
    return bool(((one[..., 0] <= other[..., 1] + slack) & (other[..., 0] <= one[..., 1] + slack)).all())


def fits(pose: Solution, segment: Segment) -> bool:
    """Return whether an exact pose is what a segment says of it."""
    taut, tight = set(segment.taut), {*segment.taut, *segment.switching}
    own = {i for i, state in enumerate(pose.cable_states) if state != "slack"}
    tube: Any = segment.tube
    return (
        taut <= own <= tight
        and meet(pose.position, tube.position)
        and meet(pose.rotation, tube.rotation)
        and meet(pose.tensions, tube.tensions, 1e-9)
    )


def segments_at(segments: Sequence[Segment], time: float) -> list[Segment]:
    """Return the segments, one or two, that speak about a time."""
    return [one for one in segments if one.t[0] <= time <= one.t[1]]


def is_without_gaps(segments: Sequence[Segment]) -> bool:
    """Return whether every segment begins where the one before ends."""
    return all(np.array_equal(a.t[1], b.t[0]) for a, b in pairwise(segments))
