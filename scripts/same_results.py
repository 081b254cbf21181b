"""Record what the solvers answer, bit for bit, and compare two records: for changes that must change nothing.

Run as ``python scripts/same_results.py record FOLDER`` before and after, then ``compare BEFORE AFTER``.
A record holds the result documents, without times, of the questions of the benchmark and of planted
robots, and the poses of trackers and prepared point-mass solvers along closed paths, doubles in hex.
Searches are bounded by cells, never by time, so a record depends on the code alone. The exit code of
``compare`` is 1 where two records differ or hold different questions.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

# Run from anywhere: the cases lie in this folder, the planted robots beside the tests.
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parent))

import benchmark_cases
import planted_point_mass as point

from solvers import PointMass, Tracker, forward_kinematics
from tests.support.planted import platform

POINT_KINDS = ("point-mass", "point-mass-elastic")
CELLS = 20_000
"""Most cells of a planted robot: enough for most, and what stays open is compared as well."""
TIMES = ("time_s", "sha256", "provenance", "version")
"""Fields that say nothing of the answer."""
STEPS = 200
"""Of a closed path."""


def without_times(value: Any) -> Any:
    """Return a document without the fields of `TIMES`, doubles as hexadecimal text."""
    if isinstance(value, dict):
        return {k: without_times(v) for k, v in value.items() if k not in TIMES}
    if isinstance(value, list | tuple):
        return [without_times(v) for v in value]
    return value.hex() if isinstance(value, float) else value


def plain(value: Any) -> Any:
    """Return what a controller gets as plain data."""
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in fields(value) if f.compare}
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, float):
        return value.hex()
    return value if isinstance(value, int | str | None) else str(value)


def ask(*question: Any, **options: Any) -> Any:
    """Return the document of one call of `forward_kinematics`."""
    return without_times(forward_kinematics(*question, **options).to_dict())


def benchmark_questions() -> Iterator[tuple[str, Callable[[], Any]]]:
    """Yield the questions of the benchmark, one thread each but the last."""
    robots = {
        name: benchmark_cases.shipped(name) for name in ("uc2", "uc3", "uc4", "merlet_4_1", "six_leg_40")
    }
    six = json.loads((benchmark_cases.DATA / "six_leg_40.json").read_text())["lengths_m"]
    large = benchmark_cases.smaller_base(robots["uc3"], Fraction(3, 10))
    uc4, cogiro = benchmark_cases.UC4, benchmark_cases.shipped("cogiro")
    yield "point-mass", partial(ask, robots["merlet_4_1"], benchmark_cases.MERLET)
    yield "uc2", partial(ask, robots["uc2"], ["7.5", "8"])
    yield "uc3", partial(ask, robots["uc3"], ["7.5", "8", "7"])
    yield "uc4", partial(ask, robots["uc4"], uc4)
    yield "uc3-range", partial(ask, robots["uc3"], [["7.4999", "7.5001"], "8", "7"], cell_limit=200_000)
    yield "uc3-large", partial(ask, large, ["4", "4.4", "3.7"])
    yield "fifth-cable", partial(ask, benchmark_cases.fifth_cable(robots["uc4"]), [*uc4, "7.6"])
    yield (
        "six-leg",
        partial(ask, robots["six_leg_40"], [str(x) for x in six], taut=range(6), ignore_tension_sign=True),
    )
    yield "cogiro", partial(ask, cogiro, benchmark_cases.COGIRO.split(","), threads=2)


def planted_questions(count: int, seed: int) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Yield planted robots, the kinds in turn; platforms of up to three cables with all subsets."""
    kinds = (*POINT_KINDS, *platform.KINDS)
    for i in range(count):
        kind, number = kinds[i % len(kinds)], seed * 1_000_003 + i // len(kinds)
        yield f"{kind}/{number}", partial(planted_answer, kind, number)


def planted_answer(kind: str, number: int) -> Any:
    """Return the document of one planted robot."""
    if kind in POINT_KINDS:
        rng = random.Random(f"{kind}/{number}")
        problem = point.plant(
            rng, kind == POINT_KINDS[1], Fraction(10) ** rng.choice((0, 0, 0, 2, -3))
        ).problem
        return ask(problem.robot, problem.lengths, external_force=problem.external_force, cell_limit=CELLS)
    planted = platform.plant(kind, number)
    taut = None if len(planted.lengths) <= 3 else planted.taut
    force = planted.external_force
    return ask(planted.robot, planted.lengths, taut=taut, external_force=force, cell_limit=CELLS)


