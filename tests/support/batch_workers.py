"""What workers of test batches do, importable by new processes; and job files for them."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path

from solvers.batch.work import Chunk, JobOutcome, solve_chunk

MONTE_CARLO = """
format: cdpr-batch/1
robots: [merlet_4_1_k100]
problems:
  - type: monte-carlo
    lengths_m: [2.99558, 2.99558, 4.121083, 4.121083]
    samples: {samples}
    seed: 1
    perturb:
      lengths_m: {{distribution: uniform, half_width: 0.03}}
      stiffness: {{distribution: normal, relative_sigma: 0.05}}
"""
DEADLY = 2.0
"""m of the first cable: such a job kills its worker."""


def listed(lengths: list[list[float]], robot: str = "merlet_4_1") -> str:
    """Return a job file of listed lengths."""
    rows = "".join(f"      - {row}\n" for row in lengths)
    return f"format: cdpr-batch/1\nrobots: [{robot}]\nproblems:\n  - type: lengths\n    lengths_m:\n{rows}"


def deadly(chunk: Chunk) -> list[JobOutcome]:
    """Die at a certain length, as a worker that runs out of memory does."""
    for task in chunk.tasks:
        if float(json.loads(task.input)["lengths_m"][0]) == DEADLY:
            os.kill(os.getpid(), signal.SIGKILL)
    return solve_chunk(chunk)


def deadly_part(chunk: Chunk) -> list[JobOutcome]:
    """Die in one part of a split job."""
    for task in chunk.tasks:
        asked = json.loads(task.input)
        if asked["lengths_m"][0] == "7.6" and asked.get("part", {}).get("number") == 4:
            os.kill(os.getpid(), signal.SIGKILL)
    return solve_chunk(chunk)


def deadly_in_company(chunk: Chunk) -> list[JobOutcome]:
    """Die when there is more than one job in a chunk."""
    if len(chunk.tasks) > 1:
        os._exit(3)
    return solve_chunk(chunk)


def stillborn(*arguments: object) -> None:
    """End before there was anything to do."""
    os._exit(7)


def write(folder: Path, text: str) -> Path:
    """Write a job file."""
    path = folder / "jobs.yaml"
    path.write_text(text)
    return path
