"""``cdpr-solve warm-up``: compile the kernels beforehand, in parallel processes."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import click

from cdpr_interval.errors import CdprError
from solvers.commands.kernel_units import PLATFORM, POINT, UNITS
from solvers.shell.examples import examples
from solvers.shell.interrupt import interruptible

HOME = str(Path(__file__).resolve().parents[2])
"""The folder the packages lie in."""
TICK = 0.1
"""s between two looks at the processes."""
SHOWN_EVERY = 10.0
"""s between two lines about what is still compiled."""


@dataclass
class Running:
    """A unit under way."""

    name: str
    process: subprocess.Popen[str]
    begun: float


@click.command(
    "warm-up",
    short_help="Compile the kernels beforehand, once per machine.",
    epilog=examples("warm-up point"),
)
@click.argument("kind", type=click.Choice([POINT, PLATFORM, "all"]), default="all")
@click.option(
    "--threads",
    type=click.IntRange(min=1),
    default=None,
    metavar="N",
    help="Processes that compile at once; default: one a core.",
)
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
def command(kind: str, threads: int | None, quiet: bool) -> None:
    """Compile the kernels beforehand, once per machine.

    point: point masses on inextensible and on elastic cables; platform: six-dof platforms, their certificates
    and trackers; all: both, some minutes of processor time. What is compiled already is only loaded.

    Otherwise the first question of each kind waits for them. Where they lie and how to share them: page
    docs/install.md; NUMBA_CACHE_DIR names another folder.
    """
    begun = time.monotonic()
    names = [name for name, unit in UNITS.items() if kind in (unit.kind, "all")]
    run = WarmUp(names, threads or os.cpu_count() or 1, quiet)
    try:
        with interruptible():
            run.run()
    finally:
        run.stop()
    run.say(f"kernels are ready after {time.monotonic() - begun:.0f} s")


class WarmUp:
    """Units that are compiled, so many at once."""

    def __init__(self, names: Sequence[str], processes: int, quiet: bool) -> None:
        self._waiting, self._processes, self._quiet = list(names), processes, quiet
        self._running: list[Running] = []
        self._total, self._done = len(names), 0
        self._said = time.monotonic()

    def say(self, line: str) -> None:
        """Print a line on stderr."""
        if not self._quiet:
            self._said = time.monotonic()
            click.echo(line, err=True)

    def run(self) -> None:
        """Compile all units; `CdprError` when one fails."""
        while self._waiting or self._running:
            while len(self._running) < self._processes and (name := self._next()) is not None:
                self._start(name)
            time.sleep(TICK)
            for one in [one for one in self._running if one.process.poll() is not None]:
                self._running.remove(one)
                self._end(one)
            if self._running and time.monotonic() - self._said > SHOWN_EVERY:
                under_way = ", ".join(
                    f"{UNITS[one.name].words} {time.monotonic() - one.begun:.0f} s" for one in self._running
                )
                self.say(f"{self._done}/{self._total} done; still compiling: {under_way}")

    def stop(self) -> None:
        """End what is still under way; what it has compiled is kept.

        A search takes SIGTERM as the end of its budget, and would compile on; files are replaced in one step.
        """
        for one in self._running:
            one.process.kill()
        for one in self._running:
            one.process.communicate()

    def _next(self) -> str | None:
        """Take a unit that waits for none."""
        left = {*self._waiting, *(one.name for one in self._running)}
        for name in self._waiting:
            if UNITS[name].after not in left:
                self._waiting.remove(name)
                return name
        return None

    def _start(self, name: str) -> None:
        process = subprocess.Popen(
            # The kernels of this very package, whatever lies in the present folder.
            [sys.executable, "-P", "-m", "solvers.commands.kernel_units", name],
            env={
                **os.environ,
                "PYTHONPATH": os.pathsep.join(filter(None, (HOME, os.environ.get("PYTHONPATH")))),
            },
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._running.append(Running(name, process, time.monotonic()))
        self.say(f"compiling kernels for {UNITS[name].words} ...")

    def _end(self, one: Running) -> None:
        output, errors = one.process.communicate()
        words = UNITS[one.name].words
        if one.process.returncode != 0:
            last = errors.strip().splitlines()[-1:] or [f"exit code {one.process.returncode}"]
            raise CdprError(f"kernels for {words} could not be compiled: {last[0]}")
        self._done += 1
        count, seconds = int(output), time.monotonic() - one.begun
        what = f"{count} compiled" if count else "nothing to compile"
        self.say(f"[{self._done}/{self._total}] {words}: {what}, {seconds:.0f} s")