def paths() -> Iterator[tuple[str, Callable[[], Any]]]:
    """Yield closed paths of trackers and of prepared point-mass solvers."""
    cogiro = [float(x) for x in benchmark_cases.COGIRO.split(",")]
    for name, lengths, taut in (
        ("uc2", [7.5, 8.0], range(2)),
        ("uc3", [7.5, 8.0, 7.0], range(3)),
        ("uc4", [7.5, 8.0, 7.0, 9.0], range(4)),
        ("cogiro", cogiro, range(1, 7)),
    ):
        yield f"tracker-{name}", partial(tracked, name, lengths, taut)
    for count, elastic in ((3, False), (8, False), (2, True), (4, True), (7, True)):
        yield f"controller-{count}-{'elastic' if elastic else 'exact'}", partial(controlled, count, elastic)


def tracked(name: str, lengths: Sequence[float], taut: Sequence[int]) -> Any:
    """Return the tracked poses along the benchmark's path and along one four times as wide."""
    robot = benchmark_cases.shipped(name)
    poses = forward_kinematics(robot, lengths, taut=taut).solutions
    (start,) = [pose for pose in poses if pose.stability == "stable"]
    found = []
    for swing in (benchmark_cases.SWING, 4.0 * benchmark_cases.SWING):
        tracker = Tracker(robot)
        tracker.reset(start)
        for step in range(STEPS):
            rng = random.Random(step)
            given = [x + swing * rng.uniform(-1.0, 1.0) * min(1.0, step / STEPS) for x in lengths]
            found.append(plain(tracker.update(given)))
    return found


def controlled(count: int, elastic: bool) -> Any:
    """Return the answers of a prepared point-mass solver for a hundred points."""
    robot, lengths = benchmark_cases.hanging_robot(count, elastic, seed=count)
    solver = PointMass(robot)
    return [plain(solver.solve(given)) for given in lengths]


def record(folder: Path, count: int, seed: int) -> None:
    """Write one file a question."""
    folder.mkdir(parents=True, exist_ok=True)
    questions = [*benchmark_questions(), *paths(), *planted_questions(count, seed)]
    start = time.process_time()
    for name, answer in questions:
        (folder / f"{name.replace('/', '-')}.json").write_text(json.dumps(answer(), indent=1))
    print(f"seed {seed}: {len(questions)} questions in {time.process_time() - start:.0f} s of processor time")


def answers(file: Path) -> Any:
    """Return what a record holds, also one written when fewer fields were left out."""
    return without_times(json.loads(file.read_text(encoding="utf-8")))


def compare(before: Path, after: Path) -> int:
    """Print the questions with different answers; return the exit code."""
    names = [{path.name for path in folder.glob("*.json")} for folder in (before, after)]
    only, both = sorted(names[0] ^ names[1]), sorted(names[0] & names[1])
    other = [name for name in both if answers(before / name) != answers(after / name)]
    for name in only:
        print(f"in one record only: {name}")
    for name in other:
        print(f"different: {name}")
    print(f"{len(both)} questions compared, {len(other)} with another answer")
    return 1 if only or other or not both else 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Record or compare; return the exit code."""
    parser = argparse.ArgumentParser(description="Record answers bit for bit, and compare two records.")
    commands = parser.add_subparsers(dest="command", required=True)
    recording = commands.add_parser("record", help="write one file a question")
    recording.add_argument("folder", type=Path)
    recording.add_argument("--robots", type=int, default=500, help="number of planted robots")
    recording.add_argument("--seed", type=int, default=1)
    comparing = commands.add_parser("compare", help="print the questions with different answers")
    comparing.add_argument("before", type=Path)
    comparing.add_argument("after", type=Path)
    options = parser.parse_args(arguments)
    if options.command == "compare":
        return compare(options.before, options.after)
    record(options.folder, options.robots, options.seed)
    return 0


if __name__ == "__main__":
    sys.exit(main())
