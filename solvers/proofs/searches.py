"""The certificate's entries of taut subsets that are searched: roots and trees of each of their frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cdpr_interval.exact import balls
from certificates.frames import settings
from certificates.problem import Listed
from certificates.problem import Problem as Question
from certificates.subsets import Kind
from solvers.proofs.tree import Recorder
from solvers.six_dof.record import Searched
from solvers.six_dof.reduction import Reduced
from solvers.six_dof.roots import Root, pose_of

NEAR = 1e-6
"""Entries of rotation matrices that differ by less may belong to one pose: it is checked."""


def search_entries(
    question: Question, taut: tuple[int, ...], kind: Kind, searched: Sequence[Searched], listed: list[Listed]
) -> list[dict[str, Any]] | None:
    """Return one entry for each frame of a subset, or None where not all of them were searched."""
    frames = settings(question, taut, kind)
    if len(searched) < len(frames):
        return None
    entries = []
    with balls.precision():
        for one, setting in zip(searched, frames, strict=False):
            recorder = Recorder(question, setting, one.reduced, listed)
            for root in one.roots:
                recorder.add(root, candidates(root, one.reduced, listed, setting.family))
            entries.append(recorder.entry(whole=one.whole))
    return entries


def candidates(root: Root, reduced: Reduced, listed: Sequence[Listed], family: bool) -> list[int]:
    """Return the solutions that a root's pose may be."""
    middle = balls.middle(pose_of(root, reduced.frame).rotation)
    return [
        k
        for k, solution in enumerate(listed)
        if (solution.family is not None) == family
        and (family or bool(np.all(np.abs(middle - np.mean(solution.rotation, axis=-1)) < NEAR)))
    ]
