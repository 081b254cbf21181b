"""One entry of a root whose ranges of lengths were cut: the hull of what its pieces report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.mechanics.stability import Stability
from solvers.answers.data import CableState, Certainty, Solution, Undecided
from solvers.questions.problem import Problem
from solvers.six_dof.real.strands import Piece

Floats = NDArray[np.float64]


def problem_of(problem: Problem, taut: Sequence[int], piece: Piece) -> Problem:
    """Return a question with the lengths of a piece for its taut cables."""
    lengths = list(problem.lengths)
    for i, (lo, hi) in zip(taut, piece.real.lengths.tolist(), strict=False):
        lengths[i] = max(lengths[i][0], Fraction(lo)), min(lengths[i][1], Fraction(hi))
    return replace(problem, lengths=tuple(lengths))


def merged(
    taut: tuple[int, ...], pieces: Sequence[Solution | Undecided | None], reason: str
) -> Solution | Undecided | None:
    """Return the entry of a strand by those of its pieces; None where no piece has a static pose.

    Undecided where some pieces have none: the hull of the others is where a pose is for some choices.
    """
    found = [piece for piece in pieces if piece is not None]
    if not found:
        return None
    position, rotation = hull([x.position for x in found]), hull([x.rotation for x in found])
    own = [piece for piece in found if isinstance(piece, Solution)]
    if len(own) < len(pieces):
        return Undecided(taut, len(pieces), reason, position, rotation)
    middle = own[len(own) // 2]
    states = tuple(
        of_cable[0] if len(set(of_cable)) == 1 else CableState.UNDECIDED
        for of_cable in zip(*(piece.cable_states for piece in own), strict=True)
    )
    proved = all(piece.is_proved for piece in own)
    return replace(
        middle,
        taut=tuple(i for i, state in enumerate(states) if state is CableState.TAUT),
        cable_states=states,
        position=position,
        rotation=rotation,
        height=hull([piece.height for piece in own]),
        tensions=hull([piece.tensions for piece in own]),
        distances=hull([piece.distances for piece in own]),
        slack_respected=agreed([piece.slack_respected for piece in own]),
        existence=Certainty.PROVED if proved else Certainty.UNDECIDED,
        stability=stability_of([piece.stability for piece in own]),
        note=next((piece.note for piece in own if piece.note), ""),
    )


def alone(
    taut: tuple[int, ...],
    strands: Sequence[Solution | Undecided],
    others: Sequence[Solution | Undecided],
    reason: str,
) -> list[Solution | Undecided]:
    """Return the entries of a subset's strands, as regions where other entries overlap them.

    A part knows no other equilibria than those of its cells: only where no other entry reaches into the box
    does it hold one pose for each choice.
    """
    found: list[Solution | Undecided] = []
    for k, entry in enumerate(strands):
        rest = [*others, *strands[:k], *strands[k + 1 :]]
        if isinstance(entry, Solution) and any(overlap(entry, other) for other in rest):
            entry = Undecided(taut, 1, reason, entry.position, entry.rotation)
        found.append(entry)
    return found


def hull(bounds: Sequence[Floats]) -> Floats:
    """Return the least bounds (..., 2) that hold all."""
    each = np.array(bounds)
    return np.stack([each[..., 0].min(axis=0), each[..., 1].max(axis=0)], axis=-1)


def agreed(answers: Sequence[bool | None]) -> bool | None:
    """Return what all say; None where they differ."""
    return answers[0] if len(set(answers)) == 1 else None


def stability_of(each: Sequence[Stability]) -> Stability:
    """Return the stability of all pieces; undecided where they differ."""
    return each[0] if len(set(each)) == 1 else Stability.UNDECIDED


def overlap(one: Solution | Undecided, other: Solution | Undecided) -> bool:
    """Return whether the boxes of two entries overlap, position and rotation."""
    pairs = ((one.position, other.position), (one.rotation, other.rotation))
    return all(
        bool((np.maximum(a[..., 0], b[..., 0]) <= np.minimum(a[..., 1], b[..., 1])).all()) for a, b in pairs
    )
