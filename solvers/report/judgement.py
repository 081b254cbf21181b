"""What a report says first: one judgement of the solver's answer and the checker's verdict together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from cdpr_interval.text.count import counted
from certificates.verdicts import Verdict
from solvers.answers.data import Outcome, ResultData
from solvers.batch.work import Status
from solvers.proofs.check import REFUSED, Proof


class Kind(StrEnum):
    """The colour: green only where nothing that was looked at is open or refused."""

    GOOD = "good"
    OPEN = "open"
    BAD = "bad"


@dataclass(frozen=True)
class Judgement:
    """The top of a report; nothing else on the page has a colour of its own."""

    kind: Kind
    headline: str
    lines: tuple[str, ...]
    """What it rests on."""

    @property
    def exit_code(self) -> int:
        """What the command that draws it ends with: the codes of `check`."""
        return {Kind.GOOD: 0, Kind.OPEN: 3, Kind.BAD: 5}[self.kind]


def judge(result: ResultData, proof: Proof | None) -> Judgement:
    """Return the judgement of a result: the worse of the solver's answer and the checker's verdict.

    Parameters
    ----------
    result : ResultData
    proof : Proof, optional
        What is known by a certificate; None: there is none.
    """
    is_complete = result.outcome is Outcome.COMPLETE
    lines = [f"Solver: {result.message}."]
    if left := left_open(result):
        lines.append(f"Left open: {left}.")
    if proof is None:
        lines.append("No certificate was given to the independent checker.")
        headline = (
            "Complete" if is_complete else "Incomplete: what is listed as proved is, but there may be more"
        )
        return Judgement(Kind.GOOD if is_complete else Kind.OPEN, headline, tuple(lines))
    lines.append(f"Independent check of the certificate: {proof}")
    if proof.is_refused:
        return Judgement(Kind.BAD, f"The certificate is refused: {proof.name}", tuple(lines))
    if proof.name != Verdict.PROVED:
        solved = "The solver's list is complete, but its" if is_complete else "Incomplete, and the"
        return Judgement(Kind.OPEN, f"{solved} certificate is only: {proof.name}", tuple(lines))
    if not is_complete:
        return Judgement(Kind.OPEN, "Incomplete, though the certificate is proved", tuple(lines))
    return Judgement(Kind.GOOD, "Complete, and proved by an independent check", tuple(lines))


def left_open(result: ResultData) -> str:
    """Return what is undecided or pending, counted; empty when nothing is."""
    cells = sum(one.cells for one in result.undecided)
    proved = [solution for solution in result.solutions if solution.is_proved]
    unproved = len(result.solutions) - len(proved)
    unclear = sum(solution.has_open_cable for solution in proved)
    said = []
    if result.undecided:
        said.append(f"{counted(len(result.undecided), 'undecided region')} ({counted(cells, 'cell')})")
    if result.pending:
        said.append(f"{counted(result.pending, 'cell')} not looked at")
    if unproved:
        said.append(f"{counted(unproved, 'entry', 'entries')} not proved to hold exactly one pose")
    if unclear:
        said.append(f"{counted(unclear, 'pose')} with an undecided cable")
    if doubt := sum(solution.tension_respected is None for solution in proved):
        said.append(f"{counted(doubt, 'pose')} with a tension that may be outside the limits")
    return ", ".join(said)


def judge_batch(
    jobs: Mapping[str, int], undecided: int, verdicts: Mapping[str, int], unchecked: int
) -> Judgement:
    """Return the judgement of a batch: as good as its worst job.

    Parameters
    ----------
    jobs : mapping
        Number of jobs by status.
    undecided : int
        Jobs that left something undecided.
    verdicts : mapping
        Number of certificates by verdict.
    unchecked : int
        Certificates that were not given to the checker.
    """
    counts = Counter({status: count for status, count in jobs.items() if count})
    lines = [", ".join(f"{count} {status}" for status, count in counts.items()) + "."]
    lines.append(f"{counted(undecided, 'job')} left something undecided.")
    lines.append(_certificates(verdicts, unchecked))
    failed = counts[Status.FAILED] + counts[Status.CRASHED]
    refused = sum(verdicts.get(verdict, 0) for verdict in REFUSED)
    if failed or refused:
        words = [f"{counted(failed, 'job')} failed"] if failed else []
        words += [f"{counted(refused, 'certificate')} refused"] if refused else []
        return Judgement(Kind.BAD, ", ".join(words), tuple(lines))
    unsettled = set(counts) - {Status.DONE, Status.NO_POSE}
    if unsettled or undecided or unchecked or set(verdicts) - {Verdict.PROVED}:
        return Judgement(Kind.OPEN, "Not all jobs are complete and proved", tuple(lines))
    checked = ", and proved by an independent check" if verdicts else ""
    return Judgement(Kind.GOOD, f"Every job is complete{checked}", tuple(lines))


def _certificates(verdicts: Mapping[str, int], unchecked: int) -> str:
    count = sum(verdicts.values()) + unchecked
    if not count:
        return "No certificates were asked for."
    said = [f"{number} {verdict}" for verdict, number in verdicts.items()]
    said += [f"{unchecked} not checked (batch check)"] if unchecked else []
    return f"{counted(count, 'certificate')}: {', '.join(said)}."
