"""A certificate's entries: for every taut subset what proves that all its poses are listed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from flint import ctx

from certificates.balls import BITS
from certificates.frames import settings
from certificates.problem import Listed
from certificates.problem import Problem as Question
from certificates.subsets import Kind, classify, examined
from solvers import balls
from solvers.certificate_point import certificate_question, listed_solution, point_entry
from solvers.certificate_tree import Recorder
from solvers.platform_frame import pose_of
from solvers.platform_reduction import Reduced
from solvers.platform_roots import Root
from solvers.platform_subset import SubsetSearch
from solvers.problem import Options, Problem
from solvers.result import Solution

Json = dict[str, Any]
NEAR = 1e-6
"""Entries of rotation matrices that differ by less may belong to one pose: it is checked."""


@dataclass(frozen=True, eq=False)
class Searched:
    """One search of a run: what it was, and what it found."""

    reduced: Reduced
    roots: tuple[Root, ...]
    whole: bool
    """Nothing is pending."""


@dataclass
class Record:
    """The searches of a run, by taut subset."""

    searches: dict[tuple[int, ...], list[Searched]] = field(default_factory=dict)

    def keep(self, taut: tuple[int, ...], reduced: Reduced, subset: SubsetSearch) -> None:
        """Remember a search that has ended."""
        found = Searched(reduced, tuple(subset.roots), subset.pending == 0)
        self.searches.setdefault(taut, []).append(found)


def subset_entries(
    problem: Problem, options: Options, record: Record, solutions: Sequence[Solution]
) -> list[Json]:
    """Return the entries of all subsets to be examined.

    ``solutions`` : as the document lists them. What the checker would refuse is written as pending.
    """
    question = certificate_question(problem, options)
    listed = [listed_solution(s) for s in solutions]
    with ctx.workprec(BITS), balls.precision():
        return [
            {"taut": list(taut), **entry(problem, options, question, taut, record, listed, list(solutions))}
            for taut in examined(question)
        ]


def entry(
    problem: Problem,
    options: Options,
    question: Question,
    taut: tuple[int, ...],
    record: Record,
    listed: list[Listed],
    solutions: list[Solution],
) -> Json:
    """Return what proves one subset."""
    kind = None if question.is_point_mass else classify(question, taut)
    if kind is None or kind in (Kind.FREE, Kind.ONE_POINT):
        found = point_entry(problem, options, taut, solutions)
        return found if "pending" in found else {"point": found}
    if kind is Kind.DEPENDENT:
        return {} if problem.taut is None else {"pending": "the wrenches are dependent in every pose"}
    searched = record.searches.get(taut, [])
    frames = settings(question, taut, kind)
    if kind is Kind.BOTH:
        return {"pending": "families about two axes are not certified"}
    if len(searched) < len(frames):
        return {"pending": "not searched"}
    entries: list[Json] = []
    for one, setting in zip(searched, frames, strict=True):
        recorder = Recorder(question, setting, one.reduced, listed)
        for root in one.roots:
            recorder.add(root, candidates(root, one.reduced, solutions, setting.family))
        entries.append(recorder.entry(whole=one.whole))
    return {"searches": entries}


def candidates(root: Root, reduced: Reduced, solutions: Sequence[Solution], family: bool) -> list[int]:
    """Return the solutions that a root's pose may be."""
    pose = pose_of(root, reduced.frame)
    rotation = balls.middle(pose.rotation)
    return [
        k
        for k, solution in enumerate(solutions)
        if (solution.family is not None) == family
        and (family or bool(np.all(np.abs(rotation - solution.rotation.mean(axis=-1)) < NEAR)))
    ]
