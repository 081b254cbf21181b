"""Measure named cases: median processor time, cells, ns a cell; a table, and JSON with ``--json FILE``.

Run as ``python scripts/benchmark.py [CASE ...]``. Every case runs once before it is measured, so that the
kernels are compiled and loaded. Times are processor time of the whole Python call in one thread; the case
with two threads is measured in wall time. A case whose answer is not the known one ends the run.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from importlib.metadata import version
from pathlib import Path

from cdpr_interval.robots.model import Robot
from cdpr_interval.robots.reader import load_robot
from solvers import forward_kinematics
from solvers.result import Outcome

LONG_S = 2.0
"""Three runs are enough for a case that takes longer, seven for others."""
DATA = Path(__file__).resolve().parents[1] / "tests" / "reference" / "data"
COGIRO = (
    "10.737826963826153,10.996863446575965,10.519354683477053,10.587410916921941,"
    "9.838356404726296,9.423395407318322,9.501702491749816,11.157614327874176"
)
"""Lengths of a static pose with c1, c2, c3, c5, c7 taut, the others 5 % longer."""


MERLET = ["2.6925824035672520156", "3.9051248379533272068", "3.3541019662496845446", "4.385"]
UC4 = ["7.5", "8", "7", "9"]


@dataclass(frozen=True)
class Case:
    """One forward-kinematics question and the number of its poses."""

    name: str
    robot: Robot
    lengths: Sequence[object]
    poses: int
    taut: range | None = None
    threads: int = 1
    geometry_only: bool = False


@dataclass(frozen=True)
class Measured:
    """What a case took."""

    name: str
    runs: int
    threads: int
    median_s: float
    fastest_s: float
    cells: int
    ns_per_cell: float | None
    poses: int


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

    cables = tuple(replace(c, frame_anchor=scaled(c.frame_anchor)) for c in robot.cables)
    return replace(robot, cables=cables)


def cases() -> list[Case]:
    """Return the cases, quick ones first."""
    uc2, uc3, uc4 = (load_robot(name) for name in ("uc2", "uc3", "uc4"))
    six = json.loads((DATA / "six_leg_40.json").read_text())["lengths_m"]
    large = smaller_base(uc3, Fraction(3, 10))
    return [
        Case("point-mass-inextensible", load_robot("merlet_4_1"), MERLET, 1),
        Case("uc2", uc2, ["7.5", "8"], 8, range(2)),
        Case("uc3", uc3, ["7.5", "8", "7"], 14, range(3)),
        Case("uc4", uc4, UC4, 3, range(4)),
        Case("uc4-two-threads", uc4, UC4, 3, range(4), threads=2),
        Case("uc4-fifth-cable", fifth_cable(uc4), [*UC4, "7.6"], 0, range(5)),
        Case("uc4-all-subsets", uc4, UC4, 10),
        Case("uc3-large-platform", large, ["4", "4.4", "3.7"], 8, range(3)),
        Case("six-leg", load_robot("six_leg_40"), [str(x) for x in six], 40, range(6), geometry_only=True),
        Case("cogiro-two-threads", load_robot("cogiro"), COGIRO.split(","), 44, threads=2),
    ]


def measure(case: Case, runs: int | None) -> Measured:
    """Run a case once unmeasured and then ``runs`` times."""
    clock: Callable[[], float] = time.process_time if case.threads == 1 else time.perf_counter
    times: list[float] = []
    wanted = 1
    while len(times) < wanted + 1:
        start = clock()
        result = forward_kinematics(
            case.robot,
            case.lengths,
            taut=case.taut,
            threads=case.threads,
            ignore_tension_sign=case.geometry_only,
        )
        times.append(clock() - start)
        if result.outcome is not Outcome.COMPLETE or len(result.solutions) != case.poses:
            raise SystemExit(f"{case.name}: {len(result.solutions)} poses, {result.outcome.value}")
        if len(times) == 2:
            wanted = runs or (3 if times[1] > LONG_S else 7)
    median = statistics.median(times[1:])
    cells = result.statistics.cells
    each = 1e9 * median / cells if cells else None
    return Measured(case.name, wanted, case.threads, median, min(times[1:]), cells, each, case.poses)


def processor() -> str:
    """Return the processor's name."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    return next(
        (x.split(":", 1)[1].strip() for x in lines if x.startswith("model name")), platform.processor()
    )


def line(m: Measured) -> str:
    """Return a table line."""
    each = "" if m.ns_per_cell is None else f"{m.ns_per_cell:10.0f}"
    return (
        f"{m.name:<26}{m.poses:>6}{m.cells:>10}{m.median_s:>12.6f}{m.fastest_s:>12.6f}{m.runs:>6}{each:>10}"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print; return the exit code."""
    parser = argparse.ArgumentParser(description="Measure named cases.")
    parser.add_argument("cases", nargs="*", help="names of cases; all where none is named")
    parser.add_argument("--runs", type=int, help="measured runs a case")
    parser.add_argument("--json", type=Path, help="also write this file")
    options = parser.parse_args(arguments)
    known = {case.name: case for case in cases()}
    unknown = [name for name in options.cases if name not in known]
    if unknown:
        parser.error(f"unknown case {unknown[0]}; known: {', '.join(known)}")
    machine = {
        "processor": processor(),
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0],
        "python": platform.python_version(),
        **{name: version(name) for name in ("numba", "numpy", "cdpr-interval")},
    }
    print(", ".join(f"{key} {value}" for key, value in machine.items()))
    print(f"{'case':<26}{'poses':>6}{'cells':>10}{'median s':>12}{'fastest s':>12}{'runs':>6}{'ns/cell':>10}")
    found = []
    for name in options.cases or known:
        found.append(measure(known[name], options.runs))
        print(line(found[-1]), flush=True)
    if options.json:
        options.json.write_text(
            json.dumps({"machine": machine, "cases": [asdict(m) for m in found]}, indent=1)
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
