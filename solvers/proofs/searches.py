"""The searches of a taut subset, as a certificate has them: one in each of its frames."""

from __future__ import annotations

from collections.abc import Sequence

from certificates.frames import settings
from certificates.problem import Listed
from certificates.problem import Problem as Question
from certificates.subsets import Kind
from solvers.proofs.recorder import Recorder
from solvers.six_dof.record import Searched


def recorders(
    question: Question, taut: tuple[int, ...], kind: Kind, searched: Sequence[Searched], listed: list[Listed]
) -> list[Recorder]:
    """Return one recorder for each frame of a subset; none where not all of them were searched."""
    frames = settings(question, taut, kind)
    if len(searched) < len(frames):
        return []
    return [Recorder(question, s, one, listed) for s, one in zip(frames, searched, strict=False)]
