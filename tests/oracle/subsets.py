"""Every static pose that multi-start Newton finds, over all subsets of taut cables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import mpmath
import numpy as np

from .model import Case
from .newton import solve
from .refine import refine
from .stability import stability
from .starts import random_starts
from .statics import DIGITS, Pose, System, jacobian, number, spokes, system_of, wrenches

SAME = 1e-5
"""Float solutions of one subset nearer than this are refined once."""
DEPENDENT = 1e-7
"""Wrenches whose least singular value is below it are left to the smaller subsets (Caratheodory)."""
MEMBERS = 8
"""So many poses of a continuum are kept."""
ZERO, CLEAR = mpmath.mpf(10) ** -35, mpmath.mpf(10) ** -25
"""Below the one a tension or margin counts as exactly zero, above the other as clearly not."""


@dataclass(frozen=True)
class StaticPose:
    """A static pose to 50 digits, in SI units; mpmath numbers."""

    taut: tuple[int, ...]
    centre: Any
    """(3,) centre of mass."""
    position: Any
    """(3,) platform origin."""
    rotation: Any
    """(3, 3)."""
    tensions: Any
    """(N,) N, zero for a slack cable."""
    distances: Any
    """(N,) m."""
    margins: Any
    """(N,) m: length less distance of a cable outside ``taut``, zero for those inside."""
    free: int
    """Dimension of the continuum it belongs to; 0 for an isolated pose."""
    clear: bool
    """No tension and no margin is exactly zero."""
    slack_respected: bool
    stability: str
    """``stable``, ``unstable`` or ``unclear``."""

    def describe(self) -> str:
        """Return the pose in few digits."""
        where = ", ".join(f"{float(x):.9g}" for x in self.position)
        turn = np.array2string(self.rotation.astype(float), precision=6, separator=",").replace("\n", "")
        names = ",".join(f"c{i + 1}" for i in self.taut)
        return f"pose taut {names} at ({where}) rotation {turn} ({self.stability})"


@dataclass(frozen=True)
class Question:
    """An exact question in both kinds of numbers."""

    case: Case
    coarse: System
    precise: System


def question_of(case: Case) -> Question:
    """Prepare an exact question."""
    with mpmath.workdps(DIGITS + 10):
        return Question(case, system_of(case), system_of(case, precise=True))


def subsets_of(case: Case) -> Iterator[tuple[int, ...]]:
    """Yield the subsets of cables that may be taut together."""
    if case.taut is not None:
        yield case.taut
        return
    most = 6 if not case.point_mass else 3 if case.stiffness is None else case.count
    for size in range(1, min(most, case.count) + 1):
        yield from combinations(range(case.count), size)


def within_reach(system: System, taut: tuple[int, ...]) -> bool:
    """Return False where two inextensible cables cannot both reach the platform."""
    for i, j in combinations(taut, 2):
        if system.compliance[i] or system.compliance[j]:
            continue
        gap = np.linalg.norm(system.exits[i] - system.exits[j])
        span = np.linalg.norm(system.arms[i] - system.arms[j])
        if gap > (system.lengths[i] + system.lengths[j] + span) * (1 + 1e-12):
            return False
    return True


def find_poses(
    case: Case, rng: np.random.Generator, starts: int, hints: Iterable[tuple[tuple[int, ...], Pose]] = ()
) -> list[StaticPose]:
    """Return the static poses of an exact question that Newton finds.

    Parameters
    ----------
    starts : int
        Random starts for each subset.
    hints : iterable of (subset, Pose)
        More starts, in the units of the system.
    """
    question, known = question_of(case), list(hints)
    found: list[StaticPose] = []
    for subset in subsets_of(case):
        if not within_reach(question.coarse, subset):
            continue
        taut = np.array(subset)
        batch = random_starts(rng, question.coarse, taut, starts)
        extra = [pose for of, pose in known if of == subset]
        if extra:
            batch = Pose(
                *(
                    np.concatenate([getattr(batch, name), *(getattr(pose, name)[None] for pose in extra)])
                    for name in ("p", "rotation", "tensions")
                )
            )
        found += _judged(question, subset, solve(question.coarse, batch, taut))
    return found


def _judged(question: Question, subset: tuple[int, ...], solutions: Pose) -> list[StaticPose]:
    """Return the static poses among float solutions of one subset, each once."""
    found: list[StaticPose] = []
    for pose in _distinct(_plausible(question, subset, solutions)):
        if sum(f.free > 0 for f in found) >= MEMBERS:
            break
        static = judge(question, subset, pose)
        if static is not None and not any(_same(static, other) for other in found):
            found.append(static)
    return found


def _plausible(question: Question, subset: tuple[int, ...], solutions: Pose) -> Pose:
    """Return the solutions without negative tensions and, where it matters, with the others slack."""
    system = question.coarse
    keep = (solutions.tensions > -1e-7).all(axis=-1)
    others = [i for i in range(system.count) if i not in subset]
    if others and not question.case.ignore_slack:
        _, e = spokes(system, solutions, np.array(others))
        keep &= (np.linalg.norm(e, axis=-1) < system.lengths[others] + 1e-7).all(axis=-1)
    return Pose(solutions.p[keep], solutions.rotation[keep], solutions.tensions[keep])


def _distinct(solutions: Pose) -> list[Pose]:
    """Return one of each group of solutions that nearly coincide."""
    flat = np.concatenate(
        [solutions.p, solutions.rotation.reshape(-1, 9), np.clip(solutions.tensions, None, 1e3)], axis=-1
    )
    chosen: list[int] = []
    for k, row in enumerate(flat):
        if not chosen or np.abs(flat[chosen] - row).max(axis=1).min() > SAME:
            chosen.append(k)
    return [Pose(solutions.p[k], solutions.rotation[k], solutions.tensions[k]) for k in chosen]


def _same(a: StaticPose, b: StaticPose) -> bool:
    pairs = ((a.position, b.position), (a.rotation, b.rotation))
    return all(max(abs(x - y) for x, y in zip(p.ravel(), q.ravel(), strict=True)) < ZERO for p, q in pairs)


def judge(question: Question, subset: tuple[int, ...], pose: Pose) -> StaticPose | None:
    """Return the static pose at a float solution to 50 digits; None where it is none, or not clear."""
    taut = np.array(subset)
    if not question.case.point_mass or question.case.stiffness is None:
        s = np.linalg.svd(wrenches(question.coarse, pose, taut), compute_uv=False)
        if len(s) < len(taut) or s[-1] < DEPENDENT * s[0]:
            return None
    refined = refine(question.coarse, question.precise, pose, taut)
    if refined is None:
        return None
    sharp, free = refined
    with mpmath.workdps(DIGITS + 10):
        return _static(question, subset, sharp, free)


def _static(question: Question, subset: tuple[int, ...], sharp: Pose, free: int) -> StaticPose | None:
    system, case = question.precise, question.case
    batch = Pose(sharp.p[None], sharp.rotation[None], sharp.tensions[None])
    _, e = spokes(system, batch, np.arange(system.count))
    distances = np.array([mpmath.sqrt(x) for x in (e[0] * e[0]).sum(axis=-1)], dtype=object)
    margins = system.lengths - distances
    margins[list(subset)] = number(0)
    outside = [margins[i] for i in range(system.count) if i not in subset]
    signs = list(sharp.tensions) + ([] if case.ignore_slack else outside)
    if any(x < -ZERO or ZERO < x < CLEAR for x in signs):
        return None
    if case.taut is not None and any(abs(x) < CLEAR for x in sharp.tensions):
        # Not what was asked: a pose of a smaller subset at which this one is just tight.
        return None
    tensions = np.array([number(0)] * system.count, dtype=object)
    tensions[list(subset)] = sharp.tensions
    unit_m, unit_N = number(system.unit_m), number(system.unit_N)
    coarse = Pose(*(a.astype(float) for a in (sharp.p, sharp.rotation, sharp.tensions)))
    return StaticPose(
        taut=subset,
        centre=sharp.p * unit_m,
        position=(sharp.p - sharp.rotation @ system.centre) * unit_m,
        rotation=sharp.rotation,
        tensions=tensions * unit_N,
        distances=distances * unit_m,
        margins=margins * unit_m,
        free=free,
        clear=all(x >= CLEAR for x in signs) and all(abs(x) >= CLEAR for x in outside),
        slack_respected=all(x >= -ZERO for x in outside),
        stability=stability(
            question.coarse, coarse, np.array(subset), free_motions(question, subset, coarse, free)
        ),
    )


def free_motions(question: Question, subset: tuple[int, ...], pose: Pose, free: int) -> Any:
    """Return the motions along a continuum, (free, 6 or 3)."""
    size = 6 if question.coarse.turns else 3
    _, _, vt = np.linalg.svd(jacobian(question.coarse, pose, np.array(subset)))
    return vt[len(vt) - free :, :size]
