"""The named cases of the benchmark: each a callable that does a known piece of work and checks its answer."""

from __future__ import annotations

import json
import math
import os
import random
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from enum import StrEnum
from fractions import Fraction
from functools import cache
from multiprocessing import get_context
from pathlib import Path

from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Cable, Elasticity, Platform, Robot
from cdpr_interval.robots.formats.reader import load_robot
from cdpr_interval.robots.numbers import exact_point
from solvers import PointMass, Tracker, forward_kinematics
from solvers.answers.data import Outcome, Solution

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT / "tests" / "reference" / "data"
COGIRO = (
    "10.737826963826153,10.996863446575965,10.519354683477053,10.587410916921941,"
    "9.838356404726296,9.423395407318322,9.501702491749816,11.157614327874176"
)
"""Lengths of a static pose with c1, c2, c3, c5, c7 taut, the others 5 % longer."""
MERLET = ["2.6925824035672520156", "3.9051248379533272068", "3.3541019662496845446", "4.385"]
UC4 = ["7.5", "8", "7", "9"]
LIGHT_CALLS = 1000
"""Calls of a prepared solver in one run: the clock's own time must not show."""
SIDE_BY_SIDE = (
    "the work of uc4 twice, in two processes that share nothing: twice the time of uc4 over this wall time "
    "is what two cores of the machine give at best; compare it with uc4 over uc4-two-threads"
)
SWING = 0.02
"""m: how far the lengths of a tracked pose swing."""


class Clock(StrEnum):
    """Whose time a case is measured in."""

    PROCESSOR = "processor"
    """Processor time of this process."""
    WALL = "wall"
    """For cases with several threads."""
    CHILD = "child"
    """Processor time of the processes a case starts."""


@dataclass(frozen=True)
class Done:
    """What one run did."""

    poses: int
    cells: int = 0


@dataclass(frozen=True)
class Case:
    """A piece of work of known outcome.

    A run may hold many calls, or steps of a path: the times reported are those of one, in ``unit``.
    """

    name: str
    run: Callable[[], Done]
    """Raises `WrongAnswer` where what is found is not proved complete."""
    poses: int
    """Expected, of one run."""
    unit: str = "s"
    """``s``, ``ms`` or ``us``, for the table."""
    calls: int = 1
    """In one run."""
    clock: Clock = Clock.PROCESSOR
    threads: int = 1
    warm: bool = True
    """One run that is not measured goes ahead: kernels are compiled and loaded."""
    rare: bool = False
    """Only measured where it is asked for: it takes long."""
    note: str = ""
    """What limits it, or what it is to be compared with."""


class WrongAnswer(Exception):
    """A case did not find what is known to be true."""


def question(name: str, robot: Robot, lengths: Sequence[object], poses: int, **options: object) -> Case:
    """Return a case that is one call of `forward_kinematics`."""
    threads = int(str(options.get("threads", 1)))

    def run() -> Done:
        result = forward_kinematics(robot, lengths, **options)  # type: ignore[arg-type]
        if result.outcome is not Outcome.COMPLETE:
            raise WrongAnswer(f"{name}: {len(result.solutions)} poses, {result.outcome.value}")
        return Done(len(result.solutions), result.statistics.cells)

    clock = Clock.PROCESSOR if threads == 1 else Clock.WALL
    return Case(name, run, poses, clock=clock, threads=threads)


def light_calls(name: str, robot: Robot, lengths: Sequence[Sequence[float]]) -> Case:
    """Return a case of many calls of a prepared point-mass solver, over given lengths in turn."""
    solver = PointMass(robot)
    turns = [lengths[i % len(lengths)] for i in range(LIGHT_CALLS)]

    def run() -> Done:
        for given in turns:
            if not solver.solve(given).complete:
                raise WrongAnswer(f"{name}: lengths {given} are not decided")
        return Done(LIGHT_CALLS)

    return Case(name, run, LIGHT_CALLS, unit="us", calls=LIGHT_CALLS)


def tracking(name: str, robot: Robot, lengths: Sequence[float], taut: Sequence[int]) -> Case:
    """Return a case that follows the one stable pose of a taut subset along a closed path of lengths."""

    @cache
    def prepared() -> tuple[Tracker, Solution, list[list[float]]]:
        poses = forward_kinematics(robot, lengths, taut=taut).solutions
        (start,) = [pose for pose in poses if pose.stability is Stability.STABLE]
        turns = [2.0 * math.pi * i / LIGHT_CALLS for i in range(LIGHT_CALLS)]
        path = [[x + SWING * math.sin(j * turn) for j, x in enumerate(lengths, 1)] for turn in turns]
        return Tracker(robot), start, path

    def run() -> Done:
        tracker, start, path = prepared()
        tracker.reset(start)
        for given in path:
            pose = tracker.update(given)
            if not pose.tracked:
                raise WrongAnswer(f"{name}: lengths {given}: {pose.reason}")
        return Done(LIGHT_CALLS)

    return Case(name, run, LIGHT_CALLS, unit="us", calls=LIGHT_CALLS)


@cache
def shipped(name: str) -> Robot:
    """Return a robot that ships, read once."""
    return load_robot(name)


def solve_uc4() -> int:
    """Return the number of poses of UC4; the task of one process."""
    return len(forward_kinematics(shipped("uc4"), UC4, taut=range(4)).solutions)


def side_by_side(name: str, poses: int, note: str) -> Case:
    """Return a case that solves UC4 in two processes at the same time: what a second core is worth."""

    @cache
    def pool() -> ProcessPoolExecutor:
        return ProcessPoolExecutor(2, mp_context=get_context("spawn"))

    def run() -> Done:
        tasks = [pool().submit(solve_uc4) for _ in range(2)]
        return Done(sum(task.result() for task in tasks))

    return Case(name, run, 2 * poses, clock=Clock.WALL, note=note)


