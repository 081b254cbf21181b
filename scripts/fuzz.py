"""Draw examples that no run has tried before, for as long as asked, and print what reproduces a failure.

Run as ``make fuzz SECONDS=600 SEED=1``, or ``python scripts/fuzz.py --seconds 600 --seed 1``. Rounds of every
stage below, with the seeds SEED, SEED + 1, ..., follow one another until the time is over; what runs then is
ended and counts as nothing. The exit code is 1 when a stage has failed.
"""

from __future__ import annotations

import argparse
import itertools
import os
import random
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Stage:
    """A program that draws examples by a seed and fails where one is wrong."""

    name: str
    arguments: tuple[str, ...]
    """Of Python; ``{seed}`` stands for the seed of the round."""

    def command(self, seed: int) -> list[str]:
        """Return the command of a round."""
        return [sys.executable, *(argument.format(seed=seed) for argument in self.arguments)]


STAGES = (
    Stage(
        "property tests",
        (
            "-m", "pytest", "-q", "-m", "hypothesis", "tests",
            "--hypothesis-profile=fuzz", "--hypothesis-seed={seed}",
        ),
    ),
    Stage("oracle", ("scripts/fuzz_oracle.py", "--seconds", "120", "--seed", "{seed}")),
    Stage("planted point masses", ("scripts/planted_point_mass.py", "200", "{seed}")),
    Stage(
        "planted platforms",
        (
            "scripts/planted.py", "--robots", "54", "--seed", "{seed}", "--taut-only",
            "--time-limit-per-robot", "30", "--cell-limit-per-robot", "3000000",
        ),
    ),
)  # fmt: skip


@dataclass(frozen=True)
class Failure:
    """What a stage found."""

    stage: str
    command: str
    """For a shell, in the project's folder; it draws the same examples again."""
    output: str


class OutOfTime(Exception):
    """The time was over before a stage ended."""


def run(stage: Stage, seed: int, seconds: float) -> Failure | None:
    """Run one round of a stage; return what failed, None when it passed, or raise `OutOfTime`."""
    command = stage.command(seed)
    # A group of its own, so that the stage's own workers end with it.
    process = subprocess.Popen(
        command, cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True
    )
    try:
        output, _ = process.communicate(timeout=seconds)
    except BaseException as error:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        if isinstance(error, subprocess.TimeoutExpired):
            raise OutOfTime from None
        raise
    return None if process.returncode == 0 else Failure(stage.name, shlex.join(command), output)


def fuzz(stages: Sequence[Stage], seconds: float, seed: int) -> list[Failure]:
    """Run rounds until the time is over, a line each; print and return what failed."""
    end = time.monotonic() + seconds
    failures: list[Failure] = []
    for number in itertools.count(seed):
        for stage in stages:
            start = time.monotonic()
            try:
                failure = run(stage, number, max(end - start, 0.0))
            except OutOfTime:
                print(f"seed {number}: {stage.name}: the time is over", flush=True)
                return failures
            word = "FAILED" if failure else "passed"
            print(f"seed {number}: {stage.name}: {word} after {time.monotonic() - start:.0f} s", flush=True)
            if failure:
                failures.append(failure)
                print(f"{failure.output}\nreproduce: {failure.command}", flush=True)
    raise AssertionError("there is always another seed")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run and print; return the exit code."""
    parser = argparse.ArgumentParser(description="Draw new examples and print what reproduces a failure.")
    parser.add_argument("--seconds", type=float, default=600.0, help="how long")
    parser.add_argument("--seed", type=int, help="of the first round; default: a random one, printed")
    options = parser.parse_args(arguments)
    seed = random.SystemRandom().randrange(10**9) if options.seed is None else options.seed
    print(f"first seed {seed}, {options.seconds:g} s", flush=True)
    failures = fuzz(STAGES, options.seconds, seed)
    for failure in failures:
        print(f"FAILED: {failure.stage}: reproduce: {failure.command}")
    return 1 if failures else 0


if __name__ == "__main__":
    raise SystemExit(main())
