"""The certificate's entries of taut subsets that are searched: roots and trees of each of their frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from cdpr_interval.exact import balls
from certificates.frames import settings
from certificates.problem import Listed
from certificates.problem import Problem as Question
from certificates.subsets import Kind
from solvers.proofs.recorder import Recorder
from solvers.six_dof.record import Searched


def search_entries(
    question: Question, taut: tuple[int, ...], kind: Kind, searched: Sequence[Searched], listed: list[Listed], budget, threads
) -> list[dict[str, Any]] | None:
    """Return one entry for each frame of a subset, or None where not all of them were searched."""
    frames = settings(question, taut, kind)
    if len(searched) < len(frames):
        return None
    entries = []
    with balls.precision():
        for one, setting in zip(searched, frames, strict=False):
            recorder = Recorder(question, setting, one, listed)
            recorder.claim_roots(lambda: budget.stop() is None)
            recorder.complete(budget, threads)
            entries.append(recorder.entry())
    return entries
