"""What a check may end with."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


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
    """By which a sample was drawn."""
    question: tuple[str, ...] = ()
    """Robot, lengths, force and subset, as the file has them."""

    def lines(self) -> list[str]:
        """Return what to print, the verdict first."""
        partial = " (partial)" if self.verdict is Verdict.PROVED and not self.complete else ""
        drawn = "" if self.seed is None else f", drawn with --seed {self.seed}"
        return [
            f"{self.verdict}{partial}: {self.message}".encode("ascii", "backslashreplace").decode(),
            *self.question,
            f"{self.solutions} entries, {self.subsets} subsets, {self.leaves} cells",
            f"{self.checked} cells checked in {self.parts} parts, {self.seconds:.2f} s{drawn}",
            f"{self.pending} pending, {self.undecided} undecided",
        ]
