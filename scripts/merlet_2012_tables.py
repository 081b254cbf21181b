"""The sensitivity study of Merlet 2012, section IV.B: what the paper prints beside what comes out here.

"true" are the static poses, each proved to be the only one. "union" is what the printed ranges fit: the
pose with four taut cables where there is one, and every pose at which three cables alone carry the load,
whether or not the fourth is long enough to be slack. "certified" encloses the poses of all choices. In
centimetres and newtons, as printed: the mean, and the least and the largest deviation from it.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr_interval import load_robot
from cdpr_interval.exact.range import LengthRange
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import exact as exactly
from solvers import forward_kinematics, inverse_kinematics
from solvers.batch.draws import Spread
from solvers.batch.expansion import MonteCarlo
from solvers.batch.job import Settings, perturbed

Printed = tuple[tuple[float, float, float], ...]
"""Mean, least and largest deviation of x, y, z in cm and of four tensions in N; empty where not printed."""
ALL_CABLES = 4
TITLES = ("x cm", "y cm", "z cm", "tau 1 N", "tau 2 N", "tau 3 N", "tau 4 N")
POSE, OTHER_POSE = (1.0, 2.0, -2.0), (1.3, 1.8, -2.0)
"""Nominal poses in m."""
ON_LENGTHS = Spread(is_normal=False, width=0.03, is_relative=False, cut=0.0)
ON_STIFFNESS = Spread(is_normal=False, width=0.1, is_relative=True, cut=0.0)
ON_ANCHORS = Spread(is_normal=False, width=0.02, is_relative=False, cut=0.0, axes=(True, True, False))
WIRES = {"lengths_m": ON_LENGTHS, "stiffness": ON_STIFFNESS}


@dataclass(frozen=True)
class Study:
    """One Monte-Carlo study of the paper."""

    title: str
    robot: str
    pose: tuple[float, float, float]
    spreads: dict[str, Spread]
    samples: int
    printed: Printed
    with_four: int | None = None
    """Of 1000 cases, those with four taut cables, as printed."""
    remark: str = ""


BOTH = {**WIRES, "frame_anchors_m": ON_ANCHORS}
SOFT, STIFF = "merlet_4_1_k100", "merlet_4_1_k1000"
STUDIES = (
    Study(
        "tables I, II: l +-3 cm, k +-10 %, k = 100 N/cm", SOFT, POSE, WIRES, 1000,
        ((99.633266, -7.53, 4.57), (200.58488, -6.86, 5.75), (-198.945539, -7.60, 2.87),
         (470.68, -184.1, 123.7), (423.2, -137, 170.7), (181.42, -177.5, 230.7), (277.13, -274.8, 135)),
        960, "277.13 for tau 4 stands in the table for k = 1000 too: a misprint in one of them",
    ),
    Study(
        "tables I, II: l +-3 cm, k +-10 %, k = 1000 N/cm", STIFF, POSE, WIRES, 1000,
        ((100.032878, -5.48, 4.79), (200.22398, -4.79, 4.26), (-199.629886, -5.14, 4.24),
         (467.6, -192, 133.8), (463.06, -187.45, 138.1), (278.35, -274.2, 146.1), (277.13, -241.7, 168.7)),
        160,
    ),
    Study(
        "pose (130, 180, -200): l +-3 cm, k +-10 %", SOFT, OTHER_POSE, WIRES, 1000,
        ((128.55, -7.833, 5.56), (181.558, -8.61, 6.028), (-200.789, -6.955, 4.708),
         (434.832, -176.741, 213.368), (366.715, -211.942, 210.86), (316.01, -297.098, 175.482),
         (332.344, -327.109, 183.161)),
        remark="the paper says k = 1000; its numbers are those of k = 100, which is used here",
    ),
    Study(
        "tables III, IV: A_i +-2 cm in x and y, k = 100 N/cm", SOFT, POSE, {"frame_anchors_m": ON_ANCHORS},
        1000,
        ((97.971473, -4.1195, 4.4631), (199.911506, -4.55, 4.578), (-200.850671, -3.044, 3.055),
         (452.238063, -158.657, 136.74), (442.731039, -147.916, 147.59), (265.256553, -147.916, 147.59),
         (280.263655, -272.85, 126.315)),
        remark="the range of tau 3 repeats that of tau 2: a misprint",
    ),
    Study(
        "tables III, IV: A_i +-2 cm in x and y, k = 1000 N/cm", STIFF, POSE, {"frame_anchors_m": ON_ANCHORS},
        1000,
        ((99.678064, -3.4, 3.446), (200.047538, -2.923, 2.684), (-199.993619, -2.735, 2.519),
         (439.025901, -156.45, 157.649), (441.118404, -157.12, 156.826), (272.519396, -269.671, 147.625),
         (237.373109, -231.759, 182.077)),
    ),
    Study(
        "all together, k = 100 N/cm", SOFT, POSE, BOTH, 3000,
        ((98.726651, -9.449, 7.102), (200.361376, -8.158, 7.217), (-201.308687, -6.337, 6.5),
         (440.999788, -164.3975, 158.733), (476.440767, -197.1234, 123.558), (225.695517, -225.5340, 199.768),
         (188.101464, -187.45861, 233.732)),
    ),
    Study(
        "all together, k = 1000 N/cm", STIFF, POSE, BOTH, 3000,
        ((100.149153, -8.575, 6.676), (199.46656, -5.935, 6.607), (-200.443448, -5.716, 6.453),
         (439.317306, -173.728, 168.846), (496.090587, -228.579, 110.658), (188.53118, -188.125, 248.888),
         (276.871677, -276.619, 160.55)),
    ),
)  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """What came out of a study; rows of x, y, z in cm and four tensions in N."""

    true: NDArray[np.float64]
    union: NDArray[np.float64]
    by_taut: dict[int, int]
    """Number of true poses with so many taut cables."""
    seconds: float
    """Of processor time."""


def samples(study: Study, count: int, seed: int) -> Iterator[tuple[Robot, list[Any]]]:
    """Yield the robots and lengths of a study."""
    robot = load_robot(study.robot)
    nominal = inverse_kinematics(robot, study.pose).lengths
    assert nominal is not None
    # The paper prints lengths to 1e-4 cm.
    exact: list[LengthRange] = [(Fraction(f"{length:.6f}"),) * 2 for length in nominal]
    drawn = MonteCarlo(0, robot, {}, tuple(exact), count, seed, study.spreads)
    for job in drawn.jobs(Settings()):
        asked = json.loads(job.input)
        yield perturbed(robot, asked), asked["lengths_m"]


def conduct(study: Study, count: int, seed: int) -> Outcome:
    """Solve a study."""
    begun = time.process_time()
    true, union, by_taut = [], [], {3: 0, ALL_CABLES: 0}
    for robot, lengths in samples(study, count, seed):
        result = forward_kinematics(robot, lengths)
        if not (result.outcome == "complete" and len(result.solutions) == 1):
            raise AssertionError(f"not one proved pose for {lengths}: {result.message}")
        (pose,) = result.solutions
        row = numbers(pose)
        true.append(row)
        by_taut[len(pose.taut)] = by_taut.get(len(pose.taut), 0) + 1
        if len(pose.taut) == ALL_CABLES:
            union.append(row)
        union += triples(robot, lengths)
    return Outcome(np.array(true), np.array(union), by_taut, time.process_time() - begun)


def triples(robot: Robot, lengths: list[Any]) -> Iterator[list[float]]:
    """Yield the poses at which three cables alone carry the load, whatever the fourth does."""
    for left_out in range(ALL_CABLES):
        kept = [i for i in range(ALL_CABLES) if i != left_out]
        three = replace(robot, cables=tuple(robot.cables[i] for i in kept))
        for pose in forward_kinematics(three, [lengths[i] for i in kept]).solutions:
            if len(pose.taut) == len(kept):
                row = numbers(pose)
                row.insert(3 + left_out, 0.0)
                yield row


def numbers(pose: Any) -> list[float]:
    """Return position in cm and tensions in N."""
    return [*(100.0 * pose.position.mean(axis=1)), *pose.tensions.mean(axis=1)]


def shown(mean: float, least: float, most: float) -> str:
    """Return mean and deviations in one column."""
    return f"{mean:9.3f} [{least:8.2f}, {most:7.2f}]"


def deviations(values: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return mean, and the least and largest deviation from it."""
    mean = float(values.mean())
    return mean, float(values.min()) - mean, float(values.max()) - mean


