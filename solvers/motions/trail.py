"""A pose led along a course: what is proved of it, time by time, and where that ends."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise

from cdpr_interval.engine.budget import Budget, Stop
from solvers.motions.course import Course
from solvers.motions.stretch import Mover, Stretch

SHORTEST = Fraction(1, 2**20)
"""Of a way that is tried, over the way between two knots: what is not proved over that is not proved."""
MOST_UNDONE = 8
"""Ways that are taken back between two knots: a bound of the time that takes."""
GROWTH = 2
"""Of ways after one that is proved; they are halved after one that is not."""


@dataclass(frozen=True, eq=False)
class Span:
    """What is proved of a pose between two times."""

    begin: Fraction
    """s, exactly."""
    end: Fraction
    tube: Stretch
    """For all times of the span; its shares mean nothing here."""


@dataclass
class Trail:
    """How far a pose was led, and what is proved of it on the way."""

    reached: Fraction
    """s: until then all is proved."""
    spans: list[Span] = field(default_factory=list)
    """One after the other; of one knot to the next, those with the same cables taut are one."""
    reason: str = ""
    """Why it goes no further, one sentence; empty at the end of the course."""
    stop: Stop | None = None
    """The budget that ended it."""
    proofs: int = 0
    """Ways that were tried."""


def lead(
    mover: Mover,
    course: Course,
    knots: Sequence[Fraction],
    budget: Budget,
    told: Callable[[Trail], None] | None = None,
) -> Trail:
    """Lead a pose from knot to knot, forwards or backwards.

    Parameters
    ----------
    mover : Mover
        Where the course has it at the first knot.
    course : Course
    knots : sequence of Fraction
        Times in s, ascending or descending; the course is straight from one to the next.
    budget : Budget
        Looked at before every proof.
    told : callable, optional
        Called with the trail, at every knot.
    """
    trail = Trail(knots[0])
    for knot, following in pairwise(knots):
        own: list[Span] = []
        _to_knot(mover, course, following - knot, following, budget, trail, own)
        trail.spans += own
        if trail.reason or trail.stop is not None:
            break
        if told is not None:
            told(trail)
    return trail


def _to_knot(
    mover: Mover,
    course: Course,
    way: Fraction,
    knot: Fraction,
    budget: Budget,
    trail: Trail,
    spans: list[Span],
) -> None:
    """Lead the pose to the next knot, in ways as long as can be proved.

    After a long way it may not be known well enough to go on: then that one is taken back, and gone in parts.
    """
    step, undone, last, least = way, 0, None, SHORTEST * abs(way) / Fraction(mover.finest)
    while trail.reached != knot:
        if (stop := budget.stop()) is not None:
            trail.stop = stop
            return
        step = min(step, knot - trail.reached, key=abs)
        before, place, whole = trail.reached, mover.mark(), list(spans)
        moved = mover.go(course.bounds(before + step), budget)
        trail.proofs += 1
        for one in moved.stretches:
            begin, end = (before + step * Fraction(float(x)) for x in (one.first, one.last))
            _add(spans, Span(begin, end, one))
        trail.reached = before + step * Fraction(moved.share)
        if not moved.reason:
            last, step = (before, step, place, whole), GROWTH * step
            continue
        if (stop := budget.stop()) is not None:
            trail.stop = stop
            return
        step /= 2
        if abs(step) >= least:
            continue
        if last is None or last[2] is None or undone == MOST_UNDONE or abs(last[1]) < 2 * least:
            trail.reason = moved.reason
            return
        trail.reached, step, place, spans[:] = last
        mover.back_to(place)
        step, last, undone = step / 2, None, undone + 1


def _add(spans: list[Span], span: Span) -> None:
    """Add a span, joined with the last one where the same cables are taut."""
    if spans and spans[-1].tube.is_like(span.tube):
        last = spans.pop()
        span = Span(last.begin, span.end, last.tube.joined(span.tube))
    spans.append(span)
