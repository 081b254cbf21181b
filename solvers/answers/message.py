"""The sentence of a result: what was found, counted, and whether it is all; and its counts read again."""

from __future__ import annotations

import re
from collections.abc import Sequence

from cdpr_interval.text.count import counted
from solvers.answers.data import Answer, Outcome, Solution, StopReason

_STOPPED = {
    StopReason.TIME_LIMIT: "stopped at the time limit",
    StopReason.CELL_LIMIT: "stopped at the cell limit",
    StopReason.INTERRUPTED: "interrupted",
    StopReason.EXHAUSTED: "finished",
}
_ALL = re.compile(r"(\d+) static poses?, proved to be all(?:;|$)")
_SOME = re.compile(
    rf"(?:{'|'.join(_STOPPED.values())}): (\d+) static poses? proved"
    r"(?:, (?:\d+ of them )?with an undecided cable)?(?:(?:; besides|), (\d+) open entr(?:y|ies))?(?:[,;]|$)"
)


def message_of(answer: Answer) -> str:
    """Return one sentence that says what was found and whether it is everything."""
    proved = sum(solution.is_proved for solution in answer.solutions)
    poses = counted(proved, "static pose")
    if answer.outcome is Outcome.COMPLETE:
        if proved == 0:
            return answer.message or "there is no static pose for these lengths"
        text = f"{poses}, proved to be all"
    else:
        text = f"{_STOPPED[answer.stop_reason]}: {poses} proved{_with_open_cables(answer, proved)}"
        if left := _left_open(answer):
            text += f"; besides, {', '.join(left)}"
    return f"{text}; {answer.message}" if answer.message else text


def _with_open_cables(answer: Answer, proved: int) -> str:
    """Return how many of the proved poses have a cable of which it is open whether it is taut."""
    just = sum(solution.is_proved and solution.has_open_cable for solution in answer.solutions)
    of_them = f"{just} of them " if proved > 1 else ""
    return f", {of_them}with an undecided cable" if just else ""


def _left_open(answer: Answer) -> list[str]:
    """Return what is no proved pose, counted: none of it may be added to those."""
    unproved = sum(not solution.is_proved for solution in answer.solutions)
    left = [f"{counted(unproved, 'open entry', 'open entries')}"] if unproved else []
    if answer.undecided:
        left.append(f"{counted(len(answer.undecided), 'region')} undecided")
    if answer.pending:
        left.append(f"{counted(answer.pending, 'cell')} not looked at")
    return left


def miscounted(message: str, solutions: Sequence[Solution], outcome: Outcome) -> str:
    """Return what is wrong with the counts a message gives of the entries; empty when nothing is.

    A message of another wording counts nothing.
    """
    proved = sum(solution.is_proved for solution in solutions)
    if match := _ALL.match(message):
        if outcome is not Outcome.COMPLETE:
            return "says 'proved to be all' although the outcome is incomplete"
        said, unproved = int(match[1]), 0
    elif match := _SOME.match(message):
        if outcome is Outcome.COMPLETE:
            return "says that something is open although the outcome is complete"
        said, unproved = int(match[1]), int(match[2] or 0)
    else:
        return ""
    if said != proved:
        return f"counts {said} proved poses, the entries {proved}"
    if unproved != len(solutions) - proved:
        return f"counts {unproved} open entries, there are {len(solutions) - proved}"
    return ""