def vague(study: Study) -> tuple[Robot, list[LengthRange]]:
    """Return the robot and the lengths of a study with ranges for what it draws, each as wide as it draws."""
    robot = load_robot(study.robot)
    nominal = inverse_kinematics(robot, study.pose).lengths
    assert nominal is not None
    exact = [Fraction(f"{length:.6f}") for length in nominal]
    reach = Fraction("0.03") if "lengths_m" in study.spreads else Fraction(0)
    share = Fraction("0.1") if "stiffness" in study.spreads else Fraction(0)
    away = Fraction("0.02") if "frame_anchors_m" in study.spreads else Fraction(0)
    cables = []
    for cable in robot.cables:
        assert cable.elasticity is not None and cable.elasticity.stiffness is not None
        k = exactly(cable.elasticity.stiffness)
        x, y, z = map(exactly, cable.frame_anchor)
        exit_point = ((x - away, x + away), (y - away, y + away), z)
        spring = cable.elasticity.replace(stiffness=(k * (1 - share), k * (1 + share)))
        cables.append(cable.replace(frame_anchor=exit_point, elasticity=spring))
    return robot.replace(cables=tuple(cables)), [(x - reach, x + reach) for x in exact]


def certified(study: Study) -> tuple[NDArray[np.float64], str, float]:
    """Return certified bounds (7, 2) for every choice as printed, what is proved, and processor seconds."""
    begun = time.process_time()
    result = forward_kinematics(*vague(study))
    seconds = time.process_time() - begun
    (pose,) = result.solutions
    return np.vstack([100.0 * pose.position, pose.tensions]), result.message, seconds


