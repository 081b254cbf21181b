"""Solve random robots whose static pose is known: none may be lost.

Run as ``python scripts/planted.py --robots 500 --seed 1``. One line a kind:

    found       in the box of a proved solution with the planted taut cables
    undecided   in an undecided region, or in a proved pose with a cable whose state is open
    pending     not found before the cell or time limit
    LOST        none of these: a wrong proof of completeness; the exit code is 1

    WRONG       a listed solution is not in balance or contradicts itself; exit code 1 as well

Such a line names kind and seed: ``tests.support.planted.platform.plant(KIND, SEED)`` is that robot. Platforms
are asked for the planted taut cables alone; those with up to ``--all-subsets`` cables for all subsets of
taut cables, unless ``--taut-only``.
"""

from __future__ import annotations

import argparse
import os
import random
import statistics
import sys
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from fractions import Fraction
from multiprocessing import get_context
from pathlib import Path

# Run from anywhere: the generators live beside the tests and in this folder.
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parent))

import planted_point_mass as point

from solvers import forward_kinematics
from solvers.answers.data import Outcome, StopReason
from solvers.point_mass.forward import solve as solve_point_mass
from solvers.questions.problem import Options
from tests.support.planted import platform
from tests.support.planted.verdict import Verdict, complaints, judge

POINT_KINDS = ("point-mass", "point-mass-elastic")
WRONG = "WRONG"
"""The verdict where a listed solution is not in balance."""
COLUMNS = (Verdict.FOUND.value, Verdict.UNDECIDED.value, Verdict.PENDING.value, Verdict.LOST.value, WRONG)
FAILED = (Verdict.LOST.value, WRONG)


@dataclass(frozen=True)
class Job:
    """One robot to solve."""

    kind: str
    seed: int
    time_limit: float
    cell_limit: int
    all_subsets: int


@dataclass(frozen=True)
class Fate:
    """What became of one robot."""

    kind: str
    seed: int
    verdict: str
    cells: int
    seconds: float
    notes: tuple[str, ...] = ()
    whole: bool = False
    """All subsets were asked for."""


def solve_job(job: Job) -> Fate:
    """Solve one robot in a worker process."""
    return solve_point(job) if job.kind in POINT_KINDS else solve_platform(job)


def solve_platform(job: Job) -> Fate:
    """Solve one platform and compare."""
    planted = platform.plant(job.kind, job.seed)
    whole = len(planted.lengths) <= job.all_subsets
    start = time.process_time()
    result = forward_kinematics(
        planted.robot,
        planted.lengths,
        taut=None if whole else planted.taut,
        external_force=planted.external_force,
        time_limit=job.time_limit,
        cell_limit=job.cell_limit,
    )
    seconds = time.process_time() - start
    if result.stop_reason is StopReason.INTERRUPTED:
        raise KeyboardInterrupt
    notes = tuple(complaints(planted, result))
    verdict = WRONG if notes else judge(planted, result).value
    return Fate(job.kind, job.seed, verdict, result.statistics.cells, seconds, notes, whole)


def solve_point(job: Job) -> Fate:
    """Solve one point mass and compare."""
    rng = random.Random(f"{job.kind}/{job.seed}")
    elastic = job.kind == POINT_KINDS[1]
    scale = Fraction(10) ** rng.choice((0, 0, 0, 2, -3))
    planted = point.plant(rng, elastic, scale)
    while not any(planted.problem.load) or (not elastic and point.is_singular(planted)):
        planted = point.plant(rng, elastic, scale)
    start = time.process_time()
    answer = solve_point_mass(planted.problem, Options(time_limit=job.time_limit))
    seconds = time.process_time() - start
    notes = tuple(point.complaints(planted, answer, 1e-8 * float(scale)))
    open_ = answer.outcome is not Outcome.COMPLETE
    verdict = Verdict.FOUND if not notes else Verdict.UNDECIDED if open_ else Verdict.LOST
    return Fate(job.kind, job.seed, verdict.value, answer.cells, seconds, notes, whole=True)


