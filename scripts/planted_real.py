"""Random platforms on pulleys and elastic cables whose static pose is known: none may be lost.

Run as ``python scripts/planted_real.py [COUNT [SEED]]``. Three to eight cables, all taut, straight or over
a pulley on one joint or two (up to 6 cm on 1 to 2 m), some so nearly straight that they lift off it,
inextensible (six at most) or stretched by up to 5 %; the taut cables alone are asked for. One line for each
number of cables:

    found       a proved solution
    undecided   in an undecided region
    pending     not found before the cell limit
    LOST        none of these: a wrong proof of completeness; the exit code is 1

``tests.support.planted.pulleys.plant(SEED, CABLES, any_cable)`` and ``stretched`` here make the robot of a
line.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

# Run from anywhere: the generators live beside the tests.
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Robot
from cdpr_interval.robots.pulley import Pulley
from solvers import Result, forward_kinematics
from tests.support.planted.pulleys import Planted, any_cable, exact, plant

COUNTS = (3, 4, 5, 6, 7, 8)
MOST_RIGID = 6
"""More inextensible cables share the load in more than one way."""
MOST_STRAIN = 0.05
CELLS = 400_000
NEAR = 1e-6
"""How far the pose found may be from the planted one, whose data are floats."""
VERDICTS = ("found", "undecided", "pending", "LOST")


@dataclass(frozen=True)
class Fate:
    """What became of one robot."""

    count: int
    verdict: str
    cells: int
    seconds: float


def stretched(planted: Planted, seed: int) -> tuple[Robot, list[Fraction]]:
    """Return the robot of a planted pose, some of its cables elastic, and the unstretched lengths (m)."""
    rng = np.random.default_rng([seed, 1])
    cables, lengths, rigid = [], [], 0
    for i, cable in enumerate(planted.cables):
        length, tension = Fraction(float(planted.lengths[i])), Fraction(float(planted.tensions[i]))
        elasticity = None
        if rigid == MOST_RIGID or rng.random() < 0.5:
            strain = Fraction(float(MOST_STRAIN * 10.0 ** -rng.uniform(0.0, 3.0)))
            elasticity = Elasticity(axial_stiffness=tension / strain)
            length = length / (1 + strain)
        else:
            rigid += 1
        pulley = None
        if cable.radius > 0.0:
            pulley = Pulley(
                Fraction(cable.radius),
                Fraction(cable.arm),
                cable.joints,
                exact(cable.axis),
                Fraction(cable.lead_in),
            )
        own = Cable(f"c{i + 1}", exact(cable.exit), exact(planted.arms[i]), elasticity, pulley=pulley)
        cables.append(own)
        lengths.append(length)
    robot = Robot("planted", Platform(Fraction(1)), tuple(cables), gravity=exact(planted.load))
    return robot, lengths


def verdict(planted: Planted, result: Result) -> str:
    """Return what became of the planted pose."""
    place, rotation = planted.position, planted.rotation
    for pose in result.solutions:
        off = np.abs(np.subtract(pose.nominal.position, place)).max()
        turned = np.abs(pose.rotation.mean(axis=2) - rotation).max()
        if off < NEAR and turned < NEAR:
            return "found"
    for region in result.undecided:
        inside = (region.position[:, 0] - NEAR <= place) & (place <= region.position[:, 1] + NEAR)
        if inside.all():
            return "undecided"
    return "pending" if result.pending else "LOST"


def solve(seed: int) -> Fate:
    """Plant and solve one robot."""
    count = COUNTS[seed % len(COUNTS)]
    planted = plant(seed, count, any_cable)
    robot, lengths = stretched(planted, seed)
    started = time.process_time()
    result = forward_kinematics(robot, lengths, taut=range(count), cell_limit=CELLS)
    cells = sum(subset.cells for subset in result.subsets)
    return Fate(count, verdict(planted, result), cells, time.process_time() - started)


def main(arguments: Sequence[str]) -> int:
    """Print a table; return 1 where a pose was lost."""
    count, first = (*map(int, arguments), *(60, 1)[len(arguments) :])
    fates = []
    for seed in range(first, first + count):
        fates.append(solve(seed))
        if fates[-1].verdict == "LOST":
            print(f"LOST: {fates[-1].count} cables, seed {seed}", flush=True)
    last = first + count - 1
    print(f"seeds {first}..{last}: {count} robots, at most {CELLS} cells; medians of cells and CPU s")
    print("cables  robots " + " ".join(f"{word:>9}" for word in VERDICTS) + "     cells   CPU s")
    for n in COUNTS:
        own = [fate for fate in fates if fate.count == n]
        if own:
            each = " ".join(f"{sum(fate.verdict == word for fate in own):9}" for word in VERDICTS)
            cells = statistics.median(fate.cells for fate in own)
            seconds = statistics.median(fate.seconds for fate in own)
            print(f"{n:6} {len(own):7} {each} {cells:9.0f} {seconds:7.2f}")
    return int(any(fate.verdict == "LOST" for fate in fates))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
