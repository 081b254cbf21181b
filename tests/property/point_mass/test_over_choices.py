"""Ranges of all data of a point mass: the pose of every choice lies in the one entry, or in the region."""

from __future__ import annotations

import random
from fractions import Fraction as F

import numpy as np
import pytest

from cdpr_interval.exact.range import Range
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Robot
from solvers import forward_kinematics, pose_from_tensions
from solvers.answers.data import CableState, Outcome

CHOICES = 12
"""Of each robot: corners and others in turn."""
SEEDS = range(12)
KINDS = {"all": [0, 1, 4], "lengths": [1, 5, 30], "wide": [60]}
"""Half of a range in mm: of all data; of lengths alone, where bounds are sharpened only; regions are left."""


def around(x: F, half: F) -> F | Range:
    return Range(x - half, x + half) if half else x


def drawn(rng: random.Random, low: int, high: int) -> F:
    return F(rng.randint(low * 1000, high * 1000), 1000)


def vague(
    rng: random.Random, elastic: bool, kind: str = "all"
) -> tuple[Robot, list[tuple[F, F]], tuple[F | Range, ...]]:
    """Return a robot with ranges in a random part of its data, lengths and an external force."""
    size, data = F(rng.choice(KINDS[kind]), 1000), int(kind != "lengths")
    count = rng.randint(3, 5)
    point = [drawn(rng, 1, 3), drawn(rng, 1, 3), drawn(rng, -3, -1)]
    cables, lengths = [], []
    for i in range(count):
        # Cables from below may leave no choice, or none that is known: then there are regions.
        exit_point = [drawn(rng, 0, 4), drawn(rng, 0, 4), drawn(rng, -4 if kind == "wide" else 0, 1)]
        spring = None
        if elastic:
            k = F(rng.randint(5, 50) * 1000)
            key = rng.choice(["stiffness", "axial_stiffness"])
            spring = Elasticity(**{key: around(k, k * F(data * rng.choice([0, 2]), 100))})
        half = data * size * rng.choice([0, 1])
        cables.append(Cable(f"c{i}", [around(x, half) for x in exit_point], (0, 0, 0), spring))
        far = sum(float(a - b) ** 2 for a, b in zip(exit_point, point, strict=True)) ** 0.5
        length = F(round(far * 1000), 1000) + F(rng.randint(0, 20), 1000)
        half = size * rng.choice([0, 1])
        lengths.append((length - half, length + half))
    mass = around(F(50), F(data * rng.choice([0, 1])))
    turned, pull = F(data * rng.choice([0, 1]), 20), F(data * rng.choice([0, 1]), 50)
    gravity = [0, around(F(0), turned), around(F("-9.81"), pull)]
    force = (F(0), around(F(5), F(data * rng.choice([0, 2]))), F(0))
    return Robot("vague", Platform(mass), cables, gravity), lengths, force


def chosen(rng: random.Random, corner: bool, value: F | Range) -> F:
    if not isinstance(value, Range):
        return value
    share = F(rng.randint(0, 1)) if corner else F(rng.randint(0, 1000), 1000)
    return value.lo + share * value.width


def one_robot(rng: random.Random, corner: bool, robot: Robot) -> Robot:
    """Return the robot of one choice."""
    cables = []
    for cable in robot.cables:
        spring = cable.elasticity
        if spring is not None:
            given = (spring.stiffness, spring.axial_stiffness)
            spring = Elasticity(*(None if v is None else chosen(rng, corner, v) for v in given))
        exit_point = tuple(chosen(rng, corner, x) for x in cable.frame_anchor)
        cables.append(cable.replace(frame_anchor=exit_point, elasticity=spring))
    mass = chosen(rng, corner, robot.platform.mass)
    gravity = tuple(chosen(rng, corner, g) for g in robot.gravity)
    return robot.replace(platform=robot.platform.replace(mass=mass), cables=cables, gravity=gravity)


def overlap(a: np.ndarray, b: np.ndarray) -> bool:
    """Return whether two boxes have a common point."""
    return bool((a[..., 0] <= b[..., 1]).all() and (b[..., 0] <= a[..., 1]).all())


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("elastic", [False, True], ids=["inextensible", "elastic"])
@pytest.mark.parametrize("seed", SEEDS)
def test_the_pose_of_every_choice_lies_in_the_answer(seed: int, elastic: bool, kind: str) -> None:
    rng = random.Random(f"{seed} {elastic} {kind}")
    robot, lengths, force = vague(rng, elastic, kind)
    whole = forward_kinematics(robot, lengths, external_force=force)
    assert whole.verify(robot) == []
    for k in range(CHOICES):
        corner = bool(k % 2)
        own = [chosen(rng, corner, Range(*length)) for length in lengths]
        pull = [chosen(rng, corner, f) for f in force]
        found = forward_kinematics(one_robot(rng, corner, robot), own, external_force=pull)
        if not found.solutions:
            assert not whole.solutions
            continue
        (pose,) = found.solutions
        if not whole.solutions:
            assert whole.outcome is Outcome.INCOMPLETE
            assert any(overlap(pose.position, region.position) for region in whole.undecided)
            continue
        (entry,) = whole.solutions
        for name in ("position", "tensions", "distances", "height"):
            assert overlap(getattr(pose, name), getattr(entry, name)), name
        for mine, of_all in zip(pose.cable_states, entry.cable_states, strict=True):
            if of_all in (CableState.TAUT, CableState.SLACK):
                assert mine in (of_all, CableState.UNDECIDED, CableState.SWITCHING)


@pytest.mark.parametrize("seed", range(6))
def test_the_pose_for_given_tensions_lies_in_the_answer(seed: int) -> None:
    rng = random.Random(seed)
    robot, _, force = vague(rng, True)
    tensions = [(F(300), F(302))] * len(robot.cables)
    whole = pose_from_tensions(robot, tensions, external_force=force)
    for k in range(CHOICES):
        corner = bool(k % 2)
        own = [chosen(rng, corner, Range(*tension)) for tension in tensions]
        pull = [chosen(rng, corner, f) for f in force]
        for pose in pose_from_tensions(one_robot(rng, corner, robot), own, external_force=pull).solutions:
            regions = whole.solutions or whole.undecided
            assert any(overlap(pose.position, region.position) for region in regions)
