"""What a check may end with, and why it leaves something open."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any


class Malformed(Exception):
    """The file is not a certificate: a rule of the format is broken."""


class NotProved(Exception):
    """The file is a certificate, but something it claims does not follow."""


class Verdict(StrEnum):
    """The outcome in one word."""

    PROVED = "PROVED"
    NOT_PROVED = "NOT PROVED"
    MALFORMED = "MALFORMED"
    SAMPLED = "SAMPLED"
    """What was checked follows, but not all was checked."""
    OUT_OF_TIME = "OUT OF TIME"


class Conclusion(StrEnum):
    """A verdict as it is printed, with an exit code; PROVED with something left open is its own thing."""

    PROVED = "PROVED"
    PARTIAL = "PROVED (partial)"
    NOT_PROVED = "NOT PROVED"
    MALFORMED = "MALFORMED"
    SAMPLED = "SAMPLED"
    OUT_OF_TIME = "OUT OF TIME"

    @classmethod
    def of(cls, verdict: Verdict, complete: bool) -> Conclusion:
        """Return the conclusion of a check."""
        return cls.PARTIAL if verdict is Verdict.PROVED and not complete else cls(verdict.value)

    @property
    def exit_code(self) -> int:
        """What a command that ends with it returns."""
        return EXIT_CODES[self]

    @property
    def remark(self) -> str:
        """One line for standard error beside an exit code that is not 0."""
        return f"{self}: {REMARKS[self]} (exit code {self.exit_code})"


EXIT_CODES = {
    Conclusion.PROVED: 0,
    Conclusion.MALFORMED: 2,
    Conclusion.PARTIAL: 3,
    Conclusion.SAMPLED: 3,
    Conclusion.OUT_OF_TIME: 3,
    Conclusion.NOT_PROVED: 5,
}
REMARKS = {
    Conclusion.PROVED: "nothing is left open",
    Conclusion.PARTIAL: "what is claimed is proved, but not that there is no other pose",
    Conclusion.NOT_PROVED: "something that is claimed does not follow",
    Conclusion.MALFORMED: "this is no certificate",
    Conclusion.SAMPLED: "some cells were not checked",
    Conclusion.OUT_OF_TIME: "not everything was checked",
}


def counted(number: int, one: str, several: str = "") -> str:
    """Return a number with its noun."""
    return f"{number} {one if number == 1 else several or one + 's'}"


@dataclass(frozen=True)
class Report:
    """The outcome of a check."""

    verdict: Verdict
    message: str
    complete: bool
    """With PROVED: nothing is left open, so there is no other pose."""
    solutions: int
    """That are listed: poses or families, where nothing is undecided."""
    subsets: int
    leaves: int
    """Cells of all search trees."""
    checked: int
    """Those of them that were checked."""
    parts: int
    """Into which these were bisected."""
    pending: int
    """Subsets and cells of which nothing is claimed since they were not looked at."""
    undecided: int
    """Cells that the search could not decide."""
    seconds: float
    seed: int | None = None
    """By which a sample was drawn, and the cells that were checked in both arithmetics."""
    question: tuple[str, ...] = ()
    """Robot, lengths, force and subset, as the file has them."""
    examined: int = 0
    """Subsets that were checked but for their cells."""
    chosen: int | None = None
    """Cells to be checked of all, where a sample is."""
    reasons: tuple[str, ...] = ()
    """Why something is left open, as the file has it, counted."""

    twice: int = 0
    """Cells that were checked in both arithmetics."""

    @property
    def wanted(self) -> int:
        """How many cells are to be checked, as far as their subsets are examined."""
        return self.leaves if self.chosen is None else min(self.chosen, self.leaves)

    @property
    def extent(self) -> str:
        """How far the check is."""
        if not self.subsets:
            return "the file is not read"
        if self.examined < self.subsets:
            return f"{self.examined} of {counted(self.subsets, 'subset')} examined, no cell checked"
        return f"{self.checked} of {counted(self.wanted, 'cell')} checked"

    @property
    def conclusion(self) -> Conclusion:
        """The verdict, and whether it leaves something open, in one word."""
        return Conclusion.of(self.verdict, self.complete)

    def lines(self) -> list[str]:
        """Return what to print, the verdict first."""
        drawn = f", {self.twice} of them twice, drawn with --seed {self.seed}" if self.twice else ""
        return [
            f"{self.conclusion}: {self.message}".encode("ascii", "backslashreplace").decode(),
            *self.question,
            f"{counted(self.solutions, 'entry', 'entries')}, {counted(self.subsets, 'subset')},"
            f" {counted(self.leaves, 'cell')}",
            f"{counted(self.checked, 'cell')} checked in {counted(self.parts, 'part')},"
            f" {self.seconds:.2f} s{drawn}",
            f"{self.pending} pending, {self.undecided} undecided",
            *(line.encode("ascii", "backslashreplace").decode() for line in self.reasons),
        ]


MOST_KINDS = 5
"""Of reasons that are told."""
LONGEST = 100
"""Characters of a reason: it is whatever the writer of the file has put there."""


def reasons(
    entries: Sequence[dict[str, Any]], left_out: Sequence[str], pending: int, undecided: int
) -> list[str]:
    """Return a line for each kind of reason, the most frequent first, at most `MOST_KINDS` of them.

    ``entries`` are those of subsets, ``left_out`` the reasons of poses; ``pending`` counts subsets and cells
    of which nothing is claimed, ``undecided`` cells. Nobody checks what the file says here.
    """
    subsets = [entry["pending"] for entry in entries if "pending" in entry]
    found = Counter(("pose", "not certified", reason) for reason in left_out)
    found.update(("subset", "pending", reason) for reason in subsets)
    found["cell", "pending", "the search has not come to it"] += pending - len(subsets)
    found["cell", "undecided", "too small to be cut once more"] += undecided
    return list(lines(+found))


def lines(found: Counter[tuple[str, str, str]]) -> Iterator[str]:
    """Yield a line for each kind."""
    for (what, state, reason), number in found.most_common(MOST_KINDS):
        short = reason if len(reason) <= LONGEST else reason[: LONGEST - 3] + "..."
        yield f"{counted(number, what)} {state}: {short}"
    if (more := len(found) - MOST_KINDS) > 0:
        yield f"and {counted(more, 'other reason')}"
