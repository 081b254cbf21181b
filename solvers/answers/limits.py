"""Tension limits of a question: which poses of an answer keep to them, which do not, and where it is open."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from cdpr_interval.text.count import counted
from solvers.answers.data import Answer, CableState, Outcome, Solution, SubsetReport

Limits = tuple[Fraction, Fraction] | tuple[float, float]
"""N, lo < hi; both are allowed."""


def within_limits(answer: Answer, limits: Limits) -> Answer:
    """Return the answer to the question for poses whose taut cables all have tensions within limits.

    Slack cables have no tension and are not judged. A proved pose is left out where a cable that is proved
    taut has a tension proved outside, for every choice of ranges. Where bounds of a tension hold a limit, the
    entry stays, and the answer is incomplete. Undecided regions stay.

    Guarantee
    ---------
    With outcome COMPLETE no static pose within the limits is missing, and every pose listed is within them.
    """
    kept, outside, unclear = [], 0, []
    for solution in answer.solutions:
        if solution.is_proved and breaking(solution, limits):
            outside += 1
        elif doubtful(solution, limits):
            unclear.append(replace(solution, tension_respected=None))
            kept.append(unclear[-1])
        else:
            kept.append(solution)
    found = replace(answer, solutions=tuple(kept))
    return replace(
        found,
        subsets=tuple(_report(subset, found, unclear) for subset in answer.subsets),
        message=_message(found, outside, len(unclear)),
    )


def breaking(solution: Solution, limits: Limits) -> tuple[int, ...]:
    """Return the cables proved taut whose tension is proved to be outside the limits."""
    states, tensions = solution.cable_states, solution.tensions.tolist()
    return tuple(
        i
        for i, (lo, hi) in enumerate(tensions)
        if states[i] is CableState.TAUT and (hi < limits[0] or lo > limits[1])
    )


def doubtful(solution: Solution, limits: Limits) -> tuple[int, ...]:
    """Return the cables that may be taut and whose tension is not proved to be within the limits."""
    states, tensions = solution.cable_states, solution.tensions.tolist()
    return tuple(
        i
        for i, (lo, hi) in enumerate(tensions)
        if states[i] is not CableState.SLACK and not (limits[0] <= lo and hi <= limits[1])
    )


def limits_text(limits: Limits) -> str:
    """Return limits for people."""
    lo, hi = map(float, limits)
    return f"{lo:.15g}..{hi:.15g} N"


def _report(subset: SubsetReport, answer: Answer, unclear: list[Solution]) -> SubsetReport:
    """Return a subset's line: incomplete where a pose of it may be outside, complete where nothing is."""
    if answer.outcome is Outcome.COMPLETE:
        # What was open of it was a cable of a pose that is outside, whatever that cable does.
        return replace(subset, outcome=Outcome.COMPLETE)
    chosen = set(subset.taut)
    for solution in unclear:
        slack = {i for i, state in enumerate(solution.cable_states) if state is CableState.SLACK}
        if set(solution.taut) <= chosen and not slack & chosen:
            return replace(subset, outcome=Outcome.INCOMPLETE)
    return subset


def _message(answer: Answer, outside: int, unclear: int) -> str:
    """Return what to say of the poses outside and of those that may be."""
    parts = [answer.message] if answer.message else []
    if outside and answer.outcome is Outcome.COMPLETE and not answer.solutions:
        poses = counted(outside, "static pose")
        return f"no static pose within the tension limits; {poses} found outside them"
    if unclear:
        poses = "one pose" if unclear == 1 else f"{unclear} poses"
        parts.append(f"whether {poses} {'is' if unclear == 1 else 'are'} within the tension limits is open")
    if outside:
        parts.append(f"{counted(outside, 'more pose')} found outside the tension limits")
    return "; ".join(parts)
