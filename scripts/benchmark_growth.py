"""How the cost grows: with the number of taut cables, of cables, and with the precision asked for."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from benchmark_cases import COGIRO, LIGHT_CALLS, UC4, hanging_robot, light_calls

from cdpr_interval.robots.formats.reader import load_robot
from solvers import forward_kinematics
from solvers.answers.result import Result
from tests.support.planted import platform

TAUT_KINDS = ("c-at-centre-1", "two-cables", "general-3", "general-4", "general-5", "general-6")
"""Planted robots by number of taut cables."""
SEEDS = range(1, 6)
PRECISIONS = tuple(10.0**-k for k in range(3, 13))
LONG_S = 5.0
"""A question that takes longer is asked once."""
RUNS = 3
TIME_LIMIT_S = 240.0
"""Of one question: what is stopped by it is listed as incomplete."""


@dataclass(frozen=True)
class Point:
    """One point of a study; a study's median over robots, or over runs of one robot."""

    study: str
    subject: str
    variable: str
    value: float
    median_s: float
    """Processor time of one question, one thread."""
    slowest_s: float
    runs: int
    cells: int
    """Median where there are several robots."""
    ns_per_cell: float | None
    poses: int
    undecided: int
    complete: int
    """Number of runs that were complete."""
    widest_m: float | None = None
    """Largest width of a position, over all poses."""


def asked(ask: Callable[[], Result]) -> tuple[float, Result]:
    """Return the processor time of a question and its result."""
    start = time.process_time()
    result = ask()
    return time.process_time() - start, result


def point(study: str, subject: str, variable: str, value: float, runs: list[tuple[float, Result]]) -> Point:
    """Return the point of some runs."""
    times = [seconds for seconds, _ in runs]
    results = [result for _, result in runs]
    cells = round(statistics.median(result.statistics.cells for result in results))
    middle = statistics.median(times)
    widths = [float((s.position[:, 1] - s.position[:, 0]).max()) for r in results for s in r.solutions]
    return Point(
        study,
        subject,
        variable,
        value,
        middle,
        max(times),
        len(runs),
        cells,
        1e9 * middle / cells if cells else None,
        round(statistics.median(len(result.solutions) for result in results)),
        round(statistics.median(len(result.undecided) for result in results)),
        sum(result.outcome.value == "complete" for result in results),
        max(widths) if widths else None,
    )


def repeated(ask: Callable[[], Result]) -> list[tuple[float, Result]]:
    """Ask one question a few times, a long one once; the first time, which loads kernels, does not count."""
    first = asked(ask)
    return [first] if first[0] > LONG_S else [asked(ask) for _ in range(RUNS)]


def by_taut_cables() -> Iterator[Point]:
    """Ask planted platforms for their n planted taut cables: one run a robot, after one that loads."""
    for n, kind in enumerate(TAUT_KINDS, 1):
        runs = []
        for seed in SEEDS:
            made = platform.plant(kind, seed)

            def ask(made: platform.Planted = made) -> Result:
                return forward_kinematics(
                    made.robot,
                    made.lengths,
                    taut=made.taut,
                    external_force=made.external_force,
                    time_limit=TIME_LIMIT_S,
                )

            if seed == SEEDS[0]:
                ask()
            runs.append(asked(ask))
        yield point("taut cables", f"planted {kind}, {len(SEEDS)} robots", "n", n, runs)


def by_cables() -> Iterator[Point]:
    """Ask CoGiRo's first N cables for all subsets of taut cables."""
    robot, lengths = load_robot("cogiro"), COGIRO.split(",")
    for count in range(4, 9):
        part = replace(robot, cables=robot.cables[:count])

        def ask(part: object = part, count: int = count) -> Result:
            return forward_kinematics(part, lengths[:count], time_limit=TIME_LIMIT_S)  # type: ignore[arg-type]

        yield point("cables, all subsets", "cogiro, first N cables", "N", count, repeated(ask))


def by_precision() -> Iterator[Point]:
    """Ask for ever smaller boxes; where times and widths do not change, precision steers nothing."""
    robot = load_robot("uc4")
    for precision in PRECISIONS:

        def ask(precision: float = precision) -> Result:
            return forward_kinematics(robot, UC4, taut=range(4), precision=precision)

        yield point("precision", "uc4, all four taut", "precision", precision, repeated(ask))


def by_cables_of_a_point_mass() -> Iterator[Point]:
    """Call the prepared solver for 1 to 12 cables: the median over runs of many calls, per call."""
    for elastic in (False, True):
        for count in range(1, 13):
            case = light_calls("light", *hanging_robot(count, elastic, seed=count))
            case.run()
            times = []
            for _ in range(7):
                start = time.process_time()
                case.run()
                times.append((time.process_time() - start) / LIGHT_CALLS)
            kind = "elastic" if elastic else "inextensible"
            middle, slowest = statistics.median(times), max(times)
            row = Point(
                "cables, light call", f"point mass, {kind}", "N", count, middle, slowest, 7, 0, None, 1, 0, 7
            )
            yield row


STUDIES: dict[str, Callable[[], Iterator[Point]]] = {
    "light": by_cables_of_a_point_mass,
    "precision": by_precision,
    "taut": by_taut_cables,
    "cables": by_cables,
}


def line(p: Point) -> str:
    """Return a table line."""
    each = "" if p.ns_per_cell is None else f"{p.ns_per_cell:.0f}"
    width = "" if p.widest_m is None else f"{p.widest_m:.1e}"
    return (
        f"{p.study:<20}{p.subject:<38}{p.value:>8.3g}{p.median_s:>12.6f}{p.slowest_s:>12.6f}{p.cells:>10}"
        f"{each:>9}{p.poses:>6}{p.complete:>5}/{p.runs}{width:>10}"
    )


HEAD = (
    f"{'study':<20}{'subject':<38}{'value':>8}{'median s':>12}{'slowest s':>12}{'cells':>10}"
    f"{'ns/cell':>9}{'poses':>6}{'complete':>8}{'width m':>9}"
)