def process(name: str, arguments: Sequence[str], cold: bool = False, poses: int = 0) -> Case:
    """Return a case that is one command in a process of its own, with ``cold`` and an empty kernel cache."""
    command = [sys.executable, "-m", "solvers", *arguments]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}

    def run() -> Done:
        with tempfile.TemporaryDirectory() as folder:
            if cold:
                environment["NUMBA_CACHE_DIR"] = folder
            done = subprocess.run(command, env=environment, capture_output=True, text=True)
        found = re.search(r": (\d+) static pose", done.stdout)
        if done.returncode != 0:
            raise WrongAnswer(f"{name}: exit code {done.returncode}: {done.stderr.strip()}")
        return Done(int(found[1]) if found else 0)

    return Case(name, run, poses, unit="ms", clock=Clock.CHILD, warm=not cold, rare=cold)


def hanging_robot(count: int, elastic: bool, seed: int) -> tuple[Robot, list[list[float]]]:
    """Return a point mass under random exit points, and lengths of 100 points it may pass through.

    Three cables of exact length and the others 2 % longer, or all of exact length when elastic.
    """
    rng = random.Random(seed)
    anchors = [[round(rng.uniform(*span), 3) for span in ((-5, 5), (-5, 5), (3, 6))] for _ in range(count)]
    stretch = Elasticity(stiffness=Fraction(100_000)) if elastic else None
    origin = (Fraction(0), Fraction(0), Fraction(0))
    cables = tuple(
        Cable(f"c{i + 1}", (Fraction(str(x)), Fraction(str(y)), Fraction(str(z))), origin, stretch)
        for i, (x, y, z) in enumerate(anchors)
    )
    paths = []
    for _ in range(100):
        point = [rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(-1, 1)]
        slack = [1.0 if elastic or i < 3 else 1.02 for i in range(count)]
        distances = [sum((p - x) ** 2 for p, x in zip(point, a, strict=True)) ** 0.5 for a in anchors]
        paths.append([d * s for d, s in zip(distances, slack, strict=True)])
    return Robot(f"hanging-{count}", Platform(Fraction(80)), cables), paths


def fifth_cable(robot: Robot) -> Robot:
    """Return UC4 with a fifth cable."""
    added = replace(
        robot.cables[0],
        name="c5",
        frame_anchor=(Fraction(5), Fraction(-3), Fraction(1, 5)),
        platform_anchor=(Fraction(1, 5), Fraction(-17, 10), Fraction(1)),
    )
    return replace(robot, cables=(*robot.cables, added))


def smaller_base(robot: Robot, factor: Fraction) -> Robot:
    """Return a robot whose exit points are scaled about the origin."""

    def scaled(a: tuple[Fraction, Fraction, Fraction]) -> tuple[Fraction, Fraction, Fraction]:
        return (factor * a[0], factor * a[1], factor * a[2])

    cables = tuple(replace(c, frame_anchor=scaled(exact_point(c.frame_anchor))) for c in robot.cables)
    return replace(robot, cables=cables)


def process_cases() -> list[Case]:
    """Return what a user waits for at the command line."""
    point = ["fk", "merlet_4_1", "--lengths", ",".join(MERLET)]
    platform = ["fk", "uc4", "--lengths", ",".join(UC4), "--threads", "1"]
    return [
        process("process-help", ["--help"]),
        process("process-point-mass", point, poses=1),
        process("process-platform", platform, poses=10),
        process("first-process-point-mass", point, cold=True, poses=1),
        process("first-process-platform", platform, cold=True, poses=10),
    ]


def cases() -> list[Case]:
    """Return all cases, quick ones first."""
    uc2, uc3, uc4 = (load_robot(name) for name in ("uc2", "uc3", "uc4"))
    six = [str(x) for x in json.loads((DATA / "six_leg_40.json").read_text())["lengths_m"]]
    large = smaller_base(uc3, Fraction(3, 10))
    six_leg, cogiro = load_robot("six_leg_40"), load_robot("cogiro")
    return [
        light_calls("point-mass-8-light", *hanging_robot(8, elastic=False, seed=8)),
        light_calls("point-mass-elastic-4-light", *hanging_robot(4, elastic=True, seed=4)),
        tracking("tracking-2-cables", uc2, [7.5, 8.0], range(2)),
        tracking("tracking-3-cables", uc3, [7.5, 8.0, 7.0], range(3)),
        tracking("tracking-4-cables", uc4, [7.5, 8.0, 7.0, 9.0], range(4)),
        tracking("tracking-6-of-8-cables", cogiro, [float(x) for x in COGIRO.split(",")], range(1, 7)),
        question("point-mass-inextensible", load_robot("merlet_4_1"), MERLET, 1),
        question("uc2", uc2, ["7.5", "8"], 8, taut=range(2)),
        question("uc3", uc3, ["7.5", "8", "7"], 14, taut=range(3)),
        question("uc4", uc4, UC4, 3, taut=range(4)),
        question("uc4-two-threads", uc4, UC4, 3, taut=range(4), threads=2),
        side_by_side("uc4-two-processes", 3, SIDE_BY_SIDE),
        question("uc4-fifth-cable", fifth_cable(uc4), [*UC4, "7.6"], 0, taut=range(5)),
        question("uc4-all-subsets", uc4, UC4, 10),
        question("uc3-large-platform", large, ["4", "4.4", "3.7"], 8, taut=range(3)),
        question("six-leg", six_leg, six, 40, taut=range(6), ignore_tension_sign=True),
        question("cogiro-two-threads", cogiro, COGIRO.split(","), 44, threads=2),
        *process_cases(),
    ]
