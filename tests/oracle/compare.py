"""What contradicts a result: poses that it lacks, poses that are none, words that are not true."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np

from .entry import SLOP, Entry, inside
from .family import axes_of, member, place
from .model import Case
from .newton import solve
from .starts import rotation_of
from .statics import DIGITS, Pose, number
from .subsets import Question, StaticPose, find_poses, judge, question_of

ANGLES = 24
"""Members of a family that are looked at."""


@dataclass(frozen=True)
class Verdict:
    """What a comparison found."""

    contradictions: tuple[str, ...]
    """One sentence each."""
    found: int
    """Static poses of the oracle, over all choices of lengths."""
    listed: int
    """Entries of the result."""


def compare(
    case: Case,
    document: dict[str, Any],
    rng: np.random.Generator,
    *,
    starts: int = 60,
    choices: int = 3,
    poses: list[StaticPose] | None = None,
) -> Verdict:
    """Compare a result with what the oracle finds.

    Parameters
    ----------
    document : dict
        The ``cdpr-result/1`` document of this question.
    starts : int
        Random starts for each subset.
    choices : int
        Lengths that are looked at where the lengths are ranges.
    poses : list of StaticPose, optional
        What `find_poses` found for an exact question, where that is known already.
    """
    listing = Listing(case, document)
    if case.exact:
        if poses is None:
            poses = find_poses(case, rng, starts)
        wrong = listing.missing(poses) + listing.false_entries(rng)
        return Verdict(tuple(wrong), len(poses), len(listing.entries))
    complaints, count = list[str](), 0
    for lengths in chosen_lengths(case, rng, choices):
        there, wrong = listing.at_choice(lengths, rng, starts)
        complaints, count = complaints + wrong, count + len(there)
    return Verdict(tuple(complaints), count, len(listing.entries))


def chosen_lengths(case: Case, rng: np.random.Generator, count: int) -> list[tuple[Fraction, ...]]:
    """Return the middles, then corners and inner points of the ranges in turn; all doubles or ends."""
    lengths = [tuple((lo + hi) / 2 for lo, hi in case.lengths)]
    for k in range(1, count):
        if k % 2:
            lengths.append(tuple(pair[rng.integers(2)] for pair in case.lengths))
        else:
            lengths.append(tuple(lo + (hi - lo) * Fraction(rng.random()) for lo, hi in case.lengths))
    return lengths


class Listing:
    """A result document as the oracle reads it."""

    def __init__(self, case: Case, document: dict[str, Any]) -> None:
        self.case = case
        self.document = document
        self.entries = [Entry(k + 1, s, case) for k, s in enumerate(document["solutions"])]
        self.complete = document["outcome"] == "complete"
        self.covers = document["stop_reason"] == "exhausted" and not document["pending"]
        """Every pose lies in an entry or a region."""

    def missing(self, poses: Sequence[StaticPose]) -> list[str]:
        """Return which static poses are not listed as they should be."""
        if not (self.complete or self.covers):
            return []
        return [complaint for pose in poses if (complaint := self._complaint(pose)) is not None]

    def _complaint(self, pose: StaticPose) -> str | None:
        misfits = [(entry, entry.misfit(pose)) for entry in self.entries]
        held = [entry for entry, misfit in misfits if misfit is None]
        if len(held) > 1 and pose.clear and self.case.exact:
            return f"LISTED TWICE: {pose.describe()} in entries {[e.number for e in held]}"
        if held:
            return self._wrong_stability(held[0], pose)
        if any(self._in_region(region, pose) for region in self.document["undecided"]):
            return None
        wrong = [(entry, why) for entry, why in misfits if why != "elsewhere"]
        if wrong:
            return f"WRONG ENTRY {wrong[0][0].number}: {pose.describe()}: {wrong[0][1]}"
        word = "complete" if self.complete else "incomplete, but exhausted"
        return f"MISSING in a result that is {word}: {pose.describe()}"

    def _in_region(self, region: dict[str, Any], pose: StaticPose) -> bool:
        with mpmath.workdps(DIGITS + 10):
            length = SLOP * max(number(hi) for _, hi in self.case.lengths)
            return inside(region["position_m"], pose.position, length) and inside(
                region["rotation"], pose.rotation, SLOP
            )

    def _wrong_stability(self, entry: Entry, pose: StaticPose) -> str | None:
        listed = entry.document["stability"]
        if "undecided" in (listed, entry.document["existence"]) or pose.stability in ("unclear", listed):
            return None
        if not pose.clear and listed == "stable":
            # Cables that are tight without tension may hold it.
            return None
        return f"STABILITY of entry {entry.number}: listed {listed}, {pose.describe()}"

    def false_entries(self, rng: np.random.Generator) -> list[str]:
        """Return which entries of an exact question hold no pose, or claim more than is true."""
        question, found = question_of(self.case), []
        for entry in self.entries:
            if not entry.proved:
                continue
            pose = self._confirmed(question, entry)
            if pose is None:
                found.append(
                    f"PHANTOM: entry {entry.number} {entry.document['nominal']['position_m']} holds no pose"
                )
                continue
            wrong = self._wrong_stability(entry, pose)
            found += [wrong] if wrong else []
            found += self._false_angles(question, entry, rng) if entry.family is not None else []
        return found

    def _confirmed(self, question: Question, entry: Entry) -> StaticPose | None:
        """Return the pose that Newton reaches from the nominal one and that lies in the entry."""
        for subset in entry.subsets():
            for start in entry.starts(question.coarse, subset):
                batch = Pose(*(a[None] for a in (start.p, start.rotation, np.maximum(start.tensions, 1e-3))))
                solved = solve(question.coarse, batch, np.array(subset))
                for k in range(-1, len(solved.p)):
                    near = start if k < 0 else Pose(solved.p[k], solved.rotation[k], solved.tensions[k])
                    static = judge(question, subset, near)
                    if static is not None and entry.misfit(static) is None:
                        return static
        return None

    def _false_angles(self, question: Question, entry: Entry, rng: np.random.Generator) -> list[str]:
        """Return at which angles of a family other cables are not as listed."""
        family = entry.family
        rotation = np.array(entry.document["rotation"]).mean(axis=-1)
        centre = np.array(entry.document["position_m"]).mean(axis=-1)
        centre = centre + rotation @ np.array([float(c) for c in self.case.centre])
        arms = np.array(
            [[float(b - c) for b, c in zip(row, self.case.centre, strict=True)] for row in self.case.points]
        )
        exits = np.array([[float(x) for x in a] for a in self.case.exits])
        lengths = np.array([float(lo) for lo, _ in self.case.lengths])
        tolerance = 1e-6 * lengths.max()
        count = len(axes_of(family))
        for angles in rng.uniform(-np.pi, np.pi, size=(ANGLES, count)):
            if count:
                p, r = member(family, centre, rotation, tuple(angles))
            else:
                p, r = centre, rotation_of(rng.normal(size=4))
            distances = np.linalg.norm(exits - p - arms @ r.T, axis=1)
            if not count and str(entry.document.get("note") or "").startswith("of all rotations those"):
                # Only these are listed, and the one of the entry is looked at as any pose is.
                continue
            where = place(family, tuple(angles))
            states = list(zip(entry.states, distances, lengths, strict=True))
            if where == "inside" and not self.case.ignore_slack:
                for i, (state, d, length) in enumerate(states):
                    if state == "slack" and d > length + tolerance:
                        return [f"FAMILY of entry {entry.number}: c{i + 1} is not slack at angle {angles}"]
            held = all(state == "taut" or d < length - tolerance for state, d, length in states)
            if where == "outside" and held and self.complete and not self.case.ignore_slack:
                return [f"FAMILY of entry {entry.number}: its pose at angle {angles} is not listed"]
        return []

    def at_choice(
        self, lengths: tuple[Fraction, ...], rng: np.random.Generator, starts: int
    ) -> tuple[list[StaticPose], list[str]]:
        """Return the poses for one choice of lengths, and what is wrong there."""
        case = self.case.at(lengths)
        question = question_of(case)
        hints = [(s, entry.start(question.coarse, s)) for entry in self.entries for s in entry.subsets()]
        poses = find_poses(case, rng, starts, hints)
        label = " at lengths " + ",".join(repr(float(x)) for x in lengths)
        found = [c + label for c in self.missing(poses)]
        for entry in self.entries:
            if not entry.proved or entry.family is not None:
                continue
            held = [p for p in poses if entry.misfit(p) is None]
            if not held:
                followed = self._followed(entry, lengths)
                held = [] if followed is None else [followed]
            if not held:
                found.append(f"NO POSE in entry {entry.number}, existence proved" + label)
            if len(held) > 1 and all(p.clear for p in held) and entry.document["uniqueness"] == "proved":
                found.append(f"TWO POSES in entry {entry.number}, uniqueness proved" + label)
        return poses, found

    def _followed(self, entry: Entry, lengths: tuple[Fraction, ...], steps: int = 12) -> StaticPose | None:
        """Return the entry's pose at some lengths, followed from the middle of the ranges, or None."""
        for subset in entry.subsets():
            taut = np.array(subset)
            pose: Pose | None = None
            for k in range(steps + 1):
                part = Fraction(k, steps)
                mixed = [m + (x - m) * part for x, m in zip(lengths, self._middles(), strict=True)]
                question = question_of(self.case.at(mixed))
                start = entry.start(question.coarse, subset) if pose is None else pose
                solved = solve(
                    question.coarse, Pose(*(a[None] for a in (start.p, start.rotation, start.tensions))), taut
                )
                if not len(solved.p):
                    break
                pose = Pose(solved.p[0], solved.rotation[0], solved.tensions[0])
            else:
                static = None if pose is None else judge(question, subset, pose)
                if static is not None and entry.misfit(static) is None:
                    return static
        return None

    def _middles(self) -> list[Fraction]:
        return [(lo + hi) / 2 for lo, hi in self.case.lengths]