def jobs_of(arguments: argparse.Namespace) -> list[Job]:
    """Return the robots to solve: the kinds in turn."""
    kinds = [k for k in (*POINT_KINDS, *platform.KINDS) if matches(k, arguments.kinds)]
    if not kinds:
        raise SystemExit(f"no kind matches {' '.join(arguments.kinds)}")
    all_subsets = 0 if arguments.taut_only else arguments.all_subsets
    return [
        Job(
            kinds[i % len(kinds)],
            arguments.seed * 1_000_003 + i // len(kinds),
            arguments.time_limit_per_robot,
            arguments.cell_limit_per_robot,
            all_subsets,
        )
        for i in range(arguments.robots)
    ]


def matches(kind: str, wanted: Sequence[str]) -> bool:
    """Return True for a kind whose name begins with one of the wanted ones; all where none is named."""
    return not wanted or any(kind.startswith(w) for w in wanted)


def solve_all(jobs: Sequence[Job], processes: int, seconds: float) -> Iterable[Fate]:
    """Solve the robots in worker processes; what has not begun when the time is over is left out."""
    end = time.monotonic() + seconds
    # The first point mass and platform compile the kernels into numba's cache: the workers load them.
    heads = {job.kind in POINT_KINDS: job for job in reversed(jobs)}
    yield from map(solve_job, heads.values())
    jobs = [job for job in jobs if job not in heads.values()]
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        step = 4 * processes
        for first in range(0, len(jobs), step):
            if time.monotonic() > end:
                return
            yield from pool.map(solve_job, jobs[first : first + step])


def line(name: str, fates: Sequence[Fate]) -> str:
    """Return the table line of one kind."""
    counts = [sum(f.verdict == column for f in fates) for column in COLUMNS]
    cells = statistics.median(f.cells for f in fates)
    seconds = statistics.median(f.seconds for f in fates)
    whole = sum(f.whole for f in fates)
    numbers = "".join(f"{count:>10}" for count in (len(fates), whole, *counts))
    return f"{name:<30}{numbers}{cells:>12.0f}{seconds:>10.2f}"


def table(fates: Sequence[Fate]) -> list[str]:
    """Return one line a kind and the totals."""
    heads = ("robots", "all sets", *COLUMNS)
    head = f"{'kind':<30}" + "".join(f"{h:>10}" for h in heads) + f"{'cells':>12}{'CPU s':>10}"
    kinds = dict.fromkeys(f.kind for f in fates)
    return [head, *(line(k, [f for f in fates if f.kind == k]) for k in kinds), line("all", fates)]


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Solve random robots whose static pose is known.")
    parser.add_argument("--robots", type=int, default=500, help="number of robots, over all kinds")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", nargs="*", default=[], help="only kinds whose names begin like this")
    parser.add_argument("--each", action="store_true", help="print a line for every robot")
    parser.add_argument("--taut-only", action="store_true", help="never ask for all subsets of a platform")
    parser.add_argument("--all-subsets", type=int, default=3, help="most cables asked for all subsets")
    parser.add_argument("--time-limit-per-robot", type=float, default=120.0, help="seconds of wall time")
    parser.add_argument("--cell-limit-per-robot", type=int, default=6_000_000)
    parser.add_argument("--time-limit", type=float, default=3600.0, help="seconds for the whole run")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run and print; return the exit code."""
    options = parse(arguments)
    jobs = jobs_of(options)
    fates = []
    for fate in solve_all(jobs, options.processes, options.time_limit):
        fates.append(fate)
        if options.each or fate.verdict in FAILED:
            cost = f"{fate.cells} cells, {fate.seconds:.2f} s"
            text = f"{fate.verdict}: kind {fate.kind}, seed {fate.seed}, {cost}"
            print(text, *fate.notes, sep="\n  ", flush=True)
    print(f"seed {options.seed}: {len(fates)} of {len(jobs)} robots solved, each with one planted pose;")
    asked = "no platform" if options.taut_only else f"platforms of up to {options.all_subsets} cables"
    print(f"all subsets of taut cables: point masses and {asked}; the planted subset alone: the others.")
    print(
        f"At most {options.cell_limit_per_robot} cells and {options.time_limit_per_robot:g} s a robot. "
        "Medians of cells and CPU seconds."
    )
    print("\n".join(table(fates)))
    return 1 if any(f.verdict in FAILED for f in fates) else 0


if __name__ == "__main__":
    sys.exit(main())
