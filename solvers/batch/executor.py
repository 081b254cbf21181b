"""Who solves chunks: the protocol that the process pool and a cluster share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from cdpr_interval.errors import CdprError
from solvers.batch.work import Chunk, JobOutcome


class ExecutorError(CdprError):
    """Workers cannot be used at all: no job's fault, and the jobs stay pending."""


Work = Callable[[Chunk], list[JobOutcome]]
"""What a worker does with a chunk."""


@dataclass(frozen=True)
class Finished:
    """A chunk that is over."""

    chunk: Chunk
    outcomes: Sequence[JobOutcome] | None
    """None: its worker died."""
    message: str = ""
    """How it died."""


class Executor(Protocol):
    """Takes chunks and gives outcomes back, in any order."""

    @property
    def workers(self) -> int:
        """Number of workers, once all are there."""

    @property
    def free(self) -> int:
        """How many chunks may be submitted now."""

    def submit(self, chunk: Chunk) -> None:
        """Start a chunk; only while ``free`` is above 0."""

    def wait(self, seconds: float) -> list[Finished]:
        """Return what is over, at the latest after so many seconds."""

    def grow(self) -> None:
        """Kernels are compiled: let all workers come."""

    def close(self) -> None:
        """End; chunks under way are given up."""
