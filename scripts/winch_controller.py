"""A controller at 100 Hz: winches follow a trajectory, and each cycle proves where the platform is.

The robot is UC4, a platform on four cables, with winches added; the drives are simulated, their drums as
large as the tolerances allow. Every cycle the measured length ranges go to a `Tracker`, which proves a box
that holds the pose; a bound of its distance from the pose that was asked for is printed.
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from fractions import Fraction

import numpy as np

from cdpr_interval import load_robot
from cdpr_interval.driver.group import WinchGroup
from cdpr_interval.driver.setpoints import smooth
from cdpr_interval.driver.simulated_drive import SimulatedDrive
from cdpr_interval.driver.simulator import SimulatedBus
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.winch import HelicalDrum, Winch, WinchLimits
from solvers import Tracker, forward_kinematics
from solvers.six_dof.tracked_pose import TrackedPose

START = (7.5, 8.0, 7.0, 9.0)
GOAL = (7.45, 8.05, 7.03, 8.95)
DURATION = 3.0
"""s."""
TOLERANCE = Fraction(1, 50_000)
"""m by which the lengths are known at the start."""
LOOKAHEAD = 5
"""Cycles by which set-points are sent ahead."""


def uc4_with_winches() -> Robot:
    """Return UC4 with a servo winch on every cable; signs alternate."""
    radius = Range(Fraction("0.049999"), Fraction("0.050001"))
    drum = HelicalDrum(
        radius, Range(Fraction("0.002"), Fraction("0.002")), Range(Fraction("0.0025"), Fraction("0.0025"))
    )
    limits = WinchLimits((Fraction(1), Fraction(12)), Fraction(1, 2), Fraction(1), Fraction(1, 100), None)
    robot = load_robot("uc4")
    cables = tuple(
        replace(cable, winch=Winch(drum, Fraction(156, 7), 65536, (-1) ** i, Fraction(1), limits, i + 1))
        for i, cable in enumerate(robot.cables)
    )
    return replace(robot, cables=cables)


def trajectory(cycle: float) -> list[tuple[float, ...]]:
    """Return lengths in m, one row a cycle, at rest at both ends."""
    steps = round(DURATION / cycle)
    shares = [smooth(k / steps) for k in range(1, steps + 1)]
    return [tuple(a + share * (b - a) for a, b in zip(START, GOAL, strict=True)) for share in shares]


def farthest(pose: TrackedPose, wanted: TrackedPose) -> float:
    """Return a bound in m of the distance between two positions known to boxes."""
    apart = np.maximum(
        np.abs(pose.position[:, 1] - wanted.position[:, 0]),
        np.abs(wanted.position[:, 1] - pose.position[:, 0]),
    )
    return math.hypot(*apart.tolist())


def main() -> int:
    """Run the loop; return 0 when every cycle was proved and the truth lay in every box of lengths."""
    robot = uc4_with_winches()
    poses = forward_kinematics(robot, START, taut=range(4)).solutions
    start = next(pose for pose in poses if pose.stability == "stable")
    measured, wanted = Tracker(robot, start), Tracker(robot, start)
    measured.warm_up()
    drives = [
        SimulatedDrive(cable.winch, Fraction(length), share=Fraction(1))
        for cable, length in zip(robot.cables, START, strict=True)
        if cable.winch is not None
    ]
    bus = SimulatedBus(drives)
    group = WinchGroup(robot, bus)
    path = trajectory(group.supervisor.period)
    lost = 0
    with group:
        group.home([Range(Fraction(length) - TOLERANCE, Fraction(length) + TOLERANCE) for length in START])
        group.enable()
        begin = bus.now() + LOOKAHEAD * group.supervisor.period
        for k in range(len(path) + LOOKAHEAD):
            if k < len(path):
                group.command(path[k], begin + (k + 1) * group.supervisor.period, at_rest=k == len(path) - 1)
            # What the drives do in this cycle was commanded in the one before.
            asked = [cable.commanded for cable in group.snapshot.cables]
            group.pass_cycles(1)
            pose = measured.update(group.length_ranges())
            goal = wanted.update(asked)
            inside = all(
                lo <= drive.true_length <= hi
                for drive, (lo, hi) in zip(drives, group.length_ranges(), strict=True)
            )
            lost += not (pose.tracked and goal.tracked and inside)
            if k % 50 == 0 or k == len(path) + LOOKAHEAD - 1:
                error = f"at most {1e3 * farthest(pose, goal):.3f} mm off" if pose.tracked else pose.reason
                print(f"{bus.now() - begin:6.2f} s  {group.state.value:8}  {error}")
    print(f"{len(path) + LOOKAHEAD} cycles, {lost} not proved")
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main())