def print_studies(seed: int, count: int | None = None) -> None:
    """Print every study, with the paper's number of samples or another."""
    print(f"seed {seed}; mean [least, largest deviation]")
    for study in STUDIES:
        found = conduct(study, count or study.samples, seed)
        total = len(found.true)
        print(f"\n{study.title}: {total} samples, {found.seconds:.1f} s of processor time")
        if study.remark:
            print(f"  ({study.remark})")
        hull, message, seconds = certified(study)
        print(f"certified for every choice: {message}; {seconds:.1f} s")
        print(f"{'':10}{'paper':32}{'true':32}{'union':32}certified, from the mean of true")
        for i, title in enumerate(TITLES):
            ours = [shown(*deviations(rows[:, i])) for rows in (found.true, found.union)]
            mean = float(found.true[:, i].mean())
            ours.append(f"[{hull[i, 0] - mean:8.2f}, {hull[i, 1] - mean:7.2f}]")
            print(f"{title:10}{shown(*study.printed[i]):32}{ours[0]:32}{ours[1]:32}{ours[2]}")
        share = 1000 * found.by_taut[ALL_CABLES] / total
        error = 1000 * (share / 1000 * (1 - share / 1000) / total) ** 0.5
        paper = "" if study.with_four is None else f"paper {study.with_four}, "
        print(f"four taut cables, per 1000: {paper}here {share:.0f} +- {error:.0f} (standard error)")
