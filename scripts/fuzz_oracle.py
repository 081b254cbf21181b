"""Compare `fk` with the independent oracle on random questions, for as long as asked.

Run as ``python scripts/fuzz_oracle.py --seconds 600 --seed 1``. Each question is one of the kinds of
``tests/oracle/problems.py``; what contradicts the oracle is printed with kind and seed, the robot's
file and the command, and the exit code is 1. ``--kind KIND --only SEED`` repeats one question.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from cdpr_interval.robots.formats.reader import parse_robot  # noqa: E402
from solvers import forward_kinematics  # noqa: E402
from tests.oracle.compare import compare  # noqa: E402
from tests.oracle.model import Case  # noqa: E402
from tests.oracle.problems import KINDS, problem  # noqa: E402


def answer(case: Case, time_limit: float) -> tuple[dict[str, Any], list[str]]:
    """Return the ``cdpr-result/1`` document that the solver gives, and what `Result.verify` says."""
    lengths: list[tuple[Fraction, Fraction] | Fraction] = [
        lo if lo == hi else (lo, hi) for lo, hi in case.lengths
    ]
    robot = parse_robot(case.robot_yaml().encode())
    result = forward_kinematics(
        robot,
        lengths,
        taut=case.taut,
        ignore_slack=case.ignore_slack,
        external_force=case.force,
        time_limit=time_limit,
    )
    return result.to_dict(), [f"VERIFY: {line}" for line in result.verify(robot)]


def arguments() -> argparse.Namespace:
    """Return the command line's values."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=60.0, help="stop after so many seconds")
    parser.add_argument("--seed", type=int, default=None, help="of the first question; default: the clock")
    parser.add_argument(
        "--kind", choices=sorted(KINDS), action="append", help="only this kind; may be repeated"
    )
    parser.add_argument("--only", type=int, default=None, help="only the question of this seed")
    parser.add_argument("--starts", type=int, default=60, help="Newton's random starts for each taut subset")
    parser.add_argument("--time-limit", type=float, default=20.0, help="seconds of the solver for a question")
    return parser.parse_args()


def main() -> int:
    """Ask, compare, report."""
    options = arguments()
    seed = int(time.time()) if options.seed is None else options.seed
    kinds = options.kind or list(KINDS)
    tasks = [(k, options.only) for k in kinds] if options.only is not None else None
    print(f"seed {seed}", flush=True)
    start, asked, failed, poses, entries = time.monotonic(), Counter[str](), 0, 0, 0
    number = 0
    while (number < len(tasks)) if tasks else (time.monotonic() - start < options.seconds):
        kind, which = tasks[number] if tasks else (kinds[number % len(kinds)], seed + number // len(kinds))
        number += 1
        case = problem(kind, which)
        document, wrong = answer(case, options.time_limit)
        verdict = compare(case, document, np.random.default_rng(which), starts=options.starts)
        poses, entries = poses + verdict.found, entries + verdict.listed
        asked[f"{kind} {document['outcome']}"] += 1
        wrong += verdict.contradictions
        if wrong:
            failed += 1
            print(f"\nFAILED {kind} {which}: python scripts/fuzz_oracle.py --kind {kind} --only {which}")
            print(f"  {document['outcome']}: {document['message']}")
            print("".join(f"  {line}\n" for line in wrong), end="")
            print(case.robot_yaml() + case.command("FILE"), flush=True)
    print(
        f"\n{number} questions, {failed} with a contradiction; {poses} poses of the oracle, {entries} entries"
    )
    for name, count in sorted(asked.items()):
        print(f"  {count:5d} {name}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
