"""Measure named cases: median processor time, cells, ns a cell; a table, and JSON with ``--json FILE``.

Run as ``python scripts/benchmark.py [CASE ...]``. Every case runs once before it is measured, so that the
kernels are compiled and loaded. Times are processor time of one call in one thread, or of a whole process;
cases with two threads are measured in wall time. A case whose answer is not the known one ends the run.
``--first-run`` adds processes that start with an empty kernel cache, ``--growth`` the studies of how the
cost grows.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import statistics
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path

# Run from anywhere: the cases lie in this folder, the planted robots of the studies beside the tests.
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parent))

from benchmark_cases import Case, Clock, Done, WrongAnswer, cases

LONG_S = 2.0
"""Three runs are enough for a case that takes longer, seven for others."""
FEWEST, USUAL = 3, 7
SCALE = {"s": 1.0, "ms": 1e3, "us": 1e6}


@dataclass(frozen=True)
class Measured:
    """What one call of a case took."""

    name: str
    runs: int
    calls: int
    """In each run; the times are those of a run divided by it."""
    threads: int
    clock: str
    unit: str
    """Of the table; the times here are in s."""
    median_s: float
    fastest_s: float
    wall_median_s: float
    cells: int
    ns_per_cell: float | None
    poses: int
    note: str


def now(clock: Clock) -> float:
    """Return a clock's time in s."""
    if clock is Clock.CHILD:
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime
    return time.process_time() if clock is Clock.PROCESSOR else time.perf_counter()


def timed(case: Case) -> tuple[float, float, Done]:
    """Run a case once; return the time of its clock, the wall time and what it did."""
    wall, start = time.perf_counter(), now(case.clock)
    done = case.run()
    spent, waited = now(case.clock) - start, time.perf_counter() - wall
    if done.poses != case.poses:
        raise WrongAnswer(f"{case.name}: {done.poses} poses, expected {case.poses}")
    return spent, waited, done


def measure(case: Case, runs: int | None) -> Measured:
    """Run a case ``runs`` times, by default as often as its time allows, after one unmeasured run."""
    try:
        if case.warm:
            timed(case)
        measured = [timed(case)]
        wanted = runs or (FEWEST if measured[0][1] > LONG_S else USUAL)
        measured += [timed(case) for _ in range(wanted - 1)]
    except WrongAnswer as wrong:
        raise SystemExit(str(wrong)) from None
    times, waits = [row[0] / case.calls for row in measured], [row[1] / case.calls for row in measured]
    cells = measured[-1][2].cells
    median = statistics.median(times)
    return Measured(
        case.name,
        wanted,
        case.calls,
        case.threads,
        case.clock.value,
        case.unit,
        median,
        min(times),
        statistics.median(waits),
        cells,
        1e9 * median * case.calls / cells if cells else None,
        case.poses // case.calls,
        case.note,
    )


def processor() -> str:
    """Return the processor's name."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    return next(
        (x.split(":", 1)[1].strip() for x in lines if x.startswith("model name")), platform.processor()
    )


def machine() -> dict[str, object]:
    """Return what a time depends on besides the program."""
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0],
        "python": platform.python_version(),
        **{name: version(name) for name in ("numba", "numpy", "cdpr-interval")},
    }


HEAD = (
    f"{'case':<28}{'poses':>6}{'cells':>10}{'median':>12}{'fastest':>12}{'wall':>12}    "
    f"{'clock':<10}{'runs':>5}{'ns/cell':>9}"
)


def line(m: Measured) -> str:
    """Return a table line."""
    median, fastest, wall = (SCALE[m.unit] * x for x in (m.median_s, m.fastest_s, m.wall_median_s))
    each = "" if m.ns_per_cell is None else f"{m.ns_per_cell:.0f}"
    return (
        f"{m.name:<28}{m.poses:>6}{m.cells:>10}{median:>12.4g}{fastest:>12.4g}{wall:>12.4g} {m.unit:<3}"
        f"{m.clock:<10}{m.runs:>5}{each:>9}"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print; return the exit code."""
    parser = argparse.ArgumentParser(description="Measure named cases.")
    parser.add_argument("cases", nargs="*", help="names of cases; all but rare ones where none is named")
    parser.add_argument("--runs", type=int, help="measured runs a case")
    parser.add_argument("--json", type=Path, help="also write this file")
    parser.add_argument("--first-run", action="store_true", help="also the cases that compile every kernel")
    parser.add_argument(
        "--growth",
        nargs="*",
        metavar="STUDY",
        help="also the studies of growth, all or some of: light, precision, taut, cables",
    )
    options = parser.parse_args(arguments)
    known = {case.name: case for case in cases()}
    unknown = [name for name in options.cases if name not in known]
    if unknown:
        parser.error(f"unknown case {unknown[0]}; known: {', '.join(known)}")
    chosen = options.cases or [c.name for c in known.values() if not c.rare or options.first_run]
    described = machine()
    print(", ".join(f"{key} {value}" for key, value in described.items()))
    print(HEAD)
    document: dict[str, object] = {"machine": described}
    found = []
    for name in chosen:
        found.append(measure(known[name], options.runs))
        print(line(found[-1]), flush=True)
    document["cases"] = [asdict(m) for m in found]
    if options.growth is not None:
        document["growth"] = growth(parser, options.growth)
    if options.json:
        options.json.write_text(json.dumps(document, indent=1) + "\n")
    return 0


def growth(parser: argparse.ArgumentParser, names: Sequence[str]) -> list[dict[str, object]]:
    """Run studies, print their points and return them for the file."""
    import benchmark_growth as studies

    unknown = [name for name in names if name not in studies.STUDIES]
    if unknown:
        parser.error(f"unknown study {unknown[0]}; known: {', '.join(studies.STUDIES)}")
    print("\n" + studies.HEAD)
    points = []
    for name in names or studies.STUDIES:
        for point in studies.STUDIES[name]():
            points.append(asdict(point))
            print(studies.line(point), flush=True)
    return points


if __name__ == "__main__":
    sys.exit(main())
